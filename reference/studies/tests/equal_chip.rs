//! The chip between events is the specification's to the cycle on the packets of a picture.

use rayon::prelude::*;
use saarcor_model::host::{HostImage, Kernel};
use saarcor_model::rays::{Frame, Pipeline};
use saarcor_model::time::standard::{PACKET_RAYS, POLICY};
use saarcor_model::time::{ChipConfig, MetadataCacheConfig, Programs, Recorder, Version};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Observed, WholeScene};
use saarcor_scenes::builtin::builtin;
use saarcor_scenes::kdbuild::{self, BuildOptions};

/// What the packets of a small picture of a built-in scene do.
fn picture() -> Programs {
    let scene = builtin("pquake3-nt").expect("a built-in scene");
    let tree = kdbuild::build(&scene.triangles, &BuildOptions::default(), &|_| ());
    let image = HostImage::build(&scene, &tree, Kernel::default()).expect("a valid tree");
    let frame = Frame::new(&scene.path[0], 64, 48);
    let mut memory = Observed { memory: WholeScene(&image.bytes), observer: Recorder::default() };
    let mut pipeline = Pipeline::<PACKET_RAYS>::new(Pipeline::<PACKET_RAYS>::STANDARD_BOUNCES);
    let (columns, rows) = frame.tiles::<PACKET_RAYS>();
    let program = |packet| {
        pipeline.render(&mut memory, &image.registers, &frame, packet);
        memory.observer.take()
    };
    let packets = (0..columns * rows).map(program).collect();
    Programs { packets, triangles: image.registers.triangles }
}

/// On the standard chip and on a small one, cold and warm.
#[test]
fn fast_chip_is_the_specifications_on_a_picture() {
    let picture = picture();
    let operations = picture.in_order().count();
    assert!(operations > 1_000, "{operations} operations");
    let before = Programs {
        packets: picture.packets[..picture.packets.len() / 2].to_vec(),
        triangles: picture.triangles,
    };
    let cache = |memory| CacheConfig {
        geometry: Geometry::new(Bytes(memory), Bytes(128), 4).expect("legal"),
        hash: Hash::default(),
        policy: POLICY,
    };
    let versions = [Version::None, Version::A, Version::B];
    let chips: Vec<(bool, ChipConfig)> = versions
        .into_iter()
        .flat_map(|version| {
            let standard = ChipConfig::standard(version, cache(8 << 20));
            let small = ChipConfig {
                pipelines: 2,
                threads: 3,
                metadata_cache: MetadataCacheConfig { bytes: 256, granule: 16 },
                ..ChipConfig::standard(version, cache(32 << 10))
            };
            [(true, standard), (false, small)]
        })
        .collect();
    chips.par_iter().for_each(|(is_warm, config)| {
        let before = if *is_warm { std::slice::from_ref(&before) } else { &[] };
        let fast = saarcor_fast::chip::simulate(before, &picture, config).expect("a chip");
        let specified = saarcor_model::time::simulate(before, &picture, config).expect("a chip");
        assert_eq!(fast, specified, "{config:?}");
    });
}
