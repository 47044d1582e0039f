//! The recorded frames of `saarcor-kd` and `saarcor-chip` are what the chip asks for, and what its packets do, in a frame
//! of a built-in scene. `SAARCOR_WRITE_LISTS=1` writes them.

use glam::Vec3;
use saarcor_kit::chip::Chip;
use saarcor_kit::chip::request::Request;
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
use saarcor_studies::simulate::record;
use saarcor_studies::standard::MAX_BOUNCES;
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};
use std::collections::BTreeSet;
use std::path::Path;

const SCENE: &str = "pquake3-nt";
const FRAME: usize = 150;
/// Pixels a row and rows of the rays: as few as give a scene that is small to store.
const RAYS: (u32, u32) = (24, 18);
/// Triangles of a leaf, and the greatest depth, of the tree over the triangles that rays are tested against.
const LEAVES: (usize, u32) = (4, 48);
/// Pixels a row and rows of the packets: as few as give more packets, after those of the earlier picture, than the small
/// chip has threads.
const PACKETS: (u32, u32) = (32, 24);
/// The standard chip, without the place of the triangles, and what others have in its place: a small one, whose
/// first-level caches, memory of 32 KB and metadata cache evict, and one without virtual memory.
const CHIP: &str = "pipelines=4 threads=16 s-sets=256 n-sets=2048 l-sets=4096 t-sets=1024 \
    version=a lines=65536 meta-sets=1024";
const OTHER_CHIPS: [&str; 2] = [
    "pipelines=2 threads=2 s-sets=4 n-sets=64 l-sets=64 t-sets=16 version=b lines=256 meta-sets=4",
    "version=none",
];

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
fn recorded_rays(name: &str) -> Vec<u8> {
    let options = WorldOptions { kernel: Kernel::MollerTrumbore, ..WorldOptions::new(SCENE) };
    let world = World::open(&options, &Silent).expect("a built-in scene");
    let registers = &world.image.registers;
    let frame = Frame::new(&world.path[FRAME], RAYS.0, RAYS.1);
    let mut memory = Observed { memory: WholeScene(&world.image.bytes), observer: Triangles::default() };
    let mut traversal = Traversal::<1, _>::default();
    let mut rays: Vec<(Query, Ray)> = Vec::new();
    for (x, y) in (0..RAYS.1).flat_map(|y| (0..RAYS.0).map(move |x| (x, y))) {
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
    Session::new(name, Kd.hello(), "kernel=moller-trumbore", &text).to_suite()
}

/// The packets of a picture: those of its second half alone, and then with those of the first as an earlier picture.
fn recorded_packets(name: &str) -> Vec<u8> {
    let world = World::open(&WorldOptions::new(SCENE), &Silent).expect("a built-in scene");
    let options = TraceOptions { resolution: PACKETS, packet: PacketSize::Rays64, max_bounces: MAX_BOUNCES };
    let programs = record(&world, FRAME, &options, PacketOrder::Scan).programs;
    let (first, second) = programs.packets.split_at(programs.packets.len() / 2);
    let mut requests: Vec<Request> = second.iter().map(|packet| Request::Packet(packet.to_vec())).collect();
    requests.push(Request::Run);
    requests.extend(first.iter().map(|packet| Request::Before(packet.to_vec())));
    requests.push(Request::Run);
    let text: String = requests.iter().map(|request| format!("{request}\n")).collect();
    let config = format!("{CHIP} triangles={}", programs.triangles.0);
    let mut suite = OTHER_CHIPS.map(|chip| format!("#: also {chip}\n")).concat().into_bytes();
    suite.extend(Session::new(name, Chip.hello(), &config, text.as_bytes()).to_suite());
    suite
}

/// The file of a suite is what `recorded` makes.
fn is_recorded(name: &str, recorded: fn(&str) -> Vec<u8>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../suites/{name}.txt"));
    let expected = recorded(name);
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        std::fs::write(&file, &expected).expect("written");
    }
    let kept = std::fs::read(&file).expect("a file of the kit");
    assert!(kept == expected, "{} is no longer what the scene gives", file.display());
}

#[test]
fn recorded_rays_are_those_of_the_scene() {
    is_recorded("kd/frame/pquake3-nt-150", recorded_rays);
}

#[test]
fn recorded_packets_are_those_of_the_scene() {
    is_recorded("chip/frame/pquake3-nt-150", recorded_packets);
}
