//! A picture, a walk and a table do not depend on the machine or on the build: their digests stand here.

#[path = "../examples/digests.rs"]
mod digests;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const DIGESTS: [(&str, u64); 4] = [
    ("scene", 0xea26_a2a6_8f2b_c5b8),
    ("frame", 0x9180_4008_18f4_3a54),
    ("walk", 0xe0c2_f1cf_3950_a37b),
    ("accuracy", 0x46a2_9465_8e91_06f9),
];

/// The platform's sine of 1, which its mathematical library computes.
fn platforms_sine() -> f64 {
    std::hint::black_box(1.0_f64).sin()
}

#[test]
fn digests_are_the_same_on_every_machine() {
    println!("the platform's sine: {:016x}", platforms_sine().to_bits());
    let shown = |digests: [(&str, u64); 4]| digests.map(|(name, digest)| format!("{name} {digest:016x}"));
    assert_eq!(shown(digests::digests().expect("a scene")), shown(DIGESTS));
}

/// A mathematical library in which nothing is right. What every library has to round exactly, as floors and square roots, is left alone.
const SHIM: &str = "
#define BOTH(name) double name(double x) { return 0.4375 - x / 3; } float name##f(float x) { return 0.4375f - x / 3; }
#define TWO(name) double name(double x, double y) { return 0.4375 - x / 3 + y / 7; } \\
    float name##f(float x, float y) { return 0.4375f - x / 3 + y / 7; }
BOTH(sin) BOTH(cos) BOTH(tan) BOTH(asin) BOTH(acos) BOTH(atan) BOTH(sinh) BOTH(cosh) BOTH(tanh) BOTH(asinh) BOTH(acosh)
BOTH(atanh) BOTH(exp) BOTH(exp2) BOTH(expm1) BOTH(log) BOTH(log2) BOTH(log10) BOTH(log1p) BOTH(cbrt) BOTH(tgamma)
TWO(pow) TWO(atan2) TWO(hypot)
void sincos(double x, double *s, double *c) { *s = sin(x); *c = cos(x); }
void sincosf(float x, float *s, float *c) { *s = sinf(x); *c = cosf(x); }
";

/// With the platform's library exchanged, its sine is another one in this very process, and all digests are the same.
#[test]
#[cfg(target_os = "linux")]
fn digests_do_not_depend_on_the_mathematical_library() {
    let folder = tempfile::tempdir().expect("a folder");
    let [source, shim] = ["shim.c", "shim.so"].map(|name| folder.path().join(name));
    fs::write(&source, SHIM).expect("a source");
    let built = Command::new("cc")
        .args(["-O1", "-fno-builtin", "-shared", "-fPIC", "-o"])
        .arg(&shim)
        .arg(&source)
        .status();
    assert!(built.expect("the C compiler that linked this test").success());
    let output = Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", "digests_are_the_same_on_every_machine", "--nocapture"])
        .env("LD_PRELOAD", &shim)
        .output()
        .expect("this test once more");
    let said = String::from_utf8_lossy(&output.stdout);
    let exchanged = format!("the platform's sine: {:016x}", (0.4375 - 1.0 / 3.0_f64).to_bits());
    assert!(said.contains(&exchanged), "the library is not exchanged: {said}");
    assert!(said.contains("1 passed"), "{said}");
    assert!(platforms_sine() > 0.8);
}

/// A build: its name, variables, and arguments of Cargo.
type Build = (&'static str, &'static [(&'static str, &'static str)], &'static [&'static str]);

const BUILDS: [Build; 6] = [
    ("release", &[], &["--release"]),
    ("unoptimised, x86-64", &[FOR_X86_64, ("CARGO_PROFILE_DEV_OPT_LEVEL", "0")], &[]),
    ("x86-64", &[FOR_X86_64, QUICK], &[]),
    ("x86-64-v3", &[("RUSTFLAGS", "-C target-cpu=x86-64-v3"), QUICK], &[]),
    ("x86-64-v4", &[("RUSTFLAGS", "-C target-cpu=x86-64-v4"), QUICK], &[]),
    (
        "aarch64",
        &[
            ("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", "aarch64-linux-gnu-gcc"),
            ("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", "qemu-aarch64 -L /usr/aarch64-linux-gnu"),
            QUICK,
        ],
        &["--target", "aarch64-unknown-linux-gnu"],
    ),
];

const FOR_X86_64: (&str, &str) = ("RUSTFLAGS", "-C target-cpu=x86-64");
const QUICK: (&str, &str) = ("CARGO_PROFILE_DEV_OPT_LEVEL", "1");

/// The builds of the name that `SAARCOR_BUILDS` has, or all. One that this machine cannot make or run is said, but for the release.
#[test]
#[ignore = "builds the studies six times: half an hour"]
#[cfg(target_os = "linux")]
fn digests_are_those_of_other_builds() {
    let asked = std::env::var("SAARCOR_BUILDS").unwrap_or_default();
    for (name, variables, arguments) in BUILDS.into_iter().filter(|(name, ..)| name.contains(&asked)) {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["run", "--quiet", "-p", "saarcor-studies", "--example", "digests"]).args(arguments);
        cargo.envs(variables.iter().copied());
        cargo.env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join(name));
        let output = cargo.output().expect("cargo");
        if !output.status.success() {
            assert_ne!(name, "release");
            println!("{name}: not run: {}", String::from_utf8_lossy(&output.stderr));
            continue;
        }
        let expected: String =
            DIGESTS.iter().map(|(name, digest)| format!("{name:<10}{digest:016x}\n")).collect();
        assert_eq!(String::from_utf8_lossy(&output.stdout), expected, "{name}");
        println!("{name}: the same");
    }
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
