//! Sets of four ways as rows of 16-bit words, used two at a time.

use super::lanes::Lanes;
use saarcor_model::vm::Policy;

/// A set of four ways. The words of what it holds come in the order in which the policy keeps them, what was used (FIFO: loaded)
/// last first; behind them lie free words.
pub type Row = [u16; 4];

/// What a row did for one access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Step {
    /// Bit `i`: the word at place `i` was the one asked for. One bit after a hit, none after a miss.
    pub found: u8,
    /// Whether the word is marked now and was not before.
    pub marked: bool,
}

/// The step of a row: uses the word of `key`, which comes in and drops the last word if it was not there.
///
/// With `MARKS` bit 0 of a word is a mark, which a key may set and which stays until the word is dropped; it does not count
/// when words are compared. Without, all 16 bits are compared.
#[inline(always)]
pub fn step<const MARKS: bool>(row: &mut Row, key: u16, policy: Policy) -> Step {
    let (mut found, mut place, mut old) = (0, 3, 0);
    for (i, word) in row.iter().enumerate() {
        let same = if MARKS { word ^ key < 2 } else { *word == key };
        if same {
            (found, place, old) = (1 << i, i, *word);
        }
    }
    // All words down to the place make room; a FIFO hit moves none.
    let stays = found != 0 && policy == Policy::Fifo;
    let mut moved = old | key;
    for (i, word) in row.iter_mut().enumerate() {
        let moves = if stays { i == place } else { i <= place };
        if moves {
            std::mem::swap(word, &mut moved);
        }
    }
    Step { found, marked: MARKS && key & !old & 1 == 1 }
}

/// What many accesses to rows did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sums {
    /// Accesses that found their word.
    pub hits: u64,
    /// Accesses that marked a word which was not marked.
    pub marked: u64,
}

/// The rows of a cache of lines, or (`MARKS`) of granules, which are dirty where they are marked.
#[derive(Clone, Debug)]
pub struct Rows<const MARKS: bool> {
    /// The rows; a power of two, unless there are spare ones.
    pub rows: Vec<Row>,
    /// LRU or FIFO.
    pub policy: Policy,
}

impl<const MARKS: bool> Rows<MARKS> {
    /// A word that is never asked for: it stands where a row holds nothing. The largest tag is smaller.
    pub const FREE: u16 = if MARKS { 0x7ffe } else { u16::MAX };

    /// So many empty rows.
    #[must_use]
    pub fn new(rows: usize, policy: Policy) -> Self {
        Self { rows: vec![[Self::FREE; 4]; rows], policy }
    }
}

impl Rows<false> {
    /// Uses keys in the rows at `places`, one after the other, two at a time. Byte `i` of `found` has [`Step::found`] of access
    /// `2 i` in its lower half, of access `2 i + 1` in its upper one. Pairs beyond the length of `found` are left.
    ///
    /// # Panics
    /// If there is no row at a place, or more than 2¹⁵ pairs.
    pub fn access(
        &mut self,
        lanes: Lanes,
        pairs: impl Iterator<Item = ([u32; 2], [u16; 2])>,
        found: &mut [u8],
    ) -> Sums {
        assert!(found.len() <= 1 << 15, "{} pairs at a time: at most 32768", found.len());
        lanes.access(&mut self.rows, self.policy, pairs, found)
    }
}

/// As many rows as places of 16 bits tell apart.
pub const PLACES: usize = 1 << 16;

impl Rows<true> {
    /// Uses at most 2¹⁵ pairs of keys, one after the other, each in two different rows.
    ///
    /// # Panics
    /// If there are not [`PLACES`] rows.
    pub fn access_granules(
        &mut self,
        lanes: Lanes,
        pairs: impl Iterator<Item = ([u16; 2], [u16; 2])>,
    ) -> Sums {
        let Some(rows) = self.rows.first_chunk_mut() else { panic!("{} rows", self.rows.len()) };
        lanes.access_granules(rows, self.policy, pairs)
    }
}

/// Two accesses, one after the other. Returns what both found, as [`Rows::access`] does.
#[inline(always)]
pub(super) fn two<const MARKS: bool>(
    rows: &mut [Row],
    policy: Policy,
    places: [u32; 2],
    keys: [u16; 2],
    sums: &mut Sums,
) -> u8 {
    let first = one::<MARKS>(rows, policy, places[0], keys[0], sums);
    first | one::<MARKS>(rows, policy, places[1], keys[1], sums) << 4
}

/// One access.
#[inline(always)]
pub(super) fn one<const MARKS: bool>(
    rows: &mut [Row],
    policy: Policy,
    place: u32,
    key: u16,
    sums: &mut Sums,
) -> u8 {
    let Step { found, marked } = step::<MARKS>(&mut rows[place as usize], key, policy);
    sums.hits += u64::from(found != 0);
    sums.marked += u64::from(marked);
    found
}
