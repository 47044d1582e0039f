//! When conversations are stopped, so that a verdict comes in time.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A moment at which conversations are stopped, whatever is left of their own time limits. Any thread may bring
/// it nearer.
#[derive(Debug)]
pub struct Deadline {
    made: Instant,
    /// Nanoseconds from `made` on; the greatest stands for never.
    after: AtomicU64,
}

impl Deadline {
    /// A moment that does not come until it is brought nearer.
    #[must_use]
    pub fn never() -> Self {
        Self { made: Instant::now(), after: AtomicU64::new(u64::MAX) }
    }

    /// Brings the moment nearer: in `time` from now on, where that is earlier.
    pub fn within(&self, time: Duration) {
        let after = self.made.elapsed().saturating_add(time).as_nanos();
        self.after.fetch_min(u64::try_from(after).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    /// The time that is left.
    #[must_use]
    pub fn left(&self) -> Duration {
        match self.after.load(Ordering::Relaxed) {
            u64::MAX => Duration::MAX,
            after => Duration::from_nanos(after).saturating_sub(self.made.elapsed()),
        }
    }

    /// Whether no time is left.
    #[must_use]
    pub fn has_come(&self) -> bool {
        self.left().is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_moment_counts() {
        let deadline = Deadline::never();
        assert_eq!(deadline.left(), Duration::MAX);
        deadline.within(Duration::from_secs(1000));
        deadline.within(Duration::from_secs(2000));
        assert!(!deadline.has_come() && deadline.left() <= Duration::from_secs(1000));
        deadline.within(Duration::ZERO);
        assert!(deadline.has_come());
    }
}
