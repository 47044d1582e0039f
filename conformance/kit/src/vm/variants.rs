//! Variants of the model, each of which breaks one requirement: where one answers as an implementation does, the
//! requirement that the implementation breaks is known.
//!
//! A variant decides hits, ways and victims only: bytes are not its matter.

use super::request::{Observes, ReadAnswer, Request};
use saarcor_model::vm::{CacheConfig, Hash, HostAddr, LineAddr, Policy, Set, SetIndex, Way};
use std::collections::HashMap;

/// What a variant does otherwise than the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// Only its configuration is another.
    Config,
    /// Upper bits are combined by exclusive or.
    HashXors,
    /// Tags have so many bits.
    TagBits(u32),
    /// A hit does not change the order.
    HitsLeaveOrder,
    /// A load does not change the order.
    LoadsLeaveOrder,
    /// A load into a free way does not change the order.
    FreeLoadsLeaveOrder,
    /// The youngest line is evicted.
    VictimYoungest,
    /// The second oldest line is evicted.
    VictimSecondOldest,
    /// Each eviction takes the next way in turn.
    VictimInTurn,
    /// A write uses the lines that it meets, where they are resident.
    WritesUse,
    /// A write invalidates the lines that it meets.
    WritesInvalidate,
    /// The free way of the highest number is filled.
    FreeHighest,
    /// The free way that was used first is filled.
    FreeOldest,
    /// The free way that was used last is filled.
    FreeYoungest,
    /// The way that was freed last is filled.
    FreedLast,
    /// Once an invalidation has freed some, the free way of the highest number is filled.
    FreedHighest,
    /// Ways that an invalidation freed are not looked for.
    FreedIgnored,
    /// Free ways are not looked for.
    FreeIgnored,
    /// Ranges invalidate nothing.
    RangesDoNothing,
    /// A flush invalidates nothing.
    FlushDoesNothing,
    /// Of a range the first line alone is invalidated.
    RangesOfOneLine,
    /// Of a range of several lines the last one stays.
    RangesWithoutTheLast,
    /// One line behind a range is invalidated too.
    RangesTooFar,
    /// The whole set of each line of a range is invalidated.
    RangesOfSets,
    /// An invalidation does not look at the last way.
    LastWayStays,
    /// An invalidation puts the order of its set back to what it was at first.
    RangesResetOrder,
}

/// The changes, and the requirement that each breaks.
const CHANGES: [(Change, &str); 26] = [
    (Change::HashXors, "VM-3"),
    (Change::TagBits(16), "VM-4"),
    (Change::TagBits(24), "VM-4"),
    (Change::HitsLeaveOrder, "VM-6"),
    (Change::LoadsLeaveOrder, "VM-6"),
    (Change::FreeLoadsLeaveOrder, "VM-6"),
    (Change::VictimYoungest, "VM-6"),
    (Change::VictimSecondOldest, "VM-6"),
    (Change::VictimInTurn, "VM-6"),
    (Change::WritesUse, "VM-6"),
    (Change::WritesInvalidate, "VM-6"),
    (Change::FreeHighest, "VM-7"),
    (Change::FreeOldest, "VM-7"),
    (Change::FreeYoungest, "VM-7"),
    (Change::FreedLast, "VM-7"),
    (Change::FreedHighest, "VM-7"),
    (Change::FreedIgnored, "VM-7"),
    (Change::FreeIgnored, "VM-7"),
    (Change::RangesDoNothing, "VM-8"),
    (Change::FlushDoesNothing, "VM-8"),
    (Change::RangesOfOneLine, "VM-8"),
    (Change::RangesWithoutTheLast, "VM-8"),
    (Change::RangesTooFar, "VM-8"),
    (Change::RangesOfSets, "VM-8"),
    (Change::LastWayStays, "VM-8"),
    (Change::RangesResetOrder, "VM-8"),
];

/// The variants of a configuration.
fn variants(config: CacheConfig) -> impl Iterator<Item = (CacheConfig, Change, &'static str)> {
    let CacheConfig { hash, policy, .. } = config;
    let policies =
        [Policy::Lru, Policy::Fifo, Policy::Plru].into_iter().filter(move |other| *other != policy);
    let hashes =
        [Hash::Low, Hash::AddUpper, Hash::AddUpperAll].into_iter().filter(move |other| *other != hash);
    policies
        .map(move |policy| (CacheConfig { policy, ..config }, Change::Config, "VM-6"))
        .chain(hashes.map(move |hash| (CacheConfig { hash, ..config }, Change::Config, "VM-3")))
        .chain(CHANGES.into_iter().map(move |(change, requirement)| (config, change, requirement)))
}

/// The requirements that a single variant has to break to give all of these answers to requests.
pub(super) fn explanations<'a>(
    config: CacheConfig,
    observes: Observes,
    exchanges: impl Iterator<Item = (&'a [u8], &'a [u8])> + Clone,
) -> Vec<&'static str> {
    let explains = |(config, change, requirement): (CacheConfig, Change, &'static str)| {
        let answered = exchanges.clone();
        let is_alike = match config.geometry.ways() {
            1 => Variant::<1>::new(config, change).answers(observes, answered),
            2 => Variant::<2>::new(config, change).answers(observes, answered),
            4 => Variant::<4>::new(config, change).answers(observes, answered),
            8 => Variant::<8>::new(config, change).answers(observes, answered),
            _ => Variant::<16>::new(config, change).answers(observes, answered),
        };
        is_alike.then_some(requirement)
    };
    variants(config).filter_map(explains).collect()
}

/// A variant of the model.
struct Variant<const WAYS: usize> {
    config: CacheConfig,
    change: Change,
    /// The sets that have been used.
    sets: HashMap<u32, Set<WAYS>>,
    /// Evictions of each set.
    evictions: HashMap<u32, usize>,
    /// The ways of each set that an invalidation freed, in its order.
    freed: HashMap<u32, Vec<usize>>,
}

impl<const WAYS: usize> Variant<WAYS> {
    fn new(config: CacheConfig, change: Change) -> Self {
        let (sets, evictions, freed) = (HashMap::new(), HashMap::new(), HashMap::new());
        Self { config, change, sets, evictions, freed }
    }

    /// Whether it gives these answers to requests, as far as they are observed; bytes are passed over.
    fn answers<'a>(
        &mut self,
        observes: Observes,
        mut exchanges: impl Iterator<Item = (&'a [u8], &'a [u8])>,
    ) -> bool {
        exchanges.all(|(request, answer)| match Request::parse(request) {
            Ok(Request::Read { host, len }) => {
                let got = ReadAnswer::parse(answer, len, observes);
                let own = self.read(host);
                got.is_ok_and(|got| {
                    got.hit.is_none_or(|hit| Some(hit) == own.hit)
                        && got.card.is_none_or(|card| Some(card) == own.card)
                        && (!observes.evict || got.evicted == own.evicted)
                })
            }
            Ok(Request::Write { host, digits }) => {
                self.write(host, digits.len() as u64 / 2);
                true
            }
            Ok(Request::Invalidate { host, len }) => {
                self.invalidate(host, len);
                true
            }
            Ok(Request::Flush) => {
                if self.change != Change::FlushDoesNothing {
                    self.sets.clear();
                    self.freed.clear();
                    self.evictions.clear();
                }
                true
            }
            Err(_) => false,
        })
    }

    fn set_of(&self, line: LineAddr) -> u32 {
        let bits = self.config.geometry.set_bits();
        match (self.change, self.config.hash) {
            (Change::HashXors, Hash::AddUpper | Hash::AddUpperAll) => {
                let (mut sum, mut upper) = (u64::from(line.0), u64::from(line.0) >> bits);
                loop {
                    sum ^= upper;
                    upper = upper.checked_shr(bits).unwrap_or(0);
                    if bits == 0 || upper == 0 || self.config.hash == Hash::AddUpper {
                        break (sum & ((1 << bits) - 1)) as u32;
                    }
                }
            }
            _ => self.config.set_of(line).0,
        }
    }

    fn is_same(&self, tag: LineAddr, line: LineAddr) -> bool {
        match self.change {
            Change::TagBits(bits) => (tag.0 ^ line.0) & ((1 << bits) - 1) == 0,
            _ => tag == line,
        }
    }

    fn way_of(&self, set: &Set<WAYS>, line: LineAddr) -> Option<usize> {
        (0..WAYS).find(|way| set.resident[*way] && self.is_same(set.lines[*way], line))
    }

    /// The set with a way that it holds made the youngest.
    fn used(&self, set: &Set<WAYS>, way: usize) -> Set<WAYS> {
        // The order of FIFO is that of LRU at loads.
        let policy = if self.config.policy == Policy::Plru { Policy::Plru } else { Policy::Lru };
        let mut alone = *set;
        alone.resident = std::array::from_fn(|other| other == way);
        Set { order: alone.access(alone.lines[way], policy).0.order, ..*set }
    }

    fn free_way(&self, index: u32, set: &Set<WAYS>) -> Option<usize> {
        let free = |way: &usize| !set.resident[*way];
        let mut by_number = 0..WAYS;
        let mut by_age = set.order.iter().map(|way| usize::from(*way));
        let freed = self.freed.get(&index).map_or(&[][..], Vec::as_slice);
        let has_ages = self.config.policy != Policy::Plru;
        match self.change {
            Change::FreeIgnored => None,
            Change::FreeHighest => by_number.rfind(free),
            Change::FreeOldest if has_ages => by_age.rfind(free),
            Change::FreeYoungest if has_ages => by_age.find(free),
            Change::FreedLast => freed.iter().rev().copied().find(free).or_else(|| by_number.find(free)),
            Change::FreedHighest if !freed.is_empty() => by_number.rfind(free),
            Change::FreedIgnored => by_number.find(|way| free(way) && !freed.contains(way)),
            _ => by_number.find(free),
        }
    }

    fn victim(&mut self, index: u32, set: &Set<WAYS>) -> usize {
        let evictions = self.evictions.entry(index).or_default();
        let turn = *evictions % WAYS;
        *evictions += 1;
        let place = match self.change {
            Change::VictimInTurn => return turn,
            Change::VictimYoungest => 0,
            Change::VictimSecondOldest => WAYS.saturating_sub(2),
            _ => WAYS - 1,
        };
        if self.config.policy != Policy::Plru {
            return usize::from(set.order[place]);
        }
        let mut node = 1;
        while node < WAYS {
            let bit = usize::from(set.order[node]);
            node = 2 * node + if self.change == Change::VictimYoungest { 1 - bit } else { bit };
        }
        node - WAYS
    }

    /// The answer to a read, without its bytes.
    fn read(&mut self, host: u32) -> ReadAnswer<'static> {
        let geometry = self.config.geometry;
        let line = geometry.line_of(HostAddr(host));
        let index = self.set_of(line);
        let mut set = self.sets.get(&index).copied().unwrap_or_else(|| Set::empty(self.config.policy));
        let (mut hit, mut evicted) = (true, None);
        let way = self.way_of(&set, line).unwrap_or_else(|| {
            hit = false;
            let free = self.free_way(index, &set);
            let way = free.unwrap_or_else(|| self.victim(index, &set));
            evicted = set.resident[way].then_some(set.lines[way]);
            (set.lines[way], set.resident[way]) = (line, true);
            way
        });
        let changes_order = match self.change {
            _ if hit => self.config.policy != Policy::Fifo && self.change != Change::HitsLeaveOrder,
            Change::LoadsLeaveOrder => false,
            Change::FreeLoadsLeaveOrder => evicted.is_some(),
            _ => true,
        };
        if changes_order {
            set = self.used(&set, way);
        }
        self.sets.insert(index, set);
        let start = geometry.card_addr(SetIndex(index), Way(way as u8)).0;
        ReadAnswer {
            hit: Some(hit),
            card: Some(u64::from(start + geometry.offset_of(HostAddr(host)))),
            evicted: evicted.map(|line| u64::from(geometry.first_byte(line).0)),
            data: None,
        }
    }

    /// The resident lines of a range, with their sets and ways.
    fn resident(&self, lines: std::ops::Range<u64>) -> Vec<(u32, usize)> {
        if lines.end - lines.start < self.sets.len() as u64 {
            let place = |line: u64| {
                let index = self.set_of(LineAddr(line as u32));
                Some((index, self.way_of(self.sets.get(&index)?, LineAddr(line as u32))?))
            };
            return lines.filter_map(place).collect();
        }
        let ways = self.sets.iter().flat_map(|(&index, set)| (0..WAYS).map(move |way| (index, set, way)));
        let is_met =
            |set: &Set<WAYS>, way: usize| set.resident[way] && lines.contains(&u64::from(set.lines[way].0));
        ways.filter(|(_, set, way)| is_met(set, *way)).map(|(index, _, way)| (index, way)).collect()
    }

    fn write(&mut self, host: u32, len: u64) {
        let met = match self.change {
            Change::WritesUse | Change::WritesInvalidate => {
                self.resident(self.config.lines_of(HostAddr(host), len))
            }
            _ => return,
        };
        for (index, way) in met {
            let Some(mut set) = self.sets.get(&index).copied() else { continue };
            if self.change == Change::WritesInvalidate {
                set.resident[way] = false;
            } else {
                set = self.used(&set, way);
            }
            self.sets.insert(index, set);
        }
    }

    fn invalidate(&mut self, host: u32, len: u64) {
        let mut lines = self.config.lines_of(HostAddr(host), len);
        match self.change {
            Change::RangesDoNothing => return,
            Change::RangesOfOneLine => lines.end = lines.start + 1,
            Change::RangesWithoutTheLast if lines.end - lines.start > 1 => lines.end -= 1,
            Change::RangesTooFar => lines.end += 1,
            _ => {}
        }
        for (index, way) in self.resident(lines) {
            let Some(set) = self.sets.get_mut(&index) else { continue };
            match self.change {
                Change::LastWayStays if way == WAYS - 1 => continue,
                Change::RangesOfSets => set.resident = [false; WAYS],
                _ => set.resident[way] = false,
            }
            if self.change == Change::RangesResetOrder {
                set.order = Set::<WAYS>::empty(self.config.policy).order;
            }
            self.freed.entry(index).or_default().push(way);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::{Kind as _, Oracle};
    use crate::vm::{Vm, config};

    /// Without a change a variant answers as the model does, in any configuration; so a variant differs by its
    /// change alone.
    #[test]
    fn without_a_change_a_variant_is_the_model() {
        for seed in 0..40 {
            let session = Vm.random(seed, 400);
            let mut model = Vm.oracle(Oracle::Model, session.config()).expect("a model");
            let answers: Vec<Vec<u8>> = session
                .requests()
                .map(|request| {
                    let mut answer = Vec::new();
                    model.answer(request, &mut answer).expect("an answer");
                    answer
                })
                .collect();
            let exchanges = session.requests().zip(answers.iter().map(Vec::as_slice));
            let config = config::parse(session.config()).expect("a configuration");
            let is_alike = match config.geometry.ways() {
                1 => Variant::<1>::new(config, Change::Config).answers(Observes::ALL, exchanges),
                2 => Variant::<2>::new(config, Change::Config).answers(Observes::ALL, exchanges),
                4 => Variant::<4>::new(config, Change::Config).answers(Observes::ALL, exchanges),
                8 => Variant::<8>::new(config, Change::Config).answers(Observes::ALL, exchanges),
                _ => Variant::<16>::new(config, Change::Config).answers(Observes::ALL, exchanges),
            };
            assert!(is_alike, "seed {seed}: {}", session.config());
        }
    }

    /// Of a set of four, way 1 is freed after 3 was, and then two lines are loaded.
    #[test]
    fn answers_name_the_change_that_gives_them() {
        let config = config::parse("line=16 lines=4 ways=4 hash=low policy=lru").expect("a configuration");
        let requests = ["r 0 1", "r 10 1", "r 20 1", "r 30 1", "i 10 1", "i 30 1", "r 40 1"];
        let explained = |last: &str| {
            let answers = ["m 0 - -", "m 10 - -", "m 20 - -", "m 30 - -", "ok", "ok", last];
            let exchanges = requests.iter().zip(&answers).map(|(a, b)| (a.as_bytes(), b.as_bytes()));
            let observes = Observes { data: false, ..Observes::ALL };
            explanations(config, observes, exchanges)
        };
        // The free way that was used last, freed last, or has the highest number of those that were freed.
        assert_eq!(explained("m 30 - -"), ["VM-7"; 3]);
        // The oldest line goes, as freed ways are not looked for, or nothing was invalidated.
        assert_eq!(explained("m 0 0 -"), ["VM-7", "VM-8"]);
        assert!(explained("m 20 20 -").is_empty());
    }
}
