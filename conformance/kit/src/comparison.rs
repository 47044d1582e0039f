//! How the answers of an implementation are compared with the model's.

use crate::error::Error;
use crate::implementation::Implementation;
use crate::level::Level;
use crate::shown::shown;

/// Compares the answers of one session, one by one.
pub trait Comparison {
    /// Whether a level can be judged by what the implementation observes.
    fn observed(&self, level: Level) -> bool;

    /// Compares the answer to the next request with the model's; differences are handed to `found`.
    ///
    /// # Errors
    /// What would be right, where the answer is not in the form of the protocol.
    fn compare(
        &mut self,
        request: &[u8],
        answer: &[u8],
        found: &mut dyn FnMut(Difference),
    ) -> Result<(), Error>;

    /// The model's answer to the request that was compared last.
    fn expected(&self) -> &[u8];

    /// What answers so far were right, though they were not the model's.
    fn admitted(&self) -> &[Admitted] {
        &[]
    }
}

/// Answers that are right, though they are not the model's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Admitted {
    /// The requirement that leaves them open.
    pub requirement: &'static str,
    /// How many there were.
    pub answers: u64,
    /// What was asked first.
    pub asked: String,
    /// Why the first was right, in a sentence.
    pub why: String,
}

/// Adds an answer that is right, though it is not the model's; `why` is asked of the first of a requirement.
pub(crate) fn admit(
    admitted: &mut Vec<Admitted>,
    requirement: &'static str,
    asked: &[u8],
    why: impl FnOnce() -> String,
) {
    match admitted.iter_mut().find(|known| known.requirement == requirement) {
        Some(known) => known.answers += 1,
        None => admitted.push(Admitted { requirement, answers: 1, asked: shown(asked), why: why() }),
    }
}

/// How an answer differs from the model's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The lowest level that it breaks.
    pub level: Level,
    /// What differs, in a sentence.
    pub says: String,
    /// The requirement that it breaks, such as `VM-6`, by all that is known of the session.
    pub requirement: &'static str,
}

/// The model, which answers the requests of the implementation under test.
pub(crate) struct Expected<M> {
    /// The model.
    pub model: M,
    answer: Vec<u8>,
}

impl<M: Implementation> Expected<M> {
    pub fn new(model: M) -> Self {
        Self { model, answer: Vec::new() }
    }

    /// Lets the model answer too. Returns whether the implementation's answer is the same, byte for byte.
    #[inline]
    pub fn equals(&mut self, request: &[u8], answer: &[u8]) -> Result<bool, Error> {
        self.answer.clear();
        self.model.answer(request, &mut self.answer)?;
        Ok(self.answer == answer)
    }

    /// The model's last answer.
    pub fn answer(&self) -> &[u8] {
        &self.answer
    }
}
