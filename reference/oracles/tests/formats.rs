//! The narrow formats against an independent soft-float, bit for bit.

use dashu_ratio::RBig;
use rustc_apfloat::ieee::{Double, IeeeFloat, Semantics};
use rustc_apfloat::{Float, FloatConvert, StatusAnd};
use saarcor_oracles::formats::{Format, Narrow};

const OPERATIONS: usize = 10_000;

/// 1-7-16 for the soft-float.
struct F24S;

impl Semantics for F24S {
    const BITS: usize = 24;
    const EXP_BITS: usize = 7;
}

/// Whole numbers, the same on every run (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Two numbers of the format: every bit at random, or of near exponents, or denormal.
    fn pair<S: Semantics>(&mut self) -> [u128; 2] {
        let mask = (1_u64 << S::BITS) - 1;
        let exponent = ((1_u64 << S::EXP_BITS) - 1) << (S::BITS - 1 - S::EXP_BITS);
        let (a, b, kind) = (self.next() & mask, self.next() & mask, self.next() % 4);
        let b = if kind == 0 { (a & exponent) | (b & !exponent) } else { b };
        let [a, b] = if kind == 1 { [a & !exponent, b] } else { [a, b] };
        [u128::from(a), u128::from(b)]
    }
}

fn to_f64<S: Semantics>(number: IeeeFloat<S>) -> f64 {
    let wide: StatusAnd<Double> = number.convert(&mut false);
    f64::from_bits(wide.value.to_bits() as u64)
}

fn from_f64<S: Semantics>(value: f64) -> IeeeFloat<S> {
    let narrow: StatusAnd<IeeeFloat<S>> = Double::from_bits(u128::from(value.to_bits())).convert(&mut false);
    narrow.value
}

fn same(ours: f64, theirs: f64) -> bool {
    ours.to_bits() == theirs.to_bits() || (ours.is_nan() && theirs.is_nan())
}

/// The four operations on 10 000 pairs each.
fn agrees<const E: u32, const M: u32, S: Semantics>() {
    type Ours<const E: u32, const M: u32> = fn(Narrow<E, M>, Narrow<E, M>) -> Narrow<E, M>;
    type Theirs<S> = fn(IeeeFloat<S>, IeeeFloat<S>) -> StatusAnd<IeeeFloat<S>>;
    let operations: [(&str, Ours<E, M>, Theirs<S>); 4] = [
        ("+", |a, b| a + b, |a, b| a + b),
        ("-", |a, b| a - b, |a, b| a - b),
        ("*", |a, b| a * b, |a, b| a * b),
        ("/", |a, b| a / b, |a, b| a / b),
    ];
    let mut random = Random(u64::from(E));
    for (name, ours, theirs) in operations {
        for _ in 0..OPERATIONS {
            let [a, b] = random.pair::<S>().map(IeeeFloat::<S>::from_bits);
            let [x, y] = [a, b].map(|number| {
                let value = to_f64(number);
                let narrow = Narrow::<E, M>::round(value);
                assert!(same(narrow.to_f64(), value), "{value:e} is a number of the format");
                narrow
            });
            let (ours, theirs) = (ours(x, y).to_f64(), to_f64(theirs(a, b).value));
            assert!(same(ours, theirs), "{x:?} {name} {y:?}: {ours:e}, not {theirs:e}");
        }
    }
}

/// Rounding of 10 000 f64 of the format's range and beyond.
fn rounds<const E: u32, const M: u32, S: Semantics>() {
    let mut random = Random(u64::from(M));
    for _ in 0..OPERATIONS {
        // An exponent from below the least denormal to above the greatest number.
        let exponent =
            1023 - (1 << (E - 1)) - u64::from(M) - 4 + random.next() % ((2 << E) + 2 * u64::from(M));
        let value = f64::from_bits((random.next() & !(0x7FF << 52)) | (exponent << 52));
        let (ours, theirs) = (Narrow::<E, M>::round(value).to_f64(), to_f64(from_f64::<S>(value)));
        assert!(same(ours, theirs), "{value:e}: {ours:e}, not {theirs:e}");
    }
}

/// The soft-float has no root: the number nearest to the root is the one between whose middles to
/// its neighbours, squared, the operand lies.
fn takes_roots<const E: u32, const M: u32, S: Semantics>() {
    let rational = |value: f64| RBig::try_from(value).expect("finite");
    let mut random = Random(1);
    for _ in 0..OPERATIONS {
        let operand = to_f64(IeeeFloat::<S>::from_bits(random.pair::<S>()[0])).abs();
        if !operand.is_finite() || operand == 0.0 {
            continue;
        }
        let root = Narrow::<E, M>::round(operand).sqrt().to_f64();
        let bits = from_f64::<S>(root).to_bits();
        let neighbour = |bits| rational(to_f64(IeeeFloat::<S>::from_bits(bits)));
        let middle = |other: RBig| (rational(root) + other) / RBig::from(2);
        let (below, above) = (middle(neighbour(bits - 1)), middle(neighbour(bits + 1)));
        let operand = rational(operand);
        assert!(&below * &below < operand && operand < &above * &above, "√{operand} is not {root:e}");
    }
}

mod f24 {
    use super::*;

    #[test]
    fn agrees_with_a_soft_float() {
        agrees::<7, 16, F24S>();
        rounds::<7, 16, F24S>();
        takes_roots::<7, 16, F24S>();
    }
}

mod bf16 {
    use super::*;
    use rustc_apfloat::ieee::BFloatS;

    #[test]
    fn agrees_with_a_soft_float() {
        agrees::<8, 7, BFloatS>();
        rounds::<8, 7, BFloatS>();
        takes_roots::<8, 7, BFloatS>();
    }
}

mod f16 {
    use super::*;
    use rustc_apfloat::ieee::HalfS;

    #[test]
    fn agrees_with_a_soft_float() {
        agrees::<5, 10, HalfS>();
        rounds::<5, 10, HalfS>();
        takes_roots::<5, 10, HalfS>();
    }
}
