//! The recorded frame of `saarcor-kd` is what the chip asks for in a frame of a built-in scene.
//! `SAARCOR_WRITE_LISTS=1` writes it.

use glam::Vec3;
use saarcor_kit::kd::Kd;
use saarcor_kit::kd::generated_scene::GeneratedScene;
use saarcor_kit::kd::request::push_ray;
use saarcor_kit::kind::Kind as _;
use saarcor_kit::session::Session;
use saarcor_model::host::{Kernel, TRIANGLE_BYTES};
use saarcor_model::rays::{Cones, Frame, Hits, Packet, Query, Ray, Traversal, shadow_ray, surfaces};
use saarcor_model::vm::{HostAddr, Observed, Observer, Unit, WholeScene};
use saarcor_random::Random;
use saarcor_studies::monitor::Silent;
use saarcor_studies::world::{World, WorldOptions};
use std::collections::BTreeSet;
use std::path::Path;

/// The frame, and pixels a row and rows: as few as give a scene that is small to store.
const FRAME: usize = 150;
const PICTURE: (u32, u32) = (24, 18);
/// Triangles of a leaf, and the greatest depth, of the tree over the triangles that rays are tested against.
const LEAVES: (usize, u32) = (4, 48);

/// Notes the triangles that are read.
#[derive(Default)]
struct Triangles(BTreeSet<u32>);

impl Observer for Triangles {
    fn read(&mut self, unit: Unit, addr: HostAddr, _bytes: usize) {
        if unit == Unit::Intersection {
            self.0.insert(addr.0);
        }
    }
}

/// The primary rays of a picture, and of each the shadow ray to the first light where it hits something; over the
/// triangles that the chip tests them against.
fn recorded() -> Vec<u8> {
    let options = WorldOptions { kernel: Kernel::MollerTrumbore, ..WorldOptions::new("pquake3-nt") };
    let world = World::open(&options, &Silent).expect("a built-in scene");
    let registers = &world.image.registers;
    let frame = Frame::new(&world.path[FRAME], PICTURE.0, PICTURE.1);
    let mut memory = Observed { memory: WholeScene(&world.image.bytes), observer: Triangles::default() };
    let mut traversal = Traversal::<1, _>::default();
    let mut rays: Vec<(Query, Ray)> = Vec::new();
    for (x, y) in (0..PICTURE.1).flat_map(|y| (0..PICTURE.0).map(move |x| (x, y))) {
        let ray = frame.primary_ray(x, y);
        let packet = Packet::new([Some(ray)]);
        let hits: Hits<1> = traversal.run(&mut memory, registers, &packet, Query::Closest);
        rays.push((Query::Closest, ray));
        let cones = Cones { spread: 0.0, begin: [0.0] };
        let [surface] = surfaces(&mut memory, registers, &packet, &hits, &cones);
        if let Some(surface) = surface {
            let shadow = shadow_ray(&surface, &registers.lights[0]);
            traversal.run(&mut memory, registers, &Packet::new([Some(shadow)]), Query::Any);
            rays.push((Query::Any, shadow));
        }
    }
    let corners = |addr: &u32| {
        let bytes = &world.image.bytes[*addr as usize..][..TRIANGLE_BYTES as usize];
        let words: Vec<f32> = bytes.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
        std::array::from_fn(|corner| Vec3::from_slice(&words[3 * corner..]))
    };
    let triangles: Vec<[Vec3; 3]> = memory.observer.0.iter().map(corners).collect();
    let scene = GeneratedScene::with_leaves(&triangles, LEAVES, &mut Random::new(0));
    let mut text = scene.requests();
    rays.iter().for_each(|(query, ray)| push_ray(&mut text, *query, ray));
    Session::new("kd/frame/pquake3-nt-150", Kd.hello(), "kernel=moller-trumbore", &text).to_suite()
}

#[test]
fn recorded_frame_is_that_of_the_scene() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../suites/kd/frame/pquake3-nt-150.txt");
    let expected = recorded();
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        std::fs::write(&file, &expected).expect("written");
    }
    let kept = std::fs::read(&file).expect("a file of the kit");
    assert!(kept == expected, "{} is no longer what the scene gives", file.display());
}
