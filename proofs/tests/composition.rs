//! The composition: the table of operations is whole, the induction and the chains of simulations hold for every small
//! machine, and long runs at the sizes that people build are runs of the abstract machines.

use saarcor_fast::version_b::MetadataDecisions;
use saarcor_model::vm::{
    Bytes, CacheConfig, CachedMetadata, Directory, FirstLevelCaches, Geometry, Hash, HostAddr, LineAddr,
    MetadataTraffic, Policy, Set, SetIndex, Unit, VirtualMemory,
};
use saarcor_proofs::refinement::directory::{self, AtOneSet, OneSet};
use saarcor_proofs::refinement::first_level::ChipIsFlat;
use saarcor_proofs::refinement::machine::{Along, Chain, Machine, Simulation, begin, run, step};
use saarcor_proofs::refinement::memory::{self, Card, Flat, IsFlat};
use saarcor_proofs::refinement::table::{SPECIFICATION, TWINS, gaps, operations, page};
use saarcor_proofs::refinement::twins::{Fast, TwinOfA, TwinOfB};
use saarcor_proofs::source::Stop;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file)
}

fn theorems() -> BTreeSet<&'static str> {
    saarcor_proofs::theorems().map(|theorem| theorem.name).collect()
}

// The table.

#[test]
fn each_public_operation_has_its_theorems() {
    let theorems = theorems();
    let mut found = Vec::new();
    for (file, rows) in SPECIFICATION {
        let source = fs::read_to_string(path(file)).expect("a file of the specification");
        found.extend(gaps(file, &source, rows, &theorems));
    }
    for (file, rows) in TWINS {
        let source = fs::read_to_string(path(file)).expect("a file of the twins");
        let rows: Vec<_> = rows.iter().map(|(name, _, by)| (*name, *by)).collect();
        found.extend(gaps(file, &source, &rows, &theorems));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A twin is one of an operation that is there, and is shown by theorems of equality.
#[test]
fn twins_are_of_operations_and_equal_by_theorems_of_equality() {
    let specified: BTreeSet<_> =
        SPECIFICATION.iter().flat_map(|(_, rows)| rows.iter().map(|row| row.0)).collect();
    for (name, of, by) in TWINS.iter().flat_map(|(_, rows)| rows.iter()) {
        assert!(specified.contains(of), "{name} is the twin of {of}, which the table does not have");
        for theorem in saarcor_proofs::theorems().filter(|theorem| by.contains(&theorem.name)) {
            let unit = theorem.unit();
            assert!(unit.starts_with("equal::"), "{name}: {} is of {unit}", theorem.name);
        }
    }
}

#[test]
fn the_page_of_composition_is_generated() {
    let file = path("proofs/COMPOSITION.md");
    if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
        fs::write(file, page()).expect("the page again");
    } else {
        let current = fs::read_to_string(file).unwrap_or_default();
        assert!(
            current == page(),
            "proofs/COMPOSITION.md is old: SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-proofs --test composition"
        );
    }
}

const MADE_UP: &str = "
impl Cache {
    const WAYS: usize = 2;

    /// Uses a line.
    #[must_use]
    pub fn access(&mut self, line: u32) -> bool {
        fn inner() {}
        pub fn deeper() {}
        true
    }

    pub(crate) fn not_public(&self) {}

    fn private(&self) {}
}

impl<const WAYS: usize, M: Metadata<WAYS>, F: Fn() -> u32>
    Metadata<WAYS> for Cached<WAYS, M, F>
where
    M: Copy,
{
    fn load(&mut self) {}
}

impl Observer for () {}

#[inline]
pub fn alone<const WAYS: usize>() {}

fn hidden() {}

pub const fn constant() -> u32 {
    0
}

#[cfg(test)]
mod tests {
    pub fn of_a_test() {}
}
";

#[test]
fn operations_are_read_from_the_source() {
    assert_eq!(operations(MADE_UP), ["Cache::access", "Cached::load", "alone", "constant"]);
}

#[test]
fn an_operation_without_theorem_is_found() {
    let theorems = BTreeSet::from(["a", "b"]);
    let whole: [(&str, &[&str]); 4] =
        [("Cache::access", &["a"]), ("Cached::load", &["a", "b"]), ("alone", &["b"]), ("constant", &["b"])];
    assert_eq!(gaps("made_up.rs", MADE_UP, &whole, &theorems), [""; 0]);
    assert_eq!(
        gaps("made_up.rs", MADE_UP, &whole[1..], &theorems),
        ["made_up.rs: no theorem is given for the step of Cache::access"]
    );
    let added = MADE_UP.replace("    fn private(", "    pub fn peek(");
    assert_eq!(
        gaps("made_up.rs", &added, &whole, &theorems),
        ["made_up.rs: no theorem is given for the step of Cache::peek"]
    );
    let gone = MADE_UP.replace("pub fn alone", "fn alone");
    assert_eq!(gaps("made_up.rs", &gone, &whole, &theorems), ["made_up.rs has no public operation alone"]);
    assert_eq!(
        gaps("made_up.rs", MADE_UP, &whole, &BTreeSet::from(["a"])),
        [
            "made_up.rs: Cached::load names b, which is no theorem",
            "made_up.rs: alone names b, which is no theorem",
            "made_up.rs: constant names b, which is no theorem"
        ]
    );
    let mut without = whole;
    without[0].1 = &[];
    assert_eq!(
        gaps("made_up.rs", MADE_UP, &without, &theorems),
        ["made_up.rs: Cache::access has no theorem"]
    );
}

/// Tried on the real source: one more operation, and one less, in each file.
#[test]
fn a_change_of_any_file_is_found() {
    let theorems = theorems();
    for (file, rows) in SPECIFICATION {
        let source = fs::read_to_string(path(file)).expect("a file of the specification");
        let more = format!("pub fn one_more() {{}}\n{source}");
        assert_eq!(gaps(file, &more, rows, &theorems).len(), 1, "{file}: one more");
        assert_eq!(gaps(file, &source, &rows[1..], &theorems).len(), 1, "{file}: a row less");
        assert_eq!(gaps(file, "", rows, &theorems).len(), rows.len(), "{file}: none left");
    }
}

// The induction and the composition, for every machine of three states, two requests and two answers.

const STATES: usize = 3;
const REQUESTS: usize = 2;

/// A machine by its table: of each state and request, the answer and the state after it.
#[derive(Clone, Copy, Debug)]
struct Table {
    steps: [[(u8, u8); REQUESTS]; STATES],
    state: u8,
}

impl Machine for Table {
    type Request = u8;
    type Answer = u8;

    fn step(&mut self, request: &u8) -> u8 {
        let (answer, next) = self.steps[usize::from(self.state)][usize::from(*request)];
        self.state = next;
        answer
    }
}

/// A relation between the states of two tables, bit by bit; in a cell of its thread, since a simulation has no value.
macro_rules! relation {
    ($name:ident, $cell:ident) => {
        thread_local!(static $cell: std::cell::Cell<u16> = const { std::cell::Cell::new(0) });

        #[derive(Debug)]
        struct $name;

        impl Simulation for $name {
            type Concrete = Table;
            type Abstract = Table;

            fn related(concrete: &Table, model: &Table) -> bool {
                $cell.get() >> (usize::from(concrete.state) * STATES + usize::from(model.state)) & 1 == 1
            }

            fn asked(request: &u8, _: &u8, _: &Table, _: &Table) -> u8 {
                *request
            }

            fn agree(answer: &u8, expected: &u8) -> bool {
                answer == expected
            }
        }
    };
}

relation!(Lower, LOWER);
relation!(Upper, UPPER);

/// Numbers at random, the same in every run (Marsaglia 2003, xorshift).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16) % end
    }

    fn table(&mut self) -> Table {
        let mut steps = [[(0, 0); REQUESTS]; STATES];
        for cell in steps.as_flattened_mut() {
            *cell = (self.below(2) as u8, self.below(STATES as u64) as u8);
        }
        Table { steps, state: 0 }
    }
}

/// Whether every step from any related states keeps the relation: what a theorem of the step says.
fn every_step_holds<S: Simulation<Concrete = Table, Abstract = Table>>(
    concrete: Table,
    model: Table,
) -> bool {
    (0..STATES * STATES * REQUESTS).all(|case| {
        let (mut concrete, mut model) = (concrete, model);
        concrete.state = (case % STATES) as u8;
        model.state = (case / STATES % STATES) as u8;
        let request = (case / STATES / STATES) as u8;
        !S::related(&concrete, &model) || step::<S>(&mut concrete, &mut model, &request).is_ok()
    })
}

/// All runs of so many steps.
fn runs(length: u32) -> impl Iterator<Item = Vec<u8>> {
    (0..1_u32 << length).map(move |run| (0..length).map(|i| (run >> i & 1) as u8).collect())
}

/// Random tables are hardly ever related: the second is the first, with its states renamed and perhaps one cell changed.
fn renamed(numbers: &mut Numbers, table: &Table) -> (Table, u16) {
    let turn = numbers.below(STATES as u64) as usize;
    let name = |state: usize| (state + turn) % STATES;
    let (mut renamed, mut relation) = (*table, 0);
    for state in 0..STATES {
        relation |= 1 << (state * STATES + name(state));
        for request in 0..REQUESTS {
            let (answer, next) = table.steps[state][request];
            renamed.steps[name(state)][request] = (answer, name(next.into()) as u8);
        }
    }
    renamed.state = name(table.state.into()) as u8;
    if numbers.below(2) == 0 {
        renamed.steps[numbers.below(STATES as u64) as usize][numbers.below(2) as usize].0 ^= 1;
    }
    // Perhaps a state less is related.
    relation &= !(u16::from(numbers.below(3) == 0) << numbers.below((STATES * STATES) as u64));
    (renamed, relation)
}

#[test]
fn base_and_steps_make_every_run() {
    let mut numbers = Numbers(2003);
    let (mut sound, mut unsound) = (0, 0);
    for _ in 0..20_000 {
        let concrete = numbers.table();
        let (model, relation) = renamed(&mut numbers, &concrete);
        LOWER.set(relation);
        let shown = begin::<Lower>(&concrete, &model).is_ok() && every_step_holds::<Lower>(concrete, model);
        let all_hold =
            runs(6).all(|requests| run::<Lower>(&mut { concrete }, &mut { model }, requests) == Ok(6));
        assert!(!shown || all_hold, "{concrete:?}, {model:?}, {relation:b}: a run does not hold");
        sound += u32::from(shown);
        unsound += u32::from(!all_hold);
    }
    assert!(sound > 1000 && unsound > 1000, "{sound} sound, {unsound} with a run that fails");
}

#[test]
fn two_simulations_make_one() {
    let mut numbers = Numbers(1971);
    let (mut sound, mut unsound) = (0, 0);
    for _ in 0..20_000 {
        let concrete = numbers.table();
        let (middle, lower) = renamed(&mut numbers, &concrete);
        let (model, upper) = renamed(&mut numbers, &middle);
        LOWER.set(lower);
        UPPER.set(upper);
        let shown = begin::<Lower>(&concrete, &middle).is_ok()
            && begin::<Upper>(&middle, &model).is_ok()
            && every_step_holds::<Lower>(concrete, middle)
            && every_step_holds::<Upper>(middle, model);
        let all_hold = runs(5).all(|requests| {
            let mut along = Along::<Upper> { middle, model };
            run::<Chain<Lower, Upper>>(&mut { concrete }, &mut along, requests) == Ok(5)
        });
        assert!(!shown || all_hold, "{concrete:?}, {middle:?}, {model:?}: a run of the chain does not hold");
        if shown {
            // The answers of the outer two agree, whatever was between.
            for requests in runs(5) {
                let (mut concrete, mut model) = (concrete, model);
                assert!(requests.iter().all(|request| concrete.step(request) == model.step(request)));
            }
        }
        sound += u32::from(shown);
        unsound += u32::from(!all_hold);
    }
    assert!(sound > 1000 && unsound > 1000, "{sound} sound, {unsound} with a run that fails");
}

// Long runs.

fn standard(memory: u64, line: u64, hash: Hash, policy: Policy) -> CacheConfig {
    CacheConfig { geometry: Geometry::new(Bytes(memory), Bytes(line), 4).expect("legal"), hash, policy }
}

/// Standard caches of 16 384 to 131 072 sets, with each hash and policy, and small ones that always evict.
fn caches() -> [CacheConfig; 5] {
    [
        standard(8 << 20, 128, Hash::AddUpper, Policy::Lru),
        standard(16 << 20, 64, Hash::AddUpperAll, Policy::Plru),
        standard(64 << 20, 128, Hash::Low, Policy::Fifo),
        standard(1 << 10, 64, Hash::AddUpper, Policy::Lru),
        standard(1 << 8, 64, Hash::AddUpper, Policy::Plru),
    ]
}

/// An address in one of seven lines of the watched byte's set, of the next set, or of one far from both: few enough to
/// meet again, more than a set holds.
fn addr(numbers: &mut Numbers, config: &CacheConfig, watched: HostAddr) -> HostAddr {
    let (sets, line) = (config.geometry.sets(), config.geometry.line().0);
    // Lines so far apart share a set.
    let stride = if config.hash == Hash::Low { sets } else { (sets - 1).max(1) };
    let other = [0, 1, sets / 2][numbers.below(3) as usize];
    let near = (numbers.below(7) * stride + other) * line + numbers.below(line);
    HostAddr(watched.0.wrapping_add(near as u32))
}

fn asked_of_directory(numbers: &mut Numbers, config: &CacheConfig, watched: HostAddr) -> directory::Ask {
    let at = addr(numbers, config, watched);
    match numbers.below(400) {
        0 => directory::Ask::Flush,
        1 => directory::Ask::Invalidate(HostAddr(0), u64::MAX),
        2..20 => directory::Ask::Invalidate(at, numbers.below(300)),
        _ => directory::Ask::Access(config.geometry.line_of(at)),
    }
}

fn asked_of_memory(numbers: &mut Numbers, config: &CacheConfig, watched: HostAddr) -> memory::Ask {
    let at = addr(numbers, config, watched);
    match numbers.below(400) {
        0 => memory::Ask::Flush,
        1 => memory::Ask::Invalidate(HostAddr(0), u64::MAX),
        2..20 => memory::Ask::Invalidate(at, numbers.below(300)),
        20..40 => memory::Ask::Write(at, numbers.below(300), numbers.below(256) as u8),
        40..60 => memory::Ask::Write(watched, 1, numbers.below(256) as u8),
        60..120 => memory::Ask::ReadByte(watched),
        120..200 => memory::Ask::Read(watched),
        200..210 => memory::Ask::Read(HostAddr(u32::MAX - numbers.below(4) as u32)),
        210..300 => memory::Ask::Read(at),
        _ => memory::Ask::ReadByte(at),
    }
}

type MetadataOfB = CachedMetadata<4, 4, 16>;

/// The watched bytes of a run: of the first set, of the last, and one between.
fn watched_bytes(config: &CacheConfig) -> [HostAddr; 3] {
    let card = config.geometry.memory().0 as u32;
    [HostAddr(0), HostAddr(card - 1), HostAddr(card / 2 + 17)]
}

fn holds(run: Result<u64, Stop>, steps: u64, what: &str, config: &CacheConfig) {
    match run {
        Ok(taken) => assert_eq!(taken, steps, "{what}, {config:?}"),
        Err(stop) => panic!("{what}, {config:?}: {stop:?}"),
    }
}

/// Versions A and B are one and the same machine at each watched set, over long runs.
#[test]
fn both_versions_run_as_one_set() {
    for (config, steps) in caches().into_iter().zip([2000, 2000, 2000, 20_000, 20_000]) {
        for watched in watched_bytes(&config) {
            let index = config.set_of(config.geometry.line_of(watched));
            let mut one = OneSet { config, index, set: Set::<4>::empty(config.policy) };
            let requests = || {
                let mut numbers = Numbers(7 + u64::from(watched.0));
                (0..steps).map(move |_| asked_of_directory(&mut numbers, &config, watched))
            };
            let mut a = Directory::<4>::new(config);
            holds(run::<AtOneSet<4, _>>(&mut a, &mut { one }, requests()), steps, "version A", &config);
            assert!(a.counters.evictions > 10 && a.counters.hits() > 10, "{config:?}: {:?}", a.counters);
            let mut b = Directory::over(config, MetadataOfB::new(&config, 1, Policy::Lru));
            holds(run::<AtOneSet<4, _>>(&mut b, &mut one, requests()), steps, "version B", &config);
            assert_eq!(a.counters, b.counters, "{config:?}");
            let traffic = b.metadata.observer;
            assert!(traffic.write_backs > 10 || config.geometry.sets() == 1, "{config:?}: {traffic:?}");
        }
    }
}

/// The twin of version B, the specification of version B, and one set of version A run along: a chain of two simulations.
#[test]
fn the_twin_of_version_b_runs_as_one_set() {
    type Twin = TwinOfB<4, 4, 16, MetadataTraffic>;
    for (config, steps) in caches().into_iter().zip([60, 40, 20, 5000, 5000]) {
        let watched = watched_bytes(&config)[2];
        let index = config.set_of(config.geometry.line_of(watched));
        let twin = MetadataDecisions::<4, 4, _>::new(&config, 2, 16, Policy::Lru, MetadataTraffic::default());
        let mut twin = Fast(Directory::over(config, twin));
        let middle = Directory::over(config, MetadataOfB::new(&config, 2, Policy::Lru));
        let model = OneSet { config, index, set: Set::<4>::empty(config.policy) };
        let mut along = Along::<AtOneSet<4, MetadataOfB>> { middle, model };
        let mut numbers = Numbers(11);
        let requests = (0..steps).map(|_| asked_of_directory(&mut numbers, &config, watched));
        let run = run::<Chain<Twin, AtOneSet<4, MetadataOfB>>>(&mut twin, &mut along, requests);
        holds(run, steps, "the twin of version B", &config);
    }
}

/// So does the twin of version A.
#[test]
fn the_twin_of_version_a_runs_as_one_set() {
    for (config, steps) in caches().into_iter().zip([200, 200, 100, 5000, 5000]) {
        let watched = watched_bytes(&config)[1];
        let index = config.set_of(config.geometry.line_of(watched));
        let middle = Directory::<4>::new(config);
        let mut twin = Fast(middle.clone());
        let model = OneSet { config, index, set: Set::<4>::empty(config.policy) };
        let mut along = Along::<AtOneSet<4, _>> { middle, model };
        let mut numbers = Numbers(13);
        let requests = (0..steps).map(|_| asked_of_directory(&mut numbers, &config, watched));
        let run = run::<Chain<TwinOfA<4>, AtOneSet<4, _>>>(&mut twin, &mut along, requests);
        holds(run, steps, "the twin of version A", &config);
    }
}

/// The host's memory: 4 MB that differ from line to line.
fn host() -> Vec<u8> {
    (0..4_u32 << 20).map(|i| (i.wrapping_mul(0x9e37_79b9) >> 24) as u8).collect()
}

/// A virtual memory of either version runs as flat memory, of which each line lies where it was loaded to; and with
/// first-level caches in front of it as flat memory.
#[test]
fn every_memory_runs_as_flat_memory() {
    let host = host();
    for config in caches() {
        for watched in watched_bytes(&config).map(|addr| HostAddr(addr.0 % (host.len() as u32 - 4))) {
            let flat = Flat { addr: watched, byte: host[watched.0 as usize] };
            let card = Card { config, flat, place: None };
            let steps = 2000;
            let requests = || {
                let mut numbers = Numbers(17 + u64::from(watched.0));
                (0..steps).map(move |_| asked_of_memory(&mut numbers, &config, watched))
            };
            let mut a = VirtualMemory::new(Directory::<4>::new(config), host.clone());
            holds(run::<IsFlat<_, 4, _>>(&mut a, &mut { card }, requests()), steps, "version A", &config);
            let b = || Directory::over(config, MetadataOfB::new(&config, 4, Policy::Plru));
            let mut b_alone = VirtualMemory::new(b(), host.clone());
            holds(
                run::<IsFlat<_, 4, _>>(&mut b_alone, &mut { card }, requests()),
                steps,
                "version B",
                &config,
            );
            assert_eq!(a.directory.counters, b_alone.directory.counters, "{config:?}");
            let below = VirtualMemory::new(b(), host.clone());
            let mut chip = FirstLevelCaches::new([256, 2048, 4096, 1024], Policy::Lru, HostAddr(36), below);
            let mut numbers = Numbers(19);
            let of_units = requests().map(|ask| (Unit::ALL[numbers.below(4) as usize], ask));
            holds(run::<ChipIsFlat<_, 4, _>>(&mut chip, &mut { flat }, of_units), steps, "the chip", &config);
            assert!(
                chip.triangles.counters.hits() > 0 && chip.shading.counters.invalidated > 0,
                "{config:?}"
            );
        }
    }
}

/// What no step shows, since each begins in related states, the base does: a cache that begins with a line in it.
#[test]
fn a_cache_that_does_not_begin_empty_is_found() {
    let config = caches()[3];
    let mut directory = Directory::<4>::new(config);
    let one = OneSet { config, index: SetIndex(0), set: Set::<4>::empty(config.policy) };
    assert_eq!(begin::<AtOneSet<4, _>>(&directory, &one), Ok(()));
    directory.metadata.sets[0] = directory.metadata.sets[0].access(LineAddr(0), config.policy).0;
    assert!(matches!(begin::<AtOneSet<4, _>>(&directory, &one), Err(Stop::Disproved(_))));
}
