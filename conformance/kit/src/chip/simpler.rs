//! Packets that are simpler than others: what shrinking tries.

use super::request::Request;
use crate::session::Session;
use saarcor_model::program::Operation;
use saarcor_model::units::HostAddr;

/// Packets that are simpler than one, the boldest first: fewer operations, then fewer rays, fewer bytes
/// and lower addresses.
pub fn requests(request: &[u8]) -> Vec<Request> {
    let Ok(request) = Request::parse(request) else { return Vec::new() };
    let operations = request.operations();
    let mut simpler = Vec::new();
    let mut part = operations.len();
    while part > 0 {
        for begin in (0..operations.len()).step_by(part).rev() {
            let mut fewer = operations.to_vec();
            fewer.drain(begin..(begin + part).min(operations.len()));
            simpler.push(fewer);
        }
        part /= 2;
    }
    for (place, operation) in operations.iter().enumerate() {
        for smaller in smaller(operation) {
            let mut changed = operations.to_vec();
            changed[place] = smaller;
            simpler.push(changed);
        }
    }
    simpler.into_iter().map(|operations| request.with(operations)).collect()
}

/// Operations that are simpler than one by one number, which is less.
fn smaller(operation: &Operation) -> Vec<Operation> {
    let &Operation { addr, bytes, rays, .. } = operation;
    let mut steps = Vec::new();
    if bytes > 0 {
        steps.push(Operation { rays: 0, ..*operation });
        steps.push(Operation { addr: HostAddr(0), ..*operation });
        steps.push(Operation { bytes: 1, ..*operation });
        // The first byte of a page, of a beat, and halfway.
        steps.extend([0xfff, 0xf].map(|low| Operation { addr: HostAddr(addr.0 & !low), ..*operation }));
        steps.push(Operation { addr: HostAddr(addr.0 / 2), ..*operation });
    } else {
        steps.push(Operation { addr: HostAddr(0), ..*operation });
    }
    steps.push(Operation { rays: rays.min(1), ..*operation });
    steps.push(Operation { rays: rays.div_ceil(2), ..*operation });
    steps.retain(|simpler| simpler != operation);
    steps
}

/// The sessions in which one packet is simpler.
pub fn sessions(session: &Session) -> Vec<Session> {
    let lines: Vec<&[u8]> = session.requests().collect();
    let mut sessions = Vec::new();
    for (place, line) in lines.iter().enumerate() {
        for request in requests(line) {
            let text = request.to_string();
            let mut lines = lines.clone();
            lines[place] = text.as_bytes();
            sessions.push(session.with_requests(lines));
        }
    }
    sessions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_become_simpler_until_nothing_is_left() {
        let mut line = "p n,1234,8,40 s,0,0,3 t,24,24,7".to_owned();
        let mut steps = 0;
        while let Some(simpler) = requests(line.as_bytes()).last() {
            line = simpler.to_string();
            assert!(Request::parse(line.as_bytes()).is_ok(), "{line}");
            steps += 1;
            assert!(steps < 100, "{line}");
        }
        // Of each operation only what has to be.
        assert_eq!(line, "p");
    }

    #[test]
    fn the_boldest_step_comes_first() {
        assert_eq!(requests(b"p n,0,8,1 n,8,8,1").first().map(Request::to_string).as_deref(), Some("p"));
        assert!(requests(b"run").is_empty() && requests(b"p").is_empty());
    }
}
