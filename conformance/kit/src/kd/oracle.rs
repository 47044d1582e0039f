//! The model and the naive reference as implementations.

use super::request::{Request, push_f32s};
use super::scene_memory::{LegalScene, SceneMemory, parse_config};
use super::truth::candidates;
use super::walk::trace;
use crate::error::Error;
use crate::hex;
use crate::implementation::Implementation;
use crate::kind::Oracle;
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::rays::{Query, Ray};
use saarcor_oracles::exact::rational::nearest_f32;
use saarcor_oracles::exact::{closest, solve};

/// An oracle with the memory that the requests so far have written.
#[derive(Clone, Debug)]
pub struct KdOracle {
    oracle: Oracle,
    /// The triangle test, and the rule for edges.
    test: (Kernel, Edges),
    world: SceneMemory,
    /// The scene that lies in memory, once a ray was traced in it.
    scene: Option<LegalScene>,
}

impl KdOracle {
    /// The oracle of a configuration.
    ///
    /// # Errors
    /// The key whose value is wrong.
    pub fn new(oracle: Oracle, config: &str) -> Result<Self, Error> {
        let test = parse_config(config)?;
        Ok(Self { oracle, test, world: SceneMemory::default(), scene: None })
    }

    /// Takes what a request changes; a ray changes nothing.
    pub fn change(&mut self, request: &Request<'_>) {
        if self.world.change(request) {
            self.scene = None;
        }
    }

    /// The scene, and the memory that it lies in.
    ///
    /// # Errors
    /// Why there is none.
    pub fn scene(&mut self) -> Result<(&LegalScene, &[u8]), Error> {
        let scene = match self.scene.take() {
            Some(scene) => scene,
            None => self.world.scene(self.test)?,
        };
        Ok((self.scene.insert(scene), &self.world.memory))
    }
}

impl Implementation for KdOracle {
    fn observes(&self) -> String {
        match self.oracle {
            Oracle::Model => "triangle,t,uv,touched".to_owned(),
            Oracle::Naive => "triangle,t,uv".to_owned(),
        }
    }

    fn answer(&mut self, request: &[u8], answer: &mut Vec<u8>) -> Result<(), Error> {
        let request = Request::parse(request)?;
        let Request::Trace(query, ray) = request else {
            self.change(&request);
            answer.extend_from_slice(b"ok");
            return Ok(());
        };
        let oracle = self.oracle;
        let (scene, memory) = self.scene().map_err(|_| "what lies in memory is no scene")?;
        match oracle {
            Oracle::Model => model(scene, memory, &ray, query, answer),
            Oracle::Naive => naive(scene, &ray, query, answer),
        }
        Ok(())
    }
}

fn model(scene: &LegalScene, memory: &[u8], ray: &Ray, query: Query, answer: &mut Vec<u8>) {
    let (hits, touched) = trace(memory, scene, ray, query);
    let hit = hits.is_hit(0).then_some((hits.triangle[0], [hits.t[0], hits.u[0], hits.v[0]]));
    push_answer(answer, query, hit);
    if query == Query::Any {
        return;
    }
    answer.push(b' ');
    for (place, (_, addr)) in touched.iter().enumerate() {
        if place > 0 {
            answer.push(b',');
        }
        hex::push_number(answer, (*addr).into());
    }
    if touched.is_empty() {
        answer.extend_from_slice(b"none");
    }
}

/// All triangles, exactly; of those hit first the one at the lowest address.
fn naive(scene: &LegalScene, ray: &Ray, query: Query, answer: &mut Vec<u8>) {
    let numbered = candidates(scene, ray);
    let first = closest(ray, numbered).and_then(|closest| closest.triangles.first().copied());
    let hit = first.and_then(|(place, _)| {
        let point = solve(ray, &scene.corners[place as usize])?;
        let numbers = [point.t, point.u, point.v].map(|number| nearest_f32(&number));
        Some((scene.addresses[place as usize], numbers))
    });
    push_answer(answer, query, hit);
    if query == Query::Closest {
        answer.extend_from_slice(b" -");
    }
}

/// Appends the answer without what was read.
fn push_answer(answer: &mut Vec<u8>, query: Query, hit: Option<(u32, [f32; 3])>) {
    match hit {
        None => answer.push(b'm'),
        Some(_) if query == Query::Any => answer.push(b'h'),
        Some((triangle, numbers)) => {
            answer.extend_from_slice(b"h ");
            hex::push_number(answer, triangle.into());
            push_f32s(answer, numbers);
        }
    }
}
