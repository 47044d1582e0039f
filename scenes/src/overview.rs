//! The camera of a scene that comes without a camera path.

use glam::DVec3;
use saarcor_model::host::{Camera, Triangle};

/// A camera that sees all of the triangles, in any picture that is at least as wide as high.
///
/// It looks along the diagonal (−1, −1, −1) at the centre of the bounding box, y up, from so far
/// that the sphere around the box fits the picture. `None` where there is no such place: without
/// triangles, or where it would lie outside of the range of f32.
#[must_use]
pub fn overview(triangles: &[Triangle]) -> Option<Camera> {
    const FOV_Y_DEG: f64 = 60.0;
    /// Space left around the sphere, so that its rim is not cut by rounding.
    const MARGIN: f64 = 1.05;

    let mut corners = triangles.iter().flat_map(|triangle| triangle.corners);
    let first = corners.next()?;
    let (least, most) =
        corners.fold((first, first), |(least, most), corner| (least.min(corner), most.max(corner)));
    let (least, most) = (least.as_dvec3(), most.as_dvec3());

    let centre = (least + most) / 2.0;
    let radius = match (most - least).length() / 2.0 {
        // All corners in one point: any distance will do.
        0.0 => 1.0,
        radius => radius,
    };
    let distance = MARGIN * radius / libm::sin(FOV_Y_DEG.to_radians() / 2.0);
    let dir = DVec3::NEG_ONE.normalize();
    let up = DVec3::new(-1.0, 2.0, -1.0).normalize();
    let eye = (centre - dir * distance).as_vec3();
    eye.is_finite().then_some(Camera {
        eye,
        dir: dir.as_vec3(),
        up: up.as_vec3(),
        fov_y_deg: FOV_Y_DEG as f32,
    })
}
