//! Theorems of the beats of the memory chips (SD-1).

use crate::draw::ENDS;
use crate::{check, check_eq, cover, theorems};
use saarcor_model::time::SdramConfig;

/// Bytes of a beat.
const BEAT: u64 = SdramConfig::STANDARD.beat_bytes as u64;

theorems! {
    /// A transfer moves the fewest whole, aligned beats that hold its bytes.
    #["SD-1", unwind 4, covers ["one beat", "a beat more than its bytes need", "aligned"]]
    fn transfer_moves_the_beats_that_hold_its_bytes(s) {
        let addr = u64::from(s.value("address", 0..=u32::MAX, &ENDS));
        let bytes = u64::from(s.value("bytes", 1..=u16::MAX, &[1, 2, 15, 16, 17, 32, 36, 128]));
        let beats = SdramConfig::STANDARD.beats(addr, bytes);
        let first = addr & !(BEAT - 1);
        cover!(s, "one beat", beats == 1);
        cover!(s, "a beat more than its bytes need", (beats - 1) * BEAT >= bytes);
        cover!(s, "aligned", first == addr && beats * BEAT == bytes);
        check!(first + beats * BEAT >= addr + bytes, "{bytes} bytes at {addr}: {beats} beats are too few");
        check!(first + (beats - 1) * BEAT < addr + bytes, "{bytes} bytes at {addr}: {beats} beats are too many");
        check_eq!(SdramConfig::STANDARD.moved(addr, bytes), beats * BEAT, "{bytes} bytes at {addr}: bytes moved");
    }

    /// A triangle is always three beats, and a kd-node or a list entry one, wherever it lies.
    #["SD-1", unwind 4, covers ["a triangle", "a kd-node", "a list entry"]]
    fn items_of_the_scene_are_whole_beats(s) {
        let number = u64::from(s.value("number", 0..=u32::MAX >> 6, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 1000]));
        let item = s.value("item (triangle, kd-node, list entry)", 0..=2, &[0, 1, 2_u8]);
        let (bytes, beats) = [(36, 3), (8, 1), (4, 1)][usize::from(item)];
        cover!(s, "a triangle", item == 0);
        cover!(s, "a kd-node", item == 1);
        cover!(s, "a list entry", item == 2);
        check_eq!(SdramConfig::STANDARD.beats(number * bytes, bytes), beats, "{bytes} bytes at {number} * {bytes}");
    }
}
