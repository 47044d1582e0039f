//! The worked tables of SPEC.md say what the specification does.

use saarcor_model::rays::{is_downwards, reciprocal, visit, widen};
use saarcor_model::time::{Burst, Command, Direction, Sdram, SdramConfig};
use saarcor_model::vm::{LineAddr, Policy, Set};
use std::fmt::Write as _;

/// Compares the table of SPEC.md behind `<!-- NAME -->` with these rows.
fn is_the_table(name: &str, rows: &str) {
    let spec = include_str!("../../SPEC.md");
    let (_, table) = spec.split_once(&format!("<!-- {name} -->\n")).expect("its begin");
    let (table, _) = table.split_once(&format!("<!-- end of {name} -->")).expect("its end");
    assert_eq!(table, rows, "SPEC.md, {name}");
}

#[test]
fn bytes_of_a_set() {
    let mut rows = String::from(
        "| policy | accesses | management bits, way by way | bytes, way by way |\n|---|---|---|---|\n",
    );
    let cases: [(&str, Policy, &[u32]); 4] = [
        ("LRU, FIFO", Policy::Lru, &[]),
        ("LRU", Policy::Lru, &[0x81, 0x1000, 0x81]),
        ("FIFO", Policy::Fifo, &[0x81, 0x1000, 0x81]),
        ("PLRU", Policy::Plru, &[0x81, 0x1000, 0x81]),
    ];
    for (name, policy, lines) in cases {
        let mut set = Set::<4>::empty(policy);
        let mut accesses = Vec::new();
        for &line in lines {
            set = set.access(LineAddr(line), policy).0;
            accesses.push(format!("{line:x}"));
        }
        let accesses = if accesses.is_empty() { "none".to_owned() } else { accesses.join(", ") };
        let order = set.order.map(|bits| bits.to_string()).join(", ");
        let bytes =
            set.to_entries().map(|bytes| bytes.map(|byte| format!("{byte:02x}")).join(" ")).join(" · ");
        let _ = writeln!(rows, "| {name} | {accesses} | {order} | `{bytes}` |");
    }
    is_the_table("bytes of a set", &rows);
}

#[test]
fn parts_of_a_ray() {
    let mut rows = String::from(
        "| direction | plane − origin | end of the interval | distance | below the plane | above it |\n|---|---|---|---|---|---|\n",
    );
    let cases = [
        (0.5, 1.0, 8.0),
        (-0.5, -1.0, 8.0),
        (0.5, 8.0, 8.0),
        (0.0, 1.0, 8.0),
        (0.0, -1.0, 8.0),
        (-0.0, 1.0, 8.0),
        (0.0, 0.0, 8.0),
        (0.0, 1.0, f32::INFINITY),
        (0.0, -1.0, f32::INFINITY),
        (-0.0, 1.0, f32::INFINITY),
        (-0.0, -1.0, f32::INFINITY),
        (f32::from_bits(1 << 19), 1.0, 8.0),
    ];
    let number = |number: f32| match number {
        f32::INFINITY => "∞".to_owned(),
        f32::NEG_INFINITY => "−∞".to_owned(),
        number if number.is_nan() => "none".to_owned(),
        number if number != 0.0 && number.abs() < 1e-30 => format!("2^{}", number.log2()),
        number => {
            // Bounds are widened in the seventh digit.
            let rounded = (f64::from(number) * 1e4).round() / 1e4;
            if rounded == 0.0 && number.is_sign_negative() {
                "−0".to_owned()
            } else {
                rounded.to_string().replace('-', "−")
            }
        }
    };
    for (direction, difference, leave) in cases {
        let reciprocal = reciprocal(direction, 16.0);
        let distance = difference * reciprocal;
        let parts = visit(0.0, leave, widen(distance), is_downwards(reciprocal));
        let [below, above] = parts.map(|(enter, leave)| match enter <= leave {
            true => format!("{} to {}", number(enter), number(leave)),
            false => "not visited".to_owned(),
        });
        let [direction, difference, leave, distance] = [direction, difference, leave, distance].map(number);
        let _ = writeln!(rows, "| {direction} | {difference} | {leave} | {distance} | {below} | {above} |");
    }
    is_the_table("parts of a ray", &rows);
}

#[test]
fn commands_of_the_memory() {
    let mut rows = String::from(
        "| clock | command | bank | row | column | beats | data in clocks |\n|---|---|---|---|---|---|---|\n",
    );
    let mut sdram = Sdram::new(SdramConfig { refresh_interval: 40, ..SdramConfig::STANDARD });
    let requests = [
        (1, 0, 36, Direction::Read),
        (1, 4 << 10, 8, Direction::Read),
        (1, 16 << 10, 8, Direction::Read),
        (1, (12 << 10) - 64, 128, Direction::Write),
        (157, 0, 8, Direction::Read),
        (221, 0, 16, Direction::Write),
        (221, 16 << 10, 8, Direction::Read),
        (221, 4 << 10, 8, Direction::Read),
    ];
    for now in 0..=125 * 4 {
        sdram.begin_cycle(now);
        for (_, addr, bytes, direction) in requests.iter().filter(|request| request.0 == now) {
            sdram.request(now, *addr, *bytes, *direction);
        }
        sdram.end_cycle(now);
    }
    for (clock, command) in sdram.commands {
        let row = match command {
            Command::Open(bank, row) => format!("ACT | {bank} | {row} | | |"),
            Command::Close(bank) => format!("PRE | {bank} | | | |"),
            Command::CloseAll => "PRE | all | | | |".to_owned(),
            Command::Refresh => "REF | all | | | |".to_owned(),
            Command::Move(Burst { bank, row, column, beats, direction }) => {
                let (name, latency) = match direction {
                    Direction::Read => ("RD", u64::from(SdramConfig::STANDARD.cas)),
                    Direction::Write => ("WR", 0),
                };
                let data = match (clock + latency, clock + latency + beats - 1) {
                    (first, last) if first == last => first.to_string(),
                    (first, last) => format!("{first} to {last}"),
                };
                format!("{name} | {bank} | {row} | {column} | {beats} | {data}")
            }
        };
        let _ = writeln!(rows, "| {clock} | {row} |");
    }
    is_the_table("commands of the memory", &rows);
}
