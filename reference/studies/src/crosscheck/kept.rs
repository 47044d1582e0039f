//! Interesting rays as text, to be asked again.
//!
//! A row a ray: class, kind, three coordinates of the origin, three components of the direction,
//! and the distance at which it ends. Numbers are the shortest decimals that read back as the same
//! f32. `#` begins a comment.

use super::judge::{Class, JudgedRay};
use super::rays::{Question, RayKind};
use crate::error::StudyError;
use glam::Vec3;
use saarcor_model::rays::Ray;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The rays on which not all agree, as text: of each class the first `most`. `command` says how
/// they are asked again.
#[must_use]
pub fn to_text(cases: &[JudgedRay], most: usize, command: &str) -> String {
    let mut text = format!("# Asked again by: {command}\n# class, kind, origin, direction, end of the ray\n");
    let mut counts = BTreeMap::<&str, usize>::new();
    for case in cases.iter().filter(|case| case.class != Class::Agree) {
        let count = counts.entry(case.class.name()).or_default();
        *count += 1;
        if *count <= most {
            let Question { kind, ray: Ray { origin: o, direction: d, t_max, .. } } = case.question;
            let (class, kind) = (case.class.name(), kind.name());
            let _ = writeln!(text, "{class} {kind} {} {} {} {} {} {} {t_max}", o.x, o.y, o.z, d.x, d.y, d.z);
        }
    }
    text
}

/// The rays of such a text. `name` is the file's, for errors.
///
/// # Errors
/// The first row that is not a ray, and the form of a right one.
pub fn from_text(text: &str, name: &str) -> Result<Vec<Question>, StudyError> {
    let rows = (1..).zip(text.lines()).map(|(number, line)| (number, line.split('#').next().unwrap_or("")));
    let rows = rows.filter(|(_, line)| !line.trim().is_empty());
    let error = |line, why| StudyError::BadRay { file: name.to_owned(), line, why };
    rows.map(|(number, line)| question(line).map_err(|why| error(number, why))).collect()
}

/// The ray of a row, or what is wrong with the row and would be right.
fn question(line: &str) -> Result<Question, String> {
    let fields: Vec<_> = line.split_whitespace().collect();
    let [_, kind, numbers @ ..] = &fields[..] else {
        return Err("write class, kind and seven numbers".to_owned());
    };
    let known = RayKind::ALL.into_iter().find(|known| known.name() == *kind);
    let kind = known.ok_or_else(|| {
        format!("no such kind of ray: write one of {}", RayKind::ALL.map(RayKind::name).join(", "))
    })?;
    let number = |text: &&str| text.parse().map_err(|error| format!("'{text}' is no number: {error}"));
    let numbers: Vec<f32> = numbers.iter().map(number).collect::<Result<_, _>>()?;
    let [a, b, c, d, e, f, t_max] = numbers[..] else {
        let count = numbers.len();
        return Err(format!(
            "{count} numbers: write three of the origin, three of the direction and the end"
        ));
    };
    if !numbers[..6].iter().all(|number| number.is_finite()) || t_max.is_nan() || t_max < 0.0 {
        return Err("origin and direction must be finite, and the end of the ray at least 0".to_owned());
    }
    let (origin, direction) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
    Ok(Question { kind, ray: Ray { origin, direction, t_min: 0.0, t_max } })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crosscheck::judge::Answers;
    use std::sync::Arc;

    fn case(class: Class, ray: Ray) -> JudgedRay {
        let answers = Answers { model: None, any: false, robust: None, fast: None };
        let question = Question { kind: RayKind::Aimed, ray };
        let copies = Arc::default();
        JudgedRay { question, answers, truth: None, copies, class, model: None, robust: None, fast: None }
    }

    #[test]
    fn rays_read_back_bit_for_bit() {
        let ray = Ray {
            origin: Vec3::new(0.1, -1e-40, f32::MAX),
            direction: Vec3::new(-0.0, 1.0 / 3.0, 1e-20),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        let classes = [Class::Tie, Class::Agree, Class::Tie, Class::Edge, Class::Tie];
        let text = to_text(&classes.map(|class| case(class, ray)), 2, "again");
        let read = from_text(&text, "file").expect("readable");
        assert_eq!(read.len(), 3, "two ties and an edge: {text}");
        let bits =
            |ray: Ray| (ray.origin.to_array().map(f32::to_bits), ray.direction.to_array().map(f32::to_bits));
        for question in read {
            assert_eq!((bits(question.ray), question.ray.t_max), (bits(ray), f32::INFINITY));
        }
    }

    #[test]
    fn what_is_no_ray_is_refused_with_its_place() {
        for (line, says) in [
            ("tie", "seven numbers"),
            ("tie sideways 0 0 0 0 0 1 1", "primary"),
            ("tie aimed 0 0 0 0 0 1", "6 numbers"),
            ("tie aimed 0 0 x 0 0 1 1", "'x'"),
            ("tie aimed 0 0 inf 0 0 1 1", "finite"),
            ("tie aimed 0 0 0 0 0 1 NaN", "at least 0"),
        ] {
            let error = from_text(&format!("# rays\n\n{line}\n"), "f").expect_err(line).to_string();
            assert!(error.starts_with("f:3: ") && error.contains(says), "{error}");
        }
    }
}
