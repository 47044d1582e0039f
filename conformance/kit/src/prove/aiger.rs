//! A netlist as an and-inverter graph (AIGER, binary), in 64 runs at once, a bit of a word each.

use std::collections::BTreeMap;

/// A wire of several bits by its name, and the bit.
pub(super) type Place = (String, usize);

/// The graph, with the names that Yosys writes beside it. A literal is twice a variable, plus 1 where it is inverted.
pub(super) struct Graph {
    /// Which of the inputs each bit is.
    pub inputs: BTreeMap<Place, usize>,
    /// The literals of outputs.
    outputs: BTreeMap<Place, usize>,
    /// How many inputs there are. Their variables are 1, 2 .., then come those of latches, then those of gates.
    input_count: usize,
    /// The literals of the latches' next values.
    next: Vec<usize>,
    /// The two literals of each gate.
    gates: Vec<(usize, usize)>,
    /// The values of all variables.
    values: Vec<u64>,
}

impl Graph {
    /// Reads a graph and its map; none where they are not as Yosys writes them.
    pub fn parse(aig: &[u8], map: &str) -> Option<Self> {
        let mut lines = Lines(aig);
        let header: Vec<usize> =
            lines.next()?.strip_prefix("aig ")?.split(' ').map_while(|n| n.parse().ok()).collect();
        let [variables, input_count, latches, outputs, gates, ..] = header[..] else { return None };
        let next: Vec<usize> =
            (0..latches).map(|_| lines.next()?.split(' ').next()?.parse().ok()).collect::<Option<_>>()?;
        // Claims that Yosys writes as bad states stand behind the outputs.
        let others: usize = header[5..].iter().sum();
        let literals: Vec<usize> =
            (0..outputs + others).map(|_| lines.next()?.parse().ok()).collect::<Option<_>>()?;
        let mut bytes = lines.0.iter();
        let mut number = || {
            let (mut value, mut shift) = (0, 0);
            loop {
                let byte = usize::from(*bytes.next()?);
                value |= (byte & 0x7f) << shift;
                shift += 7;
                if byte < 0x80 {
                    return Some(value);
                }
            }
        };
        let gates = (0..gates)
            .map(|gate| {
                let own = 2 * (1 + input_count + latches + gate);
                let first = own.checked_sub(number()?)?;
                Some((first, first.checked_sub(number()?)?))
            })
            .collect::<Option<_>>()?;
        let (mut named, mut shown) = (BTreeMap::new(), BTreeMap::new());
        for line in map.lines() {
            let mut words = line.splitn(4, ' ');
            let (kind, index) = (words.next()?, words.next()?.parse::<usize>().ok()?);
            let place = |bit: Option<&str>, name: Option<&str>| Some((name?.to_owned(), bit?.parse().ok()?));
            match kind {
                "input" => _ = named.insert(place(words.next(), words.next())?, index),
                "output" => _ = shown.insert(place(words.next(), words.next())?, *literals.get(index)?),
                _ => {}
            }
        }
        let values = vec![0; variables + 1];
        Some(Self { inputs: named, outputs: shown, input_count, next, gates, values })
    }

    /// How many inputs there are.
    pub fn input_count(&self) -> usize {
        self.input_count
    }

    /// Takes the inputs of a clock.
    pub fn settle(&mut self, inputs: &[u64]) {
        self.values[1..=self.input_count].copy_from_slice(inputs);
        let first = 1 + self.input_count + self.next.len();
        for (gate, &(a, b)) in self.gates.iter().enumerate() {
            self.values[first + gate] = self.literal(a) & self.literal(b);
        }
    }

    /// Goes on to the next clock.
    pub fn rise(&mut self) {
        let next: Vec<u64> = self.next.iter().map(|&literal| self.literal(literal)).collect();
        self.values[1 + self.input_count..][..next.len()].copy_from_slice(&next);
    }

    fn literal(&self, literal: usize) -> u64 {
        self.values[literal / 2] ^ if literal % 2 == 1 { u64::MAX } else { 0 }
    }

    /// The value of a bit of an output; none where there is no such output.
    pub fn output(&self, place: &Place) -> Option<u64> {
        self.outputs.get(place).map(|&literal| self.literal(literal))
    }
}

/// The lines of a text that goes on in bytes.
struct Lines<'a>(&'a [u8]);

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a str> {
        let end = self.0.iter().position(|&byte| byte == b'\n')?;
        let (line, rest) = self.0.split_at(end);
        self.0 = &rest[1..];
        std::str::from_utf8(line).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bit that toggles where it is enabled: one input, one latch, and the gates of an exclusive or.
    #[test]
    fn a_graph_is_simulated() {
        // Variables: 1 enable, 2 latch, 3 = 1 & !2, 4 = !1 & 2, 5 = !3 & !4; the latch takes !5.
        let mut aig = b"aig 5 1 1 1 3\n11\n4\n".to_vec();
        for (own, a, b) in [(6, 5, 2), (8, 4, 3), (10, 9, 7)] {
            aig.extend([(own - a) as u8, (a - b) as u8]);
        }
        let mut graph =
            Graph::parse(&aig, "input 0 0 enable\nlatch 0 0 bit\noutput 0 0 bit\n").expect("a graph");
        let bit = ("bit".to_owned(), 0);
        for (enable, before) in [(0b01, 0), (0b11, 0b01), (0b10, 0b10), (0, 0)] {
            graph.settle(&[enable]);
            assert_eq!(graph.output(&bit), Some(before));
            graph.rise();
        }
        assert!(Graph::parse(b"aig 1\n", "").is_none());
    }
}
