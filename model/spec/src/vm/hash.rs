//! The index hash (§3): which set a line belongs to.

use super::units::{LineAddr, SetIndex};

/// The function from line addresses to set indices (VM-3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Hash {
    /// The lower bits, as in standard caches (§3).
    Low,
    /// The upper bits added to the lower ones (§3, Stated), once, the carry dropped (Assumed).
    #[default]
    AddUpper,
    /// All groups of upper bits added to the lower ones, the carry dropped (Assumed).
    AddUpperAll,
}

impl Hash {
    /// The set of `line` among `2^set_bits` sets.
    ///
    /// ```
    /// use saarcor_model::vm::{Hash, LineAddr, SetIndex};
    /// let line = LineAddr(0x3_2_1);
    /// assert_eq!(Hash::Low.set_of(line, 4), SetIndex(0x1));
    /// assert_eq!(Hash::AddUpper.set_of(line, 4), SetIndex(0x1 + 0x2));
    /// assert_eq!(Hash::AddUpperAll.set_of(line, 4), SetIndex(0x1 + 0x2 + 0x3));
    /// ```
    #[must_use]
    pub fn set_of(self, line: LineAddr, set_bits: u32) -> SetIndex {
        // In 64 bits neither the shift by 32 (2³² sets) nor the sum can overflow.
        let (line, mask) = (u64::from(line.0), (1u64 << set_bits) - 1);
        let sum = match self {
            Self::Low => line,
            Self::AddUpper => line + (line >> set_bits),
            Self::AddUpperAll => {
                let mut sum = line;
                let mut upper = line >> set_bits;
                // With one set there is nothing to add, and the loop would not end.
                while upper != 0 && set_bits != 0 {
                    sum += upper & mask;
                    upper >>= set_bits;
                }
                sum
            }
        };
        SetIndex((sum & mask) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn add_upper_all_adds_every_group() {
        for (line, bits, set) in
            [(0x321, 4, 0x6), (0xf0f, 4, 0xe), (0x4321, 4, 0xa), (0b11_01, 1, 1), (7, 0, 0)]
        {
            assert_eq!(
                Hash::AddUpperAll.set_of(LineAddr(line), bits),
                SetIndex(set),
                "{line:#x}, {bits} bits"
            );
        }
        assert_eq!(Hash::AddUpperAll.set_of(LineAddr(u32::MAX), 32), SetIndex(u32::MAX));
    }
}
