//! What is measured of the SaarCOR model: options in, rows of data out.
//!
//! Nothing here prints, parses a command line or draws. A study that takes long reports its stages to a
//! [`Monitor`](monitor::Monitor).
//!
//! A picture through a virtual memory of 4 KiB is the picture without one:
//!
//! ```
//! use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy};
//! use saarcor_studies::monitor::Silent;
//! use saarcor_studies::picture::{through_virtual_memory, through_whole_scene};
//! use saarcor_studies::trace::{PacketSize, TraceOptions};
//! use saarcor_studies::world::{World, WorldOptions};
//!
//! let world = World::open(&WorldOptions::new("pquake3-nlnt"), &Silent)?;
//! let options = TraceOptions { resolution: (64, 48), packet: PacketSize::Rays64, max_bounces: 5 };
//! let geometry = Geometry::new(Bytes(4096), Bytes(128), 4)?;
//! let cache = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
//! let (picture, counters) = through_virtual_memory(&world, 150, &options, cache);
//! assert!(counters.evictions > 0);
//! assert_eq!(picture, through_whole_scene(&world, 150, &options));
//! # Ok::<(), saarcor_studies::StudyError>(())
//! ```
//!
//! Read [`world`] first, then the studies in the order of this table.
//!
//! | module | subject |
//! |---|---|
//! | [`world`] | a scene made ready for the chip |
//! | [`trace`] | how pictures are traced |
//! | [`summary`] | the features that a scene needs, and the bytes of its image |
//! | [`picture`] | a frame through any memory |
//! | [`caches`] | virtual memories of any sizes that see the same reads |
//! | [`recorded`] | accesses that somebody recorded, played to them |
//! | [`walk`] | step one of §4: the traffic of a walk through a scene |
//! | [`hot_spots`] | the frames of a walk that are simulated on the chip |
//! | [`simulate`] | step two of §4: a frame on the chip, cycle by cycle |
//! | [`frames`] | the frames of a walk on the chip |
//! | [`traffic`] | where the bytes of such a frame go |
//! | [`sampling`] | such frames from a few of them, with intervals |
//! | [`sweep`] | one frame on many chips |
//! | [`metadata`] | the metadata law of §3 |
//! | [`accuracy`] | triangle tests and number formats: speed against error |
//! | [`crosscheck`] | the model, the exact judge and Embree, ray by ray |
//! | [`standard`] | the standard configuration |
//! | [`names`] | names of kernels, versions and buses |
//! | [`monitor`] | how a study reports its stages |
//! | [`error`] | why a study fails |

pub mod accuracy;
pub mod caches;
pub mod crosscheck;
mod dispatch;
pub mod error;
pub mod frames;
pub mod hot_spots;
pub mod metadata;
pub mod monitor;
pub mod names;
pub mod picture;
pub mod recorded;
pub mod sampling;
pub mod simulate;
pub mod standard;
pub mod summary;
pub mod sweep;
pub mod trace;
pub mod traffic;
pub mod walk;
pub mod world;

pub use error::StudyError;
