//! Writes a scene as an OBJ file, with its materials, images, camera path and lights beside it.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use glam::Vec3;
use image::ExtendedColorType;
use rayon::prelude::*;
use saarcor_model::host::{Material, Scene, TexelFormat, Texture};

use crate::csv::{CAMERA_CSV, LIGHTS_CSV, format_cameras, format_lights, parse_cameras, parse_lights};
use crate::error::SceneError;
use crate::obj::materials::Library;
use crate::warning::Warnings;

/// Writes `FILE.obj` (`path`), and beside it `FILE.mtl`, the images as `FILE-0.png` and so on,
/// `camera.csv` and `lights.csv`; files of these names are replaced. So a folder holds one scene.
///
/// [`load_obj`](crate::load_obj) gives back the same scene, bit for bit, but for what no triangle
/// shows: images that no material in use has are left out, and normals of length zero become
/// geometric ones. Numbers are the shortest decimals that give back the same f32. Equal positions,
/// texture coordinates and normals are written once, which makes the file smaller and the loading
/// faster by more than the search for them takes.
///
/// # Errors
///
/// When the path does not end in `.obj`, when a file cannot be written, and when the scene is one
/// that an OBJ file cannot hold: without triangles or camera path, with numbers that are not
/// finite or indices out of range, or with a material of which `reflection` is neither 0 nor the
/// mean of `specular`. No file is changed then; only where the complete files cannot be moved
/// into the folder, the ones already moved are removed again.
pub fn export_obj(scene: &Scene, path: &Path) -> Result<(), SceneError> {
    let unfit = |reason| SceneError::in_file(path, format!("the scene cannot be exported: {reason}"));
    let names = Names::new(path)?;
    let used = check_indices(scene).map_err(unfit)?;
    let shown = shown_images(scene, &used);
    let mtl = format_materials(scene, &used, |image| names.image(image, &shown));
    check_numbers(scene, &mtl).map_err(unfit)?;

    let staging = Staging::new(path)?;
    staging.write(&names.mtl(), |file| fs::write(file, mtl))?;
    staging.write(CAMERA_CSV, |file| fs::write(file, format_cameras(&scene.path)))?;
    staging.write(LIGHTS_CSV, |file| fs::write(file, format_lights(&scene.lights)))?;
    let images = (0u32..).zip(&scene.textures).zip(&shown).filter(|(_, shown)| **shown);
    let images: Vec<_> = images.map(|((index, image), _)| (names.image(index, &shown), image)).collect();
    images
        .par_iter()
        .map(|(name, image)| staging.write(name, |file| write_image(image, file)))
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<(), _>>()?;
    staging.write(&names.obj(), |file| {
        write_triangles(scene, &names.mtl(), BufWriter::new(File::create(file)?))
    })?;

    // The OBJ comes last: where it stands, the others do.
    let images = images.into_iter().map(|(name, _)| name);
    let others = [names.mtl(), CAMERA_CSV.to_owned(), LIGHTS_CSV.to_owned(), names.obj()];
    staging.publish(images.chain(others))
}

/// The names of the files, without their folder.
struct Names<'a> {
    stem: &'a str,
}

impl<'a> Names<'a> {
    fn new(path: &'a Path) -> Result<Self, SceneError> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let odd = |c: char| c.is_control() || c == '\\';
        match name.strip_suffix(".obj") {
            Some(stem) if !stem.is_empty() && stem.trim() == stem && !stem.contains(odd) => Ok(Self { stem }),
            _ => Err(SceneError::in_file(
                path,
                "the name must end in .obj, be UTF-8, and be without backslashes, control \
                 characters, and spaces at its ends",
            )),
        }
    }

    fn obj(&self) -> String {
        format!("{}.obj", self.stem)
    }

    fn mtl(&self) -> String {
        format!("{}.mtl", self.stem)
    }

    /// The file of an image. All names have as many digits, so that they sort as the images do:
    /// the loader numbers images in the order of their names.
    fn image(&self, index: u32, shown: &[bool]) -> String {
        let digits = shown.len().to_string().len();
        format!("{}-{index:0digits$}.png", self.stem)
    }
}

/// What the names of temporary files and folders begin with, of any process.
pub const TEMPORARY: &str = ".saarcor-";

/// What the names of this process's temporary files and folders begin with: whoever has the process ended by a signal
/// can remove them.
#[must_use]
pub fn temporary_prefix() -> String {
    format!("{TEMPORARY}{}-", std::process::id())
}

/// A folder beside the export, in which the files are completed before they are moved to their
/// places. It is removed at the end.
struct Staging<'a> {
    staged: tempfile::TempDir,
    folder: &'a Path,
}

impl<'a> Staging<'a> {
    /// A staging folder for the export to `path`.
    fn new(path: &'a Path) -> Result<Self, SceneError> {
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let staged =
            tempfile::Builder::new().prefix(&temporary_prefix()).tempdir_in(folder).map_err(|error| {
                let reason = format!("no file can be written to the folder ({})", error.kind());
                SceneError::in_file(path, reason)
            })?;
        Ok(Self { staged, folder })
    }

    /// Writes the file of this name with `write`.
    fn write<E: std::fmt::Display>(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), E>,
    ) -> Result<(), SceneError> {
        write(&self.staged.path().join(name)).map_err(|error| self.unwritable(name, error))
    }

    /// Moves the files of these names to their places, or none.
    fn publish(self, names: impl Iterator<Item = String>) -> Result<(), SceneError> {
        let mut published: Vec<PathBuf> = Vec::new();
        for name in names {
            let target = self.folder.join(&name);
            if let Err(error) = fs::rename(self.staged.path().join(&name), &target) {
                for file in published {
                    // Whether this works or not, the user must know of the first error.
                    let _ = fs::remove_file(file);
                }
                return Err(self.unwritable(&name, error));
            }
            published.push(target);
        }
        Ok(())
    }

    fn unwritable(&self, name: &str, error: impl std::fmt::Display) -> SceneError {
        SceneError::in_file(&self.folder.join(name), format!("cannot be written: {error}"))
    }
}

/// Which images a triangle shows: those of materials in use, where there are texture coordinates.
/// `used` says which materials are in use.
fn shown_images(scene: &Scene, used: &[bool]) -> Vec<bool> {
    let mut shown = vec![false; scene.textures.len()];
    if !scene.tex_coords.is_empty() {
        let used = scene.materials.iter().zip(used).filter(|(_, used)| **used);
        for image in used.flat_map(|(material, _)| [material.texture, material.bump]).flatten() {
            shown[image as usize] = true;
        }
    }
    shown
}

/// Checks the indices of a scene. Returns which materials triangles use.
fn check_indices(scene: &Scene) -> Result<Vec<bool>, String> {
    let mut used = vec![false; scene.materials.len()];
    for (index, triangle) in scene.triangles.iter().enumerate() {
        let material = triangle.material;
        *used
            .get_mut(material as usize)
            .ok_or_else(|| format!("triangle {index} has material {material}, which is not there"))? = true;
    }
    for (index, material) in scene.materials.iter().enumerate() {
        for (image, format) in [(material.texture, TexelFormat::Rgba8), (material.bump, TexelFormat::Height8)]
        {
            let Some(number) = image else { continue };
            match scene.textures.get(number as usize) {
                Some(image) if image.format == format => {}
                _ => {
                    return Err(format!(
                        "material {index} needs a {format:?} image, and image {number} is none"
                    ));
                }
            }
        }
    }
    Ok(used)
}

/// Checks that the numbers of a scene will read back the same, its materials as the MTL file `mtl`.
fn check_numbers(scene: &Scene, mtl: &str) -> Result<(), String> {
    if scene.triangles.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    for (name, count) in [("texture coordinates", scene.tex_coords.len()), ("normals", scene.normals.len())] {
        if count != 0 && count != scene.triangles.len() {
            return Err(format!("{count} triangles have {name}: all or none are needed"));
        }
    }
    let corners = scene.triangles.iter().flat_map(|triangle| triangle.corners);
    if !corners.chain(scene.normals.iter().copied().flatten()).all(|vector| vector.is_finite())
        || !scene.tex_coords.iter().flatten().all(|coordinates| coordinates.is_finite())
    {
        return Err("a position, normal or texture coordinate is not finite".to_owned());
    }

    let camera_csv = Path::new(CAMERA_CSV);
    let path = parse_cameras(camera_csv, &format_cameras(&scene.path)).map_err(one_line)?;
    if let Some(frame) = path.iter().zip(&scene.path).position(|(read, camera)| read != camera) {
        return Err(format!("frame {frame}: dir and up are not unit vectors at a right angle"));
    }
    parse_lights(Path::new(LIGHTS_CSV), &format_lights(&scene.lights)).map_err(one_line)?;

    let mut strict = Warnings::new(true);
    let library = Library::parse(Path::new("its MTL"), mtl.to_owned(), &mut strict).map_err(one_line)?;
    for (index, written) in scene.materials.iter().enumerate() {
        let read = library.material(index, &mut strict).map_err(one_line)?.material;
        let Material { texture, bump, bump_height, .. } = *written;
        if (Material { texture, bump, bump_height, ..read }) != *written {
            return Err(format!(
                "material {index}: reflection is {}, refraction {} and shininess {}; an MTL file can state a \
                 reflection that is 0 or the mean of specular, a refraction from 0 to 1 that is with it at \
                 most 1, and a shininess that is 0 only without highlights",
                written.reflection, written.refraction, written.shininess
            ));
        }
    }
    Ok(())
}

fn one_line(error: SceneError) -> String {
    error.to_string()
}

/// The MTL file, with a material for each of the scene's. `image` names the file of an image that
/// is written.
fn format_materials(scene: &Scene, used: &[bool], image: impl Fn(u32) -> String) -> String {
    let mut text = String::new();
    for (index, (material, used)) in scene.materials.iter().zip(used).enumerate() {
        let colour = |colour: Vec3| format!("{} {} {}", colour.x, colour.y, colour.z);
        let mut line = |statement: String| {
            text.push_str(&statement);
            text.push('\n');
        };
        line(format!("newmtl {}", material_name(index)));
        line(format!("Kd {}", colour(material.diffuse)));
        line(format!("Ks {}", colour(stated_specular(material))));
        line(format!("Ns {}", material.shininess));
        line(format!("Ni {}", material.index_of_refraction));
        line(format!("Tr {}", material.refraction));
        line(format!("illum {}", illumination_model(material)));
        if *used && !scene.tex_coords.is_empty() {
            if let Some(texture) = material.texture {
                line(format!("map_Kd {}", image(texture)));
            }
            if let Some(bump) = material.bump {
                line(format!("map_Bump -bm {} {}", material.bump_height, image(bump)));
            }
        }
    }
    text
}

/// The `Ks` of which the loader makes the same material: a mirror without highlights has an exponent of
/// 0, and reflects the mean of this colour.
fn stated_specular(material: &Material) -> Vec3 {
    match material.shininess == 0.0 && material.specular == Vec3::ZERO {
        true => Vec3::splat(material.reflection),
        false => material.specular,
    }
}

/// The name of the material of this index.
fn material_name(index: impl std::fmt::Display) -> String {
    format!("material{index}")
}

/// The MTL illumination model that the loader takes for the same reflection and refraction.
fn illumination_model(material: &Material) -> u8 {
    match (material.reflection != 0.0, material.refraction != 0.0) {
        (false, false) if material.specular == Vec3::ZERO => 1,
        (false, false) => 2,
        (true, false) => 3,
        (true, true) => 6,
        (false, true) => 9,
    }
}

/// Writes the image as a PNG file.
fn write_image(image: &Texture, path: &Path) -> image::ImageResult<()> {
    let colour = match image.format {
        TexelFormat::Rgba8 => ExtendedColorType::Rgba8,
        TexelFormat::Height8 => ExtendedColorType::L8,
    };
    let format = image::ImageFormat::Png;
    image::save_buffer_with_format(path, &image.texels, image.width, image.height, colour, format)
}

/// Writes the OBJ file: each corner's `v`, `vt` and `vn` stand above the first face that has them.
fn write_triangles(scene: &Scene, mtl: &str, mut out: impl Write) -> io::Result<()> {
    writeln!(out, "mtllib {mtl}")?;
    let mut positions = Statements::new("v");
    let mut tex_coords = Statements::new("vt");
    let mut normals = Statements::new("vn");
    let mut material = None;
    let mut face = String::new();
    for (index, triangle) in scene.triangles.iter().enumerate() {
        face.clear();
        for corner in 0..3 {
            let v = positions.index_of(triangle.corners[corner].to_array(), &mut out)?;
            let vt = match scene.tex_coords.get(index) {
                Some(uv) => Some(tex_coords.index_of(uv[corner].to_array(), &mut out)?),
                None => None,
            };
            let vn = match scene.normals.get(index) {
                Some(normal) => Some(normals.index_of(normal[corner].to_array(), &mut out)?),
                None => None,
            };
            match (vt, vn) {
                (None, None) => write!(face, " {v}"),
                (Some(vt), None) => write!(face, " {v}/{vt}"),
                (None, Some(vn)) => write!(face, " {v}//{vn}"),
                (Some(vt), Some(vn)) => write!(face, " {v}/{vt}/{vn}"),
            }
            .expect("a String takes all text");
        }
        if material.replace(triangle.material) != Some(triangle.material) {
            writeln!(out, "usemtl {}", material_name(triangle.material))?;
        }
        writeln!(out, "f{face}")?;
    }
    out.flush()
}

/// The statements of one keyword, each vector of N numbers written once. Vectors are equal where
/// their bits are.
struct Statements<const N: usize> {
    keyword: &'static str,
    indices: HashMap<[u32; N], usize>,
}

impl<const N: usize> Statements<N> {
    fn new(keyword: &'static str) -> Self {
        Self { keyword, indices: HashMap::new() }
    }

    /// The OBJ index of `vector`, which is written if it is new.
    fn index_of(&mut self, vector: [f32; N], out: &mut impl Write) -> io::Result<usize> {
        let next = self.indices.len() + 1;
        match self.indices.entry(vector.map(f32::to_bits)) {
            Entry::Occupied(entry) => Ok(*entry.get()),
            Entry::Vacant(entry) => {
                out.write_all(self.keyword.as_bytes())?;
                for number in vector {
                    write!(out, " {number}")?;
                }
                writeln!(out)?;
                Ok(*entry.insert(next))
            }
        }
    }
}
