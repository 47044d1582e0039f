//! Caches of one number of sets and of every number of ways, in one pass: twin of
//! [`Directory`](saarcor_model::vm::Directory) with LRU, for all its numbers of ways together.
//!
//! A stack keeps the lines of a set, the one used last on top. With LRU a set of `w` ways holds the `w` topmost lines
//! of its stack, whatever `w` is; so the place at which a line is found, its stack distance, says which of these caches
//! hit (Mattson, Gecsei, Slutz, Traiger 1970, "Evaluation techniques for storage hierarchies"). Only ways differ: each
//! number of sets has its own stacks, since the standard hash spreads the lines of one set over any of more sets.
//! Equal by the theorems of `saarcor-proofs`, `equal::stacks`.

use saarcor_model::vm::{Hash, LineAddr, SetIndex};

/// The stacks of all sets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stacks {
    /// Chooses the set of a line.
    pub hash: Hash,
    /// Binary logarithm of the number of sets.
    pub set_bits: u32,
    /// Most lines of a stack: the largest number of ways.
    pub depth: usize,
    /// The stacks, one after the other, with room for `depth` lines each; the topmost line of a stack comes first.
    pub lines: Vec<LineAddr>,
    /// Lines on each stack.
    pub held: Vec<u8>,
}

impl Stacks {
    /// The empty stacks of `2^set_bits` sets that `hash` chooses from, for up to `ways` ways.
    ///
    /// # Panics
    /// If there are no ways, or more than 255.
    #[must_use]
    pub fn new(hash: Hash, set_bits: u32, ways: u8) -> Self {
        assert!(ways > 0, "a set has at least one way");
        let (sets, depth) = (1 << set_bits, usize::from(ways));
        Self { hash, set_bits, depth, lines: vec![LineAddr(0); sets * depth], held: vec![0; sets] }
    }

    /// The set of a line.
    #[inline]
    #[must_use]
    pub fn set_of(&self, line: LineAddr) -> SetIndex {
        self.hash.set_of(line, self.set_bits)
    }

    /// The lines on the stack of a set, the topmost first.
    #[inline]
    #[must_use]
    pub fn stack(&self, set: SetIndex) -> &[LineAddr] {
        let begin = set.0 as usize * self.depth;
        &self.lines[begin..begin + usize::from(self.held[set.0 as usize])]
    }

    /// Whether `line` lies on top of its stack: then it hits whatever the number of ways, and its use changes nothing.
    #[inline]
    #[must_use]
    pub fn is_on_top(&self, line: LineAddr) -> bool {
        self.stack(self.set_of(line)).first() == Some(&line)
    }

    /// Uses `line`, which comes to the top of its stack. Returns how many lines lay above it: it hits in sets of more ways
    /// than that. None if it did not lie there: it misses whatever the number of ways.
    #[inline]
    pub fn access(&mut self, line: LineAddr) -> Option<usize> {
        let set = self.set_of(line).0 as usize;
        let (begin, held) = (set * self.depth, usize::from(self.held[set]));
        let stack = &mut self.lines[begin..begin + self.depth];
        // Each line from the top on moves down into the place of the next, up to where `line` was.
        let mut moved = line;
        for (above, place) in stack[..held].iter_mut().enumerate() {
            moved = std::mem::replace(place, moved);
            if moved == line {
                return Some(above);
            }
        }
        // The lowest line of a full stack falls from it.
        if let Some(free) = stack.get_mut(held) {
            *free = moved;
            self.held[set] += 1;
        }
        None
    }

    /// Forgets all lines.
    pub fn flush(&mut self) {
        self.held.fill(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "at least one way")]
    fn no_stack_is_without_room() {
        let _ = Stacks::new(Hash::Low, 0, 0);
    }
}
