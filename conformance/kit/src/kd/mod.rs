//! `saarcor-kd`: the traversal and intersection units, for one ray at a time.

pub mod bound;
mod compare;
mod coverage;
mod random;
pub mod request;
pub mod scene;
mod served;
mod truth;
mod walk;
pub mod world;

use crate::kind::{Comparison, Coverage, Kind, Oracle};
use crate::level::Level;
use crate::serve::{Served, Unsupported};
use crate::session::Session;
use crate::suites;
use request::{Request, push_ray};
use saarcor_model::rays::{Query, Ray};
use scene::Made;
use served::KdServed;

/// The kind `saarcor-kd`.
#[derive(Clone, Copy, Debug)]
pub struct Kd;

impl Kd {
    /// A session of rays, each in a scene of its own.
    #[must_use]
    pub fn session_of_cases(self, name: &str, config: &str, cases: &[(Made, Ray)]) -> Session {
        let mut text = Vec::new();
        for (made, ray) in cases {
            text.extend_from_slice(b"flush\n");
            text.extend(made.requests());
            push_ray(&mut text, Query::Closest, ray);
            push_ray(&mut text, Query::Any, ray);
        }
        Session::new(name, self.hello(), config, &text)
    }
}

impl Kind for Kd {
    fn name(&self) -> &'static str {
        "saarcor-kd"
    }

    fn hello(&self) -> &'static str {
        "saarcor-kd 1"
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Protocol, Level::Rays, Level::Traversal]
    }

    fn suites(&self) -> &'static [(&'static str, &'static str)] {
        suites::KD
    }

    fn random(&self, seed: u64, requests: usize) -> Session {
        let name = format!("{}/random/{seed}", self.prefix());
        Session::new(&name, self.hello(), &random::config_of(seed), &random::requests(seed, requests))
    }

    /// Whether each ray has a legal scene.
    fn check(&self, session: &Session) -> Result<(), String> {
        let model = KdServed::new(Oracle::Model, session.config());
        let mut model = model.map_err(|wrong| format!("config: {}", wrong.0))?;
        for (line, number) in session.requests().zip(1..) {
            let wrong =
                |right: &str| format!("request {number}, '{}': {right}", String::from_utf8_lossy(line));
            let request = Request::parse(line).map_err(wrong)?;
            match request {
                Request::Trace(..) => model.scene().map(|_| ()).map_err(|right| wrong(&right))?,
                _ => model.change(&request),
            }
        }
        Ok(())
    }

    fn oracle(&self, oracle: Oracle, config: &str) -> Result<Box<dyn Served>, Unsupported> {
        Ok(Box::new(KdServed::new(oracle, config)?))
    }

    fn keys(&self) -> Vec<&'static str> {
        vec!["kernel"]
    }

    fn comparison<'a>(
        &self,
        session: &'a Session,
        observes: &str,
    ) -> Result<Box<dyn Comparison + 'a>, String> {
        Ok(Box::new(compare::KdComparison::new(session, observes)?))
    }

    fn simpler_configs(&self, _config: &str) -> Vec<String> {
        // Another test is another question.
        Vec::new()
    }

    fn simpler_requests(&self, _session: &Session, _request: &[u8]) -> Vec<String> {
        Vec::new()
    }

    /// The last scene simplified, with the rays that it was asked for.
    fn simpler_sessions(&self, session: &Session) -> Vec<Session> {
        let Ok(mut model) = KdServed::new(Oracle::Model, session.config()) else { return Vec::new() };
        let mut rays = Vec::new();
        for line in session.requests() {
            let Ok(request) = Request::parse(line) else { return Vec::new() };
            match request {
                Request::Trace(query, ray) => rays.push((query, ray)),
                Request::Flush => rays.clear(),
                _ => {}
            }
            model.change(&request);
        }
        let Ok((scene, _)) = model.scene() else { return Vec::new() };
        let of = |made: &Made| {
            let mut text = made.requests();
            rays.iter().for_each(|(query, ray)| push_ray(&mut text, *query, ray));
            session.with_requests(text.trim_ascii_end().split(|&byte| byte == b'\n'))
        };
        Made::of(scene).simpler().iter().map(of).collect()
    }

    /// The right walk.
    fn state_before(&self, session: &Session, request: usize) -> Vec<String> {
        let Ok(mut model) = KdServed::new(Oracle::Model, session.config()) else { return Vec::new() };
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
        rows.extend(walk::steps(memory, scene, &ray).iter().map(walk::Step::text));
        rows
    }

    fn coverage(&self) -> Box<dyn Coverage> {
        Box::new(coverage::Reached::default())
    }
}
