//! What the pipeline makes of rays that follow one another (RG-4 to RG-6): a packet of 64 is as each of its rays alone,
//! and the colours and numbers of rays are those that can be counted by hand.

mod support;

use glam::Vec3;
use proptest::collection::vec;
use proptest::prelude::*;
use saarcor_model::host::{Aabb, Camera, HostImage, KdTree, Kernel, Light, Material, Node, Scene, Triangle};
use saarcor_model::rays::{AMBIENT, BACKGROUND, Frame, Pipeline, RayCounts};
use saarcor_model::vm::Observed;
use saarcor_oracles::flat::FlatMemory;
use support::engine;

/// Two triangles across the z axis, seen from both sides.
fn wall(z: f32, half: f32, material: u32) -> [Triangle; 2] {
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, z);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    [Triangle { corners: [a, b, c], material }, Triangle { corners: [a, c, d], material }]
}

/// The scene in host memory, with a tree of one leaf.
fn image(scene: &Scene, kernel: Kernel) -> HostImage {
    let bounds = Aabb::around(scene.triangles.iter().flat_map(|triangle| triangle.corners));
    let count = scene.triangles.len() as u32;
    let tree = KdTree { bounds, nodes: vec![Node::Leaf { first: 0, count }], refs: (0..count).collect() };
    HostImage::build(scene, &tree, kernel).expect("a valid tree")
}

/// A camera at the origin that looks upwards along z, and sees little beside the axis.
fn camera() -> Camera {
    Camera { eye: Vec3::ZERO, dir: Vec3::Z, up: Vec3::Y, fov_y_deg: 0.01 }
}

/// The colours of all pixels, row by row, and the rays that were traced.
fn picture<const N: usize>(image: &HostImage, frame: &Frame, max_bounces: u32) -> (Vec<[u32; 3]>, RayCounts) {
    let mut pipeline = Pipeline::<N>::new(max_bounces);
    let mut memory = Observed::by_nobody(FlatMemory::new(&image.bytes));
    let mut pixels = vec![[0; 3]; (frame.width() * frame.height()) as usize];
    for packet in 0..frame.packets::<N>() {
        let colours = pipeline.render(&mut memory, &image.registers, frame, packet);
        for (colour, pixel) in colours.into_iter().zip(frame.pixels::<N>(packet)) {
            if let Some((x, y)) = pixel {
                pixels[(y * frame.width() + x) as usize] = colour.to_array().map(f32::to_bits);
            }
        }
    }
    (pixels, pipeline.rays)
}

/// The colour of the one pixel along the z axis, and the rays that were traced.
fn pixel(image: &HostImage, max_bounces: u32) -> (Vec3, RayCounts) {
    let (pixels, rays) = picture::<1>(image, &Frame::new(&camera(), 1, 1), max_bounces);
    (Vec3::from_array(pixels[0].map(f32::from_bits)), rays)
}

fn is_near(found: Vec3, expected: Vec3) -> bool {
    (found - expected).abs().max_element() < 1e-5
}

fn materials() -> impl Strategy<Value = Material> {
    let part = || prop_oneof![Just(0.0_f32), Just(0.01), Just(0.25), Just(0.5)];
    let colour = [0.1..1.0_f32, 0.1..1.0_f32, 0.1..1.0_f32].prop_map(Vec3::from);
    (colour, part(), part(), any::<bool>()).prop_map(|(diffuse, reflection, refraction, shiny)| Material {
        diffuse,
        specular: if shiny { Vec3::ONE } else { Vec3::ZERO },
        shininess: 8.0,
        reflection,
        refraction,
        index_of_refraction: 1.5,
        ..Material::default()
    })
}

fn corner() -> impl Strategy<Value = Vec3> {
    [-4.0..4.0_f32, -4.0..4.0_f32, 1.0..6.0_f32].prop_map(Vec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: engine().cases.min(64), ..engine() })]

    /// Each pixel has the same colour, bit for bit, whether its ray is traced in a packet of 64, 16 or alone; the rays
    /// that are traced are as many.
    #[test]
    fn pixels_do_not_depend_on_the_packet(
        corners in vec(([corner(), corner(), corner()], 0..3_u32), 4..24),
        materials in [materials(), materials(), materials()],
        lights in vec((corner(), 0.1..0.9_f32), 0..3),
        kernel in 0..5_usize,
        (width, height) in (1..11_u32, 1..11_u32),
        max_bounces in 0..4_u32,
    ) {
        let triangle = |(corners, material): ([Vec3; 3], u32)| Triangle { corners, material };
        let triangles: Vec<_> = corners.into_iter().map(triangle).filter(|it| !it.is_degenerate()).collect();
        let lights = lights.into_iter().map(|(position, intensity)| Light { position: position - Vec3::Z * 2.0, intensity });
        let scene = Scene { triangles, materials: materials.to_vec(), lights: lights.collect(), ..Scene::default() };
        let image = image(&scene, Kernel::ALL[kernel]);
        let frame = Frame::new(&Camera { eye: Vec3::NEG_Z, fov_y_deg: 70.0, ..camera() }, width, height);
        let alone = picture::<1>(&image, &frame, max_bounces);
        prop_assert_eq!(&picture::<64>(&image, &frame, max_bounces), &alone);
        prop_assert_eq!(&picture::<16>(&image, &frame, max_bounces), &alone);
        prop_assert_eq!(alone.1.primary, u64::from(width * height));
    }
}

/// A mirror before the camera and one behind it.
fn mirrors(reflection: f32) -> HostImage {
    let material = |diffuse| Material { diffuse, reflection, ..Material::default() };
    let scene = Scene {
        triangles: wall(4.0, 3.0, 0).into_iter().chain(wall(-4.0, 2.0, 1)).collect(),
        materials: vec![material(Vec3::new(1.0, 0.5, 0.0)), material(Vec3::new(0.0, 0.25, 1.0))],
        ..Scene::default()
    };
    image(&scene, Kernel::Adaptive)
}

/// Reflections follow one another up to the limit, and while they are at least 1/256 of their pixel's light; what they
/// see takes the place of that part of a surface's own colour.
#[test]
fn reflections_end_at_their_limit_and_where_little_is_left() {
    let own = [Vec3::new(1.0, 0.5, 0.0), Vec3::new(0.0, 0.25, 1.0)];
    for (part, least) in [
        (0.5_f32, 8),
        (0.25, 4),
        (1.0 / 16.0, 2),
        ((1.0_f32 / 16.0).next_down(), 1),
        (1.0 / 256.0, 1),
        ((1.0_f32 / 256.0).next_down(), 0),
        (0.0, 0),
    ] {
        let image = mirrors(part);
        for max_bounces in [0, 1, 2, 3, 5, 9] {
            let (colour, rays) = pixel(&image, max_bounces);
            let bounces = max_bounces.min(least);
            assert_eq!((rays.primary, rays.shadow), (1, 0));
            assert_eq!(rays.secondary, u64::from(bounces), "{part}, up to {max_bounces}");
            assert_eq!(rays.total(), 1 + u64::from(bounces));
            // From the last surface back to the first.
            let expected = (0..bounces).rev().fold(own[bounces as usize % 2], |seen, bounce| {
                let own = own[bounce as usize % 2];
                own + (seen - own) * part
            });
            assert!(is_near(colour, expected), "{part}, up to {max_bounces}: {colour}, not {expected}");
        }
    }
}

/// A surface that reflects and refracts sends both rays, each for its own part; what is behind glass is seen straight
/// on without a change of direction.
#[test]
fn glass_shows_what_is_before_and_behind_it() {
    let glass = Material {
        diffuse: Vec3::Z,
        reflection: 0.25,
        refraction: 0.5,
        index_of_refraction: 1.5,
        ..Material::default()
    };
    let plain = Material { diffuse: Vec3::X, ..Material::default() };
    let scene = Scene {
        triangles: wall(2.0, 3.0, 0).into_iter().chain(wall(5.0, 3.0, 1)).collect(),
        materials: vec![glass, plain],
        ..Scene::default()
    };
    let (colour, rays) = pixel(&image(&scene, Kernel::Adaptive), 3);
    assert_eq!((rays.primary, rays.secondary), (1, 2));
    // The mirrored ray sees nothing.
    let expected = Vec3::Z + (BACKGROUND - Vec3::Z) * 0.25 + (Vec3::X - Vec3::Z) * 0.5;
    assert!(is_near(colour, expected), "{colour}, not {expected}");
}

/// A ray that hits nothing sees the background, and sends no ray.
#[test]
fn nothing_is_the_background() {
    let scene = Scene {
        triangles: wall(-5.0, 1.0, 0).to_vec(),
        materials: vec![Material { reflection: 0.5, ..Material::default() }],
        lights: vec![Light { position: Vec3::ZERO, intensity: 1.0 }],
        ..Scene::default()
    };
    let (colour, rays) = pixel(&image(&scene, Kernel::Adaptive), 3);
    assert_eq!((colour, rays), (BACKGROUND, RayCounts { primary: 1, ..RayCounts::default() }));
}

/// Each hit sends one shadow ray to each light, also to one behind the surface; what lies between them keeps the light
/// off, however near to either end, and what lies behind the light or is the surface itself does not.
#[test]
fn lights_are_kept_off_by_what_lies_between() {
    let floor = Material { diffuse: Vec3::new(1.0, 0.5, 0.25), ..Material::default() };
    // The surface is at z = 4 and seen from below; the light is at z = 2, straight before it.
    for (blocker, lit) in [
        (None, true),
        (Some(3.0), false),
        (Some(2.0 + 1e-4), false),
        (Some(2.0 - 1e-4), true),
        (Some(4.0 - 1e-3), false),
        (Some(4.0 + 1e-3), true),
        (Some(1.0), true),
    ] {
        let mut triangles = wall(4.0, 3.0, 0).to_vec();
        if let Some(z) = blocker {
            // Beside the axis, along which the camera looks, but before the light of the surface's other pixel.
            let corner = |x: f32, y: f32| Vec3::new(x, y, z);
            let corners = [corner(-9.0, -9.0), corner(9.0, -9.0), corner(0.0, 18.0)];
            triangles.push(Triangle { corners, material: 0 });
        }
        let lights = vec![
            Light { position: Vec3::new(0.0, 0.0, 2.0), intensity: 0.25 },
            Light { position: Vec3::new(0.0, 0.0, 9.0), intensity: 0.5 },
        ];
        let scene = Scene { triangles, materials: vec![floor], lights, ..Scene::default() };
        // From beyond the blocker, so that the surface itself is seen.
        let eye = blocker.filter(|&z| z < 4.0).map_or(0.0, |z| if z > 3.5 { 4.0 - 1e-4 } else { z + 0.5 });
        let frame = Frame::new(&Camera { eye: Vec3::Z * eye, ..camera() }, 1, 1);
        let (pixels, rays) = picture::<1>(&image(&scene, Kernel::Adaptive), &frame, 0);
        let colour = Vec3::from_array(pixels[0].map(f32::from_bits));
        assert_eq!((rays.primary, rays.shadow), (1, 2), "{blocker:?}");
        let own = floor.diffuse;
        let expected = own * AMBIENT + if lit { own * ((1.0 - AMBIENT) * 0.25) } else { Vec3::ZERO };
        assert!(is_near(colour, expected), "blocker at {blocker:?}: {colour}, not {expected}");
    }
}
