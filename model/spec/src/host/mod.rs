//! What lies in host memory.

mod layout;
mod scene;
mod texture;
mod tree;

pub use layout::*;
pub use scene::*;
pub use texture::*;
pub use tree::*;
