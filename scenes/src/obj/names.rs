//! Names in OBJ and MTL files, as they are written and as they may be meant, and the files of these names.

use std::collections::{BTreeSet, HashMap};
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

/// What a name may mean that nothing has as it is written: without the comment behind it, without
/// quotes around it, and without the backslashes that protect its spaces.
pub(crate) fn meanings(name: &str) -> Vec<String> {
    let mut meanings = vec![name.to_owned()];
    let comment = name.char_indices().find(|&(at, c)| c == '#' && name[..at].ends_with(char::is_whitespace));
    let bare = comment.map_or(name, |(at, _)| &name[..at]).trim();
    let quotes = |quote| bare.strip_prefix(quote).and_then(|rest: &str| rest.strip_suffix(quote));
    let unquoted = quotes('"').or_else(|| quotes('\'')).unwrap_or(bare).trim();
    for meaning in [bare.to_owned(), unquoted.to_owned(), unquoted.replace("\\ ", " ")] {
        if !meanings.contains(&meaning) {
            meanings.push(meaning);
        }
    }
    meanings
}

/// A file that a name means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) path: PathBuf,
    /// Whether the name says just this path.
    pub(crate) exact: bool,
}

/// Finds files by their names, and keeps which it looked for.
#[derive(Debug, Default)]
pub(crate) struct Finder {
    /// What is in the folders that were listed, by the names in small letters; of several the first.
    listings: HashMap<PathBuf, HashMap<String, OsString>>,
    looked_for: BTreeSet<PathBuf>,
}

impl Finder {
    /// The files that were found, and those that were looked for and do not exist.
    pub(crate) fn looked_for(self) -> impl Iterator<Item = PathBuf> {
        self.looked_for.into_iter()
    }

    /// The file that `name` says, relative to `folder` and with either kind of slash. Where there is
    /// none: what the name may mean, in any case of its letters, and at last the file of the same name
    /// in `folder` itself, as paths of other machines are common.
    pub(crate) fn find(&mut self, folder: &Path, name: &str) -> Option<Found> {
        let meanings = meanings(name);
        let slashed = |name: &String| name.replace('\\', "/");
        let exact = folder.join(slashed(&meanings[0]));
        if self.is_file(&exact) {
            return Some(Found { path: exact, exact: true });
        }
        let names: Vec<String> =
            meanings.iter().map(slashed).filter(|name| !name.trim().is_empty()).collect();
        let last = |name: &String| name.rsplit('/').next().unwrap_or_default().to_owned();
        let bases: Vec<String> = names.iter().map(last).filter(|base| !base.is_empty()).collect();
        let path = names
            .iter()
            .chain(&bases)
            .find_map(|name| {
                [Some(folder.join(name)), undecoded(name).map(|name| folder.join(name))]
                    .into_iter()
                    .flatten()
                    .find(|path| self.is_file(path))
            })
            .or_else(|| names.iter().chain(&bases).find_map(|name| self.in_any_case(folder, name)))?;
        Some(Found { path, exact: false })
    }

    /// Whether there is a regular file.
    fn is_file(&mut self, path: &Path) -> bool {
        self.looked_for.insert(path.to_owned());
        path.is_file()
    }

    /// The first regular file, in the order of the names, that differs from `name` in case alone.
    fn in_any_case(&mut self, folder: &Path, name: &str) -> Option<PathBuf> {
        let mut path = match folder {
            _ if folder == Path::new("") => PathBuf::from("."),
            _ => folder.to_owned(),
        };
        for component in Path::new(name).components() {
            match component {
                Component::Normal(part) => {
                    let found = self.listing(&path).get(&part.to_str()?.to_lowercase())?.clone();
                    path.push(found);
                }
                Component::CurDir => {}
                Component::ParentDir => path.push(".."),
                // A path from the root is of this machine, or none.
                Component::RootDir | Component::Prefix(_) => return None,
            }
        }
        self.is_file(&path).then_some(path)
    }

    fn listing(&mut self, folder: &Path) -> &HashMap<String, OsString> {
        self.listings.entry(folder.to_owned()).or_insert_with(|| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let mut names: Vec<_> = entries.map(|entry| entry.file_name()).collect();
            names.sort();
            let in_small = |name: OsString| Some((name.to_str()?.to_lowercase(), name));
            names.into_iter().rev().filter_map(in_small).collect()
        })
    }
}

/// The name's bytes as a file's name: of a name that was taken for Latin-1 and is in another encoding,
/// which the file system may have kept.
#[cfg(unix)]
fn undecoded(name: &str) -> Option<OsString> {
    let bytes: Option<Vec<u8>> = name.chars().map(|c| u8::try_from(u32::from(c)).ok()).collect();
    let bytes = bytes.filter(|bytes| !bytes.is_ascii())?;
    Some(std::os::unix::ffi::OsStringExt::from_vec(bytes))
}

/// File names are no bytes here.
#[cfg(not(unix))]
fn undecoded(_: &str) -> Option<OsString> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_mean_what_stands_in_them() {
        let all = |name| meanings(name).join("|");
        assert_eq!(all("a.mtl"), "a.mtl");
        assert_eq!(all("a.mtl # the library"), "a.mtl # the library|a.mtl");
        assert_eq!(all("\"a b.mtl\""), "\"a b.mtl\"|a b.mtl");
        assert_eq!(all("'a b'"), "'a b'|a b");
        assert_eq!(all("a\\ b.mtl"), "a\\ b.mtl|a b.mtl");
        assert_eq!(all("\"a\\ b\" # c # d"), "\"a\\ b\" # c # d|\"a\\ b\"|a\\ b|a b");
        assert_eq!(all("a#1"), "a#1");
        assert_eq!(all("\""), "\"");
    }
}
