//! Recorded traces as sessions: what a chip asks for in a real frame.
//!
//! A trace says which addresses are read, and not what lies there. So the host first writes to every
//! line that is read, and no two lines have the same bytes.

use super::config;
use crate::error::Error;
use crate::hex;
use crate::kind::Kind;
use crate::session::Session;
use saarcor_model::vm::HostAddr;
use saarcor_random::Random;
use std::collections::BTreeSet;

/// Traces of the kit by their names.
const FRAMES: &[(&str, &str)] =
    &[("pquake3-nt-150", include_str!("../../../../reference/oracles/traces/pquake3-nt-150.din"))];

/// Configurations that a trace is played with: the standard one, which holds all of a small frame,
/// and ones that do not.
pub(super) const CONFIGS: &[&str] = &[
    "line=128 lines=65536 ways=4 hash=add-upper policy=lru",
    "line=128 lines=512 ways=4 hash=add-upper policy=plru",
    "line=64 lines=64 ways=2 hash=add-upper-all policy=fifo",
];

/// Bytes that are read at each address, as far as its line has them: a word.
const READ_BYTES: u64 = 4;

/// The addresses of a trace in the form `din`: a row an access, the label 0 and the address in hex.
///
/// # Errors
/// The row that is wrong, and what would be right.
pub fn parse_din(text: &str) -> Result<Vec<HostAddr>, Error> {
    let row = |(row, line): (&str, usize)| {
        let wrong = |right: &str| Error::Line { line, right: format!("'{}': {right}", shown(row)) };
        let (label, address) = row.trim_end().split_once(' ').unwrap_or((row, ""));
        if label != "0" {
            return Err(wrong("write '0 ADDRESS', a read, with the address in hex"));
        }
        let address = hex::number(address.as_bytes()).and_then(|address| u32::try_from(address).ok());
        address.map(HostAddr).ok_or_else(|| wrong("an address is hex, and at most ffffffff"))
    };
    text.lines().zip(1..).map(row).collect()
}

/// Most characters of a row that are shown.
const SHOWN: usize = 40;

fn shown(row: &str) -> String {
    row.chars().take(SHOWN).collect()
}

/// The traces of the kit, each as sessions of `kind` of at most so many reads, as [`played`] makes them.
pub(crate) fn recorded(
    kind: &dyn Kind,
    configs: &[&str],
    reads: usize,
    requests: impl Fn(&[HostAddr], &str) -> Vec<u8>,
) -> Vec<Session> {
    let of_frame = |(name, din): &(&str, &str)| {
        let addresses = parse_din(din).expect("a trace of the kit, which a test reads");
        let name = format!("{}/frame/{name}", kind.prefix());
        played(&name, kind.hello(), configs, &addresses[..addresses.len().min(reads)], &requests)
    };
    FRAMES.iter().flat_map(of_frame).collect()
}

/// The first `reads` accesses of a trace as sessions of `saarcor-vm`, one for each configuration.
#[must_use]
pub fn sessions(name: &str, hello: &str, addresses: &[HostAddr], reads: usize) -> Vec<Session> {
    played(name, hello, CONFIGS, &addresses[..addresses.len().min(reads)], &requests)
}

/// Accesses as sessions, one for each configuration, for which `requests` makes the requests.
fn played(
    name: &str,
    hello: &str,
    configs: &[&str],
    played: &[HostAddr],
    requests: &dyn Fn(&[HostAddr], &str) -> Vec<u8>,
) -> Vec<Session> {
    let session = |(config, number): (&&str, usize)| {
        let name = if number == 0 { name.to_owned() } else { format!("{name}@{number}") };
        let mut session = Session::new(&name, hello, config, &requests(played, config));
        session.idea = format!("The first {} reads of a recorded frame.", played.len());
        session
    };
    configs.iter().zip(0..).map(session).collect()
}

/// Writes to each line, then the reads.
pub(super) fn requests(addresses: &[HostAddr], config: &str) -> Vec<u8> {
    let line_bytes = config::parse(config).map_or(1, |config| config.geometry.line().0);
    let mut text = Vec::new();
    let lines: BTreeSet<u64> = addresses.iter().map(|addr| u64::from(addr.0) / line_bytes).collect();
    for line in lines {
        let mut random = Random::new(line);
        let bytes: Vec<u8> = (0..line_bytes).map(|_| random.bits() as u8).collect();
        request(&mut text, b'w', line * line_bytes);
        hex::push_bytes(&mut text, &bytes);
        text.push(b'\n');
    }
    for addr in addresses {
        let addr = u64::from(addr.0);
        request(&mut text, b'r', addr);
        hex::push_number(&mut text, READ_BYTES.min(line_bytes - addr % line_bytes));
        text.push(b'\n');
    }
    text
}

fn request(text: &mut Vec<u8>, name: u8, host: u64) {
    text.extend_from_slice(&[name, b' ']);
    hex::push_number(text, host);
    text.push(b' ');
}

#[cfg(test)]
mod tests {
    use super::super::Vm;
    use super::*;

    #[test]
    fn rows_are_addresses() {
        assert_eq!(parse_din("0 8\r\n0 FFFFFFFF\n").ok(), Some(vec![HostAddr(8), HostAddr(u32::MAX)]));
        assert_eq!(parse_din("").ok(), Some(Vec::new()));
        for (text, line, says) in [
            ("0 8\n1 8\n", 2, "a read"),
            ("0 8\n\n", 2, "0 ADDRESS"),
            ("0 0x8\n", 1, "hex"),
            ("0 100000000\n", 1, "ffffffff"),
            ("address\n", 1, "'address'"),
        ] {
            let error = parse_din(text).expect_err(text).to_string();
            assert!(error.starts_with(&format!("line {line}: ")) && error.contains(says), "{text}: {error}");
        }
    }

    #[test]
    fn traces_are_sessions_whose_lines_differ() {
        for session in sessions("x", "saarcor-vm 1", &[HostAddr(0x7f), HostAddr(0x80), HostAddr(u32::MAX)], 3)
        {
            Vm.check(&session).expect("legal");
            let requests: Vec<_> = session.requests().collect();
            assert_eq!(requests.len(), 6);
            assert_eq!(requests[3..], [&b"r 7f 1"[..], b"r 80 4", b"r ffffffff 1"]);
            assert_ne!(requests[0][5..], requests[1][5..]);
        }
        for (_, din) in FRAMES {
            assert!(parse_din(din).is_ok_and(|addresses| addresses.len() > 1000));
        }
    }
}
