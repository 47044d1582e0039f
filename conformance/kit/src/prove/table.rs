//! The step of one set as a table, made by running the specification's step on every state.
//!
//! A set compares lines for equality and does nothing else with them (`proofs/src/vm/set.rs` rests on the same), so
//! its states are finite: which ways are resident, the order of the ways, and which ways hold the line that is asked
//! for. A [`Table`] has one [`Row`] for each thing that can happen in each way: when it happens, and what it changes.
//! Its conditions are the strongest that hold in all states in which the step does so, and no two of them hold in one
//! state: a step for which that cannot be has no table.

use crate::error::Error;
use saarcor_model::vm::{LineAddr, Outcome, Policy, Set, Way};

/// What happens to a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Event {
    /// An access finds its line.
    Hit,
    /// An access loads its line into a free way.
    Fill,
    /// An access evicts a line.
    Evict,
    /// An invalidation finds its line.
    Forget,
}

impl Event {
    /// All, in the order of a table's rows.
    pub const ALL: [Self; 4] = [Self::Hit, Self::Fill, Self::Evict, Self::Forget];
}

/// Values of some bits of a set's state.
///
/// The state of a set is a number: bit `way` says whether the way is resident; above are the bits of the order. LRU
/// and FIFO have a bit for each pair of ways `a < b`, in the order of [`pairs`]: `a` was used (loaded) before `b`. PLRU
/// has the bits of the nodes `1 .. ways` of its tree. A cold set is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Literals {
    /// The bits that are meant.
    pub mask: u64,
    /// Their values; 0 elsewhere.
    pub values: u64,
}

impl Literals {
    /// Whether a state has these values.
    #[must_use]
    pub fn hold(self, state: u64) -> bool {
        state & self.mask == self.values
    }

    /// The state with these values in the place of its own.
    #[must_use]
    pub fn put(self, state: u64) -> u64 {
        state & !self.mask | self.values
    }

    /// Whether no state has both.
    #[must_use]
    fn exclude(self, other: Self) -> bool {
        self.mask & other.mask & (self.values ^ other.values) != 0
    }
}

/// What happens in a way, when, and what it changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// What happens.
    pub event: Event,
    /// The way in which it does.
    pub way: usize,
    /// Its condition, beside the line that is resident in the way (hit, invalidation) or in none.
    pub when: Literals,
    /// The bits that it sets.
    pub then: Literals,
}

/// The step of a set of a policy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Ways of the set.
    pub ways: usize,
    /// Its policy.
    pub policy: Policy,
    /// Bits of its state.
    pub bits: usize,
    /// The rows, by event and way.
    pub rows: Vec<Row>,
}

/// The step that a table is made of: access and invalidation.
pub(crate) struct Step<const WAYS: usize> {
    pub access: fn(&Set<WAYS>, LineAddr, Policy) -> (Set<WAYS>, Outcome),
    pub invalidate: fn(Set<WAYS>, LineAddr) -> (Set<WAYS>, Option<Way>),
}

impl<const WAYS: usize> Step<WAYS> {
    /// The specification's.
    pub const SPECIFIED: Self = Self { access: Set::access, invalidate: Set::invalidate };
}

/// The pairs of ways, the lower one first.
pub fn pairs(ways: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..ways).flat_map(move |a| (a + 1..ways).map(move |b| (a, b)))
}

/// The line that is asked for, and a line a way that is another.
const ASKED: LineAddr = LineAddr(0);
fn other(way: usize) -> LineAddr {
    LineAddr(way as u32 + 1)
}

/// What is known of a row while states are visited.
#[derive(Clone, Copy)]
struct Seen {
    and: u64,
    or: u64,
    kept: u64,
    set: u64,
    cleared: u64,
}

impl Table {
    /// The table of the specification's step.
    ///
    /// # Errors
    /// Where there is none for so many ways: there are those for 1, 2, 4 and 8.
    pub fn new(ways: u32, policy: Policy) -> Result<Self, Error> {
        match ways {
            1 => Self::of(&Step::<1>::SPECIFIED, policy),
            2 => Self::of(&Step::<2>::SPECIFIED, policy),
            4 => Self::of(&Step::<4>::SPECIFIED, policy),
            8 => Self::of(&Step::<8>::SPECIFIED, policy),
            _ => Err(format!("a proof for {ways} ways: there are proofs for 1, 2, 4 and 8").into()),
        }
    }

    /// The table of a step.
    pub(crate) fn of<const WAYS: usize>(step: &Step<WAYS>, policy: Policy) -> Result<Self, Error> {
        let mut seen: [[Option<Seen>; WAYS]; 4] = [[None; WAYS]; 4];
        let mut wrong = None;
        for order in orders::<WAYS>(policy) {
            for resident in 0..1_u64 << WAYS {
                for asked in 0..=WAYS {
                    let set = set_of(order, resident, if asked < WAYS { 1 << asked } else { 0 });
                    let before = number_of(&set, policy);
                    let mut note = |event: Event, way: usize, after: u64| {
                        let row = seen[event as usize][way].get_or_insert(Seen {
                            and: !0,
                            or: 0,
                            kept: !0,
                            set: !0,
                            cleared: !0,
                        });
                        row.and &= before;
                        row.or |= before;
                        row.kept &= !(before ^ after);
                        row.set &= after;
                        row.cleared &= !after;
                    };
                    match accessed(step, &set, policy) {
                        Some((event, way, after)) => note(event, way, after),
                        None => wrong = Some(set),
                    }
                    match forgotten(step, &set, policy) {
                        Some(Some((way, after))) => note(Event::Forget, way, after),
                        Some(None) => {}
                        None => wrong = Some(set),
                    }
                }
            }
        }
        if let Some(set) = wrong {
            return Err(format!(
                "the step has no table: it changes other tags, or finds a line where it is not: {set:?}"
            )
            .into());
        }
        let bits = bits(WAYS, policy);
        let all = (1_u64 << bits) - 1;
        let mut rows = Vec::new();
        for event in Event::ALL {
            for way in 0..WAYS {
                let seen = seen[event as usize][way].ok_or_else(|| {
                    Error::from(format!("the step has no table: no {event:?} in way {way}"))
                })?;
                let mask = !(seen.and ^ seen.or) & all;
                let changed = !seen.kept & all;
                if changed & !(seen.set | seen.cleared) != 0 {
                    return Err(format!(
                        "the step has no table: {event:?} in way {way} changes a bit to what is no constant"
                    )
                    .into());
                }
                rows.push(Row {
                    event,
                    way,
                    when: Literals { mask, values: seen.and & mask },
                    then: Literals { mask: changed, values: seen.set & changed },
                });
            }
        }
        let misses: Vec<_> =
            rows.iter().filter(|row| matches!(row.event, Event::Fill | Event::Evict)).collect();
        for (n, row) in misses.iter().enumerate() {
            if let Some(too) = misses[..n].iter().find(|too| !row.when.exclude(too.when)) {
                return Err(format!("the step has no table: {row:?} and {too:?} are for one state").into());
            }
        }
        Ok(Self { ways: WAYS, policy, bits, rows })
    }

    /// The row of an access or an invalidation of a line that is resident in a way, or in none.
    #[must_use]
    pub fn row(&self, state: u64, resident_in: Option<usize>, forgets: bool) -> Option<&Row> {
        self.rows.iter().find(|row| match row.event {
            Event::Hit => !forgets && resident_in == Some(row.way),
            Event::Forget => forgets && resident_in == Some(row.way),
            Event::Fill | Event::Evict => !forgets && resident_in.is_none() && row.when.hold(state),
        })
    }
}

/// Bits of a set's state.
fn bits(ways: usize, policy: Policy) -> usize {
    match policy {
        Policy::Lru | Policy::Fifo => ways + ways * (ways - 1) / 2,
        Policy::Plru => 2 * ways - 1,
    }
}

/// What an access does; none where no row can say it.
fn accessed<const WAYS: usize>(
    step: &Step<WAYS>,
    set: &Set<WAYS>,
    policy: Policy,
) -> Option<(Event, usize, u64)> {
    let (next, outcome) = (step.access)(set, ASKED, policy);
    let way = usize::from(outcome.way().0);
    let holds = |way: usize| set.resident[way] && set.lines[way] == ASKED;
    let mut lines = set.lines;
    let event = match outcome {
        Outcome::Hit { .. } if holds(way) => Event::Hit,
        Outcome::Miss { evicted, .. } if !(0..WAYS).any(holds) => {
            lines[way] = ASKED;
            match evicted {
                None => Event::Fill,
                Some(line) if line == set.lines[way] => Event::Evict,
                Some(_) => return None,
            }
        }
        _ => return None,
    };
    (next.lines == lines && next.is_valid(policy)).then(|| (event, way, number_of(&next, policy)))
}

/// What an invalidation does, where it does something; none where no row can say it.
fn forgotten<const WAYS: usize>(
    step: &Step<WAYS>,
    set: &Set<WAYS>,
    policy: Policy,
) -> Option<Option<(usize, u64)>> {
    let (next, way) = (step.invalidate)(*set, ASKED);
    let held = (0..WAYS).find(|&way| set.resident[way] && set.lines[way] == ASKED);
    let way = way.map(|way| usize::from(way.0));
    let is_right = way == held && next.lines == set.lines && (held.is_some() || next == *set);
    is_right.then(|| way.map(|way| (way, number_of(&next, policy))))
}

/// A set of that order, in whose ways of `resident` lines are resident, and in whose ways of `asked` the line asked
/// for is, resident or left behind.
fn set_of<const WAYS: usize>(order: [u8; WAYS], resident: u64, asked: u64) -> Set<WAYS> {
    Set {
        lines: std::array::from_fn(|way| if asked >> way & 1 == 1 { ASKED } else { other(way) }),
        resident: std::array::from_fn(|way| resident >> way & 1 == 1),
        order,
    }
}

/// The state of a set as a number, as [`Literals`] has it.
fn number_of<const WAYS: usize>(set: &Set<WAYS>, policy: Policy) -> u64 {
    let mut number = 0;
    for way in 0..WAYS {
        number |= u64::from(set.resident[way]) << way;
    }
    match policy {
        Policy::Lru | Policy::Fifo => {
            let mut places = [0; WAYS];
            for (place, way) in set.order.into_iter().enumerate() {
                places[usize::from(way)] = place;
            }
            let mut bit = WAYS;
            for a in 0..WAYS {
                for b in a + 1..WAYS {
                    number |= u64::from(places[a] > places[b]) << bit;
                    bit += 1;
                }
            }
        }
        Policy::Plru => {
            for node in 1..WAYS {
                number |= u64::from(set.order[node]) << (WAYS + node - 1);
            }
        }
    }
    number
}

/// All orders of a policy.
fn orders<const WAYS: usize>(policy: Policy) -> Vec<[u8; WAYS]> {
    match policy {
        Policy::Lru | Policy::Fifo => {
            let mut orders = Vec::new();
            permute(&mut std::array::from_fn(|way| way as u8), WAYS, &mut orders);
            orders
        }
        Policy::Plru => (0..1_usize << (WAYS - 1))
            .map(|bits| std::array::from_fn(|node| (bits << 1 >> node & 1) as u8))
            .collect(),
    }
}

/// Appends what the permutations of the first places make of `order`.
fn permute<const WAYS: usize>(order: &mut [u8; WAYS], places: usize, orders: &mut Vec<[u8; WAYS]>) {
    if places <= 1 {
        orders.push(*order);
        return;
    }
    for place in 0..places {
        order.swap(place, places - 1);
        permute(order, places - 1, orders);
        order.swap(place, places - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLICIES: [Policy; 3] = [Policy::Lru, Policy::Fifo, Policy::Plru];

    /// How many states were compared: the table does what the step does, in all of them. `stale`: also where the
    /// line asked for was left behind in several ways.
    fn compared<const WAYS: usize>(policy: Policy, stale: bool) -> usize {
        let table = Table::of(&Step::<WAYS>::SPECIFIED, policy).expect("a table");
        let mut states = 0;
        for order in orders::<WAYS>(policy) {
            for resident in 0..1 << WAYS {
                for asked in 0..1_u64 << WAYS {
                    let held = asked & resident;
                    if held.count_ones() > 1 || !stale && asked.count_ones() > 1 {
                        continue;
                    }
                    let set = set_of::<WAYS>(order, resident, asked);
                    let held = (held != 0).then(|| held.trailing_zeros() as usize);
                    let state = number_of(&set, policy);
                    let row = table.row(state, held, false).expect("a row");
                    let (next, outcome) = set.access(ASKED, policy);
                    let after = row.then.put(state);
                    assert_eq!((after, row.way), (number_of(&next, policy), usize::from(outcome.way().0)));
                    let event = match outcome {
                        Outcome::Hit { .. } => Event::Hit,
                        Outcome::Miss { evicted: None, .. } => Event::Fill,
                        Outcome::Miss { .. } => Event::Evict,
                    };
                    assert_eq!(row.event, event);
                    let after = table.row(state, held, true).map_or(state, |row| row.then.put(state));
                    assert_eq!(after, number_of(&set.invalidate(ASKED).0, policy));
                    states += 1;
                }
            }
        }
        states
    }

    #[test]
    fn the_table_is_the_step() {
        for policy in POLICIES {
            compared::<1>(policy, true);
            compared::<2>(policy, true);
        }
        // Orders, times 3⁴ + 4·3³ of residence and lines left behind.
        let of_an_order = 81 + 4 * 27;
        assert_eq!(compared::<4>(Policy::Lru, true), 24 * of_an_order);
        assert_eq!(compared::<4>(Policy::Fifo, true), 24 * of_an_order);
        assert_eq!(compared::<4>(Policy::Plru, true), 8 * of_an_order);
        assert_eq!(compared::<8>(Policy::Plru, true), 128 * (6561 + 8 * 2187));
    }

    #[test]
    #[ignore = "visits some 93 million states of each policy"]
    fn the_table_of_eight_ways_in_order_is_the_step() {
        for policy in [Policy::Lru, Policy::Fifo] {
            assert_eq!(compared::<8>(policy, false), 40_320 * 256 * 9);
        }
    }

    /// Two ways' LRU in full: a line is evicted from way 0 where that was used before way 1.
    #[test]
    fn a_table_of_two_ways() {
        let table = Table::new(2, Policy::Lru).expect("a table");
        let row = table.row(0b111, None, false).expect("a row");
        assert_eq!((row.event, row.way), (Event::Evict, 0));
        assert_eq!((row.when, row.then), (Literals { mask: 7, values: 7 }, Literals { mask: 4, values: 0 }));
        assert_eq!((table.bits, table.rows.len()), (3, 8));
        assert!(Table::new(16, Policy::Lru).is_err());
    }

    /// Another step has another table, or none.
    #[test]
    fn mutated_steps_have_other_tables() {
        fn hits_do_not_touch(set: &Set<4>, line: LineAddr, policy: Policy) -> (Set<4>, Outcome) {
            let (next, outcome) = set.access(line, policy);
            if matches!(outcome, Outcome::Hit { way: Way(3) }) { (*set, outcome) } else { (next, outcome) }
        }
        fn evicts_the_youngest(set: &Set<4>, line: LineAddr, policy: Policy) -> (Set<4>, Outcome) {
            let mut turned = *set;
            turned.order.reverse();
            let (next, outcome) = turned.access(line, policy);
            if set.way_of(line).is_none() { (next, outcome) } else { set.access(line, policy) }
        }
        fn forgets_nothing(set: Set<4>, line: LineAddr) -> (Set<4>, Option<Way>) {
            (set, set.way_of(line))
        }
        fn loses_a_tag(set: &Set<4>, line: LineAddr, policy: Policy) -> (Set<4>, Outcome) {
            let (mut next, outcome) = set.access(line, policy);
            if outcome.way() == Way(1) {
                next.lines[2] = LineAddr(77);
            }
            (next, outcome)
        }
        let right = Table::new(4, Policy::Lru).expect("a table");
        let with = |step: Step<4>| Table::of(&step, Policy::Lru);
        let specified = Step::<4>::SPECIFIED;
        assert_eq!(with(specified).expect("a table"), right);
        for access in [hits_do_not_touch, evicts_the_youngest] {
            let table = with(Step { access, ..Step::<4>::SPECIFIED });
            assert!(table.is_err() || table.is_ok_and(|table| table != right));
        }
        assert_ne!(
            with(Step { invalidate: forgets_nothing, ..Step::<4>::SPECIFIED }).expect("a table"),
            right
        );
        assert!(with(Step { access: loses_a_tag, ..Step::<4>::SPECIFIED }).is_err());
    }
}
