//! The sensitivity of Table 2, in one folder: what was measured, so that a run can go on, the result and the tornados.

use super::tornado::TORNADOS;
use crate::output::{OutFile, Stdout, json_line};
use crate::progress::{Progress, Remaining};
use crate::table::{Column, Table};
use anyhow::{Context, Result, ensure};
use saarcor_paper::sensitivity::{
    Bar, Effect, Errors, Measured, Options, SampleFacts, Sensitivity, Setting, measure,
};
use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::Path;

/// Measures what the folder lacks, and writes the result. `over` names the numbers that are varied, and no pairs of them;
/// without any, all are.
///
/// # Errors
/// If the folder cannot be written to or holds something else, and those of [`measure`].
pub fn run(
    folder: &Path,
    options: &Options,
    over: &[String],
    combined: &[Setting],
    json: bool,
    progress: &Progress,
) -> Result<()> {
    options.check()?;
    fs::create_dir_all(folder).with_context(|| format!("{}: the folder cannot be made", folder.display()))?;
    let result = OutFile::check(&folder.join("sensitivity.json"))?;
    let path = folder.join("sensitivity.jsonl");
    let (mut known, mut file) = open(&path)?;
    if !known.is_empty() {
        progress.say(format!("{}: {} rows are known", path.display(), known.len()));
    }
    let is_varied =
        |setting: &Setting| over.is_empty() || over.iter().any(|name| setting.numbers() == [name]);
    let one_at_a_time = Setting::one_at_a_time().into_iter().filter(is_varied);
    let settings: Vec<Setting> = one_at_a_time.chain(combined.iter().cloned()).collect();
    let mut keep = |measured: &Measured| {
        let line = serde_json::to_string(measured)?;
        file.write_all(format!("{line}\n").as_bytes())
    };
    let mut complete = |settings: &[Setting], known: &mut Vec<Measured>| -> Result<Sensitivity> {
        let remaining = Remaining::new();
        measure(options, settings, known, &mut keep, progress, &mut |part| remaining.say(part, progress))
            .with_context(|| path.display().to_string())?;
        Ok(Sensitivity::of(options, settings, known)?)
    };
    let mut sensitivity = complete(&settings, &mut known)?;
    if over.is_empty() {
        let all: Vec<Setting> = settings.into_iter().chain(sensitivity.pairs()).collect();
        sensitivity = complete(&all, &mut known)?;
    }
    result.write(|out| Ok(writeln!(out, "{}", serde_json::to_string_pretty(&sensitivity)?)?))?;
    for tornado in TORNADOS {
        let file = OutFile::check(&folder.join(tornado.file).with_extension("svg"))?;
        file.write(|out| Ok(out.write_all(tornado.svg(&sensitivity).as_bytes())?))?;
    }
    let mut out = Stdout::new();
    if json {
        json_line(&mut out, &sensitivity)?;
    } else {
        print(&sensitivity, &mut out)?;
    }
    out.finish()
}

/// How a row begins.
const BEGIN: &str = "{\"defaults\":\"";

/// What the file has, and the file to go on with. A line that was not written to its end is dropped.
fn open(path: &Path) -> Result<(Vec<Measured>, File)> {
    let shown = path.display();
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        Err(error) => return Err(error).with_context(|| format!("{shown}: cannot be read")),
    };
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    ensure!(
        // A row begins with its first key, however early it was cut off.
        text[whole..].starts_with(BEGIN) || BEGIN.starts_with(&text[whole..]),
        "{shown}: holds something else; name another folder"
    );
    let lines = text[..whole].lines().enumerate().map(|(place, line)| {
        let row = serde_json::from_str::<Measured>(line).ok().filter(Measured::is_possible);
        row.with_context(|| format!("{shown}: line {}: no measured row; name another folder", place + 1))
    });
    let known = lines.collect::<Result<Vec<Measured>>>()?;
    let file = File::options().create(true).append(true).open(path);
    let file = file.with_context(|| format!("{shown}: cannot be written"))?;
    file.set_len(whole as u64).with_context(|| format!("{shown}: cannot be written"))?;
    Ok((known, file))
}

fn print(sensitivity: &Sensitivity, out: &mut Stdout) -> Result<()> {
    let Sensitivity { settings, sample, defaults, bars, strongest, combinations, .. } = sensitivity;
    let rows = defaults.effects.get("all").map_or(0, |effect| effect.rows);
    out.line(format_args!(
        "{settings} settings over {rows} rows. Errors in percent, changes in points of percent"
    ))?;
    if let Some(sample) = sample {
        out.line(worth(sample))?;
    }
    out.line("")?;
    let all = || std::iter::once(defaults).chain(bars).chain(combinations);
    let name =
        |bar: &Bar| if bar.setting.is_empty() { "the defaults".to_owned() } else { bar.setting.clone() };
    let names = ["A / no VM", "B / no VM", "Mem B / A", "fps", "Mem", "PCI"];
    let numbers = ["error", "change", "built-in", "real", "95 % over families"].into_iter().chain(names);
    let mut table = Table::new(std::iter::once(Column::text("setting")).chain(numbers.map(Column::number)));
    for bar in all() {
        let Some(Effect { errors, change, interval: [low, high], .. }) = bar.effects.get("all") else {
            continue;
        };
        let of = |set: &str| {
            bar.effects.get(set).map_or_else(String::new, |effect| format!("{:+.1}", effect.change))
        };
        let absolute = [errors.a, errors.b, errors.mem_b_of_a, errors.fps, errors.mem, errors.pci];
        let first = [name(bar), format!("{:.1}", errors.relations), format!("{change:+.1}")];
        let interval = format!("{low:+.1} to {high:+.1}");
        let cells = [of("built_in"), of("real"), interval].into_iter();
        table.row(first.into_iter().chain(cells).chain(absolute.map(|error| format!("{error:.1}"))));
    }
    out.line(table)?;
    out.line("")?;
    out.line("Ours / the paper's, geometric means of a family: frames a second without virtual memory, Mem and PCI of version A")?;
    out.line("")?;
    let families: Vec<&str> = defaults.families.keys().map(String::as_str).collect();
    let columns = families.iter().map(|family| Column::number(*family));
    let mut table = Table::new(std::iter::once(Column::text("setting")).chain(columns));
    for bar in all() {
        let cell = |family: &&str| {
            let ratios = |errors: &Errors| {
                [errors.fps_ratio, errors.mem_ratio, errors.pci_ratio].map(ratio).join("  ")
            };
            bar.families.get(*family).map_or_else(String::new, ratios)
        };
        table.row(std::iter::once(name(bar)).chain(families.iter().map(cell)));
    }
    out.line(table)?;
    out.line("")?;
    if strongest.is_empty() {
        return Ok(());
    }
    out.line(format_args!("the strongest numbers: {}", strongest[..strongest.len().min(4)].join(", ")))
}

/// A ratio with about three digits.
fn ratio(value: f64) -> String {
    format!("{value:.*}", if value < 10.0 { 2 } else { 0 })
}

/// What a sample is worth, in words.
fn worth(sample: &SampleFacts) -> String {
    let SampleFacts { part, rows: (rows, all), settings, error, within } = sample;
    let shown = match error {
        None => "no setting was measured with all rows, so nothing but the intervals says what the sample is worth".to_owned(),
        Some(error) => format!(
            "by the {settings} settings that all rows were measured with, its changes are off by {error:.2} points (root of the \
             mean square), and {within} lie in its interval"
        ),
    };
    format!("A sample of {part}, {rows} of {all} rows: {shown}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn run_that_was_stopped_goes_on_behind_the_last_whole_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sensitivity.jsonl");
        let line = r#"{"defaults":"0","resolution":[8,8],"scene":"s","real":false,"of":"Sodahall","row":"a","frame":1,"hot_spots":[1],"setting":"","fps":[1.0,1.0,1.0],"mem_bytes":[1,1,1],"pci_bytes":[1,1]}"#;
        fs::write(&path, format!("{line}\n{}", &line[..30])).expect("written");
        let (known, mut file) = open(&path).expect("opened");
        assert_eq!(known.len(), 1);
        writeln!(file, "{line}").expect("written");
        assert_eq!(open(&path).expect("opened").0.len(), 2);
        fs::write(&path, "frame,cycles\n").expect("written");
        let said = format!("{:#}", open(&path).expect_err("refused"));
        assert!(said.contains("line 1: no measured row; name another folder"), "{said}");
    }
}
