//! Requests and answers of `saarcor-meta`.

use crate::error::Error;
use crate::hex;
use crate::vm::request::END_OF_ADDRESSES;
use crate::words::{Words, list_of_names, observed_names};
use saarcor_oracles::metadata::GranuleEvent;
use std::fmt;

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// The chip uses the line that holds an address.
    Read {
        /// The address.
        host: u32,
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
    /// Bits of a byte of the metadata on the card flip.
    Flip {
        /// The byte, from the begin of the metadata.
        byte: u32,
        /// The bits.
        mask: u8,
    },
}

impl Request {
    /// The request of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(line: &[u8]) -> Result<Self, Error> {
        let mut words = Words::of(line);
        let request = match words.word() {
            b"r" => Self::Read { host: words.address().ok_or("write 'r HOST' in hex")? },
            b"i" => {
                let right = "write 'i HOST LEN' in hex, which ends at 100000000 at last";
                let (host, len) = (words.address().ok_or(right)?, words.number().ok_or(right)?);
                if len == 0 || u64::from(host).saturating_add(len) > END_OF_ADDRESSES {
                    return Err(right.into());
                }
                Self::Invalidate { host, len }
            }
            b"x" => {
                let right = "write 'x BYTE MASK' in hex, with one bit of MASK set or up to three neighbours";
                let (byte, mask) = (words.address().ok_or(right)?, words.number().ok_or(right)?);
                let mask = u8::try_from(mask).map_err(|_| right)?;
                // The check bits detect all errors of this kind (VM-12).
                if mask == 0 || ![1, 3, 5, 7].contains(&(mask >> mask.trailing_zeros())) {
                    return Err(right.into());
                }
                Self::Flip { byte, mask }
            }
            b"flush" => Self::Flush,
            _ => return Err("the requests are r, i, flush, x, end".into()),
        };
        words.end()?;
        Ok(request)
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Read { host } => write!(f, "r {host:x}"),
            Self::Invalidate { host, len } => write!(f, "i {host:x} {len:x}"),
            Self::Flush => f.write_str("flush"),
            Self::Flip { byte, mask } => write!(f, "x {byte:x} {mask:x}"),
        }
    }
}

/// What an implementation observes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observes {
    /// Whether an access hits.
    pub hit: bool,
    /// Where on the card its byte lies.
    pub card: bool,
    /// Which line is evicted.
    pub evict: bool,
    /// Which granules of metadata move.
    pub meta: bool,
    /// The bytes of those that are written back.
    pub bytes: bool,
}

impl Observes {
    /// All.
    pub const ALL: Self = Self { hit: true, card: true, evict: true, meta: true, bytes: true };

    /// What the list after `observes=` names.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(list: &str) -> Result<Self, Error> {
        let [hit, card, evict, meta, bytes] = observed_names(Self::NAMES, list)?;
        Ok(Self { hit, card, evict, meta, bytes })
    }

    const NAMES: [&str; 5] = ["hit", "card", "evict", "meta", "bytes"];
}

impl fmt::Display for Observes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hit, card, evict, meta, bytes } = *self;
        f.write_str(&list_of_names(Self::NAMES, [hit, card, evict, meta, bytes]))
    }
}

/// The answer to an access or an invalidation, as far as it is observed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether the access hits.
    pub hit: Option<bool>,
    /// Where on the card its byte lies.
    pub card: Option<u64>,
    /// Host address of the line that is evicted; none if nothing is, or it is not observed.
    pub evicted: Option<u64>,
    /// What moved; bytes that are not observed are none.
    pub moved: Option<Vec<GranuleEvent>>,
}

impl Answer {
    /// The answer of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(request: Request, line: &[u8], observes: Observes) -> Result<Self, Error> {
        let words: Vec<&[u8]> = line.split(|&byte| byte == b' ').filter(|word| !word.is_empty()).collect();
        let is_read = matches!(request, Request::Read { .. });
        let (letter, card, evicted, meta) = match *words.as_slice() {
            [b"ok", meta] if !is_read => (&b"-"[..], &b"-"[..], &b"-"[..], meta),
            [letter @ b"h", card, meta] if is_read => (letter, card, &b"-"[..], meta),
            [letter @ b"m", card, evicted, meta] if is_read => (letter, card, evicted, meta),
            [letter @ b"-", card, meta] if is_read && !observes.hit => (letter, card, &b"-"[..], meta),
            [letter @ b"-", card, evicted, meta] if is_read && !observes.hit => (letter, card, evicted, meta),
            _ if is_read => return Err("'h CARD META' or 'm CARD EVICTED META' is right".into()),
            _ => return Err("'ok META' is right".into()),
        };
        let number = |word: &[u8]| match word {
            b"-" => Ok(None),
            _ => hex::number(word).map(Some).ok_or("an address is a hex number or '-'"),
        };
        let (card, evicted) = (number(card)?, number(evicted)?);
        if is_read && observes.card && card.is_none() {
            return Err("CARD is '-', though it is observed".into());
        }
        let moved = match meta {
            _ if !observes.meta => None,
            meta => Some(parse_moved(meta, observes.bytes)?),
        };
        Ok(Self {
            hit: (is_read && observes.hit).then_some(letter == b"h"),
            card: card.filter(|_| observes.card),
            evicted: evicted.filter(|_| observes.evict),
            moved,
        })
    }
}

fn parse_moved(meta: &[u8], bytes_seen: bool) -> Result<Vec<GranuleEvent>, Error> {
    let right = "META is a list of hGRANULE, mGRANULE and wGRANULE=BYTES with ',' between them";
    let one = |word: &[u8]| {
        let (letter, rest) = word.split_first()?;
        let granule = |digits: &[u8]| hex::number(digits).and_then(|number| u32::try_from(number).ok());
        match letter {
            b'h' => granule(rest).map(GranuleEvent::Found),
            b'm' => granule(rest).map(GranuleEvent::Read),
            b'w' => {
                let equals = memchr::memchr(b'=', rest)?;
                let bytes = match &rest[equals + 1..] {
                    _ if !bytes_seen => Vec::new(),
                    digits => hex::bytes(digits)?,
                };
                granule(&rest[..equals]).map(|granule| GranuleEvent::WrittenBack(granule, bytes))
            }
            _ => None,
        }
    };
    let moved = meta.split(|&byte| byte == b',').map(|word| one(word).ok_or(Error::from(right)));
    moved.collect()
}

/// Appends what moved.
pub fn push_moved(out: &mut Vec<u8>, moved: &[GranuleEvent], bytes_seen: bool) {
    for (place, moved) in moved.iter().enumerate() {
        if place > 0 {
            out.push(b',');
        }
        let (letter, granule) = match moved {
            GranuleEvent::Found(granule) => (b'h', granule),
            GranuleEvent::Read(granule) => (b'm', granule),
            GranuleEvent::WrittenBack(granule, _) => (b'w', granule),
        };
        out.push(letter);
        hex::push_number(out, u64::from(*granule));
        if let GranuleEvent::WrittenBack(_, bytes) = moved {
            out.push(b'=');
            if bytes_seen { hex::push_bytes(out, bytes) } else { out.push(b'-') }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_read_back() {
        for text in ["r 1f", "i 0 100000000", "flush", "x 13 80", "x 0 e", "x 2 5"] {
            let request = Request::parse(text.as_bytes());
            assert_eq!(request.expect(text).to_string(), text);
        }
        for text in ["", "r", "r 0 1", "w 0 00", "i 0 0", "i 1 100000000", "x 0 0", "x 0 9", "x 0 100", "end"]
        {
            assert!(Request::parse(text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn answers_are_read_as_far_as_observed() {
        let (read, forget) = (Request::Read { host: 0 }, Request::Invalidate { host: 0, len: 1 });
        let moved = vec![
            GranuleEvent::Found(1),
            GranuleEvent::Read(0xa),
            GranuleEvent::WrittenBack(3, vec![0xab, 0]),
        ];
        let answer = Answer { hit: Some(false), card: Some(0x10), evicted: None, moved: Some(moved.clone()) };
        assert_eq!(Answer::parse(read, b"m 10 - h1,mA,w3=aB00", Observes::ALL).ok(), Some(answer));
        let mut text = Vec::new();
        push_moved(&mut text, &moved, true);
        assert_eq!(text, b"h1,ma,w3=ab00");
        let none = Answer { hit: None, card: None, evicted: None, moved: None };
        let hit = Observes::parse("hit").expect("a list");
        assert_eq!(Answer::parse(read, b"h - -", hit).expect("a hit").hit, Some(true));
        assert_eq!(Answer::parse(forget, b"ok -", hit).ok(), Some(none));
        for text in
            ["", "ok", "h 0", "h 0 - h1", "m 0 h1", "h - h1", "h 0 -", "h 0 h", "h 0 1", "h 0 w1", "h 0 h1,"]
        {
            assert!(Answer::parse(read, text.as_bytes(), Observes::ALL).is_err(), "{text}");
        }
        assert!(Answer::parse(forget, b"ok", Observes::ALL).is_err());
        assert_eq!(Observes::parse(&Observes::ALL.to_string()).ok(), Some(Observes::ALL));
        assert!(Observes::parse("data").is_err());
    }
}
