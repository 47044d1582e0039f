//! The units of a ray tracing pipeline (§2). In reading order:
//!
//! 1. `ray`: rays, packets of them, and what they hit; `camera`: where rays come from (RG-1 to RG-3);
//! 2. `interval`, `traversal`: the way through the kd-tree (KD-3, KD-4);
//! 3. `intersection`: rays against a triangle, one file for each test (IS-1 to IS-5);
//! 4. `texel`, `shading`: what a surface looks like where a ray hits it (SH-1 to SH-6);
//! 5. `pipeline`: all of them, and the rays that follow one another (RG-4 to RG-6).

mod camera;
mod intersection;
mod interval;
mod pipeline;
mod ray;
mod shading;
mod texel;
mod traversal;

pub use camera::{Frame, SURFACE_OFFSET, ray_from_surface};
pub use intersection::{
    Candidate, EdgeTriangle, ExactHit, Intersection, IntersectionUnit, Number, PluckerTriangle,
    ProjectedTriangle, ShearedRay, StoredTriangle, TriangleTest, Triple, WatertightTriangle, intersect,
    keep_nearest,
};
pub use interval::{Intervals, UNDERFLOW, WIDENING, is_downwards, max, min, reciprocal, visit, widen};
pub use pipeline::{LEAST_PART, Pipeline, RayCounts, shadow_ray};
pub use ray::{Hits, Packet, Query, Ray};
pub use shading::{AMBIENT, BACKGROUND, Cones, Surface, surfaces};
pub use texel::{sample_colour, sample_slope};
pub use traversal::{Children, Stack, Traversal};
