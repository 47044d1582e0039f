//! Delta debugging: the shortest requests that still fail in the same way (Zeller, Hildebrandt 2002).

use crate::deadline::Deadline;
use crate::kind::Kind;
use crate::scoreboard::Finding;
use crate::session::Session;

/// Conversations that are held at most to shrink one session.
const MAX_TRIES: usize = 1000;

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
pub fn shrink(
    kind: &dyn Kind,
    session: &Session,
    finding: &Finding,
    deadline: &Deadline,
    fails: &mut Fails<'_>,
) -> ShrinkResult {
    let requests = session.requests().map(<[u8]>::to_vec).collect();
    let (session, finding) = (session.clone(), finding.clone());
    let mut shrinking =
        Shrinker { kind, session, requests, finding, deadline, fails, tries: 0, cut_short: false };
    shrinking.cut();
    // Leaving out parts of a scene gives another scene, which is harder to simplify than the whole.
    shrinking.simplify_session();
    shrinking.simplify_session();
    shrinking.simplify_config();
    shrinking.simplify_requests();
    let Shrinker { session, finding, cut_short, .. } = shrinking;
    ShrinkResult { session, finding, cut_short }
}

struct Shrinker<'a, 'f> {
    kind: &'a dyn Kind,
    /// The shortest that fails, and its requests.
    session: Session,
    requests: Vec<Vec<u8>>,
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
        self.requests = session.requests().map(<[u8]>::to_vec).collect();
        (self.session, self.finding) = (session, finding);
        true
    }

    fn take_requests(&mut self, requests: &[Vec<u8>]) -> bool {
        self.take(self.session.with_requests(requests.iter().map(Vec::as_slice)))
    }

    /// Leaves out what follows the request that fails.
    fn cut(&mut self) {
        if let Some(last) = self.finding.request.filter(|last| last + 1 < self.requests.len()) {
            let requests = self.requests[..=last].to_vec();
            self.take_requests(&requests);
        }
    }

    /// Leaves out ever smaller parts, until no single request can be.
    fn leave_out(&mut self) {
        let mut part = (self.requests.len() / 2).max(1);
        loop {
            let mut left_out = false;
            // From the end on: what fails stands there, and what it needs often shortly before.
            let mut end = self.requests.len();
            while end > 0 {
                // Going through the parts of a long session takes time, even where none is tried.
                if self.is_over() {
                    return;
                }
                let begin = end.saturating_sub(part);
                let mut requests = self.requests.clone();
                requests.drain(begin..end);
                if self.take_requests(&requests) {
                    left_out = true;
                    self.cut();
                }
                end = begin.min(self.requests.len());
            }
            if part > 1 {
                part /= 2;
            } else if !left_out {
                return;
            }
        }
    }

    fn simplify_session(&mut self) {
        while self.kind.simpler_sessions(&self.session).into_iter().any(|session| {
            session.requests().count() <= self.requests.len() && session != self.session && self.take(session)
        }) {
            self.cut();
        }
        self.leave_out();
    }

    fn simplify_config(&mut self) {
        loop {
            let simpler = self.kind.simpler_configs(self.session.config());
            if !simpler.iter().any(|config| self.take(self.session.with_config(config))) {
                return;
            }
            self.cut();
            self.leave_out();
        }
    }

    fn simplify_requests(&mut self) {
        for place in 0..self.requests.len() {
            if self.is_over() {
                return;
            }
            for simpler in self.kind.simpler_requests(&self.session, &self.requests[place]) {
                let mut requests = self.requests.clone();
                requests[place] = simpler.into_bytes();
                if self.take_requests(&requests) {
                    break;
                }
            }
        }
        self.leave_out();
    }
}
