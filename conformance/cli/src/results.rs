//! Results of a sweep or of the frames of a walk as lines of JSON, in the order of the points, whatever order
//! they were found in. So a file of them says by itself how far it is, a run that was stopped goes on where it
//! was, and the parts of a grid that several machines worked on can be merged.

use anyhow::{Context, Result, bail, ensure};
use saarcor_studies::error::StudyError;
use saarcor_studies::sweep::Position;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where a line of results stands.
fn position(line: &str) -> Result<Position> {
    serde_json::from_str(line).context("no result of such a run")
}

/// Lines of results that grow, in memory or in a file too.
pub struct Results {
    /// The lines.
    pub lines: Vec<String>,
    file: Option<(PathBuf, File)>,
}

impl Results {
    /// Those of the points at `expected`, as far as `file` has them. A line that was not written to
    /// its end is dropped.
    ///
    /// # Errors
    /// If the file cannot be read and written, or holds other results.
    pub fn open(file: Option<&Path>, expected: &[Position]) -> Result<Self> {
        let Some(path) = file else { return Ok(Self { lines: Vec::new(), file: None }) };
        let cannot = || format!("{}: cannot be written", path.display());
        // A device or a pipe has no end to go on at.
        let is_file = fs::metadata(path).map_or(true, |found| found.is_file());
        ensure!(is_file, "{}: no plain file; name one, or print with --json", path.display());
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(error).with_context(|| format!("{}: cannot be read", path.display())),
        };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let lines: Vec<_> = text[..whole].lines().map(str::to_owned).collect();
        for (i, line) in lines.iter().enumerate() {
            let position = position(line).with_context(|| format!("{}: line {}", path.display(), i + 1))?;
            ensure!(
                expected.get(i) == Some(&position),
                "{}: line {}: result of another run; name a new file",
                path.display(),
                i + 1
            );
        }
        // What is cut off has to be a result that was not written to its end.
        ensure!(
            text[whole..].is_empty() || text[whole..].starts_with('{'),
            "{}: line {}: no result of such a run",
            path.display(),
            lines.len() + 1
        );
        let file = File::options().create(true).append(true).open(path).with_context(cannot)?;
        file.set_len(whole as u64).with_context(cannot)?;
        Ok(Self { lines, file: Some((path.to_owned(), file)) })
    }

    /// Adds the results of the points that are left, `at_a_time` of them worked on together by `rows`.
    ///
    /// # Errors
    /// Those of `rows`, and if the file cannot be written.
    pub fn complete<Row: Serialize>(
        &mut self,
        points: &[usize],
        at_a_time: usize,
        mut rows: impl FnMut(&[usize]) -> Result<Vec<Row>, StudyError>,
        report: impl Fn(f64),
    ) -> Result<()> {
        for chunk in points[self.lines.len()..].chunks(at_a_time.max(1)) {
            report(self.lines.len() as f64 / points.len() as f64);
            for row in rows(chunk)? {
                let line = serde_json::to_string(&row).context("result as JSON")?;
                if let Some((path, file)) = &mut self.file {
                    // What a full disk leaves of a line is dropped when the sweep goes on.
                    file.write_all(format!("{line}\n").as_bytes())
                        .with_context(|| format!("{}: cannot be written", path.display()))?;
                }
                self.lines.push(line);
            }
        }
        Ok(())
    }
}

/// The lines of several files as those of the whole grid, in its order.
///
/// # Errors
/// If they are not of one sweep, differ, or leave points out.
pub fn merged(files: &[(String, String)]) -> Result<Vec<String>> {
    let mut all: BTreeMap<usize, &str> = BTreeMap::new();
    let mut one: Option<Position> = None;
    for (name, text) in files {
        for (i, line) in text.lines().enumerate() {
            let position = position(line).with_context(|| format!("{name}: line {}", i + 1))?;
            let first = one.get_or_insert_with(|| position.clone());
            ensure!(
                (&position.sweep, position.points) == (&first.sweep, first.points),
                "{name}: line {}: result of another run",
                i + 1
            );
            if all.insert(position.point, line).is_some_and(|other| other != line) {
                bail!("{name}: line {}: point {} has another result elsewhere", i + 1, position.point);
            }
        }
    }
    let points = one.context("no results in any of the files")?.points;
    if let Some(missing) = (0..points).find(|point| !all.contains_key(point)) {
        bail!("point {missing} of 0 to {} is in none of the files; finish its part first", points - 1);
    }
    Ok(all.into_values().map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_needs_all_of_one_sweep() {
        let line = |sweep, point| format!(r#"{{"sweep":"{sweep}","point":{point},"points":3}}"#);
        let file = |name: &str, lines: &[String]| (name.to_owned(), lines.join("\n"));
        let (a, b) = (file("a", &[line("x", 0), line("x", 2)]), file("b", &[line("x", 1)]));
        let whole = merged(&[b.clone(), a.clone()]).expect("whole");
        assert_eq!(whole, [line("x", 0), line("x", 1), line("x", 2)]);
        let said = |files: &[_]| merged(files).expect_err("refused").to_string();
        assert!(said(std::slice::from_ref(&a)).contains("point 1"));
        assert!(said(&[a, b, file("c", &[line("y", 1)])]).contains("another run"));
        assert!(said(&[]).contains("no results"));
    }
}
