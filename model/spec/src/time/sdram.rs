//! The on-board memory chips (§4: 128 bit at 133 MHz, Stated) in time, clock by clock (SD-1 to SD-5).
//!
//! Banks with one open row each, and for all of them one bus of commands and one of data. Requests are
//! served in the order in which they come; the rows of later ones are opened while the data of earlier
//! ones move.

use super::standard;
use std::collections::VecDeque;

/// Sizes and times of the memory chips. Times are in memory clocks, if nothing else is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdramConfig {
    /// Core cycles a memory clock.
    pub cycles_a_clock: u32,
    /// Bytes that move in one clock: a beat. A transfer moves whole beats.
    pub beat_bytes: u32,
    /// Banks, a power of two.
    pub banks: u32,
    /// Bytes of a row of one bank, a power of two; rows that follow one another lie in different
    /// banks.
    pub row_bytes: u32,
    /// From the read command to the first beat (CL). A write's first beat comes with its command.
    pub cas: u32,
    /// From the opening of a row to the first command (tRCD).
    pub ras_to_cas: u32,
    /// To close a row (tRP).
    pub precharge: u32,
    /// From the opening of a row to its closing (tRAS).
    pub row_active: u32,
    /// From the opening of a row to the next opening in the same bank (tRC).
    pub row_cycle: u32,
    /// From the opening of a row to the next opening in any bank (tRRD).
    pub row_to_row: u32,
    /// From the last beat of a write to the closing of its row (tWR).
    pub write_recovery: u32,
    /// A refresh is due each time that so many clocks have passed; 0: never.
    pub refresh_interval: u32,
    /// Time that a refresh takes (tRFC).
    pub refresh: u32,
}

impl SdramConfig {
    /// The paper's memory chips (§4), by the numbers of [`standard`].
    pub const STANDARD: Self = Self {
        cycles_a_clock: (standard::CORE_HZ / standard::SDRAM_HZ) as u32,
        beat_bytes: standard::SDRAM_BUS_BITS / 8,
        banks: standard::BANKS,
        row_bytes: standard::ROW_BYTES,
        cas: standard::CAS,
        ras_to_cas: standard::RAS_TO_CAS,
        precharge: standard::PRECHARGE,
        row_active: standard::ROW_ACTIVE,
        row_cycle: standard::ROW_CYCLE,
        row_to_row: standard::ROW_TO_ROW,
        write_recovery: standard::WRITE_RECOVERY,
        refresh_interval: standard::REFRESH_INTERVAL,
        refresh: standard::REFRESH,
    };

    /// Beats that `bytes > 0` bytes at `addr` touch.
    pub fn beats(&self, addr: u64, bytes: u64) -> u64 {
        let beat = u64::from(self.beat_bytes);
        (addr + bytes - 1) / beat - addr / beat + 1
    }

    /// Bytes that move for them: whole beats (SD-1).
    pub fn moved(&self, addr: u64, bytes: u64) -> u64 {
        self.beats(addr, bytes) * u64::from(self.beat_bytes)
    }
}

/// Which way data move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the chip.
    Read,
    /// To the memory.
    Write,
}

/// A time on a bus, in core cycles: from `begin` on and before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first cycle.
    pub begin: u64,
    /// The first cycle after.
    pub end: u64,
}

/// Number of a transfer, in the order of the requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransferId(pub usize);

/// Beats of a transfer that lie in one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Burst {
    /// The number of the bank.
    pub bank: usize,
    /// The row's number in the bank.
    pub row: u64,
    /// The first beat's number in the row.
    pub column: u64,
    /// Beats that move.
    pub beats: u64,
    /// Which way.
    pub direction: Direction,
}

/// What the memory chips have to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// To move the next burst of a transfer.
    Move(TransferId, Burst),
    /// To refresh all rows.
    Refresh,
}

/// A command to the chips: one a clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// To open a row of a bank (ACT).
    Open(usize, u64),
    /// To move a burst in the row that is open (RD, WR).
    Move(Burst),
    /// To close the row of a bank (PRE).
    Close(usize),
    /// To close all rows (PRE of all banks).
    CloseAll,
    /// To refresh (REF).
    Refresh,
}

/// A bank, with one row open at most (SD-2, SD-3). Times are in clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Bank {
    /// The row that is open.
    pub open: Option<u64>,
    /// The first clock in which a row may be opened, if none is open.
    pub may_open: u64,
    /// The first clock in which data of its row may be commanded.
    pub may_move: u64,
    /// The first clock in which its row may be closed.
    pub may_close: u64,
}

/// The memory chips and their buses.
#[derive(Clone, Debug)]
pub struct Sdram {
    config: SdramConfig,
    /// First and last clock on the bus of each transfer, as far as its commands are given.
    transfers: Vec<Option<Span>>,
    /// Jobs whose last command is still to be given, in order.
    pub jobs: VecDeque<Job>,
    /// The banks.
    pub banks: Vec<Bank>,
    /// The clock in which the next refresh is due.
    pub refresh_due: u64,
    /// The first clock in which a row of any bank may be opened.
    pub may_open: u64,
    /// The clock from which on the bus of data is free.
    pub bus_free: u64,
    /// The commands so far, and their clocks.
    pub commands: Vec<(u64, Command)>,
}

impl Sdram {
    /// The memory at cycle 0, with all rows closed.
    pub fn new(config: SdramConfig) -> Self {
        Self {
            config,
            transfers: Vec::new(),
            jobs: VecDeque::new(),
            banks: vec![Bank::default(); config.banks as usize],
            refresh_due: config.refresh_interval.into(),
            may_open: 0,
            bus_free: 0,
            commands: Vec::new(),
        }
    }

    /// Asks for `bytes > 0` bytes at `addr` in cycle `now`, after all earlier requests. In each row that
    /// they meet, they are a job of their own (SD-2).
    pub fn request(&mut self, now: u64, addr: u64, bytes: u64, direction: Direction) -> TransferId {
        self.begin_cycle(now);
        let transfer = TransferId(self.transfers.len());
        self.transfers.push(None);
        let (row_bytes, banks) = (u64::from(self.config.row_bytes), u64::from(self.config.banks));
        for row in addr / row_bytes..=(addr + bytes - 1) / row_bytes {
            let begin = addr.max(row * row_bytes);
            let end = (addr + bytes).min((row + 1) * row_bytes);
            let column = begin % row_bytes / u64::from(self.config.beat_bytes);
            let beats = self.config.beats(begin, end - begin);
            let burst = Burst { bank: (row % banks) as usize, row: row / banks, column, beats, direction };
            self.jobs.push_back(Job::Move(transfer, burst));
        }
        transfer
    }

    /// When the data of a transfer are on the bus, once all its commands are given: transfers are served in
    /// order.
    pub fn span_of(&self, transfer: TransferId) -> Option<Span> {
        let transfer_of = |job: &Job| if let Job::Move(transfer, _) = job { Some(transfer.0) } else { None };
        if self.jobs.iter().find_map(transfer_of).is_some_and(|first| first <= transfer.0) {
            return None;
        }
        let cycles = u64::from(self.config.cycles_a_clock);
        self.transfers[transfer.0]
            .map(|Span { begin, end }| Span { begin: begin * cycles, end: end * cycles })
    }

    /// Whether a transfer ended `latency` cycles before cycle `now`, or earlier.
    pub fn is_over(&self, transfer: TransferId, latency: u64, now: u64) -> bool {
        self.span_of(transfer).is_some_and(|span| span.end + latency <= now)
    }

    /// Begins a cycle. Refreshes that are due at the next clock come before its requests (SD-5).
    pub fn begin_cycle(&mut self, now: u64) {
        let interval = u64::from(self.config.refresh_interval);
        while interval != 0 && self.refresh_due <= now.div_ceil(self.config.cycles_a_clock.into()) {
            self.jobs.push_back(Job::Refresh);
            self.refresh_due += interval;
        }
    }

    /// Ends a cycle: if a clock began with it, the chips get its command.
    pub fn end_cycle(&mut self, now: u64) {
        let cycles = u64::from(self.config.cycles_a_clock);
        if now.is_multiple_of(cycles)
            && let Some(command) = self.next_command(now / cycles)
        {
            self.commands.push((now / cycles, command));
            self.obey(now / cycles, command);
        }
    }

    /// The command of a clock: that of the first job to which one may be given (SD-4). A bank serves its
    /// jobs in order, and a refresh holds up all that comes after it.
    fn next_command(&self, clock: u64) -> Option<Command> {
        if self.jobs.front() == Some(&Job::Refresh) {
            return self.next_of_refresh(clock);
        }
        let first_of = |bank: usize| self.bursts().enumerate().find(|(_, burst)| burst.bank == bank);
        let first_jobs = (0..self.banks.len()).filter_map(first_of);
        let given = first_jobs.filter_map(|(place, burst)| Some((place, self.next_of(place, burst, clock)?)));
        given.min_by_key(|(place, _)| *place).map(|(_, command)| command)
    }

    /// The bursts before the next refresh, in order.
    fn bursts(&self) -> impl Iterator<Item = Burst> {
        self.jobs.iter().map_while(|job| if let Job::Move(_, burst) = *job { Some(burst) } else { None })
    }

    /// The command for the first burst of a bank, which has a place among all, if it may be given (SD-3).
    fn next_of(&self, place: usize, burst: Burst, clock: u64) -> Option<Command> {
        let bank = &self.banks[burst.bank];
        let is_open = |burst: Burst| self.banks[burst.bank].open == Some(burst.row);
        let (may, command) = if is_open(burst) {
            let data_follow = self.first_beat(burst.direction, clock) >= self.bus_free;
            (place == 0 && clock >= bank.may_move && data_follow, Command::Move(burst))
        } else if bank.open.is_some() {
            (clock >= bank.may_close, Command::Close(burst.bank))
        } else {
            let may_open = clock >= bank.may_open.max(self.may_open);
            (may_open && self.bursts().take(place).all(is_open), Command::Open(burst.bank, burst.row))
        };
        may.then_some(command)
    }

    /// Once all data have moved, all rows are closed, and then the chips refresh (SD-5).
    fn next_of_refresh(&self, clock: u64) -> Option<Command> {
        if clock < self.bus_free {
            None
        } else if self.banks.iter().any(|bank| bank.open.is_some()) {
            self.banks.iter().all(|bank| clock >= bank.may_close).then_some(Command::CloseAll)
        } else {
            self.banks.iter().all(|bank| clock >= bank.may_open).then_some(Command::Refresh)
        }
    }

    /// When the data of a command are on the bus, from the first beat on.
    fn first_beat(&self, direction: Direction, clock: u64) -> u64 {
        match direction {
            Direction::Read => clock + u64::from(self.config.cas),
            Direction::Write => clock,
        }
    }

    /// What a command changes (SD-3 to SD-5).
    fn obey(&mut self, clock: u64, command: Command) {
        let after = |clocks: u32| clock + u64::from(clocks);
        let config = self.config;
        let close = |bank: &mut Bank| {
            (bank.open, bank.may_open) = (None, bank.may_open.max(after(config.precharge)));
        };
        match command {
            Command::Open(bank, row) => {
                self.banks[bank] = Bank {
                    open: Some(row),
                    may_open: after(config.row_cycle),
                    may_move: after(config.ras_to_cas),
                    may_close: after(config.row_active),
                };
                self.may_open = after(config.row_to_row);
            }
            Command::Move(burst) => self.move_burst(clock, burst),
            Command::Close(bank) => close(&mut self.banks[bank]),
            Command::CloseAll => self.banks.iter_mut().for_each(close),
            Command::Refresh => {
                self.jobs.pop_front();
                self.banks.iter_mut().for_each(|bank| bank.may_open = after(config.refresh));
            }
        }
    }

    /// The data of the first job move.
    fn move_burst(&mut self, clock: u64, Burst { bank, beats, direction, .. }: Burst) {
        let begin = self.first_beat(direction, clock);
        let end = begin + beats;
        self.bus_free = end;
        let may_close = match direction {
            Direction::Read => clock + beats,
            Direction::Write => end + u64::from(self.config.write_recovery),
        };
        self.banks[bank].may_close = self.banks[bank].may_close.max(may_close);
        if let Some(Job::Move(transfer, _)) = self.jobs.pop_front() {
            let span = &mut self.transfers[transfer.0];
            *span = Some(Span { begin: span.map_or(begin, |span| span.begin), end });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: SdramConfig = SdramConfig { refresh_interval: 0, ..SdramConfig::STANDARD };

    fn clocks(begin: u64, end: u64) -> Span {
        Span { begin: 4 * begin, end: 4 * end }
    }

    /// When the transfers are on the bus that are asked for at these clocks.
    fn spans(config: SdramConfig, requests: &[(u64, u64, u64, Direction)]) -> Vec<Span> {
        let mut sdram = Sdram::new(config);
        let mut transfers = Vec::new();
        for now in 0..4000 {
            sdram.begin_cycle(now);
            for &(_, addr, bytes, direction) in requests.iter().filter(|request| 4 * request.0 == now) {
                transfers.push(sdram.request(now, addr, bytes, direction));
            }
            sdram.end_cycle(now);
        }
        transfers.into_iter().map(|transfer| sdram.span_of(transfer).expect("it is over")).collect()
    }

    #[test]
    fn a_triangle_is_three_beats_wherever_it_lies() {
        for triangle in 0..100 {
            assert_eq!(QUIET.beats(triangle * 36, 36), 3);
        }
        assert_eq!(QUIET.beats(8, 8), 1);
        assert_eq!(QUIET.beats(8, 36), 3);
        assert_eq!(QUIET.beats(10, 8), 2);
    }

    #[test]
    fn rows_are_opened_closed_and_kept_open() {
        let read = |clock, addr| (clock, addr, 16, Direction::Read);
        let requests = [read(0, 0), read(10, 16), read(20, 4 * 4096), read(20, 0), read(20, 4096)];
        // tRCD + CL; CL; tRP + tRCD + CL. The bank's row was opened at 23: the next at 32, after tRC, and that
        // of the other bank at 34, after tRRD.
        let expected = [clocks(6, 7), clocks(13, 14), clocks(29, 30), clocks(38, 39), clocks(40, 41)];
        assert_eq!(spans(QUIET, &requests), expected);
    }

    #[test]
    fn data_follow_one_another_without_a_gap() {
        let requests =
            [(0, 0, 128, Direction::Write), (1, 0, 36, Direction::Read), (2, 4096 - 16, 32, Direction::Read)];
        assert_eq!(spans(QUIET, &requests), [clocks(3, 11), clocks(11, 14), clocks(14, 16)]);
    }

    #[test]
    fn refresh_closes_all_rows() {
        let config = SdramConfig { refresh_interval: 100, ..QUIET };
        let requests = [(99, 0, 64, Direction::Read), (101, 0, 16, Direction::Read)];
        // The refresh that is due at 100 begins at 109, and takes tRP + tRFC.
        let second = clocks(109 + 12 + 6, 109 + 12 + 7);
        assert_eq!(spans(config, &requests), [clocks(105, 109), second]);
    }
}
