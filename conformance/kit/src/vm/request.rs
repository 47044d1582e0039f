//! Requests and answers of `saarcor-vm`.

use crate::error::Error;
use crate::hex;
use crate::words::{Words, list_of_names, observed_names};
use std::fmt;

/// One past the last host address.
pub const END_OF_ADDRESSES: u64 = 1 << 32;

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request<'a> {
    /// The host writes the bytes of these hex digits.
    Write {
        /// Address of the first byte.
        host: u32,
        /// Two hex digits a byte.
        digits: &'a [u8],
    },
    /// The chip reads within one line.
    Read {
        /// Address of the first byte.
        host: u32,
        /// Number of bytes.
        len: u32,
    },
    /// Every line that the range meets is invalidated.
    Invalidate {
        /// Address of the first byte.
        host: u32,
        /// Number of bytes.
        len: u64,
    },
    /// All lines are invalidated.
    Flush,
}

impl<'a> Request<'a> {
    /// The request of a line of text.
    ///
    /// # Errors
    /// What would be right.
    #[inline]
    pub fn parse(line: &'a [u8]) -> Result<Self, Error> {
        let mut words = Words::of(line);
        let request = match words.word() {
            b"r" => {
                let right = "write 'r HOST LEN' in hex";
                let (host, len) = (words.address().ok_or(right)?, words.address().ok_or(right)?);
                Self::Read { host, len }
            }
            b"w" => {
                let host = words.address().ok_or("write 'w HOST HEXBYTES' in hex")?;
                let digits = words.word();
                let whole = digits.len().is_multiple_of(2) && !digits.is_empty();
                if !whole || !digits.iter().all(u8::is_ascii_hexdigit) {
                    return Err("write two hex digits a byte".into());
                }
                if u64::from(host) + digits.len() as u64 / 2 > END_OF_ADDRESSES {
                    return Err("a write ends at 100000000 at last".into());
                }
                Self::Write { host, digits }
            }
            b"i" => {
                let right = "write 'i HOST LEN' in hex";
                let (host, len) = (words.address().ok_or(right)?, words.number().ok_or(right)?);
                if len == 0 {
                    return Err("a range has at least one byte".into());
                }
                if u64::from(host).saturating_add(len) > END_OF_ADDRESSES {
                    return Err("a range ends at 100000000 at last".into());
                }
                Self::Invalidate { host, len }
            }
            b"flush" => Self::Flush,
            _ => return Err("the requests are r, w, i, flush, end".into()),
        };
        words.end()?;
        Ok(request)
    }

    /// Whether the request is legal with lines of so many bytes: a read lies within one line.
    #[must_use]
    pub fn fits(&self, line: u64) -> bool {
        match *self {
            Self::Read { host, len } => len > 0 && u64::from(host) % line + u64::from(len) <= line,
            _ => true,
        }
    }
}

impl fmt::Display for Request<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Write { host, digits } => write!(f, "w {host:x} {}", String::from_utf8_lossy(digits)),
            Self::Read { host, len } => write!(f, "r {host:x} {len:x}"),
            Self::Invalidate { host, len } => write!(f, "i {host:x} {len:x}"),
            Self::Flush => f.write_str("flush"),
        }
    }
}

/// What an implementation observes of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observes {
    /// The bytes.
    pub data: bool,
    /// Whether it hits.
    pub hit: bool,
    /// Where on the card the bytes lie.
    pub card: bool,
    /// Which line is evicted.
    pub evict: bool,
}

impl Observes {
    /// All.
    pub const ALL: Self = Self { data: true, hit: true, card: true, evict: true };

    /// What the list after `observes=` names.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(list: &str) -> Result<Self, Error> {
        let [data, hit, card, evict] = observed_names(Self::NAMES, list)?;
        Ok(Self { data, hit, card, evict })
    }

    const NAMES: [&str; 4] = ["data", "hit", "card", "evict"];
}

impl fmt::Display for Observes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { data, hit, card, evict } = *self;
        f.write_str(&list_of_names(Self::NAMES, [data, hit, card, evict]))
    }
}

/// The answer to a read, as far as it is observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadAnswer<'a> {
    /// Whether it hits.
    pub hit: Option<bool>,
    /// Where on the card the bytes lie.
    pub card: Option<u64>,
    /// Host address of the line that is evicted; none if nothing is, or it is not observed.
    pub evicted: Option<u64>,
    /// Two hex digits a byte.
    pub data: Option<&'a [u8]>,
}

impl<'a> ReadAnswer<'a> {
    /// The answer of a line of text to a read of `len` bytes.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(line: &'a [u8], len: u32, observes: Observes) -> Result<Self, Error> {
        let mut words = line.split(|&byte| byte == b' ').filter(|word| !word.is_empty());
        let mut word = || words.next().unwrap_or_default();
        let form = "'h CARD DATA' or 'm CARD EVICTED DATA' is right, with '-' for what is not observed";
        let letter = word();
        let (first, second, third) = (word(), word(), word());
        let (card, evicted, data) = match (letter, third.is_empty()) {
            (b"h", true) => (first, &b"-"[..], second),
            (b"m", false) => (first, second, third),
            (b"-", true) if !observes.hit => (first, &b"-"[..], second),
            (b"-", false) if !observes.hit => (first, second, third),
            _ => return Err(form.into()),
        };
        if words.next().is_some() || data.is_empty() {
            return Err(form.into());
        }
        let address = |word: &[u8]| match word {
            b"-" => Ok(None),
            _ => hex::number(word).map(Some).ok_or("an address is a hex number or '-'"),
        };
        let (card, evicted) = (address(card)?, address(evicted)?);
        let observed = |seen: bool, answer: Option<u64>| if seen { answer } else { None };
        if observes.card && card.is_none() {
            return Err("CARD is '-', though it is observed".into());
        }
        let data = match data {
            b"-" if observes.data => return Err("DATA is '-', though it is observed".into()),
            b"-" => None,
            digits if digits.len() as u64 != 2 * u64::from(len) => {
                return Err(format!(
                    "DATA has {} digits; {len} bytes have {}",
                    digits.len(),
                    2 * u64::from(len)
                )
                .into());
            }
            digits if !digits.iter().all(u8::is_ascii_hexdigit) => {
                return Err("DATA is not hex".into());
            }
            digits => observes.data.then_some(digits),
        };
        Ok(Self {
            hit: observes.hit.then_some(letter == b"h"),
            card: observed(observes.card, card),
            evicted: observed(observes.evict, evicted),
            data,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_read_back() {
        for text in ["r 1f 4", "w ffffffff 00", "i 0 100000000", "flush"] {
            let request = Request::parse(text.as_bytes()).expect(text);
            assert_eq!(request.to_string(), text);
        }
    }

    #[test]
    fn wrong_requests_are_refused() {
        for text in [
            "",
            "R 0 1",
            "r 0",
            "r 0 1 2",
            "r 100000000 1",
            "w 0",
            "w 0 1",
            "w 0 0g",
            "w ffffffff 0000",
            "i 1 100000000",
            "i 0",
            "i 0 0",
            "flush 1",
            "end",
            "r 0x1 1",
        ] {
            assert!(Request::parse(text.as_bytes()).is_err(), "{text}");
        }
        let fits = |host, len| Request::Read { host, len }.fits(16);
        assert!(fits(0, 16) && fits(31, 1) && !fits(1, 16) && !fits(0, 0));
    }

    #[test]
    fn answers_are_read_as_far_as_observed() {
        let parse = |text: &'static str, observes: &str| {
            ReadAnswer::parse(text.as_bytes(), 1, Observes::parse(observes).expect("a list"))
        };
        let all = "data,hit,card,evict";
        let hit = ReadAnswer { hit: Some(true), card: Some(0x1f), evicted: None, data: Some(&b"aB"[..]) };
        assert_eq!(parse("h 1F aB", all).ok(), Some(hit));
        let miss = ReadAnswer { hit: Some(false), evicted: Some(0x40), ..hit };
        assert_eq!(parse("m 1f 40 aB", all).ok(), Some(miss));
        let nothing = ReadAnswer { hit: None, card: None, evicted: None, data: Some(&b"00"[..]) };
        for text in ["- - 00", "- - - 00", "h - 00", "m 3 4 00"] {
            assert_eq!(parse(text, "data").ok(), Some(nothing), "{text}");
        }
        for text in [
            "",
            "h",
            "ok",
            "h - 00",
            "h 0 0",
            "h 0 0000",
            "h 0 -",
            "h 0 gg",
            "m 0 00",
            "h 0 - 00",
            "- 0 00",
            "m x - 00",
            "m 0 - 00 0",
        ] {
            assert!(parse(text, all).is_err(), "{text}");
        }
        assert!(Observes::parse("data,hits").is_err_and(|says| says.to_string().contains("hits")));
        assert_eq!(Observes::ALL.to_string(), all);
    }
}
