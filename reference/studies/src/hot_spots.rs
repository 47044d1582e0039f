//! The hot spots of a walk: the frames that step two of §4 simulates on the whole chip.

use crate::walk::FrameRow;
use saarcor_model::host::Camera;
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// What a frame has the most of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Extreme {
    /// Distinct lines touched.
    WorkingSet,
    /// Loads of lines that had been resident earlier in the frame.
    Collisions,
}

impl Extreme {
    fn of(self, row: &FrameRow) -> u64 {
        match self {
            Self::WorkingSet => row.working_set_lines,
            Self::Collisions => row.collisions,
        }
    }
}

/// A hot spot of a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct HotFrame {
    /// Number of the frame in the path.
    pub frame: usize,
    /// What it has the most of.
    pub most: Extreme,
}

/// A step of the camera is a cut if it is as many times the path's median step.
const CUT_STEPS: f32 = 8.0;
/// Hot spots are apart from each other by the path's length through this number.
const SPOTS_A_PATH: usize = 50;

/// The frames before which the camera cuts (WK-5): its eye moves more than eight times as far as the median
/// of the path's moves, the larger of two in the middle, or it turns by more than half of its vertical field of view.
#[must_use]
pub fn cuts(path: &[Camera]) -> BTreeSet<usize> {
    let moves = || path.windows(2).map(|pair| pair[0].eye.distance(pair[1].eye));
    let mut lengths: Vec<f32> = moves().filter(|length| *length > 0.0).collect();
    lengths.sort_unstable_by(f32::total_cmp);
    let far = lengths.get(lengths.len() / 2).map_or(f32::INFINITY, |median| CUT_STEPS * median);
    let turns = path.windows(2).map(|pair| {
        let half_of_view = pair[0].fov_y_deg.to_radians() / 2.0;
        pair[0].dir.angle_between(pair[1].dir) > half_of_view
    });
    let cut = moves().zip(turns).map(|(length, turned)| length > far || turned);
    cut.enumerate().filter(|(_, cut)| *cut).map(|(place, _)| place + 1).collect()
}

/// `count` hot spots of a walk through a path, or as many as there are, in the order of their frames (WK-4): in turn the
/// frame with the largest working set and the one with most collisions, the first of several, that is apart from
/// those found before by at least a fiftieth of the path, rounded down. Where no frame that is left has a collision, the working set decides.
///
/// The first frame of the path and those after a cut are not among them, since no frame before warms their caches;
/// unless there are no others.
#[must_use]
pub fn hot_spots(rows: &[FrameRow], path: &[Camera], count: usize) -> Vec<HotFrame> {
    let cuts = cuts(path);
    let follows = |row: &&FrameRow| row.frame > 0 && !cuts.contains(&(row.frame as usize));
    let mut left: Vec<&FrameRow> = rows.iter().filter(follows).collect();
    if left.is_empty() {
        left = rows.iter().collect();
    }
    let apart = (path.len() / SPOTS_A_PATH).max(1) as u64;
    let mut spots = Vec::new();
    while let Some(first) = left.first().filter(|_| spots.len() < count) {
        let collide = left.iter().any(|row| row.collisions > 0);
        let most = if spots.len() % 2 == 1 && collide { Extreme::Collisions } else { Extreme::WorkingSet };
        let hottest = left.iter().max_by_key(|row| (most.of(row), Reverse(row.frame))).unwrap_or(first);
        let frame = hottest.frame;
        spots.push(HotFrame { frame: frame as usize, most });
        left.retain(|row| row.frame.abs_diff(frame) >= apart);
    }
    spots.sort_unstable_by_key(|spot| spot.frame);
    spots
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A path along x with these positions.
    fn path(positions: &[f32]) -> Vec<Camera> {
        let camera =
            |&x: &f32| Camera { eye: Vec3::new(x, 0.0, 0.0), dir: Vec3::Z, up: Vec3::Y, fov_y_deg: 60.0 };
        positions.iter().map(camera).collect()
    }

    fn walk(lines_and_collisions: &[(u64, u64)]) -> Vec<FrameRow> {
        let row = |(frame, &(working_set_lines, collisions)): (usize, &(u64, u64))| FrameRow {
            frame: frame as u64,
            working_set_lines,
            collisions,
            ..FrameRow::default()
        };
        lines_and_collisions.iter().enumerate().map(row).collect()
    }

    fn found(rows: &[FrameRow], path: &[Camera], count: usize) -> Vec<(usize, Extreme)> {
        hot_spots(rows, path, count).iter().map(|spot| (spot.frame, spot.most)).collect()
    }

    #[test]
    fn cut_is_far_from_the_steps_of_the_path_or_turns_away() {
        let steady: Vec<f32> = (0..20).map(|step| step as f32).collect();
        assert_eq!(cuts(&path(&steady)), BTreeSet::new());
        // Twice as fast is no cut, and neither is a rest.
        assert_eq!(cuts(&path(&[0.0, 1.0, 2.0, 4.0, 4.0, 4.0, 5.0])), BTreeSet::new());
        assert_eq!(cuts(&path(&[0.0, 1.0, 2.0, 11.0, 12.0, 13.0])), BTreeSet::from([3]));
        let mut turning = path(&steady);
        let turned =
            |degrees: f32| Vec3::new(libm::sinf(degrees.to_radians()), 0.0, libm::cosf(degrees.to_radians()));
        (turning[7].dir, turning[8].dir) = (turned(29.0), turned(61.0));
        turning[9..].iter_mut().for_each(|camera| camera.dir = turned(61.0));
        assert_eq!(cuts(&turning), BTreeSet::from([8]));
        assert_eq!(cuts(&path(&[])), BTreeSet::new());
        assert_eq!(cuts(&path(&[3.0, 3.0, 3.0])), BTreeSet::new());
    }

    #[test]
    fn hot_spots_take_turns_and_are_apart() {
        use Extreme::{Collisions, WorkingSet};
        let steady: Vec<f32> = (0..150).map(|step| step as f32).collect();
        let path = path(&steady);
        let mut lines = vec![(10, 0); 150];
        // The first frame of a path is none; of several the first is one; frames nearer than three see the same.
        (lines[0], lines[40], lines[42], lines[43]) = ((99, 99), (50, 0), (49, 0), (48, 0));
        (lines[41], lines[90], lines[91]) = ((1, 9), (1, 7), (1, 7));
        let rows = walk(&lines);
        assert_eq!(found(&rows, &path, 1), [(40, WorkingSet)]);
        assert_eq!(found(&rows, &path, 3), [(40, WorkingSet), (43, WorkingSet), (90, Collisions)]);
        assert_eq!(found(&rows, &path, 4)[0], (1, WorkingSet), "no collision is left");
        let few = found(&rows[..9], &path, 9);
        assert_eq!(few.iter().map(|spot| spot.0).collect::<Vec<_>>(), [1, 4, 7]);
    }

    #[test]
    fn cuts_and_first_frames_are_hot_spots_only_of_paths_without_others() {
        let path = path(&[0.0, 1.0, 2.0, 20.0]);
        let rows = walk(&[(9, 9), (1, 0), (2, 0), (8, 8)]);
        let frames = |rows: &[FrameRow]| found(rows, &path, 9).iter().map(|spot| spot.0).collect::<Vec<_>>();
        assert_eq!(frames(&rows), [1, 2]);
        assert_eq!(frames(&rows[..1]), [0]);
        assert_eq!(frames(&rows[3..]), [3]);
        assert_eq!(frames(&[]), [0; 0]);
    }
}
