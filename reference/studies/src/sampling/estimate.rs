//! An estimate and its interval.

/// An estimate, and its interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value to go by.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Estimate {
    /// What is known and not estimated.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self { value, low: value, high: value }
    }

    /// Whether the interval holds a value.
    #[must_use]
    pub fn holds(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Whether it is worth a number: its interval is at most half as wide as its value.
    #[must_use]
    pub fn is_known(self) -> bool {
        self.high - self.low <= self.value / 2.0
    }

    /// Half the interval's width, relative to the value.
    #[must_use]
    pub fn half_width(self) -> f64 {
        if self.high > self.low { (self.high - self.low) / (2.0 * self.value) } else { 0.0 }
    }

    /// A number divided by this one.
    #[must_use]
    pub fn dividing(self, number: f64) -> Self {
        let of = |value: f64| number / value.max(1.0);
        Self { value: of(self.value), low: of(self.high), high: of(self.low) }
    }
}

/// The 97.5 % quantile of the normal distribution.
const NORMAL_975: f64 = 1.959_964;

/// The 97.5 % quantile of Student's distribution: the first ten from a table, above by Fisher's
/// expansion about the normal distribution's (Abramowitz and Stegun 1964, 26.7.5), to 0.001.
#[must_use]
pub fn student_975(degrees: usize) -> f64 {
    const TABLE: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    match degrees {
        0 => f64::INFINITY,
        1..=10 => TABLE[degrees - 1],
        _ => {
            let (z, n) = (NORMAL_975, degrees as f64);
            z + (z.powi(3) + z) / (4.0 * n)
                + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n.powi(2))
                + (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / (384.0 * n.powi(3))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (degrees, quantile) in
            [(1, 12.706), (4, 2.776), (10, 2.228), (11, 2.201), (30, 2.042), (1000, 1.962)]
        {
            assert!((student_975(degrees) - quantile).abs() < 1e-3, "{degrees}");
        }
    }

    #[test]
    fn what_is_wider_than_half_its_value_is_not_known() {
        let wide = |low, high| Estimate { value: 10.0, low, high };
        assert!(wide(8.0, 13.0).is_known() && !wide(8.0, 13.1).is_known());
        assert!(
            Estimate::exact(0.0).is_known() && !Estimate { high: 1.0, ..Estimate::exact(0.0) }.is_known()
        );
        let seconds = wide(8.0, 16.0).dividing(160.0);
        assert_eq!(seconds, Estimate { value: 16.0, low: 10.0, high: 20.0 });
    }
}
