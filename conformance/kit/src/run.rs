//! All sessions with one implementation, and the report.

use crate::dut::{Dut, Timeout};
use crate::gather::{Gathered, Held, gather};
use crate::judge::{Finding, Judge};
use crate::kind::Kind;
use crate::level::Level;
use crate::report::{
    AtLevel, Failure, LevelVerdict, Report, RequirementVerdict, SCHEMA_VERSION, Unsupported, Verdict,
    shown_lines,
};
use crate::session::Session;
use crate::shrink::{Shrunk, shrink};
use crate::stop::Stop;
use anyhow::{Context, Result, bail};
use rayon::prelude::*;

/// Requests of the random part where nothing is said.
pub const RANDOM_REQUESTS: usize = 2_000_000;
/// Sessions that fail before a run is stopped, where nothing is said.
pub const ERRORS: usize = 20;
/// Least random sessions: each configuration has its turn.
const RANDOM_SESSIONS: usize = 24;
/// Most requests of a random session: so many that starting it takes little of its time, and that a
/// count of 16 bits runs over; and so few that many fit into memory.
const SESSION_REQUESTS: usize = 100_000;
/// Failures that are shrunk: of each requirement and level the first, and no more than these.
const SHOWN_FAILURES: usize = 8;

/// What is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The highest level that is judged, and that has to be passed; none: all that is observed.
    pub level: Option<Level>,
    /// Sessions that fail before the run is stopped.
    pub errors: usize,
    /// First seed of the random sessions.
    pub seed: u64,
    /// Requests of all random sessions together.
    pub requests: usize,
    /// By how many thousandths a timing may be off.
    pub tolerance: u32,
}

impl Options {
    /// The highest level that is judged.
    pub(crate) fn highest(&self) -> Level {
        self.level.unwrap_or(Level::HIGHEST)
    }
}

impl Default for Options {
    fn default() -> Self {
        Self { level: None, errors: ERRORS, seed: 0, requests: RANDOM_REQUESTS, tolerance: 0 }
    }
}

/// A session to be held.
#[derive(Clone, Debug)]
pub enum Planned {
    /// This one.
    Directed(Box<Session>),
    /// The random one of a seed.
    Random {
        /// The seed.
        seed: u64,
        /// Its requests.
        requests: usize,
    },
}

/// The part of the requests of the random sessions that a recorded frame has at most: a frame takes
/// no more of the time than a few random sessions.
const FRAME_PART: usize = 20;

/// The default suite of a kind: the directed sessions, recorded frames, and random ones.
///
/// # Errors
/// Where a suite of the kit is no session: a fault of the kit.
pub fn default_suite(kind: &dyn Kind, options: &Options) -> Result<Vec<Planned>> {
    let mut planned = Vec::new();
    for (name, text) in kind.suites() {
        let sessions = Session::parse(name, text).with_context(|| format!("suite {name}"))?;
        planned.extend(sessions.into_iter().map(|session| Planned::Directed(Box::new(session))));
    }
    let recorded = kind.recorded(options.requests.div_ceil(FRAME_PART));
    planned.extend(recorded.into_iter().map(|session| Planned::Directed(Box::new(session))));
    planned.extend(random_sessions(options.seed, options.requests));
    Ok(planned)
}

/// Random sessions from a seed on, of so many requests together.
pub fn random_sessions(seed: u64, requests: usize) -> impl Iterator<Item = Planned> {
    let sessions = if requests == 0 { 0 } else { requests.div_ceil(SESSION_REQUESTS).max(RANDOM_SESSIONS) };
    (0..sessions as u64).map(move |number| Planned::Random {
        seed: seed.wrapping_add(number),
        requests: requests.div_ceil(sessions),
    })
}

/// Sessions that a name stands for: a suite of the kit or one of its sessions, a random session
/// (`vm/random/17`), or the path of a suite file.
///
/// # Errors
/// Where there is no such suite or file, or it is no session.
pub fn sessions_named(name: &str, requests: usize) -> Result<(&'static dyn Kind, Vec<Session>)> {
    for kind in crate::KINDS {
        if let Some(rest) = name.strip_prefix(&format!("{}/", kind.prefix())) {
            if let Some(seed) = rest.strip_prefix("random/").and_then(|seed| seed.parse().ok()) {
                return Ok((*kind, vec![kind.random(seed, requests)]));
            }
            for (suite, text) in kind.suites() {
                let sessions = Session::parse(suite, text).with_context(|| format!("suite {suite}"))?;
                if *suite == name {
                    return Ok((*kind, sessions));
                }
                if let Some(session) = sessions.into_iter().find(|session| session.name == name) {
                    return Ok((*kind, vec![session]));
                }
            }
            if let Some(session) = kind.recorded(usize::MAX).into_iter().find(|session| session.name == name)
            {
                return Ok((*kind, vec![session]));
            }
        }
    }
    let text = std::fs::read(name).with_context(|| {
        format!("{name}: neither a suite ('saarcor conform list' shows all) nor a file that can be read")
    })?;
    let text = String::from_utf8(text).ok().with_context(|| format!("{name}: no text"))?;
    let sessions = Session::parse(name, &text).with_context(|| name.to_owned())?;
    let hello = sessions.first().map_or("", Session::hello);
    let Some(kind) = crate::KINDS.iter().find(|kind| kind.hello() == hello) else {
        let known: Vec<_> = crate::KINDS.iter().map(|kind| kind.hello()).collect();
        bail!("{name}: the hello '{hello}' is none of {}", known.join(", "));
    };
    for session in &sessions {
        kind.check(session).map_err(|wrong| anyhow::anyhow!("{name}: {wrong}"))?;
    }
    Ok((*kind, sessions))
}

/// The kind of an implementation, by the hello that it answers; none where it answers none.
///
/// # Errors
/// Where it cannot be started.
pub fn kind_of(dut: &dyn Dut) -> Result<Option<&'static dyn Kind>> {
    for kind in crate::KINDS {
        let options = Options { requests: 0, ..Options::default() };
        let session = default_suite(*kind, &options)?;
        let session = session.first().context("a kind has sessions")?.session(*kind, &options);
        let mut judge = Judge::new(*kind, &session, Level::Protocol);
        let ending = dut.converse(&session, &mut judge, &Stop::never())?;
        let refused = judge.findings().iter().find(|finding| finding.asked == kind.hello());
        let Some(finding) = refused else { return Ok(Some(*kind)) };
        if let Some(named) = crate::KINDS.iter().find(|kind| kind.hello() == finding.got) {
            return Ok(Some(*named));
        }
        if ending.timeout.is_some() {
            break;
        }
    }
    Ok(None)
}

/// Holds all sessions, and says what was found. `progress` is told the part that is done.
///
/// # Errors
/// Where the implementation cannot be started.
pub fn run(
    name: &str,
    dut: &dyn Dut,
    kind: &dyn Kind,
    planned: &[Planned],
    options: &Options,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Report> {
    let Gathered { held, stopped, random_seconds, shrinking } =
        gather(dut, kind, planned, options, progress)?;
    let failures = failures(dut, kind, planned, &held, (options, &shrinking))?;
    Ok(Summary { name, kind, planned, held: &held, options }.report(failures, stopped, random_seconds))
}

impl Planned {
    /// The session, which is made where it is random.
    pub(crate) fn session(&self, kind: &dyn Kind, options: &Options) -> Session {
        let session = match self {
            Self::Directed(session) => (**session).clone(),
            Self::Random { seed, requests } => kind.random(*seed, *requests),
        };
        if options.tolerance == 0 { session } else { kind.with_tolerance(session, options.tolerance) }
    }
}

/// Of each requirement and level the first session that fails, shrunk.
fn failures(
    dut: &dyn Dut,
    kind: &dyn Kind,
    planned: &[Planned],
    held: &[Held],
    how: (&Options, &Stop),
) -> Result<Vec<Failure>> {
    let mut chosen: Vec<(usize, &Finding)> = Vec::new();
    for (place, session) in held.iter().enumerate() {
        // The lowest level: those above follow from it.
        let Some(finding) = session.findings.iter().min_by_key(|finding| finding.level) else { continue };
        let same = |&(other, known): &(usize, &Finding)| {
            let row = &held[other].row;
            row == &session.row && known.level == finding.level && known.requirement == finding.requirement
        };
        if !chosen.iter().any(same) {
            chosen.push((place, finding));
        }
    }
    chosen.truncate(SHOWN_FAILURES);
    let of = |&(place, finding): &(usize, &Finding)| {
        let session = planned[held[place].place].session(kind, how.0);
        failure(dut, kind, &session, finding, &held[place], how)
    };
    chosen.par_iter().map(of).collect()
}

fn failure(
    dut: &dyn Dut,
    kind: &dyn Kind,
    session: &Session,
    finding: &Finding,
    held: &Held,
    (options, stop): (&Options, &Stop),
) -> Result<Failure> {
    let mut trouble = None;
    let mut fails = |session: &Session| {
        let mut judge = Judge::new(kind, session, options.highest());
        if let Err(error) = dut.converse(session, &mut judge, stop) {
            trouble.get_or_insert(error);
            return None;
        }
        let same =
            |found: &&Finding| found.level == finding.level && found.requirement == finding.requirement;
        judge.findings().iter().find(same).cloned()
    };
    let Shrunk { session: minimal, finding, cut_short } = if held.timeout.is_some() || stop.has_come() {
        // Each try would take the time limit again: only what was not asked for yet is left out.
        let session = session.with_requests(session.requests().take(finding.asked_by_then()));
        Shrunk { session, finding: finding.clone(), cut_short: true }
    } else {
        shrink(kind, session, finding, stop, &mut fails)
    };
    if let Some(error) = trouble {
        return Err(error);
    }
    let requirement = requirement(session, &finding);
    Ok(Failure {
        requirement,
        level: finding.level,
        session: session.name.clone(),
        row: held.row.clone(),
        idea: session.idea.clone(),
        says: finding.says.clone(),
        suite: minimal.to_suite(),
        minimal: shown_lines(minimal.text()),
        minimal_requests: minimal.requests().count(),
        found_requests: session.requests().count(),
        cut_short,
        state_before: finding.request.map(|request| kind.state_before(&minimal, request)).unwrap_or_default(),
        asked: finding.asked.clone(),
        expected: finding.expected.clone(),
        got: finding.got.clone(),
        stderr: held.stderr.clone(),
        replay: None,
    })
}

/// The requirement that a session fails for. A directed one is about its own, whatever differs; but for
/// bytes, unless it is about bytes, and a conversation that breaks off, unless it is about answers and
/// their form.
fn requirement(session: &Session, finding: &Finding) -> String {
    let own = finding.requirement.to_owned();
    let Some(about) = session.requirement.clone() else { return own };
    let of_bytes = finding.level == Level::Data && session.level != Some(Level::Data);
    let breaks_off = finding.level == Level::Protocol && !(about.starts_with("P-") && own == "P-5");
    if breaks_off || of_bytes || own == ENTRY_BYTES { own } else { about }
}

/// The requirement of what an entry of metadata consists of.
const ENTRY_BYTES: &str = "VM-12";

/// What a report is made of.
struct Summary<'a> {
    name: &'a str,
    kind: &'a dyn Kind,
    planned: &'a [Planned],
    held: &'a [Held],
    options: &'a Options,
}

impl Summary<'_> {
    fn report(&self, failures: Vec<Failure>, stopped: Option<String>, random_seconds: f64) -> Report {
        let levels = self.levels();
        let passed = |level: &&LevelVerdict| level.verdict == AtLevel::Passed;
        let before_failed = levels.iter().take_while(|level| level.verdict != AtLevel::Failed);
        let highest = before_failed.filter(passed).map(|level| level.level).last();
        let errors = self.held.iter().filter(|held| !held.findings.is_empty()).count();
        let at_asked = levels.iter().find(|level| Some(level.level) == self.options.level);
        let slow = self.held.iter().any(|held| held.timeout == Some(Timeout::Slow));
        let judged = self.held.iter().any(|held| held.unsupported.is_none());
        let passed = at_asked.is_none_or(|level| level.verdict == AtLevel::Passed);
        let told = judged && !slow && passed;
        let told = told && highest.is_some_and(|highest| highest > Level::Protocol);
        let verdict = match (errors, told) {
            (0, true) => Verdict::Conforms,
            (0, false) => Verdict::Incomplete,
            _ => Verdict::DoesNotConform,
        };
        let random = || self.held.iter().filter(|held| held.random);
        Report {
            schema_version: SCHEMA_VERSION,
            dut: self.name.to_owned(),
            kind: self.kind.name().to_owned(),
            verdict,
            highest,
            asked: self.options.level,
            tolerance: self.options.tolerance,
            levels,
            requirements: self.requirements(),
            failures,
            unsupported: self.unsupported(),
            coverage: self.coverage(),
            sessions: self.held.len(),
            errors,
            requests: self.held.iter().map(|held| held.answered as u64).sum(),
            random_requests: random().map(|held| held.answered as u64).sum(),
            random_seconds,
            stopped: stopped.or_else(|| {
                slow.then(|| {
                    "sessions reached the time limit: take fewer requests, or a longer limit".to_owned()
                })
            }),
        }
    }

    fn levels(&self) -> Vec<LevelVerdict> {
        let lowest_failed =
            self.held.iter().flat_map(|held| &held.findings).map(|finding| finding.level).min();
        let verdict = |&level: &Level| {
            let verdict = if level > self.options.highest() {
                AtLevel::NotAsked
            } else if lowest_failed.is_some_and(|failed| failed <= level) {
                AtLevel::Failed
            } else if self
                .held
                .iter()
                .any(|held| held.observed.contains(&level) && held.unsupported.is_none())
            {
                AtLevel::Passed
            } else {
                AtLevel::NotObserved
            };
            LevelVerdict { level, verdict }
        };
        self.kind.levels().iter().map(verdict).collect()
    }

    fn requirements(&self) -> Vec<RequirementVerdict> {
        let mut rows: Vec<RequirementVerdict> = Vec::new();
        for held in self.held.iter().filter(|held| held.unsupported.is_none()) {
            let place = rows.iter().position(|row| row.requirement == held.row).unwrap_or_else(|| {
                rows.push(RequirementVerdict { requirement: held.row.clone(), sessions: 0, failed: 0 });
                rows.len() - 1
            });
            rows[place].sessions += 1;
            rows[place].failed += usize::from(!held.findings.is_empty());
        }
        rows
    }

    fn unsupported(&self) -> Vec<Unsupported> {
        let mut rows: Vec<Unsupported> = Vec::new();
        for key in self.held.iter().filter_map(|held| held.unsupported.as_deref()) {
            match rows.iter_mut().find(|row| row.key == key) {
                Some(row) => row.sessions += 1,
                None => rows.push(Unsupported { key: key.to_owned(), sessions: 1 }),
            }
        }
        rows.sort_unstable_by(|a, b| a.key.cmp(&b.key));
        rows
    }

    /// What the sessions exercise that were held to their ends.
    fn coverage(&self) -> Vec<crate::kind::Covered> {
        let mut coverage = self.kind.coverage();
        for held in self.held {
            if held.findings.is_empty() && held.unsupported.is_none() && held.timeout.is_none() {
                coverage.add(&self.planned[held.place].session(self.kind, self.options));
            }
        }
        coverage.rows()
    }
}
