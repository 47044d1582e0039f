//! The model's cache against a simulator that others wrote: the same trace gives the same hits and
//! misses.
//!
//! `traces/*.toml` say what the simulator gave for a trace beside it. The README describes how they
//! are made.

use saarcor_model::vm::{Bytes, CacheConfig, Directory, Geometry, Hash, HostAddr, LineAddr, Policy};
use saarcor_oracles::cache::NaiveCache;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a simulator gave for a trace, each time from a cold cache without hash.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Simulation {
    trace: String,
    simulator: String,
    version: String,
    policy: NamedPolicy,
    line_bytes: u64,
    ways: u32,
    cold: Vec<Cold>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum NamedPolicy {
    Lru,
    Fifo,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cold {
    memory_bytes: u64,
    hits: u64,
    misses: u64,
}

fn crate_dir() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All simulations that are committed, by the name of their file.
fn simulations() -> Vec<(PathBuf, Simulation)> {
    let mut files: Vec<_> = std::fs::read_dir(crate_dir().join("traces"))
        .expect("the folder of traces")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no simulation to compare with");
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).expect("readable");
        let simulation = toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        (path, simulation)
    };
    files.into_iter().map(read).collect()
}

/// The byte addresses of a din trace of reads: rows of `0 HEXADDRESS`.
fn addresses(trace: &Path) -> Vec<HostAddr> {
    let text = std::fs::read_to_string(trace).expect("readable");
    let address = |row: &str| {
        let digits = row.strip_prefix("0 ").unwrap_or_else(|| panic!("not a read: {row:?}"));
        HostAddr(u32::from_str_radix(digits, 16).expect("hexadecimal"))
    };
    text.lines().map(address).collect()
}

/// Hits and misses of the model.
fn model<const WAYS: usize>(config: CacheConfig, trace: &[HostAddr]) -> (u64, u64) {
    let mut directory = Directory::<WAYS>::new(config);
    for &addr in trace {
        directory.access(config.geometry.line_of(addr));
    }
    (directory.counters.hits(), directory.counters.misses)
}

/// Hits and misses of the naive cache.
fn naive(config: CacheConfig, trace: &[HostAddr]) -> (u64, u64) {
    let mut cache = NaiveCache::new(config);
    for &addr in trace {
        cache.access(LineAddr((u64::from(addr.0) / config.geometry.line().0) as u32));
    }
    (cache.counters().hits(), cache.counters().misses)
}

#[test]
fn model_agrees_with_the_committed_simulations() {
    for (path, simulation) in simulations() {
        let trace = addresses(&crate_dir().join("traces").join(&simulation.trace));
        assert_eq!(simulation.ways, 4, "{}: the paper's caches have 4 ways", path.display());
        assert!(!simulation.cold.is_empty(), "{}", path.display());
        for cold in &simulation.cold {
            let geometry = Geometry::new(Bytes(cold.memory_bytes), Bytes(simulation.line_bytes), 4);
            let config = CacheConfig {
                geometry: geometry.expect("a legal size"),
                hash: Hash::Low,
                policy: match simulation.policy {
                    NamedPolicy::Lru => Policy::Lru,
                    NamedPolicy::Fifo => Policy::Fifo,
                },
            };
            let expected = (cold.hits, cold.misses);
            let at = format!("{}, {} bytes", path.display(), cold.memory_bytes);
            assert_eq!(model::<4>(config, &trace), expected, "model, {at}");
            assert_eq!(naive(config, &trace), expected, "naive cache, {at}");
        }
    }
}

#[test]
#[ignore = "runs pycachesim: SAARCOR_PYTHON has to name a Python that has it (reference/README.md)"]
fn simulator_still_gives_the_committed_simulations() {
    let python = std::env::var_os("SAARCOR_PYTHON").expect("SAARCOR_PYTHON names a Python interpreter");
    for (path, committed) in simulations() {
        let mut check = Command::new(&python);
        check
            .arg(crate_dir().join("pycachesim/check.py"))
            .arg(crate_dir().join("traces").join(&committed.trace))
            .args(["--line", &committed.line_bytes.to_string(), "--ways", &committed.ways.to_string()])
            .args(["--policy", &format!("{:?}", committed.policy).to_uppercase()]);
        for cold in &committed.cold {
            check.args(["--memory", &cold.memory_bytes.to_string()]);
        }
        let output = check.output().expect("SAARCOR_PYTHON runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {errors}", path.display());
        let fresh: Simulation = toml::from_str(&String::from_utf8_lossy(&output.stdout)).expect("TOML");
        assert_eq!(fresh, committed, "{}", path.display());
    }
}
