//! Judges answers about a ray by exact arithmetic.

use super::rays::{Question, RayKind};
use crate::world::Image;
use glam::Vec3;
use saarcor_model::host::Kernel;
use saarcor_model::rays::Ray;
use saarcor_oracles::bvh::Bvh;
use saarcor_oracles::embree::{Hit, distance_bound};
use saarcor_oracles::exact::filter::{Distance, Estimate};
use saarcor_oracles::exact::{Closest, Contact, Incidence, closest, judge, rational, solve};
use serde::Serialize;
use std::collections::HashMap;
use std::sync::Arc;

/// How an answer is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// A triangle, where nothing is hit.
    WrongHit,
    /// Nothing, where a triangle is hit.
    WrongMiss,
    /// Another triangle than those hit first, at another distance.
    WrongTriangle,
}

/// The finding of exact arithmetic on an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Finding {
    /// It is one of the triangles that are hit first, or nothing where nothing is hit.
    Right,
    /// It would be right if some contacts with an edge or a vertex, or at an end of the ray's range,
    /// did not count, or did. Such contact is a matter of rules.
    Edge,
    /// Another triangle, reported where the first one is hit, as far as its distance is known.
    WithinBound,
    /// None of these.
    Wrong(Fault),
}

/// The class of a ray: the last one that applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// All answer the same, and are right.
    Agree,
    /// All are right: several triangles are hit at the very same distance.
    Tie,
    /// Answers differ by the rule for edges, vertices and the ends of the range.
    Edge,
    /// Embree names another triangle, at a distance that is right within its derived bound.
    WithinBound,
    /// Embree is wrong, with one of its flags or both.
    EmbreeWrong,
    /// The model is wrong.
    ModelWrong,
}

impl Class {
    /// As it is printed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Tie => "tie",
            Self::Edge => "edge",
            Self::WithinBound => "within_bound",
            Self::EmbreeWrong => "embree_wrong",
            Self::ModelWrong => "model_wrong",
        }
    }
}

/// The answers to a question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answers {
    /// Of the model, asked for the closest hit.
    pub model: Option<Hit>,
    /// Whether the model, asked for any hit, has one.
    pub any: bool,
    /// Of Embree with its flag for robust intersection.
    pub robust: Option<Hit>,
    /// Of Embree by default.
    pub fast: Option<Hit>,
}

/// A question with its answers and the exact one.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedRay {
    /// The question.
    pub question: Question,
    /// The answers.
    pub answers: Answers,
    /// The first hit, in exact arithmetic. Of triangles with the same corners the first stands for all.
    pub truth: Option<Closest>,
    /// The triangles that have the same corners.
    pub(super) copies: Arc<Copies>,
    /// Its class.
    pub class: Class,
    /// How the model is wrong. A wrong distance of the right triangle, and another answer for any
    /// hit than for the closest, have no fault of their own.
    pub model: Option<Fault>,
    /// How Embree is wrong with its flag for robust intersection.
    pub robust: Option<Fault>,
    /// How Embree is wrong by default.
    pub fast: Option<Fault>,
}

/// A judged ray in words and numbers: triangles with their distances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RayRow {
    /// Its class.
    pub class: Class,
    /// Where the ray comes from.
    pub kind: RayKind,
    /// The triangles that are hit first.
    pub exact: Vec<u32>,
    /// The model's answer.
    pub model: Option<(u32, f32)>,
    /// Embree's with its flag for robust intersection.
    pub robust: Option<(u32, f32)>,
    /// Embree's by default.
    pub fast: Option<(u32, f32)>,
}

impl JudgedRay {
    /// The ray as a row.
    #[must_use]
    pub fn row(&self) -> RayRow {
        let answer = |hit: Option<Hit>| hit.map(|hit| (hit.triangle, hit.t));
        RayRow {
            class: self.class,
            kind: self.question.kind,
            exact: self.truth.iter().flat_map(|first| self.copies.all_of(first)).collect(),
            model: answer(self.answers.model),
            robust: answer(self.answers.robust),
            fast: answer(self.answers.fast),
        }
    }
}

/// Triangles with the same corners: what is true of one is true of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Copies {
    /// The first triangle with the corners of each.
    first: Vec<u32>,
    /// All triangles that have the corners of a first one, where there are several.
    several: HashMap<u32, Vec<u32>>,
}

impl Copies {
    fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut copies = Self::default();
        let mut known = HashMap::new();
        for (number, corners) in (0..).zip(triangles) {
            let bits = corners.map(|corner| corner.to_array().map(f32::to_bits));
            let first = *known.entry(bits).or_insert(number);
            copies.first.push(first);
            if first != number {
                copies.several.entry(first).or_insert_with(|| vec![first]).push(number);
            }
        }
        copies
    }

    /// The triangles that are hit first, in ascending order.
    fn all_of(&self, closest: &Closest) -> Vec<u32> {
        let all =
            |(first, _): &(u32, Contact)| self.several.get(first).cloned().unwrap_or_else(|| vec![*first]);
        let mut all: Vec<u32> = closest.triangles.iter().flat_map(all).collect();
        all.sort_unstable();
        all
    }
}

/// Judges answers about the triangles of a scene.
#[derive(Debug)]
pub struct Judge<'a> {
    triangles: &'a [[Vec3; 3]],
    /// Of the first triangles of all that have the same corners.
    bvh: Bvh,
    /// Their numbers, in the order of the hierarchy's.
    firsts: Vec<u32>,
    copies: Arc<Copies>,
    /// Where each triangle lies in the order of addresses; `u32::MAX` where it is in no list.
    places: Vec<u32>,
    /// Of the triangles with the corners of a first one, the one at the lowest address, where there are several.
    lowest: HashMap<u32, u32>,
    kernel: Kernel,
}

impl<'a> Judge<'a> {
    /// Of a scene with these corners, laid out as `image`.
    #[must_use]
    pub fn new(triangles: &'a [[Vec3; 3]], image: &Image) -> Self {
        let mut places = vec![u32::MAX; triangles.len()];
        for (place, id) in (0..).zip(image.triangle_ids()) {
            places[id as usize] = place;
        }
        let copies = Copies::new(triangles);
        let firsts: Vec<u32> = (0..)
            .zip(&copies.first)
            .filter(|(number, first)| number == *first)
            .map(|(number, _)| number)
            .collect();
        let corners: Vec<_> = firsts.iter().map(|&first| triangles[first as usize]).collect();
        let lowest = copies.several.iter().filter_map(|(&first, all)| {
            Some((first, all.iter().copied().min_by_key(|&number| places[number as usize])?))
        });
        let (lowest, bvh) = (lowest.collect(), Bvh::new(&corners));
        Self {
            triangles,
            bvh,
            firsts,
            copies: Arc::new(copies),
            places,
            lowest,
            kernel: image.registers.kernel,
        }
    }

    /// The first triangles of which one may be hit up to a distance.
    fn candidates(&self, ray: &Ray, farthest: f64) -> impl Iterator<Item = u32> {
        self.bvh.candidates(ray, farthest).map(|place| self.firsts[place as usize])
    }

    /// Judges the answers to a question.
    #[must_use]
    pub fn judged(&self, question: Question, answers: Answers) -> JudgedRay {
        let ray = &question.ray;
        let truth = self.closest(ray, [answers.model, answers.robust, answers.fast]);
        let of_model = self.find(ray, &truth, answers.model);
        let [robust, fast] = [answers.robust, answers.fast].map(|answer| self.find(ray, &truth, answer));
        let faults = [of_model, robust, fast].map(|finding| match finding {
            Finding::Wrong(fault) => Some(fault),
            _ => None,
        });
        let all = [of_model, robust, fast];
        let names = [answers.model, answers.robust, answers.fast].map(|hit| hit.map(|hit| hit.triangle));
        let class = if self.model_is_wrong(ray, &truth, &answers, of_model) {
            Class::ModelWrong
        } else if faults.iter().any(Option::is_some) {
            Class::EmbreeWrong
        } else if all.contains(&Finding::WithinBound) {
            Class::WithinBound
        } else if all.contains(&Finding::Edge) {
            Class::Edge
        } else if names.iter().any(|name| *name != names[0]) {
            Class::Tie
        } else {
            Class::Agree
        };
        let [model, robust, fast] = faults;
        JudgedRay { question, answers, truth, copies: Arc::clone(&self.copies), class, model, robust, fast }
    }

    /// The first hit of `ray`. A claim that is a hit bounds the distance to search.
    fn closest(&self, ray: &Ray, claims: [Option<Hit>; 3]) -> Option<Closest> {
        let hits = claims.iter().flatten().map(|claim| &self.triangles[claim.triangle as usize]);
        let farthest = hits
            .filter(|corners| judge(ray, corners).is_hit())
            .map(|corners| Estimate::new(ray, corners).distance().greatest)
            .fold(f64::INFINITY, f64::min);
        let numbered = |number: u32| (number, self.triangles[number as usize]);
        closest(ray, self.candidates(ray, farthest).map(numbered))
    }

    /// The adaptive test is exact, and with it the model has to be: the first triangle, of several
    /// the one at the lowest address (IS-2), at its distance (KD-4). Other tests may be off by their
    /// bounds, as Embree may. In each case there must be a hit where there is a closest one.
    fn model_is_wrong(&self, ray: &Ray, truth: &Option<Closest>, answers: &Answers, found: Finding) -> bool {
        let exact = match (answers.model, truth) {
            (Some(hit), Some(closest)) => {
                let lowest =
                    closest.triangles.iter().map(|(id, _)| self.lowest.get(id).copied().unwrap_or(*id));
                let lowest = lowest.min_by_key(|&id| self.place(id));
                lowest == Some(hit.triangle) && self.distance_is_right(ray, hit)
            }
            (None, None) => true,
            _ => false,
        };
        let right = if self.kernel == Kernel::Adaptive { exact } else { !matches!(found, Finding::Wrong(_)) };
        !right || answers.any != answers.model.is_some()
    }

    fn place(&self, triangle: u32) -> u32 {
        self.places[triangle as usize]
    }

    /// Whether a hit's distance is the true one times 1 ± 2u, u = 2⁻²⁴, as KD-4 asks, or off by
    /// the least f32.
    fn distance_is_right(&self, ray: &Ray, hit: Hit) -> bool {
        let corners = &self.triangles[hit.triangle as usize];
        let reported = f64::from(hit.t);
        let is_near = |least: f64, greatest: f64| {
            let slack = |t: f64| t.abs() * f64::from(f32::EPSILON) + f64::from(f32::from_bits(1));
            greatest - slack(greatest) <= reported && reported <= least + slack(least)
        };
        let Distance { least, greatest } = Estimate::new(ray, corners).distance();
        // The error of the nearest f64 is far below an f32's: it decides nothing.
        is_near(least, greatest)
            || solve(ray, corners).is_some_and(|point| {
                let t = rational::nearest_f64(&point.t);
                is_near(t, t)
            })
    }

    /// The finding on an answer.
    fn find(&self, ray: &Ray, truth: &Option<Closest>, answer: Option<Hit>) -> Finding {
        match (truth, answer) {
            (None, None) => Finding::Right,
            (Some(closest), Some(hit)) if closest.contains(self.copies.first[hit.triangle as usize]) => {
                Finding::Right
            }
            _ if self.is_right_by_other_rules(ray, answer) => Finding::Edge,
            (Some(closest), Some(hit)) if self.is_within_bound(ray, closest, hit) => Finding::WithinBound,
            (None, Some(_)) => Finding::Wrong(Fault::WrongHit),
            (Some(_), None) => Finding::Wrong(Fault::WrongMiss),
            (Some(_), Some(_)) => Finding::Wrong(Fault::WrongTriangle),
        }
    }

    /// Whether the answer would be right if contact with edges and vertices, and hits at the very
    /// ends of the ray's range, counted for some triangles and for others not.
    fn is_right_by_other_rules(&self, ray: &Ray, answer: Option<Hit>) -> bool {
        // Through the end of the range; what lies behind it is left out below.
        let closed = Ray { t_max: ray.t_max.next_up(), ..*ray };
        let ends = [ray.t_min, ray.t_max].map(rational::number);
        let mut claimed = None;
        let mut required = None;
        for number in self.candidates(&closed, f64::INFINITY) {
            let corners = &self.triangles[number as usize];
            let Incidence::Hit(contact) = judge(&closed, corners) else { continue };
            let Some(t) = rational::distance(&closed, corners) else { continue };
            if ends[1].as_ref().is_some_and(|end| t > *end) {
                continue;
            }
            if answer.is_some_and(|hit| self.copies.first[hit.triangle as usize] == number) {
                claimed = Some(t.clone());
            }
            let optional = contact != Contact::Interior || ends.iter().flatten().any(|end| t == *end);
            if !optional && required.as_ref().is_none_or(|least| t < *least) {
                required = Some(t);
            }
        }
        match (answer, claimed) {
            (None, _) => required.is_none(),
            (Some(_), Some(claimed)) => required.is_none_or(|required| claimed <= required),
            (Some(_), None) => false,
        }
    }

    /// Whether a hit is reported where the first triangle is hit, as far as the distance of its own
    /// is known.
    fn is_within_bound(&self, ray: &Ray, closest: &Closest, hit: Hit) -> bool {
        let bound = distance_bound(ray, &self.triangles[hit.triangle as usize]);
        let first = closest.triangles.first().map(|(id, _)| &self.triangles[*id as usize]);
        let point = first.and_then(|corners| solve(ray, corners));
        let off = point.map(|point| (rational::nearest_f64(&point.t) - f64::from(hit.t)).abs());
        off.zip(bound).is_some_and(|(off, bound)| off <= bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crosscheck::rays::traverse;
    use saarcor_model::host::{HostImage, Material, Scene, Triangle};
    use saarcor_model::rays::Query;
    use saarcor_scenes::kdbuild::{BuildOptions, build};

    /// Triangles at z = 1 and once more, at the next f32, at 2, and without area at 0.5; each has
    /// the corner (0, 0), of a right angle, and legs of length 4.
    const HEIGHTS: [f32; 5] = [1.0, 1.0, 1.0 + f32::EPSILON, 2.0, 0.5];
    const FIRST: u32 = 0;
    const SAME: u32 = 1;
    const NEXT: u32 = 2;
    const BEHIND: u32 = 3;
    const FLAT: u32 = 4;

    fn corners() -> Vec<[Vec3; 3]> {
        let at = |z| [Vec3::new(0.0, 0.0, z), Vec3::new(4.0, 0.0, z), Vec3::new(0.0, 4.0, z)];
        let mut corners: Vec<_> = HEIGHTS.into_iter().map(at).collect();
        corners[FLAT as usize][2] = Vec3::new(8.0, 0.0, 0.5);
        corners
    }

    fn image_of(corners: &[[Vec3; 3]], kernel: Kernel) -> Image {
        let triangles = corners.iter().map(|&corners| Triangle { corners, material: 0 }).collect();
        let scene = Scene { triangles, materials: vec![Material::default()], ..Scene::default() };
        let tree = build(&scene.triangles, &BuildOptions::default(), &|_| {});
        HostImage::build(&scene, &tree, kernel).expect("a valid tree").into()
    }

    /// The case of a ray along z from (x, y, 0) up to `t_max`, with answers by triangle and
    /// distance. `kernel` is the model's.
    fn case(kernel: Kernel, [x, y, t_max]: [f32; 3], answers: [Option<(u32, f32)>; 3]) -> JudgedRay {
        let corners = corners();
        let image = image_of(&corners, kernel);
        let ray = Ray { origin: Vec3::new(x, y, 0.0), direction: Vec3::Z, t_min: 0.0, t_max };
        let [model, robust, fast] =
            answers.map(|answer| answer.map(|(triangle, t)| Hit { triangle, t, u: 0.0, v: 0.0 }));
        let answers = Answers { model, any: model.is_some(), robust, fast };
        Judge::new(&corners, &image).judged(Question { kind: RayKind::Aimed, ray }, answers)
    }

    const INSIDE: [f32; 3] = [1.0, 1.0, f32::INFINITY];

    #[test]
    fn right_answers_agree_or_tie() {
        let first = Some((FIRST, 1.0));
        assert_eq!(case(Kernel::Adaptive, INSIDE, [first; 3]).class, Class::Agree);
        assert_eq!(case(Kernel::Adaptive, INSIDE, [first, Some((SAME, 1.0)), first]).class, Class::Tie);
        assert_eq!(case(Kernel::Adaptive, [9.0, 9.0, 9.0], [None; 3]).class, Class::Agree);
    }

    /// Of triangles with the same corners one is judged, and all are named.
    #[test]
    fn copies_are_judged_once() {
        let one = corners()[FIRST as usize];
        let copies = Copies::new(&[one, corners()[BEHIND as usize], one, one]);
        assert_eq!(
            (copies.first.clone(), copies.several.clone()),
            (vec![0, 1, 0, 0], [(0, vec![0, 2, 3])].into())
        );
        let first = Some((FIRST, 1.0));
        let case = case(Kernel::Adaptive, INSIDE, [first; 3]);
        assert_eq!(case.truth.as_ref().map(|truth| truth.triangles.len()), Some(1));
        assert_eq!(case.row().exact, [FIRST, SAME]);
    }

    /// Thousands of coincident triangles, their corners in any order: for a ray no more than ten times as many are
    /// judged as where they are one, and the model is right about them.
    #[test]
    fn coincident_triangles_cost_little_more_than_one() {
        let [one, behind] = [FIRST, BEHIND].map(|number| corners()[number as usize]);
        let turned = |number: usize| {
            let [a, b, c] = one;
            let corners = [[a, b, c], [b, c, a], [c, a, b]][number % 3];
            if number.is_multiple_of(2) { corners } else { [corners[2], corners[1], corners[0]] }
        };
        let many: Vec<_> = (0..3000).map(turned).chain([behind]).collect();
        let few = [one, behind];
        let [image, image_of_few] = [&many[..], &few].map(|corners| image_of(corners, Kernel::Adaptive));
        let (judge, usual) = (Judge::new(&many, &image), Judge::new(&few, &image_of_few));
        // Inside, on an edge, and at a vertex.
        for [x, y] in [[1.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
            let ray =
                Ray { origin: Vec3::new(x, y, 0.0), direction: Vec3::Z, t_min: 0.0, t_max: f32::INFINITY };
            let judged = |judge: &Judge<'_>| judge.candidates(&ray, f64::INFINITY).count();
            assert!(judged(&judge) <= 10 * judged(&usual), "{} of {ray:?}", judged(&judge));
            let [model, any] =
                [Query::Closest, Query::Any].map(|query| traverse(&image, &[ray], query).pop().flatten());
            let answers = Answers { model, any: any.is_some(), robust: model, fast: model };
            let case = judge.judged(Question { kind: RayKind::Aimed, ray }, answers);
            assert_eq!((case.class, case.row().exact.len()), (Class::Agree, 3000), "{ray:?}");
        }
    }

    #[test]
    fn embree_is_wrong_by_name() {
        let first = Some((FIRST, 1.0));
        let case = case(Kernel::Adaptive, INSIDE, [first, None, Some((BEHIND, 2.0))]);
        assert_eq!((case.class, case.model), (Class::EmbreeWrong, None));
        assert_eq!((case.robust, case.fast), (Some(Fault::WrongMiss), Some(Fault::WrongTriangle)));
        let beside = self::case(Kernel::Adaptive, [5.0, 5.0, 9.0], [None, first, None]);
        assert_eq!(
            (beside.class, beside.robust, beside.fast),
            (Class::EmbreeWrong, Some(Fault::WrongHit), None)
        );
    }

    #[test]
    fn a_triangle_without_area_is_never_hit() {
        let first = Some((FIRST, 1.0));
        let case = case(Kernel::Adaptive, [1.0, 0.0, 9.0], [first, Some((FLAT, 0.5)), Some((FLAT, 1.0))]);
        assert_eq!((case.robust, case.fast), (Some(Fault::WrongTriangle), Some(Fault::WrongTriangle)));
    }

    #[test]
    fn the_next_triangle_is_within_the_bound_and_the_model_has_none() {
        let (first, next) = (Some((FIRST, 1.0)), Some((NEXT, 1.0 + f32::EPSILON)));
        assert_eq!(case(Kernel::Adaptive, INSIDE, [first, next, first]).class, Class::WithinBound);
        assert_eq!(case(Kernel::Adaptive, INSIDE, [next, first, first]).class, Class::ModelWrong);
        assert_eq!(case(Kernel::MollerTrumbore, INSIDE, [next, first, first]).class, Class::WithinBound);
    }

    #[test]
    fn contact_with_edges_and_ends_is_a_matter_of_rules() {
        let (first, behind) = (Some((FIRST, 1.0)), Some((BEHIND, 2.0)));
        // On the edge y = 0 of all of them.
        assert_eq!(case(Kernel::Adaptive, [1.0, 0.0, 9.0], [first, behind, None]).class, Class::Edge);
        // At the end of the range, which does not belong to it.
        assert_eq!(case(Kernel::Adaptive, [1.0, 1.0, 1.0], [None, first, None]).class, Class::Edge);
        // Behind the end.
        assert_eq!(case(Kernel::Adaptive, [1.0, 1.0, 1.0], [None, behind, None]).class, Class::EmbreeWrong);
        // Nothing is on the edge there, and so nothing excuses that there is no answer.
        assert_eq!(case(Kernel::Adaptive, INSIDE, [first, None, first]).class, Class::EmbreeWrong);
        assert_eq!(case(Kernel::Adaptive, [1.0, 0.0, 9.0], [None, first, first]).class, Class::ModelWrong);
    }

    #[test]
    fn the_model_owes_the_lowest_address_and_the_distance() {
        let first = Some((FIRST, 1.0));
        assert_eq!(
            case(Kernel::Adaptive, INSIDE, [Some((SAME, 1.0)), first, first]).class,
            Class::ModelWrong
        );
        let off = Some((FIRST, 1.0 + 4.0 * f32::EPSILON));
        assert_eq!(case(Kernel::Adaptive, INSIDE, [off, first, first]).class, Class::ModelWrong);
    }
}
