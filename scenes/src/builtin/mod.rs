//! The built-in scenes: procedural stand-ins for the scenes of the paper's Table 1, of the same
//! kind and with the same numbers of triangles and lights and the same bytes of textures.
//!
//! Each is a pure function of its name. Units are metres, y is up.

mod building;
mod conference;
mod cruiser;
mod equipment;
mod finish;
mod furniture;
mod mesh;
mod palette;
mod path;
mod pquake3;
mod sodahall;
mod texture;

use saarcor_model::host::Scene;

/// The scenes of Table 1 (§4, Stated), in its order.
pub const TABLE_1: [&str; 9] = [
    "pquake3-nlnt",
    "conference-nl",
    "sodahall",
    "pquake3-nt",
    "conference",
    "conference-8l",
    "pquake3-nl",
    "pquake3",
    "cruiser",
];

/// Builds the scene of a name; `None` for a name that is none.
///
/// A name is `pquake3`, `conference`, `sodahall` or `cruiser` and, as in Table 1, a suffix: `-nl`
/// without lights, `-nt` without textures and bump maps, `-nlnt` without either, or, for the
/// conference room only, `-8l` with eight lights.
#[must_use]
pub fn builtin(name: &str) -> Option<Scene> {
    let (base, suffix) = name.split_once('-').map_or((name, None), |(b, s)| (b, Some(s)));
    let (lit, textured, eight) = match suffix {
        None => (true, true, false),
        Some("nl") => (false, true, false),
        Some("nt") => (true, false, false),
        Some("nlnt") => (false, false, false),
        Some("8l") if base == "conference" => (true, true, true),
        Some(_) => return None,
    };
    let mut scene = match base {
        "pquake3" => pquake3::scene(textured),
        "conference" => conference::scene(eight),
        "sodahall" => sodahall::scene(),
        "cruiser" => cruiser::scene(textured),
        _ => return None,
    };
    if !lit {
        scene.lights.clear();
    }
    Some(scene)
}
