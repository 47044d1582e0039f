//! Where the metadata of the sets is kept, and version A (§3), which keeps it on the chip.

use super::set::{Policy, Set};
use super::units::SetIndex;

/// Where the metadata of the sets is kept: the versions of §3 differ in nothing else.
pub trait Metadata<const WAYS: usize> {
    /// The state of the set `index`.
    fn load(&mut self, index: SetIndex) -> Set<WAYS>;

    /// Replaces the state of the set `index`.
    fn store(&mut self, index: SetIndex, set: &Set<WAYS>);

    /// Makes all sets empty.
    fn clear(&mut self);
}

/// Version A: the metadata of all sets lies on the chip (§3).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OnChip<const WAYS: usize> {
    /// Replacement: says how an empty set looks.
    pub policy: Policy,
    /// The sets, in the order of their indices.
    pub sets: Vec<Set<WAYS>>,
}

impl<const WAYS: usize> OnChip<WAYS> {
    /// The metadata of so many empty sets.
    pub fn new(sets: u64, policy: Policy) -> Self {
        Self { policy, sets: vec![Set::empty(policy); sets as usize] }
    }
}

impl<const WAYS: usize> Metadata<WAYS> for OnChip<WAYS> {
    fn load(&mut self, index: SetIndex) -> Set<WAYS> {
        self.sets[index.0 as usize]
    }

    fn store(&mut self, index: SetIndex, set: &Set<WAYS>) {
        self.sets[index.0 as usize] = *set;
    }

    fn clear(&mut self) {
        self.sets.fill(Set::empty(self.policy));
    }
}
