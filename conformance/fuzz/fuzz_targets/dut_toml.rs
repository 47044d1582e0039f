//! The file `dut.toml`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use saarcor_kit::kinds::kind_named;
use saarcor_kit::target::DutFile;

fuzz_target!(|input: &[u8]| {
    if let Ok(file) = DutFile::parse(&String::from_utf8_lossy(input)) {
        assert!(kind_named(&file.kind).is_some());
        assert!(std::time::Duration::try_from_secs_f64(file.time_limit).is_ok_and(|limit| !limit.is_zero()));
    }
});
