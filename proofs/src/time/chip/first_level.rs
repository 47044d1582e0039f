//! Theorems of a first-level cache in time: one look-up from any legal state (CH-9 to CH-11), and whole runs
//! of small chips (CH-8, CH-11).
//!
//! The state is that of one set of four ways, since an access changes no other set (`access_is_the_step_of_its_set`),
//! with up to three lines in flight. It is legal if no line is in flight twice and each line in flight has a
//! register.

use super::laws::{Ports, Queue, held};
use super::scope;
use crate::draw::{self, WORDS};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::time::{Answer, FirstLevelInTime, L1Config, LineInFlight, LinePart, TransferId};
use saarcor_model::vm::{HostAddr, LineAddr, Policy, Set};

/// Most lines in flight. To Kani always so many: a list whose length is a symbol takes it more than 2 GiB.
const IN_FLIGHT: usize = if cfg!(kani) { 2 } else { 3 };

/// An empty list with room for what a step adds: to Kani, to which a list that grows is work.
fn list<T>() -> Vec<T> {
    if cfg!(kani) { Vec::with_capacity(IN_FLIGHT + 1) } else { Vec::new() }
}

/// Any legal cache in time of one set; its lines in flight, each with thread 0 waiting.
///
/// Small scope: way `w` holds line `w`; lines 0, 4 and 7 are in flight.
fn cache<S: Source>(s: &mut S) -> Result<FirstLevelInTime, Stop> {
    let registers = s.value("registers", 1..=64, &WORDS[1..4]);
    let config = L1Config { line: 4, sets: 1, ports: 1, latency: 1, mshrs: registers };
    let mut l1 = FirstLevelInTime::new(HostAddr(0), config, 1);
    let mut set = Set::empty(Policy::Lru);
    for way in 0..4 {
        set.resident[way] = draw::flag(s, "resident");
        set.lines[way] = LineAddr(s.value("line of a way", 0..=u32::MAX, draw::words(way, 1)));
    }
    let oldest = s.value("rotation of the order", 0..=3, &draw::BYTES[..2]);
    for way in 0..4 {
        set.order[way] = (way as u8 + oldest) & 3;
    }
    assume!(set.is_valid(Policy::Lru));
    // The set alone: CBMC 6.6 ends where it reads a constant with an array of nothing, as the contents are.
    l1.cache.sets[0].set = set;
    l1.in_flight = list();
    if cfg!(kani) {
        s.size("lines in flight", IN_FLIGHT);
        l1.queue.reserve(2);
        l1.parts.reserve(1);
    }
    for _ in 0..IN_FLIGHT {
        if cfg!(kani) || draw::flag(s, "one more line in flight") {
            let line =
                LineAddr(s.value("line in flight", 0..=u32::MAX, if cfg!(kani) { &[] } else { &[0, 4, 7] }));
            let (mut threads, reads) = (list(), list());
            threads.push(0);
            l1.in_flight.push(LineInFlight { line, threads, unread: 1, reads });
        }
    }
    assume!(l1.in_flight.len() <= l1.registers && flies_once(&l1));
    Ok(l1)
}

/// Whether no line is in flight twice.
fn flies_once(l1: &FirstLevelInTime) -> bool {
    let mut once = true;
    for i in 0..l1.in_flight.len() {
        for j in 0..i {
            once &= l1.in_flight[i].line != l1.in_flight[j].line;
        }
    }
    once
}

/// Whether a line is in flight.
fn flies(l1: &FirstLevelInTime, line: LineAddr) -> bool {
    let mut found = false;
    for i in 0..l1.in_flight.len() {
        found |= l1.in_flight[i].line == line;
    }
    found
}

/// Lines of a small scope, which are resident or in flight or not.
static LINES: [u32; 6] = [0, 1, 3, 4, 6, 7];
/// The same, and one that is line 4 in its lower bits.
static LINES_AND_A_FAR_ONE: [u32; 7] = [0, 1, 3, 4, 6, 7, 0x1_0004];

/// A line from the host and the like: one part of it.
fn part(line: LineAddr) -> LinePart {
    LinePart { cache: 0, line, addr: HostAddr(0), bytes: 4 }
}

theorems! {
    /// A line in flight is not fetched again: whatever the set says of it, a thread that looks it up waits
    /// with the others, and no line is ever in flight twice.
    #["CH-10", not_for_kani "lists in a list, which grows, take it more than 2 GiB", covers ["in flight and resident", "in flight and evicted", "fetched"]]
    fn line_in_flight_is_not_fetched_again(s) {
        let mut l1 = cache(s)?;
        let line = draw::line(s, &LINES_AND_A_FAR_ONE);
        let (in_flight, resident, before) = (flies(&l1, line), l1.cache.is_resident(line), l1.in_flight.len());
        cover!(s, "in flight and resident", in_flight && resident);
        cover!(s, "in flight and evicted", in_flight && !resident);
        let answer = l1.look_up(line, 1);
        if answer == Answer::Missing {
            cover!(s, "fetched", true);
            l1.fetch(line, 1, vec![part(line)]);
        }
        check!((answer == Answer::InFlight) == in_flight, "{line:?} is in flight: {in_flight}, but {answer:?}");
        check!(flies_once(&l1) && l1.in_flight.len() <= l1.registers, "after {answer:?} of {line:?}: {l1:?}");
        let waits = in_flight || answer == Answer::Missing;
        let mut waiting = 0;
        for i in 0..l1.in_flight.len() {
            let own = l1.in_flight[i].line == line;
            let last = l1.in_flight[i].threads[l1.in_flight[i].threads.len() - 1];
            waiting += usize::from(last == 1);
            check!(last != 1 || own, "{answer:?}: thread 1 asked for {line:?}, and waits for {:?}", l1.in_flight[i].line);
            check!(i >= before || l1.in_flight[i].threads[0] == 0, "thread 0 waits no more for {:?}", l1.in_flight[i].line);
        }
        check_eq!(waiting, usize::from(waits), "lines for which thread 1 waits, after {answer:?} of {line:?}");
    }

    /// While all registers are taken, a look-up of a line that is neither resident nor in flight changes
    /// nothing, but that its thread is the last of the queue; any other look-up queues nobody.
    #["CH-11", unwind 7, covers ["no register", "resident while all are taken", "a register is free"]]
    fn look_up_without_a_register_only_queues(s) {
        let mut l1 = cache(s)?;
        // A chip of 64 pipelines may queue nearly all of its threads.
        let queued = if cfg!(kani) { 1 } else { s.value("threads in the queue", 0..=4095_u32, &[0, 1, 70]) as usize };
        for _ in 0..queued {
            l1.queue.push_back(9);
        }
        let line = draw::line(s, &LINES);
        let is_full = l1.in_flight.len() == l1.registers;
        let needs = !l1.cache.is_resident(line) && !flies(&l1, line);
        cover!(s, "no register", is_full && needs);
        cover!(s, "resident while all are taken", is_full && l1.cache.is_resident(line));
        cover!(s, "a register is free", !is_full && needs);
        let (cache, accesses) = (l1.cache.clone(), l1.report.accesses);
        let answer = l1.look_up(line, 1);
        check!((answer == Answer::NoRegister) == (is_full && needs), "{line:?}, full {is_full}, needs one {needs}: {answer:?}");
        if answer == Answer::NoRegister {
            check!(l1.cache.sets[0].set == cache.sets[0].set && l1.report.accesses == accesses, "{line:?} changed {l1:?}");
            let last = l1.queue.len() == queued + 1 && l1.queue[queued] == 1 && (queued == 0 || l1.queue[0] == 9);
            check!(last, "behind {queued} threads: queue {:?}", l1.queue);
        } else {
            check!(l1.queue.len() == queued && l1.report.accesses == accesses + 1, "{answer:?}: {:?}", l1.queue);
        }
    }

    /// A look-up is one step of its line's set: a line is resident exactly if the set holds it and it is not
    /// in flight, and it is the last that the set evicts after that.
    #["CH-9", unwind 7, covers ["resident", "missing"]]
    fn look_up_is_a_step_of_the_set(s) {
        let mut l1 = cache(s)?;
        let line = draw::line(s, &LINES_AND_A_FAR_ONE);
        let (resident, in_flight) = (l1.cache.is_resident(line), flies(&l1, line));
        let mut expected = l1.cache.clone();
        expected.access(line, || ());
        let answer = l1.look_up(line, 1);
        cover!(s, "resident", answer == Answer::Resident);
        cover!(s, "missing", answer == Answer::Missing);
        check!((answer == Answer::Resident) == (resident && !in_flight), "{line:?}, resident {resident}, in flight {in_flight}: {answer:?}");
        let same = l1.cache.sets[0].set == expected.sets[0].set;
        check!(answer == Answer::NoRegister || same, "{answer:?} of {line:?}: {:?}", l1.cache.sets[0].set);
    }

    /// A part that is read counts for the line of which it is, and for no other line in flight.
    #["CH-16", not_for_kani "lists of lines in flight take it more than 120 seconds or 2 GiB", covers ["the first line", "the last line"]]
    fn read_counts_for_the_line_of_its_part(s) {
        let mut l1 = cache(s)?;
        assume!(l1.in_flight.len() == IN_FLIGHT);
        let own = usize::from(s.value("which line", 0..=1, &draw::BYTES[..2])) * (IN_FLIGHT - 1);
        cover!(s, "the first line", own == 0);
        cover!(s, "the last line", own > 0);
        let line = l1.in_flight[own].line;
        l1.part_is_read(line, TransferId(7));
        for i in 0..IN_FLIGHT {
            let LineInFlight { unread, ref reads, .. } = l1.in_flight[i];
            let read = unread == 0 && reads.len() == 1 && reads[0] == TransferId(7);
            check!(if i == own { read } else { unread == 1 && reads.is_empty() }, "line {i} of {l1:?}, read {own}");
        }
    }

    /// The ports of a first-level cache serve pipelines in turn, and threads of a pipeline in turn: none that
    /// asks all the while is passed over while another one is served twice.
    #["CH-8", not_for_kani "whole runs of a chip", covers ["a wait for the port", "several ports"]]
    fn ports_serve_in_turn(s) {
        let (config, programs) = scope::contended(s);
        let report = held(&config, &programs, &mut Ports::new(&config))?;
        cover!(s, "a wait for the port", report.units.iter().any(|unit| unit.stalls[1] > 0));
        cover!(s, "several ports", config.l1[1].ports > 1);
    }

    /// The queue for a register is served in its order, when a line arrives and when a look-up leaves a register
    /// free.
    #["CH-11", not_for_kani "whole runs of a chip", covers ["queued"]]
    fn queue_is_served_in_order(s) {
        let (config, programs) = scope::contended(s);
        let report = held(&config, &programs, &mut Queue::new(&config))?;
        cover!(s, "queued", report.units.iter().any(|unit| unit.stalls[2] > 0));
    }
}
