//! Theorems of the intervals of 64 rays, and of distances to planes (KD-3).

use super::LANES;
use crate::source::Source;
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::rays::{Intervals, reciprocal, widen};

/// Rays of a packet of the standard configuration.
const RAYS: usize = 64;

/// The first and the last float of each exponent and two between, of either sign.
static FLOATS: [u32; 2048] = {
    let mut floats = [0; 2048];
    let mut i = 0;
    while i < 2048 {
        let mantissa = [0, 1, 0x55_5555, 0x7f_ffff][i % 4];
        floats[i] = ((i as u32 >> 2) << 23) | mantissa;
        i += 1;
    }
    floats
};

/// Bits of distances in ascending order.
static DISTANCES: [u32; 6] = [0xff80_0000, 0xbf80_0000, 0, 0x3f80_0000, 0x4000_0000, 0x7f80_0000];

/// Masks: none, all, single lanes, and halves.
static MASKS: [u64; 12] = [
    0,
    u64::MAX,
    1,
    1 << 15,
    1 << 16,
    1 << 31,
    1 << 32,
    1 << 63,
    0xffff_0000,
    0xffff_ffff_0000_0000,
    0x8000_0000_0000_0001,
    0x5555_5555_5555_5555,
];

/// Bits without a pattern.
static MIXED: [u32; 10] = [
    0x0000_0000,
    0x007f_ffff,
    0x812a_aaab,
    0x0255_5555,
    0x8333_3333,
    0x0019_999a,
    0x8240_0001,
    0x017f_fffe,
    0x8076_5432,
    0x0312_3457,
];

/// A number from 1/8 to 32, of either sign, of bits of an f32 without most of the exponent.
fn between(bits: u32) -> f32 {
    f32::from_bits(bits & 0x807f_ffff | (124 + (bits >> 23 & 7)) << 23)
}

/// 2 to a power from -149 on.
fn power_of_two(power: i32) -> f32 {
    2.0_f64.powi(power) as f32
}

fn distance(s: &mut impl Source, name: &'static str) -> f32 {
    f32::from_bits(s.value(name, 0..=u32::MAX, &DISTANCES))
}

theorems! {
    /// Of 64 rays, a hit of each cuts off what lies behind it of that ray, and nothing of any other.
    #["KD-4", unwind 66, covers ["cut off", "left as it is", "the last lane", "the other ray is cut off"]]
    fn hits_of_64_rays_cut_off_their_own_rays(s) {
        let lane = s.value("lane", 0..=63, &[0, 16, 63_u32]) as usize;
        let (enter, leave, t) = (distance(s, "bits of enter"), distance(s, "bits of leave"), distance(s, "bits of the hit"));
        let (other, other_leave) = (distance(s, "bits of the other hits"), distance(s, "bits of the other ends"));
        assume!(!leave.is_nan() && !t.is_nan() && !other.is_nan() && !other_leave.is_nan());
        let mut cell = Intervals::<RAYS> { enter: [0.5; RAYS], leave: [other_leave; RAYS] };
        let mut hits = [other; RAYS];
        for at in 0..RAYS {
            if at == lane {
                (cell.enter[at], cell.leave[at], hits[at]) = (enter, leave, t);
            }
        }
        cell.clip(&hits);
        cover!(s, "cut off", t < leave);
        cover!(s, "left as it is", t > leave);
        cover!(s, "the last lane", lane == 63);
        cover!(s, "the other ray is cut off", other < other_leave && t > leave);
        // Any lane: all are judged by it.
        let seen = s.value("lane that is looked at", 0..=63, &LANES) as usize;
        let mut found = (0.0, 0.0);
        for at in 0..RAYS {
            if at == seen {
                found = (cell.enter[at], cell.leave[at]);
            }
        }
        let (enter, leave, t) = if seen == lane { (enter, leave, t) } else { (0.5, other_leave, other) };
        let ends = if t < leave { t } else { leave };
        check_eq!(found.0.to_bits(), enter.to_bits(), "where lane {seen} enters, beside {lane}");
        check!(found.1 == ends, "lane {seen} beside {lane}, up to {leave}, hit at {t}: up to {}", found.1);
    }

    /// Of 64 rays those meet a cell whose interval is not empty, in whichever lanes they are: their number, the
    /// first of them, and whether there is any are those of the mask of the lanes.
    #["KD-3", unwind 66, covers ["none", "all", "the last alone", "from lane 16 on"]]
    fn rays_that_meet_a_cell_are_the_mask(s) {
        let mask = s.value("lanes that meet the cell", 0..=u64::MAX, &MASKS);
        let mut cell = Intervals::<RAYS>::EMPTY;
        for lane in 0..RAYS {
            if mask >> lane & 1 == 1 {
                // In one point.
                (cell.enter[lane], cell.leave[lane]) = (1.0, 1.0);
            }
        }
        cover!(s, "none", mask == 0);
        cover!(s, "all", mask == u64::MAX);
        cover!(s, "the last alone", mask == 1 << 63);
        cover!(s, "from lane 16 on", mask & 0xffff == 0 && mask != 0);
        let (mut count, mut first) = (0, None);
        for lane in 0..RAYS {
            let meets = mask >> lane & 1 == 1;
            check_eq!(cell.meets(lane), meets, "lane {lane} of {mask:#x}");
            count += u32::from(meets);
            if meets && first.is_none() {
                first = Some(lane);
            }
        }
        check_eq!(cell.count(), count, "rays of {mask:#x}");
        check_eq!(cell.any(), count > 0, "any ray of {mask:#x}");
        check_eq!(cell.first(), first, "the first ray of {mask:#x}");
    }

    /// The distance to a plane, widened, holds every f32 at which a hit in that plane may be reported: within 2 u of the true distance,
    /// u = 2^-24, or within half of the least f32.
    #["KD-3", not_for_kani "it divides in floating point", covers ["less than the true one", "greater", "behind the origin", "denormal"]]
    fn widened_distances_hold_every_hit(s) {
        let plane = between(s.value("bits of the plane", 0..=u32::MAX, &MIXED));
        let origin = between(s.value("bits of the origin", 0..=u32::MAX, &MIXED));
        let power = s.value("exponent of the direction + 150", 0..=280, &[30, 150, 276_u32]) as i32 - 150;
        let direction = between(s.value("bits of the direction", 0..=u32::MAX, &MIXED)) * power_of_two(power);
        let reach = (plane - origin).abs();
        let found = (plane - origin) * reciprocal(direction, reach);
        assume!(found.is_finite() && direction != 0.0);
        // Off by 2 of 2^53, which is nothing here.
        let right = (f64::from(plane) - f64::from(origin)) / f64::from(direction);
        let least = f64::from(f32::from_bits(1));
        let off = (right.abs() / f64::from(1 << 23)).max(least / 2.0) * (1.0 - 2.0_f64.powi(-20));
        cover!(s, "less than the true one", f64::from(found) < right);
        cover!(s, "greater", f64::from(found) > right);
        cover!(s, "behind the origin", found < 0.0);
        cover!(s, "denormal", found.is_subnormal());
        let [first, last] = [right - off, right + off];
        // The first and the last f32 between.
        let first = if f64::from(first as f32) < first { (first as f32).next_up() } else { first as f32 };
        let last = if f64::from(last as f32) > last { (last as f32).next_down() } else { last as f32 };
        let (low, high) = widen(found);
        check!(low <= first && last <= high, "{plane:e} from {origin:e} along {direction:e}: {low:e} to {high:e}, where hits are at {first:e} to {last:e}");
    }

    /// A distance is widened to both sides by 6 u of it, u = 2^-24, rounded to the nearest f32, and then by twice
    /// the least f32.
    #["KD-3", not_for_kani "it multiplies in floating point", covers ["positive", "negative", "denormal", "beyond the greatest number"]]
    fn widening_is_by_six_roundoffs(s) {
        let t = f32::from_bits(s.value("bits of a distance", 0..=u32::MAX, &FLOATS));
        assume!(t.is_finite());
        cover!(s, "positive", t > 0.0);
        cover!(s, "negative", t < 0.0);
        cover!(s, "denormal", t.is_subnormal());
        // Of 48 bits, which f64 holds.
        let six = 6.0 / f64::from(1 << 24);
        let (lesser, greater) = ((f64::from(t) * (1.0 - six)) as f32, (f64::from(t) * (1.0 + six)) as f32);
        cover!(s, "beyond the greatest number", greater.is_infinite());
        let (low, high) = if t < 0.0 { (greater, lesser) } else { (lesser, greater) };
        let least = f64::from(f32::from_bits(1));
        let expected = ((f64::from(low) - 2.0 * least) as f32, (f64::from(high) + 2.0 * least) as f32);
        check_eq!(widen(t), expected, "{t:e}");
    }

    /// The reciprocal of a direction is infinite, of the direction's sign, where that is zero; it is NaN exactly
    /// where the direction is longer than 2^126, so that the reciprocal is no normal number, or where a distance
    /// as far as the rays reach would be greater than the greatest f32; else it is 1 over the direction, rounded.
    #["KD-3", not_for_kani "it multiplies and divides in floating point", covers ["0.0", "-0.0", "too long", "too short", "2^126", "as it is", "NaN"]]
    fn reciprocal_is_bounded_or_none(s) {
        let bits = s.value("bits of the direction", 0..=u32::MAX, &FLOATS);
        let direction = f32::from_bits(bits);
        let reach = f32::from_bits(s.value("bits of the reach", 0..=0x7f80_0000, &[0, 1, 0x0080_0000, 0x3f80_0000, 0x4300_0000, 0x7f00_0000, 0x7f7f_ffff, 0x7f80_0000]));
        let found = reciprocal(direction, reach);
        let inverse = 1.0 / f64::from(direction);
        let long = f64::from(direction).abs() > 2.0_f64.powi(126);
        // Half a unit in the last place above the greatest f32, from which on numbers are rounded to infinity.
        let greatest = 2.0_f64.powi(128) - 2.0_f64.powi(103);
        let rounded = f64::from(inverse as f32).abs();
        let far = rounded.is_infinite() || f64::from(reach) * rounded >= greatest || reach.is_infinite();
        cover!(s, "0.0", bits == 0);
        cover!(s, "-0.0", bits == 1 << 31);
        cover!(s, "too long", long);
        cover!(s, "too short", direction != 0.0 && !long && far);
        cover!(s, "2^126", direction.abs() == 2.0_f32.powi(126) && !far);
        cover!(s, "as it is", !long && !far);
        cover!(s, "NaN", direction.is_nan());
        if direction == 0.0 {
            let infinite = if bits == 0 { f32::INFINITY } else { f32::NEG_INFINITY };
            check_eq!(found, infinite, "direction {direction:?}");
        } else if direction.is_nan() || long || far {
            check!(found.is_nan(), "direction {direction:e}, reach {reach:e}: {found:e}");
        } else {
            check_eq!(found, inverse as f32, "direction {direction:e}, reach {reach:e}");
        }
    }
}
