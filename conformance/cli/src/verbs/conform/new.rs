//! `saarcor conform new`.

use crate::output::{folder_of, temporaries};
use crate::progress::Progress;
use crate::status::Status;
use anyhow::{Context, Result, ensure};
use clap::builder::PossibleValuesParser;
use saarcor_kit::target::shell_word as quoted;
use saarcor_kit::templates::{TEMPLATES, faults};
use saarcor_studies::names::nearest;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;

/// Copies an implementation to begin with
#[derive(Debug, clap::Args)]
pub(super) struct NewArgs {
    /// The language
    #[arg(value_parser = PossibleValuesParser::new(TEMPLATES.iter().map(|template| template.name)))]
    template: String,
    /// The folder, which must not be there yet
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Plants a fault into it, to see how it is found ('saarcor conform list --faults' names them)
    #[arg(long, value_name = "NAME")]
    fault: Option<String>,
}

impl NewArgs {
    /// Copies it.
    pub(super) fn run(self, progress: &Progress) -> Result<Status> {
        let template = TEMPLATES.iter().find(|template| template.name == self.template);
        let template = template.context("the parser lets only these names pass")?;
        let files = match &self.fault {
            None => template.files(),
            Some(name) => {
                let faults = faults()?;
                let fault = faults.iter().find(|fault| fault.name == *name).with_context(|| {
                    let near = nearest(name, faults.iter().map(|fault| fault.name.as_str()));
                    let hint = near.map_or_else(String::new, |near| format!(": did you mean '{near}'?"));
                    format!("no fault '{name}'{hint} ('saarcor conform list --faults' lists all)")
                })?;
                template.with_fault(fault)?
            }
        };
        let shown = self.folder.display();
        ensure!(!self.folder.exists(), "{shown}: is there already; name a new folder");
        let parent = folder_of(&self.folder);
        // All or nothing: the folder takes its name when it is whole.
        let cannot = || format!("{shown}: cannot be written");
        let whole = temporaries::folder_in(parent).with_context(cannot)?;
        for (name, text) in files {
            let path = whole.path().join(name);
            if let Some(folder) = path.parent() {
                fs::create_dir_all(folder).with_context(cannot)?;
            }
            let mut file = fs::File::create(path).with_context(cannot)?;
            file.write_all(text.as_bytes()).with_context(cannot)?;
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // What a folder has that is simply created, but for the user's mask, which is not known.
            fs::set_permissions(whole.path(), fs::Permissions::from_mode(0o755)).with_context(cannot)?;
        }
        fs::rename(whole.path(), &self.folder).with_context(cannot)?;
        let _ = whole.keep();
        progress.say(format_args!("{shown}: saarcor conform run {}", quoted(&shown.to_string())));
        Ok(Status::Holds)
    }
}
