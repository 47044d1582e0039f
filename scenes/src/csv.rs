//! `camera.csv` and `lights.csv`: the camera path and the lights of a scene.
//!
//! Both begin with a header line, have a row a line, commas between the fields, and no quotes.

use std::fmt::Write;
use std::path::Path;

use glam::{DVec3, Vec3};
use saarcor_model::host::{Camera, Light};

use crate::error::SceneError;
use crate::text::{finite, quoted, read_text};

/// The name of the camera path's file.
pub(crate) const CAMERA_CSV: &str = "camera.csv";

/// The name of the lights' file.
pub(crate) const LIGHTS_CSV: &str = "lights.csv";

/// The columns of `camera.csv`: the frame, counted from 0, and the fields of [`Camera`].
const CAMERA_COLUMNS: [&str; 11] =
    ["frame", "eye_x", "eye_y", "eye_z", "dir_x", "dir_y", "dir_z", "up_x", "up_y", "up_z", "fov_y_deg"];

/// The columns of `lights.csv`: the fields of [`Light`].
const LIGHT_COLUMNS: [&str; 4] = ["x", "y", "z", "intensity"];

/// How far from 1 the length of `dir` and `up`, and from 0 the cosine between them, may be.
/// Such rows are corrected: they come from numbers written with few digits.
const TOLERANCE: f64 = 1e-3;

/// Up to here the difference is that of vectors made with f32 arithmetic, which takes a few
/// roundings for a product and for a length, and the row stays as it is.
const ROUNDING: f64 = 8.0 * f32::EPSILON as f64;

/// Reads a camera path: a header, then a row a frame, in order from frame 0.
///
/// `dir` and `up` are unit vectors at a right angle; where they miss that by at most 10⁻³ they are
/// corrected, `up` by the least turn.
///
/// # Errors
///
/// For the first row that is wrong, with line and field, and where there is no frame.
pub fn read_cameras(path: &Path) -> Result<Vec<Camera>, SceneError> {
    parse_cameras(path, &read_text(path)?)
}

/// Reads lights: a header, then a row a light; no rows, no lights.
///
/// # Errors
///
/// For the first row that is wrong, with line and field.
pub fn read_lights(path: &Path) -> Result<Vec<Light>, SceneError> {
    parse_lights(path, &read_text(path)?)
}

/// Reads a camera path from `text`, the content of `path`.
pub(crate) fn parse_cameras(path: &Path, text: &str) -> Result<Vec<Camera>, SceneError> {
    let mut cameras = Vec::new();
    for row in rows(path, text, CAMERA_COLUMNS)? {
        let row = row?;
        let frame = row.fields[0];
        if frame.parse() != Ok(cameras.len()) {
            return Err(row.error(format!(
                "frame {}: {} is needed, as frames count from 0 without gaps",
                quoted(frame),
                cameras.len()
            )));
        }
        let (dir, up) = directions(row.vector(4)?, row.vector(7)?).map_err(|e| row.error(e))?;
        let fov_y_deg = row.number(10)?;
        if fov_y_deg <= 0.0 || fov_y_deg >= 180.0 {
            let reason = format!("fov_y_deg {fov_y_deg}: more than 0 and less than 180 is needed");
            return Err(row.error(reason));
        }
        cameras.push(Camera { eye: row.vector(1)?, dir, up, fov_y_deg });
    }
    if cameras.is_empty() {
        return Err(SceneError::in_file(path, "has no frames: a row is needed at least"));
    }
    Ok(cameras)
}

/// Reads lights from `text`, the content of `path`.
pub(crate) fn parse_lights(path: &Path, text: &str) -> Result<Vec<Light>, SceneError> {
    rows(path, text, LIGHT_COLUMNS)?
        .map(|row| {
            let row = row?;
            let intensity = row.number(3)?;
            if intensity < 0.0 {
                return Err(row.error(format!("intensity {intensity}: 0 or more is needed")));
            }
            Ok(Light { position: row.vector(0)?, intensity })
        })
        .collect()
}

/// The text of a `camera.csv`.
pub(crate) fn format_cameras(cameras: &[Camera]) -> String {
    let mut text = CAMERA_COLUMNS.join(",");
    for (frame, camera) in cameras.iter().enumerate() {
        let [eye, dir, up] = [camera.eye, camera.dir, camera.up].map(format_vector);
        write!(text, "\n{frame},{eye},{dir},{up},{}", camera.fov_y_deg).expect("a String takes all text");
    }
    text.push('\n');
    text
}

/// The text of a `lights.csv`.
pub(crate) fn format_lights(lights: &[Light]) -> String {
    let mut text = LIGHT_COLUMNS.join(",");
    for light in lights {
        write!(text, "\n{},{}", format_vector(light.position), light.intensity)
            .expect("a String takes all text");
    }
    text.push('\n');
    text
}

fn format_vector(vector: Vec3) -> String {
    format!("{},{},{}", vector.x, vector.y, vector.z)
}

/// A row of N fields.
struct CsvRow<'a, const N: usize> {
    path: &'a Path,
    line: usize,
    columns: [&'static str; N],
    fields: [&'a str; N],
}

/// The rows below the header, which must name `columns`. Empty lines are passed over.
fn rows<'a, const N: usize>(
    path: &'a Path,
    text: &'a str,
    columns: [&'static str; N],
) -> Result<impl Iterator<Item = Result<CsvRow<'a, N>, SceneError>>, SceneError> {
    let header = columns.join(",");
    let mut lines = text.lines().enumerate();
    let found = lines.next().map_or("", |(_, line)| line);
    if !found.split(',').map(str::trim).eq(columns) {
        let reason = format!("the header is {}: {header} is needed", quoted(found));
        return Err(SceneError::at_line(path, 1, reason));
    }
    Ok(lines.filter(|(_, line)| !line.trim().is_empty()).map(move |(index, text)| {
        let line = index + 1;
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let fields = fields.try_into().map_err(|fields: Vec<&str>| {
            let reason = format!("{} fields: {N} are needed ({header})", fields.len());
            SceneError::at_line(path, line, reason)
        })?;
        Ok(CsvRow { path, line, columns, fields })
    }))
}

impl<const N: usize> CsvRow<'_, N> {
    fn error(&self, message: String) -> SceneError {
        SceneError::at_line(self.path, self.line, message)
    }

    fn number(&self, column: usize) -> Result<f32, SceneError> {
        finite(self.fields[column])
            .map_err(|reason| self.error(format!("{}: {reason}", self.columns[column])))
    }

    fn vector(&self, column: usize) -> Result<Vec3, SceneError> {
        let [x, y, z] = [column, column + 1, column + 2].map(|column| self.number(column));
        Ok(Vec3::new(x?, y?, z?))
    }
}

/// Checks that `dir` and `up` are unit vectors at a right angle, and corrects small differences.
fn directions(dir: Vec3, up: Vec3) -> Result<(Vec3, Vec3), String> {
    let (exact_dir, exact_up) = (dir.as_dvec3(), up.as_dvec3());
    let stretch = |vector: DVec3| (vector.length() - 1.0).abs();
    for (name, vector) in [("dir", exact_dir), ("up", exact_up)] {
        if stretch(vector) > TOLERANCE {
            let length = vector.length() as f32;
            return Err(format!("{name} has length {length}: a unit vector is needed"));
        }
    }
    let cosine = exact_dir.dot(exact_up);
    if cosine.abs() > TOLERANCE {
        let angle = libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees() as f32;
        return Err(format!("dir and up meet at {angle} degrees: a right angle is needed"));
    }
    if stretch(exact_dir).max(stretch(exact_up)).max(cosine.abs()) <= ROUNDING {
        return Ok((dir, up));
    }
    let dir = exact_dir.normalize();
    let up = exact_up.reject_from_normalized(dir).normalize();
    Ok((dir.as_vec3(), up.as_vec3()))
}
