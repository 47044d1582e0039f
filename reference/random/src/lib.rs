//! The one pseudo-random sequence of the workspace.
//!
//! Random sessions of the conformance kit, built-in scenes and samples are named by a seed, and mean the
//! same in every version: the sequence of a seed must never change. So it stands here, and is no
//! library's.
//!
//! ```
//! use saarcor_random::Random;
//!
//! let mut random = Random::new(17);
//! let die = 1 + random.below(6);
//! assert!((1..=6).contains(&die));
//! ```

/// The sequence of a seed: SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed, from its begin.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// A number below `end`, which is over 0 and at most 2³²: the upper 32 bits, scaled.
    #[inline]
    pub fn below(&mut self, end: u64) -> u64 {
        ((self.bits() >> 32) * end) >> 32
    }

    /// True in `percent` of a hundred cases.
    #[inline]
    pub fn percent(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    /// One of the items.
    ///
    /// # Panics
    /// If there is none.
    #[inline]
    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len() as u64) as usize]
    }

    /// A number in `low..high`: the remainder of 64 bits. Scenes were built with it, and so it differs from
    /// [`Random::below`].
    ///
    /// # Panics
    /// If the range is empty.
    pub fn range(&mut self, low: u32, high: u32) -> u32 {
        low + (self.bits() % u64::from(high - low)) as u32
    }

    /// A number in [0, 1), a multiple of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// A number between two.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequence_of_a_seed_never_changes() {
        let mut random = Random::new(1);
        // The first number of seed 1 as published with the generator.
        assert_eq!(random.bits(), 0x910a_2dec_8902_5cc1);
        assert!((0..1000).all(|_| random.below(3) < 3 && (5..7).contains(&random.range(5, 7))));
        assert!((0..1000).all(|_| (0.0..1.0).contains(&random.unit())));
    }
}
