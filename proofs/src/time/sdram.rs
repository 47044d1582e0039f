//! Theorems of the memory chips (SD-1 to SD-5): one clock, one request or one refresh from any legal state. What
//! holds after each holds in any run.
//!
//! The state is that of the chips' own registers (which row is open, from when on a bank may be closed or opened,
//! from when on the bus is free). What really happened, and when, is drawn beside it, and the registers have to
//! agree with it before and after.

use crate::draw::{BYTES, ENDS, WORDS, flag};
use crate::source::{Source, Stop};
use crate::{assume, check, check_eq, cover, theorems};
use saarcor_model::time::{Bank, Burst, Command, Direction, Job, Sdram, SdramConfig, Span};

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
    closed: Option<u64>,
    /// The clock after the last beat that was written, and after the last one that was commanded to be read.
    written: Option<u64>,
    read: Option<u64>,
}

/// Whether the registers of a bank agree with what happened: no row is opened too soon (tRP, tRC), used too soon
/// (tRCD), nor closed too soon (tRAS, tWR).
fn agrees(bank: &Bank, history: &History, config: &SdramConfig) -> bool {
    let since = |event: Option<u64>, clocks: u32| event.map_or(0, |clock| clock + u64::from(clocks));
    let History { opened, closed, written, read } = *history;
    let used = since(read, 0).max(since(written, config.write_recovery));
    bank.may_open >= since(opened, config.row_cycle)
        && match bank.open {
            None => bank.may_open >= since(closed, config.precharge) && since(closed, 0) >= used,
            Some(_) => {
                bank.may_move >= since(opened, config.ras_to_cas)
                    && bank.may_close >= used.max(since(opened, config.row_active))
            }
        }
}

/// Any bank, with a history with which it agrees.
fn bank<S: Source>(s: &mut S, config: &SdramConfig) -> Result<(Bank, History), Stop> {
    let (open, row) = (flag(s, "row open"), u64::from(s.value("open row", 0..=7, &WORDS[..2])));
    let (opened_before, closed_before) = (flag(s, "opened before"), flag(s, "closed before"));
    let opened = u64::from(s.value("opened", 0..=1_u32 << 20, &[0, 19]));
    let bank = Bank {
        open: open.then_some(row),
        may_open: time(s, "may open from"),
        may_move: time(s, "may move from"),
        may_close: time(s, "may close from"),
    };
    let history = History {
        opened: opened_before.then_some(opened),
        closed: closed_before.then_some(time(s, "last closing")),
        written: flag(s, "written before").then_some(time(s, "last beat written")),
        read: flag(s, "read before").then_some(time(s, "last beat read")),
    };
    assume!(!open || opened_before);
    assume!(agrees(&bank, &history, config));
    Ok((bank, history))
}

/// Asks for a beat of a row.
fn ask(sdram: &mut Sdram, bank: u64, row: u64, direction: Direction) {
    sdram.request(0, (2 * row + bank) * u64::from(CHIPS.row_bytes), 16, direction);
}

theorems! {
    /// From any state, rows are opened and closed as the data sheet says: a row is closed tRAS after its opening, tWR
    /// after the last beat written to it and after all beats read, opened tRP after the closing and tRC after the
    /// opening before, and gets its commands tRCD after its opening.
    #["SD-3", unwind 6, covers ["a row is closed", "a row is opened", "a read", "a write"]]
    fn rows_are_opened_closed_and_used_in_time(s) {
        let (precharge, row_cycle) = (clocks(s, "tRP"), s.value("tRC", 0..=255, &[0, 9]));
        let (ras_to_cas, write_recovery, row_active) = (clocks(s, "tRCD"), s.value("tWR", 0..=255, &[0, 3]), s.value("tRAS", 0..=255, &[0, 6]));
        let config = SdramConfig { cas: 0, precharge, row_active, row_cycle, ras_to_cas, write_recovery, ..CHIPS };
        let (before, mut history) = bank(s, &config)?;
        let mut sdram = Sdram::new(config);
        let direction = direction(s);
        // Four beats of row 1 of bank 0.
        sdram.request(0, 2 * 4096, 64, direction);
        sdram.banks[0] = before;
        let clock = u64::from(s.value("clock", 0..=1_u32 << 20, &[20, 21, 23]));
        assume!(history.closed.is_none_or(|closed| closed < clock) && history.opened.is_none_or(|opened| opened < clock));
        sdram.end_cycle(clock);
        let after = sdram.banks[0];
        match sdram.commands.first() {
            None => {
                check!(after == before && !sdram.jobs.is_empty(), "without a command at {clock}: {before:?}, {after:?}");
            }
            Some(&(at, Command::Close(0))) => {
                cover!(s, "a row is closed", true);
                let since = |event: Option<u64>, clocks: u32| event.is_none_or(|event| at >= event + u64::from(clocks));
                let in_time = since(history.written, write_recovery) && since(history.read, 0) && since(history.opened, row_active);
                check!(at == clock && in_time && before.open.is_some() && before.open != Some(1), "closed at {clock}: {before:?}, {history:?}, {config:?}");
                check!(after.open.is_none() && !sdram.jobs.is_empty(), "closed at {clock}: {after:?}");
                history.closed = Some(at);
            }
            Some(&(at, Command::Open(0, 1))) => {
                cover!(s, "a row is opened", true);
                let since = |event: Option<u64>, clocks: u32| event.is_none_or(|event| at >= event + u64::from(clocks));
                let in_time = since(history.closed, precharge) && since(history.opened, row_cycle);
                check!(at == clock && in_time && before.open.is_none(), "opened at {clock}: {before:?}, {history:?}, {config:?}");
                check!(after.open == Some(1) && !sdram.jobs.is_empty(), "opened at {clock}: {after:?}");
                history.opened = Some(at);
            }
            Some(&(at, Command::Move(_))) => {
                cover!(s, "a read", direction == Direction::Read);
                cover!(s, "a write", direction == Direction::Write);
                let ready = history.opened.is_some_and(|opened| clock >= opened + u64::from(ras_to_cas));
                check!(at == clock && before.open == Some(1) && ready, "{direction:?} at {clock}: {before:?}, {history:?}, {config:?}");
                check!(after.open == Some(1) && sdram.jobs.is_empty(), "{direction:?} at {clock}: {after:?}");
                match direction {
                    Direction::Read => history.read = history.read.max(Some(clock + 4)),
                    Direction::Write => history.written = history.written.max(Some(clock + 4)),
                }
            }
            other => {
                check!(false, "{other:?} at {clock}: {before:?}");
            }
        }
        check!(agrees(&after, &history, &config), "{after:?} after {clock}, where {history:?}, {config:?}");
        check!(sdram.banks[1] == Bank::default(), "a bank without requests changed: {:?}", sdram.banks[1]);
    }

    /// Two rows of different banks are opened tRRD apart, and in the order of the requests: no row is opened before
    /// that of an earlier request, even if that one has to wait.
    #["SD-3", not_for_kani "two clocks or two requests, with their queue, take it over 2 GB", covers ["the first is opened", "the second waits for its turn", "the second is opened", "the second waits for tRRD"]]
    fn rows_are_opened_in_order_and_apart(s) {
        let config = SdramConfig { row_to_row: clocks(s, "tRRD"), ras_to_cas: 255, row_cycle: 0, ..CHIPS };
        let mut sdram = Sdram::new(config);
        let direction = direction(s);
        ask(&mut sdram, 0, 1, direction);
        ask(&mut sdram, 1, 1, direction);
        let first_waits_until = time(s, "bank 0 may open from");
        sdram.banks[0].may_open = first_waits_until;
        let clock = u64::from(s.value("clock", 0..=1_u32 << 20, &[0, 19, 20]));
        sdram.end_cycle(clock);
        let first = clock >= first_waits_until;
        cover!(s, "the first is opened", first);
        cover!(s, "the second waits for its turn", !first);
        let expected = if first { &[(clock, Command::Open(0, 1))][..] } else { &[] };
        check!(sdram.commands == expected, "at {clock}, bank 0 may open from {first_waits_until}: {:?}", sdram.commands);
        let later = clock + u64::from(s.value("clocks later", 1..=254, &WORDS[1..6]));
        sdram.end_cycle(later);
        if first {
            let apart = later >= clock + u64::from(config.row_to_row);
            cover!(s, "the second is opened", apart);
            cover!(s, "the second waits for tRRD", !apart);
            let second = sdram.commands.get(1).copied();
            check!(second == apart.then_some((later, Command::Open(1, 1))), "opened at {clock}, then at {later} {second:?}, {config:?}");
        }
    }

    /// One command a clock, whatever the state: the earliest request that may have one gets it, and the banks of the
    /// others stay as they are. Data move for the first request alone, and one bank serves its requests in order.
    #["SD-4", not_for_kani "two clocks or two requests, with their queue, take it over 2 GB", covers ["of the first", "of the second", "none", "the second waits for the first", "both in one bank"]]
    fn first_request_that_may_gets_the_command(s) {
        let mut sdram = Sdram::new(SdramConfig { cas: 0, ..CHIPS });
        let direction = direction(s);
        let second = usize::from(flag(s, "bank of the second request (0, 1)"));
        ask(&mut sdram, 0, 1, direction);
        ask(&mut sdram, second as u64, 2, direction);
        let when = |s: &mut S, name| u64::from(s.value(name, 0..=1_u32 << 20, &[19, 21]));
        for (bank, name) in [(0, "row of bank 0"), (1, "row of bank 1")] {
            let row = s.value(name, 0..=3_u8, &[0, 1, 2]);
            sdram.banks[bank] = Bank {
                open: (row > 0).then_some(row.into()),
                may_open: when(s, "may open from"),
                may_move: when(s, "may move from"),
                may_close: when(s, "may close from"),
            };
        }
        let clock = 20;
        let banks = [sdram.banks[0], sdram.banks[1]];
        let wanted = |bank: usize, row: u64| match banks[bank].open {
            Some(open) if open == row => None,
            Some(_) => (clock >= banks[bank].may_close).then_some(Command::Close(bank)),
            None => (clock >= banks[bank].may_open).then_some(Command::Open(bank, row)),
        };
        let moves = banks[0].open == Some(1) && clock >= banks[0].may_move;
        let first = if moves { Some(Command::Move(Burst { bank: 0, row: 1, column: 0, beats: 1, direction })) } else { wanted(0, 1) };
        let of_second = wanted(second, 2);
        let waits = second == 0 || (matches!(of_second, Some(Command::Open(..))) && banks[0].open != Some(1));
        let expected = first.or(if waits { None } else { of_second });
        sdram.end_cycle(clock);
        cover!(s, "of the first", first.is_some());
        cover!(s, "of the second", first.is_none() && expected.is_some());
        cover!(s, "none", expected.is_none());
        cover!(s, "the second waits for the first", first.is_none() && second == 1 && of_second.is_some() && waits);
        cover!(s, "both in one bank", second == 0);
        let given = sdram.commands.first().map(|&(at, command)| (at == clock, command));
        check!(given == expected.map(|command| (true, command)), "{given:?}, expected {expected:?}, of {banks:?}");
        check!(sdram.commands.len() < 2, "two commands in a clock: {:?}", sdram.commands);
        let bank_of = |command| match command { Command::Open(bank, _) | Command::Close(bank) => bank, _ => 0 };
        let changed = expected.map(bank_of);
        check!(changed == Some(0) || sdram.banks[0] == banks[0], "bank 0 changed: {banks:?}, {:?}", sdram.banks);
        check!(changed == Some(1) || sdram.banks[1] == banks[1], "bank 1 changed: {banks:?}, {:?}", sdram.banks);
    }

    /// Data are commanded in the order of the requests. A read's data come CL after its command, a write's
    /// with it, and no beat before the last one of earlier requests: so no two beats share a clock of the bus.
    #["SD-4", unwind 6, covers ["a read", "a write", "the bus is busy", "many beats"]]
    fn data_follow_their_commands_and_do_not_overlap(s) {
        let config = SdramConfig { cas: clocks(s, "CL"), ..CHIPS };
        let mut sdram = Sdram::new(config);
        let beats = u64::from(s.value("beats", 1..=256_u32, &[1, 8, 9, 40, 256]));
        let direction = direction(s);
        let [transfer, next] = [(); 2].map(|()| sdram.request(0, 0, 16, Direction::Read));
        sdram.jobs[0] = Job::Move(transfer, Burst { bank: 0, row: 0, column: 0, beats, direction });
        let clock = u64::from(s.value("clock", 1 << 10..=1_u32 << 20, &[1 << 10, 1025]));
        sdram.banks[0].open = Some(0);
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
        check!(sdram.span_of(next).is_none() && sdram.commands.len() == usize::from(given), "in clock {clock}: {:?}", sdram.commands);
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
            let column = (at & ((1 << row_bits) - 1)) >> beat_bits;
            let burst = Burst { bank: bank as usize, row: row >> bank_bits, column, beats, direction: Direction::Write };
            check!(sdram.jobs[place] == Job::Move(transfer, burst), "job {place} of {bytes} bytes at {addr}, {config:?}: {:?}", sdram.jobs[place]);
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

    /// A refresh waits until the data of all requests before it have moved. If a row is open, it waits until each
    /// bank may be closed, and closes all. It begins tRP later, or else when each bank may be opened.
    #["SD-5", not_for_kani "two clocks or two requests, with their queue, take it over 2 GB", covers ["it waits for the bus", "it waits for a bank", "it closes all rows", "it waits for tRP", "it begins"]]
    fn refresh_closes_all_rows_and_begins(s) {
        let precharge = clocks(s, "tRP");
        let mut sdram = Sdram::new(SdramConfig { precharge, ..CHIPS });
        let clock = time(s, "clock");
        let (mut may_close, mut may_open, mut any_open) = (0, 0, false);
        for bank in 0..2 {
            let open = flag(s, "row open");
            let own = Bank { open: open.then_some(0), may_open: time(s, "may open from"), may_move: 0, may_close: time(s, "may close from") };
            (may_close, may_open, any_open) = (own.may_close.max(may_close), own.may_open.max(may_open), any_open || open);
            sdram.banks[bank] = own;
        }
        sdram.bus_free = time(s, "the bus is free from");
        sdram.jobs.push_back(Job::Refresh);
        ask(&mut sdram, 0, 1, Direction::Read);
        let before = [sdram.banks[0], sdram.banks[1]];
        sdram.end_cycle(clock);
        cover!(s, "it waits for the bus", clock < sdram.bus_free && clock >= may_close);
        cover!(s, "it waits for a bank", any_open && clock >= sdram.bus_free && clock < may_close);
        let moved = clock >= sdram.bus_free;
        let expected = match any_open {
            true => (moved && clock >= may_close).then_some(Command::CloseAll),
            false => (moved && clock >= may_open).then_some(Command::Refresh),
        };
        cover!(s, "it closes all rows", expected == Some(Command::CloseAll));
        cover!(s, "it begins", expected == Some(Command::Refresh));
        let given = sdram.commands.first().map(|&(_, command)| command);
        check!(given == expected, "{given:?} at {clock}, expected {expected:?}: {before:?}");
        check_eq!(sdram.jobs.len(), if expected == Some(Command::Refresh) { 1 } else { 2 }, "jobs after {clock}: {sdram:?}");
        if expected.is_none() {
            check!(sdram.banks[0] == before[0] && sdram.banks[1] == before[1], "before the refresh, at {clock}: {sdram:?}");
        }
        if expected == Some(Command::CloseAll) {
            check!(sdram.banks.iter().all(|bank| bank.open.is_none()), "rows are open: {sdram:?}");
            let later = clock + u64::from(s.value("clocks later", 1..=512, &WORDS[1..5]));
            sdram.end_cycle(later);
            let begins = later >= may_open.max(clock + u64::from(precharge));
            cover!(s, "it waits for tRP", !begins);
            check_eq!(sdram.commands.len(), if begins { 2 } else { 1 }, "commands at {later}, closed at {clock}: {sdram:?}");
        }
    }

    /// After a refresh nothing is opened, nor refreshed again, before it is over, tRFC later.
    #["SD-5", not_for_kani "two clocks or two requests, with their queue, take it over 2 GB", covers ["it goes on", "it is over", "another refresh"]]
    fn refresh_takes_its_time(s) {
        let refresh = s.value("tRFC", 0..=255, &[0, 1, 9]);
        let mut sdram = Sdram::new(SdramConfig { refresh, ..CHIPS });
        let clock = time(s, "clock");
        let again = flag(s, "another refresh is due");
        sdram.jobs.push_back(Job::Refresh);
        if again {
            sdram.jobs.push_back(Job::Refresh);
        } else {
            ask(&mut sdram, 1, 1, Direction::Read);
        }
        sdram.end_cycle(clock);
        check!(sdram.commands == [(clock, Command::Refresh)], "with all rows closed, at {clock}: {sdram:?}");
        let later = clock + u64::from(s.value("clocks later", 1..=512, &WORDS[1..13]));
        sdram.end_cycle(later);
        let over = later >= clock + u64::from(refresh);
        cover!(s, "it goes on", !over);
        cover!(s, "it is over", over && !again);
        cover!(s, "another refresh", over && again);
        let next = if again { Command::Refresh } else { Command::Open(1, 1) };
        let given = sdram.commands.get(1).copied();
        check!(given == over.then_some((later, next)), "{given:?} at {later}, refreshed at {clock}, {refresh} clocks");
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
