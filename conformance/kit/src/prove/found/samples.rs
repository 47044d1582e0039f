//! A simulation of an implementation beside the specification of one of its sets.

use super::CLOCKS;
use crate::prove::config::ProveConfig;
use crate::prove::harness;
use crate::prove::simulation::{Simulation, ZERO};
use saarcor_model::vm::{CacheConfig, HostAddr, LineAddr};
use saarcor_random::Random;
use std::collections::BTreeMap;
use std::ops::Range;

/// What a simulation showed of wires: of each bit a word a clock, with a bit for each of 64 runs. The first clock is left
/// out.
pub(in crate::prove) struct Samples(pub(super) BTreeMap<(String, usize), Vec<u64>>);

impl Samples {
    /// Simulates an implementation beside a specification of one of its sets, in 64 runs of random requests to few lines
    /// of few sets, and notes the bits of wires.
    pub fn new(simulation: &mut Simulation, cache: &CacheConfig, wires: &[(String, usize)]) -> Self {
        let mut random = Random::new(0);
        let sets = cache.geometry.sets();
        let offset_bits = cache.geometry.line().0.trailing_zeros();
        let ways = cache.geometry.ways() as usize;
        // Of each run: its set, the lines that it asks for, most of them of that set, and how often it resets.
        let runs: Vec<(u32, Vec<u32>, u64)> = (0..64)
            .map(|_| {
                let set = random.below(sets) as u32;
                let mut lines = Vec::new();
                while lines.len() < ways + 3 {
                    let line = random.bits() as u32 >> offset_bits;
                    if cache.set_of(LineAddr(line)).0 == set {
                        lines.push(line);
                    }
                }
                lines.extend((0..3).map(|_| random.bits() as u32 >> offset_bits));
                (set, lines, random.pick(&[0, 1, 5]))
            })
            .collect();
        let bytes: Vec<u32> = runs.iter().map(|_| random.below(1 << offset_bits) as u32).collect();
        let inputs: Vec<(String, usize, usize)> =
            simulation.graph.inputs.iter().map(|((name, bit), index)| (name.clone(), *bit, *index)).collect();
        let bits: Vec<(String, usize)> =
            wires.iter().flat_map(|(name, width)| (0..*width).map(|bit| (name.clone(), bit))).collect();
        let mut samples: Vec<Vec<u64>> = vec![Vec::with_capacity(CLOCKS); bits.len()];
        let mut values = vec![0; simulation.graph.input_count()];
        for clock in 0..=CLOCKS {
            let mut address = [0_u64; 32];
            let mut reset = 0;
            for (run, (_, lines, resets)) in runs.iter().enumerate() {
                let host = HostAddr(
                    random.pick(lines) << offset_bits | random.bits() as u32 & ((1 << offset_bits) - 1),
                );
                for (bit, word) in address.iter_mut().enumerate() {
                    *word |= u64::from(host.0 >> bit & 1) << run;
                }
                reset |= u64::from(random.percent(*resets)) << run;
            }
            for (name, bit, index) in &inputs {
                values[*index] = match name.as_str() {
                    "clock" => 0,
                    "free_address" => address[*bit],
                    "free_witness" => {
                        runs.iter().enumerate().map(|(run, (set, ..))| u64::from(set >> bit & 1) << run).sum()
                    }
                    "free_reset" => reset,
                    "free_valid" | "free_ready" => random.bits() | random.bits(),
                    "free_forget" => random.bits() & random.bits() & random.bits(),
                    // Where bytes are looked at, one of a line that is asked for.
                    "free_byte" => {
                        let byte = |(run, (_, lines, _)): (usize, &(u32, Vec<u32>, u64))| {
                            let byte = lines[0] << offset_bits | bytes[run];
                            u64::from(byte >> bit & 1) << run
                        };
                        runs.iter().enumerate().map(byte).sum()
                    }
                    "free_planted" | ZERO => 0,
                    _ => random.bits(),
                };
            }
            simulation.settle(&mut values);
            for (place, sample) in bits.iter().zip(&mut samples) {
                if clock > 0 {
                    sample.push(simulation.graph.output(place).unwrap_or_default());
                }
            }
            simulation.rise();
        }
        Self(bits.into_iter().zip(samples).collect())
    }

    /// What it showed of some bits of a wire.
    pub fn bits<'a>(&'a self, wire: &'a str, numbers: Range<usize>) -> Vec<Bit<'a>> {
        numbers.map(|number| Bit { wire, number, samples: self.of(wire, number) }).collect()
    }

    /// What it showed of a bit of a wire.
    pub fn of(&self, name: &str, bit: usize) -> &[u64] {
        self.0.get(&(name.to_owned(), bit)).map_or(&[], Vec::as_slice)
    }

    /// Where there is no reset: a reset may clear an implementation at once.
    pub fn counts(&self) -> Vec<u64> {
        self.of("reset", 0).iter().map(|reset| !reset).collect()
    }
}

/// The wires of the harness that a simulation notes, with their widths.
#[must_use]
pub(in crate::prove) fn watched(config: &ProveConfig, cache: &CacheConfig) -> Vec<(String, usize)> {
    let ways = cache.geometry.ways() as usize;
    let of_bytes = config.data.iter().flat_map(|_| {
        [
            ("asks", 1),
            ("beat", beat_bits(cache)),
            ("want_address", 32),
            ("want_forgets", 1),
            ("want_sum", cache.geometry.set_bits() as usize),
            ("byte_lies", 1),
            ("byte_way", 4),
            ("byte_right", 8),
            ("byte_card", 32),
            ("byte_apart", 32),
            ("byte_in_way", 32),
        ]
        .into_iter()
        .chain(LOADS)
    });
    [
        ("reset", 1),
        ("accepted", 1),
        ("answered", 1),
        ("stalled", 1),
        ("resident", ways),
        ("order", harness::order_bits(cache)),
        ("lines", 32 * ways),
        ("count", 4),
        ("waits", 4),
        ("known", 4),
        ("waited", 8),
        ("waiting", 33),
        ("sum", cache.geometry.set_bits() as usize),
        ("mine", 1),
        ("queue", harness::ENTRY * config.outstanding as usize),
    ]
    .into_iter()
    .chain(of_bytes)
    .chain(answer_of_waiting(ways))
    .map(|(name, width)| (name.to_owned(), width))
    .collect()
}

/// The wires that say what is to be answered to the request that waits, with their widths.
pub(super) fn answer_of_waiting(ways: usize) -> [(&'static str, usize); 7] {
    [("matches", ways), ("present", 1), ("hit", 1), ("evicts", 1), ("way", 4), ("evicted", 32), ("card", 32)]
}

/// The wires that say what is known of a line that is loaded, with their widths.
pub(super) const LOADS: [(&str, usize); 6] =
    [("loading", 1), ("loads_byte", 1), ("comes", 1), ("owed", 2), ("known_of_line", 1), ("known_hit", 1)];

/// Most bits of the number of what was brought of a line.
pub(super) fn beat_bits(cache: &CacheConfig) -> usize {
    (cache.geometry.line().0.trailing_zeros() as usize).max(1)
}

/// A bit by its wire and number, and what a simulation showed of it.
#[derive(Clone, Copy)]
pub(in crate::prove) struct Bit<'a> {
    pub wire: &'a str,
    pub number: usize,
    pub samples: &'a [u64],
}

impl Bit<'_> {
    /// Whether it never changes.
    pub fn is_constant(&self) -> bool {
        self.samples.iter().all(|&word| word == 0) || self.samples.iter().all(|&word| word == u64::MAX)
    }
}

/// Where bits have a value together.
pub(super) fn has_value(bits: &[Bit<'_>], value: u64) -> Vec<u64> {
    let differs = |clock: usize, n: usize| {
        let wanted = if value >> n & 1 == 1 { u64::MAX } else { 0 };
        bits[n].samples[clock] ^ wanted
    };
    let clocks = bits.first().map_or(0, |bit| bit.samples.len());
    (0..clocks).map(|clock| (0..bits.len()).fold(u64::MAX, |all, n| all & !differs(clock, n))).collect()
}
