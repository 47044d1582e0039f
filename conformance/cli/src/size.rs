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

#[cfg(test)]
mod tests {
    use super::*;

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
