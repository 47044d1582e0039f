//! Twin of [`saarcor_model::vm::FirstLevel`] without bytes, as the chip in time has it: other steps on
//! the same state.
//!
//! A division takes as long as all else here, and few reads leave their line. Equal by the theorems
//! of `saarcor-proofs`, `equal::first_level`.

use super::directory::{access_set, way_if_youngest, way_of};
use saarcor_model::vm::{FirstLevel, Hash, HostAddr, LineAddr, Outcome};

/// The first and the last line that a read of `bytes` at `addr` touches, of lines of `line_bytes` from
/// `base` on: twin of [`FirstLevel::lines_of`].
///
/// Without meaning for a read that has no byte, begins below `base`, or goes beyond the end of the
/// address space: the units make none of these.
#[inline(always)]
#[must_use]
pub fn first_and_last_line(base: HostAddr, line_bytes: u32, addr: HostAddr, bytes: u16) -> (u32, u32) {
    let from_base = addr.0.saturating_sub(base.0);
    let (first, offset) = (from_base / line_bytes, from_base % line_bytes);
    let last_offset = offset + u32::from(bytes).saturating_sub(1);
    let further = if last_offset < line_bytes { 0 } else { last_offset / line_bytes };
    (first, first + further)
}

/// Whether the cache holds a line: twin of [`FirstLevel::is_resident`].
#[inline(always)]
#[must_use]
pub fn is_resident<const WAYS: usize>(cache: &FirstLevel<WAYS, ()>, line: LineAddr) -> bool {
    way_of(&cache.sets[set_of(cache, line)].set, line).is_some()
}

/// The step: twin of [`FirstLevel::access`].
#[inline(always)]
pub fn access<const WAYS: usize>(cache: &mut FirstLevel<WAYS, ()>, line: LineAddr) -> Outcome {
    cache.counters.accesses += 1;
    let index = set_of(cache, line);
    let set = &mut cache.sets[index];
    if let Some(way) = way_if_youngest(&set.set, line, cache.policy) {
        return Outcome::Hit { way };
    }
    let (next, outcome) = access_set(&set.set, line, cache.policy);
    set.set = next;
    if let Outcome::Miss { way, evicted } = outcome {
        set.dirty[usize::from(way.0)] = false;
        cache.counters.misses += 1;
        cache.counters.evictions += u64::from(evicted.is_some());
    }
    outcome
}

#[inline(always)]
fn set_of<const WAYS: usize>(cache: &FirstLevel<WAYS, ()>, line: LineAddr) -> usize {
    Hash::Low.set_of(line, cache.sets.len().trailing_zeros()).0 as usize
}
