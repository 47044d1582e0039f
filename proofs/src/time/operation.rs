//! Theorems of the programs that a functional run leaves (CH-1).

use crate::draw::{BYTES, WORDS};
use crate::vm::memory::unit;
use crate::{check, check_eq, cover, theorems};
use saarcor_model::time::{Operation, Recorder};
use saarcor_model::vm::{HostAddr, Observer, Unit};

/// Steps of a unit: operations begin, and bytes are read.
const STEPS: usize = 3;

theorems! {
    /// The program of a packet has each operation and each read of the run once, in order: a read that
    /// is the first after an operation began has that operation's rays, and the others have none.
    #["CH-1", not_for_kani "it allocates in a loop", covers ["a read of an operation", "a read without rays", "an operation without a read"]]
    fn program_has_each_operation_and_read_once(s) {
        let mut recorder = Recorder::default();
        let mut expected = [Operation { addr: HostAddr(0), bytes: 0, rays: 0, unit: Unit::List }; STEPS];
        let (mut len, mut begun) = (0, false);
        for _ in 0..STEPS {
            let unit = unit(s);
            let number = s.value("address or rays", 0..=u8::MAX, &BYTES[1..3]);
            if s.value("step (operation, read)", 0..=1, &BYTES[..2]) == 0 {
                recorder.operation(unit, number.into());
                cover!(s, "an operation without a read", begun);
                expected[len] = Operation { addr: HostAddr(0), bytes: 0, rays: number, unit };
                (len, begun) = (len + 1, true);
            } else {
                recorder.read(unit, HostAddr(number.into()), 4);
                cover!(s, "a read of an operation", begun);
                cover!(s, "a read without rays", !begun);
                // The operation that began is this read.
                let rays = if begun { expected[len - 1].rays } else { 0 };
                len -= usize::from(begun);
                expected[len] = Operation { addr: HostAddr(number.into()), bytes: 4, rays, unit };
                (len, begun) = (len + 1, false);
            }
        }
        let program = recorder.take();
        check_eq!(program.len(), len, "operations of {program:?}, expected {expected:?}");
        for i in 0..STEPS {
            check!(i >= len || program[i] == expected[i], "operation {i} of {program:?}: expected {:?}", expected[i]);
        }
        check!(recorder.take().is_empty(), "left behind after {program:?}");
    }

    /// The lines of a first-level cache begin at address 0, those of triangles at the first triangle.
    #["L1-1", unwind 5, covers ["triangles", "kd-nodes"]]
    fn lines_of_triangles_begin_at_the_first(s) {
        let triangles = s.value("first triangle", 0..=u32::MAX, &WORDS[..4]);
        let unit = unit(s);
        let programs = saarcor_model::time::Programs { packets: Vec::new(), triangles: HostAddr(triangles) };
        cover!(s, "triangles", unit == Unit::Intersection);
        cover!(s, "kd-nodes", unit == Unit::Traversal);
        let expected = if unit == Unit::Intersection { triangles } else { 0 };
        check_eq!(programs.first_level_base(unit).0, expected, "{unit:?}, triangles from {triangles} on");
    }
}
