//! Theorems of a kd-node's bytes (KD-1).

use super::PLANES;
use crate::draw::{self, BYTES, WORDS};
use crate::{check_eq, cover, theorems};
use saarcor_model::host::{Axis, NODE_BYTES, NodeRecord};
use saarcor_model::vm::HostAddr;

theorems! {
    /// Any 8 bytes are one node, and the node has those bytes.
    #["KD-1", unwind 9, covers ["a leaf", "an inner node", "a split plane that is NaN"]]
    fn node_bytes_are_those_of_the_node(s) {
        let first = s.value("first word", 0..=u32::MAX, &PLANES);
        let second = s.value("second word", 0..=u32::MAX, &draw::EDGES);
        let ([a, b, c, d], [e, f, g, h]) = (first.to_le_bytes(), second.to_le_bytes());
        let bytes: [u8; NODE_BYTES as usize] = [a, b, c, d, e, f, g, h];
        let node = NodeRecord::decode(bytes);
        cover!(s, "a leaf", matches!(node, NodeRecord::Leaf { .. }));
        cover!(s, "an inner node", matches!(node, NodeRecord::Inner { .. }));
        cover!(s, "a split plane that is NaN", matches!(node, NodeRecord::Inner { split, .. } if split.is_nan()));
        check_eq!(node.encode(), bytes, "{node:?}");
    }

    /// A node is read as it was written: axis, split plane and children, or list and count.
    #["KD-1", unwind 5, covers ["x", "y", "z", "a leaf"]]
    fn node_is_read_as_written(s) {
        let kind = s.value("kind (x, y, z, leaf)", 0..=3, &BYTES[..4]);
        let (first, second) = (s.value("split plane or count", 0..=u32::MAX, &PLANES), s.value("address / 4", 0..=u32::MAX >> 2, &WORDS));
        let addr = HostAddr(second << 2);
        cover!(s, "x", kind == 0);
        cover!(s, "y", kind == 1);
        cover!(s, "z", kind == 2);
        cover!(s, "a leaf", kind == 3);
        if kind == 3 {
            let leaf = NodeRecord::Leaf { list: addr, count: first };
            check_eq!(NodeRecord::decode(leaf.encode()), leaf, "a leaf");
        } else {
            let (axis, split) = (Axis::ALL[usize::from(kind)], f32::from_bits(first));
            let node = NodeRecord::Inner { axis, split, below: addr };
            // Bits instead of the plane itself: NaN is no equal of NaN.
            let read = match NodeRecord::decode(node.encode()) {
                NodeRecord::Inner { axis, split, below } => Some((axis, split.to_bits(), below)),
                NodeRecord::Leaf { .. } => None,
            };
            check_eq!(read, Some((axis, first, addr)), "{node:?}");
        }
    }
}
