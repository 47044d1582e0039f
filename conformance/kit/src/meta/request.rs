//! Requests and answers of `saarcor-meta`.

use crate::hex;
use crate::vm::request::{END_OF_ADDRESSES, address};
use saarcor_oracles::metadata::Moved;
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
    TurnOver {
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
    pub fn parse(line: &[u8]) -> Result<Self, &'static str> {
        let mut words = line.split(|&byte| byte == b' ');
        let name = words.next().unwrap_or_default();
        let mut word = || words.next().unwrap_or_default();
        let request = match name {
            b"r" => Self::Read { host: address(word()).ok_or("write 'r HOST' in hex")? },
            b"i" => {
                let right = "write 'i HOST LEN' in hex, which ends at 100000000 at last";
                let (host, len) = (address(word()).ok_or(right)?, hex::number(word()).ok_or(right)?);
                if len == 0 || u64::from(host).saturating_add(len) > END_OF_ADDRESSES {
                    return Err(right);
                }
                Self::Invalidate { host, len }
            }
            b"x" => {
                let right = "write 'x BYTE MASK' in hex, with one bit of MASK set or up to three neighbours";
                let (byte, mask) = (address(word()).ok_or(right)?, hex::number(word()).ok_or(right)?);
                let mask = u8::try_from(mask).map_err(|_| right)?;
                // All errors of this kind are told by the check bits (VM-12).
                if mask == 0 || ![1, 3, 5, 7].contains(&(mask >> mask.trailing_zeros())) {
                    return Err(right);
                }
                Self::TurnOver { byte, mask }
            }
            b"flush" => Self::Flush,
            _ => return Err("the requests are r, i, flush, x, end"),
        };
        if words.next().is_some() { Err("too many words") } else { Ok(request) }
    }
}

impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Read { host } => write!(f, "r {host:x}"),
            Self::Invalidate { host, len } => write!(f, "i {host:x} {len:x}"),
            Self::Flush => f.write_str("flush"),
            Self::TurnOver { byte, mask } => write!(f, "x {byte:x} {mask:x}"),
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
    pub fn parse(list: &str) -> Result<Self, String> {
        let mut observes = Self { hit: false, card: false, evict: false, meta: false, bytes: false };
        for name in list.split(',') {
            match name {
                "hit" => observes.hit = true,
                "card" => observes.card = true,
                "evict" => observes.evict = true,
                "meta" => observes.meta = true,
                "bytes" => observes.bytes = true,
                _ => return Err(format!("'{name}' is none of hit, card, evict, meta, bytes")),
            }
        }
        Ok(observes)
    }
}

impl fmt::Display for Observes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hit, card, evict, meta, bytes } = *self;
        let all = [(hit, "hit"), (card, "card"), (evict, "evict"), (meta, "meta"), (bytes, "bytes")];
        let names: Vec<_> = all.into_iter().filter_map(|(seen, name)| seen.then_some(name)).collect();
        f.write_str(&names.join(","))
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
    pub moved: Option<Vec<Moved>>,
}

impl Answer {
    /// The answer of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(request: Request, line: &[u8], observes: Observes) -> Result<Self, String> {
        let words: Vec<&[u8]> = line.split(|&byte| byte == b' ').filter(|word| !word.is_empty()).collect();
        let is_read = matches!(request, Request::Read { .. });
        let (letter, card, evicted, meta) = match *words.as_slice() {
            [b"ok", meta] if !is_read => (&b"-"[..], &b"-"[..], &b"-"[..], meta),
            [letter @ b"h", card, meta] if is_read => (letter, card, &b"-"[..], meta),
            [letter @ b"m", card, evicted, meta] if is_read => (letter, card, evicted, meta),
            [letter @ b"-", card, meta] if is_read && !observes.hit => (letter, card, &b"-"[..], meta),
            [letter @ b"-", card, evicted, meta] if is_read && !observes.hit => (letter, card, evicted, meta),
            _ if is_read => return Err("'h CARD META' or 'm CARD EVICTED META' is right".to_owned()),
            _ => return Err("'ok META' is right".to_owned()),
        };
        let number = |word: &[u8]| match word {
            b"-" => Ok(None),
            _ => hex::number(word).map(Some).ok_or("an address is a hex number or '-'"),
        };
        let (card, evicted) = (number(card)?, number(evicted)?);
        if is_read && observes.card && card.is_none() {
            return Err("CARD is '-', though it is observed".to_owned());
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

fn parse_moved(meta: &[u8], bytes_seen: bool) -> Result<Vec<Moved>, String> {
    let right = "META is a list of hGRANULE, mGRANULE and wGRANULE=BYTES with ',' between them";
    let one = |word: &[u8]| {
        let (letter, rest) = word.split_first()?;
        let granule = |digits: &[u8]| hex::number(digits).and_then(|number| u32::try_from(number).ok());
        match letter {
            b'h' => granule(rest).map(Moved::Found),
            b'm' => granule(rest).map(Moved::Read),
            b'w' => {
                let equals = memchr::memchr(b'=', rest)?;
                let bytes = match &rest[equals + 1..] {
                    _ if !bytes_seen => Vec::new(),
                    digits => hex::bytes(digits)?,
                };
                granule(&rest[..equals]).map(|granule| Moved::WrittenBack(granule, bytes))
            }
            _ => None,
        }
    };
    let moved = meta.split(|&byte| byte == b',').map(|word| one(word).ok_or_else(|| right.to_owned()));
    moved.collect()
}

/// Appends what moved.
pub fn push_moved(out: &mut Vec<u8>, moved: &[Moved], bytes_seen: bool) {
    for (place, moved) in moved.iter().enumerate() {
        if place > 0 {
            out.push(b',');
        }
        let (letter, granule) = match moved {
            Moved::Found(granule) => (b'h', granule),
            Moved::Read(granule) => (b'm', granule),
            Moved::WrittenBack(granule, _) => (b'w', granule),
        };
        out.push(letter);
        hex::push_number(out, u64::from(*granule));
        if let Moved::WrittenBack(_, bytes) = moved {
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
            assert_eq!(request.map(|request| request.to_string()), Ok(text.to_owned()));
        }
        for text in ["", "r", "r 0 1", "w 0 00", "i 0 0", "i 1 100000000", "x 0 0", "x 0 9", "x 0 100", "end"]
        {
            assert!(Request::parse(text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn answers_are_read_as_far_as_observed() {
        let (read, forget) = (Request::Read { host: 0 }, Request::Invalidate { host: 0, len: 1 });
        let moved = vec![Moved::Found(1), Moved::Read(0xa), Moved::WrittenBack(3, vec![0xab, 0])];
        let answer = Answer { hit: Some(false), card: Some(0x10), evicted: None, moved: Some(moved.clone()) };
        assert_eq!(Answer::parse(read, b"m 10 - h1,mA,w3=aB00", Observes::ALL), Ok(answer));
        let mut text = Vec::new();
        push_moved(&mut text, &moved, true);
        assert_eq!(text, b"h1,ma,w3=ab00");
        let none = Answer { hit: None, card: None, evicted: None, moved: None };
        let hit = Observes::parse("hit").expect("a list");
        assert_eq!(Answer::parse(read, b"h - -", hit).map(|answer| answer.hit), Ok(Some(true)));
        assert_eq!(Answer::parse(forget, b"ok -", hit), Ok(none));
        for text in
            ["", "ok", "h 0", "h 0 - h1", "m 0 h1", "h - h1", "h 0 -", "h 0 h", "h 0 1", "h 0 w1", "h 0 h1,"]
        {
            assert!(Answer::parse(read, text.as_bytes(), Observes::ALL).is_err(), "{text}");
        }
        assert!(Answer::parse(forget, b"ok", Observes::ALL).is_err());
        assert_eq!(Observes::parse(&Observes::ALL.to_string()), Ok(Observes::ALL));
        assert!(Observes::parse("data").is_err());
    }
}
