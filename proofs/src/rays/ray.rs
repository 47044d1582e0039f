//! Theorems of packets of 64 rays, and of what they hit (RG-2).
//!
//! One witness lane of 64 stands for all of them: whatever the other lanes hold, it is as its own ray.

use crate::draw::{self, WORDS};
use crate::source::Source;
use crate::{check, check_eq, cover, theorems};
use saarcor_model::rays::{Hits, Packet, Query, Ray};
use saarcor_model::vm::HostAddr;

/// Rays of a packet of the standard configuration.
const RAYS: usize = 64;

/// Bits of coordinates and distances: zeros, numbers, infinities and NaN.
static NUMBERS: [u32; 8] =
    [0, 0x8000_0000, 1, 0x3f80_0000, 0xbf80_0000, 0x7f80_0000, 0xff80_0000, 0x7fc0_0001];

/// Bits of `t_min` and `t_max`: in each order, equal, infinite, NaN.
static ENDS: [u32; 6] = [0, 0x8000_0000, 0x3f80_0000, 0x7f80_0000, 0xff80_0000, 0x7fc0_0000];

fn number(s: &mut impl Source, name: &'static str, small: &'static [u32]) -> f32 {
    f32::from_bits(s.value(name, 0..=u32::MAX, small))
}

/// Any ray: in the small scope its coordinates differ from each other.
fn ray(s: &mut impl Source) -> Ray {
    let mut numbers = [0.0; 6];
    let odd = s.value("a coordinate", 0..=5, &WORDS[..6]) as usize;
    let bits = number(s, "its bits", &NUMBERS);
    for place in 0..6 {
        numbers[place] = if place == odd { bits } else { 2.0 + place as f32 };
    }
    let [x, y, z, dx, dy, dz] = numbers;
    let (t_min, t_max) = (number(s, "bits of t_min", &ENDS), number(s, "bits of t_max", &ENDS));
    Ray { origin: [x, y, z].into(), direction: [dx, dy, dz].into(), t_min, t_max }
}

/// The bits of all numbers of a ray: NaN equals itself, and zeros differ.
fn bits(ray: &Ray) -> [u32; 8] {
    let ([x, y, z], [dx, dy, dz]) = (ray.origin.to_array(), ray.direction.to_array());
    [x, y, z, dx, dy, dz, ray.t_min, ray.t_max].map(f32::to_bits)
}

theorems! {
    /// Each lane of a packet of 64 rays holds its own ray, bit for bit, whatever the other lanes hold; it takes
    /// part exactly if its range is not empty, and a lane without a ray does not.
    #["RG-2", unwind 66, covers ["takes part", "an empty range", "the last lane", "from lane 16 on", "without a ray"]]
    fn lanes_of_a_packet_hold_their_own_rays(s) {
        let lane = s.value("lane", 0..=63, &[0, 1, 15, 16, 17, 31, 32, 62, 63_u32]) as usize;
        let (own, other) = (ray(s), Ray { origin: [-1.0; 3].into(), direction: [-2.0; 3].into(), t_min: 0.0, t_max: 9.0 });
        let (there, others) = (draw::flag(s, "the lane has a ray"), draw::flag(s, "the others have rays"));
        let mut rays = [others.then_some(other); RAYS];
        for at in 0..RAYS {
            if at == lane {
                rays[at] = there.then_some(own);
            }
        }
        let packet = Packet::<RAYS>::new(rays);
        let active = there && own.t_min <= own.t_max;
        cover!(s, "takes part", active);
        cover!(s, "an empty range", there && !active);
        cover!(s, "the last lane", lane == 63);
        cover!(s, "from lane 16 on", lane >= 16);
        cover!(s, "without a ray", !there);
        check_eq!(packet.is_active(lane), active, "lane {lane}: {own:?}");
        check_eq!(packet.active(), u32::from(active) + if others { 63 } else { 0 }, "rays that take part");
        if there {
            check_eq!(bits(&packet.ray(lane)), bits(&own), "lane {lane}: {own:?}");
            check_eq!(packet.origin(lane).to_array().map(f32::to_bits), own.origin.to_array().map(f32::to_bits), "origin of lane {lane}");
            check_eq!(packet.direction(lane).to_array().map(f32::to_bits), own.direction.to_array().map(f32::to_bits), "direction of lane {lane}");
        }
        for at in 0..RAYS {
            if at != lane {
                check_eq!(packet.is_active(at), others, "lane {at} beside {lane}");
                check!(!others || packet.ray(at) == other, "lane {at} beside {lane}");
            }
        }
        let hits = Hits::none(&packet);
        check_eq!(hits.t[lane].to_bits(), packet.t_max[lane].to_bits(), "lane {lane} before any hit");
        check!(!hits.is_hit(lane), "lane {lane} before any hit");
    }

    /// A hit that is kept is its own lane's, bit for bit, and changes no other of 64; for a shadow ray it lies
    /// at minus infinity.
    #["IS-2", unwind 66, covers ["closest", "any", "the last lane", "at the last address"]]
    fn hit_is_kept_in_its_own_lane(s) {
        let lane = s.value("lane", 0..=63, &[0, 1, 15, 16, 17, 31, 32, 62, 63_u32]) as usize;
        let found = [number(s, "bits of t", &NUMBERS), number(s, "bits of u", &NUMBERS[..4]), number(s, "bits of v", &NUMBERS[4..])];
        let addr = HostAddr(s.value("address / 4", 0..=u32::MAX >> 2, &[0, 9, 0x1_0000, u32::MAX >> 2]) << 2);
        let query = if draw::flag(s, "any hit") { Query::Any } else { Query::Closest };
        let before = Hits::<RAYS> { t: [7.0; RAYS], u: [0.5; RAYS], v: [0.25; RAYS], triangle: [36; RAYS] };
        let mut hits = before;
        hits.keep(lane, addr, found, query);
        cover!(s, "closest", query == Query::Closest);
        cover!(s, "any", query == Query::Any);
        cover!(s, "the last lane", lane == 63);
        cover!(s, "at the last address", addr.0 == 0xffff_fffc);
        for at in 0..RAYS {
            let now = [hits.t[at].to_bits(), hits.u[at].to_bits(), hits.v[at].to_bits(), hits.triangle[at]];
            let [t, u, v] = if at == lane { found } else { [7.0, 0.5, 0.25] };
            let t = if at == lane && query == Query::Any { f32::NEG_INFINITY } else { t };
            let expected = [t.to_bits(), u.to_bits(), v.to_bits(), if at == lane { addr.0 } else { 36 }];
            check_eq!(now, expected, "lane {at}, hit of lane {lane}");
        }
        check!(hits.is_hit(lane), "lane {lane} after its hit at {addr:?}");
    }
}
