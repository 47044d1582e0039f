//! kd-nodes in host memory (KD-1).

use super::list::LIST_ENTRY_BYTES;
use super::tree::{Axis, Node};
use crate::vm::HostAddr;

/// Bytes of a kd-node (Assumed, after Wald et al. 2001).
pub const NODE_BYTES: u32 = 8;

/// A kd-node as the chip reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeRecord {
    /// Space is cut at `split` along `axis`.
    Inner {
        /// The axis that the split plane is perpendicular to.
        axis: Axis,
        /// Coordinate of the split plane.
        split: f32,
        /// Address of the child below the plane; the one above follows it.
        below: HostAddr,
    },
    /// A leaf with `count` triangle addresses from `list` on.
    Leaf {
        /// Address of the list.
        list: HostAddr,
        /// Entries of the list.
        count: u32,
    },
}

impl NodeRecord {
    /// A node of the tree, in a host memory where nodes and lists begin there (HI-2).
    pub fn new(node: &Node, nodes: HostAddr, lists: HostAddr) -> Self {
        match *node {
            Node::Inner { axis, split, children } => {
                Self::Inner { axis, split, below: nodes.offset(children * NODE_BYTES) }
            }
            Node::Leaf { first, count } => Self::Leaf { list: lists.offset(first * LIST_ENTRY_BYTES), count },
        }
    }

    /// Reads a node: the split plane or the count, then an address whose two lowest bits are the
    /// axis, or 3 for a leaf (KD-1, Assumed).
    pub fn decode(bytes: [u8; NODE_BYTES as usize]) -> Self {
        let [a, b, c, d, e, f, g, h] = bytes;
        let (first, second) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
        let addr = HostAddr(second & !3);
        let split = f32::from_bits(first);
        match second & 3 {
            0 => Self::Inner { axis: Axis::X, split, below: addr },
            1 => Self::Inner { axis: Axis::Y, split, below: addr },
            2 => Self::Inner { axis: Axis::Z, split, below: addr },
            _ => Self::Leaf { list: addr, count: first },
        }
    }

    /// The bytes that [`NodeRecord::decode`] reads. Addresses are multiples of 4.
    pub fn encode(self) -> [u8; NODE_BYTES as usize] {
        let (first, addr, tag) = match self {
            Self::Inner { axis, split, below } => (split.to_bits(), below.0, axis as u32),
            Self::Leaf { list, count } => (count, list.0, 3),
        };
        let ([a, b, c, d], [e, f, g, h]) = (first.to_le_bytes(), (addr | tag).to_le_bytes());
        [a, b, c, d, e, f, g, h]
    }
}
