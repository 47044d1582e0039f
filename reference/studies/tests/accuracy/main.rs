//! Triangle tests and number formats on the hard suites: what must hold of each.

use glam::Vec3;
use saarcor_fast::adaptive::{AdaptiveRay, AdaptiveTriangle};
use saarcor_model::host::{Edges, Kernel, Projection};
use saarcor_model::rays::{
    EdgeTriangle, Number, PluckerTriangle, ProjectedTriangle, TriangleTest, WatertightTriangle,
};
use saarcor_oracles::bounded::Bounded;
use saarcor_oracles::formats::{self, Bf16, Double, F16, F24};
use saarcor_studies::accuracy::case::{Case, Truth};
use saarcor_studies::accuracy::contest::{Contestant, Format};
use saarcor_studies::accuracy::measure::{AccuracyRow, MeasureOptions, measure};
use saarcor_studies::accuracy::suites::{SUITES, Suite};
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

/// Cases a suite, by default and in the long tests.
const FEW: u64 = 2_000;
const MANY: u64 = 100_000;

fn rows(suite: &'static Suite, kernel: Kernel, format: Format, seed: u64, cases: u64) -> AccuracyRow {
    rows_by(Edges::Shared, suite, kernel, format, seed, cases)
}

fn rows_by(
    edges: Edges,
    suite: &'static Suite,
    kernel: Kernel,
    format: Format,
    seed: u64,
    cases: u64,
) -> AccuracyRow {
    let extent = MeasureOptions { seed, cases, repeats: 1, edges };
    measure(suite, &[Contestant { kernel, format }], extent, &|_| {}).remove(0)
}

fn adaptive_is_never_wrong(seed: u64, cases: u64) {
    for (suite, edges) in
        SUITES.iter().flat_map(|suite| [Edges::Shared, Edges::Owned].map(|edges| (suite, edges)))
    {
        let row = rows_by(edges, suite, Kernel::Adaptive, Format::F32, seed, cases);
        assert_eq!(
            (row.wrong_hit, row.wrong_miss, row.wrong_triangle, row.leaks),
            (0, 0, 0, 0),
            "{}",
            row.suite
        );
        // Rounded once to f32, from a bound far below an ulp but for rays that graze.
        let most = if suite.name == "grazing" { 1.0 } else { 0.51 };
        assert!(row.t_ulp_max <= most, "{}: t off by {} ulp", row.suite, row.t_ulp_max);
    }
}

#[test]
fn adaptive_is_never_wrong_whatever_the_seed() {
    for seed in [1, 2003, u64::MAX] {
        adaptive_is_never_wrong(seed, FEW);
    }
}

#[test]
#[ignore = "long: two million exact verdicts"]
fn adaptive_is_never_wrong_in_long_runs() {
    adaptive_is_never_wrong(77, MANY);
}

fn watertight_does_not_leak(cases: u64) {
    for suite in SUITES.iter().filter(|suite| suite.closed) {
        for format in Format::ALL {
            for edges in [Edges::Shared, Edges::Owned] {
                let row = rows_by(edges, suite, Kernel::Watertight, format, 1, cases);
                assert_eq!(row.leaks, 0, "{} {} {}", row.suite, row.format, row.edges);
            }
        }
    }
}

#[test]
fn watertight_does_not_leak_on_closed_meshes() {
    watertight_does_not_leak(10 * FEW);
}

#[test]
#[ignore = "long: eight hundred thousand rays"]
fn watertight_does_not_leak_in_long_runs() {
    watertight_does_not_leak(MANY);
}

/// The suites see a fault where there is one.
#[test]
fn tests_that_round_leak_and_err() {
    let leaks = |kernel| -> u64 {
        let closed = SUITES.iter().filter(|suite| suite.closed);
        closed.map(|suite| rows(suite, kernel, Format::F32, 1, FEW).leaks).sum()
    };
    assert!(leaks(Kernel::MollerTrumbore) > 0 && leaks(Kernel::Wald) > 0);
    for kernel in [Kernel::MollerTrumbore, Kernel::Wald, Kernel::Plucker, Kernel::Watertight] {
        let wrong: u64 = SUITES.iter().map(|suite| rows(suite, kernel, Format::F32, 1, FEW).wrong()).sum();
        assert!(wrong > 0, "{kernel:?}");
    }
}

/// What the watertight test would be if a multiplication were fused with the subtraction in its edge
/// functions, or with zero left to itself: the sheared corners of the model, from a ray along z.
mod fused {
    use super::*;

    /// Whether the origin is inside a triangle in the plane, by edge functions that `edge` computes.
    fn is_inside(corners: &[[f32; 2]; 3], edge: fn([f32; 2], [f32; 2]) -> f32) -> bool {
        let [a, b, c] = *corners;
        let sides = [edge(c, b), edge(a, c), edge(b, a)];
        !(sides.iter().any(|&side| side < 0.0) && sides.iter().any(|&side| side > 0.0))
    }

    fn rounded(p: [f32; 2], q: [f32; 2]) -> f32 {
        p[0] * q[1] - p[1] * q[0]
    }

    fn fused(p: [f32; 2], q: [f32; 2]) -> f32 {
        p[0].mul_add(q[1], -(p[1] * q[0]))
    }

    /// Rays through the edges of a fan, sheared: some leave it once a product is not rounded.
    #[test]
    fn multiply_add_would_be_seen() {
        let suite = Suite::named("sphere").expect("there");
        let (mut lost, mut lost_when_fused, mut exactly_zero) = (0, 0, 0);
        for number in 0..50_000 {
            let case = suite.case(1, number);
            let direction = case.ray.direction;
            let axis = direction.abs().max_position();
            let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
            let shear = [direction[p] / direction[axis], direction[q] / direction[axis]];
            let sheared: Vec<[[f32; 2]; 3]> = case
                .triangles
                .iter()
                .map(|corners| {
                    corners.map(|corner| {
                        let from = corner - case.ray.origin;
                        [from[p] - shear[0] * from[axis], from[q] - shear[1] * from[axis]]
                    })
                })
                .collect();
            let inside = |edge| sheared.iter().any(|corners| is_inside(corners, edge));
            lost += u32::from(!inside(rounded));
            lost_when_fused += u32::from(!inside(fused));
            exactly_zero += u32::from(sheared.iter().any(|[a, b, _]| rounded(*a, *b) == 0.0));
        }
        assert_eq!(lost, 0);
        assert!(lost_when_fused > 0, "no ray would show a fused multiply-add");
        assert!(exactly_zero > 0, "no edge function is zero");
    }

    /// No ray through the middle of an edge is lost between the triangles on both of its sides: were
    /// the model's own edge functions fused, or zero not decided, some would be.
    #[test]
    fn no_ray_is_lost_at_an_edge() {
        let suite = Suite::named("shared-edge").expect("there");
        for number in 0..20_000 {
            let case = suite.case(1, number);
            let [a, b, _] = case.triangles[0];
            let ray =
                WatertightTriangle::<f32>::ray(case.ray.origin.to_array(), case.ray.direction.to_array());
            // Corners to both sides of the plane of ray and edge.
            let across = (b - a).cross(case.ray.direction).normalize_or_zero() * (b - a).length();
            let inside = |corners| WatertightTriangle::<f32>::new(&corners).intersect::<false>(&ray).inside;
            let middle = a.midpoint(b);
            // Each sees the edge from its own side: in the same order both would err alike.
            let hit = inside([a, b, middle + across]) || inside([b, a, middle - across]);
            assert!(hit, "{number}: {case:?}");
        }
    }
}

/// In each suite, no distance is off by more than running error analysis of the very same test allows.
fn stays_in_bound<R, T, B>(kernel: &str, cases: u64, bounded: impl Fn(&[Vec3; 3]) -> B)
where
    R: formats::Format,
    T: TriangleTest<R>,
    B: TriangleTest<Bounded<R>>,
{
    let mut judged = 0;
    for suite in &SUITES {
        for number in 0..cases {
            let case = suite.case(11, number);
            let (origin, direction) = (case.ray.origin.to_array(), case.ray.direction.to_array());
            for corners in &case.triangles {
                let found = T::new(corners).intersect::<false>(&T::ray(origin, direction));
                let bound = bounded(corners).intersect::<false>(&B::ray(origin, direction)).t.error;
                let alone = Case { triangles: vec![*corners], ..case.clone() };
                let truth = Truth::of(&alone, Edges::Shared);
                if let Some(truth) = truth.0.first().filter(|_| found.inside && bound.is_finite()) {
                    let error = (found.t.to_f64() - truth.t).abs();
                    // The true distance is itself rounded to f64.
                    let bound = bound + truth.t.abs() * f64::EPSILON;
                    assert!(error <= bound, "{kernel} {} {number}: {error:e} beyond {bound:e}", suite.name);
                    judged += 1;
                }
            }
        }
    }
    assert!(judged > cases, "{kernel}: {judged} distances with a bound");
}

/// A triangle of Wald's test with the errors of its words: the driver computes them in f64, in the
/// same steps, and rounds them to the format.
fn projected<R: formats::Format>(corners: &[Vec3; 3]) -> ProjectedTriangle<Bounded<R>> {
    type Exact = Bounded<Double>;
    let Projection { axis, words } = Projection::new(corners);
    let (k, p, q) = (axis as usize, (axis as usize + 1) % 3, (axis as usize + 2) % 3);
    let [a, b, c] = corners.map(|corner| corner.to_array().map(Exact::from_f32));
    let [to_b, to_c]: [[Exact; 3]; 2] = [b, c].map(|end| std::array::from_fn(|axis| end[axis] - a[axis]));
    let normal: [Exact; 3] = std::array::from_fn(|axis| {
        let (p, q) = ((axis + 1) % 3, (axis + 2) % 3);
        to_b[p] * to_c[q] - to_b[q] * to_c[p]
    });
    let area = normal[k];
    let plane = normal.map(|component| component / area);
    let bounded = [
        plane[p],
        plane[q],
        a[0] * plane[0] + a[1] * plane[1] + a[2] * plane[2],
        to_c[q] / area,
        -to_c[p] / area,
        (a[q] * to_c[p] - a[p] * to_c[q]) / area,
        -to_b[q] / area,
        to_b[p] / area,
        (a[p] * to_b[q] - a[q] * to_b[p]) / area,
    ];
    let word = |word: usize| {
        assert!(bounded[word].allows(Double(words[word])) || bounded[word].is_undefined());
        Bounded::within(bounded[word].value, bounded[word].error)
    };
    ProjectedTriangle { axis: k, words: std::array::from_fn(word) }
}

fn all_stay_in_bound<R: formats::Format>(format: &str, cases: u64) {
    type B<R> = Bounded<R>;
    let name = |kernel: &str| format!("{kernel} {format}");
    stays_in_bound::<R, EdgeTriangle<R>, _>(&name("moller-trumbore"), cases, EdgeTriangle::<B<R>>::new);
    stays_in_bound::<R, ProjectedTriangle<R>, _>(&name("wald"), cases, projected::<R>);
    stays_in_bound::<R, PluckerTriangle<R>, _>(&name("plucker"), cases, PluckerTriangle::<B<R>>::new);
    stays_in_bound::<R, WatertightTriangle<R>, _>(
        &name("watertight"),
        cases,
        WatertightTriangle::<B<R>>::new,
    );
}

/// The adaptive test hands out its bound with each hit.
fn adaptive_stays_in_bound(cases: u64) {
    for suite in &SUITES {
        for number in 0..cases {
            let case = suite.case(11, number);
            let ray = AdaptiveRay::new(&case.ray);
            for corners in &case.triangles {
                let triangle = AdaptiveTriangle::new(corners);
                let Some(found) = triangle.intersect(Edges::Shared, &ray) else { continue };
                let truth = Truth::of(&Case { triangles: vec![*corners], ..case.clone() }, Edges::Shared);
                let truth = truth.0.first().expect("the adaptive test is never wrong");
                let (error, bound) =
                    ((found.t - truth.t).abs(), found.t_error + truth.t.abs() * f64::EPSILON);
                assert!(error <= bound, "{} {number}: {error:e} beyond {bound:e}", suite.name);
            }
        }
    }
}

#[test]
fn distances_stay_in_their_bounds() {
    const CASES: u64 = 300;
    adaptive_stays_in_bound(CASES);
    all_stay_in_bound::<Double>("f64", CASES);
    all_stay_in_bound::<f32>("f32", CASES);
    all_stay_in_bound::<F24>("f24", CASES);
    all_stay_in_bound::<Bf16>("bf16", CASES);
    all_stay_in_bound::<F16>("f16", CASES);
}

/// The exact judge says what Python's fractions say, by another method.
fn judge_agrees_with_fractions(cases: u64) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/accuracy/exact_rays.py");
    let mut python = Command::new("python3")
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 is installed");
    let cases: Vec<_> =
        SUITES.iter().flat_map(|suite| (0..cases).map(move |number| (suite, number))).collect();
    let mut input = String::new();
    for (suite, number) in &cases {
        let Case { ray, triangles } = suite.case(42, *number);
        let corners = triangles.iter().flatten().flat_map(|corner| corner.to_array());
        let numbers = [ray.t_min, ray.t_max].into_iter();
        let numbers = numbers.chain(ray.origin.to_array()).chain(ray.direction.to_array()).chain(corners);
        numbers.for_each(|x| write!(input, "{:08x} ", x.to_bits()).expect("to memory"));
        input.push('\n');
    }
    let mut stdin = python.stdin.take().expect("piped");
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = python.wait_with_output().expect("it ends");
    writer.join().expect("no panic").expect("it reads all");
    let output = String::from_utf8(output.stdout).expect("text");
    assert_eq!(output.lines().count(), cases.len());
    for ((suite, number), line) in cases.iter().zip(output.lines()) {
        let truth = Truth::of(&suite.case(42, *number), Edges::Shared);
        let first: Vec<_> = truth.0.iter().map(|found| found.triangle.to_string()).collect();
        let first = if first.is_empty() { "-".to_owned() } else { first.join(",") };
        let t = truth.0.first().map_or("-".to_owned(), |found| python_hex(found.t));
        assert_eq!(line, format!("{first} {t}"), "{} {number}", suite.name);
    }
}

/// As Python's `float.hex` writes it.
fn python_hex(number: f64) -> String {
    let bits = number.to_bits();
    let (exponent, mantissa) = ((bits >> 52) & 0x7FF, bits & ((1 << 52) - 1));
    let sign = if number.is_sign_negative() { "-" } else { "" };
    match exponent {
        0 if mantissa == 0 => format!("{sign}0x0.0p+0"),
        0 => format!("{sign}0x0.{mantissa:013x}p-1022"),
        _ => format!("{sign}0x1.{mantissa:013x}p{:+}", exponent as i64 - 1023),
    }
}

#[test]
fn judge_agrees_with_pythons_fractions() {
    judge_agrees_with_fractions(200);
}

#[test]
#[ignore = "long: 190 000 cases in Python's fractions"]
fn judge_agrees_with_pythons_fractions_on_ten_thousand_cases_a_suite() {
    judge_agrees_with_fractions(10_000);
}
