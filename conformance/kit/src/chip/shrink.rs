//! Packets that are simpler than others: what shrinking tries.

use super::request::Request;
use crate::session::Session;
use saarcor_model::time::Operation;

/// Requests with fewer operations than one, the boldest first.
fn fewer_operations(request: &Request) -> Vec<Request> {
    let operations = request.operations();
    let mut simpler = Vec::new();
    let mut part = operations.len();
    while part > 0 {
        for begin in (0..operations.len()).step_by(part).rev() {
            let mut fewer = operations.to_vec();
            fewer.drain(begin..(begin + part).min(operations.len()));
            simpler.push(request.with(fewer));
        }
        part /= 2;
    }
    simpler
}

/// The request with one ray in each operation that has more.
fn one_ray(request: &Request) -> Request {
    let one = |&operation: &Operation| Operation { rays: operation.rays.min(1), ..operation };
    request.with(request.operations().iter().map(one).collect())
}

/// Requests that are simpler than one: fewer rays, in all operations and in one of them.
pub fn requests(line: &[u8]) -> Vec<Request> {
    let Ok(request) = Request::parse(line) else { return Vec::new() };
    let operations = request.operations();
    let mut simpler = vec![one_ray(&request)];
    for (place, &operation) in operations.iter().enumerate() {
        let mut changed = operations.to_vec();
        changed[place] = Operation { rays: operation.rays.min(1), ..operation };
        simpler.push(request.with(changed));
    }
    simpler.retain(|simpler| *simpler != request);
    simpler
}

/// Sessions that are simpler: with one ray everywhere, or with fewer operations in one of the packets.
pub fn sessions(session: &Session) -> Vec<Session> {
    let parsed: Result<Vec<_>, _> = session.requests().map(Request::parse).collect();
    let Ok(requests) = parsed else { return Vec::new() };
    let text = |requests: &[Request]| {
        let lines: Vec<String> = requests.iter().map(Request::to_string).collect();
        session.with_requests(lines.iter().map(String::as_bytes))
    };
    let one_ray: Vec<_> = requests.iter().map(one_ray).collect();
    let mut sessions = Vec::new();
    if one_ray != requests {
        sessions.push(text(&one_ray));
    }
    for (place, request) in requests.iter().enumerate() {
        for simpler in fewer_operations(request) {
            let mut requests = requests.clone();
            requests[place] = simpler;
            sessions.push(text(&requests));
        }
    }
    sessions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sessions_become_simpler_until_nothing_is_left() {
        let text = b"b l,0,4,2\np n,1234,8,40 s,0,0,3 t,24,24,7\nrun\n";
        let mut session = Session::new("x", "saarcor-chip 1", "threads=1", text);
        let mut steps = 0;
        while let Some(simpler) = sessions(&session).pop() {
            session = simpler;
            steps += 1;
            assert!(steps < 100, "{:?}", session.text());
        }
        // Of each packet only that it is one.
        assert_eq!(session.requests().collect::<Vec<_>>(), [&b"b"[..], b"p", b"run"]);
    }

    #[test]
    fn boldest_steps_come_first() {
        let simpler =
            |line: &str| requests(line.as_bytes()).iter().map(Request::to_string).collect::<Vec<_>>();
        assert_eq!(
            simpler("p n,0,8,4 s,0,0,2"),
            ["p n,0,8,1 s,0,0,1", "p n,0,8,1 s,0,0,2", "p n,0,8,4 s,0,0,1"]
        );
        assert!(simpler("run").is_empty() && simpler("p n,0,8,1").is_empty());
        let session = Session::new("x", "saarcor-chip 1", "", b"p n,0,8,4 s,0,0,2\nrun\n");
        let first: Vec<_> = sessions(&session)
            .iter()
            .map(|session| session.text()[session.body_start()..].to_vec())
            .collect();
        assert_eq!(first[1], b"p\nrun\nend\n");
    }
}
