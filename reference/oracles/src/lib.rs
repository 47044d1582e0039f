//! What the SaarCOR model is judged by.
//!
//! Every oracle here is the obvious way to do its work, slow and short, so that a reader accepts
//! it at a glance. Oracles use the model's types (addresses, triangles, configurations) and none
//! of its functions that decide something: a fault of the model cannot hide in its judge.
//!
//! ```
//! use saarcor_model::vm::{Bytes, CacheConfig, Directory, Geometry, Hash, LineAddr, Policy};
//! use saarcor_oracles::cache::NaiveCache;
//!
//! let geometry = Geometry::new(Bytes(1024), Bytes(64), 4)?;
//! let config = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
//! let (mut model, mut naive) = (Directory::<4>::new(config), NaiveCache::new(config));
//! for line in [3, 7, 3, 11, 15, 19, 7] {
//!     assert_eq!(model.access(LineAddr(line)), naive.access(LineAddr(line)));
//! }
//! # Ok::<(), saarcor_model::vm::GeometryError>(())
//! ```
//!
//! | oracle | judges |
//! |---|---|
//! | [`flat::FlatMemory`] | that the virtual memory is transparent |
//! | [`cache::NaiveCache`] | hits, misses, ways, victims and counters |
//! | [`cache::NaiveVirtualMemory`] | which bytes a unit receives, and as of when |
//! | [`card::CardShadow`] | that each part that the chip in time reads is the host's |
//! | [`metadata::NaiveTags`] | the metadata of version B, and what of it moves |
//! | [`search::closest_hit`] | kd-tree traversal |
//! | [`exact::judge`], [`exact::closest`] | triangle tests, and what a ray hits first |
//! | [`exact::crossings::crossings`] | how often a ray hits the triangles around an edge or a vertex |
//! | [`surfaces::case`] | owned edges, by rays at edges and vertices of surfaces |
//! | [`bounded::Bounded`] | how far off a triangle test that rounds may be, in any of the [`formats`] |
//! | [`embree`] | answers of the model, by Embree |
//! | [`bvh::Bvh`] | kd-tree traversal, in large scenes |
//! | [`memory_protocol::Checker`] | commands to the on-board memory, by the data sheet of its chips |

pub mod bounded;
pub mod bvh;
pub mod cache;
pub mod card;
pub mod embree;
pub mod exact;
pub mod flat;
pub mod formats;
pub mod memory_protocol;
pub mod metadata;
pub mod search;
pub mod surfaces;
