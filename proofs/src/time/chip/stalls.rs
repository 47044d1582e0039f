//! Theorems of where the cycles of units go (CH-18).

use super::laws::{Account, held};
use super::scope;
use crate::{cover, theorems};
use saarcor_model::time::Stall;

theorems! {
    /// Each unit is busy, stalled or idle in each cycle, and nothing else: busy while rays go in, else stalled
    /// by the first cause that holds for one of its threads, else idle.
    #["CH-18", not_for_kani "whole runs of a chip", covers ["a look-up", "a port", "a register", "the memory", "the host"]]
    fn units_are_busy_stalled_or_idle(s) {
        let (config, programs) = scope::small(s);
        let report = held(&config, &programs, &mut Account::new(&config))?;
        let stalled = |stall: Stall| report.units.iter().any(|unit| unit.stalls[stall as usize] > 0);
        cover!(s, "a look-up", stalled(Stall::LookUp));
        cover!(s, "a port", stalled(Stall::Port));
        cover!(s, "a register", stalled(Stall::Mshr));
        cover!(s, "the memory", stalled(Stall::Memory));
        cover!(s, "the host", stalled(Stall::Host));
    }
}
