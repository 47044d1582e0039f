//! Kani's values: symbols, each standing for all values of its range.

#[cfg(kani_stub)]
use crate::stub as kani;

use crate::source::{Label, Source, Value};
use std::ops::RangeInclusive;

/// Draws symbols, and notes which of a theorem's covers were reached: a body that is judged for
/// several numbers of ways has each cover once, not once for each of them.
pub struct Symbols<const COVERS: usize> {
    labels: [Label; COVERS],
    reached: [bool; COVERS],
}

impl<const COVERS: usize> Symbols<COVERS> {
    /// Nothing reached yet.
    pub fn new(labels: [Label; COVERS]) -> Self {
        Self { labels, reached: [false; COVERS] }
    }

    /// Whether that cover was reached.
    pub fn reached(&self, cover: usize) -> bool {
        self.reached[cover]
    }
}

impl<const COVERS: usize> Source for Symbols<COVERS> {
    fn value<T: Value>(&mut self, _name: &'static str, full: RangeInclusive<T>, _small: &'static [T]) -> T {
        let value = T::any();
        kani::assume(*full.start() <= value && value <= *full.end());
        value
    }

    fn cover(&mut self, label: Label, reached: bool) {
        let mut declared = false;
        for i in 0..COVERS {
            if self.labels[i].is(label) {
                self.reached[i] |= reached;
                declared = true;
            }
        }
        assert!(declared, "a theorem declares its covers");
    }
}
