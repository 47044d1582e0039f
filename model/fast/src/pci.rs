//! The bus to the host, each transfer in closed form. Twin of `saarcor_model::time::Pci`.

use saarcor_model::time::{PciConfig, Span};

/// The bus: one transfer at a time, in the order in which they are asked for (PC-1).
#[derive(Clone, Debug)]
pub struct Pci {
    config: PciConfig,
    free: u64,
}

impl Pci {
    /// The bus at cycle 0.
    #[must_use]
    pub fn new(config: PciConfig) -> Self {
        Self { config, free: 0 }
    }

    /// Loads `bytes` that are asked for in cycle `now`: when the bus is busy with them.
    pub fn load(&mut self, now: u64, bytes: u64) -> Span {
        let begin = now.max(self.free);
        self.free = begin + self.config.cycles(bytes);
        Span { begin, end: self.free }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_transfer_at_a_time() {
        let mut pci = Pci::new(PciConfig::BITS_32_AT_33_MHZ);
        assert_eq!(pci.load(10, 128), Span { begin: 10, end: 560 });
        assert_eq!(pci.load(20, 128), Span { begin: 560, end: 1110 });
        assert_eq!(pci.load(2000, 4), Span { begin: 2000, end: 2054 });
    }
}
