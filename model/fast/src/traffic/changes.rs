//! Which of the bytes of a set's metadata an access changes (version B).
//!
//! A set of four ways takes 20 bytes, and granules end at multiples of 4 of them. So at most one granule ends inside, and what
//! an access changes before and behind that end depends on few things: where it ends, how many lines the set holds, at which
//! place in its order the line of way 0 stands, and at which place the line was found. [`Changes`] has a row for each; the rows
//! are made by the specification's own step.

use saarcor_model::vm::{ENTRY_BYTES, LineAddr, Policy, Set};

/// Ways of a set.
const WAYS: usize = 4;
/// Bytes of metadata a set.
pub const SET_BYTES: usize = WAYS * ENTRY_BYTES;

/// What changes depend on, of a set that has only been accessed and flushed: its first ways hold lines, the others none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shape {
    /// Where a granule ends inside the set's metadata, in units of 4 bytes; 0 if none does.
    pub border: usize,
    /// Lines that the set holds.
    pub lines: usize,
    /// The place of way 0 in [`Set::order`]; 0 if it holds no line.
    pub place_of_way_0: usize,
}

impl Shape {
    /// Ends of granules inside a set: at bytes 4, 8, 12, 16, or nowhere.
    pub const BORDERS: usize = SET_BYTES / 4;
    /// Shapes a border, and as many numbers again that no shape has.
    const STRIDE: usize = 16;

    /// The shape of an empty set.
    #[must_use]
    pub fn empty(border: usize) -> Self {
        Self { border, lines: 0, place_of_way_0: 0 }
    }

    /// The shape of a set.
    #[must_use]
    pub fn of(set: &Set<WAYS>, border: usize) -> Self {
        let lines = set.resident.iter().filter(|resident| **resident).count();
        let place = set.order.iter().position(|way| *way == 0).unwrap_or(0);
        Self { border, lines, place_of_way_0: if lines == 0 { 0 } else { place } }
    }

    /// All shapes.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::BORDERS).flat_map(|border| {
            (0..=WAYS).flat_map(move |lines| {
                (0..lines.max(1)).map(move |place_of_way_0| Self { border, lines, place_of_way_0 })
            })
        })
    }

    /// Its number.
    #[must_use]
    pub fn number(self) -> u8 {
        // Of 1, 2, ... lines there are 1, 2, ... places.
        let before = self.lines * self.lines.saturating_sub(1) / 2;
        let among = if self.lines == 0 { 0 } else { 1 + before + self.place_of_way_0 };
        (self.border * Self::STRIDE + among) as u8
    }

    /// A set of this shape: line `i + 1` in way `i`, and where way 0 leaves it open, later ways before earlier ones.
    #[must_use]
    pub fn example(self, policy: Policy) -> Set<WAYS> {
        let mut set = Set::empty(policy);
        let mut others = (1..self.lines as u8).rev();
        for place in 0..self.lines {
            set.lines[place] = LineAddr(place as u32 + 1);
            set.resident[place] = true;
            set.order[place] = if place == self.place_of_way_0 { 0 } else { others.next().unwrap_or(0) };
        }
        set
    }
}

/// What an access to a set of some shape does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Change {
    /// Bit 0: bytes before the border change; bit 16: bytes behind it. Without a border all lie before it.
    pub dirty: u32,
    /// The number of the new shape.
    pub next: u8,
}

impl Change {
    /// Of an access from the set `old` to the set `new`, whose metadata have a border there.
    #[must_use]
    pub fn between(old: &Set<WAYS>, new: &Set<WAYS>, border: usize) -> Self {
        let (was, is) = (old.to_entries(), new.to_entries());
        let mut dirty = 0;
        for (byte, (was, is)) in was.as_flattened().iter().zip(is.as_flattened()).enumerate() {
            let behind = border != 0 && byte >= 4 * border;
            dirty |= u32::from(was != is) << (if behind { 16 } else { 0 });
        }
        Self { dirty, next: Shape::of(new, border).number() }
    }

    /// Of an access to an example of `shape`: to the line at a place of its order, or to a line that it does not hold.
    #[must_use]
    pub fn of(shape: Shape, place: Option<usize>, policy: Policy) -> Self {
        let old = shape.example(policy);
        let line = place.map_or(LineAddr(u32::MAX), |place| old.lines[usize::from(old.order[place])]);
        Self::between(&old, &old.access(line, policy).0, shape.border)
    }
}

/// The changes of a policy, by the number of the shape and the place at which the line was found, as
/// [`Step::found`](super::rows::Step::found) says it.
#[derive(Clone, Debug)]
pub struct Changes(Box<[[Change; 16]; 256]>);

impl Changes {
    /// Those of LRU or FIFO.
    #[must_use]
    pub fn new(policy: Policy) -> Self {
        let mut changes = Box::new([[Change::default(); 16]; 256]);
        for shape in Shape::all() {
            for place in (0..shape.lines).map(Some).chain([None]) {
                let found = place.map_or(0, |place| 1 << place);
                changes[usize::from(shape.number())][found] = Change::of(shape, place, policy);
            }
        }
        Self(changes)
    }

    /// What an access does to a set of the shape of this number.
    #[inline(always)]
    #[must_use]
    pub fn of(&self, shape: u8, found: u8) -> Change {
        self.0[usize::from(shape)][usize::from(found & 15)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_shape_has_its_number_and_an_example() {
        let mut numbers: Vec<u8> = Shape::all().map(Shape::number).collect();
        numbers.sort_unstable();
        let count = numbers.len();
        numbers.dedup();
        assert_eq!((numbers.len(), count), (55, 55));
        for policy in [Policy::Lru, Policy::Fifo] {
            for shape in Shape::all() {
                assert_eq!(Shape::of(&shape.example(policy), shape.border), shape);
                assert!(shape.example(policy).is_valid(policy), "{shape:?}");
            }
        }
    }
}
