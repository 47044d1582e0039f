//! Which cases of the chip sessions reach: why units wait, what look-ups find, what moves, and the
//! rows of the memory chips.

use super::config::Setting;
use super::oracle::ChipOracle;
use super::request::Request;
use crate::coverage::{Coverage, CoverageCount};
use crate::kind::Oracle;
use crate::session::Session;
use saarcor_fast::chip::{ChipObserver, Traffic};
use saarcor_model::time::{
    CacheReport, ChipConfig, Direction, Operation, Span, Stall, TimingReport, Version,
};
use std::collections::BTreeSet;

/// What look-ups find: the line, the line in flight, nothing.
const FOUND: usize = 3;
/// What operations read: nothing, a line, several, and a line without rays to work for.
const READ: usize = 4;
/// How the row of a request is found: closed from the begin on, open, another one open, closed by a refresh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum RowState {
    Closed,
    Open,
    Another,
    Refreshed,
}
const ROWS: usize = 4;

/// What was reached: a set of cases for each row of the report.
#[derive(Clone, Debug, Default)]
pub struct ChipCoverage {
    stalls: BTreeSet<(usize, usize)>,
    look_ups: BTreeSet<(usize, usize)>,
    parts: BTreeSet<(usize, usize)>,
    traffic: BTreeSet<(usize, usize)>,
    rows: BTreeSet<(bool, RowState)>,
    in_two_rows: BTreeSet<bool>,
    bus: BTreeSet<bool>,
    operations: BTreeSet<(usize, usize)>,
    lines_in_parts: BTreeSet<bool>,
    pictures: BTreeSet<(usize, bool)>,
}

/// What moves in a run.
struct RunObserver<'a> {
    reached: &'a mut ChipCoverage,
    chip: ChipConfig,
    open: Vec<Option<u64>>,
    /// Banks whose row a refresh has closed.
    refreshed: Vec<bool>,
    next_refresh: u64,
    /// End of the last transfer from the host.
    bus_free: u64,
}

impl RunObserver<'_> {
    fn row(&mut self, row: u64, write: bool) {
        let banks = u64::from(self.chip.sdram.banks);
        let (bank, row) = ((row % banks) as usize, row / banks);
        let found = match self.open[bank].replace(row) {
            Some(open) if open == row => RowState::Open,
            Some(_) => RowState::Another,
            None if std::mem::take(&mut self.refreshed[bank]) => RowState::Refreshed,
            None => RowState::Closed,
        };
        self.reached.rows.insert((write, found));
    }
}

impl ChipObserver for RunObserver<'_> {
    fn transfer(&mut self, _: u32, traffic: Traffic, span: Span, _: u64) {
        self.reached.traffic.insert((self.chip.version as usize, traffic as usize));
        if traffic == Traffic::Pci {
            self.reached.bus.insert(span.begin == self.bus_free);
            self.bus_free = span.end;
        }
    }

    fn request(&mut self, now: u64, card: u64, bytes: u64, direction: Direction) {
        let sdram = self.chip.sdram;
        let write = direction == Direction::Write;
        while sdram.refresh_interval > 0 && self.next_refresh <= now.div_ceil(sdram.cycles_a_clock.into()) {
            self.next_refresh += u64::from(sdram.refresh_interval);
            for (open, refreshed) in self.open.iter_mut().zip(&mut self.refreshed) {
                *refreshed |= open.take().is_some();
            }
        }
        let row_bytes = u64::from(sdram.row_bytes);
        let (first, last) = (card / row_bytes, (card + bytes - 1) / row_bytes);
        (first..=last).for_each(|row| self.row(row, write));
        if first < last {
            self.reached.in_two_rows.insert(write);
        }
    }
}

/// Which kinds of look-ups a cache had.
fn found(cache: &CacheReport) -> impl Iterator<Item = usize> {
    let counts = [cache.hits(), cache.merged, cache.misses];
    (0..FOUND).filter(move |&found| counts[found] > 0)
}

impl ChipCoverage {
    fn operation(&mut self, setting: &Setting, operation: &Operation) {
        let &Operation { addr, bytes, rays, unit } = operation;
        let size = u64::from(setting.chip.l1[unit as usize].line);
        let base = if unit as usize == 3 { u64::from(setting.triangles.0) } else { 0 };
        let lines = match u64::from(bytes) {
            0 => 0,
            bytes => {
                let first = u64::from(addr.0).saturating_sub(base);
                let lines = first / size..=(first + bytes - 1) / size;
                if setting.chip.version != Version::None {
                    let vm_line = setting.chip.cache.geometry.line().0;
                    let begin = base + lines.start() * size;
                    self.lines_in_parts.insert(begin / vm_line != (begin + size - 1) / vm_line);
                }
                1 + usize::from(lines.end() > lines.start())
            }
        };
        let read = if bytes > 0 && rays == 0 { READ - 1 } else { lines };
        self.operations.insert((unit as usize, read));
    }

    fn run(&mut self, model: &ChipOracle, warm: bool) {
        let chip = model.setting.chip;
        let version = chip.version as usize;
        let banks = chip.sdram.banks as usize;
        let mut moves = RunObserver {
            reached: self,
            chip,
            open: vec![None; banks],
            refreshed: vec![false; banks],
            next_refresh: chip.sdram.refresh_interval.into(),
            bus_free: u64::MAX,
        };
        let TimingReport { units, l1, l2, .. } = model.play(&mut moves);
        self.pictures.insert((version, warm));
        for (unit, report) in units.iter().enumerate() {
            let waited = (0..Stall::ALL.len()).filter(|&stall| report.stalls[stall] > 0);
            self.stalls.extend(waited.map(|stall| (unit, stall)));
        }
        for (unit, cache) in l1.iter().enumerate() {
            self.look_ups.extend(found(cache).map(|found| (unit, found)));
        }
        self.parts.extend(found(&l2).map(|found| (version, found)));
    }
}

impl Coverage for ChipCoverage {
    fn add(&mut self, session: &Session) {
        let Ok(mut model) = ChipOracle::new(Oracle::Model, session.config()) else { return };
        let mut warm = false;
        for request in session.requests().filter_map(|request| Request::parse(request).ok()) {
            for operation in request.operations() {
                self.operation(&model.setting, operation);
            }
            match request {
                Request::Run => self.run(&model, warm),
                Request::Before(_) => warm = true,
                Request::Flush => warm = false,
                Request::Packet(_) => {}
            }
            model.change(request);
        }
    }

    fn counts(&self) -> Vec<CoverageCount> {
        let row =
            |what: &str, reached: usize, all: usize| CoverageCount { what: what.to_owned(), reached, all };
        let (units, versions) = (4, 3);
        vec![
            row("units × why they wait", self.stalls.len(), units * Stall::ALL.len()),
            row("units × what their look-ups find", self.look_ups.len(), units * FOUND),
            row("units × what their operations read", self.operations.len(), units * READ),
            // Without virtual memory all is there.
            row("versions × what is found of parts", self.parts.len(), 1 + 2 * FOUND),
            row("first-level lines in one part, in several", self.lines_in_parts.len(), 2),
            // One, three, and with metadata five.
            row("versions × what moves", self.traffic.len(), 1 + 3 + 5),
            row("reads and writes × how their row is found", self.rows.len(), 2 * ROWS),
            row("reads and writes over two rows", self.in_two_rows.len(), 2),
            row("transfers of a free bus, of one that is taken", self.bus.len(), 2),
            row("versions × caches cold and warm", self.pictures.len(), versions * 2),
        ]
    }
}
