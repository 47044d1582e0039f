//! The commands of an SDR SDRAM, judged by the rules of its data sheet.
//!
//! The memory has one rank of some banks, one command bus and one data bus. The rules are those of PC133
//! SDR SDRAM (JEDEC Standard 21-C; Micron MT48LC), counted in whole memory clocks. Nothing here knows how a
//! controller chooses its commands.
//!
//! ```
//! use saarcor_oracles::memory_protocol::{Burst, Checker, Command, PC133, Rule};
//!
//! let mut checker = Checker::new(PC133);
//! assert_eq!(checker.check(0, Command::Activate { bank: 0, row: 7 }), Ok(()));
//! let read = Command::Read(Burst { bank: 0, row: None, column: 4, beats: 2 });
//! let violation = checker.check(2, read).expect_err("tRCD is 3 clocks");
//! assert_eq!(violation.rule, Rule::Trcd);
//! let says = "clock 2: RD,0,,4,2: tRCD: RD or WR comes less than 3 clocks after ACT of its bank in clock 0";
//! assert_eq!(violation.to_string(), says);
//! ```
//!
//! Where data sheets differ or leave a choice:
//!
//! * tWR counts from the clock after the last written beat. Data sheets count from the clock edge that takes
//!   that beat, and so allow PRE a clock earlier: for them, give a `t_wr` that is 1 less.
//! * PRE of a closed bank is legal, and tRP counts from the last PRE, whether it found the bank open or not.
//!   Micron's model of the MT48LC16M16A2 takes PRE of a closed bank as NOP, which allows more.
//! * RD, WR and PRE can end a burst early in the chips. Here no burst may be cut: a burst takes the column
//!   path of all banks for as many clocks as it has beats. A `burst_cut` of 0 is for chips in which RD and
//!   WR end none.
//! * Read data and the write data behind them need no clock between them.
//! * No command but NOP comes within tRFC after REF. From ACT to REF only tRAS and tRP count.
//! * Refreshes are spread: refresh `k` (1, 2, …) comes from clock `k * t_refi` to `(k + 1) * t_refi`, both
//!   included. A `t_refi` of 0 demands none and allows none.
//! * Left out: initialisation, auto precharge, burst terminate, DQM, power-down, self refresh, and the
//!   longest time that a row may stay open (120 µs, far over tREFI).

mod csv;
mod rules;

pub use csv::{CsvError, HEADER, commands};
pub use rules::{Rule, Violation};

use rules::{Finding, after, below};
use std::collections::VecDeque;

/// How many transfers of a direction wait for their [`Checker::data`]; of more the oldest are forgotten.
const WAITING: usize = 64;

/// Size and timing of a memory, by the names of data sheets. Times are in memory clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Banks of the memory.
    pub banks: u64,
    /// Rows of a bank.
    pub rows: u64,
    /// Beats of a row.
    pub columns_a_row: u64,
    /// From RD to its first beat.
    pub cl: u64,
    /// From ACT to RD or WR of the bank.
    pub t_rcd: u64,
    /// From PRE to ACT of the bank, and to REF.
    pub t_rp: u64,
    /// From ACT to PRE of the bank.
    pub t_ras: u64,
    /// From ACT to ACT of the bank.
    pub t_rc: u64,
    /// From ACT to ACT of any bank.
    pub t_rrd: u64,
    /// From the clock after the last written beat to PRE of the bank.
    pub t_wr: u64,
    /// From REF to any command.
    pub t_rfc: u64,
    /// From refresh to refresh; 0 for none.
    pub t_refi: u64,
    /// 1 if RD and WR end a burst whose beats are not over, 0 if it moves all its beats whatever follows.
    pub burst_cut: u64,
}

/// PC133 at 7.5 ns a clock: 128 bits wide, rows of 4 KB, and 4096 rows that are refreshed in 64 ms.
pub const PC133: Timing = Timing {
    banks: 4,
    rows: 4096,
    columns_a_row: 256,
    cl: 3,
    t_rcd: 3,
    t_rp: 3,
    t_ras: 6,
    t_rc: 9,
    t_rrd: 2,
    t_wr: 2,
    t_rfc: 9,
    t_refi: 2083,
    burst_cut: 1,
};

impl Timing {
    /// All fields, by name.
    pub fn fields(&mut self) -> [(&'static str, &mut u64); 13] {
        [
            ("banks", &mut self.banks),
            ("rows", &mut self.rows),
            ("columns_a_row", &mut self.columns_a_row),
            ("cl", &mut self.cl),
            ("t_rcd", &mut self.t_rcd),
            ("t_rp", &mut self.t_rp),
            ("t_ras", &mut self.t_ras),
            ("t_rc", &mut self.t_rc),
            ("t_rrd", &mut self.t_rrd),
            ("t_wr", &mut self.t_wr),
            ("t_rfc", &mut self.t_rfc),
            ("t_refi", &mut self.t_refi),
            ("burst_cut", &mut self.burst_cut),
        ]
    }
}

/// A command. It is displayed as its line of CSV has it, behind the clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "a data sheet's names")]
pub enum Command {
    /// ACT: opens a row of a closed bank.
    Activate { bank: u64, row: u64 },
    /// RD: its data are on the bus from CL later on, a beat a clock.
    Read(Burst),
    /// WR: its data are on the bus from its own clock on, a beat a clock.
    Write(Burst),
    /// PRE: closes a bank, or all where none is named.
    Precharge { bank: Option<u64> },
    /// REF: refreshes a row of all banks.
    Refresh,
}

/// What RD and WR transfer: whole beats of the open row of a bank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Burst {
    /// The bank.
    pub bank: u64,
    /// The row that is meant, where it is said.
    pub row: Option<u64>,
    /// The column of the first beat.
    pub column: u64,
    /// How many beats, of a column each.
    pub beats: u64,
}

/// Where data go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the memory.
    Read,
    /// Into the memory.
    Write,
}

/// A burst in time.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    /// The clock of its RD or WR.
    clock: u64,
    /// The clock of its first beat.
    begin: u64,
    beats: u64,
}

impl Transfer {
    /// The clock after its last beat.
    fn end(self) -> u64 {
        self.begin.saturating_add(self.beats)
    }
}

/// The last commands of a bank.
#[derive(Clone, Copy, Debug, Default)]
struct Bank {
    open_row: Option<u64>,
    activated: Option<u64>,
    precharged: Option<u64>,
    /// The last burst of the open row, by [`Direction`].
    bursts: [Option<Transfer>; 2],
}

/// Judges the commands of one memory, in their order. It begins with all banks closed.
///
/// It holds the last commands of each bank and the last bursts, so its size does not grow.
#[derive(Clone, Debug)]
pub struct Checker {
    timing: Timing,
    banks: Vec<Bank>,
    last: Option<u64>,
    activated: Option<u64>,
    refreshed: Option<u64>,
    refreshes: u64,
    /// The last CL + 1 bursts of any bank. Data of earlier ones are over by the next command, since their data
    /// follow one another and each has a beat at least.
    bursts: VecDeque<Transfer>,
    /// Transfers that wait for their data, by [`Direction`].
    waiting: [VecDeque<Transfer>; 2],
    /// Data were reported.
    reports: bool,
}

impl Checker {
    /// The judge of a memory.
    ///
    /// # Panics
    /// If there are so many banks that no list can hold them.
    #[must_use]
    pub fn new(timing: Timing) -> Self {
        Self {
            timing,
            banks: vec![Bank::default(); timing.banks as usize],
            last: None,
            activated: None,
            refreshed: None,
            refreshes: 0,
            bursts: VecDeque::new(),
            waiting: [VecDeque::new(), VecDeque::new()],
            reports: false,
        }
    }

    /// A command in a clock. After a violation it goes on as if the command had been obeyed.
    ///
    /// # Errors
    /// The first rule that the command violates.
    pub fn check(&mut self, clock: u64, command: Command) -> Result<(), Violation> {
        let verdict = self.judge(clock, command);
        self.obey(clock, command);
        verdict.map_err(|(rule, at, limit)| Violation { rule, clock, command: Some(command), at, limit })
    }

    fn judge(&self, clock: u64, command: Command) -> Result<(), Finding> {
        let timing = &self.timing;
        after(Rule::Clock, clock, self.last, 1)?;
        after(Rule::Trfc, clock, self.refreshed, timing.t_rfc)?;
        match command {
            Command::Activate { bank, row } => {
                let bank = self.bank(bank)?;
                below(Rule::Row, row, timing.rows)?;
                if bank.open_row.is_some() {
                    return Err((Rule::OpenBank, bank.activated.unwrap_or(0), 0));
                }
                after(Rule::Trp, clock, bank.precharged, timing.t_rp)?;
                after(Rule::Trc, clock, bank.activated, timing.t_rc)?;
                after(Rule::Trrd, clock, self.activated, timing.t_rrd)
            }
            Command::Read(burst) => self.judge_burst(burst, self.transfer(clock, Direction::Read, burst)),
            Command::Write(burst) => self.judge_burst(burst, self.transfer(clock, Direction::Write, burst)),
            Command::Precharge { bank: Some(bank) } => self.judge_precharge(clock, self.bank(bank)?),
            Command::Precharge { bank: None } => {
                self.banks.iter().try_for_each(|&bank| self.judge_precharge(clock, bank))
            }
            Command::Refresh => self.judge_refresh(clock),
        }
    }

    fn judge_burst(&self, burst: Burst, transfer: Transfer) -> Result<(), Finding> {
        let Burst { bank, row, column, beats } = burst;
        let timing = &self.timing;
        let bank = self.bank(bank)?;
        below(Rule::Column, column, timing.columns_a_row)?;
        if beats == 0 {
            return Err((Rule::BurstEmpty, beats, 1));
        }
        let most = timing.columns_a_row - column;
        if beats > most {
            return Err((Rule::BurstLeavesRow, column, most));
        }
        let Some(open_row) = bank.open_row else {
            return Err((Rule::ClosedBank, bank.precharged.unwrap_or(0), 0));
        };
        if row.is_some_and(|row| row != open_row) {
            return Err((Rule::OtherRow, open_row, 0));
        }
        after(Rule::Trcd, transfer.clock, bank.activated, timing.t_rcd)?;
        for other in &self.bursts {
            let shared = other.begin.max(transfer.begin);
            if shared < other.end().min(transfer.end()) {
                return Err((Rule::DataBus, other.clock, shared));
            }
        }
        match self.bursts.back() {
            Some(last) if timing.burst_cut > 0 => {
                after(Rule::BurstCut, transfer.clock, Some(last.clock), last.beats)
            }
            _ => Ok(()),
        }
    }

    fn judge_precharge(&self, clock: u64, bank: Bank) -> Result<(), Finding> {
        if bank.open_row.is_none() {
            return Ok(());
        }
        let [read, written] = bank.bursts;
        after(Rule::Tras, clock, bank.activated, self.timing.t_ras)?;
        after(Rule::Twr, clock, written.map(Transfer::end), self.timing.t_wr)?;
        read.map_or(Ok(()), |read| after(Rule::ReadCut, clock, Some(read.clock), read.beats))
    }

    fn judge_refresh(&self, clock: u64) -> Result<(), Finding> {
        if let Some(open) = self.banks.iter().find(|bank| bank.open_row.is_some()) {
            return Err((Rule::RefreshOpen, open.activated.unwrap_or(0), 0));
        }
        let precharged = self.banks.iter().filter_map(|bank| bank.precharged).max();
        after(Rule::Trp, clock, precharged, self.timing.t_rp)?;
        if self.timing.t_refi == 0 {
            return Err((Rule::RefreshOff, clock, 0));
        }
        let number = self.refreshes + 1;
        let earliest = number.saturating_mul(self.timing.t_refi);
        if clock < earliest {
            return Err((Rule::RefreshEarly, number, earliest));
        }
        self.judge_overdue(clock)
    }

    /// The next refresh is not overdue.
    fn judge_overdue(&self, clock: u64) -> Result<(), Finding> {
        let number = self.refreshes + 1;
        let latest = (number + 1).saturating_mul(self.timing.t_refi);
        let is_overdue = self.timing.t_refi > 0 && clock > latest;
        if is_overdue { Err((Rule::RefreshLate, number, latest)) } else { Ok(()) }
    }

    /// What there is of a bank, if there is such a bank.
    fn bank(&self, number: u64) -> Result<Bank, Finding> {
        below(Rule::Bank, number, self.timing.banks)?;
        Ok(self.banks[number as usize])
    }

    fn transfer(&self, clock: u64, direction: Direction, burst: Burst) -> Transfer {
        let latency = self.latency(direction);
        Transfer { clock, begin: clock.saturating_add(latency), beats: burst.beats }
    }

    /// From the command to its first beat.
    fn latency(&self, direction: Direction) -> u64 {
        match direction {
            Direction::Read => self.timing.cl,
            Direction::Write => 0,
        }
    }

    fn obey(&mut self, clock: u64, command: Command) {
        self.last = Some(clock);
        match command {
            Command::Activate { bank, row } => {
                self.activated = Some(clock);
                if let Some(bank) = self.banks.get_mut(bank as usize) {
                    (bank.open_row, bank.activated, bank.bursts) = (Some(row), Some(clock), [None; 2]);
                }
            }
            Command::Read(burst) => self.begin(clock, Direction::Read, burst),
            Command::Write(burst) => self.begin(clock, Direction::Write, burst),
            Command::Precharge { bank } => {
                let chosen = |number: u64| bank.is_none_or(|bank| bank == number);
                for (_, bank) in (0..).zip(&mut self.banks).filter(|(number, _)| chosen(*number)) {
                    (bank.open_row, bank.precharged) = (None, Some(clock));
                }
            }
            Command::Refresh => (self.refreshed, self.refreshes) = (Some(clock), self.refreshes + 1),
        }
    }

    /// A burst takes the column path, its clocks of the data bus, and waits for its data.
    fn begin(&mut self, clock: u64, direction: Direction, burst: Burst) {
        let transfer = self.transfer(clock, direction, burst);
        if let Some(bank) = self.banks.get_mut(burst.bank as usize) {
            bank.bursts[direction as usize] = Some(transfer);
        }
        self.bursts.push_back(transfer);
        if self.bursts.len() as u64 > self.timing.cl.saturating_add(1) {
            self.bursts.pop_front();
        }
        let waiting = &mut self.waiting[direction as usize];
        waiting.push_back(transfer);
        if waiting.len() > WAITING {
            waiting.pop_front();
        }
    }

    /// The data of a transfer lay on the bus in the clocks `begin..end`. To report data is optional. Who
    /// does, reports those of each RD and WR, after its command; the directions each in their own order.
    ///
    /// # Errors
    /// The data are not those of the first transfer that waits, or not where they have to be.
    pub fn data(&mut self, begin: u64, end: u64, direction: Direction) -> Result<(), Violation> {
        self.reports = true;
        let violation = |(rule, at, limit)| Violation { rule, clock: begin, command: None, at, limit };
        let latency = self.latency(direction);
        let waiting = &mut self.waiting[direction as usize];
        let Some(&first) = waiting.front() else {
            return Err(violation((Rule::DataUnasked, begin, 0)));
        };
        // Those before a transfer that fits were left out.
        let is_this = |transfer: &Transfer| (transfer.begin, transfer.end()) == (begin, end);
        waiting.drain(..=waiting.iter().position(is_this).unwrap_or(0));
        if begin != first.begin {
            let rule = match direction {
                Direction::Read => Rule::Cl,
                Direction::Write => Rule::WriteLatency,
            };
            return Err(violation((rule, first.clock, latency)));
        }
        if end != first.end() {
            return Err(violation((Rule::DataLength, first.clock, first.beats)));
        }
        Ok(())
    }

    /// The run ends in a clock.
    ///
    /// # Errors
    /// A refresh is overdue; or data were reported, but not all that began before the end.
    pub fn finish(&self, clock: u64) -> Result<(), Violation> {
        let missing = self.waiting.iter().flatten().find(|transfer| self.reports && transfer.begin < clock);
        let verdict = match missing {
            Some(transfer) => Err((Rule::DataMissing, transfer.clock, transfer.beats)),
            None => Ok(()),
        };
        let verdict = self.judge_overdue(clock).and(verdict);
        verdict.map_err(|(rule, at, limit)| Violation { rule, clock, command: None, at, limit })
    }
}
