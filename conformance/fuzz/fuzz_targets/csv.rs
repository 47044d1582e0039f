//! A camera path and a file of lights: the same text as either.
#![no_main]

use libfuzzer_sys::fuzz_target;
use saarcor_scenes::{read_cameras, read_lights};
use std::fs;

fuzz_target!(|input: &[u8]| {
    let file = tempfile::NamedTempFile::new().expect("a file");
    fs::write(file.path(), input).expect("written");
    for camera in read_cameras(file.path()).unwrap_or_default() {
        assert!(camera.eye.is_finite() && (camera.dir.length() - 1.0).abs() < 1e-3);
    }
    for light in read_lights(file.path()).unwrap_or_default() {
        assert!(light.position.is_finite() && light.intensity.is_finite());
    }
});
