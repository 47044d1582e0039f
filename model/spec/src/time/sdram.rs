//! The on-board memory chips (§4: 128 bit at 133 MHz, Stated) in time.
//!
//! Banks with one open row each, one data bus for all. Requests are served in the order in which
//! they come, and the rows of later ones are opened while the data of earlier ones move: so every
//! time is known as soon as a request comes (SD-1 to SD-5).

use super::standard;

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
    #[must_use]
    pub fn beats(&self, addr: u64, bytes: u64) -> u64 {
        let beat = u64::from(self.beat_bytes);
        (addr + bytes - 1) / beat - addr / beat + 1
    }

    /// Bytes that move for them: whole beats (SD-1).
    #[must_use]
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
