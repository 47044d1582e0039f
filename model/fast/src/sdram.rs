//! The memory chips, each transfer in closed form. Twin of `saarcor_model::time::Sdram`: requests are
//! served in the order in which they come, so every time is known as soon as a request comes (SD-1 to
//! SD-5).

use saarcor_model::time::{Direction, SdramConfig, Span};

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
    /// First clock at which the next read or write command may be given.
    may_command: u64,
    next_refresh: u64,
}

impl Sdram {
    /// The memory at cycle 0, with all rows closed.
    #[must_use]
    pub fn new(config: SdramConfig) -> Self {
        Self {
            config,
            banks: vec![Bank::default(); config.banks as usize],
            bus_free: 0,
            may_command: 0,
            next_refresh: match config.refresh_interval {
                0 => u64::MAX,
                interval => u64::from(interval),
            },
        }
    }

    /// Serves a request for `bytes > 0` bytes at `addr` that comes in cycle `now`, after all
    /// requests before it: when its data are on the bus, first to last beat. A request that leaves
    /// its row is one request a row.
    pub fn transfer(&mut self, now: u64, addr: u64, bytes: u64, direction: Direction) -> Span {
        let row = u64::from(self.config.row_bytes);
        let comes = now.div_ceil(u64::from(self.config.cycles_a_clock));
        let (mut addr, end) = (addr, addr + bytes);
        let mut span: Option<Span> = None;
        while addr < end {
            let here = end.min((addr / row + 1) * row) - addr;
            let Span { begin, end } = self.in_row(comes, addr, self.config.beats(addr, here), direction);
            span = Some(Span { begin: span.map_or(begin, |span| span.begin), end });
            addr += here;
        }
        let cycles = u64::from(self.config.cycles_a_clock);
        let Span { begin, end } = span.unwrap_or(Span { begin: comes, end: comes });
        Span { begin: begin * cycles, end: end * cycles }
    }

    /// The clocks of a request that stays in one row.
    fn in_row(&mut self, comes: u64, addr: u64, beats: u64, direction: Direction) -> Span {
        while self.next_refresh <= comes {
            self.refresh();
        }
        let config = self.config;
        let row = addr / u64::from(config.row_bytes);
        let banks = u64::from(config.banks);
        let (bank, row) = (&mut self.banks[(row & (banks - 1)) as usize], row / banks);
        // SD-3: when the row is open for commands.
        let mut ready = comes;
        if bank.open != Some(row) {
            let closed = match bank.open {
                Some(_) => comes.max(bank.may_close) + u64::from(config.precharge),
                None => comes,
            };
            let opened = closed.max(bank.may_open);
            bank.open = Some(row);
            bank.may_open = opened + u64::from(config.row_cycle);
            ready = opened + u64::from(config.ras_to_cas);
        }
        // SD-4: the command, such that the data follow those of the request before.
        let latency = match direction {
            Direction::Read => u64::from(config.cas),
            Direction::Write => 0,
        };
        let command = ready.max(self.may_command).max(self.bus_free.saturating_sub(latency));
        let (begin, end) = (command + latency, command + latency + beats);
        let may_close = match direction {
            Direction::Read => command + beats,
            Direction::Write => end + u64::from(config.write_recovery),
        };
        bank.may_close = bank.may_close.max(may_close);
        self.may_command = command + 1;
        self.bus_free = end;
        Span { begin, end }
    }

    /// SD-5: all that came before is done, all rows are closed, then the chips refresh.
    fn refresh(&mut self) {
        let done = self.banks.iter().map(|bank| bank.may_close).fold(self.bus_free, u64::max);
        let begin = done.max(self.next_refresh);
        // It takes its clock, however short it is.
        let end = begin + (u64::from(self.config.precharge) + u64::from(self.config.refresh)).max(1);
        for bank in &mut self.banks {
            *bank = Bank { open: None, may_open: end.max(bank.may_open), may_close: end };
        }
        self.next_refresh += u64::from(self.config.refresh_interval);
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
