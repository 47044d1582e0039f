//! The virtual memory of the SaarCOR chip, for the conformance kit in process.

use saarcor_kit::error::Error;
use saarcor_kit::vm::cache::{Access, Cache, Outcome};
use saarcor_model::vm::{CacheConfig, CardAddr, Hash, HostAddr, Policy};
use std::collections::HashMap;

/// A line on the card.
struct Line {
    number: u32,
    bytes: Vec<u8>,
    /// When it was used (FIFO: loaded) last.
    stamp: u64,
}

/// The virtual memory, and its host's memory byte by byte; what is not there is zero.
pub struct MyCache {
    config: CacheConfig,
    host: HashMap<u32, u8>,
    /// A slot for each line of the memory: the ways of a set follow one another.
    slots: Vec<Option<Line>>,
    /// Bits of the trees (PLRU): as many a set as it has ways, the root at 1.
    trees: Vec<bool>,
    clock: u64,
}

/// An empty cache.
pub fn make(config: &CacheConfig) -> Result<Box<dyn Cache>, Error> {
    let lines = config.geometry.lines() as usize;
    let slots = std::iter::repeat_with(|| None).take(lines).collect();
    Ok(Box::new(MyCache {
        config: *config,
        host: HashMap::new(),
        slots,
        trees: vec![false; lines],
        clock: 0,
    }))
}

impl MyCache {
    fn ways(&self) -> usize {
        self.config.geometry.ways() as usize
    }

    fn set_of(&self, line: u32) -> usize {
        let sets = self.config.geometry.sets();
        let (low, mut upper) = (u64::from(line) % sets, u64::from(line) / sets);
        let mut sum = low;
        match self.config.hash {
            Hash::Low => {}
            Hash::AddUpper => sum += upper,
            Hash::AddUpperAll => {
                while sets > 1 && upper > 0 {
                    sum += upper % sets;
                    upper /= sets;
                }
            }
        }
        (sum % sets) as usize
    }

    /// The way that a new line takes, of the set whose slots begin at `first`.
    fn victim(&self, first: usize) -> usize {
        let set = &self.slots[first..first + self.ways()];
        if let Some(free) = set.iter().position(Option::is_none) {
            return free;
        }
        if self.config.policy != Policy::Plru {
            return (0..set.len()).min_by_key(|&way| set[way].as_ref().map(|line| line.stamp)).unwrap_or(0);
        }
        let mut node = 1;
        while node < set.len() {
            node = 2 * node + usize::from(self.trees[first + node]);
        }
        node - set.len()
    }

    fn use_way(&mut self, first: usize, way: usize) {
        self.clock += 1;
        if let Some(line) = &mut self.slots[first + way] {
            line.stamp = self.clock;
        }
        let mut node = self.ways() + way;
        while node > 1 {
            self.trees[first + node / 2] = node.is_multiple_of(2);
            node /= 2;
        }
    }

    fn load(&self, number: u32) -> Line {
        let size = self.config.geometry.line().0 as u32;
        let byte = |offset| self.host.get(&(number * size + offset)).copied().unwrap_or(0);
        Line { number, bytes: (0..size).map(byte).collect(), stamp: 0 }
    }
}

impl Cache for MyCache {
    fn write(&mut self, host: HostAddr, bytes: &[u8]) {
        self.host.extend((host.0..=u32::MAX).zip(bytes.iter().copied()));
    }

    fn read(&mut self, host: HostAddr, bytes: &mut [u8]) -> Access {
        let size = self.config.geometry.line().0 as u32;
        let (number, offset) = (host.0 / size, host.0 % size);
        let first = self.set_of(number) * self.ways();
        let set = &self.slots[first..first + self.ways()];
        let found = set.iter().position(|line| line.as_ref().is_some_and(|line| line.number == number));
        let way = found.unwrap_or_else(|| self.victim(first));
        let slot = first + way;
        let outcome = if found.is_some() {
            Outcome::Hit
        } else {
            let line = self.load(number);
            let evicted = self.slots[slot].replace(line);
            Outcome::Miss(evicted.map(|line| HostAddr(line.number * size)))
        };
        if found.is_none() || self.config.policy != Policy::Fifo {
            self.use_way(first, way);
        }
        if let Some(line) = &self.slots[slot] {
            bytes.copy_from_slice(&line.bytes[offset as usize..][..bytes.len()]);
        }
        Access { card: CardAddr(slot as u32 * size + offset), outcome }
    }

    fn invalidate(&mut self, host: HostAddr, len: u64) {
        let size = self.config.geometry.line().0;
        let lines = u64::from(host.0) / size..=(u64::from(host.0) + len - 1) / size;
        for slot in &mut self.slots {
            slot.take_if(|line| lines.contains(&u64::from(line.number)));
        }
    }

    fn flush(&mut self) {
        self.slots.fill_with(|| None);
        self.trees.fill(false);
    }
}
