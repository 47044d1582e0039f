//! What each theorem rests on, and what each engine has shown of it.
//!
//! A theorem rests on its own text, on the rest of its file without other theorems, on the files whose
//! items these name by a path, on those that these name, and so on; and where a type counts, so do the
//! files that implement something for it. All of it is hashed without comments, white space and unit
//! tests. The compiler and other people's crates are not a part of it.
//!
//! What was shown stands in `verdicts.toml`, which `saarcor prove --record` writes. What Kani draws of a
//! theorem stands in `kani_scopes.txt`, which a test compares with the code.

use crate::theorem::Theorem;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
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
        let sources = Sources { texts: BTreeMap::new(), below: RefCell::default() };
        Self { root: PathBuf::new(), sources, shown: BTreeMap::new(), kani_scopes: BTreeMap::new() }
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
        for (name, text) in self.sources.below(&Sources::node(theorem), engine) {
            hash.add(&name);
            hash.add(&text.to_string());
        }
        format!("{:016x}", hash.0)
    }

    /// The files that the theorem rests on, from the root on, with its own.
    #[must_use]
    pub fn files(&self, theorem: &Theorem) -> BTreeSet<String> {
        let nodes = self.sources.below(&Sources::node(theorem), "");
        nodes.into_keys().map(|node| node.split('#').next().unwrap_or_default().to_owned()).collect()
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

/// A text that evidence may rest on: a file, without theorems, or one theorem.
struct Text {
    hash: u64,
    /// The texts that it names.
    names: BTreeSet<String>,
}

/// All texts by their names: the path of a file, or that of a theorem's file, `#` and its name. Names that
/// stand without a path are brought into a file by one.
struct Sources {
    texts: BTreeMap<String, Text>,
    /// What each text rests on, once it was asked for.
    below: RefCell<BTreeMap<String, BTreeMap<String, u64>>>,
}

/// The crates that evidence rests on: their names in paths, and their folders.
const CRATES: [(&str, &str); 4] = [
    ("saarcor_model", "model/spec/src"),
    ("saarcor_fast", "model/fast/src"),
    ("saarcor_oracles", "reference/oracles/src"),
    ("saarcor_proofs", "proofs/src"),
];

/// What every theorem rests on, and what it rests on by the engine. What these name counts for nothing.
const HARNESS: [&str; 2] = ["proofs/src/source.rs", "proofs/src/theorem.rs"];
const OF_KANI: &str = "proofs/src/kani_source.rs";
const OF_OTHERS: &str = "proofs/src/engines.rs";
/// They name all theorems, and decide nothing.
const LISTS: [&str; 2] = ["proofs/src/lib.rs", "proofs/src/stub.rs"];

impl Sources {
    fn node(theorem: &Theorem) -> String {
        format!("{}#{}", theorem.file, theorem.name)
    }

    fn read(root: &Path) -> io::Result<Self> {
        let mut files = BTreeMap::new();
        for (_, folder) in CRATES {
            read_below(root, &root.join(folder), &mut files)?;
        }
        let tokens: BTreeMap<&str, Vec<&str>> =
            files.iter().map(|(path, text)| (path.as_str(), without_tests(tokens(text)))).collect();
        let items = tokens.iter().map(|(path, tokens)| (*path, items(tokens))).collect();
        let modules = Modules { items };
        let mut texts = BTreeMap::new();
        for (path, tokens) in tokens.iter().filter(|(path, _)| !LISTS.contains(path)) {
            let (rest, theorems) = split(tokens);
            let own = [(path.to_string(), rest)].into_iter();
            let theorems = theorems.into_iter().map(|(name, tokens)| (format!("{path}#{name}"), tokens));
            for (node, tokens) in own.chain(theorems) {
                let mut names = BTreeSet::new();
                if !HARNESS.contains(path) && ![OF_KANI, OF_OTHERS].contains(path) {
                    modules.named(path, &tokens, &mut names);
                    // A theorem rests on the rest of its file.
                    names.insert((*path).to_owned());
                }
                let mut hash = Hash::default();
                tokens.iter().for_each(|token| hash.add(token));
                texts.insert(node, Text { hash: hash.0, names });
            }
        }
        // What is implemented for a type in another file is a part of the type.
        for (path, tokens) in &tokens {
            for name in implemented(tokens) {
                for home in modules.homes(crate_of(path), name) {
                    if let Some(text) = texts.get_mut(home) {
                        text.names.insert((*path).to_owned());
                    }
                }
            }
        }
        Ok(Self { texts, below: RefCell::default() })
    }

    /// A text, all that it rests on, and their hashes.
    fn below(&self, node: &str, engine: &str) -> BTreeMap<String, u64> {
        let mut found = self.below.borrow().get(node).cloned().unwrap_or_default();
        if found.is_empty() {
            // A theorem that a macro of its own declares is a part of its file.
            let file = node.split('#').next().unwrap_or_default();
            let own = if self.texts.contains_key(node) { node } else { file };
            let mut open: Vec<&str> = HARNESS.into_iter().chain([own]).collect();
            while let Some(node) = open.pop() {
                if let Some(text) = self.texts.get(node)
                    && found.insert(node.to_owned(), text.hash).is_none()
                {
                    open.extend(text.names.iter().map(String::as_str));
                }
            }
            self.below.borrow_mut().insert(node.to_owned(), found.clone());
        }
        let of_engine = if engine == "kani" { OF_KANI } else { OF_OTHERS };
        found.extend(self.texts.get(of_engine).map(|text| (of_engine.to_owned(), text.hash)));
        found
    }
}

/// The folder of the crate that a file belongs to.
fn crate_of(path: &str) -> &'static str {
    CRATES.iter().map(|(_, folder)| *folder).find(|folder| path.starts_with(folder)).unwrap_or_default()
}

/// The files as modules, and the items that each declares.
struct Modules<'a> {
    items: BTreeMap<&'a str, Vec<&'a str>>,
}

impl<'a> Modules<'a> {
    /// The file of a module.
    fn file(&self, folder: &str, module: &[&str]) -> Option<&'a str> {
        let place = [&[folder], module].concat().join("/");
        let names = [format!("{place}.rs"), format!("{place}/mod.rs"), format!("{place}/lib.rs")];
        names.iter().find_map(|name| self.items.get_key_value(&**name)).map(|(path, _)| *path)
    }

    /// The files below a folder, itself included, that declare an item.
    fn homes(&self, folder: &str, name: &str) -> Vec<&'a str> {
        let declares = |(path, items): (&&'a str, &Vec<&str>)| {
            (path.starts_with(folder) && items.contains(&name)).then_some(*path)
        };
        self.items.iter().filter_map(declares).collect()
    }

    /// The files that a text of the file `path` names: by `crate::`, `super::`, another crate, or a module of
    /// its own.
    fn named(&self, path: &str, tokens: &[&str], names: &mut BTreeSet<String>) {
        let folder = crate_of(path);
        let own = path[folder.len()..].trim_end_matches(".rs");
        let own = own.strip_suffix("/mod").or(own.strip_suffix("/lib")).unwrap_or(own);
        let own: Vec<_> = own.split('/').filter(|part| !part.is_empty()).collect();
        for (at, &token) in tokens.iter().enumerate() {
            let inside = at > 1 && tokens[at - 1] == ":" && tokens[at - 2] == ":";
            if inside || !tokens[at + 1..].starts_with(&[":", ":"]) {
                continue;
            }
            let other = CRATES.iter().find(|(name, _)| *name == token);
            let start = match (token, other) {
                (_, Some((_, folder))) => (*folder, vec![]),
                ("crate", _) => (folder, vec![]),
                ("super", _) => (folder, own[..own.len().saturating_sub(1)].to_vec()),
                ("self", _) => (folder, own.clone()),
                _ if self.file(folder, &[&own[..], &[token]].concat()).is_some() => {
                    (folder, [&own[..], &[token]].concat())
                }
                _ => continue,
            };
            self.path(start.0, start.1, &tokens[at + 1..], names);
        }
    }

    /// Follows a path from a module on.
    fn path<'b>(
        &self,
        folder: &str,
        mut module: Vec<&'b str>,
        mut rest: &[&'b str],
        names: &mut BTreeSet<String>,
    ) {
        while rest.starts_with(&[":", ":"]) {
            let next = rest.get(2).copied().unwrap_or_default();
            if next == "{" {
                let inside = &rest[3..behind(rest, 2) - 1];
                let mut at = 0;
                while at < inside.len() {
                    if is_word(inside[at]) {
                        // The first part of each path in the braces, as if it came without them.
                        let one = [&[":", ":"], &inside[at..]].concat();
                        self.path(folder, module.clone(), &one, names);
                    }
                    // On to the next path.
                    while at < inside.len() && inside[at] != "," {
                        at = if inside[at] == "{" { behind(inside, at) } else { at + 1 };
                    }
                    at += 1;
                }
                return;
            }
            if next == "super" {
                module.pop();
            } else if next != "self" && self.file(folder, &[&module[..], &[next]].concat()).is_some() {
                module.push(next);
            } else if next != "self" && is_word(next) {
                return self.item(folder, &module, next, names);
            }
            rest = &rest[3..];
        }
        names.extend(self.file(folder, &module).map(str::to_owned));
    }

    /// The files that declare an item of a module: its own, or those that it takes items from.
    fn item(&self, folder: &str, module: &[&str], name: &str, names: &mut BTreeSet<String>) {
        let file = self.file(folder, module);
        let is_folder = file.is_none_or(|file| file.ends_with("/mod.rs") || file.ends_with("/lib.rs"));
        let own = file.filter(|file| self.items[*file].contains(&name));
        let below = [&[folder], module].concat().join("/") + "/";
        let homes = if own.is_none() && is_folder { self.homes(&below, name) } else { vec![] };
        names.extend(file.filter(|_| !is_folder || own.is_some()).map(str::to_owned));
        names.extend(homes.into_iter().map(str::to_owned));
    }
}

fn read_below(root: &Path, folder: &Path, files: &mut BTreeMap<String, String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            read_below(root, &path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            files.insert(name, fs::read_to_string(&path)?);
        }
    }
    Ok(())
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The tokens of a Rust file, without comments: words, numbers, literals whole, other characters one by one.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let len = if first.is_whitespace() {
            first.len_utf8()
        } else if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else {
            let len = token(rest, first);
            tokens.push(&rest[..len]);
            len
        };
        rest = &rest[len..];
    }
    tokens
}

/// Length of a comment, with those in it.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text.as_bytes()[at..];
        if rest.starts_with(b"/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if rest.starts_with(b"*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                break;
            }
        } else {
            at += 1;
        }
    }
    at
}

/// Length of the token that a text begins with.
fn token(text: &str, first: char) -> usize {
    let word = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let after = &text[word..];
    if ["r", "br"].contains(&&text[..word]) && after.trim_start_matches('#').starts_with('"') {
        let hashes = after.len() - after.trim_start_matches('#').len();
        let end = format!("\"{}", "#".repeat(hashes));
        let inside = word + hashes + 1;
        return text[inside..].find(&end).map_or(text.len(), |at| inside + at + end.len());
    }
    if first == '"' || (["b", "c"].contains(&&text[..word]) && after.starts_with('"')) {
        return quoted(text, word + 1, '"');
    }
    if word > 0 {
        return word;
    }
    if first == '\'' {
        let mut next = text[1..].chars();
        let (one, two) = (next.next(), next.next());
        // A character, or else the mark of a lifetime.
        if one == Some('\\') || two == Some('\'') {
            return quoted(text, 1, '\'');
        }
    }
    first.len_utf8()
}

/// Length of a literal whose inside begins at `from`.
fn quoted(text: &str, from: usize, end: char) -> usize {
    let mut escaped = false;
    for (at, c) in text[from..].char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == end => return from + at + c.len_utf8(),
            _ => {}
        }
    }
    text.len()
}

/// The place behind the group that opens at `at`.
fn behind(tokens: &[&str], at: usize) -> usize {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(at) {
        match *token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => continue,
        }
        if depth == 0 {
            return place + 1;
        }
    }
    tokens.len()
}

fn without_tests(tokens: Vec<&str>) -> Vec<&str> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::with_capacity(tokens.len());
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at..].starts_with(&MARK) {
            let body = tokens[at + MARK.len()..].iter().position(|token| ["{", ";"].contains(token));
            let Some(body) = body.map(|place| at + MARK.len() + place) else { break };
            at = if tokens[body] == "{" { behind(&tokens, body) } else { body + 1 };
        } else {
            kept.push(tokens[at]);
            at += 1;
        }
    }
    kept
}

/// Names of what a file declares outside of any body.
fn items<'a>(tokens: &[&'a str]) -> Vec<&'a str> {
    const KINDS: [&str; 8] = ["struct", "enum", "trait", "type", "const", "static", "fn", "union"];
    let (mut names, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        if tokens[at] == "{" {
            at = behind(tokens, at);
            continue;
        }
        let next = tokens.get(at + 1).copied().unwrap_or_default();
        if KINDS.contains(&tokens[at]) && is_word(next) && !KINDS.contains(&next) && next != "_" {
            names.push(next);
        }
        if tokens[at] == "macro_rules" {
            names.extend(tokens.get(at + 2).copied());
        }
        at += 1;
    }
    names
}

/// The types for which a file implements something.
fn implemented<'a>(tokens: &[&'a str]) -> Vec<&'a str> {
    let mut names = Vec::new();
    // Not those of arguments and results.
    let begins = |at: usize| at == 0 || ["}", ";", "]", "{", "unsafe"].contains(&tokens[at - 1]);
    for at in (0..tokens.len()).filter(|&at| tokens[at] == "impl" && begins(at)) {
        // The last word of the header's last path, before its generics, is the name.
        let (mut name, mut depth) = ("", 0_i32);
        for (place, &token) in tokens.iter().enumerate().skip(at + 1) {
            match token {
                "<" => depth += 1,
                ">" if tokens[place - 1] != "-" => depth -= 1,
                "{" | "where" | ";" if depth == 0 => break,
                _ if depth == 0 && is_word(token) => name = token,
                _ => {}
            }
        }
        names.push(name);
    }
    names
}

/// A file without its theorems, and each theorem by its name, from its attribute on.
fn split<'a>(tokens: &[&'a str]) -> (Vec<&'a str>, Vec<(&'a str, Vec<&'a str>)>) {
    let (mut rest, mut theorems) = (Vec::new(), Vec::new());
    let mut at = 0;
    while at < tokens.len() {
        let is_attribute = tokens[at..].starts_with(&["#", "["])
            && tokens.get(at + 2).is_some_and(|token| token.starts_with('"'));
        let end = if is_attribute { behind(tokens, at + 1) } else { 0 };
        if is_attribute && tokens.get(end) == Some(&"fn") {
            let body = behind(tokens, end + 2);
            let next = behind(tokens, body);
            theorems.push((tokens[end + 1], tokens[at..next].to_vec()));
            at = next;
        } else {
            rest.push(tokens[at]);
            at += 1;
        }
    }
    (rest, theorems)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_white_space_are_no_tokens() {
        let text = "fn f<'a>() { /* a /* b */ c */ g('\\'', \"// \\\" \", r#\"\"x\"\"#) } // end\n";
        assert_eq!(
            tokens(text),
            [
                "fn",
                "f",
                "<",
                "'",
                "a",
                ">",
                "(",
                ")",
                "{",
                "g",
                "(",
                "'\\''",
                ",",
                "\"// \\\" \"",
                ",",
                "r#\"\"x\"\"#",
                ")",
                "}"
            ]
        );
    }

    #[test]
    fn theorems_are_texts_of_their_own() {
        let text = "use a; #[\"VM-1\", unwind 8, covers [\"x\"]] fn one(s) { b } #[must_use] fn two() {}";
        let (rest, theorems) = (split(&tokens(text)).0, split(&tokens(text)).1);
        assert_eq!(rest.join(" "), "use a ; # [ must_use ] fn two ( ) { }");
        assert_eq!((theorems.len(), theorems[0].0), (1, "one"));
    }

    #[test]
    fn what_is_implemented_belongs_to_the_type() {
        let text =
            "impl<const N: usize> Set<N> { } impl<T: Into<u8>> fmt::Display for units::Way<T> where T: A { }";
        assert_eq!(implemented(&tokens(text)), ["Set", "Way"]);
    }
}
