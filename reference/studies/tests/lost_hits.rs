//! KD-4 hard: kd-tree traversal with the adaptive test loses no hit, whatever the ray. Each ray is
//! judged exactly, among the triangles that the reference's own hierarchy leaves.
//!
//! The rays are those that traversal could lose: along edges and in the planes of the kd-tree, from
//! and to vertices, along axes, through the corners of cells, and with components of any size. Many
//! lie in the planes of many triangles, which nothing but exact arithmetic decides: they are few.
//! `saarcor crosscheck` judges millions of others.

use glam::Vec3;
use rayon::prelude::*;
use saarcor_fast::adaptive::FilteredIntersection;
use saarcor_model::host::{HostImage, KdTree, Kernel, Node, Scene};
use saarcor_model::rays::{Packet, Query, Ray, Traversal};
use saarcor_model::vm::{HostAddr, Observed};
use saarcor_oracles::bvh::Bvh;
use saarcor_oracles::exact::filter::Estimate;
use saarcor_oracles::exact::{closest, judge};
use saarcor_oracles::flat::FlatMemory;
use saarcor_scenes::Random;
use saarcor_scenes::builtin::builtin;
use saarcor_scenes::kdbuild::{BuildOptions, SplitRule, build};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

/// What rays are made of.
struct Ground {
    corners: Vec<[Vec3; 3]>,
    /// The planes of the tree: axis and coordinate.
    planes: Vec<(usize, f32)>,
    bounds: (Vec3, Vec3),
}

impl Ground {
    fn new(scene: &Scene, tree: &KdTree) -> Self {
        let plane = |node: &Node| match *node {
            Node::Inner { axis, split, .. } => Some((axis as usize, split)),
            Node::Leaf { .. } => None,
        };
        Self {
            corners: scene.triangles.iter().map(|triangle| triangle.corners).collect(),
            planes: tree.nodes.iter().filter_map(plane).collect(),
            bounds: (tree.bounds.min, tree.bounds.max),
        }
    }

    fn inside(&self, random: &mut Random) -> Vec3 {
        let (min, max) = self.bounds;
        Vec3::from_array(std::array::from_fn(|axis| random.between(min[axis], max[axis])))
    }

    fn vertex(&self, random: &mut Random) -> Vec3 {
        self.corners[random.range(0, self.corners.len() as u32) as usize][random.range(0, 3) as usize]
    }

    /// Moves a point into planes of the tree, on each axis one time in two: on all three it is a
    /// point in which cells can have a corner.
    fn moved_into_planes(&self, mut point: Vec3, random: &mut Random) -> Vec3 {
        for _ in 0..3 {
            let (axis, plane) = self.planes[random.range(0, self.planes.len() as u32) as usize];
            if random.range(0, 2) == 0 {
                point[axis] = plane;
            }
        }
        point
    }

    /// A ray of one of eight ideas.
    fn ray(&self, random: &mut Random) -> Ray {
        let zero = if random.range(0, 2) == 0 { 0.0 } else { -0.0 };
        let towards = |origin: Vec3, target: Vec3| (origin, target - origin);
        let (origin, mut direction) = match random.range(0, 8) {
            0 => towards(self.inside(random), self.vertex(random)),
            1 => towards(self.vertex(random), self.vertex(random)),
            // Along an edge, from before it.
            2 => {
                let [a, b, _] = self.corners[random.range(0, self.corners.len() as u32) as usize];
                (a - (b - a), b - a)
            }
            // In a plane of the tree, or through a corner of cells.
            3 => {
                let origin = self.inside(random);
                let origin = self.moved_into_planes(origin, random);
                towards(origin, self.moved_into_planes(origin, random))
            }
            4 => {
                let target = self.vertex(random);
                towards(self.inside(random), self.moved_into_planes(target, random))
            }
            // Along an axis, to a vertex or in planes.
            5 => {
                let target = self.vertex(random);
                let mut origin = self.moved_into_planes(target, random);
                let axis = random.range(0, 3) as usize;
                origin[axis] = self.inside(random)[axis];
                let mut direction = Vec3::ZERO;
                direction[axis] = if target[axis] < origin[axis] { -1.0 } else { 1.0 };
                (origin, direction)
            }
            // Nearly along a plane: components of very different size.
            6 => {
                let (origin, mut direction) = towards(self.vertex(random), self.inside(random));
                direction[random.range(0, 3) as usize] *= 2.0_f32.powi(-(random.range(0, 150) as i32));
                (origin, direction)
            }
            // Very short and very long directions.
            _ => {
                let (origin, direction) = towards(self.inside(random), self.vertex(random));
                (origin, direction * 2.0_f32.powi(random.range(0, 200) as i32 - 100))
            }
        };
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                direction[axis] = zero;
            }
        }
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}

/// Rays traced as one packet.
const PACKET: usize = 4;

/// Traces `rays` hard rays and judges each; returns how many hit something.
fn loses_nothing(name: &str, scene: &Scene, rule: SplitRule, rays: usize) -> u64 {
    let tree = build(&scene.triangles, &BuildOptions { rule, ..BuildOptions::default() }, &|_| {});
    let image = HostImage::build(scene, &tree, Kernel::Adaptive).expect("valid scene");
    let mut places = vec![u32::MAX; scene.triangles.len()];
    (0..).zip(&image.triangle_ids).for_each(|(place, &id)| places[id as usize] = place);
    let ground = Ground::new(scene, &tree);
    let bvh = Bvh::new(&ground.corners);
    let hit = AtomicU64::new(0);
    let corners = |id: u32| (id, ground.corners[id as usize]);

    let judged = |seed: usize| -> Vec<String> {
        let mut random = Random::new(seed as u64);
        let rays: [Ray; PACKET] = std::array::from_fn(|_| ground.ray(&mut random));
        let packet = Packet::new(rays.map(Some));
        let mut memory = Observed::by_nobody(FlatMemory::new(&image.bytes));
        let [found, any] = [Query::Closest, Query::Any].map(|query| {
            Traversal::<PACKET, _>::with(FilteredIntersection::default()).run(
                &mut memory,
                &image.registers,
                &packet,
                query,
            )
        });
        let fault = |(lane, ray): (usize, &Ray)| {
            let traversed = found.is_hit(lane).then(|| image.triangle_id(HostAddr(found.triangle[lane])));
            // A hit that is one bounds how far there is to look.
            let farthest = traversed.map(corners).filter(|(_, corners)| judge(ray, corners).is_hit());
            let farthest = farthest
                .map_or(f64::INFINITY, |(_, corners)| Estimate::new(ray, &corners).distance().greatest);
            let truth = closest(ray, bvh.candidates(ray, farthest).map(corners));
            let first = truth.as_ref().and_then(|truth| {
                truth.triangles.iter().map(|(id, _)| *id).min_by_key(|&id| places[id as usize])
            });
            hit.fetch_add(u64::from(first.is_some()), Ordering::Relaxed);
            (traversed != first || any.is_hit(lane) != first.is_some())
                .then(|| format!("{name}: {ray:?}: {traversed:?}, any {}, exact {truth:?}", any.is_hit(lane)))
        };
        rays.iter().enumerate().filter_map(fault).collect()
    };
    let faults: Vec<String> = (0..rays / PACKET).into_par_iter().flat_map_iter(judged).collect();
    let hits = hit.into_inner();
    println!("{name}, {rule:?}: {rays} rays, {hits} hits");
    assert!(faults.is_empty(), "{} of {rays}, such as {:#?}", faults.len(), &faults[..faults.len().min(5)]);
    hits
}

#[test]
fn no_hit_is_lost() {
    let scene = builtin("pquake3-nt").expect("built-in");
    for rule in [SplitRule::SurfaceArea, SplitRule::SpatialMedian] {
        assert!(loses_nothing("pquake3-nt", &scene, rule, 1_000) > 500);
    }
}

/// A part of a scene with all coordinates multiplied, so that distances are among the least f32 and
/// the largest. A ray for whose distances there is no bound goes through the whole tree: it is small.
#[test]
fn no_hit_is_lost_in_very_small_and_large_scenes() {
    for exponent in [-120, -60, 60, 110] {
        let mut scene = builtin("pquake3-nlnt").expect("built-in");
        let scale = 2.0_f32.powi(exponent);
        scene.triangles = scene.triangles.iter().step_by(16).copied().collect();
        scene.tex_coords.clear();
        scene.normals.clear();
        scene.triangles.iter_mut().flat_map(|triangle| &mut triangle.corners).for_each(|p| *p *= scale);
        let name = format!("pquake3 times 2^{exponent}");
        assert!(loses_nothing(&name, &scene, SplitRule::SurfaceArea, 400) > 100);
    }
}

#[test]
#[ignore = "long: exact arithmetic by the minute; SAARCOR_SCENES names their folder"]
fn real_scenes_lose_no_hit() {
    let folder = PathBuf::from(std::env::var_os("SAARCOR_SCENES").expect("SAARCOR_SCENES names a folder"));
    for name in ["oa_dm3", "conference", "conference_raw", "office", "sponza"] {
        let path = folder.join(name).join(name).with_extension("obj");
        let loaded = saarcor_scenes::load_obj(&path, Default::default()).expect("scene");
        assert!(loses_nothing(name, &loaded.scene, SplitRule::SurfaceArea, 1_000) > 500);
    }
}
