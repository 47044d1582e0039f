//! The steps of rows in vector registers, where the processor has them.
//!
//! `pulp` asks the processor what it has, so that nothing here is unsafe. On one without AVX2, and for Kani, the same steps are
//! made one by one. The test below compares both.

use super::rows::{PLACES, Row, Sums, two};
use saarcor_model::vm::Policy;

/// How steps are made.
#[derive(Clone, Copy, Debug)]
pub enum Lanes {
    /// One by one.
    Plain,
    /// Two rows in one register.
    #[cfg(all(target_arch = "x86_64", not(kani)))]
    Avx2(vectors::V3),
}

impl Lanes {
    /// What the processor has.
    #[must_use]
    pub fn of_processor() -> Self {
        #[cfg(all(target_arch = "x86_64", not(kani)))]
        if let Some(avx2) = vectors::V3::try_new() {
            return Self::Avx2(avx2);
        }
        Self::Plain
    }

    /// Does `work` with all instructions that the processor has: the compiler may then use them for its loops.
    #[inline(always)]
    pub(super) fn run<R>(self, work: impl FnOnce() -> R) -> R {
        match self {
            Self::Plain => work(),
            #[cfg(all(target_arch = "x86_64", not(kani)))]
            Self::Avx2(lanes) => lanes.vectorize(work),
        }
    }

    /// Accesses of pairs of sets of lines, in order: [`Rows::access`](super::rows::Rows::access). At most 2¹⁵ pairs, as vectors
    /// count in 16 bits.
    pub(super) fn access(
        self,
        rows: &mut [Row],
        policy: Policy,
        pairs: impl Iterator<Item = ([u32; 2], [u16; 2])>,
        found: &mut [u8],
    ) -> Sums {
        match self {
            Self::Plain => {
                let mut sums = Sums::default();
                for ((places, keys), found) in pairs.zip(found) {
                    *found = two::<false>(rows, policy, places, keys, &mut sums);
                }
                sums
            }
            #[cfg(all(target_arch = "x86_64", not(kani)))]
            Self::Avx2(lanes) => lanes.vectorize(vectors::Access { lanes, rows, policy, pairs, found }),
        }
    }

    /// Accesses of pairs of granules, in order: [`Rows::access_granules`](super::rows::Rows::access_granules). At most 2¹⁵ pairs, as
    /// vectors count in 16 bits.
    pub(super) fn access_granules(
        self,
        rows: &mut [Row; PLACES],
        policy: Policy,
        pairs: impl Iterator<Item = ([u16; 2], [u16; 2])>,
    ) -> Sums {
        match self {
            Self::Plain => {
                let mut sums = Sums::default();
                for (places, keys) in pairs {
                    two::<true>(rows, policy, places.map(u32::from), keys, &mut sums);
                }
                sums
            }
            #[cfg(all(target_arch = "x86_64", not(kani)))]
            Self::Avx2(lanes) => lanes.vectorize(vectors::AccessGranules { lanes, rows, policy, pairs }),
        }
    }

    /// Copies `lines` to `out` without those that equal the line before them, which for the first is `before`. Returns how many
    /// there are.
    ///
    /// # Panics
    /// If `out` has no room for 8 lines more than `lines` has.
    pub(super) fn drop_repeated(self, lines: &[u32], before: u32, out: &mut [u32]) -> usize {
        let plain = |lines: &[u32], mut before, out: &mut [u32], mut count| {
            for &line in lines {
                out[count] = line;
                count += usize::from(line != before);
                before = line;
            }
            count
        };
        match self {
            Self::Plain => plain(lines, before, out, 0),
            #[cfg(all(target_arch = "x86_64", not(kani)))]
            Self::Avx2(lanes) => {
                // Of all but the first, eight at a time stand beside the eight that come before them.
                let count = plain(&lines[..lines.len().min(1)], before, out, 0);
                let eights = lines.len().saturating_sub(1) / 8;
                let count = lanes.vectorize(vectors::DropRepeated { lanes, lines, out, count });
                let rest = lines.get(8 * eights..).unwrap_or_default();
                let before = rest.first().copied().unwrap_or_default();
                plain(rest.get(1..).unwrap_or_default(), before, out, count)
            }
        }
    }
}

#[cfg(all(target_arch = "x86_64", not(kani)))]
mod vectors {
    use super::{PLACES, Policy, Row, Sums, two};
    use bytemuck::cast;
    use pulp::NullaryFnOnce;
    pub use pulp::x86::V3;
    use std::arch::x86_64::__m128i;

    /// How the words of two rows move: for each word the bytes that come to its place (128: none), and which bits of the key
    /// are then added.
    #[derive(Clone, Copy)]
    struct Move {
        bytes: [u8; 16],
        insert: [u16; 8],
    }

    /// The moves of two rows, by the places at which both found their words: four bits each.
    const fn moves(fifo: bool) -> [Move; 256] {
        let mut moves = [Move { bytes: [0; 16], insert: [0; 8] }; 256];
        let mut found = 0;
        while found < 256 {
            let mut word = 0;
            while word < 8 {
                let (row, to) = (word / 4 * 4, word % 4);
                let here = found >> row & 15_usize;
                let (hit, place) = (here != 0, if here == 0 { 3 } else { here.trailing_zeros() as usize });
                let stays = hit && fifo || to > place;
                let from = if stays {
                    to
                } else if to > 0 {
                    to - 1
                } else {
                    place
                };
                moves[found].insert[word] = match (hit && fifo, to) {
                    (true, _) if to == place => u16::MAX,
                    (false, 0) => u16::MAX,
                    _ => 0,
                };
                let nothing = to == 0 && !hit;
                let from = 2 * (row + from) as u8;
                moves[found].bytes[2 * word] = if nothing { 0x80 } else { from };
                moves[found].bytes[2 * word + 1] = if nothing { 0x80 } else { from + 1 };
                word += 1;
            }
            found += 1;
        }
        moves
    }

    static LRU: [Move; 256] = moves(false);
    static FIFO: [Move; 256] = moves(true);

    /// What both rows of a pair find, and what they add up to.
    #[derive(Clone, Copy)]
    struct Pairs {
        lanes: V3,
        moves: &'static [Move; 256],
        hits: __m128i,
        marked: __m128i,
    }

    impl Pairs {
        fn new(lanes: V3, policy: Policy) -> Self {
            let zero = lanes.sse2._mm_setzero_si128();
            let moves = if policy == Policy::Fifo { &FIFO } else { &LRU };
            Self { lanes, moves, hits: zero, marked: zero }
        }

        /// The steps of two different rows. Returns them, and what both found.
        #[inline(always)]
        fn step<const MARKS: bool>(&mut self, rows: [Row; 2], keys: [u16; 2]) -> ([Row; 2], u8) {
            let V3 { sse2, ssse3, .. } = self.lanes;
            let spread: __m128i = cast([0_u8, 1, 0, 1, 0, 1, 0, 1, 2, 3, 2, 3, 2, 3, 2, 3]);
            let words: __m128i = cast(rows);
            let key = ssse3._mm_shuffle_epi8(sse2._mm_set1_epi32(cast(keys)), spread);
            let same = if MARKS {
                sse2._mm_cmpgt_epi16(sse2._mm_set1_epi16(2), sse2._mm_xor_si128(words, key))
            } else {
                sse2._mm_cmpeq_epi16(words, key)
            };
            self.hits = sse2._mm_sub_epi16(self.hits, same);
            let found = sse2._mm_movemask_epi8(sse2._mm_packs_epi16(same, sse2._mm_setzero_si128())) as u8;
            let Move { bytes, insert } = &self.moves[usize::from(found)];
            let moved = ssse3._mm_shuffle_epi8(words, cast(*bytes));
            let inserted = sse2._mm_and_si128(key, cast(*insert));
            if MARKS {
                let first = sse2._mm_andnot_si128(moved, inserted);
                self.marked =
                    sse2._mm_add_epi16(self.marked, sse2._mm_and_si128(first, sse2._mm_set1_epi16(1)));
            }
            (cast(sse2._mm_or_si128(moved, inserted)), found)
        }

        fn sums(self) -> Sums {
            let sum = |lanes: __m128i| cast::<_, [u16; 8]>(lanes).into_iter().map(u64::from).sum::<u64>();
            Sums { hits: sum(self.hits), marked: sum(self.marked) }
        }
    }

    pub struct Access<'a, P> {
        pub lanes: V3,
        pub rows: &'a mut [Row],
        pub policy: Policy,
        pub pairs: P,
        pub found: &'a mut [u8],
    }

    impl<P: Iterator<Item = ([u32; 2], [u16; 2])>> NullaryFnOnce for Access<'_, P> {
        type Output = Sums;

        #[inline(always)]
        fn call(self) -> Sums {
            let Self { lanes, rows, policy, pairs, found } = self;
            let mut sums = Sums::default();
            let mut steps = Pairs::new(lanes, policy);
            for ((places, keys), found) in pairs.zip(found) {
                // The second access of a pair sees what the first has done: in one row they go one by one.
                let Ok([a, b]) = rows.get_disjoint_mut(places.map(|place| place as usize)) else {
                    *found = two::<false>(rows, policy, places, keys, &mut sums);
                    continue;
                };
                ([*a, *b], *found) = steps.step::<false>([*a, *b], keys);
            }
            Sums { hits: sums.hits + steps.sums().hits, ..sums }
        }
    }

    pub struct AccessGranules<'a, P> {
        pub lanes: V3,
        pub rows: &'a mut [Row; PLACES],
        pub policy: Policy,
        pub pairs: P,
    }

    impl<P: Iterator<Item = ([u16; 2], [u16; 2])>> NullaryFnOnce for AccessGranules<'_, P> {
        type Output = Sums;

        #[inline(always)]
        fn call(self) -> Sums {
            let Self { lanes, rows, policy, pairs } = self;
            let mut steps = Pairs::new(lanes, policy);
            for (places, keys) in pairs {
                let [a, b] = places.map(usize::from);
                ([rows[a], rows[b]], _) = steps.step::<true>([rows[a], rows[b]], keys);
            }
            steps.sums()
        }
    }

    /// For each set of eight lanes the numbers of those lanes, in order.
    static PACK: [u64; 256] = {
        let mut table = [0; 256];
        let mut kept = 0;
        while kept < 256 {
            let (mut lane, mut count) = (0, 0);
            while lane < 8 {
                if kept >> lane & 1 == 1 {
                    table[kept] |= lane << (8 * count);
                    count += 1;
                }
                lane += 1;
            }
            kept += 1;
        }
        table
    };

    pub struct DropRepeated<'a> {
        pub lanes: V3,
        pub lines: &'a [u32],
        pub out: &'a mut [u32],
        pub count: usize,
    }

    impl NullaryFnOnce for DropRepeated<'_> {
        type Output = usize;

        #[inline(always)]
        fn call(self) -> usize {
            let Self { lanes: V3 { sse2, avx, avx2, .. }, lines, out, mut count } = self;
            let (before, _) = lines.as_chunks::<8>();
            let (after, _) = lines.get(1..).unwrap_or_default().as_chunks::<8>();
            for (&before, &after) in before.iter().zip(after) {
                let same = avx2._mm256_cmpeq_epi32(cast(before), cast(after));
                let kept = !avx._mm256_movemask_ps(avx._mm256_castsi256_ps(same)) as u8;
                let order = sse2._mm_set_epi64x(0, PACK[usize::from(kept)] as i64);
                let order = avx2._mm256_cvtepu8_epi32(order);
                let packed: [u32; 8] = cast(avx2._mm256_permutevar8x32_epi32(cast(after), order));
                out[count..count + 8].copy_from_slice(&packed);
                count += kept.count_ones() as usize;
            }
            count
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rows::Rows;
    use super::*;

    /// All rows of up to four of `keys`' words, in any order.
    fn all_rows<const MARKS: bool>(keys: &[u16]) -> Vec<Row> {
        let mut rows = vec![[Rows::<MARKS>::FREE; 4]];
        let mut last = rows.clone();
        for held in 0..4 {
            let longer = |row: &Row| {
                let new = |key: &&u16| row[..held].iter().all(|word| word ^ **key > 1);
                let longer = |key: &u16| {
                    let mut longer = *row;
                    longer[held] = *key;
                    longer
                };
                keys.iter().filter(new).map(longer).collect::<Vec<_>>()
            };
            last = last.iter().flat_map(longer).collect();
            rows.extend(&last);
        }
        rows
    }

    /// What `lanes` make of all pairs of rows and keys, each pair on its own, and of pairs of lines in one row.
    fn outcomes<const MARKS: bool>(lanes: Lanes, policy: Policy, keys: &[u16]) -> Vec<([Row; 2], u8, Sums)> {
        let rows = all_rows::<MARKS>(keys);
        // Beside each row one of all others in turn: every row and key on either side.
        let beside = |i: usize| rows[(i * 7 + 3) % rows.len()];
        let mut granules = vec![[0; 4]; PLACES].into_boxed_slice();
        let granules: &mut [Row; PLACES] = (&mut *granules).try_into().expect("so many");
        let mut outcomes = Vec::new();
        for (i, &row) in rows.iter().enumerate() {
            for &a in keys {
                for &b in keys {
                    let pair = [row, beside(i)];
                    if MARKS {
                        let places = [u16::MAX, 0];
                        [granules[PLACES - 1], granules[0]] = pair;
                        let pairs = [(places, [a, b])].into_iter();
                        let sums = lanes.access_granules(granules, policy, pairs);
                        outcomes.push(([granules[PLACES - 1], granules[0]], 0, sums));
                        continue;
                    }
                    for places in [[0, 1], [0, 0]] {
                        let (mut pair, mut found) = (pair, [0]);
                        let pairs = [(places, [a, b])].into_iter();
                        let sums = lanes.access(&mut pair, policy, pairs, &mut found);
                        outcomes.push((pair, found[0], sums));
                    }
                }
            }
        }
        outcomes
    }

    #[test]
    fn vectors_move_rows_as_steps_do() {
        for policy in [Policy::Lru, Policy::Fifo] {
            let keys = [0, 1, 0x8000, 0xfffe, 0x0100];
            let [plain, vectors] =
                [Lanes::Plain, Lanes::of_processor()].map(|lanes| outcomes::<false>(lanes, policy, &keys));
            assert!(plain == vectors, "{policy:?}, lines");
            // Four words, marked or not, and two of them once more the other way round.
            let keys = [2, 5, 0x100, 0x101, 0x7ffc, 0x7ffd];
            let [plain, vectors] =
                [Lanes::Plain, Lanes::of_processor()].map(|lanes| outcomes::<true>(lanes, policy, &keys));
            assert!(plain == vectors, "{policy:?}, granules");
        }
    }

    #[test]
    fn vectors_count_as_many_pairs_as_they_are_given() {
        let pairs = || std::iter::repeat_n(([0, 1], [3, 5]), 1 << 15);
        let counts = [Lanes::Plain, Lanes::of_processor()].map(|lanes| {
            let mut granules = Rows::<true>::new(PLACES, Policy::Lru);
            granules.access_granules(lanes, pairs())
        });
        assert_eq!(counts, [Sums { hits: (1 << 16) - 2, marked: 2 }; 2]);
    }

    #[test]
    fn lines_that_repeat_are_dropped() {
        // All patterns of repeats among 12 lines, from all places of a longer run.
        for pattern in 0..1_u32 << 12 {
            let lines: Vec<u32> = (0..12).map(|i| 40 + (pattern >> i).count_ones()).collect();
            for (begin, before) in [(0, 7), (0, lines[0]), (3, lines[2]), (11, lines[10]), (12, lines[11])] {
                let mut expected = lines[begin..].to_vec();
                expected.insert(0, before);
                expected.dedup();
                for lanes in [Lanes::Plain, Lanes::of_processor()] {
                    let mut out = [0; 20];
                    let count = lanes.drop_repeated(&lines[begin..], before, &mut out);
                    assert_eq!(out[..count], expected[1..], "{lines:?} from {begin}, {lanes:?}");
                }
            }
        }
    }
}
