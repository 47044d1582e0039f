//! Files as bytes in memory, without reading them: a page is read when it is first touched.

// The one place of this crate that needs it. A mapping shows what becomes of its file, which the compiler cannot see. The
// files that are mapped here are those of kept worlds (`kept`): each is written whole under another name, then gets its own,
// and is only read from there on; where it leaves, its name is removed, and its content stays while it is mapped. To read it
// instead takes time and memory for all of it, whatever is touched: 1 s and 1 GB for the Cruiser, which is mapped in 0.03 s
// (measured on two cores, at work with other things).
#![allow(unsafe_code, reason = "no other call maps a file")]

use bytes::Bytes;
use memmap2::Mmap;
use std::fs::File;
use std::io::{self, Read as _};

/// All bytes of a file, which nobody may change any more: mapped, or where that cannot be, read.
///
/// # Errors
/// If it can be neither.
pub(super) fn bytes_of(mut file: File) -> io::Result<Bytes> {
    // SAFETY: the file is not changed while it is mapped, as stands above.
    match unsafe { Mmap::map(&file) } {
        Ok(map) => Ok(Bytes::from_owner(map)),
        Err(_) => {
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes)?;
            Ok(bytes.into())
        }
    }
}
