//! The judge of SDRAM commands: each rule at its limit, malformed files, and random schedules.

use proptest::prelude::*;
use saarcor_oracles::memory_protocol::Direction::{Read, Write};
use saarcor_oracles::memory_protocol::{
    Burst, Checker, Command, HEADER, PC133, Rule, Timing, Violation, commands,
};
use saarcor_random::Random;
use std::collections::BTreeSet;

/// The violations of a schedule: commands as lines of CSV, with blanks between them. The run ends with the
/// last.
fn violations(timing: Timing, schedule: &str) -> Vec<Violation> {
    let file = format!("{HEADER}\n{}", schedule.split_whitespace().collect::<Vec<_>>().join("\n"));
    let (mut checker, mut found, mut last) = (Checker::new(timing), Vec::new(), 0);
    for command in commands(file.as_bytes()) {
        let (clock, command) = command.expect("well formed");
        found.extend(checker.check(clock, command).err());
        last = clock;
    }
    found.extend(checker.finish(last).err());
    found
}

/// The rules that a schedule violates.
fn rules(timing: Timing, schedule: &str) -> Vec<Rule> {
    violations(timing, schedule).iter().map(|violation| violation.rule).collect()
}

/// The first schedule is legal, the second violates the rule, and no other.
fn limit(timing: Timing, rule: Rule, legal: &str, illegal: &str) -> Violation {
    assert_eq!(violations(timing, legal), [], "{legal}");
    assert_eq!(rules(timing, illegal), [rule], "{illegal}");
    violations(timing, illegal)[0]
}

/// [`limit`] of PC133.
fn pc133(rule: Rule, legal: &str, illegal: &str) -> Violation {
    limit(PC133, rule, legal, illegal)
}

/// What of a violation is not the command's.
fn says(violation: Violation) -> String {
    violation.to_string().rsplit(": ").next().unwrap_or_default().to_owned()
}

#[test]
fn clocks_increase() {
    let found = pc133(Rule::Clock, "5,PRE,0,,, 6,PRE,1,,,", "5,PRE,0,,, 5,PRE,1,,,");
    assert_eq!(says(found), "a command comes less than 1 clock after the one in clock 5");
    pc133(Rule::Clock, "5,PRE,0,,, 6,PRE,1,,,", "5,PRE,0,,, 4,PRE,1,,,");
}

#[test]
fn numbers_are_in_range() {
    let found = pc133(Rule::Bank, "0,ACT,3,5,,", "0,ACT,4,5,,");
    assert_eq!(says(found), "there is no bank 4, since there are 4");
    pc133(Rule::Bank, "0,PRE,3,,,", "0,PRE,4,,,");
    pc133(Rule::Bank, "0,ACT,3,5,, 3,RD,3,,0,1", "0,ACT,3,5,, 3,RD,4,,0,1");
    pc133(Rule::Row, "0,ACT,0,4095,,", "0,ACT,0,4096,,");
    pc133(Rule::Column, "0,ACT,0,5,, 3,RD,0,,255,1", "0,ACT,0,5,, 3,RD,0,,256,1");
}

#[test]
fn the_largest_numbers_are_judged_too() {
    let most = u64::MAX;
    let schedule = format!(
        "0,ACT,0,{most},, 3,RD,0,,{most},{most} {most},WR,{most},{most},{most},{most} {most},REF,all,,,"
    );
    assert_eq!(
        rules(PC133, &schedule),
        [Rule::Row, Rule::Column, Rule::Bank, Rule::Clock, Rule::RefreshLate]
    );
    let mut largest = Timing { banks: 4, ..PC133 };
    largest.fields().into_iter().skip(1).for_each(|(_, value)| *value = most);
    assert_eq!(rules(largest, &schedule), [Rule::Row, Rule::Column, Rule::Bank, Rule::Clock]);

    let wide = Timing { columns_a_row: most, t_refi: 0, ..PC133 };
    let schedule = format!("0,ACT,0,5,, {},RD,0,,0,{most} {most},WR,0,,0,{most}", most - 1);
    assert_eq!(rules(wide, &schedule), [Rule::BurstCut]);
    let rare = Timing { t_refi: most, ..PC133 };
    assert_eq!(rules(rare, &format!("{},REF,all,,, {most},REF,all,,,", most - 9)), [Rule::RefreshEarly]);
}

#[test]
fn a_burst_has_beats_and_stays_in_its_row() {
    pc133(Rule::BurstEmpty, "0,ACT,0,5,, 3,RD,0,,4,1", "0,ACT,0,5,, 3,RD,0,,4,0");
    pc133(Rule::BurstEmpty, "0,ACT,0,5,, 3,WR,0,,4,1", "0,ACT,0,5,, 3,WR,0,,4,0");
    let found = pc133(Rule::BurstLeavesRow, "0,ACT,0,5,, 3,RD,0,,254,2", "0,ACT,0,5,, 3,RD,0,,254,3");
    assert_eq!(says(found), "a burst from column 254 on has at most 2 beats");
    pc133(Rule::BurstLeavesRow, "0,ACT,0,5,, 3,WR,0,,0,256", "0,ACT,0,5,, 3,WR,0,,0,257");
}

#[test]
fn commands_find_their_row_open_or_closed() {
    let found = pc133(
        Rule::OpenBank,
        "0,ACT,0,5,, 6,PRE,0,,, 9,ACT,0,6,, 12,RD,0,6,0,1",
        "0,ACT,0,5,, 6,PRE,1,,, 9,ACT,0,6,, 12,RD,0,6,0,1",
    );
    assert_eq!(says(found), "ACT finds its bank open since clock 0");
    pc133(Rule::ClosedBank, "0,ACT,0,5,, 3,RD,0,,0,1", "0,ACT,0,5,, 3,RD,1,,0,1");
    let found =
        pc133(Rule::ClosedBank, "0,ACT,0,5,, 6,PRE,1,,, 9,WR,0,,0,1", "0,ACT,0,5,, 6,PRE,0,,, 9,WR,0,,0,1");
    assert_eq!(says(found), "RD or WR finds its bank closed since clock 6");
    pc133(Rule::ClosedBank, "0,ACT,0,5,, 9,RD,0,,0,1", "0,ACT,0,5,, 6,PRE,all,,, 9,RD,0,,0,1");
    let found = pc133(Rule::OtherRow, "0,ACT,0,5,, 3,RD,0,5,0,1", "0,ACT,0,5,, 3,RD,0,6,0,1");
    assert_eq!(says(found), "RD or WR means another row than 5, which is open");
    pc133(Rule::OtherRow, "0,ACT,0,5,, 3,WR,0,5,0,1", "0,ACT,0,5,, 3,WR,0,4,0,1");
}

#[test]
fn trcd_is_from_act_to_rd_or_wr() {
    let found = pc133(Rule::Trcd, "4,ACT,0,5,, 7,RD,0,,0,1", "4,ACT,0,5,, 6,RD,0,,0,1");
    assert_eq!((found.clock, found.at, found.limit), (6, 4, 3));
    pc133(Rule::Trcd, "4,ACT,0,5,, 7,WR,0,,0,1", "4,ACT,0,5,, 6,WR,0,,0,1");
    pc133(
        Rule::Trcd,
        "0,ACT,0,5,, 4,ACT,1,5,, 6,RD,0,,0,1 7,RD,1,,0,1",
        "0,ACT,0,5,, 4,ACT,1,5,, 6,RD,1,,0,1",
    );
}

#[test]
fn trp_is_from_pre_to_act_or_ref() {
    let found = pc133(Rule::Trp, "0,ACT,0,5,, 7,PRE,0,,, 10,ACT,0,6,,", "0,ACT,0,5,, 7,PRE,0,,, 9,ACT,0,6,,");
    assert_eq!((found.clock, found.at, found.limit), (9, 7, 3));
    pc133(Rule::Trp, "0,ACT,0,5,, 7,PRE,all,,, 10,ACT,0,6,,", "0,ACT,0,5,, 7,PRE,all,,, 9,ACT,0,6,,");
    // Of the bank alone.
    pc133(Rule::Trp, "0,ACT,0,5,, 7,PRE,0,,, 8,ACT,1,6,,", "0,ACT,0,5,, 7,PRE,0,,, 9,ACT,0,6,,");
    // From the last PRE, of an open bank or not.
    pc133(
        Rule::Trp,
        "0,ACT,0,5,, 7,PRE,0,,, 9,PRE,0,,, 12,ACT,0,6,,",
        "0,ACT,0,5,, 7,PRE,0,,, 9,PRE,0,,, 11,ACT,0,6,,",
    );
    // Of all banks to REF.
    pc133(
        Rule::Trp,
        "2070,ACT,0,5,, 2080,PRE,0,,, 2083,REF,all,,,",
        "2070,ACT,0,5,, 2081,PRE,0,,, 2083,REF,all,,,",
    );
    pc133(
        Rule::Trp,
        "2079,PRE,3,,, 2080,PRE,0,,, 2083,REF,all,,,",
        "2079,PRE,3,,, 2081,PRE,0,,, 2083,REF,all,,,",
    );
}

#[test]
fn tras_is_from_act_to_pre() {
    let found = pc133(Rule::Tras, "4,ACT,0,5,, 10,PRE,0,,,", "4,ACT,0,5,, 9,PRE,0,,,");
    assert_eq!((found.clock, found.at, found.limit), (9, 4, 6));
    pc133(Rule::Tras, "0,ACT,0,5,, 4,ACT,1,5,, 10,PRE,all,,,", "0,ACT,0,5,, 4,ACT,1,5,, 9,PRE,all,,,");
    // Of the bank alone, and of an open row.
    pc133(Rule::Tras, "0,ACT,0,5,, 6,PRE,0,,, 7,PRE,0,,, 9,PRE,1,,,", "0,ACT,0,5,, 5,PRE,0,,,");
}

#[test]
fn trc_is_from_act_to_act() {
    let timing = Timing { t_rc: 12, ..PC133 };
    let found = limit(
        timing,
        Rule::Trc,
        "4,ACT,0,5,, 10,PRE,0,,, 16,ACT,0,6,,",
        "4,ACT,0,5,, 10,PRE,0,,, 15,ACT,0,6,,",
    );
    assert_eq!((found.clock, found.at, found.limit), (15, 4, 12));
    limit(timing, Rule::Trc, "4,ACT,0,5,, 10,PRE,0,,, 13,ACT,1,6,,", "4,ACT,0,5,, 10,PRE,0,,, 13,ACT,0,6,,");
}

#[test]
fn trrd_is_from_act_to_act_of_any_bank() {
    let found = pc133(Rule::Trrd, "4,ACT,0,5,, 6,ACT,1,5,,", "4,ACT,0,5,, 5,ACT,1,5,,");
    assert_eq!((found.clock, found.at, found.limit), (5, 4, 2));
}

#[test]
fn twr_is_from_the_clock_after_the_last_written_beat_to_pre() {
    let found = pc133(Rule::Twr, "0,ACT,0,5,, 3,WR,0,,0,4 9,PRE,0,,,", "0,ACT,0,5,, 3,WR,0,,0,4 8,PRE,0,,,");
    assert_eq!((found.clock, found.at, found.limit), (8, 7, 2));
    pc133(Rule::Twr, "0,ACT,0,5,, 3,WR,0,,0,4 9,PRE,all,,,", "0,ACT,0,5,, 3,WR,0,,0,4 8,PRE,all,,,");
    // Of the bank alone, and of the row that is open.
    pc133(
        Rule::Twr,
        "0,ACT,0,5,, 2,ACT,1,5,, 5,WR,1,,0,9 6,PRE,0,,,",
        "0,ACT,0,5,, 2,ACT,1,5,, 5,WR,1,,0,9 15,PRE,1,,,",
    );
}

#[test]
fn pre_cuts_no_read() {
    let found =
        pc133(Rule::ReadCut, "0,ACT,0,5,, 3,RD,0,,0,5 8,PRE,0,,,", "0,ACT,0,5,, 3,RD,0,,0,5 7,PRE,0,,,");
    assert_eq!((found.clock, found.at, found.limit), (7, 3, 5));
    pc133(Rule::ReadCut, "0,ACT,0,5,, 3,RD,0,,0,5 8,PRE,all,,,", "0,ACT,0,5,, 3,RD,0,,0,5 7,PRE,all,,,");
    pc133(
        Rule::ReadCut,
        "0,ACT,0,5,, 2,ACT,1,5,, 5,RD,1,,0,9 6,PRE,0,,,",
        "0,ACT,0,5,, 2,ACT,1,5,, 5,RD,1,,0,9 13,PRE,1,,,",
    );
}

#[test]
fn rd_and_wr_cut_no_burst() {
    let found =
        pc133(Rule::BurstCut, "0,ACT,0,5,, 3,WR,0,,0,2 5,RD,0,,0,1", "0,ACT,0,5,, 3,WR,0,,0,2 4,RD,0,,0,1");
    assert_eq!((found.clock, found.at, found.limit), (4, 3, 2));
    pc133(Rule::BurstCut, "0,ACT,0,5,, 3,RD,0,,0,2 5,WR,0,,0,1", "0,ACT,0,5,, 3,RD,0,,0,2 4,WR,0,,0,1");
    pc133(
        Rule::BurstCut,
        "0,ACT,0,5,, 2,ACT,1,5,, 5,WR,0,,0,2 7,RD,1,,0,1",
        "0,ACT,0,5,, 2,ACT,1,5,, 5,WR,0,,0,2 6,RD,1,,0,1",
    );
    // Chips in which bursts move all their beats cut none.
    let uncut = Timing { burst_cut: 0, ..PC133 };
    assert_eq!(rules(uncut, "0,ACT,0,5,, 3,WR,0,,0,2 4,RD,0,,0,1"), []);
}

#[test]
fn data_share_no_clock() {
    let act = "0,ACT,0,5,, 2,ACT,1,5,,";
    let bus = |legal: &str, illegal: &str| {
        let found = pc133(Rule::DataBus, &format!("{act} {legal}"), &format!("{act} {illegal}"));
        (found.clock, found.at, found.limit)
    };
    assert_eq!(bus("5,RD,0,,0,4 9,RD,1,,0,4", "5,RD,0,,0,4 8,RD,1,,0,4"), (8, 5, 11));
    assert_eq!(bus("5,WR,0,,0,4 9,WR,1,,0,4", "5,WR,0,,0,4 8,WR,1,,0,4"), (8, 5, 8));
    assert_eq!(bus("5,WR,0,,0,8 13,RD,1,,0,4", "5,WR,0,,0,8 9,RD,1,,0,4"), (9, 5, 12));
    assert_eq!(bus("5,RD,0,,0,4 12,WR,1,,0,4", "5,RD,0,,0,4 11,WR,1,,0,4"), (11, 5, 11));
    // A write before the data of a read.
    assert_eq!(bus("5,RD,0,,0,1 6,WR,1,,0,2", "5,RD,0,,0,1 6,WR,1,,0,3"), (6, 5, 8));
    // Of many reads under way, each counts.
    let reads = "5,RD,0,,0,1 6,RD,0,,0,1 7,RD,0,,0,1";
    assert_eq!(bus(&format!("{reads} 11,WR,0,,0,1"), &format!("{reads} 8,WR,0,,0,1")), (8, 5, 8));
    assert_eq!(bus(&format!("{reads} 11,WR,0,,0,1"), &format!("{reads} 9,WR,0,,0,1")), (9, 6, 9));
    assert_eq!(bus(&format!("{reads} 11,WR,0,,0,1"), &format!("{reads} 10,WR,0,,0,1")), (10, 7, 10));
    let reads = (5..13).map(|clock| format!("{clock},RD,0,,0,1 ")).collect::<String>();
    assert_eq!(bus(&format!("{reads} 16,WR,0,,0,1"), &format!("{reads} 13,WR,0,,0,1")), (13, 10, 13));
}

#[test]
fn a_refresh_finds_all_banks_closed() {
    let found = pc133(
        Rule::RefreshOpen,
        "2060,ACT,3,5,, 2070,PRE,3,,, 2083,REF,all,,,",
        "2060,ACT,3,5,, 2070,PRE,1,,, 2083,REF,all,,,",
    );
    assert_eq!(says(found), "REF finds a bank open since clock 2060");
}

#[test]
fn trfc_is_from_ref_to_any_command() {
    let found = pc133(Rule::Trfc, "2083,REF,all,,, 2092,ACT,0,5,,", "2083,REF,all,,, 2091,ACT,0,5,,");
    assert_eq!((found.clock, found.at, found.limit), (2091, 2083, 9));
    pc133(Rule::Trfc, "2083,REF,all,,, 2092,PRE,all,,,", "2083,REF,all,,, 2091,PRE,all,,,");
    let often = Timing { t_refi: 5, ..PC133 };
    limit(often, Rule::Trfc, "6,REF,all,,, 15,REF,all,,,", "6,REF,all,,, 14,REF,all,,,");
}

#[test]
fn refreshes_come_in_their_time() {
    let found = pc133(Rule::RefreshEarly, "2083,REF,all,,,", "2082,REF,all,,,");
    assert_eq!(says(found), "refresh 1 comes before clock 2083");
    let found = pc133(
        Rule::RefreshEarly,
        "4166,REF,all,,, 4175,REF,all,,, 6249,REF,all,,,",
        "4165,REF,all,,, 4174,REF,all,,, 6248,REF,all,,,",
    );
    assert_eq!(says(found), "refresh 3 comes before clock 6249");
    let found = pc133(Rule::RefreshLate, "4166,REF,all,,,", "4167,REF,all,,,");
    assert_eq!(says(found), "refresh 1 is due by clock 4166");
    // At the end of the run.
    let found = pc133(Rule::RefreshLate, "4166,PRE,0,,,", "4167,PRE,0,,,");
    assert_eq!(found.command, None);
    pc133(Rule::RefreshLate, "2083,REF,all,,, 6249,PRE,0,,,", "2083,REF,all,,, 6250,PRE,0,,,");
}

#[test]
fn without_an_interval_no_refresh_is_demanded_or_allowed() {
    let off = Timing { t_refi: 0, ..PC133 };
    limit(off, Rule::RefreshOff, "0,PRE,0,,, 999999,PRE,0,,,", "9,REF,all,,, 999999,PRE,0,,,");
}

#[test]
fn a_violation_is_named_once() {
    // A bank that was closed too early is closed, and its next row has nothing to wait for.
    assert_eq!(rules(PC133, "0,ACT,0,5,, 3,PRE,0,,, 4,PRE,0,,,"), [Rule::Tras]);
    assert_eq!(rules(PC133, "0,ACT,0,5,, 3,WR,0,,0,99 9,PRE,0,,, 12,ACT,0,6,, 18,PRE,0,,,"), [Rule::Twr]);
    assert_eq!(rules(PC133, "0,ACT,0,5,, 3,RD,0,,0,99 9,PRE,0,,, 12,ACT,0,6,, 18,PRE,0,,,"), [Rule::ReadCut]);
}

#[test]
fn data_lie_where_their_commands_say() {
    let burst = |beats| Burst { bank: 0, row: None, column: 0, beats };
    let start = || {
        let mut checker = Checker::new(PC133);
        let commands = [
            (0, Command::Activate { bank: 0, row: 5 }),
            (3, Command::Read(burst(1))),
            (4, Command::Write(burst(2))),
            (7, Command::Read(burst(4))),
        ];
        for (clock, command) in commands {
            assert_eq!(checker.check(clock, command), Ok(()));
        }
        checker
    };
    let rule = |verdict: Result<(), Violation>| verdict.err().map(|violation| violation.rule);

    let mut right = start();
    for (begin, end, direction) in [(4, 6, Write), (6, 7, Read), (10, 14, Read)] {
        assert_eq!(right.data(begin, end, direction), Ok(()));
    }
    assert_eq!(right.finish(14), Ok(()));
    assert_eq!(rule(right.data(14, 15, Read)), Some(Rule::DataUnasked));
    // Reports are optional.
    assert_eq!(start().finish(14), Ok(()));

    let mut late = start();
    let violation = late.data(7, 8, Read).expect_err("a clock late");
    assert_eq!(violation.to_string(), "clock 7: CL: data do not begin 3 clocks after their RD in clock 3");
    assert_eq!(late.data(10, 14, Read), Ok(()));
    assert_eq!(rule(start().data(5, 6, Read)), Some(Rule::Cl));
    assert_eq!(rule(start().data(6, 8, Read)), Some(Rule::DataLength));
    assert_eq!(rule(start().data(5, 7, Write)), Some(Rule::WriteLatency));
    assert_eq!(rule(start().data(4, 5, Write)), Some(Rule::DataLength));

    // Of many that wait the oldest is forgotten.
    let mut many = Checker::new(PC133);
    assert_eq!(many.check(0, Command::Activate { bank: 0, row: 5 }), Ok(()));
    for clock in 3..3 + 65 {
        assert_eq!(many.check(clock, Command::Read(burst(1))), Ok(()));
    }
    let violation = many.data(6, 7, Read).expect_err("forgotten");
    assert_eq!((violation.rule, violation.at), (Rule::Cl, 4));
    assert_eq!(many.data(8, 9, Read), Ok(()));

    // Left out: the next shows it, or the end.
    let mut left_out = start();
    assert_eq!(rule(left_out.data(10, 14, Read)), Some(Rule::Cl));
    assert_eq!(rule(left_out.data(14, 15, Read)), Some(Rule::DataUnasked));
    assert_eq!(rule(left_out.finish(4)), None);
    assert_eq!(rule(left_out.finish(5)), Some(Rule::DataMissing));
}

#[test]
fn malformed_files_are_refused_with_line_and_field() {
    let error = |file: &[u8]| {
        let first = commands(file).find_map(Result::err);
        first.expect("malformed").to_string()
    };
    let line = |line: &str| error(format!("{HEADER}\n0,REF,all,,,\n{line}\n").as_bytes());
    let number = "is not a decimal number below 2^64";
    let empty = "is not empty, as it is for this command";
    assert_eq!(error(b""), format!("line 1: `` is not `{HEADER}`"));
    assert_eq!(error(b"0,REF,all,,,\n"), format!("line 1: `0,REF,all,,,` is not `{HEADER}`"));
    assert_eq!(error(&[0xff]), "line 1: stream did not contain valid UTF-8");
    assert_eq!(line(""), format!("line 3: 1 fields are not the 6 of `{HEADER}`"));
    assert_eq!(line("1,ACT,0,5,,,"), format!("line 3: 7 fields are not the 6 of `{HEADER}`"));
    assert_eq!(line("x,ACT,0,5,,"), format!("line 3, field clock: `x` {number}"));
    assert_eq!(line("+1,ACT,0,5,,"), format!("line 3, field clock: `+1` {number}"));
    assert_eq!(line("-1,ACT,0,5,,"), format!("line 3, field clock: `-1` {number}"));
    assert_eq!(line("18446744073709551616,ACT,0,5,,").split('`').next(), Some("line 3, field clock: "));
    assert_eq!(line("1,act,0,5,,"), "line 3, field command: `act` is not ACT, RD, WR, PRE or REF");
    assert_eq!(line("1,ACT,,5,,"), format!("line 3, field bank: `` {number}"));
    assert_eq!(line("1,ACT,all,5,,"), format!("line 3, field bank: `all` {number}"));
    assert_eq!(line("1,ACT,0,,,"), format!("line 3, field row: `` {number}"));
    assert_eq!(line("1,ACT,0,5,0,"), format!("line 3, field column: `0` {empty}"));
    assert_eq!(line("1,ACT,0,5,,1"), format!("line 3, field beats: `1` {empty}"));
    assert_eq!(line("1,RD,0,x,0,1"), format!("line 3, field row: `x` {number}"));
    assert_eq!(line("1,RD,0,,,1"), format!("line 3, field column: `` {number}"));
    assert_eq!(line("1,WR,0,,0,"), format!("line 3, field beats: `` {number}"));
    assert_eq!(line("1,PRE,,,,"), format!("line 3, field bank: `` {number}"));
    assert_eq!(line("1,PRE,0,5,,"), format!("line 3, field row: `5` {empty}"));
    assert_eq!(line("1,REF,0,,,"), "line 3, field bank: `0` is not `all`");
    assert_eq!(line("1,REF,all,,,1"), format!("line 3, field beats: `1` {empty}"));
}

/// A greedy controller: of some random commands a clock, it gives the first that is legal. It holds of each
/// command from which clock on it may come, where the checker looks back.
struct Controller {
    timing: Timing,
    clock: u64,
    random: Random,
    banks: Vec<Ready>,
    any: u64,
    activate: u64,
    burst: u64,
    taken: BTreeSet<u64>,
    refreshes: u64,
}

/// The clocks from which on a bank takes commands.
#[derive(Clone, Copy, Default)]
struct Ready {
    open_row: Option<u64>,
    activate: u64,
    burst: u64,
    precharge: u64,
}

impl Controller {
    fn new(timing: Timing, seed: u64) -> Self {
        Self {
            timing,
            clock: 0,
            random: Random::new(seed),
            banks: vec![Ready::default(); timing.banks as usize],
            any: 0,
            activate: 0,
            burst: 0,
            taken: BTreeSet::new(),
            refreshes: 0,
        }
    }

    fn candidate(&mut self) -> Command {
        let timing = self.timing;
        let any_open = self.banks.iter().any(|bank| bank.open_row.is_some());
        if self.clock >= (self.refreshes + 1) * timing.t_refi {
            return if any_open { Command::Precharge { bank: None } } else { Command::Refresh };
        }
        let bank = self.random.below(timing.banks);
        let open_row = self.banks[bank as usize].open_row;
        let row = open_row.filter(|_| self.random.percent(50));
        let beats = if self.random.percent(50) { 1 } else { 1 + self.random.below(8) };
        let column = self.random.below(timing.columns_a_row - beats + 1);
        let burst = Burst { bank, row, column, beats };
        match self.random.below(10) {
            0..3 => Command::Activate { bank, row: self.random.below(timing.rows) },
            3..6 => Command::Read(burst),
            6..8 => Command::Write(burst),
            _ => Command::Precharge { bank: Some(bank).filter(|_| self.random.percent(95)) },
        }
    }

    /// Gives the command in this clock, if it is legal.
    fn gives(&mut self, command: Command) -> bool {
        let (timing, clock) = (self.timing, self.clock);
        if clock < self.any {
            return false;
        }
        match command {
            Command::Activate { bank, row } => {
                let ready = &mut self.banks[bank as usize];
                if ready.open_row.is_some() || clock < ready.activate.max(self.activate) {
                    return false;
                }
                ready.open_row = Some(row);
                ready.activate = clock + timing.t_rc;
                ready.burst = clock + timing.t_rcd;
                ready.precharge = clock + timing.t_ras;
                self.activate = clock + timing.t_rrd;
            }
            Command::Read(burst) | Command::Write(burst) => {
                let ready = &mut self.banks[burst.bank as usize];
                let (latency, recovery) = match command {
                    Command::Read(_) => (timing.cl, 0),
                    _ => (0, timing.t_wr),
                };
                let mut data = clock + latency..clock + latency + burst.beats;
                if ready.open_row.is_none()
                    || clock < ready.burst.max(self.burst)
                    || data.clone().any(|beat| self.taken.contains(&beat))
                {
                    return false;
                }
                self.taken = self.taken.split_off(&clock);
                self.taken.extend(&mut data);
                self.burst = clock + burst.beats;
                ready.precharge = ready.precharge.max(clock + burst.beats + recovery);
            }
            Command::Precharge { bank } => {
                let banks = match bank {
                    Some(bank) => &mut self.banks[bank as usize..=bank as usize],
                    None => &mut self.banks[..],
                };
                if banks.iter().any(|ready| ready.open_row.is_some() && clock < ready.precharge) {
                    return false;
                }
                for ready in banks {
                    ready.open_row = None;
                    ready.activate = ready.activate.max(clock + timing.t_rp);
                }
            }
            Command::Refresh => {
                // Each bank could be opened, were it not for tRC.
                let precharged = self.banks.iter().all(|ready| clock >= ready.activate);
                if !precharged {
                    return false;
                }
                self.any = clock + timing.t_rfc;
                self.refreshes += 1;
            }
        }
        true
    }

    /// The command of the next clock, if there is one.
    fn step(&mut self) -> Option<(u64, Command)> {
        let given = (0..3).find_map(|_| {
            let command = self.candidate();
            self.gives(command).then_some((self.clock, command))
        });
        self.clock += 1;
        given
    }
}

/// A memory that refreshes often, where each time can be what a command waits for.
const BUSY: Timing = Timing { rows: 8, columns_a_row: 16, t_rc: 11, t_refi: 150, ..PC133 };

/// The rules that a checker finds violated in a run of a controller.
fn run(controller: Timing, checker: Timing, seed: u64, clocks: u64) -> BTreeSet<Rule> {
    let (mut controller, mut checker) = (Controller::new(controller, seed), Checker::new(checker));
    let mut found = BTreeSet::new();
    while controller.clock < clocks {
        if let Some((clock, command)) = controller.step() {
            let line = format!("{HEADER}\n{clock},{command}\n");
            let read = commands(line.as_bytes()).next().expect("a command").expect("well formed");
            assert_eq!(read, (clock, command));
            found.extend(checker.check(clock, command).err().map(|violation| violation.rule));
            let (latency, burst, direction) = match command {
                Command::Read(burst) => (controller.timing.cl, burst, Read),
                Command::Write(burst) => (0, burst, Write),
                _ => continue,
            };
            let begin = clock + latency;
            let verdict = checker.data(begin, begin + burst.beats, direction);
            found.extend(verdict.err().map(|violation| violation.rule));
        }
    }
    found.extend(checker.finish(clocks).err().map(|violation| violation.rule));
    found
}

fn any_timing() -> impl Strategy<Value = Timing> {
    let times = (1_u64..6, 0_u64..6, 0_u64..6, 0_u64..10, 0_u64..16, 0_u64..6, 0_u64..6, 0_u64..12);
    (1_u64..6, 8_u64..20, times, 100_u64..300).prop_map(
        |(banks, columns_a_row, (cl, t_rcd, t_rp, t_ras, t_rc, t_rrd, t_wr, t_rfc), t_refi)| Timing {
            banks,
            rows: 8,
            columns_a_row,
            cl,
            t_rcd,
            t_rp,
            t_ras,
            t_rc,
            t_rrd,
            t_wr,
            t_rfc,
            t_refi,
            burst_cut: 1,
        },
    )
}

proptest! {
    #[test]
    fn legal_schedules_are_accepted(timing in any_timing(), seed in any::<u64>()) {
        prop_assert_eq!(run(timing, timing, seed, 2000), BTreeSet::new());
    }

    /// The controller of a memory that is faster or larger by one is found, whatever the seed.
    #[test]
    fn a_controller_that_is_off_by_one_is_found(field in 0_usize..12, seed in any::<u64>()) {
        let rules = [
            ("banks", 1, Rule::Bank),
            ("rows", 1, Rule::Row),
            ("columns_a_row", 1, Rule::BurstLeavesRow),
            ("cl", -1, Rule::Cl),
            ("t_rcd", -1, Rule::Trcd),
            ("t_rp", -1, Rule::Trp),
            ("t_ras", -1, Rule::Tras),
            ("t_rc", -1, Rule::Trc),
            ("t_rrd", -1, Rule::Trrd),
            ("t_wr", -1, Rule::Twr),
            ("t_rfc", -1, Rule::Trfc),
            ("t_refi", -1, Rule::RefreshEarly),
        ];
        let (name, by, rule) = rules[field];
        let mut timing = BUSY;
        let (known, value) = &mut timing.fields()[field];
        prop_assert_eq!(*known, name);
        **value = value.saturating_add_signed(by);
        let found = run(timing, BUSY, seed, 5000);
        prop_assert!(found.contains(&rule), "{} shows as {:?}", name, found);
    }
}
