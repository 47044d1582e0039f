//! The twins: what had to be written otherwise to be fast.
//!
//! `saarcor-model` is read; this is run. Each module names its twin in the specification and does the same, in another way.
//! Nothing here is believed: `saarcor-proofs` shows in `equal`, for each module, that from corresponding states one step of both
//! gives the same and leaves corresponding states. A module stands here only for a measured gain.
//!
//! ```
//! use saarcor_fast::directory;
//! use saarcor_model::vm::{Bytes, CacheConfig, Directory, Geometry, Hash, LineAddr, Policy};
//!
//! let geometry = Geometry::new(Bytes(1024), Bytes(64), 4)?;
//! let config = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
//! let mut specified = Directory::<4>::new(config);
//! let mut fast = specified.clone();
//! for line in [3, 7, 3, 11, 15, 19, 7] {
//!     assert_eq!(directory::access(&mut fast, LineAddr(line)), specified.access(LineAddr(line)));
//!     assert_eq!(fast, specified);
//! }
//! # Ok::<(), saarcor_model::vm::GeometryError>(())
//! ```
//!
//! To count what a cache does with many accesses there is one function, [`traffic::Traffic::access`] of a slice of `u32` line
//! numbers: versions A and B, any legal geometry, hash and policy. `cargo bench -p saarcor-fast` runs it beside a loop in the
//! way of Valgrind's cachegrind.
//!
//! Read `saarcor-model` first; then any of these modules beside its twin.

pub mod adaptive;
pub mod chip;
pub mod directory;
pub mod first_level;
pub mod pci;
pub mod sdram;
pub mod stacks;
pub mod traffic;
pub mod version_b;
