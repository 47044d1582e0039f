//! Requests and answers of `saarcor-kd`.

use crate::error::Error;
use crate::hex;
use crate::vm::request::Request as VmRequest;
use crate::words::observed_names;
use glam::Vec3;
use saarcor_model::host::Aabb;
use saarcor_model::rays::{Query, Ray};

/// Addresses end here (Assumed): 16 MiB, so that an implementation may hold them in an array.
pub const END_OF_ADDRESSES: u64 = 1 << 24;

/// A request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request<'a> {
    /// The driver writes to the host's memory.
    Write {
        /// Address of the first byte.
        host: u32,
        /// Two hex digits a byte.
        digits: &'a [u8],
    },
    /// The driver hands over the box around the scene.
    Bounds(Aabb),
    /// What a ray hits.
    Trace(Query, Ray),
    /// The memory is zero again, and there is no box.
    Flush,
}

impl<'a> Request<'a> {
    /// The request of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(line: &'a [u8]) -> Result<Self, Error> {
        let (name, rest) = line.split_at(line.iter().position(|&byte| byte == b' ').unwrap_or(line.len()));
        match name {
            b"b" => bounds(rest),
            b"c" => trace(rest, Query::Closest),
            b"a" => trace(rest, Query::Any),
            b"w" | b"flush" => match VmRequest::parse(line)? {
                VmRequest::Write { host, digits }
                    if u64::from(host) + digits.len() as u64 / 2 <= END_OF_ADDRESSES =>
                {
                    Ok(Self::Write { host, digits })
                }
                VmRequest::Write { .. } => Err("a write ends at 1000000 at last".into()),
                _ => Ok(Self::Flush),
            },
            _ => Err("the requests are w, b, c, a, flush, end".into()),
        }
    }
}

/// So many f32 by their bit patterns, each after a space.
fn numbers<const N: usize>(rest: &[u8]) -> Option<[f32; N]> {
    let mut words = rest.strip_prefix(b" ")?.split(|&byte| byte == b' ');
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = number_of(words.next()?)?;
    }
    words.next().is_none().then_some(numbers)
}

fn bits_of(word: &[u8]) -> Option<u32> {
    hex::number(word).and_then(|number| u32::try_from(number).ok())
}

fn number_of(word: &[u8]) -> Option<f32> {
    bits_of(word).map(f32::from_bits)
}

fn bounds(rest: &[u8]) -> Result<Request<'_>, Error> {
    let numbers: [f32; 6] = numbers(rest).ok_or("write 'b X0 Y0 Z0 X1 Y1 Z1', bits of f32 in hex")?;
    let [min, max] = [0, 3].map(|first| Vec3::from_slice(&numbers[first..]));
    if !min.is_finite() || !max.is_finite() || !min.cmple(max).all() {
        return Err("the box is finite, its least corner first".into());
    }
    Ok(Request::Bounds(Aabb { min, max }))
}

fn trace(rest: &[u8], query: Query) -> Result<Request<'_>, Error> {
    let right = "write OX OY OZ DX DY DZ TMIN TMAX, bits of f32 in hex";
    let numbers: [f32; 8] = numbers(rest).ok_or(right)?;
    let [origin, direction] = [0, 3].map(|first| Vec3::from_slice(&numbers[first..]));
    let (t_min, t_max) = (numbers[6], numbers[7]);
    if !origin.is_finite() || !direction.is_finite() {
        return Err("origin and direction are finite".into());
    }
    // −0.0 is no less than 0, and would begin a range below it.
    if !t_min.is_finite() || t_min.is_sign_negative() || t_max.is_nan() || t_max < t_min {
        return Err("0 ≤ TMIN ≤ TMAX, and TMIN is finite".into());
    }
    Ok(Request::Trace(query, Ray { origin, direction, t_min, t_max }))
}

/// Appends the line of a box, with its newline.
pub fn push_bounds(text: &mut Vec<u8>, bounds: &Aabb) {
    text.push(b'b');
    push_f32s(text, bounds.min.to_array().into_iter().chain(bounds.max.to_array()));
    text.push(b'\n');
}

/// Appends the line of a ray, with its newline.
pub fn push_ray(text: &mut Vec<u8>, query: Query, ray: &Ray) {
    text.push(match query {
        Query::Closest => b'c',
        Query::Any => b'a',
    });
    let ends = ray.origin.to_array().into_iter().chain(ray.direction.to_array());
    push_f32s(text, ends.chain([ray.t_min, ray.t_max]));
    text.push(b'\n');
}

/// Appends numbers, each after a space.
pub fn push_f32s(text: &mut Vec<u8>, numbers: impl IntoIterator<Item = f32>) {
    for number in numbers {
        text.push(b' ');
        hex::push_number(text, number.to_bits().into());
    }
}

/// What an implementation observes of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observes {
    /// Which triangle is hit.
    pub triangle: bool,
    /// The distance.
    pub t: bool,
    /// The weights.
    pub uv: bool,
    /// Which addresses are read.
    pub touched: bool,
}

impl Observes {
    /// What the list after `observes=` names.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(list: &str) -> Result<Self, Error> {
        let [triangle, t, uv, touched] = observed_names(["triangle", "t", "uv", "touched"], list)?;
        Ok(Self { triangle, t, uv, touched })
    }
}

/// A hit as it is answered, as far as it is observed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Address of the triangle.
    pub triangle: Option<u32>,
    /// Distance.
    pub t: Option<f32>,
    /// Weights of the second and the third corner.
    pub uv: Option<[f32; 2]>,
}

/// The answer to a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// What is hit.
    pub hit: Option<Hit>,
    /// The addresses that were read, in order.
    pub touched: Option<Vec<u32>>,
}

impl Answer {
    /// The answer of a line of text.
    ///
    /// # Errors
    /// What would be right.
    pub fn parse(line: &[u8], query: Query, observes: Observes) -> Result<Self, Error> {
        let words: Vec<_> = line.split(|&byte| byte == b' ').filter(|word| !word.is_empty()).collect();
        let none = Hit { triangle: None, t: None, uv: None };
        match (query, &words[..]) {
            (Query::Any, [b"h"]) => Ok(Self { hit: Some(none), touched: None }),
            (Query::Any, [b"m"]) => Ok(Self { hit: None, touched: None }),
            (Query::Any, _) => Err("'h' or 'm' is right".into()),
            (Query::Closest, [b"m", list]) => Ok(Self { hit: None, touched: touched(list, observes)? }),
            (Query::Closest, [b"h", triangle, t, u, v, list]) => {
                let triangle = observed(observes.triangle, triangle, "TRIANGLE", bits_of)?;
                let t = observed(observes.t, t, "T", number_of)?;
                let u = observed(observes.uv, u, "U", number_of)?;
                let v = observed(observes.uv, v, "V", number_of)?;
                let uv = u.zip(v).map(|(u, v)| [u, v]);
                Ok(Self { hit: Some(Hit { triangle, t, uv }), touched: touched(list, observes)? })
            }
            (Query::Closest, _) => {
                Err("'h TRIANGLE T U V TOUCHED' or 'm TOUCHED' is right, with '-' for what is not observed"
                    .into())
            }
        }
    }
}

/// A word as far as it is observed.
fn observed<T>(
    is_observed: bool,
    word: &[u8],
    name: &str,
    read: impl Fn(&[u8]) -> Option<T>,
) -> Result<Option<T>, Error> {
    match word {
        b"-" if is_observed => Err(format!("{name} is '-', though it is observed").into()),
        b"-" => Ok(None),
        _ => {
            let value = read(word).ok_or_else(|| format!("{name} is no hex number of 32 bits"))?;
            Ok(is_observed.then_some(value))
        }
    }
}

fn touched(list: &[u8], observes: Observes) -> Result<Option<Vec<u32>>, Error> {
    let addresses = |list: &[u8]| list.split(|&byte| byte == b',').map(bits_of).collect();
    let none = |list: &[u8]| (list == b"none").then(Vec::new);
    observed(observes.touched, list, "TOUCHED", |list| none(list).or_else(|| addresses(list)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_read_back() {
        let bounds = Aabb { min: Vec3::NEG_ONE, max: Vec3::new(1.0, 2.0, 3.0) };
        let ray = Ray { origin: Vec3::X, direction: -Vec3::Y, t_min: 0.5, t_max: f32::INFINITY };
        let mut text = Vec::new();
        push_bounds(&mut text, &bounds);
        push_ray(&mut text, Query::Any, &ray);
        hex::push_write(&mut text, 0x1000, &[1, 0xaf]);
        let lines: Vec<_> = text.split(|&byte| byte == b'\n').map(Request::parse).collect();
        let line = |place: usize| lines[place].as_ref().ok();
        assert_eq!(line(0), Some(&Request::Bounds(bounds)));
        assert_eq!(line(1), Some(&Request::Trace(Query::Any, ray)));
        assert_eq!(line(2), Some(&Request::Write { host: 0x1000, digits: b"01af" }));
        assert_eq!(Request::parse(b"flush").ok(), Some(Request::Flush));
    }

    #[test]
    fn wrong_requests_are_refused() {
        let ray = |rest: &str| format!("c 0 0 0 3f800000 0 0 {rest}");
        for (text, says) in [
            ("r 0 1".to_owned(), "the requests are"),
            ("w ffffff 0000".to_owned(), "1000000"),
            ("b 0 0 0".to_owned(), "X0"),
            ("b 3f800000 0 0 0 0 0".to_owned(), "least corner first"),
            ("b 0 0 0 0 0 7f800000".to_owned(), "finite"),
            (ray("0"), "TMAX"),
            (ray("0 0 0"), "TMAX"),
            (ray("80000000 0"), "0 ≤ TMIN"),
            (ray("3f800000 0"), "0 ≤ TMIN"),
            (ray("0 7fc00000"), "0 ≤ TMIN"),
            ("a 7f800000 0 0 0 0 0 0 0".to_owned(), "finite"),
            ("a 100000000 0 0 0 0 0 0 0".to_owned(), "bits of f32"),
        ] {
            let error = Request::parse(text.as_bytes()).expect_err(&text).to_string();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    #[test]
    fn answers_are_read_as_far_as_observed() {
        let parse = |line: &str, query, list| {
            Answer::parse(line.as_bytes(), query, Observes::parse(list).expect("a list"))
        };
        let all = "triangle,t,uv,touched";
        let hit = Hit { triangle: Some(0x2000), t: Some(1.0), uv: Some([0.5, 0.0]) };
        let answer = Answer { hit: Some(hit), touched: Some(vec![0, 0x1000, 0x2000]) };
        assert_eq!(parse("h 2000 3F800000 3f000000 0 0,1000,2000", Query::Closest, all).ok(), Some(answer));
        let miss = Answer { hit: None, touched: Some(vec![]) };
        assert_eq!(parse("m none", Query::Closest, all).ok(), Some(miss));
        let seen = parse("h 2000 3f800000 - - -", Query::Closest, "triangle").expect("an answer");
        assert_eq!(seen.hit, Some(Hit { triangle: Some(0x2000), t: None, uv: None }));
        assert!(parse("h", Query::Any, all).is_ok_and(|answer| answer.hit.is_some()));
        for (line, query) in [
            ("h", Query::Closest),
            ("m", Query::Closest),
            ("m -", Query::Closest),
            ("m 0,", Query::Closest),
            ("m x", Query::Closest),
            ("h - 0 0 0 0", Query::Closest),
            ("h 0 0 0 0", Query::Closest),
            ("h 0 100000000 0 0 0", Query::Closest),
            ("m 0", Query::Any),
            ("", Query::Any),
        ] {
            assert!(parse(line, query, all).is_err(), "{line}");
        }
        assert!(Observes::parse("triangle,u").is_err_and(|says| says.to_string().contains("'u'")));
    }
}
