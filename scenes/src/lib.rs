//! Scenes for the SaarCOR model.
//!
//! * [`load_obj`] reads a scene from OBJ and MTL files, PNG and JPEG images, a camera path
//!   (`camera.csv`) and lights (`lights.csv`); [`export_obj`] writes one that reads back the same.
//! * [`builtin`] makes scenes of the kinds that the paper's Table 1 names.
//! * [`kdbuild`] builds the kd-tree that the chip traverses.
//!
//! ```
//! use saarcor_scenes::kdbuild::{BuildOptions, build};
//!
//! let scene = saarcor_scenes::builtin::builtin("pquake3-nlnt").expect("a built-in scene");
//! assert_eq!(scene.triangles.len(), 46_356);
//! let tree = build(&scene.triangles, &BuildOptions::default(), &|_| ());
//! assert!(tree.check(scene.triangles.len()).is_ok());
//! ```
//!
//! Wrong input never panics: each error of a file is a [`SceneError`], one line that says what is
//! wrong, where, and what would be right. What others read nonetheless is read, with a [`Warning`].

pub mod builtin;
mod csv;
mod error;
mod export;
pub mod kdbuild;
mod obj;
mod overview;
mod text;
mod warning;

pub use csv::{read_cameras, read_lights};
pub use error::SceneError;
pub use export::{TEMPORARY, export_obj, temporary_prefix};
pub use obj::{LoadOptions, Loaded, load_obj};
pub use overview::overview;
pub use saarcor_random::Random;
pub use warning::Warning;
