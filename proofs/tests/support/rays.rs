//! What tests of rays share: images of scenes, memory that is watched, and the search over all triangles.

use glam::Vec3;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use saarcor_model::host::{HostImage, KdTree, Kernel, Material, NODE_BYTES, Scene, TRIANGLE_BYTES, Triangle};
use saarcor_model::rays::{EdgeTriangle, Hits, Packet, Query, Ray, Traversal, TriangleTest};
use saarcor_model::vm::{HostAddr, Observed, Observer, Unit};
use saarcor_oracles::flat::FlatMemory;
use saarcor_oracles::search::closest_hit;

pub fn lay_out_for(triangles: Vec<Triangle>, tree: &KdTree, kernel: Kernel) -> HostImage {
    let scene = Scene { triangles, materials: vec![Material::default()], ..Scene::default() };
    HostImage::build(&scene, tree, kernel).expect("a valid tree")
}

pub fn lay_out(triangles: Vec<Triangle>, tree: &KdTree) -> HostImage {
    lay_out_for(triangles, tree, Kernel::MollerTrumbore)
}

/// Notes the nodes that are read, with the rays for which they are, and counts entries and triangles.
#[derive(Default)]
pub struct Reads {
    pub nodes: Vec<u32>,
    pub rays: u64,
    pub entries: usize,
    pub triangles: usize,
}

impl Observer for Reads {
    fn operation(&mut self, unit: Unit, rays: u32) {
        if unit == Unit::Traversal {
            self.rays += u64::from(rays);
        }
    }

    fn read(&mut self, unit: Unit, addr: HostAddr, _bytes: usize) {
        match unit {
            Unit::Traversal => self.nodes.push(addr.0 / NODE_BYTES),
            Unit::List => self.entries += 1,
            Unit::Intersection => self.triangles += 1,
            Unit::Shading => {}
        }
    }
}

/// The host's memory, read under observation.
pub fn observed(image: &HostImage) -> Observed<FlatMemory<'_>, Reads> {
    Observed { memory: FlatMemory::new(&image.bytes), observer: Reads::default() }
}

/// Distance and address of the hit that the search finds: of several at one distance, the one at
/// the lowest address.
pub fn search(triangles: &[Triangle], image: &HostImage, ray: &Ray) -> Option<(f32, u32)> {
    let closest = closest_hit(triangles, |triangle| distance(triangle, ray))?;
    let place = image.triangle_ids.iter().position(|id| closest.triangles.contains(id));
    let place = place.expect("each triangle is in a list") as u32;
    Some((closest.t, image.registers.triangles.0 + place * TRIANGLE_BYTES))
}

pub fn distance(triangle: &Triangle, ray: &Ray) -> Option<f32> {
    let from = EdgeTriangle::<f32>::ray(ray.origin.to_array(), ray.direction.to_array());
    let found = EdgeTriangle::new(&triangle.corners).intersect::<false>(&from);
    (found.inside && found.t >= ray.t_min && found.t < ray.t_max).then_some(found.t)
}

/// Both queries of one packet against the search; returns the number of hits.
pub fn agrees<const N: usize>(
    traversal: &mut Traversal<N>,
    triangles: &[Triangle],
    image: &HostImage,
    rays: &[Option<Ray>; N],
) -> Result<usize, TestCaseError> {
    let packet = Packet::new(*rays);
    let mut memory = observed(image);
    let closest: Hits<N> = traversal.run(&mut memory, &image.registers, &packet, Query::Closest);
    memory.observer.nodes.sort_unstable();
    prop_assert!(
        memory.observer.nodes.is_sorted_by(|a, b| a < b),
        "a node is read twice: {:?}",
        memory.observer.nodes
    );
    let any = traversal.run(&mut memory, &image.registers, &packet, Query::Any);
    let mut hits = 0;
    for (lane, ray) in rays.iter().enumerate() {
        let expected = ray.and_then(|ray| search(triangles, image, &ray));
        let found = closest.is_hit(lane).then(|| (closest.t[lane], closest.triangle[lane]));
        prop_assert_eq!(found, expected, "closest hit of {:?}", ray);
        prop_assert_eq!(any.is_hit(lane), expected.is_some(), "any hit of {:?}", ray);
        if let (true, Some(ray)) = (any.is_hit(lane), ray) {
            let id = image.triangle_id(HostAddr(any.triangle[lane]));
            let triangle = &triangles[id as usize];
            prop_assert!(distance(triangle, ray).is_some(), "{:?} does not hit {:?}", ray, triangle);
            prop_assert_eq!(any.t[lane], f32::NEG_INFINITY, "any hit of {:?}", ray);
            hits += 1;
        }
    }
    Ok(hits)
}

/// A triangle across the x axis.
pub fn across(x: f32) -> Triangle {
    let corners = [Vec3::new(x, -9.0, -9.0), Vec3::new(x, 9.0, -9.0), Vec3::new(x, 0.0, 9.0)];
    Triangle { corners, material: 0 }
}

/// A ray along the x axis.
pub fn along(x: f32, direction: f32) -> Ray {
    let (origin, direction) = (Vec3::X * x, Vec3::X * direction);
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}
