//! What will happen in which cycle.

use super::thread::NONE;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Against a map by cycles, over many turns of the wheel, with gaps of all lengths.
    #[test]
    fn every_event_is_found_in_its_cycle_and_nothing_before_it() {
        const NUMBERS: usize = 8;
        let mut wheel = Wheel::new(NUMBERS);
        let mut expected = BTreeMap::<u64, Vec<u32>>::new();
        // Numbers that look random: Knuth's linear congruential generator (MMIX).
        let mut state = 1_u64;
        let mut below = |end: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % end
        };
        let mut free: Vec<u32> = (0..NUMBERS as u32).collect();
        let mut now = 0;
        for _ in 0..5_000 {
            for _ in 0..below(free.len() as u64 + 1) {
                let reach = [2, 70, 300, WHEEL as u64 - 1][below(4) as usize];
                let (cycle, number) = (now + 1 + below(reach), free.pop().expect("one is free"));
                wheel.insert(cycle, number);
                expected.entry(cycle).or_default().push(number);
            }
            let next = expected.pop_first();
            assert_eq!(wheel.upcoming(now + 1), next.as_ref().map(|&(cycle, _)| cycle), "after {now}");
            let Some((cycle, mut numbers)) = next else { continue };
            now = cycle;
            let mut taken = Vec::new();
            let mut number = wheel.take(now);
            while number != NONE {
                taken.push(number);
                number = wheel.next[number as usize];
            }
            free.extend(&taken);
            taken.sort_unstable();
            numbers.sort_unstable();
            assert_eq!(taken, numbers, "in cycle {now}");
        }
    }
}
