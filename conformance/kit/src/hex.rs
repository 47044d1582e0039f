//! Numbers and bytes in hex, without prefix, read and written without allocation.

const DIGITS: &[u8; 16] = b"0123456789abcdef";

/// The number that hex digits of either case stand for: at least one, and up to 16 behind leading zeros.
#[inline]
#[must_use]
pub fn number(word: &[u8]) -> Option<u64> {
    let zeros = word.iter().take_while(|&&digit| digit == b'0').count();
    if word.is_empty() || word.len() - zeros > 16 {
        return None;
    }
    word[zeros..].iter().try_fold(0, |number, &digit| Some(number << 4 | u64::from(value(digit)?)))
}

/// Appends a number, without leading zeros.
#[inline]
pub fn push_number(out: &mut Vec<u8>, number: u64) {
    let digits = (64 - number.leading_zeros()).div_ceil(4).max(1);
    for place in (0..digits).rev() {
        out.push(DIGITS[(number >> (4 * place) & 0xf) as usize]);
    }
}

/// Appends bytes, two digits each.
#[inline]
pub fn push_bytes(out: &mut Vec<u8>, bytes: &[u8]) {
    for byte in bytes {
        out.extend_from_slice(&[DIGITS[usize::from(byte >> 4)], DIGITS[usize::from(byte & 0xf)]]);
    }
}

/// Appends a request of a letter and numbers, with its newline.
pub fn push_request(out: &mut Vec<u8>, name: u8, numbers: &[u64]) {
    out.push(name);
    for &number in numbers {
        out.push(b' ');
        push_number(out, number);
    }
    out.push(b'\n');
}

/// Appends the request that the host writes bytes, with its newline.
pub fn push_write(out: &mut Vec<u8>, host: u32, bytes: &[u8]) {
    out.extend_from_slice(b"w ");
    push_number(out, host.into());
    out.push(b' ');
    push_bytes(out, bytes);
    out.push(b'\n');
}

/// The bytes of pairs of hex digits of either case; none where it is something else.
#[must_use]
pub fn bytes(word: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(word.len() / 2);
    extend_bytes(&mut bytes, word).then_some(bytes)
}

/// Appends the bytes of pairs of hex digits; false where it is something else.
#[inline]
pub fn extend_bytes(bytes: &mut Vec<u8>, word: &[u8]) -> bool {
    let (pairs, rest) = word.as_chunks::<2>();
    for &[high, low] in pairs {
        let (Some(high), Some(low)) = (value(high), value(low)) else { return false };
        bytes.push(high << 4 | low);
    }
    rest.is_empty()
}

#[inline]
fn value(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back() {
        for n in [0, 1, 0xf, 0x10, 0xdead_beef, u64::MAX] {
            let mut text = Vec::new();
            push_number(&mut text, n);
            assert_eq!(String::from_utf8_lossy(&text), format!("{n:x}"));
            assert_eq!(number(&text), Some(n));
        }
        for zeros in [0, 1, 8, 24] {
            assert_eq!(number(format!("{}Ff", "0".repeat(zeros)).as_bytes()), Some(0xff), "{zeros} zeros");
            assert_eq!(number(format!("{}0", "0".repeat(zeros)).as_bytes()), Some(0), "{zeros} zeros");
        }
        for text in ["", "g", "0x1", "-1", " 1", "11111111111111111"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn bytes_read_back() {
        let mut text = Vec::new();
        push_bytes(&mut text, &[0, 0x7f, 0xff]);
        assert_eq!(text, b"007fff");
        assert_eq!(bytes(&text), Some(vec![0, 0x7f, 0xff]));
        assert_eq!(bytes(b"aB"), Some(vec![0xab]));
        assert_eq!((bytes(b"a"), bytes(b"zz")), (None, None));
    }
}
