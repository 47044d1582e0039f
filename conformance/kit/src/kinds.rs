//! The kinds that there are.

use crate::chip::Chip;
use crate::hash::SetHash;
use crate::kd::Kd;
use crate::kind::Kind;
use crate::meta::Meta;
use crate::vm::Vm;

/// All kinds, in the order in which their hellos are tried.
pub const KINDS: &[&dyn Kind] = &[&Vm, &SetHash, &Meta, &Kd, &Chip];

/// The kind of a name such as `saarcor-vm`.
#[must_use]
pub fn kind_named(name: &str) -> Option<&'static dyn Kind> {
    KINDS.iter().copied().find(|kind| kind.name() == name)
}

/// The kind of a hello such as `saarcor-vm 1`.
#[must_use]
pub fn kind_of_hello(hello: &[u8]) -> Option<&'static dyn Kind> {
    KINDS.iter().copied().find(|kind| kind.hello().as_bytes() == hello)
}
