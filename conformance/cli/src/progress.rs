//! Messages on standard error: the work in progress, and how far it is.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use saarcor_studies::monitor::{Monitor, Silent, Stage};
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Work that ends sooner is not mentioned in a log.
const WORTH_A_LINE: Duration = Duration::from_secs(2);
/// Time between two lines about the same work in a log.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// Steps of a progress bar.
const BAR_STEPS: u64 = 1000;

/// Reports work in progress on standard error: with bars on a terminal, with lines in a log.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Nothing,
    Lines,
    Bars,
}

impl Progress {
    /// Says nothing if `quiet`.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        let form = match (quiet, io::stderr().is_terminal()) {
            (true, _) => Form::Nothing,
            (false, true) => Form::Bars,
            (false, false) => Form::Lines,
        };
        Self { form }
    }

    /// Says a line.
    pub fn say(&self, line: impl Display) {
        if self.form != Form::Nothing {
            // Nobody is harmed where it cannot be said.
            let _ = writeln!(io::stderr(), "{line}");
        }
    }

    /// Does `work` and says meanwhile how far it is: `work` reports the part that is done, 0 to 1.
    pub fn during<T>(&self, what: &str, work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T) -> T {
        let monitor: &dyn Monitor = self;
        monitor.during(what, work)
    }
}

impl Monitor for Progress {
    fn begin<'a>(&'a self, name: &str) -> Box<dyn Stage + 'a> {
        match self.form {
            Form::Nothing => Box::new(Silent),
            Form::Lines => Box::new(Lines::begin(self, name)),
            Form::Bars => Box::new(Bar::begin(name)),
        }
    }

    /// Said to the quiet as well: what is printed rests on it.
    fn warn(&self, line: &str) {
        let _ = writeln!(io::stderr(), "saarcor: warning: {line}");
    }
}

/// A stage in a log: lines.
struct Lines<'a> {
    progress: &'a Progress,
    name: String,
    started: Instant,
    next_line: Mutex<Instant>,
}

impl<'a> Lines<'a> {
    fn begin(progress: &'a Progress, name: &str) -> Self {
        let started = Instant::now();
        Self { progress, name: name.to_owned(), started, next_line: Mutex::new(started + WORTH_A_LINE) }
    }
}

impl Stage for Lines<'_> {
    fn reached(&self, part: f64) {
        // A thread that finds another one here has nothing to add.
        let Ok(mut next_line) = self.next_line.try_lock() else { return };
        let now = Instant::now();
        if now >= *next_line {
            *next_line = now + BETWEEN_LINES;
            self.progress.say(format_args!("{}: {:.0} %", self.name, 100.0 * part));
        }
    }
}

impl Drop for Lines<'_> {
    fn drop(&mut self) {
        let elapsed = self.started.elapsed();
        if elapsed >= WORTH_A_LINE {
            self.progress.say(format_args!("{}: {:.1} s", self.name, elapsed.as_secs_f64()));
        }
    }
}

/// A stage on a terminal: a progress bar.
struct Bar(ProgressBar);

impl Bar {
    fn begin(name: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
        let style = "{spinner} {msg} {bar:30} {percent:>3} %  {elapsed}, {eta} left";
        bar.set_style(ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(name.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }
}

impl Stage for Bar {
    fn reached(&self, part: f64) {
        self.0.set_position((part * BAR_STEPS as f64) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Estimates when long work will be done, from the part of it that is.
#[derive(Clone, Copy, Debug)]
pub struct Remaining {
    started: Instant,
}

impl Remaining {
    /// The work begins.
    #[must_use]
    pub fn new() -> Self {
        Self { started: Instant::now() }
    }

    /// A part of the work is done, 0 to 1: says how much time is left.
    pub fn say(&self, part: f64, progress: &Progress) {
        let elapsed = self.started.elapsed().as_secs_f64();
        let left = (elapsed * (1.0 / part - 1.0)).max(0.0);
        let percent = 100.0 * part;
        progress.say(format_args!("{percent:.0} % done in {elapsed:.0} s, about {left:.0} s left"));
    }
}

impl Default for Remaining {
    fn default() -> Self {
        Self::new()
    }
}
