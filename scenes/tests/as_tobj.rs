//! The loader reads the triangles that tobj reads, bit for bit, from files that both accept.

#![allow(clippy::unwrap_used)] // A test may fail by a panic.

mod files;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use files::folder;
use glam::{Vec2, Vec3};
use proptest::prelude::*;
use saarcor_scenes::{LoadOptions, load_obj};

/// A corner: its position, and its texture coordinates and normal where it has them.
type Corner = (Vec3, Option<Vec2>, Option<Vec3>);

/// The corners of all triangles as tobj reads them, in the order of their faces.
fn by_tobj(path: &Path) -> Vec<Corner> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj(path, &options).unwrap();
    let corners = |mesh: tobj::Mesh| {
        let corner = |&index: &u32| {
            let index = index as usize;
            let of = |numbers: &[f32], count: usize| {
                numbers.get(count * index..count * (index + 1)).map(<[f32]>::to_vec)
            };
            (
                Vec3::from_slice(&of(&mesh.positions, 3).unwrap()),
                of(&mesh.texcoords, 2).map(|numbers| Vec2::from_slice(&numbers)),
                of(&mesh.normals, 3).map(|numbers| Vec3::from_slice(&numbers)),
            )
        };
        mesh.indices.iter().map(corner).collect::<Vec<_>>()
    };
    models.into_iter().flat_map(|model| corners(model.mesh)).collect()
}

/// Compares what both read; texture coordinates and normals where tobj has them.
fn is_read_alike(path: &Path) {
    let scene = load_obj(path, LoadOptions::default()).unwrap().scene;
    let expected = by_tobj(path);
    assert_eq!(scene.triangles.len() * 3, expected.len(), "corners");
    for (place, (position, tex_coords, normal)) in expected.into_iter().enumerate() {
        let (triangle, corner) = (place / 3, place % 3);
        assert_eq!(scene.triangles[triangle].corners[corner], position, "triangle {triangle}");
        if let Some(tex_coords) = tex_coords {
            assert_eq!(scene.tex_coords[triangle][corner], tex_coords, "triangle {triangle}");
        }
        // A normal of length 0 is no normal.
        if let Some(normal) = normal.filter(|normal| *normal != Vec3::ZERO) {
            assert_eq!(scene.normals[triangle][corner], normal, "triangle {triangle}");
        }
    }
}

/// A number as programs write it.
fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        any::<f32>()
            .prop_filter("in reach of a camera", |number| number.abs() < 1.0e15)
            .prop_map(|number| format!("{number:e}")),
        (-1000_i32..1000).prop_map(|number| number.to_string()),
        (-1.0e4_f32..1.0e4).prop_map(|number| format!("{number:.6}")),
        (0.0_f64..1.0).prop_map(|number| format!("{number:.17}")),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Triangles, and quadrangles that bend outwards, of corners that name positions, texture coordinates and normals in any
    /// of the four ways, counted from the begin or back from the face.
    #[test]
    fn generated_files_are_read_alike(
        vertices in prop::collection::vec([number(), number(), number()], 3..20),
        squares in prop::collection::vec((-50_i16..50, -50_i16..50), 0..4),
        others in prop::collection::vec([number(), number(), number()], 1..6),
        faces in prop::collection::vec((any::<[prop::sample::Index; 9]>(), 0..4_usize, any::<bool>()), 1..20),
    ) {
        let mut text = String::new();
        for [x, y, z] in &vertices {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        for [x, y, z] in &others {
            let _ = writeln!(text, "vt {x} {y}\nvn {x} {y} {z}");
        }
        for (indices, way, back) in faces {
            // tobj takes the parts that a mesh has from its first face: a mesh a face.
            text.push_str("g part\nf");
            for corner in 0..3 {
                let index = |place: usize, count: usize| {
                    let index = indices[3 * corner + place].index(count) as i64;
                    if back { index - count as i64 } else { index + 1 }
                };
                let (v, vt, vn) = (index(0, vertices.len()), index(1, others.len()), index(2, others.len()));
                let _ = match way {
                    0 => write!(text, " {v}"),
                    1 => write!(text, " {v}/{vt}"),
                    2 => write!(text, " {v}//{vn}"),
                    _ => write!(text, " {v}/{vt}/{vn}"),
                };
            }
            text.push('\n');
        }
        for (x, y) in squares {
            let _ = writeln!(text, "g square\nv {x} {y} 0\nv {} {y} 1\nv {} {} 1\nv {x} {} 0\nf -4 -3 -2 -1", x + 2, x + 3, y + 2, y + 1);
        }
        let files = folder(&[("generated.obj", text.as_bytes())]);
        is_read_alike(&files.path().join("generated.obj"));
    }
}

#[test]
#[ignore = "needs SAARCOR_SCENES, a folder with the unpacked real scenes"]
fn real_scenes_are_read_alike() {
    let folder = PathBuf::from(std::env::var_os("SAARCOR_SCENES").expect("SAARCOR_SCENES names a folder"));
    let mut read = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let folder = entry.unwrap().path();
        for file in std::fs::read_dir(&folder).into_iter().flatten() {
            let file = file.unwrap().path();
            if file.extension().is_some_and(|extension| extension == "obj") {
                println!("{}", file.display());
                is_read_alike(&file);
                read += 1;
            }
        }
    }
    assert!(read >= 4, "{read} scenes");
}
