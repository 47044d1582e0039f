//! Delta debugging: the shortest requests that still fail in the same way (Zeller, Hildebrandt 2002).

use crate::deadline::Deadline;
use crate::kind::Kind;
use crate::scoreboard::Finding;
use crate::session::Session;
use std::rc::Rc;

/// Conversations that are held at most to shrink one session.
const MAX_TRIES: usize = 1000;
/// Requests of a session that is long: whole parts are left out before single requests are looked at.
const LONG: usize = 1000;

/// Runs a session; what it finds, if it fails in the same way.
pub type Fails<'a> = dyn FnMut(&Session) -> Option<Finding> + 'a;

/// What shrinking gave.
#[derive(Clone, Debug)]
pub struct ShrinkResult {
    /// The shortest session that was found.
    pub session: Session,
    /// What fails in it.
    pub finding: Finding,
    /// Whether time, or tries, ran out: there may be shorter ones.
    pub cut_short: bool,
}

/// A session that fails like `session` and from which no single request can be left out, in the
/// simplest configuration that was found; when `deadline` comes, the shortest by then.
///
/// Of a long session a copy or two are in memory at a time, and each try looks at the clock before it is made.
pub fn shrink(
    kind: &dyn Kind,
    session: Session,
    finding: &Finding,
    deadline: &Deadline,
    fails: &mut Fails<'_>,
) -> ShrinkResult {
    let (count, session, finding) = (session.requests().count(), Rc::new(session), finding.clone());
    let mut shrinking =
        Shrinker { kind, session, count, finding, deadline, fails, tries: 0, cut_short: false };
    shrinking.cut();
    shrinking.begin_late();
    if shrinking.count > LONG {
        shrinking.leave_out();
    }
    // Leaving out parts of a scene gives another scene, which is harder to simplify than the whole.
    shrinking.simplify_session();
    shrinking.simplify_session();
    shrinking.simplify_config();
    shrinking.simplify_requests();
    let Shrinker { session, finding, cut_short, .. } = shrinking;
    ShrinkResult { session: Rc::unwrap_or_clone(session), finding, cut_short }
}

struct Shrinker<'a, 'f> {
    kind: &'a dyn Kind,
    /// The shortest that fails.
    session: Rc<Session>,
    /// Its requests.
    count: usize,
    finding: Finding,
    deadline: &'a Deadline,
    fails: &'a mut Fails<'f>,
    tries: usize,
    cut_short: bool,
}

impl Shrinker<'_, '_> {
    /// Whether nothing more is tried, though there is something to try.
    fn is_over(&mut self) -> bool {
        let is_over = self.tries == MAX_TRIES || self.deadline.has_come();
        self.cut_short |= is_over;
        is_over
    }

    /// Takes `session` for the shortest if it fails.
    fn take(&mut self, session: Session) -> bool {
        if self.is_over() || self.kind.check(&session).is_err() {
            return false;
        }
        self.tries += 1;
        let Some(finding) = (self.fails)(&session) else { return false };
        self.count = session.requests().count();
        (self.session, self.finding) = (Rc::new(session), finding);
        true
    }

    /// The same with the requests whose places are `kept`, which are made only while there is time.
    fn take_those(&mut self, kept: impl Fn(usize) -> bool) -> bool {
        !self.is_over() && self.take(self.session.with_those(kept))
    }

    /// Leaves out what follows the request that fails.
    fn cut(&mut self) {
        if let Some(last) = self.finding.request.filter(|last| last + 1 < self.count) {
            self.take_those(|place| place <= last);
        }
    }

    /// Leaves out what stands before a flush, with which all begins anew: the last one, or as few before it
    /// as are needed, within a factor of two; the first one, where no later one will do.
    fn begin_late(&mut self) {
        let lines = self.session.requests().enumerate();
        let flushes: Vec<usize> = lines.filter(|(_, line)| *line == FLUSH).map(|(place, _)| place).collect();
        let backwards = std::iter::successors(Some(1), |back| Some(2 * back));
        let backwards = backwards.take_while(|back| *back < flushes.len());
        for back in backwards.chain((!flushes.is_empty()).then_some(flushes.len())) {
            let flush = flushes[flushes.len() - back];
            if self.take_those(|place| place > flush) {
                self.cut();
                return;
            }
        }
    }

    /// Leaves out ever smaller parts, until no single request can be.
    fn leave_out(&mut self) {
        let mut part = (self.count / 2).max(1);
        loop {
            let mut left_out = false;
            // From the end on: what fails stands there, and what it needs often shortly before.
            let mut end = self.count;
            while end > 0 {
                // Going through the parts of a long session takes time, even where none is tried.
                if self.is_over() {
                    return;
                }
                let begin = end.saturating_sub(part);
                if self.take_those(|place| !(begin..end).contains(&place)) {
                    left_out = true;
                    self.cut();
                }
                end = begin.min(self.count);
            }
            if part > 1 {
                part /= 2;
            } else if !left_out {
                return;
            }
        }
    }

    fn simplify_session(&mut self) {
        while self.take_simpler_session() {
            self.cut();
        }
        self.leave_out();
    }

    fn take_simpler_session(&mut self) -> bool {
        if self.is_over() {
            return false;
        }
        let (session, kind) = (Rc::clone(&self.session), self.kind);
        for simpler in kind.simpler_sessions(&session) {
            if self.is_over() {
                return false;
            }
            if simpler.requests().count() <= self.count && simpler != *session && self.take(simpler) {
                return true;
            }
        }
        false
    }

    fn simplify_config(&mut self) {
        loop {
            let simpler = self.kind.simpler_configs(self.session.config());
            let taken = |config: &String| !self.is_over() && self.take(self.session.with_config(config));
            if !simpler.iter().any(taken) {
                return;
            }
            self.cut();
            self.leave_out();
        }
    }

    fn simplify_requests(&mut self) {
        let (session, kind) = (Rc::clone(&self.session), self.kind);
        for (place, request) in session.requests().enumerate() {
            for simpler in kind.simpler_requests(&session, request) {
                if self.is_over() {
                    return;
                }
                if self.take(self.session.with_request(place, simpler.as_bytes())) {
                    break;
                }
            }
        }
        self.leave_out();
    }
}

/// The request with which all begins anew, in the kinds that have one.
const FLUSH: &[u8] = b"flush";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::Level;
    use crate::vm::Vm;

    /// Whatever the number of flushes, what stands before the first of them is left out.
    #[test]
    fn all_flushes_are_begun_behind() {
        for flushes in 1..9 {
            let requests = "r 0 1\n".to_owned() + &"flush\nr 10 1\n".repeat(flushes);
            let config = "line=16 lines=8 ways=2 hash=low policy=lru";
            let session = Session::new("late", "saarcor-vm 1", config, requests.as_bytes());
            let finding = Finding {
                level: Level::Traffic,
                requirement: "VM-4",
                request: None,
                asked: String::new(),
                expected: String::new(),
                got: String::new(),
                says: String::new(),
            };
            let needed =
                |session: &Session| session.requests().filter(|line| *line == b"r 10 1").count() == flushes;
            let mut shrinker = Shrinker {
                kind: &Vm,
                count: session.requests().count(),
                session: Rc::new(session),
                finding: finding.clone(),
                deadline: &Deadline::never(),
                fails: &mut |session| needed(session).then(|| finding.clone()),
                tries: 0,
                cut_short: false,
            };
            shrinker.begin_late();
            assert_eq!(shrinker.session.requests().next(), Some(&b"r 10 1"[..]), "{flushes}");
        }
    }
}
