//! Theorems of the bus to the host (PC-1).

use crate::draw::{BYTES, WORDS, flag};
use crate::{check, check_eq, cover, theorems};
use saarcor_model::time::{Pci, PciConfig, Span};

theorems! {
    /// A transfer over the bus takes its set-up, and then the fewest beats that hold its bytes.
    #["PC-1", unwind 4, covers ["one beat", "a last beat that is not full", "the fast bus"]]
    fn transfer_takes_set_up_and_whole_beats(s) {
        let fast = s.value("bus (slow, fast)", 0..=1, &BYTES[..2]) == 1;
        let (bus, beat, cycles_a_beat) =
            if fast { (PciConfig::BITS_64_AT_66_MHZ, 8, 8) } else { (PciConfig::BITS_32_AT_33_MHZ, 4, 16) };
        let bytes = u64::from(s.value("bytes", 1..=u16::MAX, &[1, 3, 4, 5, 7, 8, 9, 127, 128, 129, u16::MAX]));
        let cycles = bus.cycles(bytes);
        let setup = u64::from(bus.setup);
        check!(cycles >= setup && (cycles - setup) % cycles_a_beat == 0, "{bytes} bytes, fast: {fast}: {cycles} cycles");
        let beats = (cycles - setup) / cycles_a_beat;
        cover!(s, "one beat", beats == 1);
        cover!(s, "a last beat that is not full", beats * beat > bytes);
        cover!(s, "the fast bus", fast);
        check!(beats * beat >= bytes && (beats - 1) * beat < bytes, "{bytes} bytes, fast: {fast}: {beats} beats");
    }

    /// The bus carries one transfer at a time, in the order of the requests: from any state, none begins while one is
    /// on the bus, and in the cycle in which that one arrives the first that waits begins, with its own set-up.
    #["PC-1", unwind 6, covers ["one is on the bus", "one arrives and the next begins", "the bus was free", "nothing waits"]]
    fn bus_carries_one_transfer_at_a_time(s) {
        let config = PciConfig {
            setup: s.value("set-up", 0..=u32::MAX, &[0, 1, 70_000]),
            // Kani sees the beat of the slow bus: those of others are divisions by symbols.
            beat_bytes: if cfg!(kani) { 4 } else { s.value("bytes a beat", 1..=64, &[1, 3, 8]) },
            cycles_a_beat: s.value("cycles a beat", 1..=255, &[1, 16]),
        };
        let now = u64::from(s.value("cycle", 0..=u32::MAX, &[0, 20]));
        let arrival = now + u64::from(s.value("cycles until it arrives", 0..=u32::MAX, &WORDS[..3]));
        let busy = flag(s, "one on the bus");
        let mut pci = Pci::new(config);
        pci.arrival = busy.then_some(arrival);
        let waiting = s.value("transfers that wait", 0..=2, &BYTES[..3]);
        let mut bytes = [0_u64; 2];
        for i in 0..2 {
            bytes[i] = s.value("bytes", 1..=4096_u32, &[1, 4, 17]).into();
            if i < usize::from(waiting) {
                pci.request(bytes[i]);
            }
        }
        let arrives = pci.has_arrived(now);
        let span = pci.start(now);
        check_eq!(arrives, busy && arrival == now, "arrives in {now}, there in {arrival}, busy: {busy}");
        let free = !busy || arrives;
        cover!(s, "one is on the bus", !free && waiting > 0);
        cover!(s, "one arrives and the next begins", arrives && waiting == 2);
        cover!(s, "the bus was free", !busy && waiting > 0);
        cover!(s, "nothing waits", free && waiting == 0);
        // The fewest beats that hold the bytes.
        let beat = u64::from(config.beat_bytes);
        let cycles_of = |bytes: u64| {
            let beats = if cfg!(kani) { (bytes + 3) >> 2 } else { bytes.div_ceil(beat) };
            u64::from(config.setup) + beats * u64::from(config.cycles_a_beat)
        };
        let end = now + cycles_of(bytes[0]);
        let expected = (free && waiting > 0).then_some(Span { begin: now, end });
        check_eq!(span, expected, "{bytes:?}, of which {waiting} wait, in cycle {now}, free: {free}, {config:?}");
        let left = usize::from(waiting) - usize::from(span.is_some());
        let on_bus = if free { expected.map(|span| span.end) } else { Some(arrival) };
        let same = left < 2 || pci.waiting[0] == bytes[0];
        let last = left == 0 || pci.waiting[left - 1] == bytes[usize::from(waiting) - 1];
        check!(pci.waiting.len() == left && same && last && pci.arrival == on_bus, "{bytes:?}, {waiting} waited, in cycle {now}: {pci:?}");
        if span.is_some() && left == 1 {
            let next = Span { begin: end, end: end + cycles_of(bytes[1]) };
            let follows = pci.has_arrived(end) && pci.start(end) == Some(next);
            check!(follows, "{bytes:?}: the second does not follow at once, as {next:?}, {config:?}: {pci:?}");
        }
    }

    /// A line of 128 bytes takes 550 cycles over the slow bus, as the paper states, and 166 over the
    /// fast one.
    #["PC-1", unwind 4, covers ["slow", "fast"]]
    fn line_over_the_bus_takes_the_papers_time(s) {
        let fast = s.value("bus (slow, fast)", 0..=1, &BYTES[..2]) == 1;
        let (bus, cycles) = if fast { (PciConfig::BITS_64_AT_66_MHZ, 166) } else { (PciConfig::BITS_32_AT_33_MHZ, 550) };
        cover!(s, "slow", !fast);
        cover!(s, "fast", fast);
        check_eq!(bus.cycles(128), cycles, "{bus:?}");
    }
}
