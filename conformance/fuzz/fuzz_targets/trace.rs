//! A recorded trace, and the sessions that it makes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use saarcor_kit::kind::Kind as _;
use saarcor_kit::vm::Vm;
use saarcor_kit::vm::trace::{parse_din, sessions};

fuzz_target!(|input: &[u8]| {
    let text = String::from_utf8_lossy(input);
    if let Ok(addresses) = parse_din(&text) {
        assert_eq!(addresses.len(), text.lines().count());
        for session in sessions("fuzz", Vm.hello(), &addresses, 100) {
            Vm.check(&session).expect("legal");
        }
    }
});
