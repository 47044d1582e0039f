//! Random sessions of `saarcor-vm`, weighted to collide.

use super::config;
use crate::hex;
use saarcor_model::vm::CacheConfig;
use saarcor_random::Random;
use std::borrow::Cow;

/// The configurations of the even seeds, in turn: the small geometry with each hash and policy, then others. Those of
/// the odd seeds are drawn.
pub const CONFIGS: &[&str] = &[
    "line=16 lines=8 ways=4 hash=add-upper policy=lru",
    "line=16 lines=8 ways=4 hash=add-upper policy=fifo",
    "line=16 lines=8 ways=4 hash=add-upper policy=plru",
    "line=128 lines=65536 ways=4 hash=add-upper policy=lru",
    "line=16 lines=8 ways=4 hash=low policy=lru",
    "line=16 lines=8 ways=4 hash=low policy=fifo",
    "line=16 lines=8 ways=4 hash=low policy=plru",
    "line=32 lines=64 ways=8 hash=add-upper policy=lru",
    "line=16 lines=8 ways=4 hash=add-upper-all policy=lru",
    "line=16 lines=8 ways=4 hash=add-upper-all policy=fifo",
    "line=16 lines=8 ways=4 hash=add-upper-all policy=plru",
    "line=1 lines=16 ways=2 hash=add-upper policy=fifo",
];

/// The configuration of a seed.
#[must_use]
pub fn config_of(seed: u64) -> Cow<'static, str> {
    if seed.is_multiple_of(2) {
        return CONFIGS[(seed / 2 % CONFIGS.len() as u64) as usize].into();
    }
    // The requests are drawn from the seed itself.
    config::text(&config::of_seed(&mut Random::new(!seed))).into()
}

/// Sets that a session uses: few, so that lines collide, but more than one.
const TARGET_SETS: u64 = 3;
/// Most accesses stay within so many first bytes of a line.
const WARM_BYTES: u64 = 16;
/// Lines that are longer are read as a whole the more rarely: answers take as many bytes.
const LONG_LINE: u64 = 1024;

/// The requests of a seed, each with its newline.
///
/// # Panics
/// If `config` is none.
#[must_use]
pub fn requests(config: &str, seed: u64, count: usize) -> Vec<u8> {
    let config = config::parse(config).expect("a configuration of the kit");
    let mut session = SessionWriter { random: Random::new(seed), config, pool: Vec::new(), text: Vec::new() };
    session.fill_pool();
    // Each line of the pool is written to first, so that no two lines have the same bytes.
    let writes = session.pool.len().min(count / 4);
    for place in 0..writes {
        session.write(session.pool[place], false);
    }
    let mut made = writes;
    while made < count {
        made += session.step(count - made);
    }
    session.text
}

struct SessionWriter {
    random: Random,
    config: CacheConfig,
    /// Lines that are read, by their numbers.
    pool: Vec<u64>,
    text: Vec<u8>,
}

impl SessionWriter {
    /// Number of lines of the host.
    fn host_lines(&self) -> u64 {
        (1 << 32) / self.config.geometry.line().0
    }

    /// Lines that collide: strides of the set count and of one less, equal lower bits, neighbours,
    /// and the end of the address space, where upper bits and carries are all ones.
    fn fill_pool(&mut self) {
        let (sets, ways) = (self.config.geometry.sets(), u64::from(self.config.geometry.ways()));
        let lines = self.host_lines();
        let size = TARGET_SETS * 2 * ways + 4;
        let base = self.random.below(lines.min(u64::from(u32::MAX)));
        while (self.pool.len() as u64) < size {
            let steps = self.random.below(2 * ways + 1);
            let line = match self.random.below(8) {
                0 | 1 => base + steps * sets,
                2 => base + steps * sets.saturating_sub(1).max(1),
                3 => base ^ (1 << self.random.below(u64::from(lines.ilog2()).max(1))),
                4 => base + self.random.below(TARGET_SETS),
                5 => lines - 1 - steps * sets % lines,
                6 => steps * sets * sets,
                _ => self.random.below(lines.min(u64::from(u32::MAX))),
            };
            self.pool.push(line % lines);
        }
    }

    /// Appends a request or two, at most `most`; says how many.
    fn step(&mut self, most: usize) -> usize {
        let line = self.random.pick(&self.pool);
        match self.random.below(1000) {
            0..850 => self.read(line),
            850..890 => {
                self.write(line, true);
                if most > 1 && self.random.percent(75) {
                    // The line is the first of the range, the last, or in the middle.
                    let before = self.random.pick(&[0, 0, 0, 1, 2]).min(line);
                    let lines = before + self.random.pick(&[1, 1, 1, 2, 3]);
                    self.invalidate(line - before, lines);
                    return 2;
                }
            }
            890..970 => {
                let lines = 1 + self.random.below(3);
                self.invalidate(line, lines);
            }
            970..990 => {
                let sets = self.config.geometry.sets();
                // Another line of the pool's kind, so that a session does not stay in its pool.
                let place = self.random.below(self.pool.len() as u64) as usize;
                self.pool[place] = (line + sets * (1 + self.random.below(5))) % self.host_lines();
                self.write(self.pool[place], false);
            }
            990..998 => {
                for _ in 0..most.min(4) {
                    self.read(line);
                }
                return most.min(4);
            }
            _ => self.text.extend_from_slice(b"flush\n"),
        }
        1
    }

    fn request(&mut self, name: u8, host: u64) {
        self.text.extend_from_slice(&[name, b' ']);
        hex::push_number(&mut self.text, host);
        self.text.push(b' ');
    }

    /// Reads a few bytes of a line, now and then all of them.
    fn read(&mut self, line: u64) {
        let size = self.config.geometry.line().0;
        let (offset, len) = match self.random.below(64) {
            0 if self.random.below(size.div_ceil(LONG_LINE)) == 0 => (0, size),
            1..4 => {
                let offset = self.random.below(size);
                (offset, 1 + self.random.below((size - offset).min(WARM_BYTES)))
            }
            _ => {
                let offset = self.random.below(size.min(WARM_BYTES));
                (offset, 1 + self.random.below((size - offset).min(4)))
            }
        };
        self.request(b'r', line * size + offset);
        hex::push_number(&mut self.text, len);
        self.text.push(b'\n');
    }

    /// Writes some of the first bytes of a line, or all of them.
    fn write(&mut self, line: u64, part: bool) {
        let size = self.config.geometry.line().0.min(WARM_BYTES);
        let offset = if part { self.random.below(size) } else { 0 };
        let len = if part { 1 + self.random.below(size - offset) } else { size };
        self.request(b'w', line * self.config.geometry.line().0 + offset);
        for _ in 0..len {
            let byte = self.random.bits() as u8;
            hex::push_bytes(&mut self.text, &[byte]);
        }
        self.text.push(b'\n');
    }

    /// Invalidates a range over so many lines, from some byte of the first to some byte of the last.
    fn invalidate(&mut self, line: u64, lines: u64) {
        let size = self.config.geometry.line().0;
        let begin = line * size + self.random.below(size);
        let last = (line + lines - 1) * size + self.random.below(size);
        self.request(b'i', begin);
        let len = last.clamp(begin, (1 << 32) - 1) + 1 - begin;
        hex::push_number(&mut self.text, len);
        self.text.push(b'\n');
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::Request;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn sessions_are_legal_and_of_the_size_asked_for() {
        for seed in 0..200 {
            let config = config_of(seed);
            let line = config::parse(&config).expect("legal").geometry.line().0;
            for count in [0, 1, 2, 300] {
                let text = requests(&config, seed, count);
                let lines: Vec<_> =
                    text.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()).collect();
                assert_eq!(lines.len(), count, "{config}");
                for request in lines {
                    assert!(Request::parse(request).expect("legal").fits(line), "{config}");
                }
            }
        }
    }

    /// Half of the seeds have a configuration of their own, and among some hundreds of them are each length of a
    /// line, each number of ways and of sets, each hash and each policy.
    #[test]
    fn configurations_are_drawn_by_seed_over_all_powers_of_two() {
        let drawn: Vec<_> =
            (0..400).map(|number| config::parse(&config_of(2 * number + 1)).expect("legal")).collect();
        let values = |of: fn(&CacheConfig) -> u64| drawn.iter().map(of).collect::<BTreeSet<_>>();
        let lines = values(|config| config.geometry.line().0);
        assert!(lines.into_iter().eq((0..=16).map(|bit| 1 << bit)));
        let sets = values(|config| config.geometry.sets());
        assert!(sets.into_iter().eq((0..=18).map(|bit| 1 << bit)));
        let ways = values(|config| config.geometry.ways().into());
        assert!(ways.into_iter().eq(config::WAYS.map(u64::from)));
        assert_eq!(values(|config| 3 * config.hash as u64 + config.policy as u64).len(), 9);
        let texts: BTreeSet<_> = drawn.iter().map(config::text).collect();
        assert!(texts.len() > 350, "{}", texts.len());
    }
}
