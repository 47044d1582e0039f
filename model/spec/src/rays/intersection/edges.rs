//! Whose an edge or a vertex is that several triangles have (IS-6): the signs of weights that are 0, of a ray that
//! is moved by (ε, ε², ε³).

use super::number::{Number, Triple, cross};
use std::cmp::Ordering;
use std::ops::{Mul, Sub};

/// How the weights of three corners grow for a unit along each axis, times their sum, by the edges opposite
/// to them: from the second to the third, from the third to the first, from the first to the second.
pub(super) fn slopes<R: Copy + Sub<Output = R> + Mul<Output = R>>(
    direction: Triple<R>,
    edges: [Triple<R>; 3],
) -> [Triple<R>; 3] {
    edges.map(|edge| cross(direction, edge))
}

/// The sign of what grows from 0 by `slopes` along the three axes, if it is moved by (ε, ε², ε³).
pub(super) fn moved<R: Number>(slopes: Triple<R>) -> i8 {
    first_sign(slopes.map(|slope| slope.partial_cmp(&R::ZERO).unwrap_or(Ordering::Equal)))
}

/// -1, 0 or 1 for the first of `signs` that is not `Equal`.
pub(super) fn first_sign(signs: [Ordering; 3]) -> i8 {
    signs.into_iter().find(|sign| sign.is_ne()).unwrap_or(Ordering::Equal) as i8
}
