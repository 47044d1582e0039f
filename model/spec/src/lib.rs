//! The executable specification of the SaarCOR ray tracing chip and its virtual memory (Schmittler, Leidinger, Slusallek: *A
//! Virtual Memory Architecture for Real-Time Ray Tracing Hardware*, 2003).
//!
//! ```
//! use saarcor_model::vm::{Bytes, CacheConfig, Directory, Geometry, Hash, HostAddr, Outcome, Policy, VirtualMemory};
//!
//! let host: Vec<u8> = (0..=255).collect();                  // the PC's memory
//! let geometry = Geometry::new(Bytes(1024), Bytes(64), 4)?; // the card: 1 KiB, lines of 64 bytes, 4 ways
//! let config = CacheConfig { geometry, hash: Hash::AddUpper, policy: Policy::Lru };
//! let mut memory = VirtualMemory::new(Directory::<4>::new(config), host);
//!
//! let mut bytes = [0; 4];
//! let outcome = memory.read_in_line(HostAddr(100), &mut bytes);
//! assert!(matches!(outcome, Outcome::Miss { evicted: None, .. }));
//! assert_eq!(bytes, [100, 101, 102, 103]);
//! # Ok::<(), saarcor_model::vm::GeometryError>(())
//! ```
//!
//! The code is written to be read, beside `model/SPEC.md`, which numbers the requirements (`VM-1` ...) that the code names, and
//! `model/GLOSSARY.md`, which explains the words. Read the groups in this order:
//!
//! | group | holds |
//! |---|---|
//! | [`vm`] | the virtual memory of §3: units, geometry, hash, set, metadata, versions A and B, first-level caches |
//! | [`host`] | what lies in host memory: the scene, the kd-tree, records, textures, their layout |
//! | [`rays`] | the units of a pipeline: camera, traversal, triangle tests, shading |
//! | [`time`] | the chip in time: operations, standard numbers, memory chips, bus, the chip cycle by cycle |
//!
//! Inside a group the files have no part in the paths: `use saarcor_model::vm::{Geometry, Set}`.
//!
//! The crate is pure: no input or output, no clock, no randomness, no global state. Fused multiply-add is not used: each `*` and `+`
//! rounds by itself, and cameras and highlights take `tan` and `powf` from the crate libm, so that everything gives the same on every
//! machine. What runs fast is its twin, `saarcor-fast`.

pub mod host;
pub mod rays;
pub mod time;
pub mod vm;
