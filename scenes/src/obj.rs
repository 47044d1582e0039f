//! Loads a scene from an OBJ file, its MTL files and images, and the CSV files beside it.

mod lines;
pub(crate) mod materials;
mod textures;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use saarcor_model::host::{Material, Scene, Triangle};

use crate::csv::{CAMERA_CSV, LIGHTS_CSV, read_cameras, read_lights};
use crate::error::SceneError;
use crate::overview::overview;
use crate::text::{quoted, read_text, split_keyword};
use lines::CheckedLines;
use materials::Library;
use textures::Textures;

/// Loads a scene.
///
/// * Faces are cut into fans of triangles around their first corner; triangles without area stay.
///   Points, lines, curves, groups and smoothing groups are passed over.
/// * Texture coordinates and normals are kept as they are. Where only some faces have them, the
///   others get zeros and the geometric normal, which also replaces normals of length zero.
/// * The materials are those of the MTL files, in their order; last, where there are faces without
///   one, [`Material::default`]. `illum` 3, 5, 6, 7 reflect the mean of `Ks`, and 4, 6, 7, 9 refract
///   1 − `d` (Assumed). A material that no face uses has no images.
/// * The images are those that a face with texture coordinates shows, sorted by their paths. Texels
///   are kept as stored, without gamma; a bump map's are the luma of its image.
/// * `camera.csv` and `lights.csv` are read from the OBJ's folder. Without the first the path is one
///   frame from [`overview`], without the second there are no lights.
///
/// # Errors
///
/// The first thing that is wrong in the files, with file and line; there are no partial scenes.
pub fn load_obj(path: &Path) -> Result<Scene, SceneError> {
    load_obj_and_files(path).map(|(scene, _)| scene)
}

/// [`load_obj`], and the files that the scene depends on: those it was read from, and those that were
/// looked for and do not exist.
///
/// # Errors
///
/// As there.
pub fn load_obj_and_files(path: &Path) -> Result<(Scene, Vec<PathBuf>), SceneError> {
    let mut files = vec![path.to_owned()];
    let text = read_text(path)?;
    let libraries = load_libraries(path, &text, &mut files)?;
    let sources: Vec<Source> = libraries
        .iter()
        .flat_map(|library| library.materials.iter().map(move |material| (library, material)))
        .collect();
    let meshes = read_meshes(path, &text, &sources)?;

    let mut scene = Scene::default();
    load_materials(&mut scene, &meshes, &sources, &mut files)?;
    add_triangles(&mut scene, &meshes);

    let folder = path.parent().unwrap_or(Path::new(""));
    let lights = folder.join(LIGHTS_CSV);
    if lights.exists() {
        scene.lights = read_lights(&lights)?;
    }
    let cameras = folder.join(CAMERA_CSV);
    files.extend([lights, cameras.clone()]);
    if cameras.exists() {
        scene.path = read_cameras(&cameras)?;
    } else {
        let camera = overview(&scene.triangles).ok_or_else(|| {
            let reason = "the scene is too large for a camera outside of it: add a camera.csv";
            SceneError::in_file(path, reason)
        })?;
        scene.path.push(camera);
    }
    Ok((scene, files))
}

/// A material as its file states it.
type Source<'a> = (&'a Library, &'a tobj::Material);

/// Loads the MTL files that the `mtllib` statements name. A statement names one file, whose name
/// may hold spaces, or several without. Adds to `files` those that were looked for.
fn load_libraries(path: &Path, text: &str, files: &mut Vec<PathBuf>) -> Result<Vec<Library>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut libraries = Vec::new();
    // Looking at the begin of a line is faster than splitting each one.
    let lines = text.lines().enumerate();
    for (index, line) in lines.filter(|(_, line)| line.trim_start().starts_with("mtllib")) {
        let Some(("mtllib", rest)) = split_keyword(line) else {
            continue;
        };
        let rest = rest.replace('\\', "/");
        let whole = folder.join(&rest);
        let names: Vec<&str> = if whole.is_file() {
            vec![&rest]
        } else {
            files.push(whole);
            rest.split_whitespace().collect()
        };
        if names.is_empty() {
            let reason = "mtllib: the MTL file's name is missing";
            return Err(SceneError::at_line(path, index + 1, reason));
        }
        for name in names {
            let file = folder.join(name);
            if !file.exists() {
                let reason = format!("mtllib: there is no MTL file {}", quoted(name));
                return Err(SceneError::at_line(path, index + 1, reason));
            }
            libraries.push(Library::load(&file)?);
            files.push(file);
        }
    }
    Ok(libraries)
}

/// Reads the triangles, as meshes of one material each; their materials are indices into
/// `sources`. Where two materials have one name, the last is taken.
fn read_meshes(path: &Path, text: &str, sources: &[Source]) -> Result<Vec<tobj::Mesh>, SceneError> {
    let index_of: HashMap<String, usize> =
        sources.iter().enumerate().map(|(index, (_, material))| (material.name.clone(), index)).collect();
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let (loaded, has_faces) = CheckedLines::new(path, text, &index_of).read(|statements| {
        tobj::load_obj_buf(statements, &options, |_| {
            let materials = sources.iter().map(|(_, material)| (*material).clone()).collect();
            Ok((materials, index_of.iter().map(|(name, index)| (name.clone(), *index)).collect()))
        })
    })?;
    let (models, _) = loaded.map_err(|error| SceneError::in_file(path, error.to_string()))?;
    if !has_faces {
        let reason = "empty OBJ: it has no faces (f), and a scene needs one at least";
        return Err(SceneError::in_file(path, reason));
    }
    let meshes: Vec<_> = models.into_iter().map(|model| model.mesh).collect();
    let triangles: usize = meshes.iter().map(|mesh| mesh.indices.len() / 3).sum();
    if u32::try_from(triangles).is_err() {
        let reason = format!("{triangles} triangles: a scene holds {} at most", u32::MAX);
        return Err(SceneError::in_file(path, reason));
    }
    Ok(meshes)
}

/// Adds the materials, and the images that the meshes show, to the scene, and the images' files to
/// `files`.
fn load_materials(
    scene: &mut Scene,
    meshes: &[tobj::Mesh],
    sources: &[Source],
    files: &mut Vec<PathBuf>,
) -> Result<(), SceneError> {
    let mut mapped = vec![false; sources.len()];
    let mut unnamed = false;
    for mesh in meshes.iter().filter(|mesh| !mesh.indices.is_empty()) {
        match mesh.material_id {
            Some(material) => mapped[material] |= !mesh.texcoords.is_empty(),
            None => unnamed = true,
        }
    }

    let mut textures = Textures::default();
    for (index, (library, source)) in sources.iter().enumerate() {
        let mut material = materials::material(source);
        if mapped[index] {
            textures.request(library, source, index, &mut material)?;
        }
        scene.materials.push(material);
    }
    files.extend(textures.files().map(Path::to_owned));
    scene.textures = textures.load(&mut scene.materials)?;
    if unnamed {
        scene.materials.push(Material::default());
    }
    Ok(())
}

/// Adds the meshes' triangles, texture coordinates and normals to the scene, which has its
/// materials; a mesh without one has the last.
fn add_triangles(scene: &mut Scene, meshes: &[tobj::Mesh]) {
    let mapped = meshes.iter().any(|mesh| !mesh.texcoords.is_empty());
    let smooth = meshes.iter().any(|mesh| !mesh.normals.is_empty());
    for mesh in meshes {
        let (positions, _) = mesh.positions.as_chunks::<3>();
        let (normals, _) = mesh.normals.as_chunks::<3>();
        let (tex_coords, _) = mesh.texcoords.as_chunks::<2>();
        let material = mesh.material_id.unwrap_or(scene.materials.len().saturating_sub(1)) as u32;
        for corners in mesh.indices.as_chunks::<3>().0 {
            let at = corners.map(|corner| corner as usize);
            let triangle = Triangle { corners: at.map(|i| Vec3::from(positions[i])), material };
            scene.triangles.push(triangle);
            if mapped {
                let given = |i: usize| tex_coords.get(i).map_or(Vec2::ZERO, |&uv| uv.into());
                scene.tex_coords.push(at.map(given));
            }
            if smooth {
                let given = |i: usize| normals.get(i).map(|&normal| Vec3::from(normal));
                scene.normals.push(at.map(|i| {
                    given(i)
                        .filter(|&normal| normal != Vec3::ZERO)
                        .unwrap_or_else(|| geometric_normal(&triangle))
                }));
            }
        }
    }
}

/// The unit normal of the triangle's plane, on the front side; upwards where it has no area.
fn geometric_normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or(glam::DVec3::Y).as_vec3()
}
