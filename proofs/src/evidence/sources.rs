//! What texts there are, and which of them each rests on.
//!
//! A text is an item of a file, or what is implemented for a type, or what of a file has no name. It rests on the items that
//! its words name, by the rules of Rust: those of its file, those that `use` brings there, and those behind a path. Where
//! these rules are not followed to the end, it rests on whole files.
//!
//! What is implemented for a type counts where the type counts; if it is implemented of a trait of these crates, only where
//! the trait counts too, which is where a file takes it by `use`, declares it or names it.

use super::Hash;
use super::rust::{self, Kind, is_word};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::{fs, io};

/// The crates that evidence rests on: their names in paths, and their folders.
const CRATES: [(&str, &str); 4] = [
    ("saarcor_model", "model/spec/src"),
    ("saarcor_fast", "model/fast/src"),
    ("saarcor_oracles", "reference/oracles/src"),
    ("saarcor_proofs", "proofs/src"),
];

/// What every theorem rests on, and what it rests on by the engine: whole files, and what these name counts for nothing.
const HARNESS: [&str; 2] = ["proofs/src/source.rs", "proofs/src/theorem.rs"];
const OF_KANI: &str = "proofs/src/kani_source.rs";
const OF_OTHERS: &str = "proofs/src/engines.rs";
/// They name all theorems, and decide nothing.
const LISTS: [&str; 2] = ["proofs/src/lib.rs", "proofs/src/stub.rs"];

/// Whether the file is one text as a whole.
fn is_whole(path: &str) -> bool {
    HARNESS.contains(&path) || [OF_KANI, OF_OTHERS].contains(&path)
}

/// A text that evidence may rest on.
struct Text {
    hash: u64,
    /// The texts that it names.
    names: BTreeSet<String>,
}

/// What is implemented for a type. It counts where one of each list counts.
struct Implementation {
    text: String,
    conditions: Vec<BTreeSet<String>>,
}

/// All texts by their names: the path of a file, and for what has a name of its own, `#` and the name.
pub(super) struct Sources {
    texts: BTreeMap<String, Text>,
    implementations: Vec<Implementation>,
    /// What each text rests on, once it was asked for.
    below: RefCell<BTreeMap<String, BTreeMap<String, u64>>>,
}

impl Sources {
    /// No texts.
    pub fn none() -> Self {
        Self { texts: BTreeMap::new(), implementations: Vec::new(), below: RefCell::default() }
    }

    /// Those of the workspace with this root.
    pub fn read(root: &Path) -> io::Result<Self> {
        let mut files = BTreeMap::new();
        for (_, folder) in CRATES {
            read_below(root, &root.join(folder), &mut files)?;
        }
        Ok(Self::of(&files))
    }

    /// Those of these files.
    fn of(files: &BTreeMap<String, String>) -> Self {
        let tokens: BTreeMap<&str, _> = files
            .iter()
            .map(|(path, text)| (path.as_str(), rust::split(&rust::without_tests(rust::tokens(text)))))
            .collect();
        let mut crates = Crates { files: BTreeMap::new() };
        for (path, (rest, _)) in &tokens {
            crates.files.insert(path, File::read(path, rest));
        }
        // Where names lead has to be known of all files before any is followed.
        for path in tokens.keys() {
            let found = crates.used(path);
            if let Some(file) = crates.files.get_mut(path) {
                (file.names, file.globs) = found;
            }
        }
        let mut sources = Self::none();
        for (path, (_, theorems)) in tokens.iter().filter(|(path, _)| !LISTS.contains(path)) {
            let theorems = theorems.iter().map(|(name, tokens)| (format!("{path}#{name}"), tokens));
            for (node, tokens) in theorems {
                sources.add(&crates, path, &node, tokens);
            }
            let file = &crates.files[path];
            for (node, tokens) in &file.texts {
                sources.add(&crates, path, node, tokens);
            }
            for (node, of, of_trait) in &file.implemented {
                let found = |words: &[&str]| crates.path_in(path, words).unwrap_or_default();
                let conditions = [found(of), of_trait.as_ref().map(|words| found(words)).unwrap_or_default()];
                let conditions: Vec<_> = conditions.into_iter().filter(|found| !found.is_empty()).collect();
                if conditions.is_empty() {
                    // For a type of others, of a trait of others: a part of its file.
                    if let Some(text) = sources.texts.get_mut(*path) {
                        text.names.insert(node.clone());
                    }
                } else {
                    sources.implementations.push(Implementation { text: node.clone(), conditions });
                }
            }
        }
        sources
    }

    fn add(&mut self, crates: &Crates, path: &str, node: &str, tokens: &[&str]) {
        let mut hash = Hash::default();
        tokens.iter().for_each(|token| hash.add(token));
        let mut names = BTreeSet::new();
        let mut add = |texts: BTreeSet<String>| {
            // Two names exchanged by `use` are the same words, and lead to the same texts in all: what each of them
            // leads to counts.
            texts.iter().for_each(|text| hash.add(text));
            hash.add("");
            names.extend(texts);
        };
        if !is_whole(path) {
            crates.named(path, tokens, &mut add);
            if node == path {
                add(crates.traits_in(path));
            }
            // What of its file has no name.
            add(BTreeSet::from([path.to_owned()]));
        }
        self.texts.insert(node.to_owned(), Text { hash: hash.0, names });
    }

    /// A theorem's text, all that it rests on, and their hashes.
    pub fn below(&self, file: &str, theorem: &str, engine: &str) -> BTreeMap<String, u64> {
        let node = format!("{file}#{theorem}");
        let mut found = self.below.borrow().get(&node).cloned().unwrap_or_default();
        if found.is_empty() {
            // A theorem that a macro of its own declares may be anywhere in its file.
            let of_file = |text: &&str| text.split('#').next() == Some(file);
            let own: Vec<&str> = match self.texts.get_key_value(&node) {
                Some((own, _)) => vec![own],
                None => self.texts.keys().map(String::as_str).filter(of_file).collect(),
            };
            let mut open: Vec<&str> = HARNESS.into_iter().chain(own).collect();
            while !open.is_empty() {
                while let Some(node) = open.pop() {
                    if let Some(text) = self.texts.get(node)
                        && found.insert(node.to_owned(), text.hash).is_none()
                    {
                        open.extend(text.names.iter().map(String::as_str));
                    }
                }
                let counts = |implementation: &&Implementation| {
                    !found.contains_key(&implementation.text)
                        && implementation
                            .conditions
                            .iter()
                            .all(|one| one.iter().any(|text| found.contains_key(text)))
                };
                open.extend(self.implementations.iter().filter(counts).map(|one| one.text.as_str()));
            }
            self.below.borrow_mut().insert(node, found.clone());
        }
        // Of the engines' own files each judges by one alone, whoever names the other.
        let [of_engine, of_another] =
            if engine == "kani" { [OF_KANI, OF_OTHERS] } else { [OF_OTHERS, OF_KANI] };
        found.remove(of_another);
        found.extend(self.texts.get(of_engine).map(|text| (of_engine.to_owned(), text.hash)));
        found
    }
}

/// The folder of the crate that a file belongs to.
fn crate_of(path: &str) -> &'static str {
    CRATES.iter().map(|(_, folder)| *folder).find(|folder| path.starts_with(folder)).unwrap_or_default()
}

/// A place in a crate: its folder, and the names from there on.
type Place<'a> = (&'static str, Vec<&'a str>);

/// Names that `use` brings, and where each leads; and the modules of which it brings all names.
type Brought<'a> = (BTreeMap<&'a str, Vec<Place<'a>>>, Vec<Place<'a>>);

/// What a file implements: the text, and the paths of the type and of the trait.
type Implemented<'a> = (String, Vec<&'a str>, Option<Vec<&'a str>>);

/// A file, as the module that it is.
#[derive(Default)]
struct File<'a> {
    /// Its texts by their names, with the file's own, which holds what has none.
    texts: BTreeMap<String, Vec<&'a str>>,
    /// Items that it declares, and which of them are traits.
    items: BTreeMap<&'a str, bool>,
    /// What it implements.
    implemented: BTreeSet<Implemented<'a>>,
    used: Vec<rust::Used<'a>>,
    names: BTreeMap<&'a str, Vec<Place<'a>>>,
    globs: Vec<Place<'a>>,
}

impl<'a> File<'a> {
    fn read(path: &str, tokens: &[&'a str]) -> Self {
        let mut file = Self::default();
        file.texts.insert(path.to_owned(), Vec::new());
        for (kind, tokens) in rust::parts(tokens) {
            let mut name = path.to_owned();
            match &kind {
                Kind::Item(item) => {
                    file.items.insert(item, false);
                    name = format!("{path}#{item}");
                }
                Kind::Trait(item) => {
                    file.items.insert(item, true);
                    name = format!("{path}#{item}");
                }
                Kind::Impl { of, of_trait } => {
                    let of_trait_text =
                        of_trait.as_ref().map_or(String::new(), |path| path.join("::") + " for ");
                    name = format!("{path}#impl {of_trait_text}{}", of.join("::"));
                    file.implemented.insert((name.clone(), of.clone(), of_trait.clone()));
                }
                Kind::Use => {
                    let names = rust::used(tokens);
                    file.used.extend(names.iter().cloned());
                    // Where a name of these crates leads counts in each text that has the name.
                    let is_own = |path: &[&str]| {
                        let first = path.first().copied().unwrap_or_default();
                        ["crate", "super", "self"].contains(&first)
                            || CRATES.iter().any(|(name, _)| *name == first)
                    };
                    if names.iter().all(|(_, path)| is_own(path)) {
                        continue;
                    }
                }
                Kind::Module => continue,
                Kind::Other => {}
            }
            // An item that is declared for Kani and for others is one text, and so is all of a file that is one.
            let name = if is_whole(path) { path.to_owned() } else { name };
            file.texts.entry(name).or_default().extend(tokens);
        }
        if is_whole(path) {
            file.implemented.clear();
        }
        file
    }
}

/// The files of all crates.
struct Crates<'a> {
    files: BTreeMap<&'a str, File<'a>>,
}

impl<'a> Crates<'a> {
    /// The file of a module.
    fn file(&self, (folder, module): (&str, &[&str])) -> Option<&'a str> {
        let place = [&[folder], module].concat().join("/");
        let names = [format!("{place}.rs"), format!("{place}/mod.rs"), format!("{place}/lib.rs")];
        names.iter().find_map(|name| self.files.get_key_value(&**name)).map(|(path, _)| *path)
    }

    /// Where a path begins that stands in a file: none if in another crate, or in an item.
    fn place<'b>(&self, path: &str, words: &[&'b str]) -> Option<Place<'b>>
    where
        'a: 'b,
    {
        let (first, rest) = words.split_first()?;
        let folder = crate_of(path);
        let own = || self.module_of(path);
        let start = match *first {
            "crate" => (folder, Vec::new()),
            "self" => (folder, own()),
            "super" => {
                let mut module = own();
                module.pop();
                (folder, module)
            }
            name => match CRATES.iter().find(|(known, _)| *known == name) {
                Some((_, folder)) => (*folder, Vec::new()),
                None => {
                    let child = [own(), vec![name]].concat();
                    self.file((folder, &child))?;
                    (folder, child)
                }
            },
        };
        let mut module = start.1;
        for word in rest {
            match *word {
                "super" => drop(module.pop()),
                "self" => {}
                word => module.push(word),
            }
        }
        Some((start.0, module))
    }

    /// The module that a file is.
    fn module_of(&self, path: &str) -> Vec<&'a str> {
        let Some((path, _)) = self.files.get_key_value(path) else { return Vec::new() };
        let own = path[crate_of(path).len()..].trim_end_matches(".rs");
        let own = own.strip_suffix("/mod").or(own.strip_suffix("/lib")).unwrap_or(own);
        own.split('/').filter(|part| !part.is_empty()).collect()
    }

    /// What `use` brings into a file.
    fn used(&self, path: &str) -> Brought<'a> {
        let (mut names, mut globs) = (BTreeMap::<_, Vec<_>>::new(), Vec::new());
        for (name, words) in &self.files[path].used {
            match self.place(path, words) {
                Some(place) if *name == "*" => globs.push(place),
                Some(place) => names.entry(*name).or_default().push(place),
                None => {}
            }
        }
        (names, globs)
    }

    /// All texts of a file.
    fn whole(&self, path: &str) -> BTreeSet<String> {
        self.files[path].texts.keys().cloned().collect()
    }

    /// The texts at a place: an item's, or none for a module. None if there is nothing of that name.
    fn at(&self, (folder, words): (&str, &[&str]), depth: usize) -> Option<BTreeSet<String>> {
        let mut module: Vec<&str> = Vec::new();
        for (at, word) in words.iter().enumerate() {
            let next = [&module[..], &[word]].concat();
            if self.file((folder, &next)).is_none() {
                return self.item((folder, &module), word, depth);
            }
            // An item may have a module's name.
            if at + 1 == words.len() {
                return Some(self.item((folder, &module), word, depth).unwrap_or_default());
            }
            module = next;
        }
        Some(BTreeSet::new())
    }

    /// The texts of an item of a module: its own, or those that it takes from elsewhere.
    fn item(&self, module: (&str, &[&str]), name: &str, depth: usize) -> Option<BTreeSet<String>> {
        let path = self.file(module)?;
        let file = &self.files[path];
        if file.items.contains_key(name) {
            let text = if is_whole(path) { path.to_owned() } else { format!("{path}#{name}") };
            return Some(BTreeSet::from([text]));
        }
        if depth == 0 {
            return None;
        }
        if let Some(places) = file.names.get(name) {
            return Some(places.iter().flat_map(|place| self.follow(place, depth - 1)).collect());
        }
        let globs =
            file.globs.iter().filter_map(|(folder, words)| self.item((folder, words), name, depth - 1));
        if let Some(found) = globs.reduce(|a, b| a.union(&b).cloned().collect()) {
            return Some(found);
        }
        // A macro of the crate, which is known by no path.
        let is_root = module.1.is_empty();
        let homes = self.files.iter().filter(|(path, file)| {
            is_root && path.starts_with(module.0) && file.items.contains_key(name) && !LISTS.contains(path)
        });
        let homes: BTreeSet<_> = homes.flat_map(|(path, _)| self.own(path, name)).collect();
        (!homes.is_empty()).then_some(homes)
    }

    /// The texts at a place that a path leads to. Where nothing of that name is found, as what a macro declares, it is
    /// anywhere in the last module of the path.
    fn follow(&self, (folder, words): &Place, depth: usize) -> BTreeSet<String> {
        self.at((folder, words), depth).unwrap_or_else(|| {
            let last = (0..words.len()).rev().find_map(|end| self.file((folder, &words[..end])));
            last.map(|path| self.whole(path)).unwrap_or_default()
        })
    }

    /// The text of an item that a file declares.
    fn own(&self, path: &str, name: &str) -> Option<String> {
        let is_declared = self.files[path].items.contains_key(name);
        let text = if is_whole(path) { path.to_owned() } else { format!("{path}#{name}") };
        is_declared.then_some(text)
    }

    /// The texts that a path names which stands in a file. None if it leads out of these crates.
    fn path_in(&self, path: &str, words: &[&str]) -> Option<BTreeSet<String>> {
        const DEPTH: usize = 8;
        let first = words.first()?;
        let file = &self.files[path];
        if let Some(own) = self.own(path, first) {
            return Some(BTreeSet::from([own]));
        }
        if let Some(places) = file.names.get(first) {
            let longer =
                |(folder, brought): &Place| self.follow(&(*folder, [brought, &words[1..]].concat()), DEPTH);
            return Some(places.iter().flat_map(longer).collect());
        }
        if words.len() > 1
            && let Some(place) = self.place(path, words)
        {
            return Some(self.follow(&place, DEPTH));
        }
        let globs = file.globs.iter().filter_map(|(folder, words)| self.item((folder, words), first, DEPTH));
        globs.reduce(|a, b| a.union(&b).cloned().collect())
    }

    /// The traits that a file declares, or takes by `use`.
    fn traits_in(&self, path: &str) -> BTreeSet<String> {
        let file = &self.files[path];
        let own =
            file.items.iter().filter(|(_, is_trait)| **is_trait).filter_map(|(name, _)| self.own(path, name));
        let brought = file.names.keys().filter_map(|name| self.path_in(path, &[name])).flatten();
        let is_trait = |text: &String| {
            let (path, name) = text.split_once('#').unwrap_or((text, ""));
            self.files.get(path).and_then(|file| file.items.get(name)).is_some_and(|is_trait| *is_trait)
        };
        // Of all names of a module, its traits.
        let of_globs = file.globs.iter().filter_map(|(folder, words)| self.file((folder, words)));
        let of_globs = of_globs.flat_map(|path| self.whole(path));
        own.chain(brought.chain(of_globs).filter(is_trait)).collect()
    }

    /// The texts that each path of a text names, which stands in a file, one path after another.
    fn named(&self, path: &str, tokens: &[&str], mut add: impl FnMut(BTreeSet<String>)) {
        let mut at = 0;
        while at < tokens.len() {
            let before = |by: usize| at.checked_sub(by).map_or("", |at| tokens[at]);
            if tokens[at] == "use" {
                let end =
                    tokens[at..].iter().position(|token| *token == ";").map_or(tokens.len(), |end| at + end);
                for (name, words) in rust::used(&tokens[at..end]) {
                    // Names for a part of a file alone are not followed: they stand for the whole files. All names
                    // of the module around it are those of this file.
                    if name == "*" && words == ["super"] {
                        continue;
                    }
                    add(self.path_in(path, &words).unwrap_or_default());
                    if let Some((folder, words)) = self.place(path, &words) {
                        add(self.file((folder, &words)).map(|path| self.whole(path)).unwrap_or_default());
                    }
                }
                at = end;
                continue;
            }
            // A field, a method, a lifetime, or within a path.
            let is_inside = before(1) == "." && before(2) != "."
                || before(1) == "'"
                || before(1) == ":" && before(2) == ":";
            if !is_word(tokens[at]) || is_inside {
                at += 1;
                continue;
            }
            let mut words = vec![tokens[at]];
            let mut end = at + 1;
            while tokens[end..].starts_with(&[":", ":"])
                && tokens.get(end + 2).is_some_and(|word| is_word(word))
            {
                words.push(tokens[end + 2]);
                end += 3;
            }
            add(self.path_in(path, &words).unwrap_or_default());
            at = end;
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two files of the model, and one of theorems.
    const FILES: [(&str, &str); 5] = [
        ("model/spec/src/vm/mod.rs", "mod set; mod units; pub use set::{Set, Step}; pub use units::Way;"),
        ("model/spec/src/vm/units.rs", "number!(Way); pub struct Line(u32);"),
        (
            "model/spec/src/vm/set.rs",
            "use super::units::{Line, Way}; pub trait Step { fn step(&self); }
             pub struct Set { lines: [Line; 2] } impl Set { pub fn next(&self) -> Other { helper() } }
             impl Step for Set { fn step(&self) { of_trait() } } impl fmt::Debug for Set { }
             pub struct Other; impl Other { const ONE: u8 = one(); } fn helper() {} fn of_trait() {} fn one() {} fn unused() {}
             impl Step for Vec<u8> { fn step(&self) { of_vectors() } } fn of_vectors() {} pub fn of_a_way(way: Way) {}",
        ),
        (
            "proofs/src/draw.rs",
            "use saarcor_model::vm::Set; pub fn set() -> Set {} pub fn flag() -> bool {} pub static SMALL: u8 = 1;",
        ),
        (
            "proofs/src/vm/set.rs",
            "use crate::draw::{self, SMALL}; theorems! {
                #[\"VM-1\", unwind 2, covers [\"x\"]] fn of_sets(s) { draw::set().next(); helper(); }
                #[\"VM-1\", unwind 2, covers [\"x\"]] fn of_flags(s) { draw::flag(); SMALL.set }
                #[\"VM-1\", unwind 2, covers [\"x\"]] fn of_steps(s) { use saarcor_model::vm::Step; draw::set().step(); }
                #[\"VM-1\", unwind 2, covers [\"x\"]] fn of_ways(s) { saarcor_model::vm::Way(1); }
             } fn helper() {}",
        ),
    ];

    fn sources(files: &[(&str, &str)]) -> Sources {
        Sources::of(&files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect())
    }

    /// What the theorem rests on, without its own text and the files that have no names.
    fn below(theorem: &str) -> Vec<String> {
        let texts = sources(&FILES).below("proofs/src/vm/set.rs", theorem, "kani");
        let own = format!("proofs/src/vm/set.rs#{theorem}");
        let named = texts.into_keys().filter(|text| text.contains('#') && *text != own);
        let mut named: Vec<_> =
            named.map(|text| text.replace("model/spec/src/vm/", "").replace("proofs/src/", "")).collect();
        named.sort_unstable();
        named
    }

    #[test]
    fn theorem_rests_on_what_it_names_and_on_what_that_names() {
        let expected = [
            "draw.rs#set",
            "set.rs#Other",
            "set.rs#Set",
            "set.rs#helper",
            "set.rs#impl Other",
            "set.rs#impl Set",
            "set.rs#impl fmt::Debug for Set",
            "set.rs#one",
            "units.rs#Line",
            "vm/set.rs#helper",
        ];
        // The trait counts where a type of its file does: who has the type may have the trait.
        let of_the_trait = ["set.rs#Step", "set.rs#impl Step for Set", "set.rs#of_trait"];
        let of_vectors = ["set.rs#impl Step for Vec", "set.rs#of_vectors"];
        let mut all = [&expected[..], &of_the_trait, &of_vectors].concat();
        all.sort_unstable();
        assert_eq!(below("of_sets"), all);
        assert_eq!(
            below("of_steps"),
            all.iter().filter(|text| **text != "vm/set.rs#helper").copied().collect::<Vec<_>>()
        );
    }

    #[test]
    fn theorem_does_not_rest_on_what_else_its_files_have() {
        assert_eq!(below("of_flags"), ["draw.rs#SMALL", "draw.rs#flag"]);
    }

    #[test]
    fn what_is_not_found_is_anywhere_in_its_module() {
        assert_eq!(below("of_ways"), ["units.rs#Line"]);
        let texts = sources(&FILES).below("proofs/src/vm/set.rs", "of_ways", "kani");
        assert!(texts.contains_key("model/spec/src/vm/units.rs"), "where the macro is: {texts:?}");
    }

    #[test]
    fn change_shows_where_it_is_named_alone() {
        let hashes = |from: &str, to: &str| {
            let changed = FILES.map(|(path, text)| (path, text.replace(from, to)));
            let files: Vec<_> = changed.iter().map(|(path, text)| (*path, text.as_str())).collect();
            ["of_sets", "of_flags"]
                .map(|theorem| sources(&files).below("proofs/src/vm/set.rs", theorem, "kani"))
        };
        let before = hashes("", "");
        let differs = |from: &str, to: &str| {
            let after = hashes(from, to);
            [before[0] != after[0], before[1] != after[1]]
        };
        assert_eq!(differs("fn one() {}", "fn one() { 1 }"), [true, false]);
        assert_eq!(differs("SMALL: u8 = 1", "SMALL: u8 = 2"), [false, true]);
        assert_eq!(differs("fn unused() {}", "fn unused() { 1 }"), [false, false]);
        assert_eq!(
            differs("use saarcor_model::vm::Set", "use saarcor_model::vm::Other as Set"),
            [true, false]
        );
        assert_eq!(differs("number!(Way)", "number!(Ways)"), [true, false]);
    }

    #[test]
    fn exchanged_names_show() {
        let with = |used: &str| {
            let theorem = format!(
                "{used} theorems! {{ #[\"VM-1\", unwind 2, covers [\"x\"]] fn of_two(s) {{ one(two()) + Least.of(Most) }} }}"
            );
            let model = "pub fn one() {} pub fn two() {} pub trait Least {} pub trait Most {}";
            let files = [("model/spec/src/two.rs", model), ("proofs/src/two.rs", theorem.as_str())];
            sources(&files).below("proofs/src/two.rs", "of_two", "kani")
        };
        let before = with("use saarcor_model::two::{one, two};");
        assert_eq!(
            before,
            with("use saarcor_model::two::two; use saarcor_model::two::one;"),
            "the order of names"
        );
        assert_ne!(before, with("use saarcor_model::two::{one as two, two as one};"));
        // A method may be that of any trait that the file has.
        assert_ne!(
            with("use saarcor_model::two::{one, two, Least as First, Most};"),
            with("use saarcor_model::two::{one, two, Least, Most as First};")
        );
    }
}
