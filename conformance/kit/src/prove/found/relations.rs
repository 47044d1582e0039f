//! How the state of an implementation stands to the specification's, as a simulation shows it.

use super::samples::{Bit, Samples, answer_of_waiting, beat_bits, has_value};
use super::{CLOCKS, CONTROL_WIDTH, Found, Layout, Part, Relation, Shown};
use crate::prove::harness;
use saarcor_model::vm::CacheConfig;
use std::collections::BTreeSet;

/// Most bits, and most values, of parts that are related as a whole.
const MAX_BITS: usize = 40;
const MAX_VALUES: usize = 800;

/// How many bits of a set's lines, and of which are resident, can have relations.
pub(in crate::prove) fn most_of_set(cache: &CacheConfig) -> usize {
    cache.geometry.ways() as usize * (1 + 32 - cache.geometry.line().0.trailing_zeros() as usize)
}

/// What held in a simulation: of what was found the parts that have relations, and how many bits of the set's lines and of
/// which are resident have one.
pub(in crate::prove) fn relations(
    samples: &Samples,
    candidates: &Found,
    cache: &CacheConfig,
) -> (Found, usize) {
    let mut found = candidates.clone();
    let (classes, counts) = (classes(samples, candidates, cache), samples.counts());
    let Search { mut equal, mut others, mut controls } = Search::new(samples, candidates, &classes);
    let of_waiting = match candidates.commit {
        Some(_) => classes_of_waiting(samples, candidates, cache, &controls),
        None => Vec::new(),
    };
    let registers = candidates.parts.iter().filter(|shown| matches!(shown.part, Part::Wire(_)));
    for bit in registers.flat_map(|shown| samples.bits(&shown.wire, 0..shown.width)) {
        // What always holds comes first.
        let mut own = of_waiting.iter().filter_map(|class| class.equal(bit)).peekable();
        let is_plain = own.peek().is_some_and(|first| first.guard == of_waiting[0].guard);
        equal.extend(own.take(if is_plain { 1 } else { usize::MAX }));
    }
    let wrong = wrong_layouts(&candidates.parts, &equal);
    equal.retain(|equal| !wrong.contains(equal.part.wire));
    others.retain(|bits| bits.first().is_some_and(|bit| !wrong.contains(bit.wire)));
    let is_of_set = |equal: &&Equal<'_>| ["resident", "lines"].contains(&equal.own.wire);
    let of_set: BTreeSet<_> =
        equal.iter().filter(is_of_set).map(|equal| (equal.own.wire, equal.own.number)).collect();
    let of_set = of_set.len();
    // A register that holds the set of a request has its width.
    let set_bits = cache.geometry.set_bits() as usize;
    let is_sum = |equal: &Equal<'_>| SUMS.contains(&equal.own.wire);
    for shown in &mut found.parts {
        let sums = equal.iter().filter(|equal| equal.part.wire == shown.wire && is_sum(equal));
        shown.is_set = shown.width == set_bits && sums.count() >= set_bits;
    }
    let is_set = |wire: &str| found.parts.iter().any(|shown| shown.is_set && shown.wire == wire);
    let (sets, equal): (Vec<_>, Vec<_>) = equal.into_iter().partition(|equal| is_set(equal.part.wire));
    let mut relations = runs(equal);
    let sets = sets.iter().filter(|equal| equal.own.number == 0 && is_sum(equal));
    relations.extend(sets.map(|equal| {
        Relation::whole(format!("{}{} == {}[SET_BITS-1:0]", equal.guard, equal.part.wire, equal.own.wire))
    }));
    // The order, in whatever form; with all that is left, or a word at a time.
    let order = samples.bits("order", 0..harness::order_bits(cache));
    match group(&[others.concat(), order.clone()].concat(), &counts) {
        Some(relation) => relations.push(relation),
        None => relations
            .extend(others.into_iter().filter_map(|bits| group(&[bits, order.clone()].concat(), &counts))),
    }
    // What registers say of requests that wait, of answers, and of a line that is loaded.
    let own = [("count", 2), ("waits", 1), ("waited", 7), ("stalled", 1)];
    let own = own.iter().chain(candidates.loads());
    controls.extend(own.flat_map(|(wire, width)| samples.bits(wire, 0..*width)));
    relations.extend(group(&controls, &counts));
    relations.extend(candidates.parts.iter().filter_map(|shown| of_bytes(samples, shown)));
    let is_used = |shown: &Shown| {
        let names = [format!("{}[", shown.wire), format!("{} ", shown.wire)];
        relations.iter().any(|relation| names.iter().any(|name| relation.text.contains(name)))
    };
    found.parts.retain(is_used);
    found.relations = relations;
    (found, of_set)
}

/// The wires whose lowest bits are the set of a request.
const SUMS: [&str; 2] = ["sum", "want_sum"];

/// What bits of parts are.
struct Search<'a> {
    /// The bits that are bits of the specification.
    equal: Vec<Equal<'a>>,
    /// Of each word the bits that have no relation of their own.
    others: Vec<Vec<Bit<'a>>>,
    /// The bits of narrow registers that are no answers.
    controls: Vec<Bit<'a>>,
}

impl<'a> Search<'a> {
    fn new(samples: &'a Samples, candidates: &'a Found, classes: &'a [Class<'a>]) -> Self {
        let (mut equal, mut others, mut controls) = (Vec::new(), Vec::new(), Vec::new());
        for shown in &candidates.parts {
            let is_word = match shown.part {
                Part::Word { .. } => true,
                Part::Wire(_) => false,
                Part::Bytes { .. } => continue,
            };
            let mut unrelated = Vec::new();
            for bit in samples.bits(&shown.wire, 0..shown.width).into_iter().filter(|bit| !bit.is_constant())
            {
                let own: Vec<Equal<'_>> = classes.iter().filter_map(|class| class.equal(bit)).collect();
                let is_answer =
                    own.iter().any(|equal| equal.guard.starts_with(ANSWER) || equal.own.wire == "beat");
                if is_word && own.is_empty() {
                    unrelated.push(bit);
                } else if !is_word && !is_answer && shown.width <= CONTROL_WIDTH {
                    controls.push(bit);
                }
                equal.extend(own);
            }
            others.push(unrelated);
            if !is_word {
                let bits = samples.bits(&shown.wire, 0..shown.width);
                let constant = constant_bits(&bits, classes, &equal);
                equal.extend(constant);
            }
        }
        Self { equal, others, controls }
    }
}

/// The bits of a register that never change where they are what is to be answered, as bits beside them are.
fn constant_bits<'a>(bits: &[Bit<'a>], classes: &'a [Class<'a>], equal: &[Equal<'a>]) -> Vec<Equal<'a>> {
    let mut constant = Vec::new();
    for class in classes.iter().filter(|class| class.guard.starts_with(ANSWER)) {
        let is_of_both = |equal: &&Equal<'_>| {
            equal.guard == class.guard && bits.iter().any(|bit| bit.wire == equal.part.wire)
        };
        let Some(first) = equal.iter().find(is_of_both).filter(|first| !first.is_inverted) else { continue };
        let below = first.own.number - first.part.number.min(first.own.number);
        for &part in bits.iter().filter(|part| part.is_constant()) {
            let own = class.bits.iter().find(|own| own.number == part.number + below);
            constant.extend(own.filter(|own| !class.differ(&part, own, 0)).map(|&own| Equal {
                guard: &class.guard,
                part,
                own,
                is_inverted: false,
            }));
        }
    }
    constant
}

/// The wires of words as they do not lie: side by side or apart, what explains more of the set is right.
fn wrong_layouts<'a>(parts: &'a [Shown], equal: &[Equal<'_>]) -> BTreeSet<&'a str> {
    let explained = |of: &str, side_by_side: bool| -> usize {
        let is_alike = |shown: &&Shown| {
            matches!(&shown.part, Part::Word { memory, ways: 2.., is_side_by_side, .. }
                if memory == of && *is_side_by_side == side_by_side)
        };
        let of = |shown: &Shown| equal.iter().filter(|equal| equal.part.wire == shown.wire).count();
        parts.iter().filter(is_alike).map(of).sum()
    };
    let is_wrong = |shown: &&Shown| match &shown.part {
        Part::Word { memory, ways: 2.., is_side_by_side, .. } => {
            let (own, other) = (explained(memory, *is_side_by_side), explained(memory, !is_side_by_side));
            own < other || own == other && !is_side_by_side
        }
        _ => false,
    };
    parts.iter().filter(is_wrong).map(|shown| shown.wire.as_str()).collect()
}

/// That the byte that is looked at lies in a memory where its line is resident.
fn of_bytes(samples: &Samples, shown: &Shown) -> Option<Relation> {
    let Part::Bytes { layout, .. } = shown.part else { return None };
    let lies = samples.of("byte_lies", 0);
    let lane_bits = (shown.width / 8).trailing_zeros() as usize;
    let value = |wire: &str, bits: usize, clock: usize, run: usize| -> u64 {
        let bit = |number: usize| (samples.of(wire, number)[clock] >> run & 1) << number;
        (0..bits).map(bit).sum()
    };
    let mut seen = 0;
    for (clock, (lies, counts)) in lies.iter().zip(samples.counts()).enumerate() {
        for run in (0..64).filter(|run| (lies & counts) >> run & 1 == 1) {
            if matches!(layout, Layout::Way(way) if value("byte_way", 4, clock, run) != u64::from(way)) {
                continue;
            }
            let lane = 8 * value(layout.wire(), lane_bits, clock, run) as usize;
            let byte = (lane..lane + 8)
                .enumerate()
                .map(|(n, number)| (samples.of(&shown.wire, number)[clock] >> run & 1) << n);
            if byte.sum::<u64>() != value("byte_right", 8, clock, run) {
                return None;
            }
            seen += 1;
        }
    }
    let way = match layout {
        Layout::Way(way) => format!("byte_way != {way} || "),
        Layout::Card | Layout::Apart => String::new(),
    };
    let lane = format!("8 * ({} & {}) +: 8", layout.wire(), shown.width / 8 - 1);
    (seen > 0).then(|| Relation::whole(format!("!byte_lies || {way}{}[{lane}] == byte_right", shown.wire)))
}

/// The guard of answers: the oldest request that changed the state reads a line of the set.
const ANSWER: &str = "known == 0 || !queue[MINE] || ";

/// Bits of the specification that mean something under one condition.
struct Class<'a> {
    /// What stands before a relation under it, in Verilog.
    guard: String,
    /// Where it holds.
    holds: Vec<u64>,
    bits: Vec<Bit<'a>>,
}

/// A bit of a part that is a bit of the specification.
struct Equal<'a> {
    guard: &'a str,
    part: Bit<'a>,
    own: Bit<'a>,
    is_inverted: bool,
}

impl<'a> Class<'a> {
    /// Whether two bits differ somewhere where those of the class mean something; one of them is inverted by a mask.
    fn differ(&self, part: &Bit<'_>, own: &Bit<'_>, mask: u64) -> bool {
        let mut all = part.samples.iter().zip(own.samples).zip(&self.holds);
        all.any(|((part, own), holds)| (part ^ own ^ mask) & holds != 0)
    }

    /// The bit of the specification that a bit of a part is, or is the inverse of.
    fn equal(&'a self, part: Bit<'a>) -> Option<Equal<'a>> {
        // A bit that hardly changes where it means something says little.
        let changes = |bit: &Bit<'_>| {
            let (mut ones, mut zeros) = (0, 0);
            for (word, holds) in bit.samples.iter().zip(&self.holds) {
                ones += (word & holds).count_ones();
                zeros += (!word & holds).count_ones();
            }
            ones > 8 && zeros > 8
        };
        if !changes(&part) {
            return None;
        }
        self.bits.iter().find_map(|own| {
            let is_inverted = if !self.differ(&part, own, 0) {
                false
            } else if !self.differ(&part, own, u64::MAX) {
                true
            } else {
                return None;
            };
            Some(Equal { guard: &self.guard, part, own: *own, is_inverted })
        })
    }
}

fn classes<'a>(samples: &'a Samples, found: &Found, cache: &CacheConfig) -> Vec<Class<'a>> {
    let line_bits = 32 - cache.geometry.line().0.trailing_zeros() as usize;
    let bits = |wire: &'static str, numbers: std::ops::Range<usize>| samples.bits(wire, numbers);
    let any = |wire: &'static str| -> Vec<u64> {
        let bits = bits(wire, 0..4);
        (0..CLOCKS).map(|clock| bits.iter().fold(0, |all, bit| all | bit.samples[clock])).collect()
    };
    let ways = cache.geometry.ways() as usize;
    let set_bits = cache.geometry.set_bits() as usize;
    let always = [
        bits("resident", 0..ways),
        bits("order", 0..harness::order_bits(cache)),
        bits("known", 0..2),
        bits("waits", 0..1),
    ];
    let mut classes = vec![Class { guard: String::new(), holds: samples.counts(), bits: always.concat() }];
    classes.extend((0..ways).map(|way| Class {
        guard: format!("!resident[{way}] || "),
        holds: samples.of("resident", way).to_vec(),
        bits: bits("lines", 32 * way..32 * way + line_bits),
    }));
    let is_answer: Vec<u64> = any("known")
        .iter()
        .zip(samples.of("queue", harness::MINE))
        .map(|(known, mine)| known & mine)
        .collect();
    let evicts = samples.of("queue", harness::EVICTS);
    classes.push(Class {
        guard: format!("{ANSWER}!queue[{}] || ", harness::EVICTS),
        holds: is_answer.iter().zip(evicts).map(|(is_answer, evicts)| is_answer & evicts).collect(),
        bits: bits("queue", harness::EVICTED),
    });
    classes.push(Class { guard: ANSWER.to_owned(), holds: is_answer, bits: bits("queue", 0..harness::MINE) });
    if found.commit.is_some() {
        let bits = [bits("waiting", 0..33), bits("sum", 0..set_bits)].concat();
        classes.push(Class { guard: "waits == 0 || ".to_owned(), holds: any("waits"), bits });
    }
    if !found.loads().is_empty() {
        let holds = samples.of("asks", 0).to_vec();
        classes.push(Class { guard: "!asks || ".to_owned(), holds, bits: bits("beat", 0..beat_bits(cache)) });
        let request =
            [bits("want_address", 0..32), bits("want_forgets", 0..1), bits("want_sum", 0..set_bits)].concat();
        classes.push(Class { guard: "known == 0 || ".to_owned(), holds: any("known"), bits: request });
    }
    for class in &mut classes {
        class.holds.iter_mut().zip(samples.counts()).for_each(|(holds, counts)| *holds &= counts);
    }
    classes
}

/// What registers may hold while a request of the set waits: what was read of the set, and what is to be answered; always,
/// or where a register that controls others has a value.
fn classes_of_waiting<'a>(
    samples: &'a Samples,
    found: &'a Found,
    cache: &CacheConfig,
    controls: &[Bit<'a>],
) -> Vec<Class<'a>> {
    let ways = cache.geometry.ways() as usize;
    let words = found.parts.iter().filter(|shown| matches!(shown.part, Part::Word { .. }));
    let all: Vec<Bit<'a>> = words
        .map(|shown| (shown.wire.as_str(), shown.width))
        .chain(answer_of_waiting(ways))
        .flat_map(|(wire, width)| samples.bits(wire, 0..width))
        .collect();
    let waits = samples.of("waits", 0).iter().zip(samples.of("mine", 0)).map(|(waits, mine)| waits & mine);
    let waits: Vec<u64> = waits.zip(samples.counts()).map(|(waits, counts)| waits & counts).collect();
    let guard = "waits == 0 || !mine || ";
    let mut classes = vec![Class { guard: guard.to_owned(), holds: waits.clone(), bits: all.clone() }];
    for bits in controls.chunk_by(|a, b| a.wire == b.wire) {
        let (wire, width) = (bits[0].wire, bits.len());
        let name: Vec<_> = bits.iter().rev().map(|bit| format!("{wire}[{}]", bit.number)).collect();
        for value in 0..1_u64 << width {
            let holds =
                has_value(bits, value).into_iter().zip(&waits).map(|(has, waits)| has & waits).collect();
            let guard = format!("{guard}{{{}}} != {width}'d{value} || ", name.join(", "));
            classes.push(Class { guard, holds, bits: all.clone() });
        }
    }
    classes
}

/// Equal bits that follow each other as one relation.
fn runs(equal: Vec<Equal<'_>>) -> Vec<Relation> {
    let mut runs: Vec<Vec<Equal<'_>>> = Vec::new();
    for next in equal {
        let follows = |last: &Equal<'_>| {
            (last.guard, last.part.wire, last.own.wire, last.is_inverted)
                == (next.guard, next.part.wire, next.own.wire, next.is_inverted)
                && (last.part.number + 1, last.own.number + 1) == (next.part.number, next.own.number)
        };
        match runs.iter_mut().find(|run| run.last().is_some_and(follows)) {
            Some(run) => run.push(next),
            None => runs.push(vec![next]),
        }
    }
    let text = |run: &[Equal<'_>]| {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return String::new() };
        let range =
            |first: &Bit<'_>, last: &Bit<'_>| format!("{}[{}:{}]", first.wire, last.number, first.number);
        let not = if first.is_inverted { "~" } else { "" };
        format!("{}{} == {not}{}", first.guard, range(&first.part, &last.part), range(&first.own, &last.own))
    };
    let relation = |run: Vec<Equal<'_>>| {
        let parts = if run.len() == 1 { Vec::new() } else { run.chunks(1).map(text).collect() };
        Relation { text: text(&run), parts }
    };
    runs.into_iter().map(relation).collect()
}

/// That bits together have one of the values that they had; none where these are too many to say much.
fn group(bits: &[Bit<'_>], counts: &[u64]) -> Option<Relation> {
    if bits.is_empty() || bits.len() > MAX_BITS {
        return None;
    }
    let mut values = BTreeSet::new();
    for (clock, counts) in counts.iter().enumerate() {
        for run in (0..64).filter(|run| counts >> run & 1 == 1) {
            let bit = |bit: &Bit<'_>| bit.samples[clock] >> run & 1;
            values.insert(bits.iter().rev().fold(0, |value, next| value << 1 | bit(next)));
            if values.len() > MAX_VALUES {
                return None;
            }
        }
    }
    if values.len() >= 1 << bits.len() {
        return None;
    }
    let names: Vec<_> = bits.iter().rev().map(|bit| format!("{}[{}]", bit.wire, bit.number)).collect();
    let all = format!("{{{}}}", names.join(", "));
    let is_one = values.iter().map(|value: &u64| format!("{all} == {}'h{value:x}", bits.len()));
    Some(Relation::whole(is_one.collect::<Vec<_>>().join(" || ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_bits_that_follow_each_other_are_one_relation() {
        let samples = [0b0101, 0b0011];
        let bit = |wire, number| Bit { wire, number, samples: &samples };
        let equal = |part, own, is_inverted| Equal {
            guard: "",
            part: bit("found_part0", part),
            own: bit("resident", own),
            is_inverted,
        };
        let relations = runs(vec![equal(0, 2, false), equal(1, 3, false), equal(2, 4, true)]);
        let texts: Vec<_> = relations.iter().map(|relation| relation.text.as_str()).collect();
        assert_eq!(texts, ["found_part0[1:0] == resident[3:2]", "found_part0[2:2] == ~resident[4:4]"]);
        let mut found = Found { relations, ..Found::default() };
        assert!(found.drop(&BTreeSet::from([0])));
        assert_eq!(found.relations[0].text, "found_part0[0:0] == resident[2:2]");
        assert_eq!(found.relations.len(), 3);
        assert!(found.drop(&BTreeSet::from([0, 1])) && found.relations.len() == 1);
        assert!(!found.drop(&BTreeSet::from([7])));
    }

    #[test]
    fn bits_together_have_the_values_that_they_had_without_a_reset() {
        let (low, high) = ([0b0011], [0b0101]);
        let bits =
            [("order", &low), ("found_part0", &high)].map(|(wire, samples)| Bit { wire, number: 0, samples });
        let group = |counts| group(&bits, &[counts]).map(|relation| relation.text);
        let both = "{found_part0[0], order[0]} ==";
        assert_eq!(group(0b0011), Some(format!("{both} 2'h1 || {both} 2'h3")));
        // All values say nothing.
        assert_eq!(group(0b1111), None);
    }
}
