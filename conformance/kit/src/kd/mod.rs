//! `saarcor-kd`: the traversal and intersection units, for one ray at a time.

mod admissible;
mod compare;
mod coverage;
pub mod generated_scene;
mod oracle;
mod random;
pub mod request;
pub mod scene_memory;
mod sizes;
mod truth;
mod walk;

use crate::comparison::Comparison;
use crate::coverage::Coverage;
use crate::error::Error;
use crate::implementation::Implementation;
use crate::kind::{Candidates, Kind, Oracle};
use crate::level::Level;
use crate::session::Session;
use crate::sizes::{Extent, SizedSession};
use crate::suites;
use generated_scene::GeneratedScene;
use oracle::KdOracle;
use request::{Request, push_ray};
use saarcor_model::rays::{Query, Ray};
use std::borrow::Cow;

/// The kind `saarcor-kd`.
#[derive(Clone, Copy, Debug)]
pub struct Kd;

impl Kd {
    /// A session of rays, each in a scene of its own.
    #[must_use]
    pub fn session_of_cases(self, name: &str, config: &str, cases: &[(GeneratedScene, Ray)]) -> Session {
        let mut text = Vec::new();
        for (scene, ray) in cases {
            text.extend_from_slice(b"flush\n");
            text.extend(scene.requests());
            push_ray(&mut text, Query::Closest, ray);
            push_ray(&mut text, Query::Any, ray);
        }
        Session::new(name, self.hello(), config, &text)
    }
}

fn is_ray(request: &[u8]) -> bool {
    request.starts_with(b"c ") || request.starts_with(b"a ")
}

impl Kind for Kd {
    fn hello(&self) -> &'static str {
        "saarcor-kd 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Rays, Level::Traversal]
    }

    fn observable(&self) -> &'static [(&'static str, Level)] {
        &[("triangle", Level::Rays), ("t", Level::Rays), ("uv", Level::Rays), ("touched", Level::Traversal)]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::KD
    }

    fn random_config(&self, seed: u64) -> Cow<'static, str> {
        random::config_of(seed).into()
    }

    fn random_requests(&self, _config: &str, seed: u64, count: usize) -> Vec<u8> {
        random::requests(seed, count)
    }

    fn sizes(&self, extent: &Extent) -> Vec<SizedSession> {
        sizes::sessions(extent)
    }

    fn recorded(&self, requests: usize) -> Vec<Session> {
        let cut = |session: Session| {
            let others = session.requests().take_while(|request| !is_ray(request)).count();
            let mut cut = session.with_those(|place| place < others.saturating_add(requests));
            let rays = cut.requests().count() - others;
            cut.idea = format!(
                "The first {rays} rays of a recorded frame, over the triangles that they are tested with."
            );
            cut
        };
        suites::of_frames(suites::KD_FRAMES).map(cut).collect()
    }

    /// Checks that each ray has a legal scene.
    fn check(&self, session: &Session) -> Result<(), Error> {
        let mut model = KdOracle::new(Oracle::Model, session.config()).map_err(Error::in_config)?;
        session.check_requests(|request| {
            match Request::parse(request)? {
                Request::Trace(..) => drop(model.scene()?),
                other => model.change(&other),
            }
            Ok(())
        })
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Implementation>, Error> {
        Ok(Box::new(KdOracle::new(oracle, config)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        vec!["kernel", "edges"]
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, Error> {
        Ok(Box::new(compare::KdComparison::new(session, observes)?))
    }

    /// The last scene simplified, with its rays.
    fn simpler_sessions<'a>(&self, session: &'a Session) -> Candidates<'a, Session> {
        let none = || Box::new(std::iter::empty());
        let Ok(mut model) = KdOracle::new(Oracle::Model, session.config()) else { return none() };
        let mut forgotten = 0;
        for (line, place) in session.requests().zip(1..) {
            let Ok(request) = Request::parse(line) else { return none() };
            if request == Request::Flush {
                forgotten = place;
            }
            model.change(&request);
        }
        let Ok((scene, _)) = model.scene() else { return none() };
        let of = move |scene: GeneratedScene| {
            let mut place = 0..;
            session.edited(&scene.requests(), |line| {
                let is_later = place.next().is_some_and(|place| place >= forgotten);
                (is_later && is_ray(line)).then_some(line)
            })
        };
        Box::new(GeneratedScene::of(scene).simpler().map(of))
    }

    /// The right hits, with their bounds, and the right walk.
    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(mut model) = KdOracle::new(Oracle::Model, session.config()) else { return Vec::new() };
        for line in session.requests().take(request) {
            if let Ok(request) = Request::parse(line) {
                model.change(&request);
            }
        }
        let asked = session.requests().nth(request).map(Request::parse);
        let (Some(Ok(Request::Trace(_, ray))), Ok((scene, memory))) = (asked, model.scene()) else {
            return Vec::new();
        };
        let Ray { origin, direction, t_min, t_max } = ray;
        let mut rows = vec![format!("ray from {origin} along {direction}, t {t_min} to {t_max}")];
        rows.extend(truth::Truth::new(scene, &ray).rows());
        rows.extend(walk::steps(memory, scene, &ray).iter().map(walk::Step::text));
        rows
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::new(coverage::KdCoverage::default())
    }
}
