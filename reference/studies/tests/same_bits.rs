//! A picture, a walk and a table do not depend on the machine or on the build: their digests stand here.

#[path = "../examples/digests.rs"]
mod digests;

use std::fs;
use std::path::{Path, PathBuf};

const DIGESTS: [(&str, u64); 4] = [
    ("scene", 0xea26_a2a6_8f2b_c5b8),
    ("frame", 0x9180_4008_18f4_3a54),
    ("walk", 0xe0c2_f1cf_3950_a37b),
    ("accuracy", 0x6cad_7810_f0d4_c56b),
];

#[test]
fn digests_are_the_same_on_every_machine() {
    let shown = |digests: [(&str, u64); 4]| digests.map(|(name, digest)| format!("{name} {digest:016x}"));
    assert_eq!(shown(digests::digests().expect("a scene")), shown(DIGESTS));
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// What pictures, walks and tables are made of takes functions that platforms round each in its own way from the crate libm, and fuses no
/// multiplication with an addition, but where the exact judge takes the error of a product by it.
#[test]
fn no_function_of_the_platform_is_called() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let mut files = Vec::new();
    for folder in
        ["model/spec/src", "model/fast/src", "scenes/src", "reference/studies/src", "reference/paper/src"]
    {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 100);
    let forbidden = [
        "powf", "exp", "exp2", "ln", "log2", "log10", "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan",
        "atan2", "cbrt", "hypot", "mul_add",
    ];
    for file in files {
        let text = fs::read_to_string(&file).expect("a file");
        for name in forbidden {
            let called = text.contains(&format!(".{name}("));
            assert!(!called, "{} calls '{name}' of the platform: take libm's", file.display());
        }
    }
}
