//! That an export reads back the same, or is rejected and leaves nothing. Each test writes its own files.

#![allow(clippy::unwrap_used)] // A test may fail by a panic.

mod files;

use std::fs;
use std::path::{Path, PathBuf};

use files::{folder, load, message};
use glam::{Vec3, vec2, vec3};
use proptest::prelude::*;
use saarcor_model::host::{Camera, Light, Material, Scene, TexelFormat, Texture, Triangle};
use saarcor_scenes::export_obj;

/// A scene of every kind of material, number and image.
fn full_scene() -> Scene {
    let plain = Material { diffuse: vec3(0.1, f32::MIN_POSITIVE, 1.0 / 3.0), ..Material::default() };
    let textured = Material { texture: Some(2), bump: Some(0), bump_height: 0.7, ..plain };
    let shiny = Material { specular: vec3(0.1, 0.2, 0.3), shininess: 12.5, ..plain };
    let mirror = Material { specular: Vec3::splat(0.3), reflection: 0.3, texture: Some(1), ..plain };
    let glass = Material { refraction: 0.1, index_of_refraction: 1.52, ..plain };
    let window = Material { refraction: 0.7, ..mirror };
    let materials = vec![plain, textured, shiny, mirror, glass, window];
    let triangles = (0..12u32)
        .map(|index| {
            let x = index as f32 / 7.0;
            let corners = [vec3(x, -0.0, 1e-30), vec3(x + 0.1, 1e30, -1.0), vec3(0.0, 1.0, 16_777_216.0)];
            Triangle { corners, material: index % 6 }
        })
        .collect::<Vec<_>>();
    let colours = |width: u32, height: u32| Texture {
        width,
        height,
        format: TexelFormat::Rgba8,
        texels: (0..width * height * 4).map(|i| (i * 7) as u8).collect(),
    };
    let heights =
        Texture { width: 3, height: 2, format: TexelFormat::Height8, texels: vec![0, 9, 3, 255, 1, 2] };
    let dir = vec3(0.3, -0.2, 0.9).normalize();
    let up = dir.cross(Vec3::X).normalize();
    Scene {
        tex_coords: triangles.iter().map(|t| t.corners.map(|c| vec2(c.x, -c.x / 3.0))).collect(),
        normals: triangles.iter().map(|t| t.corners.map(|c| vec3(c.x, 2.0, 0.1))).collect(),
        triangles,
        materials,
        textures: vec![heights, colours(1, 1), colours(4, 3)],
        lights: vec![Light { position: vec3(0.1, 0.2, 0.3), intensity: 0.7 }],
        path: vec![Camera { eye: vec3(1.0, 2.0, 3.0), dir, up, fov_y_deg: 59.9 }; 3],
        ..Scene::default()
    }
}

/// Exports a scene and loads it again.
fn round_trip(scene: &Scene) -> Scene {
    let files = folder(&[]);
    let path = files.path().join("two words.obj");
    export_obj(scene, &path).unwrap();
    load(&path).unwrap()
}

#[test]
fn an_export_reads_back_the_same() {
    let scene = full_scene();
    let read = round_trip(&scene);
    assert_eq!(read, scene);
    // Equal floats may differ in the sign of zero.
    assert_eq!(format!("{read:?}"), format!("{scene:?}"));
}

#[test]
fn an_export_without_textures_normals_and_lights_reads_back_the_same() {
    let mut scene = full_scene();
    scene.lights.clear();
    scene.normals.clear();
    assert_eq!(round_trip(&scene), scene);
    scene.tex_coords.clear();
    scene.textures.clear();
    for material in &mut scene.materials {
        *material = Material { texture: None, bump: None, bump_height: 0.0, ..*material };
    }
    assert_eq!(round_trip(&scene), scene);
}

#[test]
fn an_export_leaves_out_images_that_no_triangle_shows() {
    let mut scene = full_scene();
    scene.triangles.iter_mut().for_each(|triangle| triangle.material = 3);
    let read = round_trip(&scene);
    assert_eq!(read.textures, [scene.textures[1].clone()]);
    assert_eq!(read.materials, [Material { texture: Some(0), ..scene.materials[3] }]);
    assert_eq!(read.triangles.len(), scene.triangles.len());
}

#[test]
fn an_export_replaces_its_files_and_leaves_no_others() {
    let files = folder(&[("camera.csv", b"old"), ("a.obj", b"old")]);
    export_obj(&full_scene(), &files.path().join("a.obj")).unwrap();
    let expected = ["a-0.png", "a-1.png", "a-2.png", "a.mtl", "a.obj", "camera.csv", "lights.csv"];
    assert_eq!(names(files.path()), expected);
    assert_eq!(load(&files.path().join("a.obj")).unwrap(), full_scene());
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_failed_export_leaves_nothing_behind() {
    let files = folder(&[]);
    fs::create_dir(files.path().join("a.obj")).unwrap();
    let error = message(export_obj(&full_scene(), &files.path().join("a.obj")));
    assert!(error.starts_with("a.obj: cannot be written: "), "{error}");
    assert_eq!(names(files.path()), ["a.obj"]);

    let error = message(export_obj(&full_scene(), &files.path().join("none/a.obj")));
    assert_eq!(error, "a.obj: no file can be written to the folder (entity not found)");
    let error = message(export_obj(&full_scene(), &files.path().join("a.mtl")));
    assert!(error.starts_with("a.mtl: the name must end in .obj"), "{error}");
    assert_eq!(names(files.path()), ["a.obj"]);
}

#[test]
fn scenes_that_an_obj_cannot_hold_are_rejected() {
    let check = |change: fn(&mut Scene)| {
        let mut scene = full_scene();
        change(&mut scene);
        let files = folder(&[]);
        let error = message(export_obj(&scene, &files.path().join("a.obj")));
        assert_eq!(names(files.path()), [""; 0]);
        error.strip_prefix("a.obj: the scene cannot be exported: ").unwrap().to_owned()
    };
    assert_eq!(check(|s| s.triangles.clear()), "it has no triangles");
    assert_eq!(check(|s| s.path.clear()), "camera.csv: has no frames: a row is needed at least");
    assert_eq!(
        check(|s| s.path[1].up *= 1.0001),
        "frame 1: dir and up are not unit vectors at a right angle"
    );
    assert_eq!(
        check(|s| s.triangles[0].corners[1].y = f32::NAN),
        "a position, normal or texture coordinate is not finite"
    );
    assert_eq!(check(|s| s.triangles[1].material = 6), "triangle 1 has material 6, which is not there");
    assert_eq!(
        check(|s| s.materials[1].bump = Some(1)),
        "material 1 needs a Height8 image, and image 1 is none"
    );
    assert_eq!(
        check(|s| {
            s.normals.pop();
        }),
        "11 triangles have normals: all or none are needed"
    );
    assert_eq!(
        check(|s| s.materials[2].reflection = 0.5),
        "material 2: reflection is 0.5, refraction 0 and shininess 12.5; an MTL file can state a reflection \
         that is 0 or the mean of specular, a refraction from 0 to 1 that is with it at most 1, and a \
         shininess that is 0 only without highlights"
    );
    assert_eq!(
        check(|s| s.materials[0].diffuse.x = f32::INFINITY),
        "its MTL:2: Kd: \"inf\" is not finite in 32 bits, and must be"
    );
    assert_eq!(check(|s| s.lights[0].intensity = -1.0), "lights.csv:2: intensity -1: 0 or more is needed");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_float_reads_back_the_same(bits in prop::collection::vec(any::<u32>(), 9)) {
        let floats: Vec<f32> = bits.into_iter().map(f32::from_bits).collect();
        prop_assume!(floats.iter().all(|float| float.is_finite()));
        let mut scene = full_scene();
        let (corners, _) = floats.as_chunks::<3>();
        scene.triangles[0].corners = [0, 1, 2].map(|corner: usize| corners[corner].into());
        prop_assert_eq!(format!("{:?}", round_trip(&scene)), format!("{scene:?}"));
    }
}

// ---- Real scenes

/// A scene of the folder that the environment names.
fn real(name: &str) -> PathBuf {
    let folder = std::env::var_os("SAARCOR_SCENES").expect("SAARCOR_SCENES names a folder");
    Path::new(&folder).join(name).join(format!("{name}.obj"))
}

/// Triangles, those without area, images, their decoded bytes, frames and lights.
fn counts(scene: &Scene) -> (usize, usize, usize, usize, usize, usize) {
    (
        scene.triangles.len(),
        scene.triangles.iter().filter(|triangle| triangle.is_degenerate()).count(),
        scene.textures.len(),
        scene.textures.iter().map(|image| image.texels.len()).sum(),
        scene.path.len(),
        scene.lights.len(),
    )
}

macro_rules! real_scenes {
    ($($name:ident: $counts:expr;)*) => {$(
        #[test]
        #[ignore = "needs SAARCOR_SCENES, a folder with the unpacked real scenes"]
        fn $name() {
            let scene = load(&real(stringify!($name))).unwrap();
            assert_eq!(counts(&scene), $counts);
            assert_eq!(format!("{:?}", round_trip(&scene)), format!("{scene:?}"));
        }
    )*};
}

real_scenes! {
    oa_dm3: (46_356, 146, 52, 26_083_328, 1140, 1);
    conference: (277_552, 0, 0, 0, 402, 8);
    conference_raw: (331_179, 53_627, 0, 0, 402, 8);
    office: (34_000, 1, 0, 0, 200, 3);
    sponza: (66_450, 6, 0, 0, 300, 2);
}
