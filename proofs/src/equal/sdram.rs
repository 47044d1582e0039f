//! The twin of the memory chips that knows each transfer's times at once: `saarcor_fast::sdram`.
//!
//! Whole runs of a few transfers, refreshes among them: when each is on the bus, from the first beat to
//! the last, and all commands with their clocks. The specification's chips go clock by clock, and give each command when they may.

use crate::source::Source;
use crate::{check_eq, cover, theorems};
use saarcor_model::time::{Command, Direction, Sdram, SdramConfig, Span};

/// A choice out of the lowest digits of a number.
pub(crate) fn pick<T: Copy>(code: &mut u64, of: &[T]) -> T {
    let count = of.len() as u64;
    let choice = of[(*code % count) as usize];
    *code /= count;
    choice
}

/// The memory chips of a number; those of 0 are tiny, with times that differ and a refresh soon.
pub(crate) fn sdram(code: &mut u64) -> SdramConfig {
    let (refresh_interval, refresh) = pick(code, &[(11, 2), (0, 0), (9, 1), (31, 7), (5, 0)]);
    SdramConfig {
        refresh_interval,
        refresh,
        cycles_a_clock: pick(code, &[2, 1, 4]),
        beat_bytes: pick(code, &[4, 8]),
        banks: pick(code, &[2, 1, 4]),
        row_bytes: pick(code, &[16, 8, 64]),
        cas: pick(code, &[1, 0, 3]),
        ras_to_cas: pick(code, &[2, 0, 3]),
        precharge: pick(code, &[1, 0, 3]),
        row_cycle: pick(code, &[7, 0, 9]),
        write_recovery: pick(code, &[2, 0, 1]),
        row_active: pick(code, &[4, 0, 6]),
        row_to_row: pick(code, &[3, 0, 2]),
    }
}

/// A transfer: in how many cycles it comes, its address, its bytes, its direction.
type Transfer = (u64, u64, u64, Direction);

fn transfer(s: &mut impl Source) -> Transfer {
    let gap = s.value("cycles to the request", 0..=100_u32, &[0, 3, 25]);
    let addr = s.value("address", 0..=300_u32, &[0, 4, 16, 32]);
    let bytes = s.value("bytes", 1..=80_u32, &[4, 20]);
    let direction = s.value("direction (read, write)", 0..=1_u8, &[0, 1]);
    let direction = if direction == 0 { Direction::Read } else { Direction::Write };
    (gap.into(), addr.into(), bytes.into(), direction)
}

/// When the specification's transfers are on the bus, and its commands before the cycle after the last one.
fn run(config: SdramConfig, transfers: &[Transfer]) -> (Vec<Option<Span>>, Vec<(u64, Command)>, u64) {
    let mut sdram = Sdram::new(config);
    let (mut now, mut numbers) = (0, Vec::new());
    let cycle = |sdram: &mut Sdram, now: &mut u64| {
        sdram.end_cycle(*now);
        *now += 1;
        sdram.begin_cycle(*now);
    };
    sdram.begin_cycle(0);
    for &(gap, addr, bytes, direction) in transfers {
        for _ in 0..gap {
            cycle(&mut sdram, &mut now);
        }
        numbers.push(sdram.request(now, addr, bytes, direction));
    }
    let last = now + 4000;
    while now < last && numbers.iter().any(|&number| sdram.span_of(number).is_none()) {
        cycle(&mut sdram, &mut now);
    }
    (numbers.iter().map(|&number| sdram.span_of(number)).collect(), sdram.commands, now)
}

theorems! {
    /// The memory chips that know each transfer's times at once are those that go clock by clock: they give the same
    /// commands in the same clocks.
    #["SD-4", not_for_kani "the specification goes clock by clock, over queues", covers ["a transfer over two rows", "a refresh between transfers", "a write before a read"]]
    fn fast_memory_takes_the_same_time(s) {
        let mut code = s.value("memory chips", 0..=u64::MAX, &[0, 1, 2]);
        let config = sdram(&mut code);
        let transfers = [transfer(s), transfer(s), transfer(s)];
        let mut fast = saarcor_fast::sdram::Sdram::new(config);
        let (mut now, mut expected, mut commands) = (0, Vec::new(), Vec::new());
        for (gap, addr, bytes, direction) in transfers {
            now += gap;
            commands.extend(std::iter::from_fn(|| fast.take_command(now)));
            expected.push(Some(fast.transfer(now, addr, bytes, direction)));
        }
        let row = u64::from(config.row_bytes);
        let over_two = |&(_, addr, bytes, _): &Transfer| addr / row != (addr + bytes - 1) / row;
        cover!(s, "a transfer over two rows", transfers.iter().any(over_two));
        let clock = now / u64::from(config.cycles_a_clock);
        let interval = u64::from(config.refresh_interval);
        cover!(s, "a refresh between transfers", interval != 0 && clock > interval);
        cover!(s, "a write before a read", transfers[0].3 == Direction::Write && transfers[1].3 == Direction::Read);
        let (spans, given, end) = run(config, &transfers);
        check_eq!(expected, spans, "{transfers:?} of {config:?}");
        fast.refresh_until(end);
        commands.extend(std::iter::from_fn(|| fast.take_command(end)));
        check_eq!(commands, given, "commands before cycle {end}, of {transfers:?} of {config:?}");
    }
}
