//! A part of some members.

use crate::error::ParseError;
use std::fmt;
use std::str::FromStr;

/// The part of some members that is drawn, above 0 and at most 1: `1/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleFraction {
    numerator: u32,
    denominator: u32,
}

impl SampleFraction {
    /// `1 / denominator`.
    ///
    /// # Panics
    /// If `denominator` is 0.
    #[must_use]
    pub fn one_of(denominator: u32) -> Self {
        assert!(denominator > 0, "no part is divided by 0");
        Self { numerator: 1, denominator }
    }

    /// Whether the member at a place of a list is drawn: members at equal distances are, from the middle of the first.
    #[must_use]
    pub fn draws(self, place: usize) -> bool {
        self.of(place) < self.of(place + 1)
    }

    /// So many of `all`, rounded.
    #[must_use]
    pub fn of(self, all: usize) -> usize {
        let (numerator, denominator) = (u128::from(self.numerator), u128::from(self.denominator));
        ((all as u128 * numerator + denominator / 2) / denominator) as usize
    }
}

impl FromStr for SampleFraction {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
            text.parse().ok().filter(|_| digits)
        };
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        match number(numerator).zip(number(denominator)) {
            Some((numerator, denominator)) if 0 < numerator && numerator <= denominator => {
                Ok(Self { numerator, denominator })
            }
            _ => Err(ParseError::new("write a fraction above 0 and at most 1, such as 1/8")),
        }
    }
}

impl fmt::Display for SampleFraction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => f.write_str("1"),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_read_back_as_they_are_written() {
        for text in ["1/8", "3/4", "1/64", "1"] {
            assert_eq!(text.parse::<SampleFraction>().expect("a part").to_string(), text);
        }
        assert_eq!("1/8".parse(), Ok(SampleFraction::one_of(8)));
    }

    #[test]
    fn lists_are_drawn_from_evenly() {
        let drawn = |text: &str| -> Vec<usize> {
            let part: SampleFraction = text.parse().expect("a part");
            (0..12).filter(|&place| part.draws(place)).collect()
        };
        assert_eq!(drawn("1/4"), [1, 5, 9]);
        assert_eq!(drawn("2/3").len(), 8);
        assert_eq!(drawn("1").len(), 12);
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in
            ["0", "0/4", "2/1", "9/8", "1/0", "x", "", "1/", "/8", "1/8/2", "-1/8", "+1/8", "0.5", "1/ 8"]
        {
            assert!(
                text.parse::<SampleFraction>().is_err_and(|error| error.to_string().contains("1/8")),
                "{text}"
            );
        }
    }
}
