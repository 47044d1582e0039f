//! Rust's texts, as far as evidence has to read them: tokens, theorems, and the items of a file.

pub(super) fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The tokens of a Rust file, without comments: words, numbers, literals whole, other characters one by one.
pub(super) fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let len = if first.is_whitespace() {
            first.len_utf8()
        } else if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else {
            let len = token(rest, first);
            tokens.push(&rest[..len]);
            len
        };
        rest = &rest[len..];
    }
    tokens
}

/// Length of a comment, with those in it.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text.as_bytes()[at..];
        if rest.starts_with(b"/*") {
            (depth, at) = (depth + 1, at + 2);
        } else if rest.starts_with(b"*/") {
            (depth, at) = (depth - 1, at + 2);
            if depth == 0 {
                break;
            }
        } else {
            at += 1;
        }
    }
    at
}

/// Length of the token that a text begins with.
fn token(text: &str, first: char) -> usize {
    let word = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let after = &text[word..];
    if ["r", "br"].contains(&&text[..word]) && after.trim_start_matches('#').starts_with('"') {
        let hashes = after.len() - after.trim_start_matches('#').len();
        let end = format!("\"{}", "#".repeat(hashes));
        let inside = word + hashes + 1;
        return text[inside..].find(&end).map_or(text.len(), |at| inside + at + end.len());
    }
    if first == '"' || (["b", "c"].contains(&&text[..word]) && after.starts_with('"')) {
        return quoted(text, word + 1, '"');
    }
    if word > 0 {
        return word;
    }
    if first == '\'' {
        let mut next = text[1..].chars();
        let (one, two) = (next.next(), next.next());
        // A character, or else the mark of a lifetime.
        if one == Some('\\') || two == Some('\'') {
            return quoted(text, 1, '\'');
        }
    }
    first.len_utf8()
}

/// Length of a literal whose inside begins at `from`.
fn quoted(text: &str, from: usize, end: char) -> usize {
    let mut escaped = false;
    for (at, c) in text[from..].char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == end => return from + at + c.len_utf8(),
            _ => {}
        }
    }
    text.len()
}

/// The place behind the group that opens at `at`.
pub(super) fn behind(tokens: &[&str], at: usize) -> usize {
    let mut depth = 0;
    for (place, token) in tokens.iter().enumerate().skip(at) {
        match *token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => continue,
        }
        if depth == 0 {
            return place + 1;
        }
    }
    tokens.len()
}

pub(super) fn without_tests(tokens: Vec<&str>) -> Vec<&str> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::with_capacity(tokens.len());
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at..].starts_with(&MARK) {
            let body = tokens[at + MARK.len()..].iter().position(|token| ["{", ";"].contains(token));
            let Some(body) = body.map(|place| at + MARK.len() + place) else { break };
            at = if tokens[body] == "{" { behind(&tokens, body) } else { body + 1 };
        } else {
            kept.push(tokens[at]);
            at += 1;
        }
    }
    kept
}

/// A file without its theorems, and each theorem by its name, from its attribute on.
pub(super) fn split<'a>(tokens: &[&'a str]) -> (Vec<&'a str>, Vec<(&'a str, Vec<&'a str>)>) {
    let (mut rest, mut theorems) = (Vec::new(), Vec::new());
    let mut at = 0;
    while at < tokens.len() {
        let is_attribute = tokens[at..].starts_with(&["#", "["])
            && tokens.get(at + 2).is_some_and(|token| token.starts_with('"'));
        let end = if is_attribute { behind(tokens, at + 1) } else { 0 };
        if is_attribute && tokens.get(end) == Some(&"fn") {
            let body = behind(tokens, end + 2);
            let next = behind(tokens, body);
            theorems.push((tokens[end + 1], tokens[at..next].to_vec()));
            at = next;
        } else {
            rest.push(tokens[at]);
            at += 1;
        }
    }
    (rest, theorems)
}

/// What a part of a file is, from its attributes to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kind<'a> {
    /// An item, or a module whose text stands there.
    Item(&'a str),
    /// A trait.
    Trait(&'a str),
    /// What is implemented for a type, of a trait or by itself: both by the words of their paths, which are none for a type
    /// without a path.
    Impl { of: Vec<&'a str>, of_trait: Option<Vec<&'a str>> },
    /// Names that are taken from elsewhere.
    Use,
    /// A module whose text stands in another file.
    Module,
    /// Anything else, as a call of a macro.
    Other,
}

/// The parts of a file, in order.
pub(super) fn parts<'a, 'b>(tokens: &'b [&'a str]) -> Vec<(Kind<'a>, &'b [&'a str])> {
    let (mut parts, mut begin) = (Vec::new(), 0);
    while begin < tokens.len() {
        let mut at = begin;
        while tokens[at..].first() == Some(&"#") && tokens.get(at + 1) == Some(&"[") {
            at = behind(tokens, at + 1);
        }
        if at == begin && tokens[at..].starts_with(&["#", "!"]) {
            // An attribute of the whole file.
            at = behind(tokens, at + 2);
            parts.push((Kind::Other, &tokens[begin..at]));
            begin = at;
            continue;
        }
        loop {
            match tokens[at..] {
                ["pub", "(", ..] => at = behind(tokens, at + 1),
                ["pub" | "unsafe" | "async" | "extern", ..] | ["const", "fn" | "unsafe", ..] => at += 1,
                _ => break,
            }
        }
        let keyword = tokens.get(at).copied().unwrap_or_default();
        let to_semicolon = ["use", "const", "static", "type"].contains(&keyword);
        let mut end = at;
        while end < tokens.len() {
            match tokens[end] {
                ";" => {
                    end += 1;
                    break;
                }
                "{" => {
                    end = behind(tokens, end);
                    if !to_semicolon {
                        break;
                    }
                }
                "(" | "[" => end = behind(tokens, end),
                _ => end += 1,
            }
        }
        let end = end.max(begin + 1);
        parts.push((kind(&tokens[at.min(end)..end]), &tokens[begin..end]));
        begin = end;
    }
    parts
}

/// The kind of a part, without its attributes and its visibility.
fn kind<'a>(tokens: &[&'a str]) -> Kind<'a> {
    match *tokens {
        ["use", ..] => Kind::Use,
        ["mod", _, ";"] => Kind::Module,
        ["trait", name, ..] => Kind::Trait(name),
        ["impl", ..] => implemented(tokens),
        ["macro_rules", "!", name, ..] | ["static", "mut", name, ..] => Kind::Item(name),
        ["mod" | "struct" | "enum" | "union" | "type" | "fn" | "static" | "const", name, ..]
            if name != "_" =>
        {
            Kind::Item(name)
        }
        _ => Kind::Other,
    }
}

/// Of what something is implemented.
fn implemented<'a>(tokens: &[&'a str]) -> Kind<'a> {
    let (mut of, mut of_trait, mut depth) = (Vec::new(), None, 0);
    for at in 1..tokens.len() {
        match tokens[at] {
            "<" => depth += 1,
            ">" if !["-", "="].contains(&tokens[at - 1]) => depth -= 1,
            "{" | "where" if depth == 0 => break,
            "for" if depth == 0 => of_trait = Some(std::mem::take(&mut of)),
            "mut" | "dyn" => {}
            token if depth == 0 && is_word(token) && tokens[at - 1] != "'" => of.push(token),
            _ => {}
        }
    }
    Kind::Impl { of, of_trait }
}

/// A name that `use` brings into a file: the name there, and the path to it; `*` stands for all names.
pub(super) type Used<'a> = (&'a str, Vec<&'a str>);

/// The names that a part of the kind [`Kind::Use`] brings.
pub(super) fn used<'a>(tokens: &[&'a str]) -> Vec<Used<'a>> {
    let Some(begin) = tokens.iter().position(|token| *token == "use") else { return Vec::new() };
    let end = tokens[begin..].iter().position(|token| *token == ";").map_or(tokens.len(), |at| begin + at);
    let mut names = Vec::new();
    tree(&tokens[begin + 1..end], &[], &mut names);
    names
}

/// The paths of a tree of names, behind a path that they share.
fn tree<'a>(tokens: &[&'a str], before: &[&'a str], names: &mut Vec<Used<'a>>) {
    let mut path = before.to_vec();
    for (at, token) in tokens.iter().copied().enumerate() {
        match token {
            "{" => {
                let inside = &tokens[at + 1..behind(tokens, at) - 1];
                let (mut begin, mut end) = (0, 0);
                while begin < inside.len() {
                    while end < inside.len() && inside[end] != "," {
                        end = if inside[end] == "{" { behind(inside, end) } else { end + 1 };
                    }
                    tree(&inside[begin..end], &path, names);
                    (begin, end) = (end + 1, end + 1);
                }
                return;
            }
            "as" => {
                let name = tokens.get(at + 1).copied().unwrap_or_default();
                names.push((name, path));
                return;
            }
            "*" => {
                names.push(("*", path));
                return;
            }
            "self" if !path.is_empty() => {}
            _ if is_word(token) => path.push(token),
            _ => {}
        }
    }
    if let Some(name) = path.last().filter(|_| !tokens.is_empty()) {
        names.push((name, path.clone()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_white_space_are_no_tokens() {
        let text = "fn f<'a>() { /* a /* b */ c */ g('\\'', \"// \\\" \", r#\"\"x\"\"#) } // end\n";
        let expected = "fn f < ' a > ( ) { g ( '\\'' , \"// \\\" \" , r#\"\"x\"\"# ) }";
        assert_eq!(tokens(text).join(" "), expected);
    }

    #[test]
    fn theorems_are_texts_of_their_own() {
        let text = "use a; #[\"VM-1\", unwind 8, covers [\"x\"]] fn one(s) { b } #[must_use] fn two() {}";
        let (rest, theorems) = split(&tokens(text));
        assert_eq!(rest.join(" "), "use a ; # [ must_use ] fn two ( ) { }");
        assert_eq!((theorems.len(), theorems[0].0), (1, "one"));
    }

    #[test]
    fn parts_of_a_file_have_their_names() {
        let text = "#![allow(x)] use a::b; pub(crate) const fn f() -> [u8; 4] { g() } static S: [A; 2] = [A { x: 1 }, B];
            #[derive(Debug)] pub struct T<const N: usize>(u8); mod m; mod n { fn x() {} } theorems! { y } trait U {}
            impl<const N: usize> T<N> { } impl<T: Into<u8>> fmt::Display for units::Way<T> where T: A { }
            impl<O: V + ?Sized> V for &mut O {} macro_rules! z { () => {} }";
        let tokens = tokens(text);
        let parts = parts(&tokens);
        let named = |name| Kind::Item(name);
        let implemented = |of: &[&'static str], of_trait: Option<&[&'static str]>| Kind::Impl {
            of: of.to_vec(),
            of_trait: of_trait.map(<[_]>::to_vec),
        };
        let expected = [
            Kind::Other,
            Kind::Use,
            named("f"),
            named("S"),
            named("T"),
            Kind::Module,
            named("n"),
            Kind::Other,
            Kind::Trait("U"),
            implemented(&["T"], None),
            implemented(&["units", "Way"], Some(&["fmt", "Display"])),
            implemented(&["O"], Some(&["V"])),
            named("z"),
        ];
        assert_eq!(parts.iter().map(|(kind, _)| kind.clone()).collect::<Vec<_>>(), expected);
        assert_eq!(parts.iter().map(|(_, tokens)| tokens.len()).sum::<usize>(), tokens.len());
    }

    #[test]
    fn names_are_brought_by_trees() {
        let names = used(&tokens("pub use crate::a::{self, b::{C, D as E}, f::*, g};"));
        let expected = [
            ("a", vec!["crate", "a"]),
            ("C", vec!["crate", "a", "b", "C"]),
            ("E", vec!["crate", "a", "b", "D"]),
            ("*", vec!["crate", "a", "f"]),
            ("g", vec!["crate", "a", "g"]),
        ];
        assert_eq!(names, expected);
    }
}
