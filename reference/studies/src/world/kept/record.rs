//! What is kept of a world beside the bytes of its image: a small file.

use super::source::{Source, Stamp};
use crate::world::{Image, TreeFacts, World, WorldOptions};
use glam::Vec3;
use saarcor_model::host::{Camera, Features, Light, Registers};
use xxhash_rust::xxh3::xxh3_128;

/// How the file begins; another number where what follows is another.
const BEGINNING: &[u8] = b"saarcor world 2\n";

/// A world without the bytes of its image, and what it was made of.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// The scene: a built-in name, or where its file is.
    pub scene: String,
    /// How it was made, in words.
    pub made_with: String,
    /// The program that made it, then the files that the scene depends on.
    pub sources: Vec<Source>,
    /// The file with the bytes of the image, and behind them [`Image::ids`].
    pub image: Stamp,
    /// How long the first of them are.
    pub image_bytes: usize,
    /// The world, whose image has no bytes.
    pub world: World,
}

impl Record {
    /// The record as bytes, with a checksum. None if a path is no text.
    pub fn encode(&self) -> Option<Vec<u8>> {
        let mut bytes = BEGINNING.to_vec();
        Fields::Write(&mut bytes).record(&mut self.clone())?;
        bytes.extend(xxh3_128(&bytes).to_le_bytes());
        Some(bytes)
    }

    /// The record of a world of `options`; none if the bytes are not what [`Record::encode`] made.
    pub fn decode(bytes: &[u8], options: &WorldOptions) -> Option<Self> {
        let (all, checksum) = bytes.split_last_chunk()?;
        let fields = all.strip_prefix(BEGINNING)?;
        if xxh3_128(all) != u128::from_le_bytes(*checksum) {
            return None;
        }
        let mut record = Self {
            scene: String::new(),
            made_with: String::new(),
            sources: Vec::new(),
            image: Stamp::default(),
            image_bytes: 0,
            world: World::blank(options).ok()?,
        };
        Fields::Read(fields).record(&mut record)?;
        record.world.files = record.sources.iter().skip(1).map(|source| source.path.clone()).collect();
        Some(record)
    }
}

const BLANK_CAMERA: Camera = Camera { eye: Vec3::ZERO, dir: Vec3::ZERO, up: Vec3::ZERO, fov_y_deg: 0.0 };
const BLANK_LIGHT: Light = Light { position: Vec3::ZERO, intensity: 0.0 };

/// A record's fields, written to a file or read from it: one walk over them serves both, so that the
/// two cannot differ. None where what is read ends too early, or does not fit.
enum Fields<'a> {
    Write(&'a mut Vec<u8>),
    Read(&'a [u8]),
}

impl Fields<'_> {
    fn record(&mut self, record: &mut Record) -> Option<()> {
        let Record { scene, made_with, sources, image, image_bytes, world } = record;
        self.text(scene)?;
        self.text(made_with)?;
        self.list(sources, Source::default(), Self::source)?;
        self.stamp(image)?;
        self.number(image_bytes)?;
        self.world(world)
    }

    /// All but the image's bytes, and what was asked for: the name and the kernel. Named one by one, so
    /// that none is forgotten.
    fn world(&mut self, world: &mut World) -> Option<()> {
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
        let Image { bytes: _, registers, region_bytes, mip_map_bytes, ids: _ } = image;
        let Registers {
            root,
            bounds,
            kernel: _,
            edges: _,
            triangles: first,
            shading,
            features: needs,
            lights,
        } = registers;
        let TreeFacts { nodes, leaves, refs } = tree;
        self.list(path, BLANK_CAMERA, |fields, Camera { eye, dir, up, fov_y_deg }| {
            [eye, dir, up].into_iter().try_for_each(|vector| fields.vector(vector))?;
            fields.float(fov_y_deg)
        })?;
        [triangles, degenerate, nodes, leaves, refs].into_iter().try_for_each(|count| self.number(count))?;
        region_bytes.iter_mut().chain([mip_map_bytes]).try_for_each(|bytes| self.number(&mut bytes.0))?;
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

    fn source(&mut self, Source { path, stamp }: &mut Source) -> Option<()> {
        let mut text = path.to_str()?.to_owned();
        self.text(&mut text)?;
        *path = text.into();
        self.option(stamp, Self::stamp)
    }

    fn stamp(&mut self, Stamp { bytes, times, checksum }: &mut Stamp) -> Option<()> {
        self.number(bytes)?;
        self.option(times, |fields, times| times.iter_mut().try_for_each(|time| fields.number(time)))?;
        let mut sum = checksum.to_le_bytes();
        self.bytes(&mut sum)?;
        *checksum = u128::from_le_bytes(sum);
        Some(())
    }

    fn text(&mut self, text: &mut String) -> Option<()> {
        let mut bytes = std::mem::take(text).into_bytes();
        self.list(&mut bytes, 0, |fields, byte| fields.bytes(std::array::from_mut(byte)))?;
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

    fn option<T: Clone + Default>(
        &mut self,
        option: &mut Option<T>,
        some: impl Fn(&mut Self, &mut T) -> Option<()>,
    ) -> Option<()> {
        let mut list: Vec<T> = option.iter().cloned().collect();
        self.list(&mut list, T::default(), some)?;
        *option = list.pop();
        Some(())
    }

    fn list<T: Clone>(
        &mut self,
        list: &mut Vec<T>,
        blank: T,
        each: impl Fn(&mut Self, &mut T) -> Option<()>,
    ) -> Option<()> {
        let mut length = list.len();
        self.number(&mut length)?;
        // Each item has a byte at least.
        if matches!(self, Self::Read(rest) if length > rest.len()) {
            return None;
        }
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
