//! Large scenes made ready for the chip, kept from run to run: the largest is there in 0.03 s instead of half a minute, and
//! of its memory only what is touched.
//!
//! A kept world is two files: a record, and the bytes of the image, which are mapped into memory. The record names the
//! program that made it and all files that it depends on, with their sizes, their times and checksums of their content. A
//! world is taken only if this very program would make it, bit for bit, of the files as they are: if all of them have their
//! sizes and times, or where times differ, their checksums. That goes for the image's file too. So nothing depends on a kept
//! world but time, and what cannot be kept is made again without a word.
//!
//! What a disk changes by itself under an unchanged size and time is for [`KeptWorlds::list`] to find, which can read all.

mod record;
mod source;

use super::mapped::bytes_of;
use super::{Image, World, WorldOptions, looks_like_a_path};
use crate::names::{TREES, kernel_name, name_of};
use bytes::Bytes;
use rayon::prelude::*;
use record::Record;
use saarcor_scenes::kdbuild::BuildOptions;
use saarcor_scenes::{TEMPORARY, temporary_prefix};
use serde::Serialize;
use source::{Compared, Source, Stamp};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf, absolute};
use std::time::SystemTime;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Bytes of all files of the folder, unless the user says otherwise.
pub const USUAL_LIMIT: u64 = 4 << 30;

/// Scenes with fewer triangles are not worth a file: they are ready in half a second.
const LEAST_TRIANGLES: usize = 1 << 15;

/// Digits of the name of a world's two files, and their endings.
const NAME: usize = 32;
const RECORD: &str = "world";
const IMAGE: &str = "image";

/// A folder of kept worlds.
#[derive(Clone, Debug)]
pub struct KeptWorlds {
    folder: PathBuf,
    limit: u64,
}

/// What is in the folder under one name.
#[derive(Clone, Debug, Serialize)]
pub struct KeptWorld {
    /// The scene: a built-in name, or where its file is. None where there is no record that can be read.
    pub scene: Option<String>,
    /// How it was made ready, in words.
    pub made_with: Option<String>,
    /// Triangles of the scene.
    pub triangles: Option<usize>,
    /// Bytes of its files.
    pub bytes: u64,
    /// When it was used last.
    #[serde(serialize_with = "seconds")]
    pub last_used: SystemTime,
    /// Whether it can be used.
    #[serde(flatten)]
    pub state: State,
}

/// Whether a kept world can be used.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "state", content = "changed", rename_all = "snake_case")]
pub enum State {
    /// It is what its program would make.
    Ready,
    /// This file, which it was made by or of, is another one now.
    Stale(PathBuf),
    /// Its record or its image is not as it was written, or was written by another version.
    Damaged,
    /// It is being written, or its writer was ended.
    Unfinished,
}

/// What was removed from the folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Removed {
    /// Scenes, damaged and unfinished ones too.
    pub scenes: usize,
    /// Bytes of their files.
    pub bytes: u64,
}

/// Seconds since 1970.
fn seconds<S: serde::Serializer>(time: &SystemTime, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u64(time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_secs()))
}

impl KeptWorlds {
    /// Those in `folder`, which is made when there is one to keep, with [`USUAL_LIMIT`].
    #[must_use]
    pub fn new(folder: PathBuf) -> Self {
        Self { folder, limit: USUAL_LIMIT }
    }

    /// The same with another limit in bytes.
    #[must_use]
    pub fn with_limit(self, limit: u64) -> Self {
        Self { limit, ..self }
    }

    /// Their folder; what is written there has a name with [`temporary_prefix`] until it is whole.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Bytes that all files may have together.
    #[must_use]
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// The world of `options`, if it is kept, and is what would be made now.
    #[must_use]
    pub fn find(&self, options: &WorldOptions) -> Option<World> {
        let path = self.path(options)?;
        let record = Record::decode(&fs::read(&path).ok()?, options)?;
        let sources: Vec<Source> = record.sources.par_iter().map(Source::unchanged).collect::<Option<_>>()?;
        let (bytes, image) = image(&path, &record, false)?;
        // That it is used, and times that need no checksum, are good to know the next time; nothing else needs them.
        let _ = if sources == record.sources && image == record.image {
            File::open(&path).and_then(|file| file.set_modified(SystemTime::now()))
        } else {
            let record = Record { sources, image, ..record.clone() };
            self.write(&path, &[&record.encode()?]).map(drop)
        };
        let Record { image_bytes, mut world, .. } = record;
        (world.image.bytes, world.image.ids) = (bytes.slice(..image_bytes), bytes.slice(image_bytes..));
        Some(world)
    }

    /// Keeps the world that was made of `options` since `started`, if it is worth it.
    pub fn keep(&self, options: &WorldOptions, started: SystemTime, world: &World) {
        let bytes = world.image.bytes.len() + world.image.ids.len();
        if world.triangles >= LEAST_TRIANGLES && bytes as u64 <= self.limit {
            // It is as good as kept: the next run makes it again.
            let _ = self.try_to_keep(options, started, world);
        }
    }

    fn try_to_keep(&self, options: &WorldOptions, started: SystemTime, world: &World) -> io::Result<()> {
        let not_text = || io::Error::other("a path is no text");
        let path = self.path(options).ok_or_else(not_text)?;
        let program = std::env::current_exe()?;
        let source = |path: &PathBuf| Source::before(started, absolute(path)?);
        let files: Vec<&PathBuf> = std::iter::once(&program).chain(&world.files).collect();
        let sources: Vec<Source> = files.into_par_iter().map(source).collect::<io::Result<_>>()?;
        // The file of a program that runs may have been removed.
        if sources[0].stamp.is_none() {
            return Err(ErrorKind::NotFound.into());
        }
        let Image { bytes, ids, .. } = &world.image;
        self.make_room(&path, (bytes.len() + ids.len()) as u64)?;
        let mut checksum = Xxh3::new();
        [bytes, ids].into_iter().for_each(|part| checksum.update(part));
        let image = self.write(&path.with_extension(IMAGE), &[bytes, ids])?;
        let record = Record {
            scene: scene(options).ok_or_else(not_text)?,
            made_with: described(options),
            sources,
            image: Stamp::of_unchanging(&image.metadata()?, checksum.digest128()),
            image_bytes: bytes.len(),
            world: world.clone(),
        };
        self.write(&path, &[&record.encode().ok_or_else(not_text)?])?;
        Ok(())
    }

    /// The record's file. Its name is a checksum of what the user asked for, and whom; none where that is no text.
    fn path(&self, options: &WorldOptions) -> Option<PathBuf> {
        let asked = WorldOptions { scene: scene(options)?, last_frame: None, kept: None, ..options.clone() };
        let name = xxh3_128(format!("{asked:?} {:?}", std::env::current_exe().ok()?).as_bytes());
        Some(self.folder.join(format!("{name:0NAME$x}.{RECORD}")))
    }

    /// Writes a file: all of it, or nothing. After a failure of power too there is either, or a record is found spoilt.
    fn write(&self, path: &Path, parts: &[&[u8]]) -> io::Result<File> {
        fs::create_dir_all(&self.folder)?;
        let mut file = tempfile::Builder::new().prefix(&temporary_prefix()).tempfile_in(&self.folder)?;
        parts.iter().try_for_each(|part| file.write_all(part))?;
        file.as_file().sync_all()?;
        Ok(file.persist(path)?)
    }

    /// What is in the folder, the most recently used first.
    ///
    /// With `whole`, images are read to their ends, and what is damaged is removed.
    ///
    /// # Errors
    /// If the folder cannot be read, or a file not be removed.
    pub fn list(&self, whole: bool) -> io::Result<Vec<KeptWorld>> {
        let mut worlds = Vec::new();
        for entry in self.entries()?.into_iter().rev() {
            let record = entry.record();
            let state = match &record {
                _ if entry.is_temporary => State::Unfinished,
                Some(record) if image(&entry.path, record, whole).is_some() => {
                    let changed = record.sources.par_iter().find_first(|source| source.unchanged().is_none());
                    changed.map_or(State::Ready, |source| State::Stale(source.path.clone()))
                }
                _ => State::Damaged,
            };
            if whole && state == State::Damaged {
                entry.remove()?;
            }
            let Entry { bytes, last_used, .. } = entry;
            let (scene, made_with, triangles) = match record {
                Some(Record { scene, made_with, world, .. }) => {
                    (Some(scene), Some(made_with), Some(world.triangles))
                }
                None => (None, None, None),
            };
            worlds.push(KeptWorld { scene, made_with, triangles, bytes, last_used, state });
        }
        Ok(worlds)
    }

    /// Removes all that [`KeptWorlds::list`] has. Other files in the folder are somebody else's.
    ///
    /// # Errors
    /// If the folder cannot be read, or a file not be removed.
    pub fn empty(&self) -> io::Result<Removed> {
        let entries = self.entries()?;
        entries.iter().try_for_each(Entry::remove)?;
        Ok(Removed { scenes: entries.len(), bytes: entries.iter().map(|entry| entry.bytes).sum() })
    }

    /// Removes what has the name of `path`, and then the least recently used, until there is room for so many bytes.
    fn make_room(&self, path: &Path, bytes: u64) -> io::Result<()> {
        let mut entries = self.entries()?;
        // The first to go.
        entries.sort_by_key(|entry| entry.path != path);
        let mut all: u64 = entries.iter().map(|entry| entry.bytes).sum();
        for entry in entries {
            if entry.path != path && all + bytes <= self.limit {
                break;
            }
            entry.remove()?;
            all -= entry.bytes;
        }
        Ok(())
    }

    /// What is in the folder, the least recently used first.
    fn entries(&self) -> io::Result<Vec<Entry>> {
        let found = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            found => found?,
        };
        let mut entries: BTreeMap<PathBuf, Entry> = BTreeMap::new();
        for file in found {
            let file = file?;
            let path = file.path();
            let is_temporary = file.file_name().as_encoded_bytes().starts_with(TEMPORARY.as_bytes());
            // Another process may have removed it.
            let Ok(found) = file.metadata() else { continue };
            if !found.is_file() || !(is_temporary || is_of_a_world(&path)) {
                continue;
            }
            let path = if is_temporary { path } else { path.with_extension(RECORD) };
            let last_used = found.modified()?;
            let entry =
                entries.entry(path.clone()).or_insert(Entry { path, is_temporary, bytes: 0, last_used });
            entry.bytes += found.len();
            entry.last_used = entry.last_used.max(last_used);
        }
        let mut entries: Vec<Entry> = entries.into_values().collect();
        entries.sort_by_key(|entry| entry.last_used);
        Ok(entries)
    }
}

/// What is in the folder under one name.
struct Entry {
    /// The record's file, or a temporary one.
    path: PathBuf,
    is_temporary: bool,
    bytes: u64,
    last_used: SystemTime,
}

impl Entry {
    fn record(&self) -> Option<Record> {
        // It is not opened: any options do.
        Record::decode(&fs::read(&self.path).ok()?, &WorldOptions::new(""))
    }

    fn remove(&self) -> io::Result<()> {
        [self.path.clone(), self.path.with_extension(IMAGE)].into_iter().try_for_each(|path| {
            // Another process may have been faster.
            fs::remove_file(path)
                .or_else(|error| if error.kind() == ErrorKind::NotFound { Ok(()) } else { Err(error) })
        })
    }
}

/// Whether a file has the name of one of a world's two.
fn is_of_a_world(path: &Path) -> bool {
    let text =
        |part: Option<&std::ffi::OsStr>| part.and_then(|part| part.to_str()).unwrap_or_default().to_owned();
    let (name, ending) = (text(path.file_stem()), text(path.extension()));
    name.len() == NAME
        && name.bytes().all(|digit| digit.is_ascii_hexdigit())
        && [RECORD, IMAGE].contains(&ending.as_str())
}

/// The bytes of the image, and its stamp as of now; none if they are not those of the record. They are all read where their
/// file's times are others, or `whole`.
fn image(path: &Path, record: &Record, whole: bool) -> Option<(Bytes, Stamp)> {
    let file = File::open(path.with_extension(IMAGE)).ok()?;
    let found = file.metadata().ok()?;
    let compared = record.image.compare(&found);
    let bytes = bytes_of(file).ok()?;
    let is_same = match compared {
        Compared::Same if !whole => true,
        Compared::Same | Compared::Perhaps => xxh3_128(&bytes) == record.image.checksum,
        Compared::Different => false,
    };
    let fits = bytes.len() as u64 == record.image.bytes && bytes.len() >= record.image_bytes;
    (is_same && fits).then(|| (bytes, Stamp::of_unchanging(&found, record.image.checksum)))
}

/// The scene as text, wherever the program runs: a built-in name, or where its file is.
fn scene(options: &WorldOptions) -> Option<String> {
    match &options.file {
        Some(_) => None,
        None if looks_like_a_path(&options.scene) => {
            Some(absolute(&options.scene).ok()?.to_str()?.to_owned())
        }
        None => Some(options.scene.clone()),
    }
}

/// How a world is made, in words.
fn described(options: &WorldOptions) -> String {
    let WorldOptions { lights, no_textures, strict, no_mip_maps, tree, kernel, .. } = options;
    let usual = BuildOptions::default();
    let usual_but_its_rule = BuildOptions { rule: tree.rule, ..usual };
    let said = |is_said: bool, words: &str| is_said.then(|| words.to_owned());
    let words = [
        Some(kernel_name(*kernel).to_owned()),
        said(tree.rule != usual.rule, &format!("tree {}", name_of(TREES, &tree.rule))),
        said(*tree != usual_but_its_rule, "another tree"),
        lights.map(|lights| format!("{lights} lights")),
        said(*no_textures, "no textures"),
        said(*no_mip_maps, "no mip maps"),
        said(*strict, "strict"),
    ];
    words.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use saarcor_model::host::Scene;
    use saarcor_scenes::builtin::builtin;
    use saarcor_scenes::export_obj;
    use std::time::Duration;

    /// A scene that is worth keeping, and needs files of all kinds.
    fn export(folder: &Path) -> PathBuf {
        let Scene { mut triangles, materials, textures, lights, path, mut tex_coords, mut normals, mip_maps } =
            builtin("pquake3").expect("a scene");
        assert!(triangles.len() > LEAST_TRIANGLES && !textures.is_empty() && !lights.is_empty());
        triangles.truncate(LEAST_TRIANGLES);
        tex_coords.truncate(LEAST_TRIANGLES);
        normals.truncate(LEAST_TRIANGLES);
        let file = folder.join("scene.obj");
        let scene = Scene { triangles, materials, textures, lights, path, tex_coords, normals, mip_maps };
        export_obj(&scene, &file).expect("written");
        // What is kept says its warnings again.
        let mut obj = File::options().append(true).open(&file).expect("the scene");
        writeln!(obj, "unknown").expect("written");
        file
    }

    fn options(scene: &Path, kept: Option<&KeptWorlds>) -> WorldOptions {
        WorldOptions { kept: kept.cloned(), ..WorldOptions::new(scene.to_str().expect("text")) }
    }

    /// All that a world is but for what it was made of, as bytes.
    fn bytes(world: &World) -> Vec<u8> {
        let world = World { files: Vec::new(), ..world.clone() };
        let Image { bytes, ids, .. } = world.image.clone();
        let record = Record {
            scene: String::new(),
            made_with: String::new(),
            sources: Vec::new(),
            image: Stamp::default(),
            image_bytes: bytes.len(),
            world,
        };
        [&record.encode().expect("text")[..], &bytes, &ids].concat()
    }

    /// The world as bytes, and whether it was kept.
    fn open(options: &WorldOptions) -> (Vec<u8>, bool) {
        let found = options.kept.as_ref().and_then(|kept| kept.find(options));
        let world = World::open(options, &Silent).expect("a scene");
        assert_eq!(world.warnings.len(), 1);
        assert_eq!((&world.name, world.image.registers.kernel), (&options.scene, options.kernel));
        assert!(found.iter().all(|found| bytes(found) == bytes(&world) && found.files == world.files));
        (bytes(&world), found.is_some())
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let mut files: Vec<_> =
            fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
        files.sort();
        files
    }

    /// The two files of the only world, the image first.
    fn both(kept: &KeptWorlds) -> [PathBuf; 2] {
        files(kept.folder()).try_into().expect("two files")
    }

    fn states(kept: &KeptWorlds) -> Vec<State> {
        kept.list(false).expect("a folder").into_iter().map(|world| world.state).collect()
    }

    #[test]
    fn a_kept_world_is_the_one_made() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), KeptWorlds::new(folder.path().join("kept")));
        let asked = options(&scene, Some(&kept));
        let (made, _) = open(&options(&scene, None));
        assert_eq!(open(&asked), (made.clone(), false));
        assert_eq!(open(&asked), (made.clone(), true));
        assert_eq!(open(&WorldOptions { last_frame: Some(0), ..asked.clone() }), (made.clone(), true));
        let too_late = WorldOptions { last_frame: Some(usize::MAX), ..asked.clone() };
        assert!(World::open(&too_late, &Silent).is_err());

        // Other options make another world.
        let few = WorldOptions { lights: Some(1), no_textures: true, ..asked.clone() };
        let (other, _) = open(&few);
        assert_eq!(open(&few), (other.clone(), true));
        assert!(other != made && files(kept.folder()).len() == 4);
        let listed = kept.list(true).expect("a folder");
        let made = |world: &KeptWorld| {
            (world.made_with.clone().expect("words"), world.triangles, world.state.clone())
        };
        assert_eq!(
            listed.iter().map(made).collect::<Vec<_>>(),
            ["moller-trumbore, 1 lights, no textures", "moller-trumbore"].map(|words| (
                words.to_owned(),
                Some(LEAST_TRIANGLES),
                State::Ready
            ))
        );
        assert!(listed.iter().all(|world| world.scene.as_deref() == scene.to_str()));
        let bytes: u64 = listed.iter().map(|world| world.bytes).sum();
        assert_eq!(kept.empty().expect("emptied"), Removed { scenes: 2, bytes });
        assert_eq!(files(kept.folder()), [""; 0].map(PathBuf::from));
    }

    #[test]
    fn a_spoilt_file_is_made_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), KeptWorlds::new(folder.path().join("kept")));
        let asked = options(&scene, Some(&kept));
        let (made, _) = open(&asked);
        let both = both(&kept);
        let whole = both.each_ref().map(|file| fs::read(file).expect("a file"));
        let restore = || {
            for (file, whole) in both.iter().zip(&whole) {
                fs::write(file, whole).expect("written");
            }
        };
        for (file, whole) in both.iter().zip(&whole) {
            for spoilt in [0, whole.len() / 2, whole.len() - 100, whole.len() - 1] {
                let mut bytes = whole.clone();
                bytes[spoilt] ^= 1;
                fs::write(file, &bytes).expect("written");
                assert!(kept.find(&asked).is_none() && states(&kept) == [State::Damaged], "byte {spoilt}");
            }
            for short in [0, 1, whole.len() - 4] {
                fs::write(file, &whole[..short]).expect("written");
                assert!(kept.find(&asked).is_none() && states(&kept) == [State::Damaged], "{short} bytes");
            }
            fs::remove_file(file).expect("removed");
            assert!(kept.find(&asked).is_none() && states(&kept) == [State::Damaged]);
            restore();
            assert_eq!(open(&asked), (made.clone(), true));
        }
        fs::write(&both[0], &whole[0][..whole[0].len() - 4]).expect("written");
        assert_eq!(open(&asked), (made.clone(), false));
        assert_eq!(open(&asked), (made, true));
    }

    /// What has the times of before is not read, but by whoever looks for damage.
    #[test]
    fn what_a_disk_changes_is_found_by_reading_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), KeptWorlds::new(folder.path().join("kept")));
        let asked = options(&scene, Some(&kept));
        open(&asked);
        let [image, record] = both(&kept);
        let mut bytes = fs::read(&image).expect("a file");
        bytes[1000] ^= 1;
        fs::write(&image, bytes).expect("written");
        // As if the new times were those of the record.
        let mut kept_record = Record::decode(&fs::read(&record).expect("a file"), &asked).expect("a record");
        let found = fs::metadata(&image).expect("a file");
        kept_record.image = Stamp::of_unchanging(&found, kept_record.image.checksum);
        fs::write(&record, kept_record.encode().expect("text")).expect("written");
        assert!(kept.find(&asked).is_some());
        let state = |whole| kept.list(whole).expect("a folder").pop().map(|world| world.state);
        assert_eq!(state(false), Some(State::Ready));
        assert_eq!(state(true), Some(State::Damaged));
        assert_eq!(state(false), None);
    }

    #[test]
    fn a_world_of_changed_files_is_made_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), KeptWorlds::new(folder.path().join("kept")));
        let asked = options(&scene, Some(&kept));
        open(&asked);
        let texture = files(folder.path()).into_iter().find(|file| file.extension() == Some("png".as_ref()));
        let find = || kept.find(&asked);
        for file in [texture.expect("a texture"), scene.clone(), scene.with_extension("mtl")]
            .into_iter()
            .chain(["camera.csv", "lights.csv"].map(|name| folder.path().join(name)))
        {
            assert!(find().is_some(), "{}", file.display());
            let bytes = fs::read(&file).expect("a file");
            fs::write(&file, [&bytes[..], b"\n"].concat()).expect("written");
            assert!(find().is_none(), "{}", file.display());
            assert_eq!(states(&kept), [State::Stale(file.clone())]);
            // As long as before, and of the same time.
            let modified = fs::metadata(&file).and_then(|file| file.modified()).expect("a time");
            let mut other = bytes.clone();
            other[0] ^= 1;
            fs::write(&file, other).expect("written");
            File::options()
                .write(true)
                .open(&file)
                .and_then(|file| file.set_modified(modified))
                .expect("set");
            assert!(find().is_none(), "{}", file.display());
            fs::remove_file(&file).expect("removed");
            assert!(find().is_none(), "{}", file.display());
            fs::write(&file, bytes).expect("written");
        }
        // A file that was looked for.
        fs::remove_file(folder.path().join("lights.csv")).expect("removed");
        let (dark, _) = open(&asked);
        assert_eq!(open(&asked), (dark, true));
        fs::write(folder.path().join("lights.csv"), "x,y,z,intensity\n").expect("written");
        assert!(find().is_none());
    }

    /// A file that only has other times is read once, and not again when these are old enough to tell a change.
    #[test]
    fn other_times_are_no_change() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), KeptWorlds::new(folder.path().join("kept")));
        let asked = options(&scene, Some(&kept));
        open(&asked);
        let [_, record] = both(&kept);
        let times = || {
            let record = Record::decode(&fs::read(&record).expect("a file"), &asked).expect("a record");
            let of_scene = record.sources.iter().find(|source| source.path == scene).expect("the scene");
            of_scene.stamp.expect("a file").times
        };
        std::thread::sleep(source::COARSE);
        assert!(kept.find(&asked).is_some());
        let first = times().expect("times");
        assert!(kept.find(&asked).is_some());
        assert_eq!(times(), Some(first));
        let long_ago = SystemTime::now() - Duration::from_secs(1000);
        File::options().write(true).open(&scene).and_then(|file| file.set_modified(long_ago)).expect("set");
        assert!(kept.find(&asked).is_some() && times() != Some(first));
    }

    #[test]
    fn what_was_written_meanwhile_is_not_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), folder.path().join("kept"));
        let asked = options(&scene, None);
        let world = World::open(&asked, &Silent).expect("a scene");
        KeptWorlds::new(kept.clone()).keep(&asked, SystemTime::UNIX_EPOCH, &world);
        assert!(!kept.exists());
    }

    /// The least recently used leave, whatever they are, and nothing of anybody else's.
    #[test]
    fn so_many_bytes_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let kept = KeptWorlds::new(folder.path().join("kept")).with_limit(100);
        assert!(kept.list(true).expect("no folder").is_empty());
        fs::create_dir(kept.folder()).expect("a folder");
        let write = |name: &str, bytes: usize, age: u64| {
            let path = kept.folder().join(name);
            fs::write(&path, vec![0; bytes]).expect("written");
            let time = SystemTime::now() - Duration::from_secs(age);
            File::options().write(true).open(&path).and_then(|file| file.set_modified(time)).expect("set");
            path
        };
        let (a, b, c) = ("a".repeat(32), "b".repeat(32), "c".repeat(32));
        let somebodys =
            ["notes.txt", "a.world", &format!("{a}.txt"), "saarcor-1"].map(|name| write(name, 1000, 9000));
        // Used lately, though its image was written long ago.
        let recent = [write(&format!("{a}.image"), 30, 8000), write(&format!("{a}.world"), 10, 10)];
        let old = [write(&format!("{b}.image"), 30, 800), write(&format!("{b}.world"), 10, 700)];
        let left = write(&format!("{TEMPORARY}1-x"), 15, 900);
        let exist = |files: &[PathBuf]| files.iter().all(|file| file.exists());
        let new = kept.folder().join(format!("{c}.{RECORD}"));
        assert_eq!(states(&kept), [State::Damaged, State::Damaged, State::Unfinished]);
        kept.make_room(&new, 5).expect("room");
        assert!(exist(&recent) && exist(&old) && left.exists());
        kept.make_room(&new, 20).expect("room");
        assert!(exist(&recent) && exist(&old) && !left.exists());
        kept.make_room(&new, 21).expect("room");
        assert!(exist(&recent) && !old[0].exists() && !old[1].exists());
        // Its own place is emptied first.
        kept.make_room(&recent[1], 0).expect("room");
        assert!(!recent[0].exists() && !recent[1].exists());
        write(&format!("{a}.image"), 30, 0);
        assert_eq!(kept.empty().expect("emptied"), Removed { scenes: 1, bytes: 30 });
        assert!(exist(&somebodys));
        assert_eq!(files(kept.folder()).len(), somebodys.len());
    }

    #[test]
    fn what_cannot_be_kept_is_made() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, file) = (export(folder.path()), folder.path().join("file"));
        fs::write(&file, "in the way").expect("a file");
        let (made, _) = open(&options(&scene, None));
        for kept in [KeptWorlds::new(file), KeptWorlds::new(folder.path().join("kept")).with_limit(1 << 20)] {
            let asked = options(&scene, Some(&kept));
            assert_eq!(open(&asked), (made.clone(), false));
            assert_eq!(open(&asked), (made.clone(), false));
        }
        assert!(!folder.path().join("kept").exists());
    }
}
