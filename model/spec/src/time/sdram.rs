//! The on-board memory chips (§4: 128 bit at 133 MHz, Stated) in time, clock by clock (SD-1 to SD-5).
//!
//! Banks with one open row each, one data bus for all. Requests are served in the order in which they
//! come; the rows of later ones are opened while the data of earlier ones move.

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
    /// From the opening of a row to the next opening in the same bank (tRC).
    pub row_cycle: u32,
    /// From the last beat of a write to the closing of its row (tWR).
    pub write_recovery: u32,
    /// A refresh is due each time that so many clocks have passed; 0: never.
    pub refresh_interval: u32,
    /// Time that a refresh takes once all rows are closed (tRFC).
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
        row_cycle: standard::ROW_CYCLE,
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

/// What the memory chips have to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// To move beats of a transfer that lie in one row.
    Move {
        /// The transfer.
        transfer: TransferId,
        /// The number of the bank.
        bank: usize,
        /// The row's number in the bank.
        row: u64,
        /// Beats that move.
        beats: u64,
        /// Which way.
        direction: Direction,
    },
    /// To refresh all rows.
    Refresh,
}

/// A bank, with one row open at most (SD-2, SD-3). Times are in clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Bank {
    /// The row that is open.
    pub open: Option<u64>,
    /// The clock of its last opening.
    pub opened: Option<u64>,
    /// The clock from which on it is closed, where no row is open.
    pub closed: u64,
    /// The first clock in which its row may be closed.
    pub may_close: u64,
}

/// The memory chips and their bus.
#[derive(Clone, Debug)]
pub struct Sdram {
    config: SdramConfig,
    /// First and last clock on the bus of each transfer, as far as its commands are given.
    transfers: Vec<Option<Span>>,
    /// Jobs whose command is still to be given, in order.
    pub jobs: VecDeque<Job>,
    /// The banks.
    pub banks: Vec<Bank>,
    /// The clock in which the next refresh is due.
    pub refresh_due: u64,
    /// The clock from which on the last refresh is over.
    pub refreshed: u64,
    /// The clock from which on the bus is free.
    pub bus_free: u64,
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
            refreshed: 0,
            bus_free: 0,
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
            let (bank, row) = ((row % banks) as usize, row / banks);
            let beats = self.config.beats(begin, end - begin);
            self.jobs.push_back(Job::Move { transfer, bank, row, beats, direction });
        }
        transfer
    }

    /// When the data of a transfer are on the bus, once all its commands are given.
    pub fn span_of(&self, transfer: TransferId) -> Option<Span> {
        let unfinished = |job: &Job| matches!(job, Job::Move { transfer: other, .. } if *other == transfer);
        if self.jobs.iter().any(unfinished) {
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

    /// Ends a cycle: if a clock began with it, the chips do what they may with the requests so far.
    pub fn end_cycle(&mut self, now: u64) {
        let cycles = u64::from(self.config.cycles_a_clock);
        let clock = now / cycles;
        if !now.is_multiple_of(cycles) || clock < self.refreshed {
            return;
        }
        if self.jobs.front() == Some(&Job::Refresh) {
            self.refresh(clock);
        } else {
            self.open_rows(clock);
            self.give_command(clock);
        }
    }

    /// Once all that came before is done, all rows are closed, and the chips refresh (SD-5).
    fn refresh(&mut self, clock: u64) {
        if clock < self.bus_free || self.banks.iter().any(|bank| clock < bank.may_close) {
            return;
        }
        self.jobs.pop_front();
        self.refreshed = clock + u64::from(self.config.precharge) + u64::from(self.config.refresh);
        for bank in &mut self.banks {
            bank.open = None;
            (bank.closed, bank.may_close) = (self.refreshed, self.refreshed);
        }
    }

    /// In each bank, the row of its first job is opened, and before that, another one closed (SD-3). A
    /// refresh holds up all that comes after it.
    fn open_rows(&mut self, clock: u64) {
        for (number, bank) in self.banks.iter_mut().enumerate() {
            let row_of = |job: &Job| match *job {
                Job::Move { bank, row, .. } => Some((bank == number, row)),
                Job::Refresh => None,
            };
            let first = self.jobs.iter().map_while(row_of).find(|(is_own, _)| *is_own);
            let Some((_, row)) = first else { continue };
            if bank.open.is_some_and(|open| open != row) && clock >= bank.may_close {
                bank.open = None;
                bank.closed = clock + u64::from(self.config.precharge);
            }
            let row_cycle = u64::from(self.config.row_cycle);
            let may_open = bank.opened.is_none_or(|opened| clock >= opened + row_cycle);
            if bank.open.is_none() && clock >= bank.closed && may_open {
                bank.open = Some(row);
                bank.opened = Some(clock);
            }
        }
    }

    /// The first job gets its command, if its row is open and its data follow those before (SD-4).
    fn give_command(&mut self, clock: u64) {
        let Some(&Job::Move { transfer, bank, row, beats, direction }) = self.jobs.front() else { return };
        let bank = &mut self.banks[bank];
        let ras_to_cas = u64::from(self.config.ras_to_cas);
        let is_open =
            bank.open == Some(row) && bank.opened.is_some_and(|opened| clock >= opened + ras_to_cas);
        let begin = match direction {
            Direction::Read => clock + u64::from(self.config.cas),
            Direction::Write => clock,
        };
        if !is_open || begin < self.bus_free {
            return;
        }
        self.jobs.pop_front();
        let end = begin + beats;
        self.bus_free = end;
        let may_close = match direction {
            Direction::Read => clock + beats,
            Direction::Write => end + u64::from(self.config.write_recovery),
        };
        bank.may_close = bank.may_close.max(may_close);
        let span = &mut self.transfers[transfer.0];
        *span = Some(Span { begin: span.map_or(begin, |span| span.begin), end });
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
        // tRCD + CL; CL; tRP + tRCD + CL. The bank's row was opened at 23: the next at 32, after tRC. Another
        // bank opens its row meanwhile.
        let expected = [clocks(6, 7), clocks(13, 14), clocks(29, 30), clocks(38, 39), clocks(39, 40)];
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
