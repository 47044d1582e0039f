//! How a command ends.

/// How a command ends that had no wrong input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// What was asked for holds, or is done.
    Holds = 0,
    /// It does not hold.
    Disproved = 1,
    /// Not all of it could be decided.
    Incomplete = 3,
}
