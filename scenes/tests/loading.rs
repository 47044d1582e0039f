//! Scenes from files: what is read, what is rejected and with which words. Each test writes its own
//! files.

#![allow(clippy::unwrap_used)] // A test may fail by a panic.

mod files;

use std::fs;

use files::{SQUARE, folder, load, message};
use glam::{Vec2, Vec3, vec2, vec3};
use proptest::prelude::*;
use saarcor_model::host::{Camera, Light, Material, Scene, TexelFormat, Texture};
use saarcor_scenes::{LoadOptions, Loaded, SceneError, load_obj, read_cameras, read_lights};

const CAMERA_HEADER: &str = "frame,eye_x,eye_y,eye_z,dir_x,dir_y,dir_z,up_x,up_y,up_z,fov_y_deg\n";

fn load_files(files: &[(&str, &[u8])]) -> Result<Scene, SceneError> {
    load(&folder(files).path().join("a.obj"))
}

fn load_text(obj: &str) -> Result<Scene, SceneError> {
    load_files(&[("a.obj", obj.as_bytes())])
}

/// Loads the square with these statements below it.
fn load_square(statements: &str) -> Result<Scene, SceneError> {
    load_text(&format!("{SQUARE}{statements}"))
}

/// Loads a triangle of material `m`, which has these statements.
fn load_material(statements: &str) -> Result<Scene, SceneError> {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
    let mtl = format!("newmtl m\n{statements}\n");
    load_files(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())])
}

/// The number of a corner of [`SQUARE`], from 1.
fn corner_number(corner: Vec3) -> usize {
    1 + SQUARE
        .lines()
        .filter(|line| line.starts_with("v "))
        .position(|line| line == format!("v {} {} {}", corner.x, corner.y, corner.z))
        .unwrap()
}

fn corner_numbers(scene: &Scene) -> Vec<[usize; 3]> {
    scene.triangles.iter().map(|triangle| triangle.corners.map(corner_number)).collect()
}

fn png(width: u32, height: u32, texels: &[u8]) -> Vec<u8> {
    let colour = match texels.len() / (width * height) as usize {
        1 => image::ExtendedColorType::L8,
        3 => image::ExtendedColorType::Rgb8,
        _ => image::ExtendedColorType::Rgba8,
    };
    let mut file = std::io::Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut file, texels, width, height, colour, image::ImageFormat::Png)
        .unwrap();
    file.into_inner()
}

// ---- Geometry

#[test]
fn polygons_become_fans() {
    let scene = load_square("f 1 2 3 4\n").unwrap();
    assert_eq!(corner_numbers(&scene), [[1, 2, 3], [1, 3, 4]]);
    let long = load_square(&format!("f{}\n", " 1 2 3".repeat(1000))).unwrap();
    assert_eq!(long.triangles.len(), 2998);
}

#[test]
fn faces_are_read_however_they_are_written() {
    for (spelling, faces) in [
        ("indices", "f 1 2 3"),
        ("negative indices", "f -4 -3 -2"),
        ("all parts", "f 1/1/1 2/2/1 3/1/1"),
        ("no texture coordinates", "f 1//1 2//1 3//1"),
        ("empty parts", "f 1// 2// 3//"),
        ("tabs", "\tf\t1\t2\t3"),
        ("carriage returns", "f 1 2 3\r\n\r\n"),
        ("no newline at the end, and a comment", "f 1 2 3 # the only one"),
        ("continued lines", "f 1 \\\n2\\\n3\n"),
        ("comment that ends with a backslash", "# C:\\models\\\nf 1 2 3\n"),
        ("objects and groups", "o a\ng b c\ns off\nf 1 2 3\no d\n"),
    ] {
        let scene = load_square(faces).unwrap();
        assert_eq!(corner_numbers(&scene), [[1, 2, 3]], "{spelling}");
    }
}

#[test]
fn points_and_lines_make_no_triangles() {
    let scene = load_square("p 1\nl 1 2\nl 1 2 3\nl 1/1 2/2 3/1 4/1\nf 2 3 4\n").unwrap();
    assert_eq!(corner_numbers(&scene), [[2, 3, 4]]);
}

#[test]
fn triangles_without_area_stay() {
    let scene = load_square("f 1 1 2\nf 1 2 3\n").unwrap();
    assert_eq!(corner_numbers(&scene), [[1, 1, 2], [1, 2, 3]]);
    assert!(scene.triangles[0].is_degenerate());
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let scene = load_text(&format!("\u{feff}{SQUARE}f 1 2 3\n")).unwrap();
    assert_eq!(scene.triangles.len(), 1);
}

#[test]
fn homogeneous_and_coloured_positions_are_read() {
    let scene = load_text("v 2 4 6 2\nv 1 0 0 0.1 0.2 0.3\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(scene.triangles[0].corners, [vec3(1.0, 2.0, 3.0), Vec3::X, Vec3::Y]);
}

#[test]
fn texture_coordinates_and_normals_are_absent_where_no_face_has_them() {
    let scene = load_square("f 1 2 3\n").unwrap();
    assert!(scene.tex_coords.is_empty());
    assert!(scene.normals.is_empty());
}

#[test]
fn missing_texture_coordinates_are_zero_and_missing_normals_geometric() {
    let scene = load_square("f 1/2 2/1 3/2\nf 1 3 2\nvn 1 0 0\nf 1//2 2//2 3//2\n").unwrap();
    let (zero, one) = (Vec2::ZERO, vec2(1.0, 0.5));
    assert_eq!(scene.tex_coords, [[one, zero, one], [zero; 3], [zero; 3]]);
    assert_eq!(scene.normals, [[Vec3::Z; 3], [Vec3::NEG_Z; 3], [Vec3::X; 3]]);
}

#[test]
fn normals_of_length_zero_become_geometric() {
    let scene = load_square("vn 0 0 0\nf 1//2 2//2 3//1\n").unwrap();
    assert_eq!(scene.normals, [[Vec3::Z; 3]]);
}

// ---- Materials and images

#[test]
fn materials_are_those_of_the_files_and_last_the_default() {
    let obj = format!(
        "usemtl red\n{SQUARE}f 1 2 3\nmtllib a.mtl b c.mtl\nusemtl\tdark  blue\nf 1 2 3\nmtllib d.mtl e.mtl\n"
    );
    let scene = load_files(&[
        ("a.obj", obj.as_bytes()),
        ("a.mtl b c.mtl", b"newmtl red\nKd 1 0 0\n"),
        ("d.mtl", b"newmtl\tdark  blue\r\n\tKd 0 0 0.5\r\n"),
        ("e.mtl", b"newmtl unused\nmap_Kd none.png\n"),
    ])
    .unwrap();
    assert_eq!(scene.triangles.iter().map(|t| t.material).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(
        scene.materials.iter().map(|material| material.diffuse).collect::<Vec<_>>(),
        [vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 0.5)]
    );
    let plain = load_square("f 1 2 3\n").unwrap();
    assert_eq!(plain.materials, [Material::default()]);
}

#[test]
fn material_statements_are_read() {
    let scene = load_material("Kd 0.1 0.2 0.3\nKs 0.2 0.4 0.6\nNs 20\nNi 1.5\nillum 6\nd 0.5");
    let expected = Material {
        diffuse: vec3(0.1, 0.2, 0.3),
        specular: vec3(0.2, 0.4, 0.6),
        shininess: 20.0,
        reflection: 0.4,
        refraction: 0.5,
        index_of_refraction: 1.5,
        ..Material::default()
    };
    assert_eq!(scene.unwrap().materials, [expected]);
}

#[test]
fn the_illumination_model_decides_on_reflection_and_refraction() {
    for illum in 0..=10 {
        let scene = load_material(&format!("Ks 0.5 0.5 0.5\nTr 0.3\nillum {illum}")).unwrap();
        let reflection = if [3, 5, 6, 7].contains(&illum) { 0.5 } else { 0.0 };
        let refraction = if [4, 6, 7, 9].contains(&illum) { 0.3 } else { 0.0 };
        let material = scene.materials[0];
        assert_eq!((material.reflection, material.refraction), (reflection, refraction), "{illum}");
    }
}

#[test]
fn images_are_read_once_each_in_the_order_of_their_names() {
    let obj = format!(
        "mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\nusemtl n\nf 1/1 2/2 3/1\nusemtl o\nf 1 2 3\n"
    );
    let mtl = "newmtl m\nmap_Kd maps\\two words.png\nmap_Bump -bm 2.5 grey.png\n\
               newmtl n\nmap_Kd maps/two words.png\nbump grey.png\n\
               newmtl o\nmap_Kd missing.png\n";
    let files =
        folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("grey.png", &png(1, 2, &[7, 9]))]);
    fs::create_dir(files.path().join("maps")).unwrap();
    fs::write(files.path().join("maps/two words.png"), png(2, 1, &[1, 2, 3, 4, 5, 6])).unwrap();
    let scene = load(&files.path().join("a.obj")).unwrap();
    let heights = Texture { width: 1, height: 2, format: TexelFormat::Height8, texels: vec![7, 9] };
    let colours =
        Texture { width: 2, height: 1, format: TexelFormat::Rgba8, texels: vec![1, 2, 3, 255, 4, 5, 6, 255] };
    assert_eq!(scene.textures, [heights, colours]);
    let maps = |m: &Material| (m.texture, m.bump, m.bump_height);
    assert_eq!(maps(&scene.materials[0]), (Some(1), Some(0), 2.5));
    assert_eq!(maps(&scene.materials[1]), (Some(1), Some(0), 1.0));
    assert_eq!(maps(&scene.materials[2]), (None, None, 0.0));
    assert_eq!(scene.materials[0].diffuse, Vec3::ONE);

    let loaded = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap();
    let Loaded { scene: same, files: mut depends, warnings } = loaded;
    assert_eq!(warnings, []);
    depends.sort();
    depends.dedup();
    let names = ["a.mtl", "a.obj", "camera.csv", "grey.png", "lights.csv", "maps/two words.png"];
    assert_eq!((same, depends), (scene, names.map(|name| files.path().join(name)).to_vec()));
}

// ---- Cameras and lights

#[test]
fn without_camera_path_the_whole_scene_is_seen() {
    let scene = load_text("v -5 0 0\nv 5 0 1\nv 0 9 0\nf 1 2 3\n").unwrap();
    let [camera] = scene.path[..] else { panic!("{:?}", scene.path) };
    assert!(scene.lights.is_empty());
    let up_and_dir = camera.dir.dot(camera.up);
    approx::assert_abs_diff_eq!(up_and_dir, 0.0, epsilon = 1e-6);
    for corner in scene.triangles[0].corners {
        let ray = corner - camera.eye;
        let height = ray.dot(camera.up) / ray.dot(camera.dir);
        let side = ray.dot(camera.dir.cross(camera.up)) / ray.dot(camera.dir);
        let limit = (camera.fov_y_deg / 2.0).to_radians().tan();
        assert!(ray.dot(camera.dir) > 0.0 && height.abs() < limit && side.abs() < limit);
    }
}

#[test]
fn a_scene_in_one_point_has_a_camera() {
    let scene = load_text("v 1 2 3\nf 1 1 1\n").unwrap();
    assert!(scene.path[0].eye.distance(vec3(1.0, 2.0, 3.0)) > 0.5);
}

#[test]
fn cameras_and_lights_stand_beside_the_obj() {
    let camera = format!("{CAMERA_HEADER}0,1,2,3,0,0,-1,0,1,0,60\r\n\n1,4,5,6,1,0,0,0,1,0,70.5\n");
    let obj = format!("{SQUARE}f 1 2 3\n");
    let scene = load_files(&[
        ("a.obj", obj.as_bytes()),
        ("camera.csv", camera.as_bytes()),
        ("lights.csv", b"x,y,z,intensity\n1,2,3,0.5\n"),
    ])
    .unwrap();
    let first = Camera { eye: vec3(1.0, 2.0, 3.0), dir: Vec3::NEG_Z, up: Vec3::Y, fov_y_deg: 60.0 };
    let second = Camera { eye: vec3(4.0, 5.0, 6.0), dir: Vec3::X, up: Vec3::Y, fov_y_deg: 70.5 };
    assert_eq!(scene.path, [first, second]);
    assert_eq!(scene.lights, [Light { position: vec3(1.0, 2.0, 3.0), intensity: 0.5 }]);
}

#[test]
fn directions_slightly_off_are_corrected() {
    let row = format!("{CAMERA_HEADER}0,0,0,0,1.0005,0,0,0.0005,0.9996,0,60\n");
    let files = folder(&[("camera.csv", row.as_bytes())]);
    let [camera] = read_cameras(&files.path().join("camera.csv")).unwrap()[..] else { panic!() };
    assert_eq!((camera.dir, camera.up), (Vec3::X, Vec3::Y));
}

#[test]
fn wrong_camera_rows_are_named() {
    let check = |content: &str| {
        let files = folder(&[("camera.csv", content.as_bytes())]);
        message(read_cameras(&files.path().join("camera.csv")))
    };
    let row = |row: &str| check(&format!("{CAMERA_HEADER}0,0,0,0,0,0,-1,0,1,0,60\n{row}\n"));
    let expected = "camera.csv:3: 10 fields: 11 are needed \
                    (frame,eye_x,eye_y,eye_z,dir_x,dir_y,dir_z,up_x,up_y,up_z,fov_y_deg)";
    assert_eq!(row("1,0,0,0,0,0,-1,0,1,0"), expected);
    assert_eq!(
        row("2,0,0,0,0,0,-1,0,1,0,60"),
        "camera.csv:3: frame \"2\": 1 is needed, as frames count from 0 without gaps"
    );
    assert_eq!(row("1,0,a,0,0,0,-1,0,1,0,60"), "camera.csv:3: eye_y: \"a\" is not a number");
    assert_eq!(
        row("1,0,0,0,0,NaN,-1,0,1,0,60"),
        "camera.csv:3: dir_y: \"NaN\" is not finite in 32 bits, and must be"
    );
    assert_eq!(row("1,0,0,0,0,0,0,0,1,0,60"), "camera.csv:3: dir has length 0: a unit vector is needed");
    assert_eq!(row("1,0,0,0,0,0,-1,0,2,0,60"), "camera.csv:3: up has length 2: a unit vector is needed");
    assert_eq!(
        row("1,0,0,0,0,0,-1,0,0,1,60"),
        "camera.csv:3: dir and up meet at 180 degrees: a right angle is needed"
    );
    for fov in ["0", "180", "-60"] {
        let expected = "more than 0 and less than 180 is needed";
        let row = row(&format!("1,0,0,0,0,0,-1,0,1,0,{fov}"));
        assert_eq!(row, format!("camera.csv:3: fov_y_deg {fov}: {expected}"));
    }
    assert_eq!(check(CAMERA_HEADER), "camera.csv: has no frames: a row is needed at least");
    assert!(check("").starts_with("camera.csv:1: the header is \"\": frame,eye_x,"));
    assert!(check("0,0,0,0,0,0,-1,0,1,0,60\n").starts_with("camera.csv:1: the header is \"0,0,"));
}

#[test]
fn wrong_light_rows_are_named() {
    let check = |content: &str| {
        let files = folder(&[("lights.csv", content.as_bytes())]);
        read_lights(&files.path().join("lights.csv"))
    };
    let row = |row: &str| message(check(&format!("x,y,z,intensity\n{row}\n")));
    assert_eq!(row("1,2,3"), "lights.csv:2: 3 fields: 4 are needed (x,y,z,intensity)");
    assert_eq!(row("1,2,3,-0.5"), "lights.csv:2: intensity -0.5: 0 or more is needed");
    assert_eq!(row("1,2,3,nan"), "lights.csv:2: intensity: \"nan\" is not finite in 32 bits, and must be");
    assert_eq!(row("1,,3,1"), "lights.csv:2: y: \"\" is not a number");
    assert_eq!(check("x,y,z,intensity\n").unwrap(), []);
}

// ---- Errors

#[test]
fn files_that_cannot_be_read_are_named() {
    let files = folder(&[("a.obj", b"v 0 0 0\nv \xff 0 0\n")]);
    assert_eq!(message(load(&files.path().join("b.obj"))), "b.obj: no such file");
    fs::create_dir(files.path().join("c.obj")).unwrap();
    assert_eq!(message(load(&files.path().join("c.obj"))), "c.obj: is a directory, and a file is needed");
    assert_eq!(
        message(load(&files.path().join("a.obj"))),
        "a.obj:2: is not UTF-8: save the file as UTF-8 text"
    );
}

#[test]
fn an_obj_without_faces_is_empty() {
    let expected = "a.obj: empty OBJ: it has no faces (f), and a scene needs one at least";
    assert_eq!(message(load_text("")), expected);
    assert_eq!(message(load_square("l 1 2 3\n")), expected);
}

#[test]
fn wrong_numbers_are_named() {
    for (statement, expected) in [
        ("v 0 nan 0", "v: y = \"nan\" is not finite in 32 bits, and must be"),
        ("v 0 0 -inf", "v: z = \"-inf\" is not finite in 32 bits, and must be"),
        ("v 1e39 0 0", "v: x = \"1e39\" is not finite in 32 bits, and must be"),
        ("v 0 0", "v has 2 numbers: x y z, x y z w, x y z r g b, or x y z r g b a is needed"),
        ("v 0 0 0 0", "v: x, y, z divided by w = 0.0 are not finite"),
        ("v 1 1 1 1e-45", "v: x, y, z divided by w = 1e-45 are not finite"),
        ("v 0 1,5 0", "v: y = \"1,5\" is not a number"),
        ("vt NaN 0", "vt: u = \"NaN\" is not finite in 32 bits, and must be"),
        ("vn 0 0 infinity", "vn: z = \"infinity\" is not finite in 32 bits, and must be"),
        ("vn 0 0", "vn: z is missing: x y z are needed"),
    ] {
        let obj = format!("{statement}\n");
        assert_eq!(message(load_square(&obj)), format!("a.obj:8: {expected}"));
    }
}

#[test]
fn wrong_faces_are_named() {
    for (statement, expected) in [
        ("f 1 2 5", "f: v index 5 is out of range: the file has 4"),
        ("f 1 2 -5", "f: v index -5 is out of range: 1 to 4 (or -4 to -1) stand above this line"),
        ("f 0 1 2", "f: v index 0 is out of range: 1 to 4 (or -4 to -1) stand above this line"),
        ("f 1/0 2/1 3/1", "f: vt index 0 is out of range: 1 to 2 (or -2 to -1) stand above this line"),
        ("f 1//1 2//2 3//1", "f: vn index 2 is out of range: the file has 1"),
        ("f 1 2", "f has 2 corners: at least 3 are needed"),
        ("f", "f has 0 corners: at least 3 are needed"),
        ("f 1/1 2 3/1", "f: 2 of 3 corners have a vt"),
        ("f 1 2 x", "f: corner \"x\": v, v/vt, v//vn or v/vt/vn is needed"),
        ("f 1 2 /1", "f: corner \"/1\": v, v/vt, v//vn or v/vt/vn is needed"),
        ("f 1/1/1/1 2 3", "f: corner \"1/1/1/1\": v, v/vt, v//vn or v/vt/vn is needed"),
        (
            "f 1 2 9223372036854775808",
            "f: corner \"9223372036854775808\": v, v/vt, v//vn or v/vt/vn is needed",
        ),
    ] {
        let obj = format!("f 1 2 3\n{statement}\n");
        assert_eq!(message(load_square(&obj)), format!("a.obj:9: {expected}"));
    }
    assert_eq!(
        message(load_text("v 0 0 0\nf 1/1 1/1 1/1")),
        "a.obj:2: f: vt index 1 is out of range: the file has 0"
    );
}

#[test]
fn missing_materials_are_named() {
    assert_eq!(
        message(load_square("\nmtllib none.mtl\nf 1 2 3\n")),
        "a.obj:9: mtllib: there is no MTL file \"none.mtl\""
    );
    assert_eq!(
        message(load_square("usemtl red\nf 1 2 3")),
        "a.obj:8: usemtl: material \"red\" is not defined by any MTL file that the OBJ names (mtllib)"
    );
    assert_eq!(message(load_square("usemtl \nf 1 2 3")), "a.obj:8: usemtl: the material's name is missing");
    assert_eq!(message(load_square("mtllib\nf 1 2 3\n")), "a.obj:8: mtllib: the MTL file's name is missing");
}

#[test]
fn wrong_material_statements_are_named() {
    for (statement, expected) in [
        ("Kd 1 nan 1", "Kd: \"nan\" is not finite in 32 bits, and must be"),
        ("Kd 1 1", "Kd \"1 1\": 3 numbers are needed"),
        ("Ks 1 -1 1", "Ks -1: 0 to 1 is needed"),
        ("Kd 1 -1 1", "Kd -1: 0 or more is needed"),
        ("Ns x", "Ns: \"x\" is not a number"),
        ("Ni 0", "Ni 0: more than 0 is needed"),
        ("d 1.5", "d 1.5: 0 to 1 is needed"),
        ("Tr -1", "Tr -1: 0 to 1 is needed"),
        ("illum 11", "illum \"11\": a whole number from 0 to 10 is needed"),
        ("map_Kd", "map_Kd: the image's file name is missing"),
        (
            "map_Kd -s 2 2 2 a.png",
            "map_Kd: option \"-s\" is not supported: only -bm is; apply it to the image or to vt",
        ),
        ("bump -bm x a.png", "map_Bump: -bm: \"x\" is not a number"),
    ] {
        assert_eq!(message(load_material(statement)), format!("a.mtl:2: {expected}"));
    }
    let early = load_files(&[("a.obj", b"mtllib a.mtl\nv 0 0 0\nf 1 1 1\n"), ("a.mtl", b"Kd 1 1 1\n")]);
    assert_eq!(message(early), "a.mtl:1: Kd stands above the first newmtl");
}

#[test]
fn missing_and_broken_images_are_named() {
    let missing = message(load_material("Kd 1 1 1\nmap_Kd no such.png"));
    assert!(missing.starts_with("a.mtl:3: map_Kd: image \""), "{missing}");
    assert!(missing.ends_with("no such.png\" no such file"), "{missing}");

    let whole = png(4, 4, &[0; 64]);
    for broken in [&b""[..], b"not an image", &whole[..whole.len() / 2]] {
        let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
        let mtl = b"newmtl m\nmap_Bump broken.png\n";
        let files = [("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("broken.png", broken)];
        let broken = message(load_files(&files));
        assert!(broken.starts_with("a.mtl:2: map_Bump: image \""), "{broken}");
        assert!(broken.contains("broken.png\" cannot be decoded ("), "{broken}");
        assert!(broken.ends_with("a whole PNG or JPEG file is needed"), "{broken}");
    }
}

// ---- No input makes the loader panic

/// An OBJ file with its MTL, to be damaged.
const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nvt 0 0\nvn 0 0 1\nusemtl m\n\
                   f 1/1/1 2/1/1 3/1/1\no b\nl 1 2 3\nf -1 -2 -3 1 \\\n2\n";
const MTL: &str = "newmtl m\nKd 1 1 1\nKs 0 0 0\nNs 1\nd 1\nillum 2\nmap_Kd -bm 2 a.png\n";

/// The bytes with some of them replaced, removed or doubled.
fn damaged(text: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let damage = (0..text.len(), 0..3u8, prop::sample::select(&b"0123456789/-.# \n\\aefvmN\xff"[..]));
    prop::collection::vec(damage, 0..6).prop_map(|damages| {
        let mut bytes = text.as_bytes().to_vec();
        for (at, kind, byte) in damages {
            let at = at.min(bytes.len() - 1);
            match kind {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ if bytes.len() > 1 => drop(bytes.remove(at)),
                _ => {}
            }
        }
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_panic(obj in damaged(OBJ), mtl in damaged(MTL)) {
        let files = folder(&[("a.obj", &obj), ("a.mtl", &mtl)]);
        for strict in [false, true] {
            let options = LoadOptions { strict, ..LoadOptions::default() };
            let lines = match load_obj(&files.path().join("a.obj"), options) {
                Ok(loaded) => loaded.warnings.iter().map(ToString::to_string).collect(),
                Err(error) => vec![error.to_string()],
            };
            prop_assert!(lines.iter().all(|line| line.lines().count() == 1), "{:?}", lines);
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(load_files(&[("a.obj", &bytes)]).is_err());
    }
}
