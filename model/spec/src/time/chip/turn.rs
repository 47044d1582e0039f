//! Who is next (CH-6).

/// Members of a group that are served in turn (CH-6, Assumed).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Turn {
    /// The member that was served last; none at first.
    pub last: Option<usize>,
}

impl Turn {
    /// Serves one of `asking`, which are in the order of their numbers: the lowest above the one
    /// served last, else the lowest.
    ///
    /// # Panics
    /// If nobody asks.
    pub fn next(&mut self, asking: &[usize]) -> usize {
        let above = asking.iter().find(|&&member| self.last.is_none_or(|last| member > last));
        let next = *above.unwrap_or(&asking[0]);
        self.last = Some(next);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_who_ask_are_served_in_turn() {
        let mut turn = Turn::default();
        let served = [&[1, 3][..], &[1, 3], &[0, 2, 3], &[2], &[0, 1]].map(|asking| turn.next(asking));
        assert_eq!(served, [1, 3, 0, 2, 0]);
    }
}
