//! Packets that are simpler than others: what shrinking tries.

use super::request::Request;
use crate::session::Session;
use saarcor_model::time::Operation;

/// Requests with fewer operations than one, the boldest first.
fn fewer_operations(request: Request) -> impl Iterator<Item = Request> {
    let count = request.operations().len();
    let halves = std::iter::successors(Some(count), |part| Some(part / 2)).take_while(|part| *part > 0);
    let parts = halves.flat_map(move |part| (0..count).step_by(part).rev().map(move |begin| (begin, part)));
    parts.map(move |(begin, part)| {
        let mut fewer = request.operations().to_vec();
        fewer.drain(begin..(begin + part).min(count));
        request.with(fewer)
    })
}

/// The request with one ray in each operation that has more.
fn one_ray(request: &Request) -> Request {
    let one = |&operation: &Operation| Operation { rays: operation.rays.min(1), ..operation };
    request.with(request.operations().iter().map(one).collect())
}

/// Requests that are simpler than one: fewer rays, in all operations and in one of them.
pub fn requests(line: &[u8]) -> impl Iterator<Item = Request> {
    Request::parse(line).into_iter().flat_map(|request| {
        let original = request.clone();
        let in_one = (0..request.operations().len()).map(move |place| {
            let mut changed = request.operations().to_vec();
            changed[place].rays = changed[place].rays.min(1);
            request.with(changed)
        });
        std::iter::once(one_ray(&original)).chain(in_one).filter(move |simpler| *simpler != original)
    })
}

/// Sessions that are simpler: with one ray everywhere, or with fewer operations in one of the packets.
pub fn sessions(session: &Session) -> impl Iterator<Item = Session> {
    let with_one_ray = std::iter::once_with(|| {
        let simpler =
            |line| Request::parse(line).map_or_else(|_| Vec::new(), |request| one_ray(&request).text());
        let requests: Vec<_> = session.requests().map(simpler).collect();
        session.with_requests(requests.iter().map(Vec::as_slice))
    });
    let with_fewer = session.requests().enumerate().flat_map(move |(place, line)| {
        let simpler = Request::parse(line).into_iter().flat_map(fewer_operations);
        simpler.map(move |simpler| session.with_request(place, &simpler.text()))
    });
    with_one_ray.filter(move |simpler| simpler != session).chain(with_fewer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sessions_become_simpler_until_nothing_is_left() {
        let text = b"b l,0,4,2\np n,1234,8,40 s,0,0,3 t,24,24,7\nrun\n";
        let mut session = Session::new("x", "saarcor-chip 1", "threads=1", text);
        let mut steps = 0;
        while let Some(simpler) = sessions(&session).last() {
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
            |line: &str| requests(line.as_bytes()).map(|simpler| simpler.to_string()).collect::<Vec<_>>();
        assert_eq!(
            simpler("p n,0,8,4 s,0,0,2"),
            ["p n,0,8,1 s,0,0,1", "p n,0,8,1 s,0,0,2", "p n,0,8,4 s,0,0,1"]
        );
        assert!(simpler("run").is_empty() && simpler("p n,0,8,1").is_empty());
        let session = Session::new("x", "saarcor-chip 1", "", b"p n,0,8,4 s,0,0,2\nrun\n");
        let first: Vec<_> =
            sessions(&session).map(|session| session.text()[session.body_start()..].to_vec()).collect();
        assert_eq!(first[1], b"p\nrun\nend\n");
    }
}
