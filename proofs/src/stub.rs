//! As much of Kani's library as the theorems use, so that what Kani sees is type-checked on
//! machines without Kani: `cargo check -p saarcor-proofs` with the flags `--cfg kani --cfg
//! kani_stub`. Nothing of it runs.

/// Any value.
pub fn any<T: Default>() -> T {
    T::default()
}

/// Restricts the values.
pub fn assume(_holds: bool) {}

/// What Kani draws of a theorem: sizes and ranges, found by playing the body, as it is compiled for
/// Kani, many times with values at random.
#[cfg(test)]
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    random: u64,
    /// Whether this case is one of zeros and ones.
    bits: bool,
    scope: crate::scope::Scope,
}

#[cfg(test)]
impl Recorder {
    fn below(&mut self, bound: u64) -> u64 {
        // splitmix64.
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.random;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed = mixed ^ (mixed >> 31);
        if bound == 0 { mixed } else { mixed % bound }
    }

    /// Plays a body; its scope, and in how many cases its assumptions held to the end.
    pub fn play(body: fn(&mut Self) -> crate::source::Holds, cases: u32) -> (String, u32) {
        let mut recorder = Self::default();
        let mut whole = 0;
        for case in 0..cases {
            recorder.bits = case % 2 == 1;
            recorder.scope.begin();
            whole += u32::from(body(&mut recorder).is_ok());
        }
        (recorder.scope.text(), whole)
    }
}

#[cfg(test)]
impl crate::source::Source for Recorder {
    fn value<T: crate::source::Value>(
        &mut self,
        name: &'static str,
        full: std::ops::RangeInclusive<T>,
        small: &'static [T],
    ) -> T {
        let [low, high]: [u64; 2] = [*full.start(), *full.end()].map(Into::into);
        self.scope.draw(name, [low, high]);
        // Small values, which legal states have more often than others; in every other case bits.
        match (self.below(16), self.bits) {
            (0, _) => T::above(*full.start(), self.below((high - low).wrapping_add(1))),
            (_, true) => T::above(*full.start(), self.below((high - low).min(1) + 1)),
            _ if small.is_empty() => T::above(*full.start(), self.below((high - low).min(3) + 1)),
            _ => small[self.below(small.len() as u64) as usize],
        }
    }

    fn size(&mut self, name: &'static str, value: usize) {
        self.scope.size(name, value as u64);
    }

    fn cover(&mut self, _label: crate::source::Label, _reached: bool) {}
}

/// Prints what Kani draws of each theorem, for the list that `tests/lists.rs` keeps.
#[test]
fn scopes_of_kani() {
    for theorem in crate::theorems().filter(|theorem| theorem.not_for_kani.is_none()) {
        let (scope, whole) = Recorder::play(theorem.recorded, 4_000);
        // Of what comes after assumptions that no case met nothing would be seen.
        assert!(whole > 0, "{}: no case to the end", theorem.harness());
        println!("scope of {}::{}: {scope}", theorem.unit(), theorem.name);
    }
}
