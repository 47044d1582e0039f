//! Theorems of what a run is counted by.

use crate::draw::WORDS;
use crate::source::Source;
use crate::{assume, check_eq, cover, theorems};
use saarcor_model::time::{CacheReport, TimingReport, UnitReport};

/// Any number. Small scope: 0 to 2.
fn number(s: &mut impl Source, name: &'static str) -> u64 {
    u64::from(s.value(name, 0..=u32::MAX, &WORDS[..3]))
}

theorems! {
    /// Hits, lines in flight and misses add up to the accesses, stalls of all causes to the stalled
    /// cycles, and the bytes of the four causes to those of the on-board memory.
    #["CH-18", unwind 7, covers ["hits", "merged", "stalled"]]
    fn counters_add_up(s) {
        let cache = CacheReport { accesses: number(s, "accesses"), merged: number(s, "merged"), misses: number(s, "misses") };
        assume!(cache.merged + cache.misses <= cache.accesses);
        cover!(s, "hits", cache.hits() > 0);
        cover!(s, "merged", cache.merged > 0);
        check_eq!(cache.hits() + cache.merged + cache.misses, cache.accesses, "{cache:?}");
        let stalls = [(); 5].map(|()| number(s, "stalls"));
        let unit = UnitReport { stalls, ..UnitReport::default() };
        cover!(s, "stalled", unit.stalled() > 0);
        let [a, b, c, d, e] = stalls;
        check_eq!(unit.stalled(), a + b + c + d + e, "{unit:?}");
        let (l1_fill_bytes, vm_fill_bytes, pci_bytes) = (a, b, e);
        let (metadata_read_bytes, metadata_write_back_bytes) = (c, d);
        let report = TimingReport {
            l1_fill_bytes,
            vm_fill_bytes,
            metadata_read_bytes,
            metadata_write_back_bytes,
            pci_bytes,
            ..TimingReport::default()
        };
        check_eq!(report.memory_bytes(), a + b + c + d, "{stalls:?}");
    }
}
