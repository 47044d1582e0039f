//! Intervals of distances: which part of a ray lies in a cell (KD-3).
//!
//! Bounds of intervals are computed in f32 and widened by their rounding error, so that no cell is
//! missed: `t = (plane - origin) · (1 / direction)` takes three roundings, so that the computed distance
//! is the true one times 1 ± γ(3), γ(n) = n·u / (1 - n·u), u = 2⁻²⁴, and up to 2⁻¹⁵⁰ more where the
//! product underflows (Higham 2002, §2.1 and §3.1; after Ize 2013). The difference cannot underflow,
//! and the reciprocal must not: where it would, [`reciprocal`] makes it NaN, for which no interval
//! is cut.

/// Relative width by which a distance to a plane is widened to each side: 2 γ(3). The first γ(3) is
/// the error of the distance. Of the second one u is for the rounding of the widening itself, and
/// 2u are left for the distance that it is compared to: a hit may be reported at up to 1 ± 2u times
/// its true distance, that is within one unit in the last place, and cuts off no hit that is nearer
/// or as near (KD-4).
pub const WIDENING: f32 = 6.0 * (f32::EPSILON / 2.0) / (1.0 - 3.0 * (f32::EPSILON / 2.0));

/// Absolute width, for distances among the least f32, where rounding is not relative: half of the
/// least f32 each for the rounding of the distance, of the widening, and of the distance of a hit
/// that it is compared to, and as much to spare. It changes no distance above 2⁻¹²³.
pub const UNDERFLOW: f32 = f32::from_bits(2);

/// The parts of the rays that lie in a cell: `enter ≤ t ≤ leave`, closed, empty for a ray that
/// does not meet the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intervals<const N: usize> {
    /// Where each ray enters.
    pub enter: [f32; N],
    /// Where each ray leaves.
    pub leave: [f32; N],
}

impl<const N: usize> Intervals<N> {
    /// No ray meets the cell.
    pub const EMPTY: Self = Self { enter: [f32::INFINITY; N], leave: [f32::NEG_INFINITY; N] };

    /// Every ray meets the cell, all along.
    pub const EVERYWHERE: Self = Self { enter: [f32::NEG_INFINITY; N], leave: [f32::INFINITY; N] };

    /// Whether the ray in `lane` meets the cell.
    pub fn meets(&self, lane: usize) -> bool {
        self.enter[lane] <= self.leave[lane]
    }

    /// Whether any ray meets the cell.
    pub fn any(&self) -> bool {
        self.count() > 0
    }

    /// Number of rays that meet the cell.
    pub fn count(&self) -> u32 {
        (0..N).map(|lane| u32::from(self.meets(lane))).sum()
    }

    /// The first ray that meets the cell.
    pub fn first(&self) -> Option<usize> {
        (0..N).find(|&lane| self.meets(lane))
    }

    /// Cuts off what lies behind the hits found so far, at the distances `t`.
    pub fn clip(&mut self, t: &[f32; N]) {
        for (leave, &t) in self.leave.iter_mut().zip(t) {
            *leave = min(t, *leave);
        }
    }
}

/// The lesser of two numbers; the second where they are equal, or one is NaN.
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater of two numbers; the second where they are equal, or one is NaN.
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Least and greatest distance at which a plane may be met, from the distance computed (KD-3,
/// Derived). Both are NaN where that is, and infinite where that is.
pub fn widen(t: f32) -> (f32, f32) {
    let (a, b) = (t * (1.0 - WIDENING), t * (1.0 + WIDENING));
    (min(a, b) - UNDERFLOW, max(a, b) + UNDERFLOW)
}

/// The interval of one ray in the two children of a node (KD-3): below and above the plane that it
/// meets between the distances `least` and `greatest`. It comes from above where `downwards`.
///
/// A distance that is NaN, as of a plane in which the ray lies, leaves the whole interval to both
/// children; an infinite distance, as of a plane to which the ray is parallel, leaves it to the side
/// on which the ray is.
pub fn visit(enter: f32, leave: f32, (least, greatest): (f32, f32), downwards: bool) -> [(f32, f32); 2] {
    let near = (enter, min(greatest, leave));
    let far = (max(least, enter), leave);
    let (below, above) = if downwards { (far, near) } else { (near, far) };
    [below, above]
}

/// 1 / `direction`, for distances to planes up to `reach` away: infinite where the ray is parallel
/// to them, and NaN, for which every ray goes to both children, where distances would be off by more
/// than their bound (KD-3, Derived).
///
/// That is where the reciprocal is less than the least normal f32, or a distance is greater than
/// the greatest f32: a ray with a component of 2⁻¹³⁰ has none that is an f32, but moves by 1/8 until
/// t = 2¹²⁷.
pub fn reciprocal(direction: f32, reach: f32) -> f32 {
    let reciprocal = 1.0 / direction;
    let exact = direction == 0.0;
    let bounded = (reciprocal.abs() >= f32::MIN_POSITIVE) & (reach * reciprocal.abs() < f32::INFINITY);
    if exact | bounded { reciprocal } else { f32::NAN }
}

/// Whether a ray goes towards lower coordinates, by the reciprocal of its direction; −0.0, whose
/// reciprocal is −∞, does.
pub fn is_downwards(reciprocal: f32) -> bool {
    reciprocal < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_empty((enter, leave): (f32, f32)) -> bool {
        enter > leave
    }

    #[test]
    fn rays_that_meet_the_cell_are_counted() {
        // Inside, in one point, not at all, and inside once more.
        let intervals = Intervals { enter: [0.0, 2.0, 3.0, 1.0], leave: [1.0, 2.0, 1.0, 4.0] };
        assert_eq!((intervals.count(), intervals.any(), intervals.first()), (3, true, Some(0)));
        assert_eq!((Intervals::<4>::EMPTY.count(), Intervals::<4>::EMPTY.any()), (0, false));
    }

    #[test]
    fn planes_split_the_interval() {
        let [below, above] = visit(1.0, 5.0, widen(3.0), false);
        assert!(below.0 == 1.0 && below.1 >= 3.0 && above.0 <= 3.0 && above.1 == 5.0);
        assert!(below.1 - above.0 < 1e-5);
        assert_eq!(visit(1.0, 5.0, widen(3.0), true), [above, below]);
        let [below, above] = visit(1.0, 5.0, widen(7.0), false);
        assert!(!is_empty(below) && is_empty(above));
        let [below, above] = visit(1.0, 5.0, widen(-7.0), false);
        assert!(is_empty(below) && !is_empty(above));
    }

    #[test]
    fn parallel_rays_stay_on_their_side() {
        // (split - origin) / 0, from below and from above the plane.
        for (zero, downwards) in [(0.0_f32, false), (-0.0, true)] {
            let [below, above] = visit(0.0, 9.0, widen(1.0 / zero), downwards);
            assert!((!is_empty(below), is_empty(above)) == (true, true));
            let [below, above] = visit(0.0, 9.0, widen(-1.0 / zero), downwards);
            assert!((is_empty(below), !is_empty(above)) == (true, true));
        }
    }

    #[test]
    fn rays_in_the_plane_go_to_both_sides() {
        assert_eq!(visit(0.0, 9.0, widen(f32::NAN), false), [(0.0, 9.0); 2]);
        assert_eq!(visit(0.0, 9.0, widen(f32::NAN), true), [(0.0, 9.0); 2]);
    }

    #[test]
    fn planes_are_widened_by_their_rounding_error() {
        let unit = 2.0_f64.powi(-24);
        let gamma = 3.0 * unit / (1.0 - 3.0 * unit);
        assert_eq!(WIDENING, (2.0 * gamma) as f32);
        assert_eq!(widen(2.0), (2.0 * (1.0 - WIDENING), 2.0 * (1.0 + WIDENING)));
        assert_eq!(widen(-2.0), (-2.0 * (1.0 + WIDENING), -2.0 * (1.0 - WIDENING)));
        // Among the least numbers by two of them.
        assert_eq!(widen(f32::from_bits(9)), (f32::from_bits(7), f32::from_bits(11)));
        assert_eq!(widen(0.0), (-f32::from_bits(2), f32::from_bits(2)));
    }

    #[test]
    fn distances_that_would_not_be_bounded_are_nan() {
        let least = 2.0_f32.powi(-130);
        assert!(reciprocal(least, 1.0).is_nan() && reciprocal(-least, 0.0).is_nan());
        assert!(reciprocal(2.0_f32.powi(127), 1.0).is_nan());
        assert!(reciprocal(2.0_f32.powi(-120), 2.0_f32.powi(8)).is_nan());
        assert!(reciprocal(1.0, f32::INFINITY).is_nan() && reciprocal(f32::NAN, 1.0).is_nan());
        assert_eq!(reciprocal(2.0_f32.powi(-120), 2.0_f32.powi(7)), 2.0_f32.powi(120));
        assert_eq!((reciprocal(0.0, 0.0), reciprocal(-0.0, 9.0)), (f32::INFINITY, f32::NEG_INFINITY));
        assert_eq!((reciprocal(4.0, 1.0), reciprocal(-4.0, 1.0)), (0.25, -0.25));
    }

    #[test]
    fn minus_zero_is_downwards() {
        assert!(is_downwards(1.0 / -0.0) && !is_downwards(1.0 / 0.0));
        assert!(!is_downwards(1.0 / f32::INFINITY));
    }
}
