//! Small chips and their programs.

use crate::equal::chip::{OPERATIONS, chip, operation};
use crate::source::Source;
use saarcor_model::time::{ChipConfig, Operation, Program, Programs, Version};
use saarcor_model::vm::HostAddr;

/// Four packets of two operations each, out of three operations.
fn programs(s: &mut impl Source) -> Programs {
    let [a, b, c] = [(); 3].map(|()| operation(s, &OPERATIONS));
    let packet = |operations: &[Operation]| Program::from(operations);
    let packets = vec![packet(&[a, b]), packet(&[b, c]), packet(&[c, a]), packet(&[a, c])];
    Programs { packets, triangles: HostAddr(0) }
}

/// A small chip without virtual memory, on which several threads want the same unit, and its programs.
///
/// Small scope: one pipeline of three threads, and two of three; caches of one port, and of three.
pub fn contended(s: &mut impl Source) -> (ChipConfig, Programs) {
    let mut config = chip(s.value("chip", 0..=u64::MAX, &[0, 1]), Version::None);
    config.threads = s.value("threads a pipeline", 1..=5, &[3]);
    let ports = s.value("ports", 1..=3, &[1, 3]);
    config.l1.iter_mut().for_each(|l1| l1.ports = ports);
    (config, programs(s))
}

/// A small chip of any version, and its programs.
///
/// Small scope: one pipeline of three threads, with first-level lines of 4 bytes, and of 7, of which some lie in two
/// lines of the virtual memory.
pub fn small(s: &mut impl Source) -> (ChipConfig, Programs) {
    let version = match s.value("version (none, A, B)", 0..=2_u8, &[0, 1, 2]) {
        0 => Version::None,
        1 => Version::A,
        _ => Version::B,
    };
    let mut config = chip(s.value("chip", 0..=u64::MAX, &[0]), version);
    config.threads = s.value("threads a pipeline", 1..=4, &[3]);
    let line = s.value("bytes of a first-level line", 4..=8, &[4, 7]);
    config.l1.iter_mut().for_each(|l1| l1.line = line);
    (config, programs(s))
}
