//! Large scenes made ready for the chip, kept from run to run: the real conference is there in 0.05 s
//! instead of 1.0 s (two cores), and a sampled frame of it takes 0.3 to 0.7 s.
//!
//! A kept world is the one that this very program would make of the files as they are, bit for bit: it
//! stands beside checksums of the program and of all files that it depends on, and is not taken if one of
//! them differs, or if the file is not whole. Nothing depends on it but time, so what cannot be kept is
//! made again without a word.

use super::{TreeFacts, World, WorldOptions, looks_like_a_path};
use glam::Vec3;
use rayon::prelude::*;
use saarcor_model::host::{Camera, Features, HostImage, Light, Registers};
use saarcor_scenes::temporary_prefix;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::path::{Path, PathBuf, absolute};
use std::time::SystemTime;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Names the folder of kept worlds; where it is empty, none are kept.
pub const FOLDER: &str = "SAARCOR_CACHE";

/// Scenes with fewer triangles are not worth a file: they are ready in half a second.
const LEAST_TRIANGLES: usize = 1 << 15;

/// Files that are kept, and bytes of the largest image: half a gigabyte in all.
const FILES: usize = 8;
const MOST_BYTES: usize = 64 << 20;

const EXTENSION: &str = "world";

/// A folder of kept worlds.
#[derive(Clone, Debug)]
pub struct KeptWorlds {
    folder: PathBuf,
}

impl KeptWorlds {
    /// Those in `folder`, which is made when there is one to keep.
    #[must_use]
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Their folder; what is written there has a name with [`temporary_prefix`] until it is whole.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
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

    /// The world of `options`, if it is kept, and is what would be made now.
    #[must_use]
    pub fn find(&self, options: &WorldOptions) -> Option<World> {
        let bytes = fs::read(self.path(options)?).ok()?;
        let (world, sources) = decode(bytes, options)?;
        let as_now = |source: &Source| Source::now(source.path.clone()).is_ok_and(|now| now == *source);
        let Source { path, checksum } = sources.first()?;
        let world = World { files: sources[1..].iter().map(|source| source.path.clone()).collect(), ..world };
        // The file of a program that runs may have been removed.
        let of_this_program = checksum.is_some() && *path == std::env::current_exe().ok()?;
        (of_this_program && sources.par_iter().all(as_now)).then_some(world)
    }

    /// Keeps the world that was made of `options` since `started`, and of `files`, if it is worth it.
    pub fn keep(&self, options: &WorldOptions, started: SystemTime, files: &[PathBuf], world: &World) {
        if world.triangles >= LEAST_TRIANGLES && world.image.bytes.len() <= MOST_BYTES {
            // It is as good as kept: the next run makes it again.
            let _ = self.try_to_keep(options, started, files, world);
        }
    }

    fn try_to_keep(
        &self,
        options: &WorldOptions,
        started: SystemTime,
        files: &[PathBuf],
        world: &World,
    ) -> io::Result<()> {
        let not_text = || io::Error::other("a path is no text");
        let program = std::env::current_exe()?;
        let sources = [&program].into_iter().chain(files).map(|path| {
            // It may not be what the world was made of.
            let changed =
                fs::metadata(path).is_ok_and(|file| file.modified().is_ok_and(|time| time >= started));
            if changed {
                return Err(io::Error::other("written meanwhile"));
            }
            Source::now(absolute(path)?)
        });
        let bytes = encode(world, sources.collect::<io::Result<_>>()?).ok_or_else(not_text)?;
        self.write(&self.path(options).ok_or_else(not_text)?, &bytes)
    }

    /// The file's name: a checksum of what the user asked for; none where that is no text.
    fn path(&self, options: &WorldOptions) -> Option<PathBuf> {
        if options.file.is_some() {
            return None;
        }
        let scene = match looks_like_a_path(&options.scene) {
            true => absolute(&options.scene).ok()?.to_str()?.to_owned(),
            false => options.scene.clone(),
        };
        let asked = WorldOptions { scene, last_frame: None, kept: None, ..options.clone() };
        let name = xxh3_128(format!("{asked:?}").as_bytes());
        Some(self.folder.join(format!("{name:032x}.{EXTENSION}")))
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        self.make_room()?;
        let mut file = tempfile::Builder::new().prefix(&temporary_prefix()).tempfile_in(&self.folder)?;
        file.write_all(bytes)?;
        file.persist(path)?;
        Ok(())
    }

    /// Removes the oldest files, so that there is room for one more.
    fn make_room(&self) -> io::Result<()> {
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

/// A file that a world depends on.
#[derive(Clone, Debug, Default, PartialEq)]
struct Source {
    path: PathBuf,
    /// Of its bytes; none where there is no such file.
    checksum: Option<u128>,
}

impl Source {
    /// As it is now. Read piece by piece: to have memory for all of it would take longer than the
    /// checksum.
    fn now(path: PathBuf) -> io::Result<Self> {
        let file = match File::open(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self { path, checksum: None }),
            file => file?,
        };
        let mut file = BufReader::with_capacity(1 << 16, file);
        let mut checksum = Xxh3::new();
        loop {
            let piece = file.fill_buf()?;
            if piece.is_empty() {
                return Ok(Self { path, checksum: Some(checksum.digest128()) });
            }
            checksum.update(piece);
            let read = piece.len();
            file.consume(read);
        }
    }
}

/// A kept world as bytes: its image, its other fields, how long the image is, and a checksum of all.
/// None if a path is no text.
fn encode(world: &World, mut sources: Vec<Source>) -> Option<Vec<u8>> {
    let (mut world, mut bytes) = (world.clone(), Vec::new());
    bytes.append(&mut world.image.bytes);
    let image_bytes = bytes.len() as u64;
    Fields::Write(&mut bytes).all(&mut world, &mut sources)?;
    bytes.extend(image_bytes.to_le_bytes());
    bytes.extend(xxh3_128(&bytes).to_le_bytes());
    Some(bytes)
}

/// The world of `options` and what it depends on; none if the bytes are not what [`encode`] made.
fn decode(mut bytes: Vec<u8>, options: &WorldOptions) -> Option<(World, Vec<Source>)> {
    let (all, checksum) = bytes.split_last_chunk()?;
    if xxh3_128(all) != u128::from_le_bytes(*checksum) {
        return None;
    }
    let (all, image_bytes) = all.split_last_chunk()?;
    let image_bytes = u64::from_le_bytes(*image_bytes) as usize;
    let (mut world, mut sources) = (World::blank(options).ok()?, Vec::new());
    Fields::Read(all.get(image_bytes..)?).all(&mut world, &mut sources)?;
    bytes.truncate(image_bytes);
    world.image.bytes = bytes;
    Some((world, sources))
}

const BLANK_CAMERA: Camera = Camera { eye: Vec3::ZERO, dir: Vec3::ZERO, up: Vec3::ZERO, fov_y_deg: 0.0 };
const BLANK_LIGHT: Light = Light { position: Vec3::ZERO, intensity: 0.0 };

/// A world's fields, written to a file or read from it: one walk over them serves both, so that the
/// two cannot differ. None where what is read ends too early, or does not fit.
enum Fields<'a> {
    Write(&'a mut Vec<u8>),
    Read(&'a [u8]),
}

impl Fields<'_> {
    /// All but the image's bytes, and what was asked for: the name and the kernel. Named one by one, so
    /// that none is forgotten.
    fn all(&mut self, world: &mut World, sources: &mut Vec<Source>) -> Option<()> {
        let World {
            name: _,
            path,
            features,
            triangles,
            degenerate,
            image,
            tree,
            warnings,
            files: _,
            seconds: _,
        } = world;
        let HostImage { bytes: _, registers, region_bytes, mip_map_bytes, triangle_ids } = image;
        let Registers { root, bounds, kernel: _, triangles: first, shading, features: needs, lights } =
            registers;
        let TreeFacts { nodes, leaves, refs } = tree;
        self.list(sources, Source::default(), |fields, source| fields.source(source))?;
        self.list(path, BLANK_CAMERA, |fields, Camera { eye, dir, up, fov_y_deg }| {
            [eye, dir, up].into_iter().try_for_each(|vector| fields.vector(vector))?;
            fields.float(fov_y_deg)
        })?;
        [triangles, degenerate, nodes, leaves, refs].into_iter().try_for_each(|count| self.number(count))?;
        region_bytes.iter_mut().chain([mip_map_bytes]).try_for_each(|bytes| self.number(&mut bytes.0))?;
        self.list(triangle_ids, 0, Self::number)?;
        [root, first, shading].into_iter().try_for_each(|addr| self.number(&mut addr.0))?;
        [&mut bounds.min, &mut bounds.max].into_iter().try_for_each(|corner| self.vector(corner))?;
        self.list(lights, BLANK_LIGHT, |fields, Light { position, intensity }| {
            fields.vector(position)?;
            fields.float(intensity)
        })?;
        self.list(warnings, String::new(), Self::text)?;
        self.features(needs)?;
        *features = *needs;
        Some(())
    }

    fn source(&mut self, Source { path, checksum }: &mut Source) -> Option<()> {
        let mut text = path.to_str()?.to_owned();
        self.text(&mut text)?;
        *path = text.into();
        let mut sum: Vec<u128> = checksum.iter().copied().collect();
        self.list(&mut sum, 0, |fields, sum| {
            let mut bytes = sum.to_le_bytes();
            fields.bytes(&mut bytes)?;
            *sum = u128::from_le_bytes(bytes);
            Some(())
        })?;
        *checksum = sum.first().copied();
        Some(())
    }

    fn text(&mut self, text: &mut String) -> Option<()> {
        let mut bytes = std::mem::take(text).into_bytes();
        self.list(&mut bytes, 0, Self::number)?;
        *text = String::from_utf8(bytes).ok()?;
        Some(())
    }

    fn features(&mut self, features: &mut Features) -> Option<()> {
        let Features {
            textures,
            bump_maps,
            mip_maps,
            lights,
            smooth_normals,
            highlights,
            reflection,
            refraction,
        } = features;
        self.number(lights)?;
        let needs = [textures, bump_maps, mip_maps, smooth_normals, highlights, reflection, refraction];
        needs.into_iter().try_for_each(|need| {
            let mut number = u8::from(*need);
            self.number(&mut number)?;
            *need = number != 0;
            Some(())
        })
    }

    fn list<T: Clone>(
        &mut self,
        list: &mut Vec<T>,
        blank: T,
        each: impl Fn(&mut Self, &mut T) -> Option<()>,
    ) -> Option<()> {
        let mut length = list.len();
        self.number(&mut length)?;
        list.resize(length, blank);
        list.iter_mut().try_for_each(|item| each(self, item))
    }

    fn number<T: Copy + TryFrom<u64> + TryInto<u64>>(&mut self, number: &mut T) -> Option<()> {
        let mut bytes = (*number).try_into().ok()?.to_le_bytes();
        self.bytes(&mut bytes)?;
        *number = u64::from_le_bytes(bytes).try_into().ok()?;
        Some(())
    }

    fn vector(&mut self, vector: &mut Vec3) -> Option<()> {
        [&mut vector.x, &mut vector.y, &mut vector.z].into_iter().try_for_each(|number| self.float(number))
    }

    fn float(&mut self, number: &mut f32) -> Option<()> {
        let mut bits = number.to_bits();
        self.number(&mut bits)?;
        *number = f32::from_bits(bits);
        Some(())
    }

    fn bytes<const N: usize>(&mut self, bytes: &mut [u8; N]) -> Option<()> {
        match self {
            Self::Write(file) => file.extend_from_slice(bytes),
            Self::Read(rest) => {
                (*bytes, *rest) = rest.split_first_chunk().map(|(first, rest)| (*first, rest))?
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use saarcor_model::host::Scene;
    use saarcor_scenes::builtin::builtin;
    use saarcor_scenes::export_obj;

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

    fn options(scene: &Path, kept: Option<&Path>) -> WorldOptions {
        let kept = kept.map(|folder| KeptWorlds::new(folder.to_owned()));
        WorldOptions { kept, ..WorldOptions::new(scene.to_str().expect("text")) }
    }

    /// The world as bytes, and whether it was kept.
    fn open(options: &WorldOptions) -> (Vec<u8>, bool) {
        let found = options.kept.as_ref().and_then(|kept| kept.find(options));
        let world = World::open(options, &Silent).expect("a scene");
        assert_eq!(world.warnings.len(), 1);
        assert_eq!((&world.name, world.image.registers.kernel), (&options.scene, options.kernel));
        let bytes = |world| encode(world, Vec::new()).expect("text");
        assert!(found.iter().all(|found| bytes(found) == bytes(&world)));
        (bytes(&world), found.is_some())
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
    }

    #[test]
    fn a_kept_world_is_the_one_made() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), folder.path().join("kept"));
        let asked = options(&scene, Some(&kept));
        let (made, _) = open(&options(&scene, None));
        assert_eq!(open(&asked), (made.clone(), false));
        assert_eq!(open(&asked), (made.clone(), true));
        assert_eq!(open(&WorldOptions { last_frame: Some(0), ..asked.clone() }), (made.clone(), true));
        let too_late = WorldOptions { last_frame: Some(usize::MAX), ..asked.clone() };
        assert!(World::open(&too_late, &Silent).is_err());

        // A spoilt file is made anew.
        let [file] = files(&kept).try_into().expect("one file");
        let whole = fs::read(&file).expect("a file");
        for spoilt in [0, whole.len() / 2, whole.len() - 100, whole.len() - 1] {
            let mut bytes = whole.clone();
            bytes[spoilt] ^= 1;
            fs::write(&file, bytes).expect("written");
            assert!(asked.kept.as_ref().is_some_and(|kept| kept.find(&asked).is_none()));
        }
        fs::write(&file, &whole[..whole.len() - 4]).expect("written");
        assert_eq!(open(&asked), (made.clone(), false));
        assert_eq!(fs::read(&file).expect("a file"), whole);

        // Other options make another file.
        let few = WorldOptions { lights: Some(1), no_textures: true, ..asked.clone() };
        let (other, _) = open(&few);
        assert_eq!(open(&few), (other.clone(), true));
        assert!(other != made && files(&kept).len() == 2);
    }

    #[test]
    fn a_world_of_changed_files_is_made_anew() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), folder.path().join("kept"));
        let asked = options(&scene, Some(&kept));
        open(&asked);
        let texture = files(folder.path()).into_iter().find(|file| file.extension() == Some("png".as_ref()));
        let find = || asked.kept.as_ref().expect("a folder").find(&asked);
        for file in [texture.expect("a texture"), scene.clone(), scene.with_extension("mtl")]
            .into_iter()
            .chain(["camera.csv", "lights.csv"].map(|name| folder.path().join(name)))
        {
            assert!(find().is_some(), "{}", file.display());
            let bytes = fs::read(&file).expect("a file");
            fs::write(&file, [&bytes[..], b"\n"].concat()).expect("written");
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

    #[test]
    fn what_was_written_meanwhile_is_not_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, kept) = (export(folder.path()), folder.path().join("kept"));
        let asked = options(&scene, None);
        let world = World::open(&asked, &Silent).expect("a scene");
        KeptWorlds::new(kept.clone()).keep(&asked, SystemTime::UNIX_EPOCH, &[scene], &world);
        assert!(!kept.exists());
    }

    #[test]
    fn so_many_files_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let kept = KeptWorlds::new(folder.path().to_owned());
        let other = folder.path().join("somebody's.txt");
        fs::write(&other, "not a world").expect("a file");
        for number in 0..2 * FILES {
            kept.write(&folder.path().join(format!("{number}.{EXTENSION}")), &[0]).expect("room");
        }
        assert!(other.exists());
        assert_eq!(files(folder.path()).len(), FILES + 1);
    }

    #[test]
    fn what_cannot_be_kept_is_made() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, file) = (export(folder.path()), folder.path().join("file"));
        fs::write(&file, "in the way").expect("a file");
        let asked = options(&scene, Some(&file));
        let (made, _) = open(&options(&scene, None));
        assert_eq!(open(&asked), (made.clone(), false));
        assert_eq!(open(&asked), (made, false));
    }
}
