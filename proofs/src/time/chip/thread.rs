//! Theorems of threads (CH-7).

use super::laws::{Threads, held};
use super::scope;
use crate::{cover, theorems};

theorems! {
    /// No request is lost, and each is answered once: a thread asks for the lines of an operation one after
    /// another, each after the answer to the one before, and each operation is done once.
    #["CH-7", not_for_kani "whole runs of a chip", covers ["a hit", "a miss", "an operation of several lines", "an operation without rays"]]
    fn each_look_up_is_answered_once(s) {
        let (config, programs) = scope::small(s);
        let report = held(&config, &programs, &mut Threads::new(&config, &programs))?;
        let accesses: u64 = report.l1.iter().map(|l1| l1.accesses).sum();
        cover!(s, "a hit", report.l1.iter().any(|l1| l1.hits() > 0));
        cover!(s, "a miss", report.l1.iter().any(|l1| l1.misses > 0));
        cover!(s, "an operation of several lines", accesses > programs.in_order().count() as u64);
        cover!(s, "an operation without rays", programs.in_order().any(|operation| operation.rays == 0));
    }
}
