//! Image textures and bump maps: which files the materials name, and their texels.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{ImageFormat, ImageReader};
use rayon::prelude::*;
use saarcor_model::host::{Material, TexelFormat, Texture};

use super::map_options::{Statement, without_options};
use super::materials::{Map, Stated};
use super::names::Finder;
use crate::error::SceneError;
use crate::text::{quoted, read_bytes};
use crate::warning::Warnings;

/// Endings of the names of images of other formats than PNG and JPEG. Some have no mark in their content.
const OTHER_FORMATS: &str =
    "tga bmp dds tif tiff gif webp psd exr hdr ktx ktx2 basis pcx ppm pgm pnm iff rgb sgi svg";

/// The images that materials name, each once, and who named it first.
#[derive(Default)]
pub(crate) struct Textures<'a> {
    /// Sorted by path, so that the order of the images is that of their names.
    files: BTreeMap<Key, Request<'a>>,
    /// The materials that need their images' indices: material, key of `files`, and the bump map's height.
    users: Vec<(usize, Key, f32)>,
}

/// An image file, and what it is read as.
type Key = (PathBuf, Texels);

/// What an image file is read as.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Texels {
    Colours,
    Heights,
}

/// The statement that names an image first.
struct Request<'a> {
    map: Map<'a>,
    /// It names a channel, which is the image itself if that is grey.
    has_channel: bool,
}

/// An image of a kind that is read, or the kind that it is instead.
enum Decoded {
    Image { image: Texture, grey: bool },
    OtherFormat,
}

impl<'a> Textures<'a> {
    /// Notes the images of the scene's material number `index`.
    ///
    /// # Errors
    /// Faults, where they are to be errors.
    pub(crate) fn request(
        &mut self,
        stated: &Stated<'a>,
        index: usize,
        finder: &mut Finder,
        warnings: &mut Warnings,
    ) -> Result<(), SceneError> {
        let maps = [(stated.texture, Texels::Colours), (stated.bump, Texels::Heights)];
        for (map, texels) in maps.into_iter().filter_map(|(map, texels)| Some((map?, texels))) {
            let folder = map.library.folder();
            let mut statement = Statement::read(map.rest);
            // An option behind the name may be a part of it.
            let whole = Statement { name: without_options(map.rest), behind: "", ..statement };
            if whole != statement && finder.find(folder, whole.name).is_some_and(|found| found.exact) {
                statement = whole;
            }
            let options = statement.options(&map, warnings)?;
            let Some(found) = finder.find(folder, statement.name) else {
                let path = folder.join(statement.name.replace('\\', "/"));
                warnings.note("the surfaces have no image there", || {
                    map.error(format_args!("image \"{}\" no such file", path.display()))
                })?;
                continue;
            };
            if !found.exact {
                warnings.note("the file of a similar name is taken", || {
                    let (name, found) = (quoted(statement.name), found.path.display());
                    map.error(format_args!("there is no image {name}: there is \"{found}\""))
                })?;
            }
            let key = (found.path, texels);
            self.users.push((index, key.clone(), options.height));
            self.files.entry(key).or_insert(Request { map, has_channel: options.has_channel });
        }
        Ok(())
    }

    /// Decodes the images, on all cores, and writes their indices into `materials`.
    ///
    /// # Errors
    /// For the first image, in the order of the paths, that is broken.
    pub(crate) fn load(
        self,
        materials: &mut [Material],
        warnings: &mut Warnings,
    ) -> Result<Vec<Texture>, SceneError> {
        let files: Vec<_> = self.files.into_iter().collect();
        let decoded: Vec<_> = files
            .par_iter()
            .map(|((path, texels), Request { map, .. })| {
                decode(path, *texels)
                    .map_err(|reason| map.error(format_args!("image \"{}\" {reason}", path.display())))
            })
            .collect();
        // Results are gathered here, in order, so that the error is the same for any number of cores.
        let mut images = Vec::new();
        let mut index_of = BTreeMap::new();
        for ((key, Request { map, has_channel }), decoded) in files.into_iter().zip(decoded) {
            let path = key.0.display().to_string();
            match decoded? {
                Decoded::Image { image, grey } => {
                    if has_channel && !grey {
                        warnings.note("the whole colour is taken, or its brightness", || {
                            map.error(format_args!("-imfchan: image \"{path}\" has several channels"))
                        })?;
                    }
                    index_of.insert(key, images.len() as u32);
                    images.push(image);
                }
                Decoded::OtherFormat => warnings.note("images of other formats are left out", || {
                    map.error(format_args!("image \"{path}\" is neither PNG nor JPEG"))
                })?,
            }
        }
        for (material, key, height) in &self.users {
            let Some(&index) = index_of.get(key) else { continue };
            let material = &mut materials[*material];
            match key.1 {
                Texels::Colours => material.texture = Some(index),
                Texels::Heights => (material.bump, material.bump_height) = (Some(index), *height),
            }
        }
        Ok(images)
    }
}

/// Reads an image; its content says of which kind it is.
fn decode(path: &Path, texels: Texels) -> Result<Decoded, String> {
    let bytes = read_bytes(path).map_err(|error| error.to_string())?;
    let broken = |reason: &dyn std::fmt::Display| {
        let reason = reason.to_string().replace('\n', " ");
        format!("cannot be decoded ({reason}): a whole PNG or JPEG file is needed")
    };
    let format = image::guess_format(&bytes).ok();
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    match format {
        Some(ImageFormat::Png) => {}
        // The decoder fills in what is missing.
        Some(ImageFormat::Jpeg) if !has_jpeg_end(&bytes) => return Err(broken(&"its end is missing")),
        Some(ImageFormat::Jpeg) => {}
        Some(_) => return Ok(Decoded::OtherFormat),
        None if OTHER_FORMATS.split_whitespace().any(|other| ending.as_deref() == Some(other.as_ref())) => {
            return Ok(Decoded::OtherFormat);
        }
        None => {}
    }
    let decoded = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| broken(&error))?
        .decode()
        .map_err(|error| broken(&error))?;
    let (width, height) = (decoded.width(), decoded.height());
    let grey = !decoded.color().has_color();
    let (format, texels) = match texels {
        Texels::Colours => (TexelFormat::Rgba8, decoded.into_rgba8().into_raw()),
        Texels::Heights => (TexelFormat::Height8, decoded.into_luma8().into_raw()),
    };
    Ok(Decoded::Image { image: Texture { width, height, format, texels }, grey })
}

/// Whether a JPEG file has its last marker, EOI, behind the segments and scans before it (ITU-T T.81,
/// annex B).
fn has_jpeg_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let [mark, code, ..] = bytes[at.min(bytes.len())..] {
        match (mark, code) {
            (0xff, 0xd9) => return true,
            // Fill bytes, stuffed bytes and restarts.
            (0xff, 0xff) => at += 1,
            (0xff, 0x00 | 0x01 | 0xd0..=0xd7) => at += 2,
            (0xff, _) => {
                let Some(length) = bytes.get(at + 2..at + 4) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
            // Data of a scan, or bytes between segments, over which the decoder reads.
            _ => at += 1,
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jpeg_has_its_end_or_not() {
        let pixels: Vec<u8> = (0..64 * 64 * 3).map(|i: u32| (i * i / 7) as u8).collect();
        let mut bytes = Cursor::new(Vec::new());
        image::write_buffer_with_format(
            &mut bytes,
            &pixels,
            64,
            64,
            image::ExtendedColorType::Rgb8,
            ImageFormat::Jpeg,
        )
        .expect("an image");
        let whole = bytes.into_inner();
        assert!(has_jpeg_end(&whole));
        assert!(has_jpeg_end(&[&whole[..], b"more"].concat()));
        assert!((0..whole.len()).all(|length| !has_jpeg_end(&whole[..length])));
    }
}
