//! Random scenes and rays, made to meet planes, edges and ends: coordinates are often whole, and rays often
//! go along an axis, in a plane of a cell, or through a corner.

use super::generated_scene::GeneratedScene;
use super::request::push_ray;
use super::scene_memory::KERNELS;
use glam::Vec3;
use saarcor_model::rays::{Query, Ray};
use saarcor_random::Random;

/// Rays of a scene.
const RAYS: usize = 64;
/// Most triangles of a scene.
const MAX_TRIANGLES: u64 = 12;

/// The configuration of a seed: three in four have the test of the standard chip, and of the others every other one owns
/// its edges.
#[must_use]
pub fn config_of(seed: u64) -> String {
    let place = if seed % 4 == 3 { 1 + seed / 4 % (KERNELS.len() as u64 - 1) } else { 0 };
    let edges = if seed % 8 == 7 { " edges=owned" } else { "" };
    format!("kernel={}{edges}", KERNELS[place as usize].0)
}

/// So many requests: scenes, each with rays, and the memory forgotten between them.
#[must_use]
pub fn requests(seed: u64, count: usize) -> Vec<u8> {
    let mut random = Random::new(seed);
    let mut text = Vec::new();
    let mut left = count;
    while left > 0 {
        let scene = RandomScene::new(&mut random);
        let writes = scene.scene.requests();
        let lines = writes.iter().filter(|&&byte| byte == b'\n').count();
        if lines >= left {
            (0..left).for_each(|_| text.extend_from_slice(b"flush\n"));
            break;
        }
        text.extend_from_slice(&writes);
        let rays = (left - lines).min(RAYS);
        for _ in 0..rays {
            let query = if random.percent(20) { Query::Any } else { Query::Closest };
            push_ray(&mut text, query, &scene.ray(&mut random));
        }
        left -= lines + rays;
        if left > 0 {
            text.extend_from_slice(b"flush\n");
            left -= 1;
        }
    }
    text
}

/// A scene, and the manner in which its coordinates are drawn.
struct RandomScene {
    scene: GeneratedScene,
    whole: bool,
}

impl RandomScene {
    fn new(random: &mut Random) -> Self {
        let whole = random.percent(50);
        let spread = random.pick(&[0.25, 1.0, 4.0]);
        let mut triangles: Vec<[Vec3; 3]> = Vec::new();
        for _ in 0..1 + random.below(MAX_TRIANGLES) {
            let mut corners = if whole {
                std::array::from_fn(|_| place(random, true))
            } else {
                let middle = place(random, false);
                std::array::from_fn(|_| middle + place(random, false) * spread / 4.0)
            };
            match (random.below(6), triangles.last()) {
                // In a plane across an axis: where cells are cut.
                (0, _) => {
                    let axis = random.below(3) as usize;
                    (corners[1][axis], corners[2][axis]) = (corners[0][axis], corners[0][axis]);
                }
                // Beside the last one, with the edge between them.
                (1, Some(&[a, b, _])) => corners = [b, a, corners[2]],
                // The last one again.
                (2, Some(&last)) if random.percent(50) => corners = last,
                _ => {}
            }
            triangles.push(corners);
        }
        Self { scene: GeneratedScene::new(&triangles, random), whole }
    }

    fn ray(&self, random: &mut Random) -> Ray {
        let whole = self.whole || random.percent(20);
        let origin = place(random, whole) * random.pick(&[0.5, 1.0, 4.0]);
        let target = match (random.below(4), &self.scene.triangles[..]) {
            (0, _) | (_, []) => place(random, whole),
            (kind, triangles) => {
                let [a, b, c] = random.pick(triangles);
                // A corner, the middle of an edge, or a point inside.
                match kind {
                    1 => a,
                    2 => a.midpoint(b),
                    _ => a * 0.25 + b * 0.25 + c * 0.5,
                }
            }
        };
        let mut direction = target - origin;
        match random.below(8) {
            0 => direction = Vec3::AXES[random.below(3) as usize] * random.pick(&[1.0, -1.0, 2.0, 1.0 / 3.0]),
            1 => direction[random.below(3) as usize] = random.pick(&[0.0, -0.0]),
            // Too little for a reciprocal, and for a bound of distances.
            2 => direction[random.below(3) as usize] = random.pick(&[1e-39, -1e-39, 1e-38]),
            3 => direction *= random.pick(&[0.25, 3.0]),
            _ => {}
        }
        let (t_min, t_max) = random.pick(&[
            (0.0, f32::INFINITY),
            (0.0, f32::INFINITY),
            (0.0, f32::INFINITY),
            (0.0, 1.0),
            (1.0, f32::INFINITY),
            (0.5, 2.0),
            (1.0, 1.0),
        ]);
        Ray { origin, direction, t_min, t_max }
    }
}

/// A point of the cube from -4 to 4, or of its whole numbers.
fn place(random: &mut Random, whole: bool) -> Vec3 {
    let mut coordinate = || match whole {
        true => random.below(9) as f32 - 4.0,
        false => random.below(1 << 24) as f32 / (1 << 21) as f32 - 4.0,
    };
    Vec3::new(coordinate(), coordinate(), coordinate())
}
