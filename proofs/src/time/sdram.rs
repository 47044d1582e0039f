//! Theorems of the memory chips (SD-1 to SD-5): one clock, one request or one refresh from any legal state. What
//! holds after each holds in any run.
//!
//! The state is that of the chips' own registers (which row is open, from when on a bank may be closed or opened,
//! from when on the bus is free). What really happened, and when, is drawn beside it, and the registers have to
//! agree with it before and after.

use crate::draw::{BYTES, ENDS, WORDS, flag};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::time::{Bank, Direction, Job, Sdram, SdramConfig, Span, TransferId};

/// Bytes of a beat.
const BEAT: u64 = SdramConfig::STANDARD.beat_bytes as u64;

/// A number of clocks. Small scope: 0, 1 and 3.
fn clocks(s: &mut impl Source, name: &'static str) -> u32 {
    s.value(name, 0..=255, &[0, 1, 3])
}

/// A time, in clocks. Small scope: around 20.
fn time(s: &mut impl Source, name: &'static str) -> u64 {
    u64::from(s.value(name, 0..=1_u32 << 20, &[0, 19, 20]))
}

/// Memory chips whose clock is a cycle.
const CHIPS: SdramConfig =
    SdramConfig { cycles_a_clock: 1, banks: 2, refresh_interval: 0, ..SdramConfig::STANDARD };

fn direction(s: &mut impl Source) -> Direction {
    if flag(s, "direction (read, write)") { Direction::Write } else { Direction::Read }
}

/// What really happened in a bank, and when.
#[derive(Clone, Copy, Debug)]
struct History {
    /// Its last opening and its last closing.
    opened: Option<u64>,
    closed: u64,
    /// The clock after the last beat that was written, and after the last one that was commanded to be read.
    written: u64,
    read: u64,
}

/// Whether the registers of a bank agree with what happened: no row is opened too soon (tRP), nor closed (tWR).
fn agrees(bank: &Bank, history: &History, config: &SdramConfig) -> bool {
    let recovered = history.written + u64::from(config.write_recovery);
    bank.opened == history.opened
        && (bank.open.is_some() || bank.closed >= history.closed + u64::from(config.precharge))
        && bank.may_close >= recovered.max(history.read)
}

/// Any bank, with a history with which it agrees.
fn bank<S: Source>(s: &mut S, config: &SdramConfig) -> Result<(Bank, History), Stop> {
    let (open, row) = (flag(s, "row open"), u64::from(s.value("open row", 0..=7, &WORDS[..2])));
    let opened_before = flag(s, "opened before");
    let opened = u64::from(s.value("opened", 0..=1_u32 << 20, &[0, 12, 19]));
    let (closed, may_close) = (time(s, "closed from"), time(s, "may close from"));
    let history = History {
        opened: opened_before.then_some(opened),
        closed: time(s, "last closing"),
        written: time(s, "last beat written"),
        read: time(s, "last beat read"),
    };
    let bank = Bank { open: open.then_some(row), opened: history.opened, closed, may_close };
    assume!(!open || opened_before);
    assume!(agrees(&bank, &history, config));
    Ok((bank, history))
}

theorems! {
    /// From any state, rows are opened and closed as the data sheet says: a row is closed tWR after the last beat
    /// written to it and after all beats read, opened tRP after the closing and tRC after the opening before, and
    /// gets its commands tRCD after its opening.
    #["SD-3", unwind 6, covers ["a row is closed", "a row is opened", "a read", "a write"]]
    fn rows_are_opened_closed_and_used_in_time(s) {
        let (precharge, row_cycle) = (clocks(s, "tRP"), s.value("tRC", 0..=255, &[0, 3, 9]));
        let (ras_to_cas, write_recovery) = (clocks(s, "tRCD"), clocks(s, "tWR"));
        let config = SdramConfig { cas: 0, precharge, row_cycle, ras_to_cas, write_recovery, ..CHIPS };
        let (before, mut history) = bank(s, &config)?;
        let mut sdram = Sdram::new(config);
        let direction = direction(s);
        // Four beats of row 1 of bank 0.
        sdram.request(0, 2 * 4096, 64, direction);
        sdram.banks[0] = before;
        let clock = u64::from(s.value("clock", 0..=1_u32 << 20, &[20, 21, 23]));
        sdram.end_cycle(clock);
        let after = sdram.banks[0];
        let (is_closed, is_opened) = (before.open.is_some() && after.open != before.open, after.opened != before.opened);
        cover!(s, "a row is closed", is_closed);
        cover!(s, "a row is opened", is_opened);
        if is_closed {
            let (recovered, row) = (history.written + u64::from(write_recovery), before.open);
            check!(clock >= recovered && clock >= history.read && row != Some(1), "closed at {clock}: {before:?}, {history:?}, {config:?}");
            history.closed = clock;
        }
        if is_opened {
            let in_time = clock >= history.closed + u64::from(precharge)
                && history.opened.is_none_or(|opened| clock >= opened + u64::from(row_cycle));
            check!(in_time && (before.open.is_none() || is_closed), "opened at {clock}: {before:?}, {history:?}, {config:?}");
            history.opened = Some(clock);
        }
        if sdram.jobs.is_empty() {
            cover!(s, "a read", direction == Direction::Read);
            cover!(s, "a write", direction == Direction::Write);
            let ready = history.opened.is_some_and(|opened| clock >= opened + u64::from(ras_to_cas));
            check!(after.open == Some(1) && ready, "{direction:?} at {clock}: {after:?}, {history:?}, {config:?}");
            match direction {
                Direction::Read => history.read = history.read.max(clock + 4),
                Direction::Write => history.written = history.written.max(clock + 4),
            }
        }
        check!(agrees(&after, &history, &config), "{after:?} after {clock}, where {history:?}, {config:?}");
        check!(sdram.banks[1] == Bank::default(), "a bank without requests changed: {:?}", sdram.banks[1]);
    }

    /// Commands come in the order of the requests, one a clock. A read's data come CL after its command, a write's
    /// with it, and no beat before the last one of earlier requests: so no two beats share a clock of the bus.
    #["SD-4", unwind 6, covers ["a read", "a write", "the bus is busy", "many beats"]]
    fn data_follow_their_commands_and_do_not_overlap(s) {
        let config = SdramConfig { cas: clocks(s, "CL"), ras_to_cas: 0, ..CHIPS };
        let mut sdram = Sdram::new(config);
        let beats = u64::from(s.value("beats", 1..=256_u32, &[1, 8, 9, 40, 256]));
        let direction = direction(s);
        let [transfer, next] = [(); 2].map(|()| sdram.request(0, 0, 16, Direction::Read));
        sdram.jobs[0] = Job::Move { transfer, bank: 0, row: 0, beats, direction };
        let clock = u64::from(s.value("clock", 1 << 10..=1_u32 << 20, &[1 << 10, 1025]));
        sdram.banks[0] = Bank { open: Some(0), opened: Some(clock - 1), ..Bank::default() };
        let bus_free = clock + u64::from(s.value("clocks until the bus is free", 0..=300_u32, &WORDS[..5]));
        sdram.bus_free = bus_free;
        sdram.end_cycle(clock);
        cover!(s, "a read", direction == Direction::Read);
        cover!(s, "a write", direction == Direction::Write);
        cover!(s, "many beats", beats > 8);
        let begin = clock + if direction == Direction::Read { u64::from(config.cas) } else { 0 };
        let given = begin >= bus_free;
        cover!(s, "the bus is busy", !given);
        let expected = given.then_some(Span { begin, end: begin + beats });
        check_eq!(sdram.span_of(transfer), expected, "{direction:?} of {beats} beats at {clock}, the bus free from {bus_free} on, {config:?}");
        let free = if given { begin + beats } else { bus_free };
        check_eq!(sdram.bus_free, free, "the bus is free, after {direction:?} of {beats} beats at {clock}");
        check!(sdram.span_of(next).is_none(), "a second command in clock {clock}");
    }

    /// A request is one job for each row that it meets, in the order of its bytes: the beats of all that it has in
    /// the row. Rows that follow one another lie in different banks.
    #["SD-2", unwind 5, covers ["one row", "two rows", "the last bank"]]
    fn request_is_split_at_its_rows(s) {
        // Kani sees the standard sizes: those of others are divisions by symbols.
        let sizes = |s: &mut S, name, full: std::ops::RangeInclusive<u32>, small| if cfg!(kani) { *full.end() } else { s.value(name, full, small) };
        let beat_bits = sizes(s, "log2 beat", 0..=4, &[2, 4]);
        let row_bits = sizes(s, "log2 row", 4..=12, &[4, 12]);
        let bank_bits = if cfg!(kani) { 2 } else { s.value("log2 banks", 0..=12_u32, &[0, 2, 4]) };
        let config = SdramConfig { beat_bytes: 1 << beat_bits, row_bytes: 1 << row_bits, banks: 1 << bank_bits, ..CHIPS };
        let mut sdram = Sdram::new(config);
        let addr = u64::from(s.value("address", 0..=u32::MAX, &[0, 15, 4095, 0xf000, 0xffff, 0x1_0000]));
        let bytes = u64::from(s.value("bytes", 1..=256_u32, &[1, 2, 36]));
        let transfer = sdram.request(0, addr, bytes, Direction::Write);
        let mut at = addr;
        for place in 0..sdram.jobs.len() {
            let row = at >> row_bits;
            let end = (addr + bytes).min((row + 1) << row_bits);
            let beats = ((end - 1) >> beat_bits) - (at >> beat_bits) + 1;
            let bank = row & ((1 << bank_bits) - 1);
            cover!(s, "the last bank", bank == (1 << bank_bits) - 1);
            let expected = Job::Move { transfer, bank: bank as usize, row: row >> bank_bits, beats, direction: Direction::Write };
            check!(sdram.jobs[place] == expected, "job {place} of {bytes} bytes at {addr}, {config:?}: {:?}", sdram.jobs[place]);
            at = end;
        }
        cover!(s, "one row", sdram.jobs.len() == 1);
        cover!(s, "two rows", sdram.jobs.len() == 2);
        check_eq!(at, addr + bytes, "the end of {bytes} bytes at {addr}, {config:?}");
    }

    /// Refreshes that are due come before the requests of their clock, each once, however long nothing was asked.
    #["SD-5", unwind 6, covers ["none is due", "one", "two", "due in this clock"]]
    fn refreshes_come_when_they_are_due(s) {
        let interval = s.value("interval", 1..=u32::MAX, &[13, 100, 2083, 100_000]);
        // Kani sees a core clock of four times the memory's, as the standard one.
        let cycles_a_clock = if cfg!(kani) { 4 } else { s.value("cycles a clock", 1..=8, &[1, 4]) };
        let mut sdram = Sdram::new(SdramConfig { refresh_interval: interval, cycles_a_clock, ..CHIPS });
        let due = u64::from(s.value("due", 1..=u32::MAX, &[100, 2083, 70_000]));
        let now = u64::from(s.value("cycle", 0..=u32::MAX, &[0, 99, 100, 399, 400, 401, 5000, 283_000]));
        sdram.refresh_due = due;
        let clock = if cfg!(kani) { (now + 3) >> 2 } else { now.div_ceil(cycles_a_clock.into()) };
        assume!(clock < due + 3 * u64::from(interval));
        sdram.begin_cycle(now);
        let count = sdram.jobs.len() as u64;
        cover!(s, "none is due", count == 0);
        cover!(s, "one", count == 1);
        cover!(s, "two", count == 2);
        cover!(s, "due in this clock", clock == due);
        let next = due + count * u64::from(interval);
        check!(clock < next && (count == 0 || next - u64::from(interval) <= clock), "{count} refreshes at clock {clock}, due {due}, every {interval}");
        check!(sdram.refresh_due == next && sdram.jobs.iter().all(|job| *job == Job::Refresh), "next {next}: {sdram:?}");
        sdram.begin_cycle(now);
        check_eq!(sdram.jobs.len() as u64, count, "refreshes at clock {clock}, asked twice");
    }

    /// A refresh waits until the data of all requests before it have moved and each bank may be closed. It closes
    /// all rows, and nothing is opened or commanded before it is over, tRP and tRFC later.
    #["SD-5", unwind 6, covers ["it waits for the bus", "it waits for a bank", "it begins", "it goes on"]]
    fn refresh_comes_between_requests(s) {
        let (precharge, refresh) = (clocks(s, "tRP"), s.value("tRFC", 0..=255, &[0, 1, 9]));
        let config = SdramConfig { precharge, refresh, ..CHIPS };
        let mut sdram = Sdram::new(config);
        let clock = time(s, "clock");
        let mut may_close = 0;
        for bank in 0..2 {
            let open = flag(s, "row open");
            let own = time(s, "may close from");
            may_close = may_close.max(own);
            sdram.banks[bank] = Bank { open: open.then_some(0), opened: Some(0), closed: 0, may_close: own };
        }
        sdram.bus_free = time(s, "the bus is free from");
        sdram.jobs.push_back(Job::Refresh);
        sdram.jobs.push_back(Job::Move { transfer: TransferId(0), bank: 0, row: 1, beats: 1, direction: Direction::Read });
        let before = [sdram.banks[0], sdram.banks[1]];
        sdram.end_cycle(clock);
        let begins = clock >= sdram.bus_free && clock >= may_close;
        cover!(s, "it waits for the bus", clock < sdram.bus_free && clock >= may_close);
        cover!(s, "it waits for a bank", clock >= sdram.bus_free && clock < may_close);
        cover!(s, "it begins", begins);
        check_eq!(sdram.jobs.len(), if begins { 1 } else { 2 }, "jobs after {clock}: {sdram:?}");
        if !begins {
            check!(sdram.banks[0] == before[0] && sdram.banks[1] == before[1], "before the refresh, at {clock}: {sdram:?}");
            return Ok(());
        }
        let over = clock + u64::from(precharge) + u64::from(refresh);
        check!(sdram.banks.iter().all(|bank| bank.open.is_none()), "rows are open in a refresh: {sdram:?}");
        let later = clock + u64::from(s.value("clocks later", 1..=512, &WORDS[1..13]));
        sdram.end_cycle(later);
        let opened = sdram.banks[0].open.is_some();
        cover!(s, "it goes on", later < over);
        check!(opened == (later >= over && later >= u64::from(config.row_cycle)), "at {later}, refreshed from {clock} to {over}: {sdram:?}");
    }

    /// A transfer moves the fewest whole, aligned beats that hold its bytes.
    #["SD-1", unwind 4, covers ["one beat", "a beat more than its bytes need", "aligned"]]
    fn transfer_moves_the_beats_that_hold_its_bytes(s) {
        // Kani sees the standard beat: those of others are divisions by symbols.
        let beat = if cfg!(kani) { BEAT } else { 1 << s.value("log2 beat", 0..=12, &BYTES[..13]) };
        let config = SdramConfig { beat_bytes: beat as u32, ..SdramConfig::STANDARD };
        let addr = u64::from(s.value("address", 0..=u32::MAX, &ENDS));
        let bytes = u64::from(s.value("bytes", 1..=u16::MAX, &[1, 2, 15, 16, 17, 32, 36, 128, u16::MAX]));
        let beats = config.beats(addr, bytes);
        let first = addr & !(beat - 1);
        cover!(s, "one beat", beats == 1);
        cover!(s, "a beat more than its bytes need", (beats - 1) * beat >= bytes);
        cover!(s, "aligned", first == addr && beats * beat == bytes);
        check!(first + beats * beat >= addr + bytes, "{bytes} bytes at {addr}: {beats} beats are too few");
        check!(first + (beats - 1) * beat < addr + bytes, "{bytes} bytes at {addr}: {beats} beats are too many");
        check_eq!(config.moved(addr, bytes), beats * beat, "{bytes} bytes at {addr}: bytes moved");
    }

    /// A triangle is always three beats, and a kd-node or a list entry one, wherever it lies.
    #["SD-1", unwind 4, covers ["a triangle", "a kd-node", "a list entry"]]
    fn items_of_the_scene_are_whole_beats(s) {
        let number = u64::from(s.value("number", 0..=u32::MAX >> 6, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 1000]));
        let item = s.value("item (triangle, kd-node, list entry)", 0..=2, &[0, 1, 2_u8]);
        let (bytes, beats) = [(36, 3), (8, 1), (4, 1)][usize::from(item)];
        cover!(s, "a triangle", item == 0);
        cover!(s, "a kd-node", item == 1);
        cover!(s, "a list entry", item == 2);
        check_eq!(SdramConfig::STANDARD.beats(number * bytes, bytes), beats, "{bytes} bytes at {number} * {bytes}");
    }
}
