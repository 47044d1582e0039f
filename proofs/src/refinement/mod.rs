//! From one step to any run: every cache, specified or fast, in version A or B, is an abstract machine.
//!
//! `ARGUMENT.md` beside this crate says what follows from what, and what all of it rests on; `COMPOSITION.md`
//! has the theorems by the operations that they speak of.
//!
//! * [`machine`]: machines, simulations, the induction and the composition, written once.
//! * [`directory`]: the directory of any version is at each of its sets one set of version A ([`directory::OneSet`]).
//! * [`memory`]: the virtual memory is flat memory, and its lines lie where an access found or loaded them
//!   ([`memory::Card`]).
//! * [`first_level`]: so are the first-level caches in front of it ([`memory::Flat`]).
//! * [`twins`]: the twins do what the specification does.
//! * [`table`]: which theorem speaks of which operation.

pub mod directory;
pub mod draw;
pub mod first_level;
pub mod machine;
pub mod memory;
#[cfg(not(kani))]
pub mod table;
pub mod twins;
