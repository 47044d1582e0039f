//! Loads a scene from an OBJ file, its MTL files and images, and the CSV files beside it.

mod formats;
mod lines;
mod map_options;
pub(crate) mod materials;
mod names;
mod polygon;
mod statements;
mod textures;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec2, Vec3};
use saarcor_model::host::{Material, Scene, Triangle};

use crate::csv::{CAMERA_CSV, LIGHTS_CSV, read_cameras, read_lights};
use crate::error::SceneError;
use crate::overview::overview;
use crate::text::quoted;
use crate::warning::{Warning, Warnings};
use materials::{Library, Names};
use names::Finder;
use polygon::{Cutter, LONGEST, Uncut};
use statements::{Corner, Face, NONE, Statements};
use textures::Textures;

/// How a scene is loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Read no images: surfaces have no textures and bump maps.
    pub no_textures: bool,
    /// Refuse what else would be a [`Warning`].
    pub strict: bool,
}

/// What was loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// The files that it depends on: those it was read from, and those that were looked for and do not
    /// exist.
    pub files: Vec<PathBuf>,
    /// What was assumed, one of a kind.
    pub warnings: Vec<Warning>,
}

/// Loads a scene.
///
/// * Faces are cut into triangles: into a fan around their first corner where that covers the face, else
///   by their ears. Triangles without area stay. Points, lines, curves, groups and smoothing groups are
///   passed over.
/// * Texture coordinates and normals are kept as they are. Where only some faces have them, the
///   others get zeros and the geometric normal, which also replaces normals of length zero.
/// * The materials are those of the MTL files that a face uses, in their order; last, where there are
///   faces without one, [`Material::default`]. `illum` 3, 5, 6, 7 reflect the mean of `Ks`, and 4, 6, 7,
///   9 refract 1 − `d` (Assumed). Of the others nothing but their names is read.
/// * The images are those that a face with texture coordinates shows, sorted by their paths. Texels
///   are kept as stored, without gamma; a bump map's are the luma of its image.
/// * `camera.csv` and `lights.csv` are read from the OBJ's folder. Without the first the path is one
///   frame from [`overview`], without the second there are no lights.
///
/// What other programs read although it is not as the formats say is read too, with a warning.
///
/// # Errors
///
/// The first thing that is wrong in the files, with file and line; there are no partial scenes.
pub fn load_obj(path: &Path, options: LoadOptions) -> Result<Loaded, SceneError> {
    let mut warnings = Warnings::new(options.strict);
    let mut finder = Finder::default();
    let text = lines::read(path, formats::refusal, &mut warnings)?;
    let mut statements = Statements::read(path, &text, &mut warnings)?;
    if statements.faces.is_empty() {
        let reason = "empty OBJ: it has no faces (f), and a scene needs one at least";
        return Err(SceneError::in_file(path, reason));
    }
    statements.resolve(path, &mut warnings)?;

    let libraries = load_libraries(path, &statements.libraries, &mut finder, &mut warnings)?;
    let materials_of = find_materials(path, &statements, &libraries, &mut warnings)?;
    let mut scene = Scene::default();
    let material_of = load_materials(
        &mut scene,
        &statements,
        &libraries,
        &materials_of,
        (!options.no_textures).then_some(&mut finder),
        &mut warnings,
    )?;
    add_triangles(&mut scene, path, &statements, &material_of, &mut warnings)?;

    let folder = path.parent().unwrap_or(Path::new(""));
    let [lights, cameras] = [LIGHTS_CSV, CAMERA_CSV].map(|name| folder.join(name));
    if lights.exists() {
        scene.lights = read_lights(&lights)?;
    }
    if cameras.exists() {
        scene.path = read_cameras(&cameras)?;
    } else {
        let camera = overview(&scene.triangles).ok_or_else(|| {
            let reason = "the scene is too large for a camera outside of it: add a camera.csv";
            SceneError::in_file(path, reason)
        })?;
        scene.path.push(camera);
    }
    let files = [path.to_owned(), lights, cameras].into_iter().chain(finder.looked_for()).collect();
    Ok(Loaded { scene, files, warnings: warnings.found() })
}

/// Loads the MTL files that the `mtllib` statements name, each file once. A statement names one file,
/// whose name may hold spaces, or several.
fn load_libraries(
    path: &Path,
    statements: &[(&str, usize)],
    finder: &mut Finder,
    warnings: &mut Warnings,
) -> Result<Vec<Library>, SceneError> {
    /// Statements of different names: more are no mistake of an exporter.
    const MOST: usize = 1024;

    let folder = path.parent().unwrap_or(Path::new(""));
    let mut libraries = Vec::new();
    let mut loaded = HashSet::new();
    if let Some(&(_, line)) = statements.get(MOST) {
        let reason = format!("mtllib: {MOST} statements with different names are possible at most");
        return Err(SceneError::at_line(path, line, reason));
    }
    for &(rest, line) in statements {
        let at_line = |message: String| SceneError::at_line(path, line, message);
        let (files, missing) = find_libraries(folder, rest, finder);
        for (name, found) in files {
            if !found.exact || name.contains(char::is_whitespace) && name != rest {
                warnings.note("that file is taken", || {
                    at_line(format!(
                        "mtllib: {} is no file: there is \"{}\"",
                        quoted(rest),
                        found.path.display()
                    ))
                })?;
            }
            if loaded.insert(found.path.canonicalize().unwrap_or_else(|_| found.path.clone())) {
                libraries.push(Library::load(&found.path, warnings)?);
            }
        }
        for name in missing {
            warnings.note("its materials are not defined", || {
                at_line(match name {
                    "" => "mtllib: the MTL file's name is missing".to_owned(),
                    _ => format!("mtllib: there is no MTL file {}", quoted(name)),
                })
            })?;
        }
    }
    Ok(libraries)
}

/// The MTL files that a statement names, and the words in it that name none.
fn find_libraries<'a>(
    folder: &Path,
    rest: &'a str,
    finder: &mut Finder,
) -> (Vec<(&'a str, names::Found)>, Vec<&'a str>) {
    /// Words of the longest name among several, and of all together.
    const MOST_WORDS: usize = 8;
    const MOST_IN_ALL: usize = 256;

    if let Some(found) = finder.find(folder, rest) {
        return (vec![(rest, found)], Vec::new());
    }
    let data = rest.split(" #").next().unwrap_or_default();
    let offset = |word: &str| word.as_ptr().addr() - data.as_ptr().addr();
    let words: Vec<(usize, usize)> =
        data.split_whitespace().map(|word| (offset(word), offset(word) + word.len())).collect();
    if words.len() > MOST_IN_ALL {
        return (Vec::new(), vec![rest]);
    }
    let (mut files, mut missing) = (Vec::new(), Vec::new());
    let mut at = 0;
    while at < words.len() {
        let ends = (at..words.len().min(at + MOST_WORDS)).rev();
        let found = ends.into_iter().find_map(|last| {
            let name = &data[words[at].0..words[last].1];
            finder.find(folder, name).map(|found| (last, name, found))
        });
        match found {
            Some((last, name, found)) => {
                files.push((name, found));
                at = last + 1;
            }
            None => {
                missing.push(&data[words[at].0..words[at].1]);
                at += 1;
            }
        }
    }
    // Without any, they are one name as well as several.
    if files.is_empty() { (files, vec![rest]) } else { (files, missing) }
}

/// The material of each of the statements' names that faces have: library and material, or none for
/// [`Material::default`].
fn find_materials(
    path: &Path,
    statements: &Statements,
    libraries: &[Library],
    warnings: &mut Warnings,
) -> Result<Vec<Option<(usize, usize)>>, SceneError> {
    let mut is_used = vec![false; statements.names.len()];
    for face in statements.faces.iter().filter(|face| face.name != NONE) {
        is_used[face.name as usize] = true;
    }
    let mut materials = Names::new(libraries);
    let names = statements.names.iter().zip(is_used);
    names
        .map(|(&(name, line), is_used)| {
            let found = if is_used { materials.find(name) } else { return Ok(None) };
            let at_line = |message: String| SceneError::at_line(path, line, message);
            match found {
                Some((_, true)) => {}
                Some((_, false)) => warnings.note("the material of a similar name is taken", || {
                    at_line(format!("usemtl: material {} is not defined by just that name", quoted(name)))
                })?,
                None => warnings.note("the default material is taken", || {
                    at_line(match name {
                        "" => "usemtl: the material's name is missing".to_owned(),
                        _ => format!(
                            "usemtl: material {} is not defined by any MTL file that the OBJ names (mtllib)",
                            quoted(name)
                        ),
                    })
                })?,
            }
            Ok(found.map(|(material, _)| material))
        })
        .collect()
}

/// Adds the materials that faces use to the scene, and the images that they show unless there is no
/// `finder`. Returns the material of each of the statements' names, and last of faces without one.
fn load_materials(
    scene: &mut Scene,
    statements: &Statements,
    libraries: &[Library],
    materials_of: &[Option<(usize, usize)>],
    mut finder: Option<&mut Finder>,
    warnings: &mut Warnings,
) -> Result<Vec<u32>, SceneError> {
    // Library and material, in the order of the files, and whether a face with it is mapped.
    let mut used: BTreeMap<(usize, usize), bool> = BTreeMap::new();
    let mut unnamed = false;
    for (face, corners) in faces(statements) {
        let material = materials_of.get(face.name as usize).copied().flatten();
        match material {
            Some(material) => *used.entry(material).or_default() |= corners[0][1] != NONE,
            None => unnamed = true,
        }
    }
    let mut textures = Textures::default();
    let mut index_of = HashMap::new();
    for ((library, index), is_mapped) in used {
        let stated = libraries[library].material(index, warnings)?;
        let material = scene.materials.len();
        if let Some(finder) = finder.as_mut().filter(|_| is_mapped) {
            textures.request(&stated, material, finder, warnings)?;
        }
        scene.materials.push(stated.material);
        index_of.insert((library, index), material as u32);
    }
    scene.textures = textures.load(&mut scene.materials, warnings)?;
    let default = scene.materials.len() as u32;
    if unnamed {
        scene.materials.push(Material::default());
    }
    let index_of = |material: Option<(usize, usize)>| {
        material.and_then(|material| index_of.get(&material)).copied().unwrap_or(default)
    };
    Ok(materials_of.iter().copied().chain([None]).map(index_of).collect())
}

/// The faces with their corners.
fn faces<'a>(statements: &'a Statements) -> impl Iterator<Item = (&'a Face, &'a [Corner])> {
    let begins = std::iter::once(0).chain(statements.faces.iter().map(|face| face.end));
    let faces = statements.faces.iter().zip(begins);
    faces.map(|(face, begin)| (face, &statements.corners[begin..face.end]))
}

/// Adds the faces' triangles, texture coordinates and normals to the scene. `material_of` each name,
/// and last of faces without one.
fn add_triangles(
    scene: &mut Scene,
    path: &Path,
    statements: &Statements,
    material_of: &[u32],
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    let triangles = statements.corners.len() - 2 * statements.faces.len();
    if u32::try_from(triangles).is_err() {
        let reason = format!("{triangles} triangles: a scene holds {} at most", u32::MAX);
        return Err(SceneError::in_file(path, reason));
    }
    let [mapped, smooth] = [1, 2].map(|part| statements.corners.iter().any(|corner| corner[part] != NONE));
    scene.triangles.reserve(triangles);
    let mut cutter = Cutter::default();
    let mut positions = Vec::new();
    for (face, corners) in faces(statements) {
        let material = material_of[(face.name as usize).min(material_of.len() - 1)];
        let mut add = |triangle: [Corner; 3]| {
            let corners = triangle.map(|[v, ..]| statements.positions[v as usize]);
            let added = Triangle { corners, material };
            scene.triangles.push(added);
            if mapped {
                let given = |[_, vt, _]: Corner| statements.tex_coords.get(vt as usize).copied();
                scene.tex_coords.push(triangle.map(|corner| given(corner).unwrap_or(Vec2::ZERO)));
            }
            if smooth {
                let given = |[.., vn]: Corner| statements.normals.get(vn as usize).copied();
                scene.normals.push(triangle.map(|corner| {
                    given(corner)
                        .filter(|&normal| normal != Vec3::ZERO)
                        .unwrap_or_else(|| geometric_normal(&added))
                }));
            }
        };
        if let &[a, b, c] = corners {
            add([a, b, c]);
            continue;
        }
        positions.clear();
        positions.extend(corners.iter().map(|[v, ..]| statements.positions[*v as usize]));
        let (triangles, uncut) = cutter.cut(&positions);
        let at_line = |message| SceneError::at_line(path, face.line, message);
        match uncut {
            None => {}
            Some(Uncut::CrossesItself) => warnings
                .note("it is cut into a fan around its first corner", || {
                    at_line("f: the face crosses itself, so that its inside is not defined".to_owned())
                })?,
            Some(Uncut::TooMany) => {
                let reason = "f: too many corners of faces that are not convex: cut the faces into triangles";
                return Err(at_line(reason.to_owned()));
            }
            Some(Uncut::TooLong) => {
                return Err(at_line(format!(
                    "f has {} corners and is not convex: fewer than {LONGEST} are possible; cut it into smaller faces",
                    corners.len()
                )));
            }
        }
        triangles.iter().for_each(|triangle| add(triangle.map(|corner| corners[corner as usize])));
    }
    Ok(())
}

/// The unit normal of the triangle's plane, on the front side; upwards where it has no area.
fn geometric_normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3()
}
