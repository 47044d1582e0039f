//! The units of a ray tracing pipeline (§2).

mod camera;
mod intersection;
mod pipeline;
mod ray;
mod shading;
mod traversal;

pub use camera::*;
pub use intersection::*;
pub use pipeline::*;
pub use ray::*;
pub use shading::*;
pub use traversal::*;
