//! The bus to the host (§4) in time.

use super::sdram::Span;
use super::standard;
use std::collections::VecDeque;

/// Times of the bus, in core cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PciConfig {
    /// From a transfer's begin to its first beat.
    pub setup: u32,
    /// Bytes a beat.
    pub beat_bytes: u32,
    /// Core cycles a beat.
    pub cycles_a_beat: u32,
}

impl PciConfig {
    /// 32 bit at 33 MHz (§4, Stated). A beat takes 533 / 33 = 16 cycles, and what remains of the 550
    /// that a line of 128 bytes takes is set-up (Derived).
    pub const BITS_32_AT_33_MHZ: Self = {
        let beat_bytes = standard::PCI_BUS_BITS / 8;
        let cycles_a_beat = (standard::CORE_HZ / standard::PCI_HZ) as u32;
        let beats = standard::LINE.0 as u32 / beat_bytes;
        Self { setup: standard::PCI_LINE_CYCLES - beats * cycles_a_beat, beat_bytes, cycles_a_beat }
    };

    /// 64 bit at 66 MHz (§4, Stated), with the same set-up in core cycles (Assumed).
    pub const BITS_64_AT_66_MHZ: Self = Self {
        setup: Self::BITS_32_AT_33_MHZ.setup,
        beat_bytes: standard::FAST_PCI_BUS_BITS / 8,
        cycles_a_beat: (standard::CORE_HZ / standard::FAST_PCI_HZ) as u32,
    };

    /// Cycles of a transfer.
    ///
    /// ```
    /// use saarcor_model::time::PciConfig;
    /// assert_eq!(PciConfig::BITS_32_AT_33_MHZ.cycles(128), 550); // §4: "about 550"
    /// assert_eq!(PciConfig::BITS_64_AT_66_MHZ.cycles(128), 166);
    /// ```
    pub fn cycles(&self, bytes: u64) -> u64 {
        let beats = bytes.div_ceil(u64::from(self.beat_bytes));
        u64::from(self.setup) + beats * u64::from(self.cycles_a_beat)
    }
}

/// The bus: one transfer at a time, in the order of the requests (PC-1).
#[derive(Clone, Debug)]
pub struct Pci {
    config: PciConfig,
    /// Bytes of the transfers that have not begun, in order.
    pub waiting: VecDeque<u64>,
    /// The cycle in which the transfer on the bus has arrived.
    pub arrival: Option<u64>,
}

impl Pci {
    /// The bus before its first transfer.
    pub fn new(config: PciConfig) -> Self {
        Self { config, waiting: VecDeque::new(), arrival: None }
    }

    /// A transfer of `bytes` is asked for.
    pub fn request(&mut self, bytes: u64) {
        self.waiting.push_back(bytes);
    }

    /// Begins the next transfer, if there is one and the bus is free: when it is on the bus.
    pub fn start(&mut self, now: u64) -> Option<Span> {
        if self.arrival.is_some() {
            return None;
        }
        let end = now + self.config.cycles(self.waiting.pop_front()?);
        self.arrival = Some(end);
        Some(Span { begin: now, end })
    }

    /// Whether the transfer on the bus arrives in this cycle; the bus is free again then.
    pub fn has_arrived(&mut self, now: u64) -> bool {
        self.arrival.take_if(|arrival| *arrival == now).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_transfer_at_a_time() {
        let mut pci = Pci::new(PciConfig::BITS_32_AT_33_MHZ);
        pci.request(128);
        pci.request(4);
        assert_eq!(pci.start(10), Some(Span { begin: 10, end: 560 }));
        assert_eq!(pci.start(11), None);
        assert!(!pci.has_arrived(559));
        assert!(pci.has_arrived(560));
        assert_eq!(pci.start(560), Some(Span { begin: 560, end: 614 }));
        assert!(pci.has_arrived(614));
        assert_eq!(pci.start(614), None);
    }
}
