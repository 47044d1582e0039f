//! Theorems of the addresses in host memory: regions, and the items in them (HI-1, HI-2).

use crate::draw::WORDS;
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::host::{
    Aabb, Edges, Features, Kernel, LIST_ENTRY_BYTES, NODE_BYTES, Node, NodeRecord, REGION_ALIGNMENT,
    Registers, TRIANGLE_BYTES, region_starts,
};
use saarcor_model::vm::{Bytes, HostAddr};

/// Bytes of regions: none, around a page, and what takes half of the address space, or all of it.
static SIZES: [u64; 9] = [0, 1, 4095, 4096, 4097, 1 << 31, (1 << 32) - 4096, (1 << 32) - 4095, (1 << 32) + 1];

/// Numbers of items: the first ones, and around 2^16, 2^20 and the most that the address space holds.
static ITEMS: [u32; 18] = [
    0,
    1,
    2,
    113,
    0xfffe,
    0xffff,
    0x1_0000,
    0x1_0001,
    0xf_ffff,
    0x10_0000,
    (u32::MAX / 36) - 1,
    u32::MAX / 36,
    1 << 28,
    (1 << 29) - 3,
    (1 << 29) - 2,
    (1 << 29) - 1,
    (1 << 30) - 2,
    (1 << 30) - 1,
];

/// The page at which a region begins. Small scope: the first pages, and around every power of two.
static PAGES: [u32; 12] = [0, 1, 2, 15, 16, 17, 0xff, 0x100, 0x7_ffff, 0x8_0000, 0xf_fffe, 0xf_ffff];

/// Where a region begins, and an item of so many bytes that lies in it and in the address space.
fn item<S: Source>(s: &mut S, bytes: u32) -> Result<(HostAddr, u32), Stop> {
    let start = s.value("page", 0..=0xf_ffff, &PAGES) * REGION_ALIGNMENT;
    let number = s.value("number of the item", 0..=(1 << 30) - 1, &ITEMS);
    assume!(u64::from(start) + u64::from(bytes) * (u64::from(number) + 1) <= 1 << 32);
    Ok((HostAddr(start), number))
}

/// The chip's registers, of which only the address of the first triangle matters.
fn registers(triangles: HostAddr) -> Registers {
    Registers {
        root: HostAddr(0),
        bounds: Aabb::EMPTY,
        kernel: Kernel::MollerTrumbore,
        edges: Edges::Shared,
        triangles,
        shading: HostAddr(0),
        features: Features::default(),
        lights: Vec::new(),
    }
}

theorems! {
    /// Each region begins at the first multiple of 4096 behind the region before it, the first at address
    /// 0; a scene is refused exactly if its last region and the padding behind it leave the 4 GiB that an
    /// address of 32 bits reaches.
    #["HI-2", unwind 7, covers ["accepted", "refused", "an empty region", "to the last byte"]]
    fn regions_lie_one_behind_the_other(s) {
        let mut bytes = [Bytes(0); 5];
        let (mut end, mut empty) = (0, false);
        for region in 0..5 {
            bytes[region] = Bytes(s.value("bytes of a region", 0..=1 << 40, &SIZES));
            end += (bytes[region].0 + 4095) & !4095;
            empty |= bytes[region].0 == 0;
        }
        let result = region_starts(bytes);
        cover!(s, "accepted", result.is_ok());
        cover!(s, "refused", result.is_err());
        cover!(s, "an empty region", empty);
        cover!(s, "to the last byte", end == 1 << 32);
        check_eq!(result.is_ok(), end <= 1 << 32, "regions of {bytes:?}");
        if let Ok(starts) = result {
            check_eq!((starts[0], starts[5]), (0, end), "regions of {bytes:?}");
            for region in 0..5 {
                let (start, behind) = (starts[region], starts[region] + bytes[region].0);
                check_eq!(start & 4095, 0, "region {region} of {bytes:?}");
                check!(behind <= starts[region + 1] && starts[region + 1] < behind + 4096, "region {region} of {bytes:?}: {starts:?}");
            }
        }
    }

    /// The node of number n lies 8 n bytes behind the first node: there an inner node says that its child
    /// below is, whatever n.
    #["KD-1", unwind 4, covers ["the first node", "the last node of the address space", "bit 20 of the number"]]
    fn nodes_lie_by_their_numbers(s) {
        let (nodes, number) = item(s, NODE_BYTES)?;
        cover!(s, "the first node", number == 0);
        cover!(s, "the last node of the address space", u64::from(nodes.0) + 8 * u64::from(number) == (1 << 32) - 8);
        cover!(s, "bit 20 of the number", number & 1 << 20 != 0);
        let node = Node::Inner { axis: saarcor_model::host::Axis::Y, split: 1.0, children: number };
        let NodeRecord::Inner { below, .. } = NodeRecord::new(&node, nodes, HostAddr(4096)) else {
            check!(false, "{node:?} becomes a leaf");
            return Err(Stop::Vacuous);
        };
        check_eq!(u64::from(below.0), u64::from(nodes.0) + 8 * u64::from(number), "node {number} from {nodes:?} on");
    }

    /// The list of a leaf that begins with entry n of all lists lies 4 n bytes behind the first entry,
    /// whatever n, and is as long as the leaf says.
    #["HI-3", unwind 4, covers ["the first entry", "the last entry of the address space", "a list without entries"]]
    fn lists_lie_by_their_first_entries(s) {
        let (lists, first) = item(s, LIST_ENTRY_BYTES)?;
        let count = s.value("entries", 0..=u32::MAX, &ITEMS);
        cover!(s, "the first entry", first == 0);
        cover!(s, "the last entry of the address space", u64::from(lists.0) + 4 * u64::from(first) == (1 << 32) - 4);
        cover!(s, "a list without entries", count == 0);
        let record = NodeRecord::new(&Node::Leaf { first, count }, HostAddr(0), lists);
        let NodeRecord::Leaf { list, count: found } = record else {
            check!(false, "a leaf becomes {record:?}");
            return Err(Stop::Vacuous);
        };
        check_eq!(u64::from(list.0), u64::from(lists.0) + 4 * u64::from(first), "entry {first} from {lists:?} on");
        check_eq!(found, count, "entries of the list");
    }

    /// A triangle's number is found from the address of any of its 36 bytes, wherever the triangles begin,
    /// up to the last one that the address space holds.
    #["HI-3", unwind 6, covers ["the first triangle", "the last triangle", "bit 16 of the number", "its last byte"]]
    fn triangles_are_numbered_by_their_addresses(s) {
        let (triangles, number) = item(s, TRIANGLE_BYTES)?;
        let byte = s.value("byte of the triangle", 0..=35, &WORDS[..36]);
        cover!(s, "the first triangle", number == 0);
        cover!(s, "the last triangle", u64::from(triangles.0) + 36 * (u64::from(number) + 2) > 1 << 32);
        cover!(s, "bit 16 of the number", number & 1 << 16 != 0);
        cover!(s, "its last byte", byte == 35);
        let addr = HostAddr(triangles.0 + 36 * number + byte);
        check_eq!(registers(triangles).triangle_index(addr), number, "{addr:?}, triangles from {triangles:?} on");
    }
}
