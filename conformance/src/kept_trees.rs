//! Kd-trees of large scenes, kept from run to run: to build one takes longer than a frame does.
//!
//! A kept tree is the one that this very program would build, bit for bit: its file is named after a
//! checksum of the program, the options and the triangles, and one that is not whole is not taken.
//! Nothing depends on it but time, so what cannot be kept is built again without a word.

use anyhow::{Context, Result};
use saarcor_model::kdtree::{Aabb, Axis, KdTree, Node};
use saarcor_model::scene::Triangle;
use saarcor_scenes::kdbuild::BuildOptions;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Names the folder of kept trees; where it is empty, none are kept.
pub const FOLDER: &str = "SAARCOR_CACHE";

/// Trees over fewer triangles are not worth a file: they are built in a third of a second.
const LEAST_TRIANGLES: usize = 1 << 15;

/// Files that are kept, and bytes of the largest: half a gigabyte in all.
const FILES: usize = 8;
const MOST_BYTES: usize = 64 << 20;

/// A folder of kept trees.
#[derive(Clone, Debug)]
pub struct KeptTrees {
    folder: PathBuf,
}

impl KeptTrees {
    /// Those in `folder`, which is made when there is one to keep.
    #[must_use]
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// The user's: in the folder that [`FOLDER`] names, else in `saarcor` in the folder for what can be
    /// made again (XDG Base Directory Specification). None if the user wants none.
    #[must_use]
    pub fn of_user() -> Option<Self> {
        let folder = std::env::var_os(FOLDER).map(PathBuf::from).or_else(|| {
            let set = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
            let caches = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
            Some(caches.join("saarcor"))
        })?;
        (!folder.as_os_str().is_empty()).then(|| Self::new(folder))
    }

    /// The tree over `triangles`, kept or built.
    #[must_use]
    pub fn tree(
        &self,
        triangles: &[Triangle],
        options: &BuildOptions,
        build: impl FnOnce() -> KdTree,
    ) -> KdTree {
        if triangles.len() < LEAST_TRIANGLES {
            return build();
        }
        let Ok(name) = name(triangles, options) else { return build() };
        let path = self.folder.join(name);
        let kept = fs::read(&path).ok().and_then(|bytes| decode(&bytes, triangles.len()));
        kept.unwrap_or_else(|| {
            let tree = build();
            // It is as good as kept: the next run builds it again.
            let _ = self.keep(&path, &encode(&tree));
            tree
        })
    }

    fn keep(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        if bytes.len() > MOST_BYTES {
            return Ok(());
        }
        fs::create_dir_all(&self.folder)?;
        self.make_room()?;
        let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
        file.write_all(bytes)?;
        file.persist(path)?;
        Ok(())
    }

    /// Removes the oldest files, so that there is room for one more.
    fn make_room(&self) -> Result<()> {
        let mut files: Vec<(SystemTime, PathBuf)> = fs::read_dir(&self.folder)?
            .filter_map(|entry| {
                let entry = entry.ok()?;
                Some((entry.metadata().ok()?.modified().ok()?, entry.path()))
            })
            .filter(|(_, path)| path.extension().is_some_and(|extension| extension == EXTENSION))
            .collect();
        files.sort();
        let spare = (files.len() + 1).saturating_sub(FILES);
        files.iter().take(spare).try_for_each(|(_, path)| fs::remove_file(path))?;
        Ok(())
    }
}

const EXTENSION: &str = "kdtree";

/// The file's name: a checksum of all that a tree depends on.
fn name(triangles: &[Triangle], options: &BuildOptions) -> Result<String> {
    let mut all = Xxh3::new();
    checksum_program(&mut all).context("the program itself")?;
    all.update(format!("{options:?}").as_bytes());
    for corner in triangles.iter().flat_map(|triangle| triangle.corners) {
        all.update(corner.to_array().map(f32::to_le_bytes).as_flattened());
    }
    Ok(format!("{:032x}.{EXTENSION}", all.digest128()))
}

/// Piece by piece, since it is large: to have memory for all of it would take longer than the checksum.
fn checksum_program(sum: &mut Xxh3) -> io::Result<()> {
    let mut program = BufReader::with_capacity(1 << 16, File::open(std::env::current_exe()?)?);
    loop {
        let piece = program.fill_buf()?;
        if piece.is_empty() {
            return Ok(());
        }
        sum.update(piece);
        let read = piece.len();
        program.consume(read);
    }
}

/// Words of a file before the nodes: the box, and the numbers of nodes and references.
const HEADER: usize = 8;
/// The first word of a leaf, in place of an axis.
const LEAF: u32 = 3;

/// A tree as 32-bit words, behind the checksum of them all: the box, the numbers of nodes and
/// references, three words a node, one a reference.
fn encode(tree: &KdTree) -> Vec<u8> {
    let KdTree { bounds, nodes, refs } = tree;
    let mut words = Vec::with_capacity(HEADER + 3 * nodes.len() + refs.len());
    words.extend([bounds.min, bounds.max].iter().flat_map(|corner| corner.to_array().map(f32::to_bits)));
    words.extend([nodes.len() as u32, refs.len() as u32]);
    words.extend(nodes.iter().flat_map(|node| match *node {
        Node::Inner { axis, split, children } => [axis as u32, split.to_bits(), children],
        Node::Leaf { first, count } => [LEAF, first, count],
    }));
    words.extend(refs);
    let words: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
    [&xxh3_128(&words).to_le_bytes()[..], &words].concat()
}

/// The tree over so many triangles; none if the bytes are not what [`encode`] made of one.
fn decode(bytes: &[u8], triangles: usize) -> Option<KdTree> {
    let (checksum, bytes) = bytes.split_first_chunk()?;
    if xxh3_128(bytes) != u128::from_le_bytes(*checksum) {
        return None;
    }
    let (words, []) = bytes.as_chunks() else { return None };
    let (header, words) = words.split_first_chunk::<HEADER>()?;
    let header = header.map(u32::from_le_bytes);
    let corner =
        |first: usize| glam::Vec3::from_array(std::array::from_fn(|k| f32::from_bits(header[first + k])));
    let (nodes, refs) = words.split_at_checked(3 * header[6] as usize)?;
    let node = |words: &[[u8; 4]; 3]| {
        let [kind, a, b] = words.map(u32::from_le_bytes);
        match Axis::ALL.get(kind as usize) {
            Some(&axis) => Node::Inner { axis, split: f32::from_bits(a), children: b },
            None => Node::Leaf { first: a, count: b },
        }
    };
    let tree = KdTree {
        bounds: Aabb { min: corner(0), max: corner(3) },
        nodes: nodes.as_chunks().0.iter().map(node).collect(),
        refs: refs.iter().map(|&word| u32::from_le_bytes(word)).collect(),
    };
    (refs.len() == header[7] as usize && tree.check(triangles).is_ok()).then_some(tree)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use saarcor_scenes::builtin::builtin;
    use saarcor_scenes::kdbuild;

    fn built(triangles: &[Triangle]) -> KdTree {
        kdbuild::build(triangles, &BuildOptions::default(), &|_| ())
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
    }

    #[test]
    fn a_kept_tree_is_the_one_built() {
        let folder = tempfile::tempdir().expect("a folder");
        let kept = KeptTrees::new(folder.path().join("trees"));
        let options = BuildOptions::default();
        let mut triangles = builtin("pquake3").expect("a scene").triangles;
        assert!(triangles.len() >= LEAST_TRIANGLES);
        let tree = built(&triangles);
        let never = || unreachable!("it is kept");
        assert_eq!(kept.tree(&triangles, &options, || tree.clone()), tree);
        assert_eq!(kept.tree(&triangles, &options, never), tree);
        let [file] = files(&kept.folder).try_into().expect("one file");

        // What the tree depends on makes another file, and a spoilt one is made anew.
        let whole = fs::read(&file).expect("a file");
        for place in [0, 16, whole.len() / 2, whole.len() - 1] {
            let mut spoilt = whole.clone();
            spoilt[place] ^= 1;
            fs::write(&file, spoilt).expect("a file");
            assert_eq!(kept.tree(&triangles, &options, || tree.clone()), tree);
            assert_eq!(fs::read(&file).expect("a file"), whole);
        }
        fs::write(&file, &whole[..whole.len() - 4]).expect("a file");
        assert_eq!(kept.tree(&triangles, &options, || tree.clone()), tree);
        let coarse = BuildOptions { max_leaf: 100, ..options };
        let other = kdbuild::build(&triangles, &coarse, &|_| ());
        assert_eq!(kept.tree(&triangles, &coarse, || other.clone()), other);
        triangles[7].corners[1] += Vec3::X;
        assert_eq!(kept.tree(&triangles, &options, || other.clone()), other);
        assert_eq!(files(&kept.folder).len(), 3);
    }

    #[test]
    fn so_many_files_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let kept = KeptTrees::new(folder.path().to_owned());
        let other = folder.path().join("somebody's.txt");
        fs::write(&other, "not a tree").expect("a file");
        for number in 0..2 * FILES {
            kept.keep(&folder.path().join(format!("{number}.{EXTENSION}")), &[0]).expect("room");
        }
        assert!(other.exists());
        assert_eq!(files(folder.path()).len(), FILES + 1);
    }

    #[test]
    fn what_cannot_be_kept_is_built() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, "in the way").expect("a file");
        let triangles = builtin("pquake3").expect("a scene").triangles;
        let tree = built(&triangles[..LEAST_TRIANGLES]);
        let kept = KeptTrees::new(file);
        assert_eq!(kept.tree(&triangles[..LEAST_TRIANGLES], &BuildOptions::default(), || tree.clone()), tree);
    }
}
