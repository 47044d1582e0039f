//! Files that are not as their formats say and that others read: what is assumed, that it is said, and
//! that it is refused where it is to be. Each test writes its own files.

#![allow(clippy::unwrap_used)] // A test may fail by a panic.

mod files;

use std::fs;
use std::path::Path;

use files::{SQUARE, folder};
use glam::{Vec2, Vec3, vec3};
use saarcor_model::host::{Material, Scene};
use saarcor_scenes::{LoadOptions, load_obj};

/// The scene `a.obj` in a folder, which is loaded with `expected` warnings, without the folder's name. If
/// there are some, it is refused where faults are errors, for the first.
#[track_caller]
fn load(folder: &Path, expected: &[&str]) -> Scene {
    let path = folder.join("a.obj");
    let short = |line: String| line.replace(&format!("{}/", folder.display()), "");
    let loaded = load_obj(&path, LoadOptions::default()).unwrap();
    let warnings: Vec<_> = loaded.warnings.iter().map(|warning| short(warning.to_string())).collect();
    assert_eq!(warnings, expected);
    let strict = load_obj(&path, LoadOptions { strict: true, ..LoadOptions::default() });
    match loaded.warnings.first() {
        Some(warning) => assert_eq!(strict.unwrap_err(), warning.first),
        None => assert_eq!(strict.unwrap().scene, loaded.scene),
    }
    loaded.scene
}

#[track_caller]
fn load_files(files: &[(&str, &[u8])], expected: &[&str]) -> Scene {
    load(folder(files).path(), expected)
}

/// Loads the square with these statements below it.
#[track_caller]
fn load_square(statements: &str, expected: &[&str]) -> Scene {
    load_files(&[("a.obj", format!("{SQUARE}{statements}").as_bytes())], expected)
}

/// Loads a triangle of material `m`, which has these statements, below `newmtl` in line 1.
#[track_caller]
fn load_material(statements: &str, expected: &[&str]) -> Material {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
    let mtl = format!("newmtl m\n{statements}\n");
    load_files(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())], expected).materials[0]
}

// ---- Geometry

#[test]
fn concave_faces_are_not_their_fan() {
    // An arrow head, of which the fan from corner 1 turns over; its textures and normals come along.
    let scene = load_square("v 0.25 0.75 0\nvt 7 7\nf 1/1/1 5/3/1 3/2/1 4/1/1\n", &[]);
    let corners = [Vec3::ZERO, vec3(0.25, 0.75, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0)];
    let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).z / 2.0;
    let areas: Vec<f32> = scene.triangles.iter().map(|triangle| area(triangle.corners)).collect();
    assert!(areas.len() == 2 && areas.iter().all(|&area| area > 0.0));
    assert_eq!(areas.iter().sum::<f32>(), 0.25);
    let at = |corner| corners.iter().position(|&other| other == corner).unwrap();
    let tex_coords = [Vec2::ZERO, Vec2::splat(7.0), Vec2::new(1.0, 0.5), Vec2::ZERO];
    for (triangle, uv) in scene.triangles.iter().zip(&scene.tex_coords) {
        assert_eq!(triangle.corners.map(|corner| tex_coords[at(corner)]), *uv);
    }
    // The dart whose first corner is the notch needs no other cut than its fan.
    let scene = load_square("v 0.25 0.75 0\nf 5 3 4 1\n", &[]);
    assert_eq!(scene.triangles[0].corners, [corners[1], corners[2], corners[3]]);
}

#[test]
fn faces_without_an_inside_are_named() {
    let scene = load_square(
        "f 1 2 4 3\nf 1 3 2 4\n",
        &[
            "a.obj:8: f: the face crosses itself, so that its inside is not defined; it is cut into a fan around its \
           first corner (2 times)",
        ],
    );
    assert_eq!(scene.triangles.len(), 4);
}

#[test]
fn long_faces_that_are_concave_are_refused() {
    let mut obj: String = (0..20_000).map(|i| format!("v {i} {} 0\n", i % 2)).collect();
    obj.push_str("v 20000 -5 0\nv 0 -5 0\nf");
    (1..=20_002).rev().for_each(|i| obj.push_str(&format!(" {i}")));
    let files = folder(&[("a.obj", obj.as_bytes())]);
    let error = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap_err();
    assert!(
        error.message.starts_with("f has 20002 corners and is not convex: fewer than 16384 are possible"),
        "{error}"
    );
}

#[test]
fn faces_may_stand_above_their_vertices() {
    let scene = load_files(
        &[("a.obj", b"f 1 2 3\nv 0 0 0\nf 1 3 4\nv 1 0 0\nv 1 1 0\nv 0 1 0\n")],
        &[
            "a.obj:1: f: v index 1 is out of range: there is no v above this line; what stands further down is \
           meant (2 times)",
        ],
    );
    assert_eq!(scene.triangles[1].corners, [Vec3::ZERO, vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 0.0)]);
}

#[test]
fn indices_without_data_are_left_out() {
    let without = "the face has no texture coordinates";
    let scene = load_files(
        &[("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1/1 2/2 3/3\n")],
        &[&format!("a.obj:4: f: vt index 1 is out of range: the file has 0; {without}")],
    );
    assert!(scene.tex_coords.is_empty());
    let scene = load_square(
        "f 1//0 2//0 3//0\nf 1//1 2//1 3//1\nf 1//1 2//1 3//-7\n",
        &[
            "a.obj:8: f: vn index 0 is out of range: 1 to 1 (or -1 to -1) stand above this line; the face has \
           the geometric normal (4 times)",
        ],
    );
    assert_eq!(scene.normals, [[Vec3::Z; 3]; 3]);
    let scene = load_square(
        "f 1/1 2 3/1\nf 1/2 2/2 3/2\n",
        &["a.obj:8: f: 2 of 3 corners have a vt; it has no texture coordinates"],
    );
    assert_eq!(scene.tex_coords, [[Vec2::ZERO; 3], [Vec2::new(1.0, 0.5); 3]]);
    let scene = load_square(
        "vn nan 0 0\nvt 1,5 0\nf 1/1/2 2/1/2 3/1/1\nf 1/3/1 2/2/1 3/2/1\n",
        &[
            "a.obj:8: vn: x = \"nan\" is not finite in 32 bits, and must be; faces that name it have the geometric \
             normal",
            "a.obj:9: vt: u = \"1,5\" is not a number; faces that name it have no texture coordinates",
        ],
    );
    assert_eq!((scene.normals, scene.tex_coords), (vec![[Vec3::Z; 3]; 2], vec![[Vec2::ZERO; 3]; 2]));
}

#[test]
fn statements_are_read_in_any_case_and_of_any_length() {
    let scene = load_square("V 5 5 5\nVN 1 0 0\nvt 0.5\nFO 1/3/2 2/3/2 3/3/2\nf 1/1/1 2/1/1 5/1/1\n", &[]);
    assert_eq!(scene.normals[0], [Vec3::X; 3]);
    assert_eq!(scene.tex_coords[0], [Vec2::new(0.5, 0.0); 3]);
    assert_eq!(scene.triangles[1].corners[2], Vec3::splat(5.0));
    let coloured = load_square("v 2 2 2 0.1 0.2 0.3 1\nf 1 2 5\n", &[]);
    assert_eq!(coloured.triangles[0].corners[2], Vec3::splat(2.0));
    load_square(
        "f 1 2\nf 3\nsurf 0 1\nface 1 2 3\nv 1 2 3 4 5\nv 1 2 3 0\nf 1 2 3\n",
        &[
            "a.obj:8: f has 2 corners: at least 3 are needed; it makes no triangle (2 times)",
            "a.obj:10: \"surf\": neither surfaces nor other files are read; what it adds is left out",
            "a.obj:11: \"face\" is no statement of OBJ; what OBJ does not have is passed over",
            "a.obj:12: v has 5 numbers: 3, 4, 6 or 7 are needed; the first three are taken",
            "a.obj:13: v: x, y, z divided by w = 0.0 are not finite; x, y, z are taken as they are",
        ],
    );
}

#[test]
fn text_is_read_however_it_is_encoded() {
    let obj = format!("{SQUARE}f 1 2 3\n");
    let scene = load_square("f 1 2 3\n", &[]);
    let latin = [b"# Gr\xfc\xdfe\n", obj.as_bytes()].concat();
    let expected = "a.obj:1: is not UTF-8: save the file as UTF-8 text; it is taken for Latin-1";
    assert_eq!(load_files(&[("a.obj", &latin)], &[expected]), scene);
    let wide: Vec<u8> =
        "\u{feff}".encode_utf16().chain(obj.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let expected = "a.obj:1: is not UTF-8: save the file as UTF-8 text; its byte order mark says UTF-16";
    assert_eq!(load_files(&[("a.obj", &wide)], &[expected]), scene);
    let expected =
        "a.obj:1: a carriage return without a line feed: save the file as text; the line ends there";
    assert_eq!(load_files(&[("a.obj", obj.replace('\n', "\r").as_bytes())], &[expected]), scene);
}

#[test]
fn other_formats_are_named() {
    for (content, format) in
        [(&b"ply\nformat ascii 1.0\n"[..], "PLY"), (b"glTF\x02\0\0\0", "binary glTF (GLB)")]
    {
        let files = folder(&[("a.obj", content)]);
        let error = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap_err();
        assert_eq!(error.message, format!("is no OBJ file: it is in {format} format; save the scene as OBJ"));
    }
}

// ---- Libraries and materials

#[test]
fn missing_libraries_and_materials_are_the_default() {
    let scene = load_square(
        "mtllib gone.mtl\nmtllib gone.mtl\nusemtl red\nf 1 2 3\nusemtl (null)\nf 1 2 4\nusemtl unused\n",
        &[
            "a.obj:8: mtllib: there is no MTL file \"gone.mtl\"; its materials are not defined",
            "a.obj:10: usemtl: material \"red\" is not defined by any MTL file that the OBJ names (mtllib); the \
             default material is taken (2 times)",
        ],
    );
    assert_eq!(scene.materials, [Material::default()]);
}

#[test]
fn a_library_named_twice_is_one() {
    let files = |libraries: &str| {
        let obj = format!("{libraries}{SQUARE}usemtl b\nf 1 2 3\nusemtl a\nf 1 2 3\n");
        load_files(&[("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\n")], &[])
    };
    let once = files("mtllib a.mtl\n");
    assert_eq!(once.materials.len(), 2);
    assert_eq!(files("mtllib a.mtl\nMTLLIB ./a.mtl\nmtllib a.mtl a.mtl\nmtllib a.mtl\n"), once);
}

#[test]
fn unused_materials_are_left_out_whatever_they_hold() {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/1 3/1\n");
    let mtl =
        "newmtl u\nKd nan\nNs x\nmap_Kd gone.png\nwhat\nnewmtl m\nKd 0 0 1\nnewmtl v\nillum 99\nKs -1\n";
    let scene = load_files(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())], &[]);
    assert_eq!(scene.materials, [Material { diffuse: Vec3::Z, ..Material::default() }]);
    assert_eq!(scene.triangles[0].material, 0);
}

#[test]
fn names_are_found_as_they_are_meant() {
    let square = |statements: &str| format!("{statements}\n{SQUARE}usemtl m\nf 1 2 3\n");
    let library = b"newmtl m\nKd 1 0 0\n";
    for (statement, there) in [
        ("mtllib a.mtl # the library", &["a.mtl"][..]),
        ("mtllib \"a b.mtl\"", &["a b.mtl"]),
        ("mtllib a\\ b.mtl", &["a b.mtl"]),
        ("mtllib C:\\Users\\me\\A.MTL", &["a.mtl"]),
        ("mtllib c d.mtl a b.mtl", &["a b.mtl", "c d.mtl"]),
    ] {
        let files = folder(&[("a.obj", square(statement).as_bytes())]);
        there.iter().for_each(|name| fs::write(files.path().join(name), library).unwrap());
        let loaded = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap();
        assert_eq!(loaded.scene.materials[0].diffuse, Vec3::X, "{statement}");
        let [warning] = &loaded.warnings[..] else { panic!("{statement}: {:?}", loaded.warnings) };
        assert_eq!((warning.first.line, warning.assumed), (Some(1), "that file is taken"), "{statement}");
    }
    let scene = load_files(
        &[
            (
                "a.obj",
                format!("mtllib a.mtl\n{SQUARE}usemtl m # red\nf 1 2 3\nusemtl \"n\"\nf 1 2 3\n").as_bytes(),
            ),
            ("a.mtl", b"newmtl m\nKd 1 0 0\nnewmtl n # blue\nKd 0 0 1\n"),
        ],
        &[
            "a.obj:9: usemtl: material \"m # red\" is not defined by just that name; the material of a similar \
           name is taken (2 times)",
        ],
    );
    assert_eq!(
        scene.materials.iter().map(|material| material.diffuse).collect::<Vec<_>>(),
        [Vec3::X, Vec3::Z]
    );
}

#[test]
fn material_statements_are_read_in_any_case() {
    let material = load_material(
        "kd 1 0 0\nKS 0.5\nns 9\nTF 1 1 1\nMAP_KS x.png\nPr 0.5\nwrong 1",
        &["a.mtl:8: wrong is no statement; statements that the MTL format does not have are passed over"],
    );
    assert_eq!((material.diffuse, material.specular, material.shininess), (Vec3::X, Vec3::splat(0.5), 9.0));
}

#[test]
fn values_out_of_range_are_the_nearest() {
    let material = load_material(
        "Kd 2 -1 0\nKs 3 1 0\nNs -5\nNi 0.0\nillum 11\nd 1.5",
        &[
            "a.mtl:2: Kd -1: 0 or more is needed; 0 is taken (2 times)",
            "a.mtl:3: Ks 3: 0 to 1 is needed; 1 is taken (2 times)",
            "a.mtl:5: Ni 0.0: more than 0 is needed; it is taken for 1",
            "a.mtl:6: illum \"11\": a whole number from 0 to 10 is needed; neither reflection nor refraction is assumed",
        ],
    );
    assert_eq!((material.diffuse, material.index_of_refraction), (vec3(2.0, 0.0, 0.0), 1.0));
    assert_eq!((material.reflection, material.refraction), (0.0, 0.0));
    let material = load_material(
        "Kd 0.5\nKs spectral a.rfl\nd -halo 0.25\nillum 4",
        &[
            "a.mtl:3: Ks \"spectral a.rfl\": 3 numbers are needed; the statement is passed over",
            "a.mtl:4: d -halo: d is the same from all sides; -halo is passed over",
        ],
    );
    assert_eq!((material.diffuse, material.specular), (Vec3::splat(0.5), Vec3::ZERO));
    assert_eq!(material.refraction, 0.75);
}

#[test]
fn no_surface_gives_more_light_than_it_gets() {
    let mirror =
        load_material("Ks 4 4 4\nillum 3", &["a.mtl:2: Ks 4: 0 to 1 is needed; 1 is taken (3 times)"]);
    assert_eq!(mirror.reflection, 1.0);
    let glass = load_material(
        "Ks 0.75 0.75 0.75\nd 0.5\nillum 7",
        &[
            "a.mtl:1: newmtl: the material reflects 0.75 and refracts 0.5, together more than 1; it refracts what it does \
         not reflect",
        ],
    );
    assert_eq!((glass.reflection, glass.refraction), (0.75, 0.25));
}

#[test]
fn an_exponent_of_zero_is_no_highlight() {
    let matt = load_material("Ks 0.9 0.9 0.9\nNs 0", &[]);
    assert_eq!((matt.specular, matt.shininess), (Vec3::ZERO, 0.0));
    let mirror = load_material("Ks 0.5 0.5 0.5\nNs 0\nillum 3", &[]);
    assert_eq!((mirror.specular, mirror.reflection), (Vec3::ZERO, 0.5));
}

#[test]
fn an_exponent_of_zero_can_be_exported() {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
    let files = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl m\nKs 0.5 0.25 0\nNs 0\nillum 3\n")]);
    let scene = load(files.path(), &[]);
    saarcor_scenes::export_obj(&scene, &files.path().join("a.obj")).unwrap();
    assert_eq!(load(files.path(), &[]), scene);
}

#[test]
fn where_d_and_tr_contradict_d_is_taken() {
    for (d, tr, warnings) in
        [(1.0, 1.0, 1), (0.0, 0.0, 1), (0.25, 0.25, 1), (0.25, 0.75, 0), (0.333, 0.6667, 0)]
    {
        let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3\n");
        let mtl = format!("newmtl m\nd {d}\nTr {tr}\nillum 4\n");
        let files = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())]);
        let loaded = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap();
        assert_eq!(loaded.warnings.len(), warnings);
        let refraction = if warnings == 1 { 1.0 - d } else { tr };
        assert_eq!(loaded.scene.materials[0].refraction, refraction);
    }
}

// ---- Images

/// Loads a triangle whose material has these statements, from `newmtl` in line 1, with images.
#[track_caller]
fn load_image(statements: &str, images: &[(&str, &[u8])], expected: &[&str]) -> Scene {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
    let mtl = format!("newmtl m\nKd 0.5 0.5 0.5\n{statements}\n");
    let texts: [(&str, &[u8]); 2] = [("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())];
    load_files(&[&texts[..], images].concat(), expected)
}

fn encoded(colour: image::ExtendedColorType, format: image::ImageFormat) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let texels: Vec<u8> =
        (0..32 * 32 * u32::from(colour.channel_count())).map(|i| (i * i / 5) as u8).collect();
    image::write_buffer_with_format(&mut file, &texels, 32, 32, colour, format).unwrap();
    file.into_inner()
}

fn png() -> Vec<u8> {
    encoded(image::ExtendedColorType::Rgb8, image::ImageFormat::Png)
}

#[test]
fn options_of_images_are_read_wherever_they_stand() {
    let png = png();
    for statement in [
        "map_Kd t.png",
        "map_kd -clamp off -blendu on -mm 0 1.0 -o 0 0 0 -s 1 1 t.png",
        "map_Kd t.png -cc off",
        "map_Kd \"t.png\"",
        "map_Kd T.PNG",
        "map_Kd C:\\textures\\t.png",
        "map_Kd t.png # the wall",
    ] {
        let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
        let mtl = format!("newmtl m\n{statement}\n");
        let files = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes()), ("t.png", &png)]);
        let loaded = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap();
        assert_eq!(loaded.scene.materials[0].texture, Some(0), "{statement}");
    }
    let scene = load_image("bump t.png -bm 2\n", &[("t.png", &png)], &[]);
    assert_eq!((scene.materials[0].bump, scene.materials[0].bump_height), (Some(0), 2.0));
    load_image(
        "map_Kd -s 2 2 2 -o 1 t.png",
        &[("t.png", &png)],
        &[
            "a.mtl:3: map_Kd: option \"-s\" is not supported: only -bm is; apply it to the image or to vt; the \
         image is shown without it (2 times)",
        ],
    );
    let grey = encoded(image::ExtendedColorType::L8, image::ImageFormat::Png);
    load_image("bump -imfchan r t.png", &[("t.png", &grey)], &[]);
    let scene = load_image("map_Kd a -clamp off", &[("a -clamp off", &png)], &[]);
    assert_eq!(scene.textures.len(), 1);
}

#[test]
fn images_that_are_not_there_are_left_out() {
    let scene = load_image(
        "map_Kd\nbump\n",
        &[],
        &["a.mtl:3: map_Kd: the image's file name is missing; no image is assumed (2 times)"],
    );
    assert_eq!(scene.materials[0].diffuse, Vec3::splat(0.5));
    for (name, content) in [("t.tga", &b"\0\0\x02\0"[..]), ("t.png", b"BM\0\0\0\0")] {
        let scene = load_image(
            &format!("map_Kd {name}"),
            &[(name, content)],
            &[&format!(
                "a.mtl:3: map_Kd: image \"{name}\" is neither PNG nor JPEG; images of other formats are left out"
            )],
        );
        assert_eq!((scene.textures.len(), scene.materials[0].texture), (0, None));
    }
    load_image(
        "map_Kd gone.png",
        &[],
        &["a.mtl:3: map_Kd: image \"gone.png\" no such file; the surfaces have no image there"],
    );
}

#[test]
fn without_textures_no_image_is_looked_for() {
    let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
    let mtl = b"newmtl m\nKd 1 0 0\nmap_Kd broken.png\nbump C:/gone.tga\n";
    let files = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl), ("broken.png", b"no image")]);
    let options = LoadOptions { no_textures: true, strict: true };
    let loaded = load_obj(&files.path().join("a.obj"), options).unwrap();
    assert_eq!(loaded.scene.materials, [Material { diffuse: Vec3::X, ..Material::default() }]);
    assert!(loaded.files.iter().all(|file| !file.ends_with("broken.png")));
}

#[test]
fn a_truncated_image_is_an_error_whatever_its_format() {
    for format in [image::ImageFormat::Jpeg, image::ImageFormat::Png] {
        let whole = encoded(image::ExtendedColorType::Rgb8, format);
        for length in [whole.len() - 40, whole.len() / 2] {
            let obj = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/1\n");
            let texts: [(&str, &[u8]); 2] =
                [("a.obj", obj.as_bytes()), ("a.mtl", b"newmtl m\nmap_Kd t.png\n")];
            let files = folder(&[&texts[..], &[("t.png", &whole[..length])]].concat());
            let error = load_obj(&files.path().join("a.obj"), LoadOptions::default()).unwrap_err();
            assert!(
                error.message.ends_with("a whole PNG or JPEG file is needed"),
                "{format:?} {length}: {error}"
            );
        }
    }
}
