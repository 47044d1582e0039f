//! `reproduce --scene`: the paper's figures of a scene of the user's.

mod common;

use common::{RoomCopy, room_arg, stdout_of};
use serde_json::Value;

/// The room's figures, with more arguments; what its page says.
fn figures(more: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let (room, out) = (room_arg(), folder.path().to_str().expect("text").to_owned());
    let args = [&["reproduce", "--quick", "--json", "--scene", &room, "--out", &out], more].concat();
    let figures = serde_json::from_str(&stdout_of(&args)).expect("JSON");
    for file in ["bytes-a.svg", "bytes-b.svg", "figure3-room.svg", "figure3-room.csv"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
    (figures, std::fs::read_to_string(folder.path().join("index.html")).expect("a page"))
}

fn of<'a>(value: &'a Value, key: &str) -> &'a Vec<Value> {
    value[key].as_array().unwrap_or_else(|| panic!("{key}"))
}

#[test]
fn scene_has_its_walk_its_hot_spots_and_the_claims() {
    let (figures, page) = figures(&["--memory", "16MiB"]);
    assert_eq!((figures["scene"].as_str(), figures["fit"].is_null()), (Some("room"), true));
    let memories: Vec<u64> = of(&figures, "memories")
        .iter()
        .filter_map(|row| row["memory_bytes"].as_u64())
        .map(|bytes| bytes >> 20)
        .collect();
    assert_eq!(memories, [1, 2, 4, 8, 16, 32, 64]);
    let walk = &of(&figures, "figure3")[0];
    assert_eq!(walk["memory_bytes"].as_u64(), Some(16 << 20));
    let frames = |rows: &Vec<Value>| rows.iter().map(|row| row["frame"].as_u64()).collect::<Vec<_>>();
    let spots = of(&figures, "table2");
    assert_eq!(frames(spots), frames(of(walk, "hot_spots")));
    for spot in spots {
        assert!(spot["paper"].is_null());
        for (version, run) in [("none", "no_vm"), ("a", "version_a"), ("b", "version_b")] {
            let sum = |class: &str| -> u64 {
                let classes = spot["traffic"][version][class].as_object().expect("classes");
                classes.values().filter_map(Value::as_u64).sum()
            };
            assert_eq!(sum("mem"), spot[run]["mem_bytes"].as_u64().expect("a number"), "{version}");
            assert_eq!(sum("pci"), spot[run]["pci_bytes"].as_u64().expect("a number"), "{version}");
        }
    }
    let claims = of(&figures, "claims");
    assert!(claims.len() >= 12);
    for claim in claims {
        let id = claim["id"].as_str().expect("a name");
        for key in ["section", "paper", "ours", "verdict"] {
            assert!(claim[key].as_str().is_some_and(|text| !text.is_empty()), "{id}: {key}");
        }
        let cause = &claim["cause"];
        assert!(
            cause["setting"].is_string()
                && cause["standard"].is_number()
                && cause["with_setting"].is_number(),
            "{id}"
        );
        assert!(page.contains(id));
    }
    assert!(page.contains("room: the paper") && page.contains("other sizes of on-board memory"));
    assert!(!page.contains("Table 1") && !page.contains("What differs"), "they are about the paper's scenes");
}

#[test]
fn path_may_lie_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("one frame.csv");
    let camera =
        "frame,eye_x,eye_y,eye_z,dir_x,dir_y,dir_z,up_x,up_y,up_z,fov_y_deg\n0,0.5,0.5,0.5,0,0,-1,0,1,0,60\n";
    std::fs::write(&path, camera).expect("written");
    let (figures, page) = figures(&["--path", path.to_str().expect("text")]);
    assert_eq!(of(&figures, "figure3")[0]["path_frames"].as_u64(), Some(1));
    assert_eq!(of(&figures, "table2").len(), 1);
    // One frame says nothing of warm caches, nor which frames are the worst.
    for id in ["a-hardly-slower", "b-little-slower", "fast-bus", "hot-spots-are-worst"] {
        assert_eq!(verdict(&figures, id), "undecided", "{id}");
    }
    for memory in of(&figures, "memories") {
        assert!(memory["loaded_bytes_a_frame"].is_null() && memory["bus_fps"].is_null(), "{memory}");
        assert!(memory["first_loaded_bytes"].as_u64().is_some_and(|bytes| bytes > 0), "{memory}");
    }
    assert!(!page.contains("The walks skip frames") && !page.contains("some frames"), "all of one");
}

fn verdict<'a>(figures: &'a Value, id: &str) -> &'a str {
    let claim = of(figures, "claims").iter().find(|claim| claim["id"] == id);
    claim.and_then(|claim| claim["verdict"].as_str()).unwrap_or_else(|| panic!("{id}"))
}

/// A camera at rest loads nothing anew; one that looks away sees nothing.
#[test]
fn frames_that_load_nothing_make_no_nonsense() {
    let header = "frame,eye_x,eye_y,eye_z,dir_x,dir_y,dir_z,up_x,up_y,up_z,fov_y_deg\n";
    for camera in ["0.5,0.5,0.5,0,0,-1,0,1,0,60", "900,900,900,0,0,1,0,1,0,60"] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rest.csv");
        let rows: String = (0..3).map(|frame| format!("{frame},{camera}\n")).collect();
        std::fs::write(&path, format!("{header}{rows}")).expect("written");
        let (figures, page) = figures(&["--path", path.to_str().expect("text"), "--memory", "64KiB"]);
        for claim in of(&figures, "claims") {
            let text = claim.to_string();
            assert!(
                text.len() < 3000 && !["NaN", "inf", "\" times"].iter().any(|no| text.contains(no)),
                "{text}"
            );
        }
        assert!(!page.contains("NaN") && page.contains("with 0.06 MB of on-board memory"), "{camera}");
        for id in ["ways-and-hash", "too-little-memory"] {
            assert_ne!(verdict(&figures, id), "does_not", "{id} of {camera}");
        }
    }
}

/// Files and links have names that need no quotes, whatever the scene is called.
#[test]
fn scene_may_be_called_as_it_likes() {
    let copy = RoomCopy::new();
    let scene = copy.file("R&D #1 <50%>.obj");
    std::fs::rename(copy.file("room.obj"), &scene).expect("renamed");
    let out = copy.file("out");
    let (scene, folder) = (scene.to_str().expect("text"), out.to_str().expect("text"));
    let args = ["reproduce", "--quick", "--scene", scene, "--out", folder];
    let text = stdout_of(&args);
    assert!(!text.contains("What differs") && text.contains("R&D #1 <50%>"));
    let page = std::fs::read_to_string(out.join("index.html")).expect("a page");
    let links = page.split("href=\"").skip(1).map(|rest| rest.split('"').next().expect("an end"));
    for link in links {
        let file = std::fs::read_to_string(out.join(link)).unwrap_or_else(|_| panic!("{link}"));
        if link.ends_with(".svg") {
            roxmltree::Document::parse(&file).unwrap_or_else(|error| panic!("{link}: {error}"));
        }
    }
}
