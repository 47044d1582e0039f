//! What must hold in every cycle of a run, phase by phase: each law looks at the chip after each phase and
//! keeps a book of its own. The theorems of this folder hold small chips to one law each; `tests/time.rs`
//! holds large ones to all.

/// Demands that something holds; the rest says what is wrong.
macro_rules! demand {
    ($holds:expr, $($wrong:tt)+) => {
        if !$holds {
            return Err(format!($($wrong)+));
        }
    };
}

mod account;
mod bus_manager;
mod hand_out;
mod in_flight;
mod longest_run;
mod ports;
mod threads;
mod units;

pub use account::Account;
pub use bus_manager::{LookUps, Parts};
pub use hand_out::HandOut;
pub use in_flight::{Arrivals, Queue, Waiting};
pub use longest_run::longest_run;
pub use ports::Ports;
pub use threads::Threads;
pub use units::Units;

use crate::source::Stop;
use saarcor_model::time::{Chip, ChipConfig, Programs, TimingReport};

/// What a law says against a run: nothing, or what is wrong.
pub type Verdict = Result<(), String>;

/// What must hold in a run.
pub trait Law {
    /// Looks at the chip after a phase (CH-5).
    ///
    /// # Errors
    /// What is wrong.
    fn seen(&mut self, phase: u32, chip: &Chip) -> Verdict;

    /// Looks at the report of the whole run.
    ///
    /// # Errors
    /// What is wrong.
    fn reported(&mut self, _report: &TimingReport) -> Verdict {
        Ok(())
    }
}

/// Runs `programs`, and holds the run to `laws`, and to an end within the cycles of [`longest_run`].
///
/// # Errors
/// The first law that is broken: in which cycle, after which phase, and how.
pub fn run(
    config: &ChipConfig,
    before: &[Programs],
    programs: &Programs,
    laws: &mut [&mut dyn Law],
) -> Result<TimingReport, String> {
    let mut chip = Chip::new(before, programs, config).map_err(|error| error.to_string())?;
    let longest = longest_run(config, programs);
    let mut broken = None;
    let mut over = false;
    while !over {
        over = chip.cycle(|phase, chip| {
            for law in &mut *laws {
                if broken.is_none()
                    && let Err(wrong) = law.seen(phase, chip)
                {
                    broken = Some(format!("cycle {}, phase {phase}: {wrong}", chip.now));
                }
            }
        });
        if let Some(broken) = broken.take() {
            return Err(broken);
        }
        demand!(chip.now <= longest, "packets wait for ever: not over after {longest} cycles");
    }
    let report = chip.report();
    for law in laws {
        law.reported(&report)?;
    }
    Ok(report)
}

/// Holds the run of a theorem to a law.
///
/// # Errors
/// Where it is broken.
pub fn held(config: &ChipConfig, programs: &Programs, law: &mut dyn Law) -> Result<TimingReport, Stop> {
    run(config, &[], programs, &mut [law])
        .map_err(|wrong| Stop::Disproved(format!("{wrong}: {programs:?} on {config:?}")))
}

/// The pipeline of a thread.
fn pipeline(config: &ChipConfig, thread: usize) -> usize {
    thread / config.threads as usize
}

/// Nothing but that the run ends.
pub struct Nothing;

impl Law for Nothing {
    fn seen(&mut self, _phase: u32, _chip: &Chip) -> Verdict {
        Ok(())
    }
}
