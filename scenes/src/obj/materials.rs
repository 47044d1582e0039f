//! MTL files: the materials of an OBJ file.
//!
//! tobj reads the file; [`check`] stands before it, for what tobj lets pass or stumbles over
//! (colours of fewer than three numbers, numbers that are not finite or out of range) and for the
//! line numbers.

use std::path::{Path, PathBuf};

use glam::Vec3;
use saarcor_model::host::Material;

use crate::error::SceneError;
use crate::text::{finite, quoted, read_text, split_keyword};

/// An MTL file and its materials, in the order of the file.
pub(crate) struct Library {
    path: PathBuf,
    text: String,
    /// The materials as tobj gives them.
    pub(crate) materials: Vec<tobj::Material>,
}

impl Library {
    /// Reads an MTL file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, and for the first statement of it that is wrong.
    pub(crate) fn load(path: &Path) -> Result<Self, SceneError> {
        Self::parse(path, read_text(path)?)
    }

    /// Reads `text`, the content of `path`.
    ///
    /// # Errors
    ///
    /// For the first statement that is wrong.
    pub(crate) fn parse(path: &Path, text: String) -> Result<Self, SceneError> {
        check(path, &text)?;
        let mut unread = text.as_bytes();
        let materials = tobj::load_mtl_buf(&mut unread).map_err(|error| {
            let read = &text.as_bytes()[..text.len() - unread.len()];
            let line = read.iter().filter(|&&byte| byte == b'\n').count().max(1);
            SceneError::at_line(path, line, error.to_string())
        });
        let (materials, _) = materials?;
        Ok(Self { path: path.to_owned(), text, materials })
    }

    /// The file that a `map` statement means by `name`: relative to the MTL file's folder,
    /// with either kind of slash.
    pub(crate) fn texture_path(&self, name: &str) -> PathBuf {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        folder.join(name.replace('\\', "/"))
    }

    /// An error about the statement whose keyword one of `keywords` is, and whose rest is `rest`.
    pub(crate) fn error_at(&self, keywords: &[&str], rest: &str, message: String) -> SceneError {
        let found = self.text.lines().position(|line| {
            split_keyword(line).is_some_and(|(key, found)| keywords.contains(&key) && found == rest)
        });
        SceneError { path: self.path.clone(), line: found.map(|index| index + 1), message }
    }
}

/// The material without its images. What the file does not state is as in
/// [`Material::default`]; with an image texture the diffuse colour is white instead.
///
/// `illum` 3, 5, 6 and 7 reflect the mean of `Ks`; 4, 6, 7 and 9 refract `Tr`, which is 1 − `d`
/// (Assumed: the models that the MTL format describes as ray traced reflection and as glass).
pub(crate) fn material(source: &tobj::Material) -> Material {
    let default = Material::default();
    let specular = source.specular.map_or(default.specular, Vec3::from);
    let untinted = if source.diffuse_texture.is_some() { Vec3::ONE } else { default.diffuse };
    let illum = source.illumination_model.unwrap_or_default();
    Material {
        diffuse: source.diffuse.map_or(untinted, Vec3::from),
        specular,
        shininess: source.shininess.unwrap_or(default.shininess),
        reflection: if matches!(illum, 3 | 5 | 6 | 7) { mean(specular) } else { 0.0 },
        refraction: if matches!(illum, 4 | 6 | 7 | 9) { transparency(source) } else { 0.0 },
        index_of_refraction: source.optical_density.unwrap_or(default.index_of_refraction),
        ..default
    }
}

/// The mean of the three parts, exact where they are equal.
fn mean(colour: Vec3) -> f32 {
    (colour.as_dvec3().element_sum() / 3.0) as f32
}

/// `Tr`, or 1 − `d`; both at once are not expected to differ, and `Tr` is taken.
fn transparency(source: &tobj::Material) -> f32 {
    source
        .unknown_param
        .get("Tr")
        .and_then(|words| words.split_whitespace().next()?.parse().ok())
        .or(source.dissolve.map(|dissolve| 1.0 - dissolve))
        .unwrap_or(0.0)
}

/// Checks the statements that a [`Material`] is made from.
fn check(path: &Path, text: &str) -> Result<(), SceneError> {
    let mut named = false;
    for (index, line) in text.lines().enumerate() {
        let Some((keyword, rest)) = split_keyword(line) else { continue };
        named |= keyword == "newmtl";
        check_statement(keyword, rest, named)
            .map_err(|message| SceneError::at_line(path, index + 1, message))?;
    }
    Ok(())
}

/// Checks one statement; `named` says whether it belongs to a material.
fn check_statement(keyword: &str, rest: &str, named: bool) -> Result<(), String> {
    match keyword {
        "newmtl" if rest.is_empty() => Err("newmtl: the material's name is missing".to_owned()),
        "Ka" | "Kd" | "Ks" | "Ke" => check_numbers(keyword, rest, 3, 0.0..=f32::MAX),
        "Ns" => check_numbers(keyword, rest, 1, 0.0..=f32::MAX),
        "Ni" => check_numbers(keyword, rest, 1, f32::MIN_POSITIVE..=f32::MAX),
        "d" | "Tr" => check_numbers(keyword, rest, 1, 0.0..=1.0),
        "illum" => match rest.split_whitespace().next().map(str::parse::<u8>) {
            Some(Ok(0..=10)) => Ok(()),
            _ => Err(format!("illum {}: a whole number from 0 to 10 is needed", quoted(rest))),
        },
        "map_Kd" | "map_Bump" | "map_bump" | "bump" if rest.is_empty() => {
            Err(format!("{keyword}: the image's file name is missing"))
        }
        "newmtl" | "map_Kd" | "map_Bump" | "map_bump" | "bump" => Ok(()),
        _ => return Ok(()),
    }?;
    if named { Ok(()) } else { Err(format!("{keyword} stands above the first newmtl")) }
}

/// Checks that `rest` begins with `count` numbers inside `range`.
fn check_numbers(
    keyword: &str,
    rest: &str,
    count: usize,
    range: std::ops::RangeInclusive<f32>,
) -> Result<(), String> {
    let mut words = rest.split_whitespace();
    for _ in 0..count {
        let word =
            words.next().ok_or_else(|| format!("{keyword} {}: {count} numbers are needed", quoted(rest)))?;
        let number = finite(word).map_err(|reason| format!("{keyword}: {reason}"))?;
        if !range.contains(&number) {
            let (least, most) = range.into_inner();
            return Err(match most {
                f32::MAX if least > 0.0 => format!("{keyword} {word}: more than 0 is needed"),
                f32::MAX => format!("{keyword} {word}: 0 or more is needed"),
                _ => format!("{keyword} {word}: {least} to {most} is needed"),
            });
        }
    }
    Ok(())
}
