//! Theorems of rays: the traversal of the kd-tree.

pub mod traversal;
