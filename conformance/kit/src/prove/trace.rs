//! The requests of a trace, read from its waves.

use std::collections::BTreeMap;

/// Time from one clock to the next in the waves that Yosys writes.
const CLOCK: u64 = 10;

/// What an implementation gets in a clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// A reset.
    Reset,
    /// The byte at a host address is read.
    Read(u64),
    /// The line of a host address is invalidated.
    Invalidate(u64),
}

impl Request {
    /// The request in words.
    pub fn text(&self) -> String {
        match self {
            Self::Reset => "reset".to_owned(),
            Self::Read(address) => format!("read {address:08x}"),
            Self::Invalidate(address) => format!("invalidate {address:08x}"),
        }
    }
}

/// What the implementation gets in the first clocks. The first of all is the reset that every session begins with.
pub(super) fn requests(vcd: &str, clocks: u32) -> Vec<Request> {
    asked(vcd, clocks).into_iter().filter(|(_, is_taken)| *is_taken).map(|(request, _)| request).collect()
}

/// What it is offered in the first clocks, taken or not; what waits to be taken counts once.
pub(super) fn offered(vcd: &str, clocks: u32) -> Vec<Request> {
    let mut waits = None;
    let mut offered = Vec::new();
    for (request, is_taken) in asked(vcd, clocks) {
        if waits != Some(request) {
            offered.push(request);
        }
        waits = (!is_taken).then_some(request);
    }
    offered
}

/// What the implementation is offered in each of the first clocks, and whether it takes it.
fn asked(vcd: &str, clocks: u32) -> Vec<(Request, bool)> {
    let mut asked = Vec::new();
    at_clocks(vcd, &["reset", "accepted", "valid", "forget", "address"], |clock, values| {
        let value =
            |name: &str| values.get(name).and_then(|bits| u64::from_str_radix(bits, 2).ok()).unwrap_or(0);
        // A trace that begins with a cold set has no reset.
        if clock == 0 && value("reset") == 1 || clock >= u64::from(clocks) {
            return;
        }
        let is_taken = value("accepted") == 1;
        if value("reset") == 1 {
            asked.push((Request::Reset, true));
        } else if is_taken || value("valid") == 1 {
            let address = value("address");
            let request =
                if value("forget") == 1 { Request::Invalidate(address) } else { Request::Read(address) };
            asked.push((request, is_taken));
        }
    });
    asked
}

/// The bits that wires have in the last of so many clocks.
pub(super) fn values<const N: usize>(vcd: &str, clocks: u32, wires: &[&str; N]) -> [Option<String>; N] {
    let mut last = [const { None }; N];
    at_clocks(vcd, wires, |clock, values| {
        if clock + 1 == u64::from(clocks) {
            last = wires.map(|wire| values.get(wire).map(|bits| (*bits).to_owned()));
        }
    });
    last
}

/// Calls `note` at each clock, with the values of some wires.
fn at_clocks(vcd: &str, wires: &[&str], mut note: impl FnMut(u64, &BTreeMap<&str, &str>)) {
    let mut names = BTreeMap::new();
    let mut values: BTreeMap<&str, &str> = BTreeMap::new();
    let mut note = |time: u64, values: &BTreeMap<&str, &str>| {
        if time.is_multiple_of(CLOCK) {
            note(time / CLOCK, values);
        }
    };
    let mut time = 0;
    for line in vcd.lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        if let ["$var", _, _, id, name, ..] = words[..] {
            if wires.contains(&name) {
                names.insert(id, name);
            }
        } else if let Some(next) = line.strip_prefix('#').and_then(|time| time.parse().ok()) {
            note(time, &values);
            time = next;
        } else if let [bits, id] = words[..]
            && let (Some(bits), Some(name)) = (bits.strip_prefix('b'), names.get(id))
        {
            values.insert(name, bits);
        }
    }
    note(time, &values);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_those_that_are_taken() {
        use Request::{Invalidate, Read, Reset};
        let head = "$var wire 1 a reset $end\n$var wire 1 b accepted $end\n$var wire 1 c forget $end\n\
                    $var wire 32 d address $end\n$var wire 32 e dut.address $end\n";
        let waves =
            "#0\nb1 a\nb1 b\n#10\nb0 a\nb100000 d\nb1 e\n#15\nb1 c\n#20\n#25\n#30\nb1 a\n#40\nb0 a\n#50\n";
        let all = [Read(0x20), Invalidate(0x20), Reset, Invalidate(0x20)];
        assert_eq!(requests(&format!("{head}{waves}"), 4), all[..3]);
        assert_eq!(requests(&format!("{head}{waves}"), 5), all);
        // A request that is offered in two clocks and never taken.
        let offer = "$var wire 1 f valid $end\n";
        let waves_of_offer = "#0\n#10\nb1 f\nb100000 d\n#20\n#30\nb0 f\n";
        assert_eq!(offered(&format!("{head}{offer}{waves_of_offer}"), 4), [Read(0x20)]);
        assert_eq!(requests(&format!("{head}{offer}{waves_of_offer}"), 4), []);
        let cold = "#0\nb0 a\nb1 b\nb100000 d\n#10\nb0 b\n#20\n";
        assert_eq!(requests(&format!("{head}{cold}"), 2), [Read(0x20)]);
        let last = format!("{head}{waves}b0x10 d\n");
        let of = |clocks| values(&last, clocks, &["reset", "address"]).map(Option::unwrap_or_default);
        assert_eq!(of(6), ["0", "0x10"]);
        assert_eq!(of(5), ["0", "100000"]);
    }
}
