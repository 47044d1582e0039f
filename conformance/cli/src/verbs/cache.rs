//! `saarcor cache`.

use crate::cache::{FOLDER, kept_worlds};
use crate::output::{Stdout, json_line};
use crate::progress::Progress;
use crate::size::Size;
use crate::status::Status;
use crate::table::{Column, Table};
use anyhow::{Context as _, Result};
use clap::Subcommand;
use saarcor_model::vm::Bytes;
use saarcor_paper::mb;
use saarcor_studies::world::kept::{KeptWorld, KeptWorlds, State};
use std::time::SystemTime;

/// The scenes that are kept ready from run to run: lists or removes them
///
/// They are in the folder SAARCOR_CACHE (empty: none are kept), else in 'saarcor' in the user's folder for caches. All files
/// there have SAARCOR_CACHE_LIMIT at most [default: 4GiB]; the least recently used scenes leave.
#[derive(Debug, clap::Args)]
// Without a verb, the list is meant: `cache --json`.
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(flatten)]
    list: ListArgs,
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    List(ListArgs),
    Empty(EmptyArgs),
}

/// The kept scenes, the most recently used first
#[derive(Debug, clap::Args)]
struct ListArgs {
    /// Reads all of them whole, removes those that are damaged, and ends with status 1 if there were any
    #[arg(long)]
    verify: bool,
    /// Prints one JSON object a scene
    #[arg(long)]
    json: bool,
}

/// Removes all of them
#[derive(Debug, clap::Args)]
struct EmptyArgs {
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Lists or removes them.
    pub fn run(self, progress: &Progress) -> Result<Status> {
        let mut out = Stdout::new();
        let verb = self.verb.unwrap_or(Verb::List(self.list));
        let status = match (kept_worlds()?, verb) {
            (Some(kept), Verb::List(args)) => args.run(&kept, &mut out, progress)?,
            (Some(kept), Verb::Empty(args)) => args.run(&kept, &mut out)?,
            (None, Verb::List(ListArgs { json, .. }) | Verb::Empty(EmptyArgs { json })) => {
                if !json {
                    out.line(format_args!("no scenes are kept: {FOLDER} is empty"))?;
                }
                Status::Holds
            }
        };
        out.finish()?;
        Ok(status)
    }
}

impl ListArgs {
    fn run(&self, kept: &KeptWorlds, out: &mut Stdout, progress: &Progress) -> Result<Status> {
        let folder = kept.folder().display();
        let listed = progress
            .during("kept scenes", |_| kept.list(self.verify))
            .with_context(|| format!("{folder}: the kept scenes cannot be read"))?;
        if self.json {
            listed.iter().try_for_each(|world| json_line(out, world))?;
        } else {
            if !listed.is_empty() {
                out.line(table(&listed))?;
                out.line("")?;
            }
            out.line(format_args!(
                "{} MB of at most {} in {folder}",
                mb(listed.iter().map(|world| world.bytes).sum()),
                Size(Bytes(kept.limit()))
            ))?;
        }
        let is_damaged = |world: &KeptWorld| world.state == State::Damaged;
        Ok(if self.verify && listed.iter().any(is_damaged) { Status::Disproved } else { Status::Holds })
    }
}

impl EmptyArgs {
    fn run(&self, kept: &KeptWorlds, out: &mut Stdout) -> Result<Status> {
        let folder = kept.folder().display();
        let removed = kept.empty().with_context(|| format!("{folder}: the kept scenes cannot be removed"))?;
        if self.json {
            json_line(out, &removed)?;
        } else {
            out.line(format_args!(
                "{} MB removed from {folder}: {} scenes",
                mb(removed.bytes),
                removed.scenes
            ))?;
        }
        Ok(Status::Holds)
    }
}

fn table(listed: &[KeptWorld]) -> Table {
    let mut table = Table::new([
        Column::text("scene"),
        Column::text("made with"),
        Column::number("triangles"),
        Column::number("MB"),
        Column::number("last used"),
        Column::text("state"),
    ]);
    for world in listed {
        let or_dash = |text: &Option<String>| text.clone().unwrap_or("–".to_owned());
        table.row([
            or_dash(&world.scene),
            or_dash(&world.made_with),
            or_dash(&world.triangles.map(|triangles| triangles.to_string())),
            mb(world.bytes),
            ago(world.last_used),
            match &world.state {
                State::Ready => "ready".to_owned(),
                State::Stale(file) => format!("stale: {} has changed", file.display()),
                State::Damaged => "damaged, or of another version".to_owned(),
                State::Unfinished => "unfinished".to_owned(),
            },
        ]);
    }
    table
}

/// How long ago it was, in the largest unit of which it is at least one.
fn ago(time: SystemTime) -> String {
    const UNITS: [(&str, u64); 3] = [("days", 24 * 60 * 60), ("h", 60 * 60), ("min", 60)];
    let seconds = SystemTime::now().duration_since(time).unwrap_or_default().as_secs();
    match UNITS.into_iter().find(|(_, unit)| seconds >= *unit) {
        Some((name, unit)) => format!("{} {name} ago", seconds / unit),
        None => format!("{seconds} s ago"),
    }
}
