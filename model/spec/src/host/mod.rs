//! What lies in host memory. In reading order:
//!
//! 1. `scene`: what the application describes; `features`: what of the chip that needs;
//! 2. `tree`: the kd-tree that the driver is given, and which ones the chip may be given (KD-2);
//! 3. `node`, `list`, `triangle`, `records`, `texture`: each kind of item as bytes (KD-1, HI-3, HI-6);
//! 4. `layout`: the driver, which gives all of them addresses (HI-1 to HI-5).

mod features;
mod layout;
mod list;
mod node;
mod records;
mod scene;
mod texture;
mod tree;
mod triangle;

pub use features::{Features, features};
pub use layout::{HostImage, LayoutError, REGION_ALIGNMENT, Registers, region_starts};
pub use list::{LIST_ENTRY_BYTES, ListEntry};
pub use node::{NODE_BYTES, NodeRecord};
pub use records::{MaterialRecord, ShadingRecord};
pub use scene::{Camera, Light, Material, Scene, TexelFormat, Texture, Triangle};
pub use texture::{TEXTURE_ALIGNMENT, TextureRecord};
pub use tree::{Aabb, Axis, KdTree, KdTreeError, MAX_DEPTH, Node, check_nodes};
pub use triangle::{Edges, Kernel, Projection, TRIANGLE_BYTES, TriangleRecord};
