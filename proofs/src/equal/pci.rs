//! The twin of the bus to the host that knows each transfer's times at once: `saarcor_fast::pci`.
//!
//! Whole runs of three transfers. In each cycle the specification's bus lets a transfer arrive, takes
//! the requests of the cycle, and begins the next one; the twin is asked once a request.

use crate::draw::WORDS;
use crate::{check_eq, cover, theorems};
use saarcor_model::time::{Pci, PciConfig};

theorems! {
    /// The bus that knows each transfer's times at once is the bus that goes cycle by cycle.
    #["PC-1", not_for_kani "the specification goes cycle by cycle, over a queue", covers ["a transfer that waits", "a bus that was free"]]
    fn fast_bus_takes_the_same_time(s) {
        let config = PciConfig {
            setup: s.value("set-up", 0..=40, &WORDS[..2]),
            beat_bytes: s.value("bytes a beat", 1..=8, &WORDS[2..4]),
            cycles_a_beat: s.value("cycles a beat", 1..=16, &WORDS[1..3]),
        };
        let mut fast = saarcor_fast::pci::Pci::new(config);
        let (mut now, mut requests, mut expected) = (0, Vec::new(), Vec::new());
        for _ in 0..3 {
            now += u64::from(s.value("cycles to the request", 0..=200_u32, &[0, 1, 6]));
            let bytes = u64::from(s.value("bytes", 1..=128_u32, &[1, 4, 7]));
            let span = fast.load(now, bytes);
            cover!(s, "a transfer that waits", span.begin > now);
            cover!(s, "a bus that was free", span.begin == now);
            requests.push((now, bytes));
            expected.push(span);
        }
        let mut slow = Pci::new(config);
        let mut spans = Vec::new();
        for cycle in 0..=expected[2].end {
            slow.has_arrived(cycle);
            requests.iter().filter(|(now, _)| *now == cycle).for_each(|(_, bytes)| slow.request(*bytes));
            spans.extend(slow.start(cycle));
        }
        check_eq!(expected, spans, "{requests:?} on {config:?}");
    }
}
