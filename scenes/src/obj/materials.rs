//! MTL files: the materials of an OBJ file. Only those that a face uses are read further than their
//! names, so that nothing is said about the others.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use saarcor_model::host::Material;

use super::lines::{Line, Lines, read};
use super::names::meanings;
use crate::error::SceneError;
use crate::text::{TextError, finite, quoted, split_keyword};
use crate::warning::Warnings;

/// Statements that say nothing of what a [`Material`] has, in small letters; `map_` may stand before.
const PASSED_OVER: &str = "ka ke tf km sharpness refl disp decal norm aat ns d tr pr pm ps pc pcr aniso anisor ks opacity \
    ao rma orm kn ni ct to kt";

/// An MTL file.
pub(crate) struct Library {
    path: PathBuf,
    text: String,
    /// Each `newmtl`, in the order of the file.
    definitions: Vec<Definition>,
}

/// Where in the file a material is defined.
#[derive(Clone, Copy)]
struct Definition {
    /// The line of `newmtl`, counted from 1, and where the line below it begins.
    line: usize,
    begin: usize,
    end: usize,
}

/// A statement `map_Kd` or `map_Bump` of a material.
#[derive(Clone, Copy)]
pub(crate) struct Map<'a> {
    pub(crate) library: &'a Library,
    pub(crate) line: usize,
    /// As it is usually written.
    pub(crate) keyword: &'static str,
    /// Options and file name.
    pub(crate) rest: &'a str,
}

impl Map<'_> {
    /// An error about the statement.
    pub(crate) fn error(&self, message: impl std::fmt::Display) -> SceneError {
        SceneError::at_line(&self.library.path, self.line, format!("{}: {message}", self.keyword))
    }
}

/// A material without its images, and the statements that name these.
pub(crate) struct Stated<'a> {
    pub(crate) material: Material,
    pub(crate) texture: Option<Map<'a>>,
    pub(crate) bump: Option<Map<'a>>,
}

impl Library {
    /// Reads an MTL file.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(crate) fn load(path: &Path, warnings: &mut Warnings) -> Result<Self, SceneError> {
        let text = read(path, |_| None, warnings)?;
        Self::parse(path, text, warnings)
    }

    /// Reads `text`, the content of `path`.
    ///
    /// # Errors
    /// Faults, where they are to be errors.
    pub(crate) fn parse(path: &Path, text: String, warnings: &mut Warnings) -> Result<Self, SceneError> {
        let mut definitions: Vec<Definition> = Vec::new();
        for line in Lines::new(&text) {
            let Some((keyword, _)) = split_keyword(line.text) else { continue };
            if keyword.eq_ignore_ascii_case("newmtl") {
                if let Some(last) = definitions.last_mut() {
                    last.end = line.begin;
                }
                let begin = line.begin + line.text.len();
                definitions.push(Definition { line: line.number, begin, end: text.len() });
            } else if definitions.is_empty() && !keyword.starts_with('#') {
                warnings.note("what stands there is passed over", || {
                    let reason = format!("{} stands above the first newmtl", shortened(keyword));
                    SceneError::at_line(path, line.number, reason)
                })?;
            }
        }
        Ok(Self { path: path.to_owned(), text, definitions })
    }

    /// The folder that names of images are relative to.
    pub(crate) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// The names of the materials, in the order of the file.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.definitions.iter().map(|definition| {
            let line = self.text[..definition.begin].rsplit(['\n', '\r']).next().unwrap_or_default();
            split_keyword(line).map_or("", |(_, name)| name)
        })
    }

    /// The material of this index. What the file does not state is as in [`Material::default`]; with an
    /// image texture the diffuse colour is white instead.
    ///
    /// `illum` 3, 5, 6 and 7 reflect the mean of `Ks`; 4, 6, 7 and 9 refract 1 − `d`, or `Tr` (Assumed:
    /// the models that the MTL format describes as ray traced reflection and as glass). An exponent of
    /// 0 says that there is no highlight, as exporters mean it.
    ///
    /// # Errors
    /// When a number is not finite; faults, where they are to be errors.
    pub(crate) fn material(&self, index: usize, warnings: &mut Warnings) -> Result<Stated<'_>, SceneError> {
        let Definition { line: above, begin, end } = self.definitions[index];
        let mut statements = Statements::of(self);
        for Line { number, text, .. } in Lines::new(&self.text[begin..end]) {
            if let Some((keyword, rest)) = split_keyword(text) {
                // The first line is the end of that of `newmtl`.
                statements.read(above + number - 1, keyword, rest, warnings)?;
            }
        }
        statements.material(above, warnings)
    }
}

/// What a material's statements say; the last of a keyword counts.
struct Statements<'a> {
    library: &'a Library,
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    shininess: Option<f32>,
    index_of_refraction: Option<f32>,
    dissolve: Option<f32>,
    transparency: Option<f32>,
    illumination_model: u8,
    texture: Option<Map<'a>>,
    bump: Option<Map<'a>>,
}

impl<'a> Statements<'a> {
    fn of(library: &'a Library) -> Self {
        Self {
            library,
            diffuse: None,
            specular: None,
            shininess: None,
            index_of_refraction: None,
            dissolve: None,
            transparency: None,
            illumination_model: 0,
            texture: None,
            bump: None,
        }
    }

    fn read(
        &mut self,
        line: usize,
        keyword: &str,
        rest: &'a str,
        warnings: &mut Warnings,
    ) -> Result<(), SceneError> {
        let place = Place { path: &self.library.path, line, keyword };
        let most = f32::MAX;
        let map = |keyword| Map { library: self.library, line, keyword, rest };
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => place.colour(rest, most, warnings)?.into_iter().for_each(|it| self.diffuse = Some(it)),
            "ks" => place.colour(rest, 1.0, warnings)?.into_iter().for_each(|it| self.specular = Some(it)),
            "ns" => place.number(rest, most, warnings)?.into_iter().for_each(|it| self.shininess = Some(it)),
            "d" => {
                let words = rest.strip_prefix("-halo").filter(|words| words.starts_with(char::is_whitespace));
                if words.is_some() {
                    let fault = || place.error("-halo: d is the same from all sides");
                    warnings.note("-halo is passed over", fault)?;
                }
                let number = place.number(words.unwrap_or(rest), 1.0, warnings)?;
                number.into_iter().for_each(|it| self.dissolve = Some(it));
            }
            "tr" => {
                place.number(rest, 1.0, warnings)?.into_iter().for_each(|it| self.transparency = Some(it))
            }
            "ni" => match finite(first_word(rest)) {
                Ok(..=0.0) => warnings.note("it is taken for 1", || {
                    place.error(format_args!("{}: more than 0 is needed", first_word(rest)))
                })?,
                _ => {
                    let number = place.number(rest, most, warnings)?;
                    number.into_iter().for_each(|it| self.index_of_refraction = Some(it));
                }
            },
            "illum" => match first_word(rest).parse::<f32>() {
                Ok(model) if model.fract() == 0.0 && (0.0..=10.0).contains(&model) => {
                    self.illumination_model = model as u8;
                }
                _ => warnings.note("neither reflection nor refraction is assumed", || {
                    place.error(format_args!("{}: a whole number from 0 to 10 is needed", quoted(rest)))
                })?,
            },
            "map_kd" | "map_bump" | "bump" if rest.is_empty() => {
                warnings.note("no image is assumed", || place.error(": the image's file name is missing"))?;
            }
            "map_kd" => self.texture = Some(map("map_Kd")),
            "map_bump" | "bump" => self.bump = Some(map("map_Bump")),
            other if is_passed_over(other.strip_prefix("map_").unwrap_or(other)) => {}
            _ if keyword.starts_with('#') => {}
            _ => warnings.note("statements that the MTL format does not have are passed over", || {
                SceneError::at_line(
                    &self.library.path,
                    line,
                    format!("{} is no statement", shortened(keyword)),
                )
            })?,
        }
        Ok(())
    }

    fn material(self, line: usize, warnings: &mut Warnings) -> Result<Stated<'a>, SceneError> {
        let default = Material::default();
        let fault = |message: String| SceneError::at_line(&self.library.path, line, message);
        let stated = self.specular.unwrap_or(default.specular);
        let shininess = self.shininess.unwrap_or(default.shininess);
        let untinted = if self.texture.is_some() { Vec3::ONE } else { default.diffuse };
        let reflection = if matches!(self.illumination_model, 3 | 5 | 6 | 7) { mean(stated) } else { 0.0 };
        let mut refraction = 0.0;
        if matches!(self.illumination_model, 4 | 6 | 7 | 9) {
            refraction = match (self.dissolve, self.transparency) {
                (Some(d), Some(tr)) if (1.0 - d - tr).abs() > AGREE => {
                    warnings.note("d is taken", || {
                        fault(format!("newmtl: d {d:?} and Tr {tr:?} contradict: Tr is 1 - d"))
                    })?;
                    1.0 - d
                }
                (_, Some(tr)) => tr,
                (Some(d), None) => 1.0 - d,
                (None, None) => 0.0,
            };
        }
        if reflection + refraction > 1.0 {
            warnings.note("it refracts what it does not reflect", || {
                fault(format!(
                    "newmtl: the material reflects {reflection:?} and refracts {refraction:?}, together \
                     more than 1"
                ))
            })?;
            refraction = 1.0 - reflection;
        }
        let material = Material {
            diffuse: self.diffuse.unwrap_or(untinted),
            specular: if shininess == 0.0 { Vec3::ZERO } else { stated },
            shininess,
            reflection,
            refraction,
            index_of_refraction: self.index_of_refraction.unwrap_or(default.index_of_refraction),
            ..default
        };
        Ok(Stated { material, texture: self.texture, bump: self.bump })
    }
}

/// Up to here `Tr` and 1 − `d` say the same, written with few digits.
const AGREE: f32 = 1e-3;

/// The mean of the three parts, exact where they are equal.
fn mean(colour: Vec3) -> f32 {
    (colour.as_dvec3().element_sum() / 3.0) as f32
}

/// A statement's place, for messages.
struct Place<'a> {
    path: &'a Path,
    line: usize,
    keyword: &'a str,
}

impl Place<'_> {
    /// An error that begins with the keyword.
    fn error(&self, message: impl std::fmt::Display) -> SceneError {
        let message = message.to_string();
        let space = if message.starts_with(':') { "" } else { " " };
        SceneError::at_line(self.path, self.line, format!("{}{space}{message}", self.keyword))
    }

    /// Three numbers, or one that stands for all three.
    fn colour(&self, rest: &str, most: f32, warnings: &mut Warnings) -> Result<Option<Vec3>, SceneError> {
        let words: Vec<&str> = words(rest).take(4).collect();
        let numbers = match words[..] {
            [grey] => [grey; 3],
            [red, green, blue, ..] => [red, green, blue],
            _ => {
                let fault = || self.error(format_args!("{}: 3 numbers are needed", quoted(rest)));
                warnings.note("the statement is passed over", fault)?;
                return Ok(None);
            }
        };
        let mut colour = [0.0; 3];
        for (part, word) in colour.iter_mut().zip(numbers) {
            match self.number(word, most, warnings)? {
                Some(number) => *part = number,
                None => return Ok(None),
            }
        }
        Ok(Some(colour.into()))
    }

    /// A number from 0 to `most`.
    fn number(&self, rest: &str, most: f32, warnings: &mut Warnings) -> Result<Option<f32>, SceneError> {
        let word = first_word(rest);
        match finite(word) {
            Ok(number) if number < 0.0 => {
                let range = if most < f32::MAX { format!("0 to {most}") } else { "0 or more".to_owned() };
                warnings.note("0 is taken", || self.error(format_args!("{word}: {range} is needed")))?;
                Ok(Some(0.0))
            }
            Ok(number) if number > most => {
                let fault = || self.error(format_args!("{word}: 0 to {most} is needed"));
                warnings.note("1 is taken", fault)?;
                Ok(Some(most))
            }
            Ok(number) => Ok(Some(number)),
            Err(reason @ TextError::NotFinite(_)) => Err(self.error(format_args!(": {reason}"))),
            Err(reason) => {
                warnings.note("the statement is passed over", || self.error(format_args!(": {reason}")))?;
                Ok(None)
            }
        }
    }
}

fn is_passed_over(keyword: &str) -> bool {
    PASSED_OVER.split_whitespace().any(|known| known == keyword)
}

/// The words of a statement of numbers, without a comment.
fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split('#').next().unwrap_or_default().split_whitespace()
}

fn first_word(rest: &str) -> &str {
    words(rest).next().unwrap_or_default()
}

/// A keyword as it can stand in a one-line message.
fn shortened(keyword: &str) -> String {
    if keyword.len() <= 12 { keyword.escape_debug().to_string() } else { quoted(keyword) }
}

/// The materials of several libraries by their names.
pub(crate) struct Names<'a> {
    libraries: &'a [Library],
    /// Library and material.
    exact: HashMap<&'a str, (usize, usize)>,
    /// By what else the names may mean; made when it is needed.
    meant: Option<HashMap<String, (usize, usize)>>,
}

impl<'a> Names<'a> {
    /// The materials of `libraries`. Where two have one name, the last is taken.
    pub(crate) fn new(libraries: &'a [Library]) -> Self {
        let all = libraries.iter().map(Library::names).enumerate();
        let exact = all.flat_map(|(library, names)| {
            names.enumerate().map(move |(material, name)| (name, (library, material)))
        });
        let exact = exact.collect();
        Self { libraries, exact, meant: None }
    }

    /// The material that `name` says; whether it says just its name.
    pub(crate) fn find(&mut self, name: &str) -> Option<((usize, usize), bool)> {
        if let Some(&found) = self.exact.get(name) {
            return Some((found, true));
        }
        let meant = self.meant.get_or_insert_with(|| {
            let mut meant = HashMap::new();
            for (library, names) in self.libraries.iter().map(Library::names).enumerate() {
                for (material, name) in names.enumerate() {
                    meant.extend(meanings(name).into_iter().map(|meaning| (meaning, (library, material))));
                }
            }
            meant
        });
        meanings(name).iter().find_map(|meaning| meant.get(meaning)).map(|&found| (found, false))
    }
}
