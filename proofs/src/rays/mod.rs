//! Theorems of rays: where they come from, their way through the kd-tree, what they hit, and what it looks like.

pub mod camera;
pub mod edges;
pub mod intersection;
pub mod interval;
pub mod ray;
pub mod shading;
pub mod texel;
pub mod traversal;

/// A number that has nothing to do with those of its neighbours (the finaliser of MurmurHash3).
fn noise(number: u32) -> u32 {
    let mixed = (number ^ number >> 16).wrapping_mul(0x85eb_ca6b);
    let mixed = (mixed ^ mixed >> 13).wrapping_mul(0xc2b2_ae35);
    mixed ^ mixed >> 16
}

/// All lanes of a packet of 64 rays.
static LANES: [u32; 64] = {
    let mut lanes = [0; 64];
    let mut lane = 0;
    while lane < lanes.len() {
        lanes[lane] = lane as u32;
        lane += 1;
    }
    lanes
};
