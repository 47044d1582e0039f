//! Camera paths: a smooth walk through way points.

use glam::Vec3;
use saarcor_model::host::Camera;

/// Where the camera is at some frame, and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayPoint {
    /// The frame; way points stand in ascending order.
    pub frame: f32,
    /// The eye in world space.
    pub eye: Vec3,
    /// The point in the middle of the picture, apart from `eye`.
    pub target: Vec3,
}

/// Spreads pairs of eye and target over `frames` frames, the eye at constant speed.
///
/// A pair that turns on the spot counts by the way of its target at a quarter of the speed, so
/// that the camera turns and does not jump.
#[must_use]
pub fn evenly(stops: &[(Vec3, Vec3)], frames: u32) -> Vec<WayPoint> {
    let mut way = 0.0;
    let ways: Vec<f32> = (0..stops.len())
        .map(|i| {
            let (eye, target) = stops[i];
            let (last_eye, last_target) = stops[i.saturating_sub(1)];
            way += eye.distance(last_eye).max(0.25 * target.distance(last_target));
            way
        })
        .collect();
    let scale = frames.saturating_sub(1) as f32 / way.max(f32::MIN_POSITIVE);
    stops.iter().zip(ways).map(|(&(eye, target), way)| WayPoint { frame: way * scale, eye, target }).collect()
}

/// The cameras of frames 0 to `frames`, y up, on a Catmull-Rom spline through the way points.
/// Before the first and after the last way point the camera rests. No way point, no camera.
#[must_use]
pub fn cameras(way_points: &[WayPoint], frames: u32, fov_y_deg: f32) -> Vec<Camera> {
    if way_points.is_empty() {
        return Vec::new();
    }
    (0..frames)
        .map(|frame| {
            let (eye, target) = at(way_points, frame as f32);
            let dir = (target - eye).normalize_or(Vec3::NEG_Z);
            let right = dir.cross(Vec3::Y).normalize_or(Vec3::X);
            Camera { eye, dir, up: right.cross(dir), fov_y_deg }
        })
        .collect()
}

/// Eye and target at a frame: cubic Hermite pieces whose tangents are the differences of the
/// neighbours (Catmull and Rom 1974), for way points at uneven frames.
fn at(way_points: &[WayPoint], frame: f32) -> (Vec3, Vec3) {
    let last = way_points.len() - 1;
    let next = way_points.partition_point(|w| w.frame <= frame);
    if next == 0 || next > last {
        let rest = way_points[next.min(last)];
        return (rest.eye, rest.target);
    }
    let (from, to) = (next - 1, next);
    let span = way_points[to].frame - way_points[from].frame;
    let s = (frame - way_points[from].frame) / span;
    let (s2, s3) = (s * s, s * s * s);
    let weights = [2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, 3.0 * s2 - 2.0 * s3, s3 - s2];
    let spline = |value: fn(&WayPoint) -> Vec3| {
        let tangent = |i: usize| {
            let (a, b) = (&way_points[i.saturating_sub(1)], &way_points[(i + 1).min(last)]);
            (value(b) - value(a)) * (span / (b.frame - a.frame))
        };
        value(&way_points[from]) * weights[0]
            + tangent(from) * weights[1]
            + value(&way_points[to]) * weights[2]
            + tangent(to) * weights[3]
    };
    (spline(|w| w.eye), spline(|w| w.target))
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    fn bend() -> Vec<WayPoint> {
        let stop = |frame: f32, x: f32, z: f32| WayPoint {
            frame,
            eye: vec3(x, 1.0, z),
            target: vec3(x + 1.0, 2.0, z),
        };
        vec![stop(2.0, 0.0, 0.0), stop(6.0, 4.0, 0.0), stop(16.0, 4.0, 5.0)]
    }

    #[test]
    fn the_camera_passes_each_way_point_at_its_frame() {
        let path = cameras(&bend(), 20, 60.0);
        for stop in bend() {
            let camera = path[stop.frame as usize];
            assert!(camera.eye.abs_diff_eq(stop.eye, 1e-6), "{camera:?}");
            assert!(camera.dir.abs_diff_eq((stop.target - stop.eye).normalize(), 1e-6), "{camera:?}");
        }
        assert_eq!(path[0], path[2]);
        assert_eq!(path[16], path[19]);
    }

    #[test]
    fn even_way_points_keep_a_constant_speed() {
        let stops = [(0.0, 0.0), (3.0, 0.0), (4.0, 0.0), (10.0, 0.0)]
            .map(|(x, z)| (vec3(x, 0.0, z), vec3(x + 1.0, 0.0, z)));
        let path = cameras(&evenly(&stops, 11), 11, 60.0);
        for (frame, camera) in path.iter().enumerate() {
            approx::assert_abs_diff_eq!(camera.eye.x, frame as f32, epsilon = 1e-4);
        }
    }

    #[test]
    fn no_way_point_gives_no_camera() {
        assert!(cameras(&[], 5, 60.0).is_empty());
    }
}
