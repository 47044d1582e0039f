//! The certificates of rounding errors: Gappa proves each with its least constant, not with the next one below, and the code's is no less.

use glam::Vec3;
use saarcor_model::rays::{
    Candidate, EdgeTriangle, Number, PluckerTriangle, ProjectedTriangle, TriangleTest, WatertightTriangle,
};
use saarcor_proofs::certificates::{Certificate, certificates, gappa};
use std::cmp::Ordering;
use std::fs;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::path::PathBuf;

fn path(certificate: &Certificate) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/certificates"))
        .join(format!("{}.g", certificate.name))
}

/// The constants of the code are held to the least ones, with Gappa or without.
#[test]
fn constants_of_the_code_are_no_less_than_what_is_proved() {
    for certificate in certificates() {
        let Certificate { name, least, slack, file, step, .. } = *certificate;
        let constant = (certificate.constant)();
        assert!(constant >= least, "{name}: {file} has {constant} steps of {step}, and {least} are proved");
        assert_eq!(
            constant > least,
            !slack.is_empty(),
            "{name}: {constant} steps, of which {least} are proved: {slack}"
        );
    }
    assert!(certificates().len() >= 12);
}

/// With `SAARCOR_WRITE_LISTS` set the scripts are written.
#[test]
fn scripts_are_those_of_the_code() {
    for certificate in certificates() {
        let (path, script) = (path(certificate), certificate.script(certificate.least));
        if std::env::var_os("SAARCOR_WRITE_LISTS").is_some() {
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, script).expect("the script again");
        } else {
            let kept = fs::read_to_string(&path).unwrap_or_default();
            assert!(
                kept == script,
                "{} is old: SAARCOR_WRITE_LISTS=1 cargo test -p saarcor-proofs --test certificates",
                path.display()
            );
        }
    }
    let kept = fs::read_dir(path(&certificates()[0]).parent().expect("a folder")).expect("a folder").count();
    assert_eq!(kept, certificates().len(), "a script without a certificate");
}

/// No constant is repeated here: scripts are made from those of the code.
#[test]
fn gappa_proves_the_constants_of_the_code() {
    for certificate in certificates() {
        let script = certificate.script((certificate.constant)());
        let Some((proved, said)) = gappa(&script) else {
            println!("not run: there is no gappa (Debian's package of that name)");
            return;
        };
        assert!(proved, "{} of {} is not proved: {said}\n{script}", certificate.name, certificate.file);
    }
}

#[test]
fn gappa_proves_the_least_constants_and_none_below() {
    if gappa("{ 0 <= 1 }\n").is_none() {
        println!("not run: there is no gappa (Debian's package of that name)");
        return;
    }
    for certificate in certificates() {
        let Certificate { name, least, .. } = *certificate;
        let (proved, said) = gappa(&certificate.script(least)).expect("Gappa");
        assert!(proved && !said.contains("hint"), "{name}: {least} steps are not proved: {said}");
        let below = certificate.below();
        let (proved, said) = gappa(&certificate.script(below)).expect("Gappa");
        assert!(
            !proved && said.contains("properties were not satisfied"),
            "{name}: {below} steps are proved, too: {said}"
        );
    }
}

/// A number that counts the roundings behind it, of its numerator and of its divisor, along the longest way.
#[derive(Clone, Copy, Debug)]
struct Counted {
    value: f64,
    above: u32,
    below: u32,
}

impl Counted {
    fn exact(value: f64) -> Self {
        Self { value, above: 0, below: 0 }
    }
}

impl PartialEq for Counted {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Counted {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

macro_rules! counted {
    ($($operation:ident :: $function:ident, |$a:ident, $b:ident| ($above:expr, $below:expr);)*) => {$(
        #[allow(clippy::suspicious_arithmetic_impl, reason = "roundings of factors add up")]
        impl $operation for Counted {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                Self { value: $a.value.$function($b.value), above: $above + 1, below: $below }
            }
        }
    )*};
}

counted! {
    Add::add, |a, b| (a.above.max(b.above), a.below.max(b.below));
    Sub::sub, |a, b| (a.above.max(b.above), a.below.max(b.below));
    Mul::mul, |a, b| (a.above + b.above, a.below + b.below);
    Div::div, |a, b| (a.above + b.below, a.below + b.above);
}

impl Neg for Counted {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl Number for Counted {
    const ZERO: Self = Self { value: 0.0, above: 0, below: 0 };
    const ONE: Self = Self { value: 1.0, above: 0, below: 0 };

    fn from_f32(value: f32) -> Self {
        Self::exact(value.into())
    }

    /// A word that the driver rounds.
    fn from_f64(value: f64) -> Self {
        Self { above: 1, ..Self::exact(value) }
    }

    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }

    fn is_finite(self) -> bool {
        self.value.is_finite()
    }

    fn product_order(a: Self, b: Self, c: Self, d: Self) -> Ordering {
        (a * b).partial_cmp(&(c * d)).unwrap_or(Ordering::Equal)
    }
}

/// Roundings of a test's distance, of its numerator and of its divisor, and those of the second weight.
fn roundings<T: TriangleTest<Counted>>() -> [u32; 4] {
    let corners = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 2.5, 3.5), Vec3::new(2.0, 7.0, 4.0)];
    let ray = T::ray([0.5, 0.25, -1.0], [0.5, 0.75, 1.5]);
    let Candidate { t, u, .. } = T::new(&corners).intersect::<false>(&ray);
    [t.above, t.below, u.above, u.below]
}

/// The roundings that certificates of the tests count are those of their code.
#[test]
fn roundings_are_those_of_the_code() {
    let least = |name| certificates().iter().find(|it| it.name == name).expect("a certificate").least as u32;
    // A reciprocal and its product beside the numerator; the divisor has two edges less behind it.
    let numerator = least("moller_trumbore_numerator");
    assert_eq!(
        roundings::<EdgeTriangle<Counted>>(),
        [numerator + 2, numerator - 1, numerator - 1 + 2, numerator - 1]
    );
    // A quotient.
    let [above, below, ..] = roundings::<PluckerTriangle<Counted>>();
    assert_eq!([above, below], [least("plucker_height") + 1, least("plucker_height") - 1]);
    let [_, divisor, ..] = roundings::<ProjectedTriangle<Counted>>();
    assert_eq!(divisor, least("wald_divisor"));
    // Of two sheared coordinates, which are multiplied and subtracted; and the sum of three of these.
    let edge = 2 * least("watertight_shear") + 2;
    let [.., above, below] = roundings::<WatertightTriangle<Counted>>();
    assert_eq!([above, below], [edge + 2, edge + 2]);
}
