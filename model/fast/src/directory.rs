//! Twin of [`saarcor_model::vm::Directory`] and of the [`Set`] under it: other steps on the same state.
//!
//! Nearly every access of a picture is to the line that its set used last. Such an access changes
//! nothing, and so needs no step. Which way hits otherwise cannot be predicted: the search has no
//! branches. Equal by the theorems of `saarcor-proofs`, `equal::directory`.

use saarcor_model::vm::{Directory, LineAddr, Metadata, Outcome, Policy, Set, Way};

/// The way that holds `line`: twin of [`Set::way_of`].
#[inline(always)]
#[must_use]
pub fn way_of<const WAYS: usize>(set: &Set<WAYS>, line: LineAddr) -> Option<Way> {
    let mut found = WAYS;
    for way in 0..WAYS {
        found = if holds(set, way as u8, line) { way } else { found };
    }
    (found < WAYS).then_some(Way(found as u8))
}

/// The way of `line` if it was used (FIFO: loaded) last: then an access to it changes nothing.
///
/// With PLRU, whose bits do not say which way was used last: none.
#[inline(always)]
#[must_use]
pub fn way_if_youngest<const WAYS: usize>(set: &Set<WAYS>, line: LineAddr, policy: Policy) -> Option<Way> {
    let youngest = set.order[0];
    (policy != Policy::Plru && holds(set, youngest, line)).then_some(Way(youngest))
}

#[inline(always)]
fn holds<const WAYS: usize>(set: &Set<WAYS>, way: u8, line: LineAddr) -> bool {
    set.resident[usize::from(way)] & (set.lines[usize::from(way)] == line)
}

/// The step of a set: twin of [`Set::access`].
#[inline(always)]
#[must_use]
pub fn access_set<const WAYS: usize>(
    set: &Set<WAYS>,
    line: LineAddr,
    policy: Policy,
) -> (Set<WAYS>, Outcome) {
    let mut next = *set;
    if let Some(way) = way_of(set, line) {
        if policy != Policy::Fifo {
            touch(&mut next, way, policy);
        }
        return (next, Outcome::Hit { way });
    }
    let way = free_way(set).unwrap_or_else(|| victim(set, policy));
    let slot = usize::from(way.0);
    let evicted = set.resident[slot].then_some(set.lines[slot]);
    next.lines[slot] = line;
    next.resident[slot] = true;
    touch(&mut next, way, policy);
    (next, Outcome::Miss { way, evicted })
}

/// The step of a directory of any version: twin of [`Directory::access`].
// A call would cost more than the step that it makes: half of the throughput, measured.
#[inline(always)]
pub fn access<const WAYS: usize, M: Metadata<WAYS>>(
    directory: &mut Directory<WAYS, M>,
    line: LineAddr,
) -> Outcome {
    directory.counters.accesses += 1;
    let policy = directory.config.policy;
    let index = directory.config.set_of(line);
    let set = directory.metadata.load(index);
    if let Some(way) = way_if_youngest(&set, line, policy) {
        return Outcome::Hit { way };
    }
    let (next, outcome) = access_set(&set, line, policy);
    directory.metadata.store(index, &next);
    if let Outcome::Miss { evicted, .. } = outcome {
        directory.counters.misses += 1;
        directory.counters.evictions += u64::from(evicted.is_some());
    }
    outcome
}

/// The free way of the lowest number.
#[inline(always)]
fn free_way<const WAYS: usize>(set: &Set<WAYS>) -> Option<Way> {
    let mut free = WAYS;
    for way in (0..WAYS).rev() {
        free = if set.resident[way] { free } else { way };
    }
    (free < WAYS).then_some(Way(free as u8))
}

/// The way whose line a full set evicts.
#[inline(always)]
fn victim<const WAYS: usize>(set: &Set<WAYS>, policy: Policy) -> Way {
    match policy {
        Policy::Lru | Policy::Fifo => Way(set.order[WAYS - 1]),
        Policy::Plru => {
            let mut node = 1;
            for _ in 0..WAYS.ilog2() {
                node = 2 * node + usize::from(set.order[node]);
            }
            Way((node - WAYS) as u8)
        }
    }
}

/// Makes `way` the youngest; with PLRU, turns the tree away from it.
#[inline(always)]
fn touch<const WAYS: usize>(set: &mut Set<WAYS>, way: Way, policy: Policy) {
    match policy {
        Policy::Lru | Policy::Fifo => {
            let mut moved = way.0;
            let mut closed = false;
            for place in &mut set.order {
                let here = *place;
                *place = if closed { here } else { moved };
                closed |= here == way.0;
                moved = here;
            }
        }
        Policy::Plru => {
            let mut node = WAYS + usize::from(way.0);
            for _ in 0..WAYS.ilog2() {
                set.order[node / 2] = u8::from(node & 1 == 0);
                node /= 2;
            }
        }
    }
}
