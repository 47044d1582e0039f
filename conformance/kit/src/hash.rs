//! `saarcor-hash`: the set of a line, alone.

use crate::comparison::{Comparison, Difference, Expected};
use crate::coverage::{Coverage, CoverageCount};
use crate::error::Error;
use crate::hex;
use crate::implementation::Implementation;
use crate::kind::{Candidates, Kind, Oracle};
use crate::level::Level;
use crate::session::Session;
use crate::suites;
use crate::vm::config::HASHES;
use crate::words::{Values, name_of};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, LineAddr, Policy};
use saarcor_oracles::cache::NaiveCache;
use saarcor_random::Random;
use std::borrow::Cow;

/// The kind `saarcor-hash`.
#[derive(Clone, Copy, Debug)]
pub struct SetHash;

/// Most sets: those of 4 GiB in lines of one byte.
const MAX_SET_BITS: u32 = 32;

/// All of them as powers of two, in the order in which seeds take them.
const SET_BITS: [u32; MAX_SET_BITS as usize + 1] = [
    4, 0, 14, 1, 9, 20, 32, 7, 2, 3, 5, 6, 8, 10, 11, 12, 13, 15, 16, 17, 18, 19, 21, 22, 23, 24, 25, 26, 27,
    28, 29, 30, 31,
];

/// What is observed.
const OBSERVES: &str = "set";

/// The keys of a configuration.
const KEYS: [&str; 2] = ["sets", "hash"];

/// The base 2 logarithm of the sets, and the hash, of a configuration `sets=16384 hash=add-upper`.
fn parse(config: &str) -> Result<(u32, Hash), Error> {
    let values = Values::parse(config, &KEYS)?;
    let sets: u64 = values.number("sets")?;
    if !sets.is_power_of_two() || sets > 1 << MAX_SET_BITS {
        return Err(format!("sets={sets}: it must be a power of two up to {}", 1_u64 << MAX_SET_BITS).into());
    }
    Ok((sets.ilog2(), values.named("hash", HASHES)?))
}

fn line_of(request: &[u8]) -> Result<LineAddr, Error> {
    let number = request.strip_prefix(b"s ").and_then(hex::number).and_then(|line| u32::try_from(line).ok());
    Ok(LineAddr(number.ok_or("write 's LINE' in hex")?))
}

/// The model or the naive reference.
enum SetOracle {
    Model { hash: Hash, set_bits: u32 },
    Naive(Box<NaiveCache>),
}

impl SetOracle {
    fn new(oracle: Oracle, config: &str) -> Result<Self, Error> {
        let (set_bits, hash) = parse(config)?;
        Ok(match oracle {
            Oracle::Model => Self::Model { hash, set_bits },
            Oracle::Naive => {
                let geometry = Geometry::new(Bytes(1 << set_bits), Bytes(1), 1);
                let geometry = geometry.map_err(|error| error.to_string())?;
                Self::Naive(Box::new(NaiveCache::new(CacheConfig { geometry, hash, policy: Policy::Lru })))
            }
        })
    }
}

impl Implementation for SetOracle {
    fn observes(&self) -> String {
        OBSERVES.to_owned()
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let line = line_of(request)?;
        let set = match self {
            Self::Model { hash, set_bits } => u64::from(hash.set_of(line, *set_bits).0),
            Self::Naive(cache) => cache.set_of(line),
        };
        hex::push_number(answer, set);
        Ok(())
    }
}

impl Kind for SetHash {
    fn hello(&self) -> &'static str {
        "saarcor-hash 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::State]
    }

    fn observable(&self) -> &'static [(&'static str, Level)] {
        &[(OBSERVES, Level::State)]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::HASH
    }

    fn random_config(&self, seed: u64) -> Cow<'static, str> {
        let set_bits = SET_BITS[(seed / HASHES.len() as u64 % SET_BITS.len() as u64) as usize];
        let (name, _) = HASHES[(seed % HASHES.len() as u64) as usize];
        format!("sets={} hash={name}", 1_u64 << set_bits).into()
    }

    /// Each number of sets with each hash.
    fn configurations(&self) -> usize {
        SET_BITS.len() * HASHES.len()
    }

    /// Any lines, and lines around the powers of two and the multiples of the set count.
    fn random_requests(&self, config: &str, seed: u64, count: usize) -> Vec<u8> {
        let (set_bits, _) = parse(config).expect("a configuration of the kit");
        let mut random = Random::new(seed);
        let mut text = Vec::new();
        for _ in 0..count {
            let near = match random.below(3) {
                0 => random.bits() as u32,
                1 => (1_u32 << random.below(32)).wrapping_sub(1).wrapping_add(random.below(3) as u32),
                _ => ((random.below(64) << set_bits) as u32)
                    .wrapping_add(random.below(3) as u32)
                    .wrapping_sub(1),
            };
            text.extend_from_slice(b"s ");
            hex::push_number(&mut text, u64::from(near));
            text.push(b'\n');
        }
        text
    }

    fn check(&self, session: &Session) -> Result<(), Error> {
        parse(session.config()).map_err(Error::in_config)?;
        session.check_requests(|request| line_of(request).map(|_| ()))
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Implementation>, Error> {
        Ok(Box::new(SetOracle::new(oracle, config)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        KEYS.to_vec()
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, Error> {
        if observes != OBSERVES {
            return Err(format!("'ok observes={OBSERVES}' is right").into());
        }
        let model = SetOracle::new(Oracle::Model, session.config())?;
        Ok(Box::new(SetComparison { expected: Expected::new(model) }))
    }

    /// Fewer sets, and the hash that adds less.
    fn simpler_configs(&self, config: &str) -> Vec<String> {
        let Ok((set_bits, hash)) = parse(config) else { return Vec::new() };
        let with =
            |set_bits: u32, hash| format!("sets={} hash={}", 1_u64 << set_bits, name_of(HASHES, &hash));
        let steps =
            [with(set_bits / 2, hash), with(set_bits.saturating_sub(1), hash), with(set_bits, Hash::Low)];
        steps.into_iter().filter(|simpler| simpler != &with(set_bits, hash)).collect()
    }

    /// The line without each of its bits.
    fn simpler_requests<'a>(&self, _session: &Session, request: &'a [u8]) -> Candidates<'a, String> {
        let line = line_of(request).map_or(0, |line| line.0);
        let bits = (0..32).rev().filter(move |bit| line >> bit & 1 == 1);
        Box::new(bits.map(move |bit| format!("s {:x}", line & !(1 << bit))))
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::new(BitsOfLines::default())
    }
}

/// Compares sets.
struct SetComparison {
    expected: Expected<SetOracle>,
}

impl Comparison for SetComparison {
    fn observed(&self, level: Level) -> bool {
        matches!(level, Level::Protocol | Level::State)
    }

    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        if self.expected.equals(request, answer)? {
            return Ok(());
        }
        let got = hex::number(answer).ok_or("the number of a set in hex is right")?;
        let right = hex::number(self.expected.answer()).ok_or("the number of a set in hex is right")?;
        if got != right {
            let says = format!("set {got:x}; {right:x} is right");
            found(Difference { level: Level::State, says, requirement: "VM-3" });
        }
        Ok(())
    }

    fn expected(&self) -> &[u8] {
        self.expected.answer()
    }
}

/// Which bits of a line were set in a request, by hash.
#[derive(Clone, Copy, Debug, Default)]
struct BitsOfLines([u32; HASHES.len()]);

impl Coverage for BitsOfLines {
    fn add(&mut self, session: &Session) {
        let Ok((_, hash)) = parse(session.config()) else { return };
        let lines = session.requests().filter_map(|request| line_of(request).ok());
        let place = HASHES.iter().position(|(_, known)| *known == hash).unwrap_or_default();
        self.0[place] |= lines.fold(0, |bits, LineAddr(line)| bits | line);
    }

    fn counts(&self) -> Vec<CoverageCount> {
        let rows = HASHES.iter().zip(self.0).map(|((name, _), bits)| CoverageCount {
            what: format!("bits of a line with hash {name}"),
            reached: bits.count_ones() as usize,
            all: 32,
        });
        rows.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configurations_are_read() {
        assert_eq!(parse("sets=16 hash=low").ok(), Some((4, Hash::Low)));
        assert_eq!(parse("hash=add-upper-all sets=4294967296").ok(), Some((32, Hash::AddUpperAll)));
        for (config, says) in [
            ("sets=3 hash=low", "power of two"),
            ("sets=8589934592 hash=low", "4294967296"),
            ("sets=x hash=low", "decimal"),
            ("sets=16 hash=upper", "add-upper"),
            ("sets=16", "hash is missing"),
            ("ways=4", "sets, hash"),
        ] {
            assert!(parse(config).is_err_and(|error| error.to_string().contains(says)), "{config}");
        }
    }

    #[test]
    fn random_sessions_are_legal() {
        for seed in 0..24 {
            let session = SetHash.random(seed, 100);
            SetHash.check(&session).expect("legal");
            assert_eq!(session.requests().count(), 100);
        }
    }

    #[test]
    fn simpler_configurations_end() {
        let mut config = "sets=4294967296 hash=add-upper-all".to_owned();
        while let Some(next) = SetHash.simpler_configs(&config).pop() {
            config = next;
        }
        assert_eq!(config, "sets=1 hash=low");
    }
}
