//! One set of the cache, as a pure step on a small state (§3: an n-way set-associative cache).

use super::units::{LineAddr, Way};

/// Which line a full set evicts. The paper names no policy; that of the standard chip is
/// [`POLICY`](crate::time::standard::POLICY) (Assumed).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Policy {
    /// The least recently used line.
    Lru,
    /// The line that was loaded first.
    Fifo,
    /// The line that a binary tree of bits points at: each bit points away from the half used last.
    Plru,
}

/// The result of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The line was resident in `way`.
    Hit {
        /// The way that holds the line.
        way: Way,
    },
    /// The line was loaded from the host into `way`.
    Miss {
        /// The way that holds the line now.
        way: Way,
        /// The line that this way held before; none if it was free.
        evicted: Option<LineAddr>,
    },
}

impl Outcome {
    /// The way that holds the line after the access.
    #[must_use]
    pub fn way(self) -> Way {
        match self {
            Self::Hit { way } | Self::Miss { way, .. } => way,
        }
    }
}

/// One set: for each way the metadata entry of its line, one array a field (VM-4).
///
/// The fields are public and [`Set::is_valid`] says which values are legal, so that a proof can
/// start from any legal state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Set<const WAYS: usize> {
    /// The line in each way: the tag. Meaningless if the way is free.
    pub lines: [LineAddr; WAYS],
    /// Whether the way holds a line.
    pub resident: [bool; WAYS],
    /// Management bits, as many entries as there are ways.
    ///
    /// LRU and FIFO: the ways from the one used (loaded) last to the one used (loaded) first; a
    /// permutation of `0 .. WAYS`.
    /// PLRU: entry `i` is the bit of node `i` of a tree whose root is 1 and whose node `i` has
    /// the children `2 i` and `2 i + 1`; 1 points to the upper half. Entry 0 is not used: 0.
    pub order: [u8; WAYS],
}

impl<const WAYS: usize> Set<WAYS> {
    /// A set without lines.
    #[must_use]
    pub fn empty(policy: Policy) -> Self {
        let order = match policy {
            Policy::Lru | Policy::Fifo => std::array::from_fn(|way| way as u8),
            Policy::Plru => [0; WAYS],
        };
        Self { lines: [LineAddr(0); WAYS], resident: [false; WAYS], order }
    }

    /// The invariant: no line is resident twice, and the management bits are legal (VM-5).
    #[must_use]
    pub fn is_valid(&self, policy: Policy) -> bool {
        for a in 0..WAYS {
            for b in 0..a {
                if self.resident[a] && self.resident[b] && self.lines[a] == self.lines[b] {
                    return false;
                }
                if policy != Policy::Plru && self.order[a] == self.order[b] {
                    return false;
                }
            }
            let legal = match policy {
                Policy::Lru | Policy::Fifo => usize::from(self.order[a]) < WAYS,
                Policy::Plru => self.order[a] <= u8::from(a > 0),
            };
            if !legal {
                return false;
            }
        }
        true
    }

    /// The way that holds `line`.
    #[must_use]
    pub fn way_of(&self, line: LineAddr) -> Option<Way> {
        let mut found = None;
        for way in 0..WAYS {
            if self.resident[way] && self.lines[way] == line {
                found = Some(Way(way as u8));
            }
        }
        found
    }

    /// The step: uses `line`, which is loaded if it is not resident (VM-6).
    ///
    /// A free way is taken before a line is evicted, the lowest number first (VM-7, Assumed).
    #[must_use]
    pub fn access(&self, line: LineAddr, policy: Policy) -> (Self, Outcome) {
        let mut next = *self;
        if let Some(way) = self.way_of(line) {
            if policy != Policy::Fifo {
                next.touch(way, policy);
            }
            return (next, Outcome::Hit { way });
        }
        let way = self.free_way().unwrap_or_else(|| self.victim(policy));
        let slot = usize::from(way.0);
        let evicted = self.resident[slot].then_some(self.lines[slot]);
        next.lines[slot] = line;
        next.resident[slot] = true;
        next.touch(way, policy);
        (next, Outcome::Miss { way, evicted })
    }

    /// Forgets `line` (VM-8). The order of the other lines stays.
    #[must_use]
    pub fn invalidate(mut self, line: LineAddr) -> (Self, Option<Way>) {
        let way = self.way_of(line);
        if let Some(way) = way {
            self.resident[usize::from(way.0)] = false;
        }
        (self, way)
    }

    /// The free way of the lowest number.
    fn free_way(&self) -> Option<Way> {
        let mut free = None;
        for way in (0..WAYS).rev() {
            if !self.resident[way] {
                free = Some(Way(way as u8));
            }
        }
        free
    }

    /// The way whose line a full set evicts.
    fn victim(&self, policy: Policy) -> Way {
        match policy {
            Policy::Lru | Policy::Fifo => Way(self.order[WAYS - 1]),
            Policy::Plru => {
                let mut node = 1;
                for _ in 0..WAYS.ilog2() {
                    node = 2 * node + usize::from(self.order[node]);
                }
                Way((node - WAYS) as u8)
            }
        }
    }

    /// Makes `way` the one used last; with PLRU, turns the tree away from it.
    fn touch(&mut self, way: Way, policy: Policy) {
        match policy {
            Policy::Lru | Policy::Fifo => {
                // `way` comes first, and all that were before it move one place back.
                let mut previous = way.0;
                let mut found = false;
                for place in &mut self.order {
                    let here = *place;
                    if !found {
                        *place = previous;
                    }
                    found |= here == way.0;
                    previous = here;
                }
            }
            Policy::Plru => {
                let mut node = WAYS + usize::from(way.0);
                for _ in 0..WAYS.ilog2() {
                    self.order[node / 2] = u8::from(node & 1 == 0);
                    node /= 2;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A set of four is filled with lines 0 to 3, lines `used` are used again, and lines 10, 11, 12 are
    /// loaded: the lines that these evict.
    fn victims(policy: Policy, used: &[u32]) -> Vec<u32> {
        let mut set = Set::<4>::empty(policy);
        let mut victims = Vec::new();
        for &line in [0, 1, 2, 3].iter().chain(used).chain(&[10, 11, 12]) {
            let (next, outcome) = set.access(LineAddr(line), policy);
            assert!(next.is_valid(policy));
            set = next;
            if let Outcome::Miss { evicted: Some(line), .. } = outcome {
                victims.push(line.0);
            }
        }
        victims
    }

    #[test]
    fn policies_differ_in_their_victims() {
        assert_eq!(victims(Policy::Lru, &[0, 1]), [2, 3, 0]);
        assert_eq!(victims(Policy::Fifo, &[0, 1]), [0, 1, 2]);
        // After 3, 0, 1 the root points up and the upper node at way 2; then each load turns
        // the tree away from itself.
        assert_eq!(victims(Policy::Plru, &[0, 1]), [2, 0, 3]);
    }

    #[test]
    fn lowest_free_way_is_filled_first() {
        let mut set = Set::<4>::empty(Policy::Lru);
        for line in 0..4 {
            set = set.access(LineAddr(line), Policy::Lru).0;
        }
        set = set.invalidate(LineAddr(2)).0;
        set = set.invalidate(LineAddr(1)).0;
        let (_, outcome) = set.access(LineAddr(9), Policy::Lru);
        assert_eq!(outcome, Outcome::Miss { way: Way(1), evicted: None });
    }

    #[test]
    fn management_bits_that_name_no_way_or_lie_outside_of_the_tree_are_illegal() {
        let with = |policy, order| Set::<4> { order, ..Set::empty(policy) }.is_valid(policy);
        for policy in [Policy::Lru, Policy::Fifo] {
            assert!(with(policy, [3, 1, 0, 2]) && !with(policy, [4, 1, 0, 2]), "{policy:?}");
        }
        assert!(with(Policy::Plru, [0, 1, 1, 1]) && !with(Policy::Plru, [1, 0, 0, 0]));
    }

    #[test]
    fn one_way_is_direct_mapped() {
        for policy in [Policy::Lru, Policy::Fifo, Policy::Plru] {
            let set = Set::<1>::empty(policy).access(LineAddr(7), policy).0;
            assert!(set.is_valid(policy));
            let (_, outcome) = set.access(LineAddr(8), policy);
            assert_eq!(outcome, Outcome::Miss { way: Way(0), evicted: Some(LineAddr(7)) });
        }
    }
}
