//! What an engine has drawn of a theorem: the sizes that its types have, and of each value the range.

use std::collections::BTreeSet;
use std::fmt::Write as _;

/// What was drawn, over all cases.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// Sizes by name, in the order in which they came first.
    sizes: Vec<(&'static str, BTreeSet<u64>)>,
    draws: Vec<Draw>,
    case: usize,
}

/// The values drawn by one name.
#[derive(Clone, Debug)]
struct Draw {
    name: &'static str,
    /// Ends of the range that values are drawn from.
    ends: [u64; 2],
    /// The values tried, where they are counted one by one.
    tried: Option<BTreeSet<u64>>,
    /// How often it was drawn in one case: in this one, and at most.
    times: [usize; 2],
    case: usize,
}

impl Scope {
    /// The next case begins.
    pub fn begin(&mut self) {
        self.case += 1;
    }

    /// A size of a type, as the ways of a set.
    pub fn size(&mut self, name: &'static str, value: u64) {
        match self.sizes.iter_mut().find(|(known, _)| *known == name) {
            Some((_, values)) => {
                if !values.contains(&value) {
                    values.insert(value);
                }
            }
            None => self.sizes.push((name, BTreeSet::from([value]))),
        }
    }

    /// A value of this range is drawn, any of it.
    pub fn draw(&mut self, name: &'static str, ends: [u64; 2]) {
        let case = self.case;
        let draw = self.drawn(name, ends);
        if draw.case != case {
            (draw.case, draw.times[0]) = (case, 0);
        }
        draw.times[0] += 1;
        draw.times[1] = draw.times[1].max(draw.times[0]);
    }

    /// These values of the range are tried, for the `nth` time in a case that this name is drawn.
    #[cfg(not(kani))]
    pub fn try_all(
        &mut self,
        name: &'static str,
        ends: [u64; 2],
        tried: impl Iterator<Item = u64>,
        nth: usize,
    ) {
        let draw = self.drawn(name, ends);
        draw.tried.get_or_insert_default().extend(tried);
        draw.times[1] = draw.times[1].max(nth);
    }

    fn drawn(&mut self, name: &'static str, ends: [u64; 2]) -> &mut Draw {
        let is_same = |draw: &Draw| std::ptr::eq(draw.name, name) || draw.name == name;
        let at = self.draws.iter().position(is_same).unwrap_or_else(|| {
            self.draws.push(Draw { name, ends, tried: None, times: [0; 2], case: 0 });
            self.draws.len() - 1
        });
        let draw = &mut self.draws[at];
        draw.ends = [draw.ends[0].min(ends[0]), draw.ends[1].max(ends[1])];
        draw
    }

    /// For a person: sizes first, then each value drawn and its range, with how often it is drawn in a
    /// case where that is more than once.
    #[must_use]
    pub fn text(&self) -> String {
        let mut parts: Vec<_> =
            self.sizes.iter().map(|(name, values)| format!("{name} {}", set(values))).collect();
        for Draw { name, ends, tried, times, .. } in &self.draws {
            let mut part = format!("{name} ");
            match tried {
                None => part += &range(*ends),
                Some(tried) => {
                    part += &set(tried);
                    if !covers(tried, *ends) {
                        let _ = write!(part, " of {}", range(*ends));
                    }
                }
            }
            if times[1] > 1 {
                let _ = write!(part, " ({} times)", times[1]);
            }
            parts.push(part);
        }
        parts.join(", ")
    }
}

fn range([low, high]: [u64; 2]) -> String {
    match (low, high) {
        (0, 0xffff_ffff) => "any u32".to_owned(),
        (0, u64::MAX) => "any u64".to_owned(),
        _ if low == high => low.to_string(),
        _ => format!("{low}..={high}"),
    }
}

/// Whether these are all values of the range.
fn covers(values: &BTreeSet<u64>, [low, high]: [u64; 2]) -> bool {
    values.first() == Some(&low) && values.last() == Some(&high) && is_gapless(values)
}

fn is_gapless(values: &BTreeSet<u64>) -> bool {
    values.first().zip(values.last()).is_some_and(|(first, last)| last - first == values.len() as u64 - 1)
}

fn set(values: &BTreeSet<u64>) -> String {
    let (first, last) = (values.first().copied().unwrap_or(0), values.last().copied().unwrap_or(0));
    let list = || values.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    match values.len() {
        0 | 1 => first.to_string(),
        _ if is_gapless(values) => format!("{first}..={last}"),
        2..=6 => format!("{{{}}}", list()),
        count => format!("{count} values from {first} to {last}"),
    }
}
