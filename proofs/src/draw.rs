//! Arbitrary parts of the model, drawn from a source of values.

use crate::source::{Source, Stop};
use crate::{assume, check};
use saarcor_model::host::Edges;
use saarcor_model::vm::{Bytes, Geometry, Hash, HostAddr, LineAddr, MAX_WAYS, Policy, Set};

/// 0, 1, 2 ... up to 39, the last bit of a metadata entry.
macro_rules! counting {
    ($number:ty) => {{
        let mut numbers = [0; 40];
        let mut i = 0;
        while i < numbers.len() {
            numbers[i] = i as $number;
            i += 1;
        }
        numbers
    }};
}

/// 0, 1, 2 ..., of which small scopes are parts.
pub static BYTES: [u8; 40] = counting!(u8);

/// The same in 32 bits.
pub static WORDS: [u32; 40] = counting!(u32);

/// Addresses around the powers of two, and at both ends: where fields of an address begin and end.
pub static EDGES: [u32; 97] = {
    let mut edges = [u32::MAX; 97];
    let mut bit = 0;
    while bit < 32 {
        edges[3 * bit] = (1_u32 << bit) - 1;
        edges[3 * bit + 1] = 1 << bit;
        edges[3 * bit + 2] = !(1 << bit);
        bit += 1;
    }
    edges
};

/// A few of them, for theorems that draw several.
pub static ENDS: [u32; 12] =
    [0, 1, 2, 3, 127, 128, 0xffff, 0x1_0000, 0x1_0001, 0x8000_0000, u32::MAX - 1, u32::MAX];

/// One of two.
pub fn flag(s: &mut impl Source, name: &'static str) -> bool {
    s.value(name, 0..=1, &BYTES[..2]) == 1
}

/// Either rule for edges.
pub fn edges(s: &mut impl Source) -> Edges {
    if flag(s, "edges are owned") { Edges::Owned } else { Edges::Shared }
}

/// Any replacement policy.
pub fn policy(s: &mut impl Source) -> Policy {
    match s.value("policy (lru, fifo, plru)", 0..=2, &BYTES[..3]) {
        0 => Policy::Lru,
        1 => Policy::Fifo,
        _ => Policy::Plru,
    }
}

/// Any index hash.
pub fn hash(s: &mut impl Source) -> Hash {
    match s.value("hash (low, add-upper, add-upper-all)", 0..=2, &BYTES[..3]) {
        0 => Hash::Low,
        1 => Hash::AddUpper,
        _ => Hash::AddUpperAll,
    }
}

/// Binary logarithms of the ways, the line and the sets of any legal geometry, up to 4 GiB.
pub fn logarithms<S: Source>(s: &mut S) -> Result<(u32, u32, u32), Stop> {
    let ways = s.value("log2 ways", 0..=MAX_WAYS.ilog2(), &WORDS[..5]);
    let line = s.value("log2 line", 0..=32, &WORDS[..33]);
    assume!(ways + line <= 32);
    let sets = s.value("log2 sets", 0..=32, &WORDS[..33]);
    assume!(ways + line + sets <= 32);
    Ok((ways, line, sets))
}

/// The geometry of these logarithms.
pub fn of_logarithms(ways: u32, line: u32, sets: u32) -> Result<Geometry, Stop> {
    match Geometry::new(Bytes(1 << (ways + line + sets)), Bytes(1 << line), 1 << ways) {
        Ok(geometry) => Ok(geometry),
        Err(_) => {
            check!(false, "legal sizes are refused: 2^{ways} ways, 2^{line} bytes a line, 2^{sets} sets");
            Err(Stop::Vacuous)
        }
    }
}

/// Any legal geometry, up to 4 GiB.
pub fn geometry<S: Source>(s: &mut S) -> Result<Geometry, Stop> {
    let (ways, line, sets) = logarithms(s)?;
    of_logarithms(ways, line, sets)
}

/// Any host address.
pub fn addr(s: &mut impl Source, small: &'static [u32]) -> HostAddr {
    HostAddr(s.value("address", 0..=u32::MAX, small))
}

/// Any line address.
pub fn line(s: &mut impl Source, small: &'static [u32]) -> LineAddr {
    LineAddr(s.value("line", 0..=u32::MAX, small))
}

/// Any legal set of `WAYS` ways, of any policy.
///
/// Small scope: way `w` holds line `w`, and a free way still holds one of `0 ..= WAYS`.
pub fn set<S: Source, const WAYS: usize>(s: &mut S) -> Result<(Policy, Set<WAYS>), Stop> {
    let policy = policy(s);
    Ok((policy, set_of::<S, WAYS>(s, policy)?))
}

/// Any legal set of that policy.
pub fn set_of<S: Source, const WAYS: usize>(s: &mut S, policy: Policy) -> Result<Set<WAYS>, Stop> {
    s.size("ways", WAYS);
    let mut set = Set::empty(policy);
    // At random, wide sets would hardly ever be full.
    let full = flag(s, "full");
    for way in 0..WAYS {
        set.resident[way] = full || flag(s, "resident");
        let small = if set.resident[way] { words(way, 1) } else { words(0, WAYS + 1) };
        set.lines[way] = LineAddr(s.value("line of a way", 0..=u32::MAX, small));
    }
    set.order = order(s, policy);
    assume!(set.is_valid(policy));
    Ok(set)
}

/// Any legal set of many ways.
///
/// Small scope: way `w` holds line `w`, but for one way at most, which is free; LRU and FIFO have their order from any way
/// on, and the bits of PLRU's tree are alike.
pub fn wide_set<S: Source, const WAYS: usize>(s: &mut S) -> Result<(Policy, Set<WAYS>), Stop> {
    s.size("ways", WAYS);
    let policy = policy(s);
    let mut set = Set::<WAYS>::empty(policy);
    let free = s.value("free way", 0..=WAYS as u32, words(0, WAYS + 1)) as usize;
    for way in 0..WAYS {
        set.resident[way] = way != free && s.value("resident", 0..=1, &BYTES[1..2]) == 1;
        set.lines[way] = LineAddr(s.value("line of a way", 0..=u32::MAX, &WORDS[way..=way]));
    }
    set.order = wide_order(s, policy);
    assume!(set.is_valid(policy));
    Ok((policy, set))
}

/// Any legal management bits of many ways.
#[cfg(not(kani))]
fn wide_order<const WAYS: usize>(s: &mut impl Source, policy: Policy) -> [u8; WAYS] {
    let first = s.value("youngest way, or bits of the tree", 0..=WAYS as u8 - 1, &BYTES[..WAYS]);
    let mut order = std::array::from_fn(|place| (place as u8 + first) % WAYS as u8);
    for place in 0..WAYS {
        if policy == Policy::Plru {
            let bit = s.value("bit of the tree", 0..=1, &BYTES[..1]) ^ (first & 1);
            order[place] = if place > 0 { bit } else { 0 };
        } else {
            let later = (WAYS - 1 - place) as u8;
            order.swap(place, place + usize::from(s.value("exchange", 0..=later, &BYTES[..1])));
        }
    }
    order
}

/// Any management bits: that they are legal is assumed with the set.
#[cfg(kani)]
fn wide_order<const WAYS: usize>(s: &mut impl Source, policy: Policy) -> [u8; WAYS] {
    order(s, policy)
}

/// Any legal management bits.
#[cfg(not(kani))]
pub fn order<const WAYS: usize>(s: &mut impl Source, policy: Policy) -> [u8; WAYS] {
    let mut order = [0; WAYS];
    if policy == Policy::Plru {
        for node in 1..WAYS {
            order[node] = s.value("bit of the tree", 0..=1, &BYTES[..2]);
        }
    } else {
        // Every permutation, by exchanging each place with a later one.
        for place in 0..WAYS {
            order[place] = place as u8;
        }
        for place in 0..WAYS {
            let later = (WAYS - 1 - place) as u8;
            let with = s.value("exchange", 0..=later, &BYTES[..=usize::from(later)]);
            order.swap(place, place + usize::from(with));
        }
    }
    order
}

/// Any management bits: that they are legal is assumed with the set.
#[cfg(kani)]
pub fn order<const WAYS: usize>(s: &mut impl Source, _policy: Policy) -> [u8; WAYS] {
    let mut order = [0; WAYS];
    for place in 0..WAYS {
        // Of the small scope one: those who ask what is drawn come to the end with it.
        order[place] = s.value("management bits", 0..=u8::MAX, &BYTES[place..=place]);
    }
    order
}

/// Some numbers in a row, for a small scope: of no use to Kani, to which working them out is work.
pub fn words(first: usize, count: usize) -> &'static [u32] {
    if cfg!(kani) { &[] } else { &WORDS[first..][..count] }
}

/// Any line. Small scope: those that [`set_of`] puts into a set of `WAYS` ways, and one more.
pub fn line_of_set<const WAYS: usize>(s: &mut impl Source) -> LineAddr {
    line(s, words(0, WAYS + 1))
}

/// Judges a body for sets of 1, 2 and 4 ways; Kani, of 4: all three together cost it twice the time.
macro_rules! any_ways {
    ($source:expr, $module:ident::$body:ident) => {
        match $crate::draw::log2_ways($source) {
            #[cfg(not(kani))]
            0 => $module::$body::<S, 1>($source)?,
            #[cfg(not(kani))]
            1 => $module::$body::<S, 2>($source)?,
            _ => $module::$body::<S, 4>($source)?,
        }
    };
}
pub(crate) use any_ways;

/// Binary logarithm of the ways that [`any_ways`] judges.
pub fn log2_ways(s: &mut impl Source) -> u32 {
    if cfg!(kani) { 2 } else { s.value("log2 ways", 0..=2, &WORDS[..3]) }
}
