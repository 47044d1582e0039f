//! The closest hit by trying every triangle: no tree, no culling.

/// The closest hit of a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosestHit<T> {
    /// The least distance, in whatever the triangle test measures it.
    pub t: T,
    /// Indices of all triangles that are hit at exactly that distance, in ascending order: any
    /// of them is a right answer.
    pub triangles: Vec<u32>,
}

/// Tries every triangle with `test`, which gives the distance of a hit, and returns the least
/// distance with the triangles that have it; `None` where nothing is hit.
///
/// The test decides what a hit is: it holds the ray, its range and the intersection kernel. A
/// triangle is whatever the kernel tests.
/// A distance that does not compare to itself (NaN) is no hit.
///
/// ```
/// use saarcor_model::host::Triangle;
/// use saarcor_oracles::search::closest_hit;
/// let at = |z| Triangle { corners: [glam::Vec3::Z * z; 3], material: 0 };
/// let hit = closest_hit(&[at(3.0), at(2.0), at(2.0)], |triangle| Some(triangle.corners[0].z));
/// assert_eq!(hit.map(|hit| (hit.t, hit.triangles)), Some((2.0, vec![1, 2])));
/// ```
pub fn closest_hit<Tri, T: PartialOrd + Copy>(
    triangles: &[Tri],
    mut test: impl FnMut(&Tri) -> Option<T>,
) -> Option<ClosestHit<T>> {
    let mut closest: Option<ClosestHit<T>> = None;
    for (index, triangle) in (0..).zip(triangles) {
        let Some(t) = test(triangle) else { continue };
        match &mut closest {
            Some(hit) if t > hit.t => {}
            Some(hit) if t == hit.t => hit.triangles.push(index),
            // NaN: neither greater, nor equal, nor less.
            _ if t.partial_cmp(&t).is_none() => {}
            _ => closest = Some(ClosestHit { t, triangles: vec![index] }),
        }
    }
    closest
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use saarcor_model::host::Triangle;

    /// A triangle for each distance, distinguished by its first corner.
    fn triangles(distances: &[f32]) -> Vec<Triangle> {
        distances.iter().map(|&t| Triangle { corners: [Vec3::X * t; 3], material: 0 }).collect()
    }

    fn search(distances: &[f32]) -> Option<(f32, Vec<u32>)> {
        let hit = closest_hit(&triangles(distances), |t| {
            (t.corners[0].x > 0.0 || t.corners[0].x.is_nan()).then_some(t.corners[0].x)
        });
        hit.map(|hit| (hit.t, hit.triangles))
    }

    #[test]
    fn nothing_is_hit() {
        assert_eq!(search(&[]), None);
        assert_eq!(search(&[-1.0, 0.0]), None);
    }

    #[test]
    fn least_distance_wins_wherever_it_stands() {
        for distances in [[1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0]] {
            let at = distances.iter().position(|&t| t == 1.0).expect("there") as u32;
            assert_eq!(search(&distances), Some((1.0, vec![at])));
        }
    }

    #[test]
    fn ties_are_all_named() {
        assert_eq!(search(&[5.0, 2.0, -1.0, 2.0, 7.0, 2.0]), Some((2.0, vec![1, 3, 5])));
    }

    #[test]
    fn nan_is_no_hit() {
        assert_eq!(search(&[f32::NAN, 2.0, f32::NAN]), Some((2.0, vec![1])));
        assert_eq!(search(&[f32::NAN]), None);
    }

    #[test]
    fn every_triangle_is_tried_once() {
        let mut tried = Vec::new();
        closest_hit(&triangles(&[1.0, 0.5, 2.0]), |t| {
            tried.push(t.corners[0].x);
            Some(t.corners[0].x)
        });
        assert_eq!(tried, [1.0, 0.5, 2.0]);
    }
}
