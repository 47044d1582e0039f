//! Cuts a face of four corners or more into triangles.

use std::collections::HashMap;

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// A face of so many corners is not cut by its ears, which takes at worst the square of their number.
pub(crate) const LONGEST: usize = 1 << 14;

/// The squares of the corners of all faces that are cut by their ears, added up: minutes of work at worst.
const MOST_WORK: u64 = 1 << 34;

/// Areas up to this part of a face's are those of corners on an edge, which are rounded as all are.
const TOLERANCE: f64 = 1e-6;

/// Why a face is cut into a fan that covers another area than its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Uncut {
    /// Its edges cross, so that it has no inside.
    CrossesItself,
    /// It has [`LONGEST`] corners or more.
    TooLong,
    /// The faces before it took all the work that is spent on one file.
    TooMany,
}

/// Cuts faces into triangles; keeps its memory from face to face.
#[derive(Default)]
pub(crate) struct Cutter {
    earcut: Earcut<f64>,
    work: u64,
    ears: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of a face, as numbers of its `corners`, which are three or more: corners − 2, in
    /// the sense of rotation of the face. Faces that lie in no plane are cut as they are seen along
    /// their normal.
    ///
    /// A fan around the first corner where it covers the face, as it does for each convex one; else the
    /// face's ears. Corners that lie on an edge between others stay corners, so that no gap opens to
    /// the face behind that edge.
    pub(crate) fn cut(&mut self, corners: &[Vec3]) -> (&[[u32; 3]], Option<Uncut>) {
        let Shape { normal, is_fan, is_sliver } = shape(corners);
        let uncut = match corners.len() {
            _ if is_fan => None,
            LONGEST.. if !is_sliver => Some(Uncut::TooLong),
            _ if self.work > MOST_WORK => Some(Uncut::TooMany),
            ..LONGEST if self.cut_ears(&seen_along(normal, corners)) => return (&self.triangles, None),
            _ if is_sliver => None,
            _ => Some(Uncut::CrossesItself),
        };
        self.fan(corners.len());
        (&self.triangles, uncut)
    }

    fn fan(&mut self, corners: usize) {
        self.triangles.clear();
        self.triangles.extend((2..corners as u32).map(|third| [0, third - 1, third]));
    }

    /// Cuts a ring in the plane, counterclockwise, and says whether the triangles cover just it.
    fn cut_ears(&mut self, ring: &[DVec2]) -> bool {
        self.work += (ring.len() as u64).pow(2);
        self.earcut.earcut(ring.iter().map(|corner| corner.to_array()), &[], &mut self.ears);
        self.triangles.clear();
        self.triangles.extend_from_slice(self.ears.as_chunks().0);
        for triangle in &mut self.triangles {
            if area(ring, *triangle) < 0.0 {
                triangle.swap(1, 2);
            }
        }
        self.add_left_out(ring.len());
        let wanted: f64 = (2..ring.len() as u32).map(|third| area(ring, [0, third - 1, third])).sum();
        let made: f64 = self.triangles.iter().map(|&triangle| area(ring, triangle).abs()).sum();
        wanted > 0.0 && (made - wanted).abs() <= TOLERANCE * wanted
    }

    /// Puts the corners that no ear has, as they lie on an edge, back on that edge.
    fn add_left_out(&mut self, corners: usize) {
        let mut has_ear = vec![false; corners];
        self.triangles.iter().flatten().for_each(|&corner| has_ear[corner as usize] = true);
        let Some(first) = has_ear.iter().position(|&has| has) else { return };
        if has_ear.iter().all(|&has| has) {
            return;
        }
        let edges_of = |index: usize, [a, b, c]: [u32; 3]| {
            [([a, b], (index, c)), ([b, c], (index, a)), ([c, a], (index, b))]
        };
        let all = self.triangles.iter().enumerate();
        let mut edges: HashMap<_, _> = all.flat_map(|(index, &ear)| edges_of(index, ear)).collect();
        let (mut begin, mut between) = (first as u32, Vec::new());
        for corner in (first + 1..=first + corners).map(|corner| corner % corners) {
            if !has_ear[corner] {
                between.push(corner as u32);
                continue;
            }
            let end = corner as u32;
            if let Some(&(index, apex)) = edges.get(&[begin, end]).filter(|_| !between.is_empty()) {
                let mut last = begin;
                for corner in between.iter().copied() {
                    edges.extend(edges_of(self.triangles.len(), [last, corner, apex]));
                    self.triangles.push([last, corner, apex]);
                    last = corner;
                }
                self.triangles[index] = [last, end, apex];
                edges.extend(edges_of(index, [last, end, apex]));
            }
            begin = end;
            between.clear();
        }
    }
}

/// What decides how a face is cut.
struct Shape {
    /// After Newell: as long as twice the face's area.
    normal: DVec3,
    /// The fan around the first corner covers the face: no triangle of it turns over.
    is_fan: bool,
    /// The corners lie on a line, but for rounding.
    is_sliver: bool,
}

fn shape(corners: &[Vec3]) -> Shape {
    let first = corners[0].as_dvec3();
    let spokes = || corners[1..].iter().map(|corner| corner.as_dvec3() - first);
    let doubled_areas = || spokes().zip(spokes().skip(1)).map(|(a, b)| a.cross(b));
    let normal: DVec3 = doubled_areas().sum();
    let flipped = TOLERANCE * normal.length_squared();
    let all: f64 = doubled_areas().map(|area| area.length()).sum();
    let longest = spokes().map(|spoke| spoke.length_squared()).fold(0.0, f64::max);
    Shape {
        normal,
        // Where they cancel out, no triangle is the one that is flipped.
        is_fan: doubled_areas().all(|area| area.dot(normal) >= -flipped)
            && normal.length() >= TOLERANCE * all,
        is_sliver: doubled_areas().all(|area| area.length() <= TOLERANCE * longest),
    }
}

/// The corners as they are seen against the normal: without the coordinate in which it is longest.
fn seen_along(normal: DVec3, corners: &[Vec3]) -> Vec<DVec2> {
    let (axis, along) = [0, 1, 2]
        .map(|axis| (axis, normal[axis]))
        .into_iter()
        .max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))
        .unwrap_or_default();
    let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
    // The triangles come out as the face goes: seen from behind, it is mirrored.
    let (x, y) = if along > 0.0 { (x, y) } else { (y, x) };
    corners.iter().map(|corner| DVec2::new(corner[x].into(), corner[y].into())).collect()
}

/// Twice the area of a triangle of the ring's corners, positive counterclockwise.
fn area(ring: &[DVec2], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| ring[corner as usize]);
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, EulerRot, Quat};
    use proptest::prelude::*;

    /// The ring in the plane z = 0.
    fn flat(ring: &[[i32; 2]]) -> Vec<Vec3> {
        ring.iter().map(|&[x, y]| Vec3::new(x as f32, y as f32, 0.0)).collect()
    }

    /// The letter C.
    const C: [[i32; 2]; 8] = [[0, 0], [4, 0], [4, 1], [1, 1], [1, 3], [4, 3], [4, 4], [0, 4]];

    /// Cuts the ring from each of its corners on, forwards and backwards, seen from everywhere:
    /// corners − 2 triangles that turn as the ring does and cover `area`.
    #[track_caller]
    fn covers(ring: &[[i32; 2]], area: f64) {
        let mut cutter = Cutter::default();
        for turn in [Quat::IDENTITY, Quat::from_rotation_x(1.5), Quat::from_rotation_y(2.0)] {
            for (begin, backwards) in (0..ring.len()).flat_map(|begin| [(begin, false), (begin, true)]) {
                let mut corners: Vec<Vec3> = flat(ring).iter().map(|&corner| turn * corner).collect();
                corners.rotate_left(begin);
                let mut facing = turn * Vec3::Z;
                if backwards {
                    corners.reverse();
                    facing = -facing;
                }
                let (triangles, uncut) = cutter.cut(&corners);
                assert_eq!((triangles.len(), uncut), (ring.len() - 2, None), "from {begin}, {turn}");
                let areas = triangles.iter().map(|triangle| {
                    let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
                    f64::from((b - a).cross(c - a).dot(facing)) / 2.0
                });
                let areas: Vec<f64> = areas.collect();
                assert!(areas.iter().all(|&area| area > -1e-5), "from {begin}, {turn}: {areas:?}");
                approx::assert_relative_eq!(areas.iter().sum::<f64>(), area, max_relative = 1e-5);
            }
        }
    }

    #[test]
    fn convex_faces_become_fans() {
        let mut cutter = Cutter::default();
        let face = flat(&[[0, 0], [1, 0], [2, 0], [2, 2], [0, 2]]);
        assert_eq!(cutter.cut(&face), (&[[0, 1, 2], [0, 2, 3], [0, 3, 4]][..], None));
        let line = [0.1, 0.3, 0.2, 0.7, 0.5].map(|at| at * Vec3::new(0.3, 0.7, 0.9));
        for nothing in [[Vec3::ONE; 5], line] {
            assert_eq!(cutter.cut(&nothing), (&[[0, 1, 2], [0, 2, 3], [0, 3, 4]][..], None));
        }
    }

    #[test]
    fn concave_faces_are_covered_once() {
        covers(&C, 10.0);
        covers(&[[0, 0], [4, 0], [1, 1], [0, 4]], 4.0);
    }

    #[test]
    fn thin_and_far_faces_are_covered_once() {
        let thin = flat(&C).into_iter().map(|corner| corner * Vec3::new(1e4, 1e-4, 1.0)).collect();
        let far = flat(&C).into_iter().map(|corner| corner + Vec3::new(1e7, 0.0, -1e7)).collect();
        for corners in [thin, far] as [Vec<Vec3>; 2] {
            let mut cutter = Cutter::default();
            let (triangles, uncut) = cutter.cut(&corners);
            let area = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|corner| corners[corner as usize].as_dvec3());
                (b - a).cross(c - a).length() / 2.0
            };
            assert_eq!(uncut, None);
            approx::assert_relative_eq!(triangles.iter().map(area).sum::<f64>(), 10.0, max_relative = 1e-5);
        }
    }

    #[test]
    fn corners_on_an_edge_stay() {
        covers(&[[0, 0], [2, 0], [4, 0], [4, 1], [1, 1], [1, 2], [1, 3], [4, 3], [4, 4], [0, 4]], 10.0);
    }

    #[test]
    fn rings_with_a_bridge_have_a_hole() {
        let ring = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0], [1, 1], [1, 3], [3, 3], [3, 1], [1, 1]];
        covers(&ring, 12.0);
    }

    #[test]
    fn faces_that_cross_themselves_are_named() {
        let mut cutter = Cutter::default();
        for ring in [&[[0, 0], [2, 2], [2, 0], [0, 2]][..], &[[0, 0], [3, 3], [3, 0], [0, 2]]] {
            for axes in [
                Vec3::to_array,
                |corner| [corner.z, corner.x, corner.y],
                |corner| [corner.y, corner.z, corner.x],
            ] as [fn(&Vec3) -> [f32; 3]; 3]
            {
                let corners: Vec<Vec3> = flat(ring).iter().map(|corner| axes(corner).into()).collect();
                let (triangles, uncut) = cutter.cut(&corners);
                assert_eq!((triangles, uncut), (&[[0, 1, 2], [0, 2, 3]][..], Some(Uncut::CrossesItself)));
            }
        }
    }

    #[test]
    fn the_work_on_a_file_is_bounded() {
        let mut cutter = Cutter { work: MOST_WORK, ..Cutter::default() };
        assert_eq!(cutter.cut(&flat(&C)).1, None);
        assert_eq!(cutter.cut(&flat(&C)).1, Some(Uncut::TooMany));
        assert_eq!(cutter.cut(&flat(&[[0, 0], [1, 0], [1, 1], [0, 1]])).1, None);
    }

    #[test]
    fn the_longest_face_is_cut() {
        // A comb.
        let teeth = |corners: usize| -> Vec<Vec3> {
            let points = corners as i32 - 2;
            let mut ring: Vec<[i32; 2]> = (0..points).map(|i| [i, 10 + 5 * (i % 2)]).rev().collect();
            ring.extend([[0, 0], [points - 1, 0]]);
            flat(&ring)
        };
        let mut cutter = Cutter::default();
        assert_eq!(cutter.cut(&teeth(LONGEST - 2)).1, None);
        assert_eq!(cutter.cut(&teeth(LONGEST)).1, Some(Uncut::TooLong));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// Rings that are seen whole from a point inside, from any corner on, in any plane.
        #[test]
        fn rings_are_covered_once(
            radii in prop::collection::vec(0.1..10.0f64, 4..60),
            begin in any::<prop::sample::Index>(),
            turns in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let turn = DQuat::from_euler(EulerRot::XYZ, turns[0], turns[1], turns[2]);
            let angle = |i: usize| i as f64 / radii.len() as f64 * std::f64::consts::TAU;
            let at = |i: usize| turn * (radii[i] * DVec2::from_angle(angle(i)).extend(0.0));
            let mut corners: Vec<Vec3> = (0..radii.len()).map(|i| at(i).as_vec3()).collect();
            corners.rotate_left(begin.index(radii.len()));
            let doubled = |[a, b, c]: [Vec3; 3]| {
                let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
                (b - a).cross(c - a).dot(turn * DVec3::Z)
            };
            let area: f64 = (2..corners.len()).map(|i| doubled([corners[0], corners[i - 1], corners[i]])).sum();
            let mut cutter = Cutter::default();
            let (triangles, uncut) = cutter.cut(&corners);
            prop_assert_eq!((triangles.len(), uncut), (corners.len() - 2, None));
            let areas = triangles.iter().map(|triangle| doubled(triangle.map(|corner| corners[corner as usize])));
            let covered: f64 = areas.map(f64::abs).sum();
            prop_assert!((covered - area).abs() <= 1e-5 * area, "{} of {}", covered, area);
        }
    }
}
