//! Which frames of a walk run on the chip.
//!
//! The walk is cut into stretches of equally many frames, and one frame of each is drawn at random: a stratified sample
//! (Cochran, Sampling Techniques, 3rd ed. 1977, ch. 5). Frames that follow one another are alike, so that the stretches are
//! strata; and between two frames that were drawn there are never more than two stretches. Frames that are unlike
//! all others run on the chip in any case, a take-all stratum (Hidiroglou 1986): those without a frame before that is
//! like them, whose caches are cold.

use super::fraction::SampleFraction;
use crate::error::StudyError;
use crate::hot_spots::cuts;
use crate::world::World;
use saarcor_random::Random;
use std::collections::BTreeSet;

/// Fewest frames that are drawn: from fewer no interval is worth its width.
pub const LEAST_DRAWN: usize = 6;

/// Which frames of a walk run on the chip, by their places in the walk.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Those that run in any case.
    pub certain: BTreeSet<usize>,
    /// Those that were drawn at random.
    pub drawn: BTreeSet<usize>,
    /// All that can be drawn, in the order of the walk.
    others: Vec<usize>,
    random: Random,
}

impl Choice {
    /// Of a walk through `frames` of the world's path: certain are the path's first frame and those after a cut (WK-5). `seed` decides
    /// what is drawn.
    #[must_use]
    pub fn new(world: &World, frames: &[usize], seed: u64) -> Self {
        let cuts = cuts(&world.path);
        let is_cold = |place: &usize| frames[*place] == 0 || cuts.contains(&frames[*place]);
        let (certain, others) = (0..frames.len()).partition::<Vec<_>, _>(is_cold);
        Self {
            certain: certain.into_iter().collect(),
            drawn: BTreeSet::new(),
            others,
            random: Random::new(seed),
        }
    }

    /// Draws until each of so many stretches has a frame that was drawn.
    pub fn draw(&mut self, stretches: usize) {
        let Self { drawn, others, random, .. } = self;
        let begin = |stretch: usize| stretch * others.len() / stretches;
        for stretch in 0..stretches {
            let of_stretch = &others[begin(stretch)..begin(stretch + 1)];
            if !of_stretch.is_empty() && !of_stretch.iter().any(|place| drawn.contains(place)) {
                drawn.insert(random.pick(of_stretch));
            }
        }
    }

    /// How many frames of the others a part of the walk is, the certain ones counted in.
    ///
    /// # Errors
    /// If they are too few, with the part that is enough.
    pub fn of_part(&self, part: SampleFraction) -> Result<usize, StudyError> {
        let all = self.certain.len() + self.others.len();
        let count = part.of(all).saturating_sub(self.certain.len());
        let enough = LEAST_DRAWN.min(self.others.len());
        if count >= enough {
            return Ok(count.min(self.others.len()));
        }
        let why = format!(
            "{count} of {all} frames to be drawn, and {} that run in any case; at least {enough} have to be drawn: {}/{all} \
             is enough",
            self.certain.len(),
            self.certain.len() + enough
        );
        Err(StudyError::SmallSample { sample: part.to_string(), why })
    }

    /// Whether all frames run on the chip.
    #[must_use]
    pub fn is_all(&self) -> bool {
        self.drawn.len() == self.others.len()
    }

    /// All that run on the chip, in the order of the walk.
    #[must_use]
    pub fn all(&self) -> Vec<usize> {
        self.certain.union(&self.drawn).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(others: usize, seed: u64) -> Choice {
        let others = (0..others).collect();
        Choice { certain: BTreeSet::new(), drawn: BTreeSet::new(), others, random: Random::new(seed) }
    }

    #[test]
    fn each_stretch_has_a_frame_and_each_frame_its_chance() {
        let mut times = [0; 60];
        for seed in 0..6000 {
            let mut choice = of(60, seed);
            choice.draw(6);
            let stretches: Vec<usize> = choice.drawn.iter().map(|place| place / 10).collect();
            assert_eq!(stretches, [0, 1, 2, 3, 4, 5]);
            choice.drawn.iter().for_each(|place| times[*place] += 1);
        }
        // A binomial's standard deviation is 23; five of them, for any of 60 frames.
        assert!(times.iter().all(|&times| i32::abs_diff(times, 600) < 115), "{times:?}");
    }

    #[test]
    fn more_stretches_keep_what_was_drawn() {
        let mut choice = of(100, 3);
        choice.draw(8);
        let few = choice.drawn.clone();
        choice.draw(12);
        assert!(choice.drawn.is_superset(&few) && choice.drawn.len() >= 12);
        choice.draw(100);
        assert!(choice.is_all());
    }

    #[test]
    fn too_few_frames_are_refused() {
        let part = |text: &str| text.parse().expect("a part");
        let error = of(100, 0).of_part(part("1/50")).expect_err("two frames").to_string();
        assert!(error.contains("6/100"), "{error}");
        assert_eq!(of(100, 0).of_part(part("1/10")).expect("ten"), 10);
        assert_eq!(of(3, 0).of_part(part("1")).expect("all"), 3);
    }
}
