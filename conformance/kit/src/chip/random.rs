//! Random sessions of `saarcor-chip`: small chips, and packets that meet at lines, sets, banks and ports.

use super::config;
use super::request::{RAYS, Request};
use saarcor_model::time::{Operation, Version};
use saarcor_model::vm::{HostAddr, Unit};
use saarcor_random::Random;

/// One of so many seeds has the standard chip.
const STANDARD_EVERY: u64 = 12;

/// The configuration of a seed. All is small: caches of a few lines. Times differ, so that events coincide only by
/// chance.
#[must_use]
pub fn config_of(seed: u64) -> String {
    let mut random = Random::new(!seed);
    let mut words: Vec<String> = Vec::new();
    let mut word = |key: &str, value: u64| words.push(format!("{key}={value}"));
    let version = random.pick(&["none", "a", "a", "b", "b"]);
    if seed % STANDARD_EVERY == STANDARD_EVERY - 1 {
        return format!("version={version}");
    }
    word("pipelines", random.pick(&[1, 2, 3]));
    word("threads", random.pick(&[1, 2, 4, 5]));
    for unit in config::UNITS {
        word(&format!("{unit}-rate"), random.pick(&[1, 2, 4, 64]));
        word(&format!("{unit}-latency"), random.below(6));
        word(&format!("{unit}-line"), random.pick(&[4, 8, 12, 16]));
        word(&format!("{unit}-sets"), random.pick(&[1, 2, 4]));
        word(&format!("{unit}-ports"), random.pick(&[1, 1, 2]));
        word(&format!("{unit}-look-up"), 1 + random.below(4));
        word(&format!("{unit}-mshrs"), random.pick(&[1, 2, 4]));
    }
    word("tag", random.below(5));
    word("return", random.below(5));
    let (ways, sets) = (random.pick(&[1, 2, 4]), random.pick(&[1, 2, 4]));
    word("line", random.pick(&[16, 32, 64]));
    word("lines", ways * sets);
    word("ways", ways);
    word("granule", random.pick(&[8, 16]));
    word("meta-sets", random.pick(&[1, 1, 2]));
    word("clock", random.pick(&[1, 2, 3, 4]));
    word("beat", random.pick(&[4, 8, 16]));
    word("banks", random.pick(&[1, 2, 4]));
    word("row", random.pick(&[32, 64, 256]));
    for key in ["cl", "rcd", "rp"] {
        word(key, random.below(4));
    }
    word("ras", random.below(9));
    word("rc", random.below(12));
    word("rrd", random.below(5));
    word("wr", random.below(3));
    word("refresh", random.pick(&[0, 40, 75]));
    word("rfc", 1 + random.below(8));
    word("pci-setup", random.below(20));
    word("pci-beat", random.pick(&[4, 8, 3]));
    word("pci-clock", 1 + random.below(4));
    word("triangles", random.pick(&[0, 20, 256]));
    let hash = random.pick(&["low", "add-upper", "add-upper-all"]);
    let policy = random.pick(&["lru", "lru", "lru", "fifo", "plru"]);
    format!("{} version={version} hash={hash} policy={policy}", words.join(" "))
}

/// Most packets of a run, so that an earlier one does not make it long.
const PACKETS: usize = 12;

/// The requests of a seed, each with its newline; the last is a run.
///
/// # Panics
/// If `config` is none.
#[must_use]
pub fn requests(config: &str, seed: u64, count: usize) -> Vec<u8> {
    let setting = config::parse(config).expect("a configuration of the kit");
    let mut random = Random::new(seed);
    let line = match setting.chip.version {
        Version::None => setting.chip.sdram.row_bytes,
        Version::A | Version::B => setting.chip.cache.geometry.line().0 as u32,
    };
    let mut text = String::new();
    let mut packets = 0;
    for number in 1..=count {
        let request = match random.below(100) {
            _ if number == count => Request::Run,
            _ if packets > PACKETS => {
                packets = 0;
                Request::Flush
            }
            0..10 => Request::Run,
            10..16 => {
                packets = 0;
                Request::Flush
            }
            16..24 => Request::Before(operations(&mut random, line, setting.triangles)),
            _ => {
                packets += 1;
                Request::Packet(operations(&mut random, line, setting.triangles))
            }
        };
        text.push_str(&request.to_string());
        text.push('\n');
    }
    text.into_bytes()
}

/// A packet: some operations at few places, within a few lines of so many bytes.
fn operations(random: &mut Random, line: u32, triangles: HostAddr) -> Vec<Operation> {
    let few = random.percent(50);
    let count = random.below(if few { 3 } else { 9 });
    let one = |random: &mut Random| {
        let unit = random.pick(&Unit::ALL);
        let near = line * random.below(6) as u32;
        let place = match random.below(20) {
            // In the same row and set, or anywhere.
            0..2 => near * 64,
            2 => random.bits() as u32 >> 2,
            _ => near,
        };
        // Around the boundaries of lines.
        let addr = place + random.pick(&[0, 0, 4, 8, line - 4, line - 1, line / 2]);
        let addr = if unit == Unit::Intersection { addr + triangles.0 } else { addr };
        let bytes = random.pick(&[0, 1, 4, 4, 8, 8, 20, 36]);
        let rays = match random.below(6) {
            0 if bytes > 0 => 0,
            0 | 1 => 1,
            2 => RAYS,
            _ => 1 + random.below(RAYS.into()) as u8 / 4,
        };
        Operation { addr: HostAddr(addr), bytes, rays, unit }
    };
    (0..count).map(|_| one(random)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Chip;
    use crate::kind::Kind as _;

    #[test]
    fn sessions_are_legal_and_of_the_size_asked_for() {
        for seed in 0..200 {
            let session = Chip.random(seed, 100);
            Chip.check(&session).expect("legal");
            assert_eq!(session.requests().count(), 100, "{seed}");
            assert_eq!(session.requests().last(), Some(&b"run"[..]));
        }
    }
}
