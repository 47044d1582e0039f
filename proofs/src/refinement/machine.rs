//! Machines, simulations, and the induction from steps to runs, written once.
//!
//! A simulation relates the states of two machines. Three things make every run of the concrete machine a
//! run of the abstract one:
//!
//! 1. **Base** ([`begin`]): the states in which the machines begin are related.
//! 2. **Step** ([`step_from_any`]): from *any* two related states, *any* request gets answers that agree, and leaves
//!    related states. The theorems of this folder are this function, on states that an engine draws.
//! 3. **Induction** ([`run`]): a run is the base and then one step after another. What a turn of its loop
//!    needs, related states, is what the turn before left: so no turn of any run can fail of which 1 and 2
//!    are theorems.
//!
//! Simulations compose ([`Chain`]): the machine in the middle runs along.

use crate::source::{Holds, Stop};
use crate::{assume, check};
use std::fmt::Debug;
use std::marker::PhantomData;

/// A machine that answers one request after another. A value is one of its states.
pub trait Machine {
    /// What it is asked.
    type Request: Debug;
    /// What it answers.
    type Answer: Debug;

    /// One step.
    fn step(&mut self, request: &Self::Request) -> Self::Answer;
}

/// A request of a machine.
pub type Request<M> = <M as Machine>::Request;
/// An answer of a machine.
pub type Answer<M> = <M as Machine>::Answer;

/// A relation between the states of two machines that every step keeps.
pub trait Simulation {
    /// The machine that runs.
    type Concrete: Machine;
    /// The machine that says what it should do.
    type Abstract: Machine;

    /// Whether a state of the one stands for that of the other, and satisfies the invariant.
    fn related(concrete: &Self::Concrete, model: &Self::Abstract) -> bool;

    /// What the abstract machine is asked for a request of the concrete one. Where it leaves something open,
    /// as which line has to make room, it is asked with the choice that the concrete machine made, which
    /// shows in the answer and in the state after the step. `model` is the state before it.
    fn asked(
        request: &Request<Self::Concrete>,
        answer: &Answer<Self::Concrete>,
        after: &Self::Concrete,
        model: &Self::Abstract,
    ) -> Request<Self::Abstract>;

    /// Whether the answers agree.
    fn agree(answer: &Answer<Self::Concrete>, expected: &Answer<Self::Abstract>) -> bool;
}

/// The base: the first states are related.
///
/// # Errors
/// If they are not.
pub fn begin<S: Simulation>(concrete: &S::Concrete, model: &S::Abstract) -> Holds
where
    S::Abstract: Debug,
{
    check!(S::related(concrete, model), "the machine does not begin as {model:?}");
    Ok(())
}

/// The step, from any two states that are related: what the theorems of the step say.
///
/// # Errors
/// As [`step`], and if the states are not related: of these no theorem speaks.
pub fn step_from_any<S: Simulation>(
    concrete: &mut S::Concrete,
    model: &mut S::Abstract,
    request: &Request<S::Concrete>,
) -> Result<Answer<S::Concrete>, Stop>
where
    S::Abstract: Debug,
{
    assume!(S::related(concrete, model));
    step::<S>(concrete, model, request)
}

/// The step, from two states that are known to be related.
///
/// # Errors
/// If the answers do not agree, or the states after the step are not related.
pub fn step<S: Simulation>(
    concrete: &mut S::Concrete,
    model: &mut S::Abstract,
    request: &Request<S::Concrete>,
) -> Result<Answer<S::Concrete>, Stop>
where
    S::Abstract: Debug,
{
    let answer = concrete.step(request);
    let expected = model.step(&S::asked(request, &answer, concrete, model));
    check!(
        S::agree(&answer, &expected),
        "{request:?}: answered {answer:?}, but it is {expected:?} of {model:?}"
    );
    check!(S::related(concrete, model), "{request:?}, answered {answer:?}: the state is none of {model:?}");
    Ok(answer)
}

/// The induction: a run of any length. Returns its number of steps.
///
/// # Errors
/// If the base or a step does not hold.
pub fn run<S: Simulation>(
    concrete: &mut S::Concrete,
    model: &mut S::Abstract,
    requests: impl IntoIterator<Item = Request<S::Concrete>>,
) -> Result<u64, Stop>
where
    S::Abstract: Debug,
{
    begin::<S>(concrete, model)?;
    let mut steps = 0;
    for request in requests {
        // Related here: by `begin` in the first turn, by `step` in each turn after it.
        step::<S>(concrete, model, &request)?;
        steps += 1;
    }
    Ok(steps)
}

/// The composition of two simulations, of which the one ends where the other begins: a simulation, since
/// each part speaks of any related states, and so of those that the other has left.
///
/// Its abstract machine is [`Along`]: the machine in the middle is the witness that the states of the outer
/// two are related.
#[derive(Clone, Copy, Debug)]
pub struct Chain<Lower, Upper>(PhantomData<(Lower, Upper)>);

/// The abstract machine of a composition, and the machine in the middle beside it.
#[derive(Clone, Debug)]
pub struct Along<Upper: Simulation> {
    /// The machine in the middle.
    pub middle: Upper::Concrete,
    /// The abstract machine.
    pub model: Upper::Abstract,
}

impl<Upper: Simulation> Machine for Along<Upper> {
    type Request = Request<Upper::Concrete>;
    type Answer = (Answer<Upper::Concrete>, Answer<Upper::Abstract>);

    fn step(&mut self, request: &Self::Request) -> Self::Answer {
        let middle = self.middle.step(request);
        let model = self.model.step(&Upper::asked(request, &middle, &self.middle, &self.model));
        (middle, model)
    }
}

impl<Lower, Upper> Simulation for Chain<Lower, Upper>
where
    Lower: Simulation,
    Upper: Simulation<Concrete = Lower::Abstract>,
{
    type Concrete = Lower::Concrete;
    type Abstract = Along<Upper>;

    fn related(concrete: &Self::Concrete, along: &Self::Abstract) -> bool {
        Lower::related(concrete, &along.middle) && Upper::related(&along.middle, &along.model)
    }

    fn asked(
        request: &Request<Self::Concrete>,
        answer: &Answer<Self::Concrete>,
        after: &Self::Concrete,
        along: &Self::Abstract,
    ) -> Request<Self::Abstract> {
        Lower::asked(request, answer, after, &along.middle)
    }

    fn agree(answer: &Answer<Self::Concrete>, (middle, model): &Answer<Self::Abstract>) -> bool {
        Lower::agree(answer, middle) && Upper::agree(middle, model)
    }
}
