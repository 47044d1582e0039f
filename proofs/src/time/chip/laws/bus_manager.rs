//! The laws of the bus manager: which parts it takes, and what it counts of their look-ups (CH-12, CH-14).

use super::{Law, Verdict};
use saarcor_model::time::{CacheReport, Chip, ChipConfig, Programs, Version};
use saarcor_model::vm::{HostAddr, LineAddr, Unit};

/// Each part that is taken is one look-up of its line, which misses, or hits; it is merged if it hits a line that a
/// load is to bring when the part is taken (CH-14).
pub struct LookUps<'a> {
    config: &'a ChipConfig,
    /// The parts that each cache has, and the first of them.
    parts: [(usize, Option<HostAddr>); 4],
    /// Lines whose loads are in flight.
    loading: Vec<LineAddr>,
    /// Look-ups, misses and merged ones before.
    counts: [u64; 3],
}

impl<'a> LookUps<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig) -> Self {
        Self { config, parts: [(0, None); 4], loading: Vec::new(), counts: [0; 3] }
    }
}

impl Law for LookUps<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        let parts = [0, 1, 2, 3].map(|cache: usize| &chip.first_level[cache].parts);
        if phase == 7 {
            self.parts = parts.map(|parts| (parts.len(), parts.front().map(|part| part.addr)));
            self.loading = chip.loads.in_flight.iter().map(|load| load.line).collect();
        }
        if phase == 8 {
            let CacheReport { accesses, misses, merged, .. } = chip.report.l2;
            let counts = [accesses, misses, merged];
            let before = std::mem::replace(&mut self.counts, counts);
            let [looked_up, missed, merged] = [0, 1, 2].map(|count: usize| counts[count] - before[count]);
            let taken = (0..4).filter(|&cache| parts[cache].len() < self.parts[cache].0);
            let line = taken.filter_map(|cache| self.parts[cache].1).next();
            let line = line.map(|addr| self.config.cache.geometry.line_of(addr));
            let comes = line.is_some_and(|line| self.loading.contains(&line));
            let right = looked_up == u64::from(line.is_some())
                && missed <= looked_up
                && merged == u64::from(comes && missed == 0);
            demand!(
                right,
                "{line:?}: {looked_up} looked up, {missed} missed, {merged} merged, while {:?} are loaded",
                self.loading
            );
        }
        Ok(())
    }
}

/// The parts of a missed line are its bytes, in order, each part within one line of the virtual memory. The
/// bus manager takes one a cycle while there is one, from the first-level caches in turn, and from each in
/// order (CH-12).
pub struct Parts<'a> {
    config: &'a ChipConfig,
    programs: &'a Programs,
    /// Parts that each cache still has, and the lines that are in flight to it.
    parts: [usize; 4],
    lines: [Vec<LineAddr>; 4],
    last: Option<usize>,
}

impl<'a> Parts<'a> {
    /// Before the first cycle.
    #[must_use]
    pub fn new(config: &'a ChipConfig, programs: &'a Programs) -> Self {
        Self { config, programs, parts: [0; 4], lines: Default::default(), last: None }
    }
}

impl Law for Parts<'_> {
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict {
        if phase == 6 {
            for cache in 0..4 {
                self.lines[cache].clear();
                self.lines[cache].extend(chip.first_level[cache].in_flight.iter().map(|line| line.line));
            }
        }
        if phase == 7 {
            for cache in 0..4 {
                let l1 = &chip.first_level[cache];
                let base = if cache == Unit::Intersection as usize { self.programs.triangles.0 } else { 0 };
                let bytes = u64::from(self.config.l1[cache].line);
                let mut new = l1.parts.iter().skip(self.parts[cache]);
                for line in l1.in_flight.iter().filter(|line| !self.lines[cache].contains(&line.line)) {
                    let begin = u64::from(base) + u64::from(line.line.0) * bytes;
                    let end = (begin + bytes).min(1 << 32);
                    let mut at = begin;
                    let mut count = 0;
                    while at < end {
                        let Some(part) = new.next() else {
                            return Err(format!("{line:?} lacks a part from {at} on"));
                        };
                        let last = at + part.bytes - 1;
                        let vm_line = self.config.cache.geometry.line().0;
                        let within = self.config.version == Version::None || at / vm_line == last / vm_line;
                        let longest = self.config.version != Version::None || last + 1 == end;
                        let right =
                            part.line == line.line && part.cache == cache && u64::from(part.addr.0) == at;
                        let full = last + 1 == end || (last + 1) % vm_line == 0;
                        demand!(
                            right && within && longest && full,
                            "{part:?} of {line:?} from {at} to {end}"
                        );
                        (at, count) = (last + 1, count + 1);
                    }
                    demand!(count == line.unread && at == end, "{count} parts of {line:?}");
                }
                demand!(new.next().is_none(), "cache {cache} asks for parts that it did not miss");
                self.parts[cache] = l1.parts.len();
            }
        }
        if phase == 8 {
            let first = self.last.map_or(0, |last| last + 1);
            let next = (first..first + 4).map(|cache| cache % 4).find(|&cache| self.parts[cache] > 0);
            for cache in 0..4 {
                let taken = self.parts[cache] - chip.first_level[cache].parts.len();
                let expected = usize::from(next == Some(cache));
                demand!(
                    taken == expected,
                    "{taken} parts of cache {cache} are taken, the turn is {next:?}'s"
                );
                self.parts[cache] -= taken;
            }
            self.last = next.or(self.last);
        }
        Ok(())
    }
}
