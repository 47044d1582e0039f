//! The virtual memory of §3: the on-board memory as a cache of host memory.
//!
//! Reading order: [`HostAddr`] and the other units; the shape of the cache ([`Geometry`]) and its
//! index [`Hash`](enum@Hash); one [`Set`] of it, whose step is the heart of all, and the 40 bits of metadata of a
//! line ([`Entry`]); where the metadata of the sets lies ([`Metadata`]), in version A on the chip
//! ([`OnChip`]); the [`Directory`], which decides what lies where; a set with contents ([`DataSet`]);
//! version B, whose metadata lies behind a cache ([`CachedMetadata`]); the interface of every memory
//! ([`Memory`]); the [`VirtualMemory`]; and the first-level caches in front of it ([`FirstLevel`]).

mod units;

mod geometry;
mod hash;

mod entry;
mod set;

mod directory;
mod version_a;

mod data_set;
mod version_b;

mod memory;
mod virtual_memory;

mod first_level;

pub use data_set::{DataSet, WriteBack};
pub use directory::{CacheConfig, Counters, Directory};
pub use entry::{Corrupt, ENTRY_BYTES, Entry};
pub use first_level::{FIRST_LEVEL_WAYS, FirstLevel, FirstLevelCaches};
pub use geometry::{Geometry, GeometryError, MAX_MEMORY, MAX_WAYS};
pub use hash::Hash;
pub use memory::{HostMemory, Memory, Observed, Observer, Unit, WholeScene};
pub use set::{Outcome, Policy, Set};
pub use units::{Bytes, CardAddr, HostAddr, LineAddr, SetIndex, Way};
pub use version_a::{Metadata, OnChip};
pub use version_b::{CachedMetadata, MetadataObserver, MetadataTraffic};
pub use virtual_memory::VirtualMemory;
