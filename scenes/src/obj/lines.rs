//! The lines of an OBJ file, before tobj reads them: checked, and with their numbers.
//!
//! tobj reads fast, but it reports no line numbers, and lets pass what would give a wrong scene:
//! numbers that are not finite, index 0 among texture coordinates and normals, materials that
//! nobody defined, faces of one or two corners, and polylines (`l`), which it takes for faces. Of a
//! mesh where only some faces have texture coordinates it does not say which. [`CheckedLines`]
//! stands between the text and tobj: it stops at the first wrong line, hands on only the
//! statements that make triangles (`v vt vn f usemtl`), and starts a new mesh wherever the parts
//! that the corners of a face name change, so that each mesh has texture coordinates at all its
//! corners or at none. To check takes as long as to read: a thread does it ahead of tobj.

use std::collections::HashMap;
use std::io::{self, BufRead, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::error::SceneError;
use crate::text::{finite, quoted, split_keyword};

/// What a face's corner names, in the order of its indices.
const PARTS: [&str; 3] = ["v", "vt", "vn"];

/// The file name under which tobj asks for the materials.
pub(crate) const MATERIALS: &str = "materials";

/// Bytes of statements that are handed on together, and how many such blocks may wait for tobj.
const BLOCK: usize = 1 << 16;
const BLOCKS: usize = 4;

/// The statements of an OBJ file that make triangles, for tobj to read.
pub(crate) struct CheckedLines<'a> {
    path: &'a Path,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    materials: &'a HashMap<String, usize>,
    /// How many `v`, `vt` and `vn` stand above the line at hand.
    counts: [usize; 3],
    /// Which of `v`, `vt` and `vn` the corners of the last face named.
    named: Option<[bool; 3]>,
    /// What has yet to be handed on.
    statements: String,
}

impl<'a> CheckedLines<'a> {
    /// The lines of `text`, the content of `path`, whose `usemtl` may name the keys of `materials`.
    pub(crate) fn new(path: &'a Path, text: &'a str, materials: &'a HashMap<String, usize>) -> Self {
        Self {
            path,
            lines: text.lines().enumerate(),
            materials,
            counts: [0; 3],
            named: None,
            statements: format!("mtllib {MATERIALS}\n"),
        }
    }

    /// What `read` makes of the statements, and whether there is a face among them.
    ///
    /// # Errors
    /// For the first line that is wrong; what was made of the lines above is not returned.
    pub(crate) fn read<T>(self, read: impl FnOnce(&mut Statements) -> T) -> Result<(T, bool), SceneError> {
        std::thread::scope(|scope| {
            let (to, blocks) = sync_channel(BLOCKS);
            let checking = scope.spawn(|| self.send(to));
            // Gone before the other thread is waited for: it does not wait for room any more.
            let made = read(&mut Statements { blocks, block: String::new(), read: 0 });
            let checked = checking.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            checked.map(|has_faces| (made, has_faces))
        })
    }

    /// Sends all statements, and returns whether there is a face among them.
    fn send(mut self, to: SyncSender<String>) -> Result<bool, SceneError> {
        while let Some((index, line)) = self.lines.next() {
            self.check(line).map_err(|message| SceneError::at_line(self.path, index + 1, message))?;
            // Nobody reads any more if tobj found something wrong.
            if self.statements.len() >= BLOCK && to.send(std::mem::take(&mut self.statements)).is_err() {
                break;
            }
        }
        let _ = to.send(self.statements);
        Ok(self.named.is_some())
    }

    /// Puts the statement on `line` into `self.statements` if it has a part in triangles.
    fn check(&mut self, line: &str) -> Result<(), String> {
        let Some((keyword, rest)) = split_keyword(line) else { return Ok(()) };
        match keyword {
            "v" | "vt" | "vn" | "f" if rest.ends_with('\\') => {
                let whole = self.continued(rest);
                self.check_data(keyword, &whole)
            }
            "v" | "vt" | "vn" | "f" => self.check_data(keyword, rest),
            "usemtl" if rest.is_empty() => Err("usemtl: the material's name is missing".to_owned()),
            "usemtl" if !self.materials.contains_key(rest) => Err(format!(
                "usemtl: material {} is not defined by any MTL file that the OBJ names (mtllib)",
                quoted(rest)
            )),
            "usemtl" => {
                self.push("usemtl", rest);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Joins a statement with the lines that continue it: each but the last ends with a backslash.
    fn continued(&mut self, begin: &str) -> String {
        let mut whole = begin.to_owned();
        while whole.ends_with('\\') {
            whole.pop();
            whole.push(' ');
            whole.push_str(self.lines.next().map_or("", |(_, line)| line.trim_end()));
        }
        whole
    }

    /// Checks a statement of numbers; `rest` may end with a comment.
    fn check_data(&mut self, keyword: &str, rest: &str) -> Result<(), String> {
        let data = rest.split('#').next().unwrap_or_default();
        match keyword {
            "v" => {
                self.check_vertex(data)?;
                self.counts[0] += 1;
            }
            "vt" => {
                self.check_numbers(keyword, ["u", "v"], data)?;
                self.counts[1] += 1;
            }
            "vn" => {
                self.check_numbers(keyword, ["x", "y", "z"], data)?;
                self.counts[2] += 1;
            }
            _ => self.check_face(data)?,
        }
        Ok(())
    }

    /// `v x y z`, `v x y z w` (divided by w) or `v x y z r g b` (the colour is left out: a scene
    /// has none at its corners).
    fn check_vertex(&mut self, data: &str) -> Result<(), String> {
        match data.split_ascii_whitespace().count() {
            4 => {
                let numbers = self.check_numbers("v", ["x", "y", "z", "w"], data)?;
                let [.., w] = numbers;
                if numbers.iter().any(|number| !(number / w).is_finite()) {
                    return Err(format!("v: x, y, z divided by w = {w:?} are not finite"));
                }
            }
            3 | 6 => {
                self.check_numbers("v", ["x", "y", "z"], data)?;
            }
            count => {
                return Err(format!("v has {count} numbers: x y z, x y z w, or x y z r g b is needed"));
            }
        }
        Ok(())
    }

    /// The first N numbers of a statement, which become the statement.
    fn check_numbers<const N: usize>(
        &mut self,
        keyword: &str,
        names: [&str; N],
        data: &str,
    ) -> Result<[f32; N], String> {
        let mut numbers = [0.0; N];
        let mut words = data.split_ascii_whitespace();
        self.statements.push_str(keyword);
        for (number, name) in numbers.iter_mut().zip(names) {
            let word = words
                .next()
                .ok_or_else(|| format!("{keyword}: {name} is missing: {} are needed", names.join(" ")))?;
            *number = finite(word).map_err(|reason| format!("{keyword}: {name} = {reason}"))?;
            self.statements.push(' ');
            self.statements.push_str(word);
        }
        self.statements.push('\n');
        Ok(numbers)
    }

    /// `f` with three corners or more, each `v`, `v/vt`, `v//vn` or `v/vt/vn` as the first one is.
    fn check_face(&mut self, data: &str) -> Result<(), String> {
        let mut corners = 0;
        let mut named_first = None;
        for corner in data.split_ascii_whitespace() {
            corners += 1;
            let named = self.check_corner(corner)?;
            if named != *named_first.get_or_insert(named) {
                return Err(format!(
                    "f: corner {corners}, {}, has not the parts (v/vt/vn) of the first corner",
                    quoted(corner)
                ));
            }
        }
        if corners < 3 {
            return Err(format!("f has {corners} corners: at least 3 are needed"));
        }
        if self.named != named_first {
            self.named = named_first;
            self.push("o", "");
        }
        self.push("f", data);
        Ok(())
    }

    /// Which of `v`, `vt` and `vn` a corner names. Indices count from 1, or from -1 backwards, and
    /// name what stands above the face.
    fn check_corner(&self, corner: &str) -> Result<[bool; 3], String> {
        let malformed = || format!("f: corner {}: v, v/vt, v//vn or v/vt/vn is needed", quoted(corner));
        let mut named = [false; 3];
        for (part, word) in corner.split('/').enumerate() {
            if part == PARTS.len() {
                return Err(malformed());
            }
            if word.is_empty() {
                continue;
            }
            let index: i64 = word.parse().map_err(|_| malformed())?;
            let (name, count) = (PARTS[part], self.counts[part]);
            if index == 0 || index.unsigned_abs() > count as u64 {
                let valid = match count {
                    0 => format!("there is no {name} above this line"),
                    _ => format!("1 to {count} (or -{count} to -1) stand above this line"),
                };
                return Err(format!("f: {name} index {index} is out of range: {valid}"));
            }
            named[part] = true;
        }
        if named[0] { Ok(named) } else { Err(malformed()) }
    }

    /// Appends a line for tobj.
    fn push(&mut self, keyword: &str, rest: &str) {
        self.statements.push_str(keyword);
        self.statements.push(' ');
        self.statements.push_str(rest);
        self.statements.push('\n');
    }
}

/// What was checked, for tobj to read.
pub(crate) struct Statements {
    blocks: Receiver<String>,
    /// The block at hand, and how many bytes of it are read.
    block: String,
    read: usize,
}

impl BufRead for Statements {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read == self.block.len() {
            // No more blocks: the end.
            (self.block, self.read) = (self.blocks.recv().unwrap_or_default(), 0);
        }
        Ok(&self.block.as_bytes()[self.read..])
    }

    fn consume(&mut self, amount: usize) {
        self.read += amount;
    }
}

impl Read for Statements {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}
