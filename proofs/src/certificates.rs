//! Certificates of rounding errors: scripts for Gappa, made from the constants of the code.
//!
//! A certificate says of a bound that a decision hangs on the least constant, on a stated grid, with which Gappa proves it; `tests/certificates.rs`
//! runs Gappa on that constant, on the grid's next one below, which it does not prove, and compares it with the one in the
//! code, which no certificate repeats. The scripts are in `proofs/certificates`.
//!
//! Each operation rounds to its exact result times 1 + d, |d| ≤ u (the standard model: Higham 2002, §2.2), which
//! `roundoff_of_f32` and its like prove of Gappa's own formats; nothing underflows, but where a certificate speaks of that.

use saarcor_fast::adaptive::bounds;
use saarcor_model::rays::{SURFACE_OFFSET, UNDERFLOW, WIDENING};
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

/// A bound, and how Gappa proves it.
#[derive(Clone, Copy, Debug)]
pub struct Certificate {
    /// Its name.
    pub name: &'static str,
    /// The requirement that hangs on it.
    pub requirement: &'static str,
    /// What is proved, in one English sentence.
    pub says: &'static str,
    /// The file of the constant.
    pub file: &'static str,
    /// The constant in the code, in steps of the grid.
    pub constant: fn() -> f64,
    /// What a step of the grid is.
    pub step: &'static str,
    /// The least constant that Gappa proves, in steps.
    pub least: f64,
    /// Why the constant in the code is larger; empty where it is not.
    pub slack: &'static str,
    script: fn(f64) -> String,
}

impl Certificate {
    /// The script that states the bound with so many steps.
    #[must_use]
    pub fn script(&self, steps: f64) -> String {
        let Self { name, requirement, says, file, step, .. } = self;
        let head = format!("# {name} ({requirement}): {says}\n# Of {file}: {steps} steps of {step}.\n");
        head + &(self.script)(steps)
    }

    /// The grid's next constant below the least one.
    #[must_use]
    pub fn below(&self) -> f64 {
        // Numbers with a fraction are tenths.
        let whole = self.least.fract() == 0.0;
        if whole { self.least - 1.0 } else { (self.least * 10.0 - 1.0).round() / 10.0 }
    }

    /// What Gappa shows of the code's constant: that the least one is proved, and that the code's is no less. `None` where there
    /// is no Gappa.
    #[must_use]
    pub fn judge(&self) -> Option<bool> {
        let (proved, _) = gappa(&self.script(self.least))?;
        Some(proved && (self.constant)() >= self.least)
    }
}

/// Whether Gappa proves a script, and what it says of that. `None` where it does not run.
#[must_use]
pub fn gappa(script: &str) -> Option<(bool, String)> {
    let piped = || Stdio::piped();
    let mut gappa = Command::new("gappa").stdin(piped()).stdout(piped()).stderr(piped()).spawn().ok()?;
    gappa.stdin.take()?.write_all(script.as_bytes()).ok()?;
    let output = gappa.wait_with_output().ok()?;
    Some((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

const F32: &str = "0x1p-24";
const F64: &str = "0x1p-53";

/// A number as Gappa reads it, exactly.
fn exact(number: f64) -> String {
    let (bits, sign) = (number.to_bits(), if number < 0.0 { "-" } else { "" });
    let (exponent, mantissa) = ((bits >> 52 & 0x7ff) as i32 - 1075, bits & ((1 << 52) - 1) | 1 << 52);
    if number == 0.0 { "0".to_owned() } else { format!("{sign}0x{mantissa:x}p{exponent:+}") }
}

/// `|name| <= bound` of each name.
fn within(names: &[&str], bound: &str) -> String {
    names.iter().map(|name| format!("|{name}| <= {bound}")).collect::<Vec<_>>().join(" /\\ ")
}

/// Deltas of that many roundings, and the product of 1 + each.
fn chain(letter: char, count: u32) -> (Vec<String>, String) {
    let names: Vec<_> = (1..=count).map(|number| format!("{letter}{number}")).collect();
    let product = names.iter().map(|name| format!("(1 + {name})")).collect::<Vec<_>>().join(" * ");
    (names, product)
}

/// `count` roundings of f32 one after the other are within γ(`steps`).
fn gamma(count: u32, steps: f64) -> String {
    let (names, product) = chain('d', count);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let unit = 2.0_f64.powi(-24);
    // Rounded up: by less than a millionth of a step.
    let bound = exact((steps * unit / (1.0 - steps * unit)).next_up());
    format!("{{ {} -> |{product} - 1| <= {bound} }}\n", within(&names, F32))
}

/// ε, in which errors of the filter are counted.
fn epsilon() -> String {
    let least = (bounds::WORDS * bounds::NORMAL + bounds::ROUNDINGS) * bounds::UNIT;
    let most = bounds::WORDS * bounds::MOST_NU + 2.0_f64.powi(-40);
    format!("eps in [{}, {}]", exact(least), exact(most))
}

/// The largest word of the plane: a component over the largest, each off by ν.
fn largest_word() -> f64 {
    (1.0 + bounds::MOST_NU) / (1.0 - bounds::MOST_NU)
}

/// The largest `across` and height, with S = D = 1.
fn largest_sum() -> f64 {
    1.0 + 2.0 * largest_word()
}

/// What the plane's words are, exactly and as computed.
const PLANE: &str = "p0 = P0 + eps * x0;\np1 = P1 + eps * x1;\n";

/// What is known of them.
fn plane() -> String {
    let word = exact(largest_word().next_up());
    format!("{} /\\ |P0| <= {word} /\\ |P1| <= {word} /\\ |x0| <= 1 /\\ |x1| <= 1", epsilon())
}

/// A script with definitions, hypotheses, a goal and a hint.
fn script(definitions: &str, hypotheses: &[String], goal: &str, hint: &str) -> String {
    let mut script = format!("{definitions}{{ {}\n  -> {goal} }}\n", hypotheses.join("\n  /\\ "));
    if !hint.is_empty() {
        let _ = writeln!(script, "{hint} {{ eps <> 0 }};");
    }
    script
}

/// All certificates.
#[must_use]
pub fn certificates() -> &'static [Certificate] {
    CERTIFICATES
}

static CERTIFICATES: &[Certificate] = &[
    Certificate {
        name: "roundoff_of_f32",
        requirement: "IS-5",
        says: "An operation in f32 rounds to its exact result times 1 + d, |d| at most u = 2^-24, from 2^-125 on.",
        file: "reference/oracles/src/formats.rs",
        constant: || 1.0,
        step: "2^-24",
        least: 1.0,
        slack: "",
        script: |k| {
            format!(
                "@f32 = float<ieee_32, ne>;\n{{ |x| in [0x1p-125, 0x1p+127] -> |f32(x) -/ x| <= {} }}\n",
                exact(k * 2.0_f64.powi(-24))
            )
            .replace("|f32(x) -/ x|", "|(f32(x) - x) / x|")
        },
    },
    Certificate {
        name: "roundoff_of_f64",
        requirement: "IS-5",
        says: "An operation in f64 rounds to its exact result times 1 + d, |d| at most u = 2^-53, from 2^-1021 on.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::UNIT / 2.0_f64.powi(-53),
        step: "2^-53",
        least: 1.0,
        slack: "",
        script: |k| {
            format!(
                "@f64 = float<ieee_64, ne>;\n{{ |x| in [0x1p-1021, 0x1p+1023] -> |(f64(x) - x) / x| <= {} }}\n",
                exact(k * 2.0_f64.powi(-53))
            )
        },
    },
    Certificate {
        name: "distance_to_a_plane",
        requirement: "KD-3",
        says: "The distance to a plane is the true one times 1 + e, |e| at most γ(3), u = 2^-24.",
        file: "model/spec/src/rays/interval.rs",
        constant: || 3.0,
        step: "n of γ(n)",
        least: 3.0,
        slack: "",
        // The difference, the reciprocal, and their product.
        script: |n| gamma(3, n),
    },
    Certificate {
        name: "widening_relative",
        requirement: "KD-3",
        says: "A widened distance is beyond every f32 that is reported at 1 - 2u to 1 + 2u times the true one, to either side.",
        file: "model/spec/src/rays/interval.rs",
        constant: || (f64::from(WIDENING) / 2.0_f64.powi(-24)).floor(),
        step: "2^-24 / (1 - 3 2^-24), in f32",
        least: 5.0,
        slack: "2γ(3) needs no case by case: 1 + c is rounded to multiples of 2u, so that 5 steps give the same upper bound as 6.",
        // The last rounding keeps the order of what it rounds and of the hit, which is an f32: it takes nothing.
        script: |k| {
            let unit = 2.0_f32.powi(-24);
            let width = k as f32 * unit / (1.0 - 3.0 * unit);
            let (low, high) = (exact((1.0 - width).into()), exact((1.0 + width).into()));
            let product = "(1 + d1) * (1 + d2) * (1 + d3)";
            let goal = format!("{product} * {low} <= 0x0.fffffep+0 /\\ {product} * {high} >= 0x1.000002p+0");
            script("", &[within(&["d1", "d2", "d3"], F32)], &goal, "")
        },
    },
    Certificate {
        name: "widening_absolute",
        requirement: "KD-3",
        says: "Where distances underflow, the width makes up for the roundings of the distance, of the widening and of the hit, half of 2^-149 each.",
        file: "model/spec/src/rays/interval.rs",
        constant: || f64::from(UNDERFLOW) / f64::from(f32::from_bits(1)),
        step: "2^-149",
        least: 2.0,
        slack: "",
        script: |k| {
            let width = exact(k * 2.0_f64.powi(-149));
            let goal = format!("a * 0x1.00000cp+0 + b + c + {width} >= 0");
            script("", &[within(&["a", "b", "c"], "0x1p-150")], &goal, "")
        },
    },
    Certificate {
        name: "normal_component",
        requirement: "IS-3",
        says: "A component of the normal, a difference of two products with their errors added, is off by so much of itself, beside what it is of the products.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::NORMAL,
        step: "u, 2^-53",
        least: 3.0,
        slack: "",
        // ((l - r)(1 + a) + (l' - r')(1 + b))(1 + c), where l + l' and r + r' are the products: all of it has a and c.
        script: |k| {
            let goal = format!("|(1 + a) * (1 + c) - 1| <= {}", exact(k * bounds::UNIT));
            script("", &[within(&["a", "c"], F64)], &goal, "")
        },
    },
    Certificate {
        name: "normal_exact_edges",
        requirement: "IS-3",
        says: "With exact edges, it is off by so much of the sum of both products without signs.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::EXACT_EDGES,
        step: "u², u = 2^-53",
        least: 3.0,
        slack: "A power of two takes no rounding.",
        // l' - r', at most u of that sum, has b in the place of a.
        script: |k| {
            let goal = format!("|y * ((b - a) * (1 + c))| <= {}", exact(k * bounds::UNIT));
            script("", &[within(&["a", "b", "c"], F64), within(&["y"], "1")], &goal, "")
        },
    },
    Certificate {
        name: "normal_rounded_edges",
        requirement: "IS-3",
        says: "With edges that are rounded, it is off by so much of the sum of both products without signs.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::ROUNDED_EDGES,
        step: "u, 2^-53",
        least: 3.0,
        slack: "A power of two takes no rounding.",
        // Two edges in each product, and what exact edges leave; of the component itself, which is larger by as much.
        script: |k| {
            let goal = format!(
                "|(1 + e) * (1 + f) - 1| * (1 + 0x3p-53) + {} <= {}",
                exact(bounds::EXACT_EDGES * bounds::UNIT * bounds::UNIT * 2.0),
                exact(k * bounds::UNIT)
            );
            script("", &[within(&["e", "f"], F64)], &goal, "")
        },
    },
    Certificate {
        name: "words_of_the_plane",
        requirement: "IS-3",
        says: "A word of the plane is off by so many ν, and the rounding of the quotient.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::WORDS * 2.0,
        step: "ν / 2",
        least: 5.0,
        slack: "",
        script: |k| {
            let known = [
                format!("nu in [0, {}]", exact(bounds::MOST_NU)),
                format!("|P| <= {}", exact(largest_word().next_up())),
                within(&["x", "y"], "1"),
                within(&["d"], F64),
            ];
            script("", &known, &format!("|(x - P * y) / (1 + nu * y) * (1 + d)| <= {}", exact(k / 2.0)), "")
        },
    },
    Certificate {
        name: "words_of_the_weights",
        requirement: "IS-3",
        says: "A word of the weights, a rounded edge over a component of the normal, is off by so many ν of itself.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::WORDS * 2.0,
        step: "ν / 2",
        least: 4.0,
        slack: "Words of the plane need more.",
        script: |k| {
            let (least, most) = (bounds::NORMAL * bounds::UNIT, bounds::MOST_NU);
            let known = [
                format!("eps in [{}, {}]", exact(least), exact(most)),
                within(&["y"], "1"),
                within(&["a", "b"], F64),
            ];
            let error = "((1 + a) * (1 + b) / (1 + eps * y) - 1) / eps";
            let hint = format!("{error} -> (((1 + a) * (1 + b) - 1) / eps - y) / (1 + eps * y)");
            script("", &known, &format!("|{error}| <= {}", exact(k / 2.0)), &hint)
        },
    },
    Certificate {
        name: "roundings_within_epsilon",
        requirement: "IS-3",
        says: "Three times three roundings are within ε, of which this is the part beside ν.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::ROUNDINGS,
        step: "u, 2^-53",
        least: 2.0,
        slack: "",
        script: |k| {
            let bound = exact((bounds::WORDS * bounds::NORMAL + k) * bounds::UNIT);
            let goal = format!("3 * |(1 + a) * (1 + b) * (1 + c) - 1| <= {bound}");
            script("", &[within(&["a", "b", "c"], F64)], &goal, "")
        },
    },
    Certificate {
        name: "across_of_the_filter",
        requirement: "IS-3",
        says: "The direction's component across the plane is off by so many ε D.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::ACROSS,
        step: "ε D",
        least: 2.9,
        slack: "",
        script: |k| {
            let definitions = format!(
                "{PLANE}A = d0 + (P0 * d1 + P1 * d2);\n\
                 a = (d0 + (p0 * d1 * (1 + r1) + p1 * d2 * (1 + r2)) * (1 + r3)) * (1 + r4);\n"
            );
            let known = [plane(), within(&["d0", "d1", "d2"], "1"), within(&["r1", "r2", "r3", "r4"], F64)];
            let hint = "(a - A) / eps -> d0 * (r4 / eps) + P0 * d1 * (((1 + r1) * (1 + r3) * (1 + r4) - 1) / eps) \
                        + x0 * d1 * ((1 + r1) * (1 + r3) * (1 + r4)) + P1 * d2 * (((1 + r2) * (1 + r3) * (1 + r4) - 1) / eps) \
                        + x1 * d2 * ((1 + r2) * (1 + r3) * (1 + r4))";
            script(&definitions, &known, &format!("|(a - A) / eps| <= {}", exact(k)), hint)
        },
    },
    Certificate {
        name: "height_of_the_filter",
        requirement: "IS-3",
        says: "The origin's height over the plane is off by so many ε S.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::HEIGHT,
        step: "ε S",
        least: 3.2,
        slack: "",
        script: |k| {
            let definitions = format!(
                "{PLANE}H = f0 + (P0 * f1 + P1 * f2);\n\
                 h = (f0 * (1 + s0) + (p0 * (f1 * (1 + s1)) * (1 + r1) + p1 * (f2 * (1 + s2)) * (1 + r2)) * (1 + r3)) * (1 + r4);\n"
            );
            let known = [
                plane(),
                within(&["f0", "f1", "f2"], "1"),
                within(&["s0", "s1", "s2", "r1", "r2", "r3", "r4"], F64),
            ];
            let hint = "(h - H) / eps -> f0 * (((1 + s0) * (1 + r4) - 1) / eps) \
                        + P0 * f1 * (((1 + s1) * (1 + r1) * (1 + r3) * (1 + r4) - 1) / eps) + x0 * f1 * ((1 + s1) * (1 + r1) * (1 + r3) * (1 + r4)) \
                        + P1 * f2 * (((1 + s2) * (1 + r2) * (1 + r3) * (1 + r4) - 1) / eps) + x1 * f2 * ((1 + s2) * (1 + r2) * (1 + r3) * (1 + r4))";
            script(&definitions, &known, &format!("|(h - H) / eps| <= {}", exact(k)), hint)
        },
    },
    Certificate {
        name: "point_of_the_filter",
        requirement: "IS-3",
        says: "A coordinate of the point, times across, is off by so many ε S D.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::POINT,
        step: "ε S D",
        least: 7.9,
        slack: "",
        script: |k| {
            let definitions = "a = A + eps * ea;\nh = H + eps * eh;\nX = f * A - H * d;\n\
                               x = (f * (1 + s) * a * (1 + r1) - h * d * (1 + r2)) * (1 + r3);\n";
            let sum = exact(largest_sum().next_up());
            let known = [
                epsilon(),
                within(&["f", "d"], "1"),
                within(&["A", "H"], &sum),
                within(&["ea"], &exact(bounds::ACROSS)),
                within(&["eh"], &exact(bounds::HEIGHT)),
                within(&["s", "r1", "r2", "r3"], F64),
            ];
            let hint = "(x - X) / eps -> f * A * (((1 + s) * (1 + r1) * (1 + r3) - 1) / eps) + f * ea * ((1 + s) * (1 + r1) * (1 + r3)) \
                        - H * d * (((1 + r2) * (1 + r3) - 1) / eps) - eh * d * ((1 + r2) * (1 + r3))";
            script(definitions, &known, &format!("|(x - X) / eps| <= {}", exact(k)), hint)
        },
    },
    Certificate {
        name: "weight_of_the_filter",
        requirement: "IS-3",
        says: "The weight of the second or the third corner, times across, is off by so many L ε S D.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::WEIGHT,
        step: "L ε S D",
        least: 32.0,
        slack: "",
        script: |k| {
            let definitions = "vx = W0 * (1 + eps * q0);\nvy = W1 * (1 + eps * q1);\nx = X + eps * ex;\ny = Y + eps * ey;\n\
                               w = (vx * x * (1 + r1) + vy * y * (1 + r2)) * (1 + r3);\nT = W0 * X + W1 * Y;\n";
            let known = [
                epsilon(),
                within(&["W0", "W1"], "1"),
                within(&["X", "Y"], &exact(2.0 * largest_sum().next_up())),
                within(&["ex", "ey"], &exact(bounds::POINT)),
                within(&["q0", "q1"], "1"),
                within(&["r1", "r2", "r3"], F64),
            ];
            let hint = "(w - T) / eps -> W0 * X * (((1 + r1) * (1 + r3) - 1) / eps) + W0 * ((1 + r1) * (1 + r3)) * (ex * (1 + eps * q0) + q0 * X) \
                        + W1 * Y * (((1 + r2) * (1 + r3) - 1) / eps) + W1 * ((1 + r2) * (1 + r3)) * (ey * (1 + eps * q1) + q1 * Y)";
            script(definitions, &known, &format!("|(w - T) / eps| <= {}", exact(k)), hint)
        },
    },
    Certificate {
        name: "third_weight_of_the_filter",
        requirement: "IS-3",
        says: "Of the third weight, what comes from the other two is off by so many L ε S D.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::THIRD,
        step: "L ε S D",
        least: 69.0,
        slack: "",
        script: |k| {
            let weight = exact(4.0 * largest_sum().next_up());
            let known = [
                epsilon(),
                within(&["U", "V"], &weight),
                within(&["eu", "ev"], &exact(bounds::WEIGHT)),
                within(&["r1", "r2"], F64),
            ];
            let error = "(u * (1 + r1) * (1 + r2) + v * (1 + r2) - (U + V)) / eps";
            let hint = format!(
                "{error} -> U * (((1 + r1) * (1 + r2) - 1) / eps) + eu * ((1 + r1) * (1 + r2)) + V * (r2 / eps) + ev * (1 + r2)"
            );
            script(
                "u = U + eps * eu;\nv = V + eps * ev;\n",
                &known,
                &format!("|{error}| <= {}", exact(k)),
                &hint,
            )
        },
    },
    Certificate {
        name: "third_weight_across",
        requirement: "IS-3",
        says: "Of the third weight, what comes from across is off by so many ε D.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::THIRD_ACROSS,
        step: "ε D",
        least: 3.6,
        slack: "",
        script: |k| {
            let known = [
                epsilon(),
                within(&["A"], &exact(largest_sum().next_up())),
                within(&["ea"], &exact(bounds::ACROSS)),
                within(&["r1", "r2"], F64),
            ];
            let error = "(a * (1 + r1) * (1 + r2) - A) / eps";
            let hint =
                format!("{error} -> A * (((1 + r1) * (1 + r2) - 1) / eps) + ea * ((1 + r1) * (1 + r2))");
            script("a = A + eps * ea;\n", &known, &format!("|{error}| <= {}", exact(k)), &hint)
        },
    },
    Certificate {
        name: "margin_of_the_filter",
        requirement: "IS-3",
        says: "E, as computed with eight roundings, is no less than the error of any weight.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::MARGIN,
        step: "L ε D (S + 1/(8 L))",
        least: 70.0,
        slack: "",
        script: |k| {
            let (names, product) = chain('d', 8);
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let goal = format!(
                "{k} * ({product}) >= {} /\\ {k} * 0.125 * ({product}) >= {}",
                exact(bounds::THIRD),
                exact(bounds::THIRD_ACROSS)
            );
            script("", &[within(&names, F64)], &goal, "")
        },
    },
    Certificate {
        name: "distance_of_the_filter",
        requirement: "IS-3",
        says: "Inside, the distance is off by so many ε (S + |t| D) / |across|, as computed.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::DISTANCE,
        step: "ε (S + |t| D) / |across|",
        least: 5.0,
        slack: "",
        // g is ε D / |across|, of which three weights beyond E make less than 8 / (3 MARGIN); q is |height| / S.
        script: |k| {
            let (names, product) = chain('k', 4);
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let most = largest_sum() + bounds::HEIGHT * (bounds::WORDS * bounds::MOST_NU);
            let known = [
                epsilon(),
                format!("|eh| <= {}", exact(bounds::HEIGHT)),
                format!("|ea| <= {}", exact(bounds::ACROSS)),
                format!("g in [0, {}]", exact(8.0 / (3.0 * bounds::MARGIN) * 1.01)),
                format!("q in [0, {}]", exact(most * 1.01)),
                within(&["r1", "r2"], F64),
                within(&names, F64),
            ];
            let bound = exact(k);
            let goal = format!(
                "(|eh| / (1 - |ea| * g) + q * (|(1 + r1) * (1 + r2) - 1| / eps)) / ({product}) <= {bound}\n  /\\ |ea| / (1 - |ea| * g) / ({product}) <= {bound}"
            );
            script("", &known, &goal, "")
        },
    },
    Certificate {
        name: "distance_of_exact_volumes",
        requirement: "IS-3",
        says: "A quotient of two numbers, of which each and itself are rounded once, is off by so many u of itself as computed.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::QUOTIENT,
        step: "u, 2^-53",
        least: 4.0,
        slack: "",
        script: |k| {
            let quotient = "(1 + a) * (1 + c) / (1 + b)";
            let goal = format!("|{quotient} - 1| / ({quotient}) <= {}", exact(k * bounds::UNIT));
            script("", &[within(&["a", "b", "c"], F64)], &goal, "")
        },
    },
    Certificate {
        name: "slope_of_an_owned_edge",
        requirement: "IS-6",
        says: "A slope of a weight, the difference of two products with rounded differences, is off by so many u of their sum without signs, as computed.",
        file: "model/fast/src/adaptive/bounds.rs",
        constant: || bounds::SLOPE,
        step: "u, 2^-53",
        least: 4.0,
        slack: "",
        // Of each product: its difference, itself, and the last one; over that sum, which is rounded too.
        script: |k| {
            let goal = format!(
                "|(1 + a) * (1 + b) * (1 + f) - 1| / ((1 + a) * (1 + b) * (1 + g)) <= {}",
                exact(k * bounds::UNIT)
            );
            script("", &[within(&["a", "b", "f", "g"], F64)], &goal, "")
        },
    },
    Certificate {
        name: "moller_trumbore_numerator",
        requirement: "IS-3",
        says: "The numerator of t is off by γ(n) of its terms without signs: three differences, the products, and the sums.",
        file: "model/spec/src/rays/intersection/moller_trumbore.rs",
        constant: || 8.0,
        step: "n of γ(n), u = 2^-24",
        least: 8.0,
        slack: "",
        script: |n| gamma(3 + 2 + 3, n),
    },
    Certificate {
        name: "plucker_height",
        requirement: "IS-3",
        says: "The height is off by γ(n) of its terms without signs: a corner once, two edges of moved corners twice each, the products, and the sums.",
        file: "model/spec/src/rays/intersection/plucker.rs",
        constant: || 10.0,
        step: "n of γ(n), u = 2^-24",
        least: 10.0,
        slack: "",
        script: |n| gamma(1 + 2 + 2 + 2 + 3, n),
    },
    Certificate {
        name: "wald_divisor",
        requirement: "IS-3",
        says: "The divisor of t is off by γ(n) of its terms without signs: a word, its product, and two sums.",
        file: "model/spec/src/rays/intersection/wald.rs",
        constant: || 4.0,
        step: "n of γ(n), u = 2^-24",
        least: 4.0,
        slack: "",
        script: |n| gamma(1 + 1 + 2, n),
    },
    Certificate {
        name: "watertight_shear",
        requirement: "IS-1",
        says: "A sheared coordinate is off by γ(n) of its terms without signs: a difference, the quotient, their product, and the subtraction.",
        file: "model/spec/src/rays/intersection/watertight.rs",
        constant: || 4.0,
        step: "n of γ(n), u = 2^-24",
        least: 4.0,
        slack: "",
        script: |n| gamma(1 + 1 + 1 + 1, n),
    },
    Certificate {
        name: "offset_of_rays_from_surfaces",
        requirement: "RG-3",
        says: "A ray from a point at an f32 distance within 2u of the true one begins beyond the plane of its surface, on the side to which it goes.",
        file: "model/spec/src/rays/camera.rs",
        constant: || f64::from(SURFACE_OFFSET) / 2.0_f64.powi(-24),
        step: "u c, u = 2^-24, c the largest coordinate",
        least: 14.0,
        slack: "The default test, Möller and Trumbore's, finds distances whose error grows as a triangle is thin: `accuracy --suite shadow` judges it.",
        script: offset,
    },
];

/// The offset k u, with c = 1: the point o + t d with |o|, |point| ≤ 1, so that |t d| ≤ 2 along each axis, t off by 2u, product and sum
/// rounded; the normal off by 4u, of length 1 within that; the offset's product and sum rounded. The sum over three axes, as the
/// components of a unit vector add up to 1.7321 at most.
fn offset(k: f64) -> String {
    let known = [
        within(&["w"], "2"),
        within(&["p"], "1"),
        within(&["t"], "0x2p-24"),
        within(&["r1", "r2", "r3", "r4"], F32),
        format!("m in [{}, {}]", exact(1.0 - 8.0 * 2.0_f64.powi(-24)), exact(1.0 + 8.0 * 2.0_f64.powi(-24))),
    ];
    let off = exact(k * 2.0_f64.powi(-24));
    // How far off the plane the point lies along an axis, and what the offset is short of k u m.
    let point = "(|w| * |(1 + t) * (1 + r1) - 1| + |p| * |r2|)";
    let beginning = format!("(|p| + {off}) * |r4| + {off} * |r3|");
    let goal = format!("1.7321 * ({point} + {beginning}) - {off} * m <= 0");
    script("", &known, &goal, "")
}
