//! Rays at edges and vertices of a mesh of the user's, closed or not, wherever it is.

mod common;

use common::run;
use serde_json::Value;

/// A box in halves, its vertices moved by `offset`, without the triangles of these places.
fn box_without(left_out: &[usize], offset: f32) -> String {
    let mut obj = String::new();
    for number in 0..8 {
        let at = |bit: u32| offset + (number >> bit & 1) as f32 * [1.0, 2.0, 1e-3][bit as usize];
        obj += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    let sides = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    let halves = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    for (_, [a, b, c]) in halves.enumerate().filter(|(place, _)| !left_out.contains(place)) {
        obj += &format!("f {a} {b} {c}\n");
    }
    obj
}

/// The rows of a mesh, the exit status, and what was said of it.
fn rows_of(obj: &str) -> (Vec<Value>, Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("mesh.obj");
    std::fs::write(&file, obj).expect("a mesh");
    let suite = ["accuracy", "--suite", "exactly-one", "--edges", "owned", "--kernel", "adaptive"];
    let scene = ["--cases", "2000", "--json", "--scene", file.to_str().expect("text")];
    let output = run(&[&suite[..], &scene].concat());
    let rows = String::from_utf8_lossy(&output.stdout);
    let rows = rows.lines().map(|row| serde_json::from_str(row).expect("JSON")).collect();
    (rows, output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Also far away, where the thin box is nothing but two rectangles on one another, and of sides none is left.
#[test]
fn closed_mesh_is_hit_once_wherever_it_is() {
    for offset in [0.0, 1e6] {
        let (rows, status, said) = rows_of(&box_without(&[], offset));
        assert_eq!(status, Some(0), "{said}");
        let kernels: Vec<_> = rows.iter().map(|row| row["kernel"].as_str().expect("a name")).collect();
        assert_eq!(kernels, ["adaptive", "specification"]);
        for row in &rows {
            for wrong in ["none", "two", "silhouette_wrong", "others", "undecided"] {
                assert_eq!(row[wrong], 0, "{wrong} of {row}");
            }
            assert!(row["looked"].as_u64() > Some(500), "{row}");
        }
        assert_eq!(rows[0]["cases"], 2000);
    }
}

#[test]
fn mesh_with_a_hole_is_judged_in_part() {
    let (rows, status, said) = rows_of(&box_without(&[0], 0.0));
    assert_eq!((status, &rows[0]["none"], &rows[0]["two"]), (Some(3), &0.into(), &0.into()));
    assert!(said.contains("not closed: 6 edges and vertices"), "{said}");
}

#[test]
fn mesh_that_is_open_everywhere_is_refused() {
    let (rows, status, said) = rows_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!((rows.len(), status), (0, Some(2)));
    assert!(said.contains("no edge and no vertex has triangles all around"), "{said}");
}
