//! Sizes in bytes, as a user writes them.

use saarcor_model::vm::Bytes;
use saarcor_studies::error::ParseError;
use std::fmt;
use std::str::FromStr;

/// A size in bytes: `128`, `64KiB`, `8MiB`, `1GiB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub Bytes);

/// Units of sizes, the largest first, with their binary logarithms.
const UNITS: [(&str, u32); 4] = [("GiB", 30), ("MiB", 20), ("KiB", 10), ("", 0)];

impl FromStr for Size {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let right = "write bytes, KiB, MiB or GiB, such as 128 or 8MiB";
        let (unit, shift) = UNITS.into_iter().find(|(unit, _)| text.ends_with(unit)).unwrap_or_default();
        let digits = &text[..text.len() - unit.len()];
        if digits.is_empty() || !digits.bytes().all(|digit| digit.is_ascii_digit()) {
            return Err(ParseError::new(format!("no size; {right}")));
        }
        let number = digits.parse::<u64>().ok().and_then(|number| number.checked_mul(1 << shift));
        number.map(|bytes| Self(Bytes(bytes))).ok_or(ParseError::new("too large a size"))
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Bytes(bytes) = self.0;
        let fits = |(_, shift): &(&str, u32)| bytes != 0 && bytes % (1 << shift) == 0;
        let (unit, shift) = UNITS.into_iter().find(fits).unwrap_or_default();
        write!(f, "{}{unit}", bytes >> shift)
    }
}

/// Some sizes: `8MiB`, `64,128,256`, or the powers of two from one to another, `1MiB..=64MiB`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sizes(pub Vec<Size>);

impl FromStr for Sizes {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let mut sizes = Vec::new();
        for part in text.split(',') {
            let Some((least, most)) = part.split_once("..=") else {
                sizes.push(part.parse()?);
                continue;
            };
            let (Size(least), Size(most)): (Size, Size) = (least.parse()?, most.parse()?);
            if !(least.0.is_power_of_two() && most.0.is_power_of_two() && least.0 <= most.0) {
                return Err(ParseError::new(
                    "write a range from one power of two to a larger one, such as 1MiB..=64MiB",
                ));
            }
            sizes.extend((least.0.ilog2()..=most.0.ilog2()).map(|log2| Size(Bytes(1 << log2))));
        }
        match (1..sizes.len()).find(|&later| sizes[..later].contains(&sizes[later])) {
            Some(twice) => Err(ParseError::new(format!("{} is there twice", sizes[twice]))),
            None => Ok(Self(sizes)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_sizes_are_listed_or_the_powers_of_two_of_a_range() {
        let sizes = |text: &str| {
            text.parse().map(|Sizes(sizes)| sizes.iter().map(Size::to_string).collect::<Vec<_>>())
        };
        assert_eq!(sizes("8MiB"), Ok(vec!["8MiB".to_owned()]));
        assert_eq!(sizes("64,256").map(|sizes| sizes.join(" ")), Ok("64 256".to_owned()));
        assert_eq!(
            sizes("512KiB..=2MiB,8MiB").map(|sizes| sizes.join(" ")),
            Ok("512KiB 1MiB 2MiB 8MiB".to_owned())
        );
        assert_eq!(sizes("1..=1").map(|sizes| sizes.join(" ")), Ok("1".to_owned()));
        for (text, right) in [
            ("", "8MiB"),
            ("64,", "8MiB"),
            ("1..4", "8MiB"),
            ("..=4", "8MiB"),
            ("4..=1", "1MiB..=64MiB"),
            ("3..=8", "1MiB..=64MiB"),
            ("0..=8", "1MiB..=64MiB"),
            ("64,128,64", "64 is there twice"),
            ("1..=4,2", "2 is there twice"),
        ] {
            assert!(sizes(text).is_err_and(|error| error.to_string().contains(right)), "{text}");
        }
    }

    #[test]
    fn sizes_read_back_as_they_are_written() {
        for (text, bytes) in [("128", 128), ("64KiB", 65_536), ("8MiB", 8 << 20), ("1GiB", 1 << 30), ("0", 0)]
        {
            assert_eq!(text.parse(), Ok(Size(Bytes(bytes))));
            assert_eq!(Size(Bytes(bytes)).to_string(), text);
        }
        assert_eq!("1024KiB".parse(), "1MiB".parse::<Size>());
        assert_eq!(Size(Bytes(1536)).to_string(), "1536");
    }

    #[test]
    fn what_is_no_size_is_refused() {
        for text in ["", "8M", "8MB", "MiB", "-1", "1.5MiB", "+8", " 8", "0x10", "8 MiB", "8mib"] {
            assert!(text.parse::<Size>().is_err_and(|error| error.to_string().contains("8MiB")), "{text}");
        }
        for text in ["18446744073709551616", "99999999999GiB"] {
            assert!(text.parse::<Size>().is_err_and(|error| error.to_string().contains("large")), "{text}");
        }
    }
}
