//! The rules, and what is said of a violation.

use super::Command;
use std::fmt;

/// A rule that a command can violate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "each has its sentence below")]
pub enum Rule {
    Clock,
    Bank,
    Row,
    Column,
    BurstEmpty,
    BurstLeavesRow,
    OpenBank,
    ClosedBank,
    OtherRow,
    Trcd,
    Trp,
    Tras,
    Trc,
    Trrd,
    Twr,
    Trfc,
    ReadCut,
    BurstCut,
    DataBus,
    RefreshOpen,
    RefreshEarly,
    RefreshLate,
    RefreshOff,
    Cl,
    WriteLatency,
    DataLength,
    DataUnasked,
    DataMissing,
}

impl Rule {
    /// The name of the rule, and the sentence that says what violates it, by [`Violation::at`] and
    /// [`Violation::limit`].
    const fn about(self) -> (&'static str, &'static str) {
        match self {
            Self::Clock => ("clock", "a command comes less than {limit} clock after the one in clock {at}"),
            Self::Bank => ("bank", "there is no bank {at}, since there are {limit}"),
            Self::Row => ("row", "there is no row {at}, since a bank has {limit}"),
            Self::Column => ("column", "there is no column {at}, since a row has {limit}"),
            Self::BurstEmpty => ("empty burst", "a burst has at least {limit} beat"),
            Self::BurstLeavesRow => {
                ("burst leaves row", "a burst from column {at} on has at most {limit} beats")
            }
            Self::OpenBank => ("open bank", "ACT finds its bank open since clock {at}"),
            Self::ClosedBank => ("closed bank", "RD or WR finds its bank closed since clock {at}"),
            Self::OtherRow => ("other row", "RD or WR means another row than {at}, which is open"),
            Self::Trcd => {
                ("tRCD", "RD or WR comes less than {limit} clocks after ACT of its bank in clock {at}")
            }
            Self::Trp => ("tRP", "ACT or REF comes less than {limit} clocks after PRE in clock {at}"),
            Self::Tras => ("tRAS", "PRE comes less than {limit} clocks after ACT of its bank in clock {at}"),
            Self::Trc => ("tRC", "ACT comes less than {limit} clocks after ACT of its bank in clock {at}"),
            Self::Trrd => ("tRRD", "ACT comes less than {limit} clocks after ACT of a bank in clock {at}"),
            Self::Twr => {
                ("tWR", "PRE comes less than {limit} clocks after all was written to its bank by clock {at}")
            }
            Self::Trfc => ("tRFC", "a command comes less than {limit} clocks after REF in clock {at}"),
            Self::ReadCut => ("read cut", "PRE cuts the {limit} beats of RD of its bank in clock {at}"),
            Self::BurstCut => ("burst cut", "RD or WR cuts the {limit} beats of RD or WR in clock {at}"),
            Self::DataBus => ("data bus", "data share clock {limit} with those of RD or WR in clock {at}"),
            Self::RefreshOpen => ("open at refresh", "REF finds a bank open since clock {at}"),
            Self::RefreshEarly => ("early refresh", "refresh {at} comes before clock {limit}"),
            Self::RefreshLate => ("late refresh", "refresh {at} is due by clock {limit}"),
            Self::RefreshOff => ("refresh off", "REF comes where a tREFI of {limit} allows none"),
            Self::Cl => ("CL", "data do not begin {limit} clocks after their RD in clock {at}"),
            Self::WriteLatency => ("write latency", "data do not begin with their WR in clock {at}"),
            Self::DataLength => ("data length", "data are not the {limit} beats of RD or WR in clock {at}"),
            Self::DataUnasked => ("unasked data", "no RD or WR waits for the data in clock {at}"),
            Self::DataMissing => ("missing data", "the {limit} beats of RD or WR in clock {at} never came"),
        }
    }

    /// The name of the rule.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.about().0
    }
}

/// A rule that was violated. It is displayed as a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// The clock of the command, the begin of the data, or the end of the run.
    pub clock: u64,
    /// The command; none for data and for the end of the run.
    pub command: Option<Command>,
    /// What the rule counts from: the clock of an earlier command, or the number that is wrong.
    pub at: u64,
    /// What the rule demands: clocks of distance, or the first number that is too large.
    pub limit: u64,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, sentence) = self.rule.about();
        write!(f, "clock {}: ", self.clock)?;
        if let Some(command) = self.command {
            write!(f, "{command}: ")?;
        }
        let says = sentence.replace("{at}", &self.at.to_string()).replace("{limit}", &self.limit.to_string());
        write!(f, "{name}: {says}")
    }
}

/// A rule, and [`Violation::at`] and [`Violation::limit`].
pub(super) type Finding = (Rule, u64, u64);

/// An event in a clock comes at least `limit` clocks after the one in clock `at`, if there was one.
pub(super) fn after(rule: Rule, clock: u64, at: Option<u64>, limit: u64) -> Result<(), Finding> {
    match at {
        Some(at) if clock.checked_sub(at).is_none_or(|clocks| clocks < limit) => Err((rule, at, limit)),
        _ => Ok(()),
    }
}

/// A number is below a limit.
pub(super) fn below(rule: Rule, number: u64, limit: u64) -> Result<(), Finding> {
    if number < limit { Ok(()) } else { Err((rule, number, limit)) }
}
