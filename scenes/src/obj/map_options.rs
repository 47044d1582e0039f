//! The options of the statements of MTL files that name images.

use super::materials::Map;
use crate::error::SceneError;
use crate::text::finite;
use crate::warning::Warnings;

/// What stands behind `map_Kd` or `map_Bump`: options, the file's name, and options again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Statement<'a> {
    pub(crate) before: &'a str,
    pub(crate) name: &'a str,
    pub(crate) behind: &'a str,
}

/// What the options say that the chip can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Options {
    /// Of the bump map's white, in texels.
    pub(crate) height: f32,
    /// Whether a channel of the image is named.
    pub(crate) has_channel: bool,
}

/// The words that may follow an option.
#[derive(Clone, Copy)]
enum Arguments {
    /// A word, whatever it is.
    Word,
    /// One of these words.
    OneOf(&'static [&'static str]),
    /// So many numbers, at least and at most.
    Numbers(usize, usize),
}

/// The options, their arguments, and those with which they change nothing.
const OPTIONS: [(&str, Arguments, &[&str]); 14] = [
    ("-blendu", Arguments::OneOf(&["on", "off"]), &["on"]),
    ("-blendv", Arguments::OneOf(&["on", "off"]), &["on"]),
    ("-boost", Arguments::Numbers(1, 1), &["0"]),
    ("-bm", Arguments::Word, &[]),
    ("-cc", Arguments::OneOf(&["on", "off"]), &["off"]),
    ("-clamp", Arguments::OneOf(&["on", "off"]), &["off"]),
    ("-colorspace", Arguments::Word, &[]),
    ("-imfchan", Arguments::OneOf(&["r", "g", "b", "m", "l", "z"]), &[]),
    ("-mm", Arguments::Numbers(2, 2), &["0", "1"]),
    ("-o", Arguments::Numbers(1, 3), &["0"]),
    ("-s", Arguments::Numbers(1, 3), &["1"]),
    ("-t", Arguments::Numbers(1, 3), &["0"]),
    ("-texres", Arguments::Numbers(1, 1), &[]),
    ("-type", Arguments::Word, &[]),
];

/// An option with its arguments.
struct Given<'a> {
    name: &'static str,
    arguments: Vec<&'a str>,
    unchanging: &'static [&'static str],
}

/// Takes the option at the begin of `text`, and gives what follows; none if there is none.
fn take(text: &str) -> Option<(Given<'_>, &str)> {
    let (word, mut rest) = split_word(text)?;
    let &(name, arguments, unchanging) = OPTIONS.iter().find(|(name, ..)| name.eq_ignore_ascii_case(word))?;
    let (least, most) = match arguments {
        Arguments::Word | Arguments::OneOf(_) => (1, 1),
        Arguments::Numbers(least, most) => (least, most),
    };
    let mut given = Vec::new();
    while given.len() < most
        && let Some((word, behind)) = split_word(rest)
        && match arguments {
            Arguments::Word => true,
            Arguments::OneOf(words) => words.iter().any(|it| it.eq_ignore_ascii_case(word)),
            Arguments::Numbers(..) => word.parse::<f32>().is_ok(),
        }
    {
        given.push(word);
        rest = behind;
    }
    (given.len() >= least).then_some((Given { name, arguments: given, unchanging }, rest))
}

/// The first word and what follows it, without space around.
fn split_word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim();
    let word = text.split_whitespace().next()?;
    Some((word, text[word.len()..].trim_start()))
}

/// What stands behind the options before the name.
pub(crate) fn without_options(text: &str) -> &str {
    let mut rest = text.trim();
    while let Some((_, behind)) = take(rest) {
        rest = behind;
    }
    rest
}

impl<'a> Statement<'a> {
    /// What stands behind the keyword.
    pub(crate) fn read(text: &'a str) -> Self {
        let rest = without_options(text);
        let before = text[..text.trim_end().len() - rest.len()].trim();
        let dashes = rest.match_indices('-').filter(|&(at, _)| rest[..at].ends_with(char::is_whitespace));
        let all_options = |at: &usize| without_options(&rest[*at..]).is_empty();
        let (name, behind) = match dashes.map(|(at, _)| at).find(all_options) {
            Some(at) => rest.split_at(at),
            None => (rest, ""),
        };
        Self { before, name: name.trim_end(), behind }
    }

    /// What the options say.
    ///
    /// # Errors
    /// Faults, where they are to be errors.
    pub(crate) fn options(&self, map: &Map<'_>, warnings: &mut Warnings) -> Result<Options, SceneError> {
        let mut options = Options { height: 1.0, has_channel: false };
        for mut text in [self.before, self.behind] {
            while let Some((Given { name, arguments, unchanging }, rest)) = take(text) {
                text = rest;
                let changes_nothing = !unchanging.is_empty()
                    && arguments.iter().enumerate().all(|(index, word)| {
                        let neutral = unchanging[index.min(unchanging.len() - 1)];
                        word.eq_ignore_ascii_case(neutral)
                            || word.parse::<f32>().is_ok_and(|number| neutral.parse() == Ok(number))
                    });
                match name {
                    _ if changes_nothing => {}
                    "-imfchan" => options.has_channel = true,
                    "-bm" => match finite(arguments[0]) {
                        Ok(height) => options.height = height,
                        Err(reason) => warnings
                            .note("a height of 1 is taken", || map.error(format_args!("-bm: {reason}")))?,
                    },
                    _ => warnings.note("the image is shown without it", || {
                        map.error(format_args!(
                            "option \"{name}\" is not supported: only -bm is; apply it to the image or to vt"
                        ))
                    })?,
                }
            }
        }
        Ok(options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_stand_before_and_behind_names() {
        let read = |text| {
            let Statement { before, name, behind } = Statement::read(text);
            [before, name, behind].join("|")
        };
        assert_eq!(read("a.png"), "|a.png|");
        assert_eq!(read("two words.png "), "|two words.png|");
        assert_eq!(read("-bm 2 -clamp on  a.png"), "-bm 2 -clamp on|a.png|");
        assert_eq!(read("-s 2 2 -o 1 a.png"), "-s 2 2 -o 1|a.png|");
        assert_eq!(read("-s 2 2 2 2.png"), "-s 2 2 2|2.png|");
        assert_eq!(read("a b.png -BM 1 -clamp off"), "|a b.png|-BM 1 -clamp off");
        assert_eq!(read("-blendu off a - b -s.png -mm 0 1"), "-blendu off|a - b -s.png|-mm 0 1");
        assert_eq!(read("-unknown a.png"), "|-unknown a.png|");
        assert_eq!(read("a.png -clamp"), "|a.png -clamp|");
        assert_eq!(read("-bm 2"), "-bm 2||");
    }
}
