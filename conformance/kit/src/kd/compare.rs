//! Compares the answers of `saarcor-kd` with the model's, and what differs with what is true.

use super::admissible::{WrongRead, follow};
use super::oracle::KdOracle;
use super::request::{Answer, Observes, Request};
use super::truth::{LeftOpen, Truth, Violation};
use crate::comparison::{Admitted, Comparison, Difference, Expected, admit};
use crate::error::Error;
use crate::kind::Oracle;
use crate::level::Level;
use crate::session::Session;
use saarcor_model::rays::{Query, Ray};

/// The comparison of one session.
pub struct KdComparison {
    observes: Observes,
    expected: Expected<KdOracle>,
    admitted: Vec<Admitted>,
}

impl KdComparison {
    /// Compares what `observes` lists.
    ///
    /// # Errors
    /// What is wrong with the list or the configuration.
    pub fn new(session: &Session, observes: &str) -> Result<Self, Error> {
        let model = KdOracle::new(Oracle::Model, session.config())?;
        Ok(Self {
            observes: Observes::parse(observes)?,
            expected: Expected::new(model),
            admitted: Vec::new(),
        })
    }

    /// Compares an answer to a ray that is not the model's byte for byte with what is true.
    fn compare_ray(
        &mut self,
        (query, ray): (Query, Ray),
        request: &[u8],
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
        match (checked, truth.left_open(query, got.hit.as_ref(), right.hit.as_ref())) {
            (Err(Violation { requirement, says }), _) => {
                found(Difference { level: Level::Rays, says, requirement });
            }
            (Ok(()), Some(LeftOpen { requirement, says })) => {
                admit(&mut self.admitted, requirement, request, || says);
            }
            (Ok(()), None) => {}
        }
        let read = got.touched.as_deref().filter(|_| got.touched != right.touched);
        let Some(read) = read else { return Ok(()) };
        let shown = |addr: Option<u32>| addr.map_or("nothing".to_owned(), |addr| format!("{addr:x}"));
        match follow(memory, scene, &ray, read) {
            Err(WrongRead { place, right }) => {
                let read = shown(read.get(place).copied());
                let says = format!("read {} reads {read}; {} is right", place + 1, shown(right));
                found(Difference { level: Level::Traversal, says, requirement: "KD-3" });
            }
            Ok(()) => admit(&mut self.admitted, "KD-3", request, || {
                let models = right.touched.as_deref().unwrap_or_default();
                let differ = |place: &usize| read.get(*place) != models.get(*place);
                let place = (0..=read.len()).find(differ).unwrap_or_default();
                let [read, models] = [read, models].map(|list| shown(list.get(place).copied()));
                format!(
                    "read {} reads {read}, the model's {models}: the bound of the nearest hit's distance leaves open \
                     whether a child that was put off lies behind it",
                    place + 1
                )
            }),
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
            Request::Trace(query, ray) => self.compare_ray((query, ray), request, answer, found),
            _ => Err("'ok' is right".into()),
        }
    }

    fn expected(&self) -> &[u8] {
        self.expected.answer()
    }

    fn admitted(&self) -> &[Admitted] {
        &self.admitted
    }
}
