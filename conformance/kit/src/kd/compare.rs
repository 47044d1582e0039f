//! Compares the answers of `saarcor-kd` with the model's, and what differs with what is true.

use super::admissible::{WrongRead, follow};
use super::oracle::KdOracle;
use super::request::{Answer, Observes, Request};
use super::truth::{Truth, Violation};
use crate::comparison::{Comparison, Difference, Expected};
use crate::error::Error;
use crate::kind::Oracle;
use crate::level::Level;
use crate::session::Session;
use saarcor_model::rays::{Query, Ray};

/// The comparison of one session.
pub struct KdComparison {
    observes: Observes,
    expected: Expected<KdOracle>,
}

impl KdComparison {
    /// Compares what `observes` lists.
    ///
    /// # Errors
    /// What is wrong with the list or the configuration.
    pub fn new(session: &Session, observes: &str) -> Result<Self, Error> {
        let model = KdOracle::new(Oracle::Model, session.config())?;
        Ok(Self { observes: Observes::parse(observes)?, expected: Expected::new(model) })
    }

    /// Compares an answer to a ray that is not the model's byte for byte with what is true.
    fn compare_ray(
        &mut self,
        (query, ray): (Query, Ray),
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        let got = Answer::parse(answer, query, self.observes)?;
        let right = Answer::parse(self.expected.answer(), query, self.observes)?;
        let (scene, memory) = self.expected.model.scene()?;
        let truth = Truth::new(scene, &ray);
        let checked = match query {
            Query::Closest => truth.check_closest(got.hit.as_ref()),
            Query::Any => truth.check_any(got.hit.is_some()),
        };
        if let Err(Violation { requirement, says }) = checked {
            found(Difference { level: Level::Rays, says, requirement });
        }
        let read = got.touched.as_deref().filter(|_| got.touched != right.touched);
        if let Some(Err(WrongRead { place, right })) = read.map(|read| follow(memory, scene, &ray, read)) {
            let shown = |addr: Option<u32>| addr.map_or("nothing".to_owned(), |addr| format!("{addr:x}"));
            let read = shown(read.and_then(|read| read.get(place).copied()));
            let says = format!("read {} reads {read}; {} is right", place + 1, shown(right));
            found(Difference { level: Level::Traversal, says, requirement: "KD-3" });
        }
        Ok(())
    }
}

impl Comparison for KdComparison {
    fn observed(&self, level: Level) -> bool {
        let Observes { triangle, t, touched, .. } = self.observes;
        match level {
            Level::Protocol => true,
            Level::Rays => triangle && t,
            Level::Traversal => touched,
            _ => false,
        }
    }

    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error> {
        if self.expected.equals(request, answer)? {
            return Ok(());
        }
        match Request::parse(request)? {
            Request::Trace(query, ray) => self.compare_ray((query, ray), answer, found),
            _ => Err("'ok' is right".into()),
        }
    }

    fn expected(&self) -> &[u8] {
        self.expected.answer()
    }
}
