//! Theorems of the entries of a leaf's list (HI-3).

use crate::draw::WORDS;
use crate::{check_eq, cover, theorems};
use saarcor_model::host::{LIST_ENTRY_BYTES, ListEntry};
use saarcor_model::vm::HostAddr;

theorems! {
    /// An entry of a list is read as it was written, and any 4 bytes are one entry.
    #["HI-3", unwind 5, covers ["tagged", "not tagged"]]
    fn list_entry_is_read_as_written(s) {
        let (triangle, tag) = (s.value("address / 4", 0..=u32::MAX >> 2, &WORDS) << 2, s.value("tag", 0..=3, &WORDS[..4]));
        cover!(s, "tagged", tag > 0);
        cover!(s, "not tagged", tag == 0);
        let entry = ListEntry { triangle: HostAddr(triangle), tag };
        check_eq!(ListEntry::decode(entry.encode()), entry, "address and tag");
        let bytes: [u8; LIST_ENTRY_BYTES as usize] = (triangle | tag).to_le_bytes();
        check_eq!(ListEntry::decode(bytes).encode(), bytes, "the bytes of {entry:?}");
    }
}
