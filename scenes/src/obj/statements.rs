//! The statements of an OBJ file that make triangles: `v vt vn f usemtl`, and where they stand.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{Vec2, Vec3};

use super::lines::{Line, Lines};
use crate::error::SceneError;
use crate::text::{finite, quoted, split_keyword};
use crate::warning::Warnings;

/// What a face's corner names, in the order of its indices.
pub(crate) const PARTS: [&str; 3] = ["v", "vt", "vn"];

/// In place of an index that a corner does not have.
pub(crate) const NONE: u32 = u32::MAX;

/// Statements that make no triangles, in small letters.
const PASSED_OVER: &str = "o g s mg p l vp mtllib maplib usemap cstype deg bmat step curv curv2 parm trim hole scrv sp end \
    con bevel c_interp d_interp lod shadow_obj trace_obj ctech stech bsp bzp cdc cdp res csh t vw i";

/// The sentence for faces that lose their texture coordinates or normals.
const WITHOUT: [&str; 3] = ["", "the face has no texture coordinates", "the face has the geometric normal"];

/// The sentence for faces of which only some corners have a part.
const INCOMPLETE: [&str; 3] = ["", "it has no texture coordinates", "it has the geometric normal"];

/// A corner of a face: indices of its `v`, `vt` and `vn`, counted from 0, or [`NONE`].
pub(crate) type Corner = [u32; 3];

/// A face: a row of [`Statements::corners`].
#[derive(Clone, Copy)]
pub(crate) struct Face {
    /// The corner behind its last one; the first one is that behind the face above.
    pub(crate) end: usize,
    /// Counted from 1.
    pub(crate) line: usize,
    /// Of [`Statements::names`]; [`NONE`] above the first `usemtl`.
    pub(crate) name: u32,
}

/// What an OBJ file says.
#[derive(Default)]
pub(crate) struct Statements<'a> {
    pub(crate) positions: Vec<Vec3>,
    /// Not a number where the file has none that is finite.
    pub(crate) tex_coords: Vec<Vec2>,
    /// Likewise.
    pub(crate) normals: Vec<Vec3>,
    pub(crate) corners: Vec<Corner>,
    pub(crate) faces: Vec<Face>,
    /// The names that `usemtl` states, each once, with the line of the first.
    pub(crate) names: Vec<(&'a str, usize)>,
    /// What `mtllib` states, each once, with the line of the first.
    pub(crate) libraries: Vec<(&'a str, usize)>,
    /// Faces that name what stands further down.
    ahead: Vec<Ahead>,
}

/// A face that names what stands further down, and the first index that does.
struct Ahead {
    face: usize,
    part: usize,
    index: i64,
    /// How many there are above.
    above: usize,
}

impl Ahead {
    fn fault(&self) -> String {
        out_of_range(self.part, self.index, self.above)
    }
}

/// Says that an index names nothing of the `count` statements above the line.
fn out_of_range(part: usize, index: i64, count: usize) -> String {
    let name = PARTS[part];
    let valid = match count {
        0 => format!("there is no {name} above this line"),
        _ => format!("1 to {count} (or -{count} to -1) stand above this line"),
    };
    format!("f: {name} index {index} is out of range: {valid}")
}

/// Reads an OBJ file line by line.
struct Reader<'a, 'w> {
    path: &'a Path,
    lines: Lines<'a>,
    /// The line of the statement at hand.
    line: usize,
    read: Statements<'a>,
    names: HashMap<&'a str, u32>,
    libraries: HashSet<&'a str>,
    /// The name that the last `usemtl` states.
    name: u32,
    warnings: &'w mut Warnings,
}

impl<'a> Statements<'a> {
    /// Reads `text`, the content of `path`.
    ///
    /// # Errors
    /// For the first line that is wrong.
    pub(crate) fn read(path: &'a Path, text: &'a str, warnings: &mut Warnings) -> Result<Self, SceneError> {
        let mut reader = Reader {
            path,
            lines: Lines::new(text),
            line: 0,
            read: Self::default(),
            names: HashMap::new(),
            libraries: HashSet::new(),
            name: NONE,
            warnings,
        };
        while let Some(Line { number, text, .. }) = reader.lines.next() {
            reader.line = number;
            reader.statement(text)?;
        }
        Ok(reader.read)
    }
}

impl<'a> Reader<'a, '_> {
    fn error(&self, message: impl Into<String>) -> SceneError {
        SceneError::at_line(self.path, self.line, message)
    }

    fn note(&mut self, assumed: &'static str, fault: impl FnOnce() -> String) -> Result<(), SceneError> {
        self.warnings.note(assumed, || SceneError::at_line(self.path, self.line, fault()))
    }

    fn statement(&mut self, line: &'a str) -> Result<(), SceneError> {
        let Some((keyword, rest)) = split_keyword(line) else { return Ok(()) };
        match keyword {
            "v" | "vt" | "vn" | "f" => self.data(keyword, rest),
            _ if keyword.starts_with('#') => Ok(()),
            _ => match keyword.to_ascii_lowercase().as_str() {
                "v" => self.data("v", rest),
                "vt" => self.data("vt", rest),
                "vn" => self.data("vn", rest),
                "f" | "fo" => self.data("f", rest),
                "usemtl" => {
                    let next = self.read.names.len() as u32;
                    self.name = *self.names.entry(rest).or_insert(next);
                    if self.name == next {
                        self.read.names.push((rest, self.line));
                    }
                    Ok(())
                }
                "mtllib" => {
                    if self.libraries.insert(rest) {
                        self.read.libraries.push((rest, self.line));
                    }
                    Ok(())
                }
                "surf" | "call" => self.note("what it adds is left out", || {
                    format!("{}: neither surfaces nor other files are read", quoted(keyword))
                }),
                other if PASSED_OVER.split_whitespace().any(|known| known == other) => Ok(()),
                _ => self.note("what OBJ does not have is passed over", || {
                    format!("{} is no statement of OBJ", quoted(keyword))
                }),
            },
        }
    }

    /// A statement of numbers, which may go on in the next lines and end with a comment.
    fn data(&mut self, keyword: &str, rest: &str) -> Result<(), SceneError> {
        let whole;
        let rest = if rest.ends_with('\\') {
            whole = self.continued(rest);
            &whole
        } else {
            rest
        };
        let data = rest.split('#').next().unwrap_or_default();
        match keyword {
            "v" => self.vertex(data),
            "vt" => self.tex_coord(data),
            "vn" => self.normal(data),
            _ => self.face(data),
        }
    }

    /// Joins a statement with the lines that continue it: each but the last ends with a backslash.
    fn continued(&mut self, begin: &str) -> String {
        let mut whole = begin.to_owned();
        while whole.ends_with('\\') {
            whole.pop();
            whole.push(' ');
            whole.push_str(self.lines.next().map_or("", |line| line.text.trim_end()));
        }
        whole
    }

    /// `v x y z`, `v x y z w` (divided by w), `v x y z r g b` or `v x y z r g b a` (the colour is left
    /// out: a scene has none at its corners).
    fn vertex(&mut self, data: &str) -> Result<(), SceneError> {
        let mut words = data.split_ascii_whitespace();
        let position = numbers("v", ["x", "y", "z"], &mut words);
        let more = words.clone().count();
        let position = match position {
            Ok(numbers) => Vec3::from(numbers),
            Err(_) if data.split_ascii_whitespace().count() < 3 => {
                let count = data.split_ascii_whitespace().count();
                let reason = "x y z, x y z w, x y z r g b, or x y z r g b a is needed";
                return Err(self.error(format!("v has {count} numbers: {reason}")));
            }
            Err(reason) => return Err(self.error(reason)),
        };
        let position = match more {
            0 | 3 | 4 => position,
            1 => {
                let [w] = numbers("v", ["w"], &mut words).map_err(|reason| self.error(reason))?;
                let divided = position / w;
                if divided.is_finite() {
                    divided
                } else {
                    let fault = || format!("v: x, y, z divided by w = {w:?} are not finite");
                    self.note("x, y, z are taken as they are", fault)?;
                    position
                }
            }
            _ => {
                let fault = || format!("v has {} numbers: 3, 4, 6 or 7 are needed", 3 + more);
                self.note("the first three are taken", fault)?;
                position
            }
        };
        self.read.positions.push(position);
        Ok(())
    }

    /// `vt u`, `vt u v` or `vt u v w`; v is 0 where it is not stated, and w is left out.
    fn tex_coord(&mut self, data: &str) -> Result<(), SceneError> {
        let mut words = data.split_ascii_whitespace();
        let read = match words.clone().count() {
            1 => numbers("vt", ["u"], &mut words).map(|[u]| Vec2::new(u, 0.0)),
            _ => numbers("vt", ["u", "v"], &mut words).map(Vec2::from),
        };
        let tex_coord = match read {
            Ok(read) => read,
            Err(reason) => {
                self.note("faces that name it have no texture coordinates", || reason)?;
                Vec2::NAN
            }
        };
        self.read.tex_coords.push(tex_coord);
        Ok(())
    }

    /// `vn x y z`.
    fn normal(&mut self, data: &str) -> Result<(), SceneError> {
        let normal = match numbers("vn", ["x", "y", "z"], &mut data.split_ascii_whitespace()) {
            Ok(read) => Vec3::from(read),
            Err(reason) => {
                self.note("faces that name it have the geometric normal", || reason)?;
                Vec3::NAN
            }
        };
        self.read.normals.push(normal);
        Ok(())
    }

    /// `f` with three corners or more, each `v`, `v/vt`, `v//vn` or `v/vt/vn`. Those with fewer are
    /// points and lines.
    fn face(&mut self, data: &str) -> Result<(), SceneError> {
        let begin = self.read.corners.len();
        let counts = [self.read.positions.len(), self.read.tex_coords.len(), self.read.normals.len()];
        let mut ahead = None;
        // How many corners name each part, and whether one of the indices can be none.
        let (mut named, mut unfit) = ([0; 3], [false; 3]);
        for word in data.split_ascii_whitespace() {
            let mut corner = [NONE; 3];
            let malformed = || format!("f: corner {}: v, v/vt, v//vn or v/vt/vn is needed", quoted(word));
            for (part, word) in word.split('/').enumerate() {
                if part == PARTS.len() || (part == 0 && word.is_empty()) {
                    return Err(self.error(malformed()));
                }
                if word.is_empty() {
                    continue;
                }
                let index: i64 = word.parse().map_err(|_| self.error(malformed()))?;
                let count = counts[part];
                named[part] += 1;
                let from_0 = if index > 0 { index - 1 } else { count as i64 + index };
                match u32::try_from(from_0) {
                    Ok(from_0) if index != 0 && from_0 != NONE => {
                        if from_0 as usize >= count && ahead.is_none() {
                            ahead = Some(Ahead { face: self.read.faces.len(), part, index, above: count });
                        }
                        corner[part] = from_0;
                    }
                    _ => {
                        let fault = out_of_range(part, index, count);
                        if part == 0 {
                            return Err(self.error(fault));
                        }
                        unfit[part] = true;
                        self.note(WITHOUT[part], || fault)?;
                    }
                }
            }
            self.read.corners.push(corner);
        }
        let corners = self.read.corners.len() - begin;
        if corners < 3 {
            self.read.corners.truncate(begin);
            return self
                .note("it makes no triangle", || format!("f has {corners} corners: at least 3 are needed"));
        }
        for part in 1..PARTS.len() {
            if (1..corners).contains(&named[part]) && !unfit[part] {
                let fault = || format!("f: {} of {corners} corners have a {}", named[part], PARTS[part]);
                self.note(INCOMPLETE[part], fault)?;
                unfit[part] = true;
            }
            if unfit[part] {
                self.read.corners[begin..].iter_mut().for_each(|corner| corner[part] = NONE);
            }
        }
        self.read.ahead.extend(ahead);
        self.read.faces.push(Face { end: self.read.corners.len(), line: self.line, name: self.name });
        Ok(())
    }
}

/// The next N numbers.
fn numbers<'w, const N: usize>(
    keyword: &str,
    names: [&str; N],
    words: &mut impl Iterator<Item = &'w str>,
) -> Result<[f32; N], String> {
    let mut numbers = [0.0; N];
    for (number, name) in numbers.iter_mut().zip(names) {
        let word = words
            .next()
            .ok_or_else(|| format!("{keyword}: {name} is missing: {} are needed", names.join(" ")))?;
        *number = finite(word).map_err(|reason| format!("{keyword}: {name} = {reason}"))?;
    }
    Ok(numbers)
}

impl Statements<'_> {
    /// Checks the indices, which may name what stands anywhere in the file, and takes texture
    /// coordinates and normals from the faces that name some that are not there.
    ///
    /// # Errors
    /// When a face names a `v` that the file does not have.
    pub(crate) fn resolve(&mut self, path: &Path, warnings: &mut Warnings) -> Result<(), SceneError> {
        let counts = [self.positions.len(), self.tex_coords.len(), self.normals.len()];
        let mut ahead = self.ahead.iter().peekable();
        let mut begin = 0;
        for (index, face) in self.faces.iter().enumerate() {
            let corners = &mut self.corners[begin..face.end];
            begin = face.end;
            let at_line = |message| SceneError::at_line(path, face.line, message);
            let ahead = ahead.next_if(|ahead| ahead.face == index);
            let mut is_whole = true;
            for part in 0..PARTS.len() {
                let outside =
                    |corner: &&Corner| corner[part] != NONE && corner[part] as usize >= counts[part];
                // Only what stands ahead was not checked yet.
                if let Some(corner) = corners.iter().find(outside).filter(|_| ahead.is_some()) {
                    let fault = || {
                        let (name, count) = (PARTS[part], counts[part]);
                        at_line(format!(
                            "f: {name} index {} is out of range: the file has {count}",
                            u64::from(corner[part]) + 1
                        ))
                    };
                    if part == 0 {
                        return Err(fault());
                    }
                    warnings.note(WITHOUT[part], fault)?;
                    is_whole = false;
                    corners.iter_mut().for_each(|corner| corner[part] = NONE);
                }
                let is_number = |corner: &Corner| match part {
                    0 => true,
                    1 => self.tex_coords.get(corner[part] as usize).is_none_or(|it| it.is_finite()),
                    _ => self.normals.get(corner[part] as usize).is_none_or(|it| it.is_finite()),
                };
                if !corners.iter().all(is_number) {
                    corners.iter_mut().for_each(|corner| corner[part] = NONE);
                }
            }
            if let Some(ahead) = ahead.filter(|_| is_whole) {
                warnings.note("what stands further down is meant", || at_line(ahead.fault()))?;
            }
        }
        Ok(())
    }
}
