//! What is done before a signal ends this process.

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::io;
use std::sync::{Mutex, PoisonError};

type Actions = Vec<fn()>;

/// What is done at the end; none until signals are waited for.
static AT_END: Mutex<Option<Actions>> = Mutex::new(None);

/// Has `action` done before INT, TERM or HUP ends this process. A signal that it was started to ignore is ignored.
///
/// # Errors
/// If signals cannot be waited for.
pub fn before_end(action: fn()) -> io::Result<()> {
    let mut at_end = AT_END.lock().unwrap_or_else(PoisonError::into_inner);
    if at_end.is_none() {
        let ignored = ignored();
        let watched = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
        let mut signals = Signals::new(watched)?;
        std::thread::spawn(move || {
            if let Some(signal) = signals.forever().next() {
                let actions = AT_END.lock().unwrap_or_else(PoisonError::into_inner).take();
                actions.into_iter().flatten().for_each(|action| action());
                // Ends this process as the signal would have.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        });
    }
    at_end.get_or_insert_default().push(action);
    Ok(())
}

/// The signals that this process ignores, as bits from 1 on; none where the system does not say.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
