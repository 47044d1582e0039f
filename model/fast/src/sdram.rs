//! The memory chips, each transfer in closed form. Twin of `saarcor_model::time::Sdram`: requests are
//! served in the order in which they come, and the commands of later ones take the clocks that are left,
//! so every time is known as soon as a request comes (SD-1 to SD-5).

use saarcor_model::time::{Burst, Command, Direction, SdramConfig, Span};
use std::collections::VecDeque;

#[derive(Clone, Copy, Debug, Default)]
struct Bank {
    open: Option<u64>,
    /// First clock at which a row may be opened, and closed.
    may_open: u64,
    may_close: u64,
}

/// The memory chips, and what is promised to the requests so far.
#[derive(Clone, Debug)]
pub struct Sdram {
    config: SdramConfig,
    banks: Vec<Bank>,
    /// First clock at which the data bus is free.
    bus_free: u64,
    /// First clock at which a row of any bank may be opened.
    may_open: u64,
    /// Clock of the last read or write command: the next is not given before it, and not in it, as a
    /// clock has one command.
    may_move: u64,
    next_refresh: u64,
    /// The commands of requests so far that are still to be given, and some that were, by their clocks.
    commands: VecDeque<(u64, Command)>,
}

impl Sdram {
    /// The memory at cycle 0, with all rows closed.
    #[must_use]
    pub fn new(config: SdramConfig) -> Self {
        Self {
            config,
            banks: vec![Bank::default(); config.banks as usize],
            bus_free: 0,
            may_open: 0,
            may_move: 0,
            next_refresh: match config.refresh_interval {
                0 => u64::MAX,
                interval => u64::from(interval),
            },
            commands: VecDeque::new(),
        }
    }

    /// Serves a request for `bytes > 0` bytes at `addr` that comes in cycle `now`, after all
    /// requests before it: when its data are on the bus, first to last beat. A request that leaves
    /// its row is one request a row.
    pub fn transfer(&mut self, now: u64, addr: u64, bytes: u64, direction: Direction) -> Span {
        let row = u64::from(self.config.row_bytes);
        let comes = self.refresh_until(now);
        let (mut addr, end) = (addr, addr + bytes);
        let mut span: Option<Span> = None;
        while addr < end {
            let here = end.min((addr / row + 1) * row) - addr;
            let Span { begin, end } = self.in_row(comes, addr, here, direction);
            span = Some(Span { begin: span.map_or(begin, |span| span.begin), end });
            addr += here;
        }
        let cycles = u64::from(self.config.cycles_a_clock);
        let Span { begin, end } = span.unwrap_or(Span { begin: comes, end: comes });
        Span { begin: begin * cycles, end: end * cycles }
    }

    /// Takes the next command, with its clock, of those that are given before cycle `now`. Later requests
    /// do not change them. Of them, the owner takes all before each request: they are kept until then.
    pub fn take_command(&mut self, now: u64) -> Option<(u64, Command)> {
        let (clock, _) = *self.commands.front()?;
        if clock * u64::from(self.config.cycles_a_clock) < now { self.commands.pop_front() } else { None }
    }

    /// The refreshes that are due at the first clock from cycle `now` on, or before it; this clock.
    pub fn refresh_until(&mut self, now: u64) -> u64 {
        let clock = now.div_ceil(u64::from(self.config.cycles_a_clock));
        while self.next_refresh <= clock {
            self.refresh();
        }
        clock
    }

    /// The clocks of the `bytes` at `addr` of a request, which lie in one row.
    fn in_row(&mut self, comes: u64, addr: u64, bytes: u64, direction: Direction) -> Span {
        let config = self.config;
        let beats = config.beats(addr, bytes);
        let row_bytes = u64::from(config.row_bytes);
        let banks = u64::from(config.banks);
        let (number, row) = (((addr / row_bytes) & (banks - 1)) as usize, addr / row_bytes / banks);
        // SD-3: when the row is open for commands.
        let mut ready = comes.max(self.may_move);
        let bank = self.banks[number];
        if bank.open != Some(row) {
            let mut may_open = comes.max(bank.may_open).max(self.may_open);
            if bank.open.is_some() {
                let closed = self.give(comes.max(bank.may_close), Command::Close(number));
                may_open = may_open.max(closed + u64::from(config.precharge));
            }
            let opened = self.give(may_open, Command::Open(number, row));
            self.may_open = opened + u64::from(config.row_to_row);
            self.banks[number] = Bank {
                open: Some(row),
                may_open: opened + u64::from(config.row_cycle),
                may_close: opened + u64::from(config.row_active),
            };
            ready = ready.max(opened + u64::from(config.ras_to_cas));
        }
        // SD-4: the command, such that the data follow those of the request before.
        let latency = match direction {
            Direction::Read => u64::from(config.cas),
            Direction::Write => 0,
        };
        let column = addr % row_bytes / u64::from(config.beat_bytes);
        let burst = Burst { bank: number, row, column, beats, direction };
        let command = self.give(ready.max(self.bus_free.saturating_sub(latency)), Command::Move(burst));
        let (begin, end) = (command + latency, command + latency + beats);
        let may_close = match direction {
            Direction::Read => command + beats,
            Direction::Write => end + u64::from(config.write_recovery),
        };
        let bank = &mut self.banks[number];
        bank.may_close = bank.may_close.max(may_close);
        self.may_move = command;
        self.bus_free = end;
        Span { begin, end }
    }

    /// SD-5: all that came before is done, all rows are closed, then the chips refresh.
    fn refresh(&mut self) {
        let mut clock = self.bus_free.max(self.next_refresh);
        if self.banks.iter().any(|bank| bank.open.is_some()) {
            let may_close = self.banks.iter().map(|bank| bank.may_close).fold(clock, u64::max);
            clock = self.give(may_close, Command::CloseAll) + u64::from(self.config.precharge);
        }
        let may_open = self.banks.iter().map(|bank| bank.may_open).fold(clock, u64::max);
        let refreshed = self.give(may_open, Command::Refresh) + u64::from(self.config.refresh);
        for bank in &mut self.banks {
            *bank = Bank { open: None, may_open: refreshed, may_close: bank.may_close };
        }
        self.next_refresh += u64::from(self.config.refresh_interval);
    }

    /// Gives a command in the first clock from `clock` on in which no other is given; this clock.
    fn give(&mut self, mut clock: u64, command: Command) -> u64 {
        // Most follow all others, or all but a few.
        let mut place = self.commands.len();
        while place > 0 && self.commands[place - 1].0 >= clock {
            place -= 1;
        }
        while self.commands.get(place).is_some_and(|&(other, _)| other == clock) {
            (place, clock) = (place + 1, clock + 1);
        }
        self.commands.insert(place, (clock, command));
        clock
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random reads of triangles saturate near 60 % of the peak, as Table 2's Cruiser does
    /// without virtual memory: 1.38 to 1.39 GB/s.
    #[test]
    fn random_triangle_reads_reach_a_plateau() {
        let mut sdram = Sdram::new(SdramConfig::STANDARD);
        let mut state = 1_u64;
        let mut end = 0;
        let reads = 100_000;
        for _ in 0..reads {
            // Knuth's linear congruential generator (MMIX).
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            end = sdram.transfer(0, (state >> 33) % 1_000_000 * 36, 36, Direction::Read).end;
        }
        let part = (reads * 3 * 4) as f64 / end as f64;
        assert!((0.55..0.75).contains(&part), "{part} of the peak");
    }
}
