//! What each theorem rests on, and what each engine has shown of it.
//!
//! A theorem rests on its own text, on the items that this names, on those that these name, and so on; and where
//! a type counts, so does what is implemented for it (`evidence/sources.rs`). All of it is hashed without comments, white
//! space and unit tests. The compiler and other people's crates are not a part of it.
//!
//! What was shown stands in `verdicts.toml`, which `saarcor prove --record` writes. What Kani draws of a
//! theorem stands in `kani_scopes.txt`, which a test compares with the code.

mod rust;
mod sources;

use crate::theorem::Theorem;
use serde::{Deserialize, Serialize};
use sources::Sources;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// The engines, by the names that `verdicts.toml` has for them.
pub const ENGINES: [&str; 3] = ["kani", "exhaustive", "random"];

/// What an engine has shown of a theorem.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// `proved`, `held` or `disproved`; `no answer` if a limit was reached.
    pub verdict: String,
    /// The engine, with its version.
    pub version: String,
    /// Sizes and ranges of the values that it spoke of.
    pub scope: String,
    /// Cases tried, where they can be counted.
    pub cases: Option<u64>,
    /// How many of the covers were reached, of how many.
    pub covers: [usize; 2],
    /// Time taken.
    pub seconds: f64,
    /// Hash of what the theorem rested on.
    pub shown_for: String,
}

impl Shown {
    /// Whether the theorem holds by it.
    #[must_use]
    pub fn holds(&self) -> bool {
        ["proved", "held"].contains(&&*self.verdict)
    }
}

/// What `verdicts.toml` may say of an engine that has not shown anything.
#[derive(Deserialize)]
#[serde(untagged)]
enum Entry {
    Shown(Shown),
    #[allow(dead_code, reason = "read, and of no use: what is left out says the same")]
    Not(String),
}

/// How evidence stands to the code as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Shown for what the theorem rests on now.
    Current,
    /// Shown for something else.
    Stale,
    /// Not shown.
    Missing,
    /// The engine cannot judge the theorem, which says why.
    NotForKani,
}

/// The sources of a workspace, and what was shown of them.
pub struct Evidence {
    root: PathBuf,
    sources: Sources,
    shown: BTreeMap<String, BTreeMap<String, Shown>>,
    kani_scopes: BTreeMap<String, String>,
}

impl Evidence {
    /// Reads that of the workspace with this root.
    ///
    /// # Errors
    /// If its sources or its lists cannot be read.
    pub fn read(root: &Path) -> io::Result<Self> {
        let text = fs::read_to_string(root.join("proofs/verdicts.toml"))?;
        let entries: BTreeMap<String, BTreeMap<String, Entry>> =
            toml::from_str(&text).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
        let shown = entries.into_iter().map(|(theorem, engines)| {
            let shown = engines.into_iter().filter_map(|(engine, entry)| match entry {
                Entry::Shown(shown) => Some((engine, shown)),
                Entry::Not(_) => None,
            });
            (theorem, shown.collect())
        });
        let scopes = fs::read_to_string(root.join("proofs/kani_scopes.txt"))?;
        let scopes = scopes.lines().filter_map(|line| line.split_once(": "));
        Ok(Self {
            root: root.to_owned(),
            sources: Sources::read(root)?,
            shown: shown.collect(),
            kani_scopes: scopes.map(|(name, scope)| (name.to_owned(), scope.to_owned())).collect(),
        })
    }

    /// Nothing shown, of no sources.
    #[must_use]
    pub fn none() -> Self {
        Self {
            root: PathBuf::new(),
            sources: Sources::none(),
            shown: BTreeMap::new(),
            kani_scopes: BTreeMap::new(),
        }
    }

    /// The workspace that holds the current folder, or else the one that this was built from.
    #[must_use]
    pub fn workspace() -> PathBuf {
        let here = std::env::current_dir().unwrap_or_default();
        let root = here.ancestors().find(|folder| folder.join("proofs/verdicts.toml").is_file());
        root.unwrap_or_else(|| Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))).to_owned()
    }

    /// The root of the workspace.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What Kani draws of the theorem.
    #[must_use]
    pub fn kani_scope(&self, theorem: &Theorem) -> &str {
        let name = format!("{}::{}", theorem.unit(), theorem.name);
        self.kani_scopes.get(&name).map_or("not listed yet", String::as_str)
    }

    /// What the engine has shown of the theorem, stale or not.
    #[must_use]
    pub fn of(&self, theorem: &Theorem, engine: &str) -> Option<&Shown> {
        self.shown.get(theorem.name)?.get(engine)
    }

    /// Whether that is current.
    #[must_use]
    pub fn state(&self, theorem: &Theorem, engine: &str) -> State {
        match self.of(theorem, engine) {
            _ if engine == "kani" && theorem.not_for_kani.is_some() => State::NotForKani,
            None => State::Missing,
            Some(shown) if shown.shown_for == self.rests_on(theorem, engine) => State::Current,
            Some(_) => State::Stale,
        }
    }

    /// Hash of what the theorem rests on, judged by this engine.
    #[must_use]
    pub fn rests_on(&self, theorem: &Theorem, engine: &str) -> String {
        let mut hash = Hash::default();
        for (name, text) in self.sources.below(theorem.file, theorem.name, engine) {
            hash.add(&name);
            hash.add(&text.to_string());
        }
        format!("{:016x}", hash.0)
    }

    /// The texts that the theorem rests on, with its own: the path of a file from the root on, and where one of its
    /// items is meant, `#` and its name.
    #[must_use]
    pub fn texts(&self, theorem: &Theorem) -> BTreeSet<String> {
        self.sources.below(theorem.file, theorem.name, "").into_keys().collect()
    }

    /// The files of these texts.
    #[must_use]
    pub fn files(&self, theorem: &Theorem) -> BTreeSet<String> {
        let texts = self.texts(theorem);
        texts.iter().map(|text| text.split('#').next().unwrap_or_default().to_owned()).collect()
    }

    /// Keeps what an engine has shown of a theorem.
    pub fn keep(&mut self, theorem: &Theorem, engine: &str, shown: Shown) {
        self.shown.entry(theorem.name.to_owned()).or_default().insert(engine.to_owned(), shown);
    }

    /// Writes what was shown of the theorems that there are, by way of a second file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self) -> io::Result<()> {
        let path = self.root.join("proofs/verdicts.toml");
        let new = path.with_extension("toml.new");
        fs::write(&new, self.text())?;
        fs::rename(new, path)
    }

    fn text(&self) -> String {
        let mut text = "# What each engine has shown of each theorem, and for which text of model and theorem: a hash of all \
             that it rests on.\n# Written by `saarcor prove --record`, never by hand.\n"
            .to_owned();
        for theorem in crate::theorems() {
            let _ = write!(text, "\n[{}]\n", theorem.name);
            for engine in ENGINES {
                let _ = match (self.of(theorem, engine), theorem.not_for_kani) {
                    (_, Some(_)) if engine == "kani" => writeln!(text, "{engine} = \"not for Kani\""),
                    (None, _) => writeln!(text, "{engine} = \"not run\""),
                    (Some(shown), _) => {
                        let Shown { verdict, version, scope, cases, covers, seconds, shown_for } = shown;
                        let cases = cases.map_or_else(String::new, |cases| format!("cases = {cases}, "));
                        writeln!(
                            text,
                            "{engine} = {{ verdict = \"{verdict}\", version = \"{version}\", seconds = {seconds:.2}, \
                             covers = {covers:?}, {cases}shown_for = \"{shown_for}\", scope = \"{scope}\" }}"
                        )
                    }
                };
            }
        }
        text
    }
}

/// FNV-1a in 64 bits: changes by mistake, not by malice, are what it has to find.
struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    fn add(&mut self, text: &str) {
        for byte in text.bytes().chain([0]) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
