//! `saarcor render`: the same file, whatever lies between the chip and the host's memory.

mod common;

use common::{room_arg, run, stdout_of};

/// The verb writes the same file either way, and prints the counters of the virtual memory.
#[test]
fn files_are_the_same_with_flat_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = |name: &str, args: &[&str]| {
        let file = folder.path().join(name);
        let file_arg = file.to_str().expect("text");
        let all =
            ["render", &room_arg(), "--resolution", "160x120", "--frame", "1", "-o", file_arg, "--json"];
        let out = stdout_of(&[&all[..], args].concat());
        (std::fs::read(file).expect("a file"), serde_json::from_str::<serde_json::Value>(&out).expect("JSON"))
    };
    let (flat, without) = render("flat.png", &["--flat"]);
    let (cached, with) = render("cached.png", &["--memory", "2KiB", "--line", "64"]);
    assert_eq!(flat, cached);
    assert_eq!(without.get("accesses"), None);
    assert_eq!(
        with["hits"].as_u64().zip(with["misses"].as_u64()).map(|(a, b)| a + b),
        with["accesses"].as_u64()
    );
    assert_eq!(without["shadow_rays"], with["shadow_rays"]);
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 2, "no temporary file is left");
    let picture = image::load_from_memory(&flat).expect("PNG");
    assert_eq!((picture.width(), picture.height()), (160, 120));
}

/// Single rays and packets see the same.
#[test]
fn packets_do_not_change_the_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = |packet: &str| {
        let file = folder.path().join(packet);
        let file_arg = file.to_str().expect("text");
        let args = ["render", &room_arg(), "--resolution", "70x50", "-o", file_arg, "--packet", packet];
        assert!(run(&args).status.success());
        std::fs::read(file).expect("a file")
    };
    let single = render("1");
    assert!(["4", "16", "64"].iter().all(|packet| render(packet) == single));
}
