//! Texture textures and bump maps: which files the materials name, and their texels.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::ImageReader;
use rayon::prelude::*;
use saarcor_model::host::{Material, TexelFormat, Texture};

use crate::error::SceneError;
use crate::obj::materials::Library;
use crate::text::{finite, quoted, read_bytes};

/// The statements that name an image texture.
const TEXTURE_KEYWORDS: [&str; 1] = ["map_Kd"];
/// The statements that name a bump map.
const BUMP_KEYWORDS: [&str; 3] = ["map_Bump", "map_bump", "bump"];

/// The images that materials name, each once, and who named it first.
#[derive(Default)]
pub(crate) struct Textures<'a> {
    /// Sorted by path, so that the order of the images is that of their names.
    files: BTreeMap<(PathBuf, Texels), Request<'a>>,
    /// The materials that need their images' indices: material, and key of `files`.
    users: Vec<(usize, (PathBuf, Texels))>,
}

/// What an image file is read as.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Texels {
    Colours,
    Heights,
}

/// The statement of an MTL file that names an image.
struct Request<'a> {
    library: &'a Library,
    keywords: &'static [&'static str],
    rest: &'a str,
}

impl<'a> Textures<'a> {
    /// Notes the images of `source`, a material of `library` and the scene's material number
    /// `index`, and sets the bump map's height in `material`.
    ///
    /// # Errors
    ///
    /// When a statement has options other than `-bm`.
    pub(crate) fn request(
        &mut self,
        library: &'a Library,
        source: &'a tobj::Material,
        index: usize,
        material: &mut Material,
    ) -> Result<(), SceneError> {
        if let Some(rest) = &source.diffuse_texture {
            let request = Request { library, keywords: &TEXTURE_KEYWORDS, rest };
            let (_, name) = request.parse()?;
            self.insert(index, library.texture_path(name), Texels::Colours, request);
        }
        if let Some(rest) = &source.normal_texture {
            let request = Request { library, keywords: &BUMP_KEYWORDS, rest };
            let (height, name) = request.parse()?;
            material.bump_height = height;
            self.insert(index, library.texture_path(name), Texels::Heights, request);
        }
        Ok(())
    }

    fn insert(&mut self, user: usize, path: PathBuf, texels: Texels, request: Request<'a>) {
        let key = (path, texels);
        self.users.push((user, key.clone()));
        self.files.entry(key).or_insert(request);
    }

    /// The images' files.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.keys().map(|(path, _)| path.as_path())
    }

    /// Decodes the images, on all cores, and writes their indices into `materials`.
    ///
    /// # Errors
    ///
    /// For the first image, in the order of the paths, that is missing or broken.
    pub(crate) fn load(self, materials: &mut [Material]) -> Result<Vec<Texture>, SceneError> {
        let keys: Vec<_> = self.files.keys().collect();
        for (material, key) in &self.users {
            let image = keys.binary_search(&key).ok().map(|index| index as u32);
            match key.1 {
                Texels::Colours => materials[*material].texture = image,
                Texels::Heights => materials[*material].bump = image,
            }
        }
        let files: Vec<_> = self.files.into_iter().collect();
        let images: Vec<_> = files
            .par_iter()
            .map(|((path, texels), request)| {
                decode(path, *texels).map_err(|reason| {
                    let file = path.display();
                    request.error(format!("image \"{file}\" {reason}"))
                })
            })
            .collect();
        // Results are gathered here, in order, so that the error is the same for any number of cores.
        images.into_iter().collect()
    }
}

impl<'a> Request<'a> {
    /// The bump height and the file name.
    fn parse(&self) -> Result<(f32, &'a str), SceneError> {
        split_options(self.rest).map_err(|reason| self.error(reason))
    }

    fn error(&self, reason: String) -> SceneError {
        let message = format!("{}: {reason}", self.keywords[0]);
        self.library.error_at(self.keywords, self.rest, message)
    }
}

/// Splits what follows a `map` statement into the height of `-bm`, 1 where it is not stated, and
/// the file name, which may hold spaces.
fn split_options(rest: &str) -> Result<(f32, &str), String> {
    let Some((option, after)) = rest.split_once(char::is_whitespace) else {
        return Ok((1.0, rest));
    };
    match option {
        "-bm" => {
            let (height, name) = after
                .trim_start()
                .split_once(char::is_whitespace)
                .ok_or("-bm: a height and a file name are needed")?;
            let height = finite(height).map_err(|reason| format!("-bm: {reason}"))?;
            Ok((height, name.trim_start()))
        }
        _ if option.starts_with('-') => Err(format!(
            "option {} is not supported: only -bm is; apply it to the image or to vt",
            quoted(option)
        )),
        _ => Ok((1.0, rest)),
    }
}

/// Reads an image; its content says of which kind it is.
fn decode(path: &Path, texels: Texels) -> Result<Texture, String> {
    let bytes = read_bytes(path).map_err(|error| error.to_string())?;
    let broken = |error: &dyn std::fmt::Display| {
        let reason = error.to_string().replace('\n', " ");
        format!("cannot be decoded ({reason}): a whole PNG or JPEG file is needed")
    };
    let decoded = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| broken(&error))?
        .decode()
        .map_err(|error| broken(&error))?;
    let (width, height) = (decoded.width(), decoded.height());
    let (format, texels) = match texels {
        Texels::Colours => (TexelFormat::Rgba8, decoded.into_rgba8().into_raw()),
        Texels::Heights => (TexelFormat::Height8, decoded.into_luma8().into_raw()),
    };
    Ok(Texture { width, height, format, texels })
}
