//! Theorems of the bus to the host (PC-1).

use crate::draw::BYTES;
use crate::{check, check_eq, cover, theorems};
use saarcor_model::time::PciConfig;

theorems! {
    /// A transfer over the bus takes its set-up, and then the fewest beats that hold its bytes.
    #["PC-1", unwind 4, covers ["one beat", "a last beat that is not full", "the fast bus"]]
    fn transfer_takes_set_up_and_whole_beats(s) {
        let fast = s.value("bus (slow, fast)", 0..=1, &BYTES[..2]) == 1;
        let (bus, beat, cycles_a_beat) =
            if fast { (PciConfig::BITS_64_AT_66_MHZ, 8, 8) } else { (PciConfig::BITS_32_AT_33_MHZ, 4, 16) };
        let bytes = u64::from(s.value("bytes", 1..=u16::MAX, &[1, 3, 4, 5, 7, 8, 9, 127, 128, 129]));
        let cycles = bus.cycles(bytes);
        let setup = u64::from(bus.setup);
        check!(cycles >= setup && (cycles - setup) % cycles_a_beat == 0, "{bytes} bytes, fast: {fast}: {cycles} cycles");
        let beats = (cycles - setup) / cycles_a_beat;
        cover!(s, "one beat", beats == 1);
        cover!(s, "a last beat that is not full", beats * beat > bytes);
        cover!(s, "the fast bus", fast);
        check!(beats * beat >= bytes && (beats - 1) * beat < bytes, "{bytes} bytes, fast: {fast}: {beats} beats");
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
