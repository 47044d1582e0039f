//! What will happen in which cycle.

use super::NONE;
use saarcor_model::time::MAX_LATENCY;

/// Events of the next [`WHEEL`] cycles: for each of these a list of numbers, of threads and then of
/// units. Each number is in one list at most.
pub(super) struct Wheel {
    first: Vec<u32>,
    pub(super) next: Vec<u32>,
    occupied: [u64; WHEEL / 64],
}

/// More cycles than lie between an event and its cause: rays of an operation and latency.
const WHEEL: usize = 2048;
const _: () = assert!(WHEEL > MAX_LATENCY as usize + u8::MAX as usize);

impl Wheel {
    pub(super) fn new(numbers: usize) -> Self {
        Self { first: vec![NONE; WHEEL], next: vec![NONE; numbers], occupied: [0; WHEEL / 64] }
    }

    #[inline]
    pub(super) fn insert(&mut self, cycle: u64, number: u32) {
        let slot = cycle as usize % WHEEL;
        self.next[number as usize] = std::mem::replace(&mut self.first[slot], number);
        self.occupied[slot / 64] |= 1 << (slot % 64);
    }

    /// Takes the list of a cycle; [`Wheel::next`] leads on from its first number.
    #[inline]
    pub(super) fn take(&mut self, cycle: u64) -> u32 {
        let slot = cycle as usize % WHEEL;
        self.occupied[slot / 64] &= !(1 << (slot % 64));
        std::mem::replace(&mut self.first[slot], NONE)
    }

    /// The next cycle from `cycle` on that has events.
    #[inline]
    pub(super) fn upcoming(&self, cycle: u64) -> Option<u64> {
        let slot = cycle as usize % WHEEL;
        let here = self.occupied[slot / 64] >> (slot % 64);
        if here != 0 {
            return Some(cycle + u64::from(here.trailing_zeros()));
        }
        // The rest of the ring, word by word, and at last what of the first word was left out.
        let words = WHEEL / 64;
        let to_next_word = 64 - slot as u64 % 64;
        (0..words as u64).find_map(|i| {
            let word = self.occupied[(slot / 64 + 1 + i as usize) % words];
            let found = cycle + to_next_word + 64 * i + u64::from(word.trailing_zeros());
            (word != 0).then_some(found)
        })
    }
}
