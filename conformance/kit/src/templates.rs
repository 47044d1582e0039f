//! Implementations to copy, and faults to plant into them.

use crate::error::Error;
use serde::Deserialize;

/// An implementation to begin with.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    /// Its language.
    pub name: &'static str,
    /// Its files by their paths in its folder.
    files: &'static [(&'static str, &'static str)],
}

/// Files of a folder of `conformance/duts`.
macro_rules! template {
    ($name:literal: $($file:literal),*) => {
        Template {
            name: $name,
            files: &[$(($file, include_str!(concat!("../../duts/", $name, "/", $file)))),*],
        }
    };
}

/// All templates.
pub const TEMPLATES: &[Template] = &[
    template!("c": "cache.c", "pipe.c", "saarcor.h", "dut.toml"),
    template!("python": "cache.py", "dut.toml"),
    template!("hash": "set_of.py", "dut.toml"),
    template!("kd-c": "kd.c", "dut.toml"),
    template!("kd-python": "kd.py", "dut.toml"),
    template!("meta": "tags.py", "dut.toml"),
    template!("chip-python": "chip.py", "caches.py", "bus.py", "memory.py", "work.py", "dut.toml"),
    template!("verilog": "cache.v", "bench.v", "serve", "dut.toml"),
    template!("verilog-pipelined": "cache.v", "order.v", "bench.v", "serve", "dut.toml"),
    template!("rust": "Cargo.toml", "src/lib.rs", "src/main.rs", "tests/conforms.rs", "dut.toml"),
];

/// A fault that a maker may make: one line of a template.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Its name.
    pub name: String,
    /// The fault in a sentence.
    pub says: String,
    /// The requirement that it breaks.
    pub requirement: String,
    /// The lowest level that fails.
    pub level: String,
    /// The template.
    pub template: String,
    /// Text that is in one file of the template once.
    pub from: String,
    /// What takes its place.
    pub to: String,
    /// The session that finds it, where the quick suite does not.
    pub session: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FaultFile {
    fault: Vec<Fault>,
}

/// The faults of `duts/broken/faults.toml`.
///
/// # Errors
/// Where the file is wrong: a fault of the kit.
pub fn faults() -> Result<Vec<Fault>, Error> {
    let file: Result<FaultFile, _> = toml::from_str(include_str!("../../duts/broken/faults.toml"));
    let file = file.map_err(|error| Error::from(error.to_string()).within("faults.toml"))?;
    Ok(file.fault)
}

impl Template {
    /// The files by their paths.
    #[must_use]
    pub fn files(&self) -> Vec<(&'static str, String)> {
        // A copy lies elsewhere, and finds the kit where it was when the kit was built.
        let kit = |text: &str| {
            text.replace("\"../../kit\"", concat!("\"", env!("CARGO_MANIFEST_DIR"), "\"")).replace(
                "\"../../../model/spec\"",
                concat!("\"", env!("CARGO_MANIFEST_DIR"), "/../../model/spec\""),
            )
        };
        self.files.iter().map(|(name, text)| (*name, kit(text))).collect()
    }

    /// The files with a fault in one of them.
    ///
    /// # Errors
    /// Where the fault is another template's, or its line is not there once.
    pub fn with_fault(&self, fault: &Fault) -> Result<Vec<(&'static str, String)>, Error> {
        if fault.template != self.name {
            return Err(
                format!("the fault '{}' is one of the template '{}'", fault.name, fault.template).into()
            );
        }
        let mut files = self.files();
        let places: usize = files.iter().map(|(_, text)| text.matches(&fault.from).count()).sum();
        if places != 1 {
            return Err(format!("the fault '{}': its line is there {places} times", fault.name).into());
        }
        for (_, text) in &mut files {
            *text = text.replace(&fault.from, &fault.to);
        }
        Ok(files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_fault_has_its_line() {
        let faults = faults().expect("a list");
        let names: BTreeSet<_> = faults.iter().map(|fault| &fault.name).collect();
        assert!(faults.len() >= 30 && names.len() == faults.len());
        for fault in faults {
            let template =
                TEMPLATES.iter().find(|template| template.name == fault.template).expect("a template");
            let files = template.with_fault(&fault).expect(&fault.name);
            assert_ne!(files, template.files());
        }
    }

    #[test]
    fn templates_are_short() {
        for template in TEMPLATES {
            for (name, text) in template.files {
                assert!(text.lines().count() < 150, "{} {name}", template.name);
            }
        }
    }
}
