//! Words of the protocol: of requests, of configurations, and of the list after `observes=`.

use crate::error::Error;
use crate::hex;
use memchr::memchr;
use std::str::FromStr;

/// The words of a request, each behind a space.
pub(crate) struct Words<'a> {
    /// What follows; none behind the last word.
    rest: Option<&'a [u8]>,
}

impl<'a> Words<'a> {
    pub fn of(line: &'a [u8]) -> Self {
        Self { rest: Some(line) }
    }

    /// The next word; empty behind the last.
    #[inline]
    pub fn word(&mut self) -> &'a [u8] {
        let rest = self.rest.unwrap_or_default();
        let space = memchr(b' ', rest);
        self.rest = space.map(|space| &rest[space + 1..]);
        &rest[..space.unwrap_or(rest.len())]
    }

    /// The next word as a number in hex.
    #[inline]
    pub fn number(&mut self) -> Option<u64> {
        hex::number(self.word())
    }

    /// The next word as a host address in hex, of up to 32 bits.
    #[inline]
    pub fn address(&mut self) -> Option<u32> {
        self.number().and_then(|number| u32::try_from(number).ok())
    }

    /// Whether all words were taken.
    pub fn end(self) -> Result<(), Error> {
        if self.rest.is_some() { Err("too many words".into()) } else { Ok(()) }
    }
}

/// Which of `names` stand in a list such as `data,hit`.
pub(crate) fn observed_names<const N: usize>(names: [&str; N], list: &str) -> Result<[bool; N], Error> {
    let mut observed = [false; N];
    for word in list.split(',') {
        let place = names.iter().position(|name| *name == word);
        let place = place.ok_or_else(|| format!("'{word}' is none of {}", names.join(", ")))?;
        observed[place] = true;
    }
    Ok(observed)
}

/// The list that [`observed_names`] reads back.
pub(crate) fn list_of_names<const N: usize>(names: [&str; N], observed: [bool; N]) -> String {
    let names = names.into_iter().zip(observed).filter_map(|(name, observed)| observed.then_some(name));
    names.collect::<Vec<_>>().join(",")
}

/// Values of a key by their names.
pub type Choices<T> = &'static [(&'static str, T)];

/// The name of one of `choices`.
///
/// # Panics
/// If it is none of them.
#[must_use]
pub fn name_of<T: PartialEq>(choices: Choices<T>, value: &T) -> &'static str {
    choices.iter().find(|(_, choice)| choice == value).expect("every value has its name").0
}

/// The one of `choices` that has that name.
///
/// # Errors
/// The names that there are.
pub fn named<T: Copy>(choices: Choices<T>, name: &str) -> Result<T, Error> {
    let found = choices.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    found.ok_or_else(|| {
        let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
        format!("write one of {}", names.join(", ")).into()
    })
}

/// The keys of a configuration with their values as text. Of a key that stands there twice the last counts.
#[derive(Clone, Debug)]
pub(crate) struct Values<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Values<'a> {
    /// The words `KEY=VALUE` of a configuration, each with one of `keys`.
    pub fn parse(config: &'a str, keys: &[&str]) -> Result<Self, Error> {
        let value = |word: &'a str| {
            let (key, value) = word.split_once('=').ok_or_else(|| format!("'{word}': write KEY=VALUE"))?;
            if !keys.contains(&key) {
                return Err(format!("'{key}': the keys are {}", keys.join(", ")).into());
            }
            Ok((key, value))
        };
        config.split_ascii_whitespace().map(value).collect::<Result<_, Error>>().map(Self)
    }

    /// These values, and where they have none those of `defaults`.
    pub fn or(self, defaults: Self) -> Self {
        Self(defaults.0.into_iter().chain(self.0).collect())
    }

    /// A key that stands there twice.
    pub fn twice(&self) -> Option<&'a str> {
        let twice = |place: &usize| self.0[..*place].iter().any(|(key, _)| *key == self.0[*place].0);
        (0..self.0.len()).find(twice).map(|place| self.0[place].0)
    }

    /// The value of a key.
    pub fn text(&self, key: &str) -> Result<&'a str, Error> {
        let value = self.0.iter().rfind(|(known, _)| *known == key).map(|(_, value)| *value);
        value.ok_or_else(|| format!("{key} is missing").into())
    }

    /// The value of a key as a decimal number.
    pub fn number<T: FromStr>(&self, key: &str) -> Result<T, Error> {
        let value = self.text(key)?;
        value.parse().map_err(|_| format!("{key}={value}: write a decimal number").into())
    }

    /// The value of a key as one of `choices`.
    pub fn named<T: Copy>(&self, key: &str, choices: Choices<T>) -> Result<T, Error> {
        let value = self.text(key)?;
        named(choices, value).map_err(|right| format!("{key}={value}: {right}").into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_taken_one_by_one() {
        let mut words = Words::of(b"r 1f 100000000");
        assert_eq!((words.word(), words.number(), words.address()), (&b"r"[..], Some(0x1f), None));
        assert!(words.end().is_ok());
        let mut words = Words::of(b"r 1f");
        assert_eq!((words.word(), words.word(), words.word()), (&b"r"[..], &b"1f"[..], &b""[..]));
        assert!(words.end().is_ok());
        let mut words = Words::of(b"r ");
        assert_eq!(words.word(), b"r");
        assert!(words.end().is_err());
    }

    #[test]
    fn values_are_found_by_their_keys() {
        let values = Values::parse("ways=4 line=x ways=2", &["ways", "line", "hash"]).expect("known keys");
        assert_eq!(values.number::<u32>("ways").ok(), Some(2));
        assert_eq!(values.twice(), Some("ways"));
        let says = |error: Error| error.to_string();
        assert_eq!(
            values.number::<u32>("line").map_err(says),
            Err("line=x: write a decimal number".to_owned())
        );
        assert_eq!(values.text("hash").map_err(says), Err("hash is missing".to_owned()));
        let unknown = Values::parse("way=4", &["ways"]).map(|_| ()).map_err(says);
        assert_eq!(unknown, Err("'way': the keys are ways".to_owned()));
    }
}
