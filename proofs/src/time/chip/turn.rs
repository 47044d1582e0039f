//! Theorems of who is next (CH-6).

use crate::draw::flag;
use crate::{check, cover, theorems};
use saarcor_model::time::Turn;

/// Members that ask.
const MEMBERS: usize = 4;
/// Numbers: the first ones, those of 16 and of 64 threads, and of 4 × 64.
static NUMBERS: [u16; 7] = [0, 1, 2, 15, 63, 64, 255];

theorems! {
    /// Of those that ask, the one is served that comes first after the one served last, round and round: so
    /// each other that asks is served before the same one is served again.
    #["CH-6", unwind 6, covers ["the next above", "round and round", "nobody before", "one of them was served last"]]
    fn turn_serves_the_next_that_asks(s) {
        let mut asking = [0_usize; MEMBERS];
        for i in 0..MEMBERS {
            let above = usize::from(s.value("numbers between two that ask", 0..=255, &NUMBERS[..5]));
            asking[i] = above + if i == 0 { 0 } else { asking[i - 1] + 1 };
        }
        let last = usize::from(s.value("served last", 0..=u16::MAX, &NUMBERS));
        let mut turn = Turn { last: if flag(s, "anyone before") { Some(last) } else { None } };
        let before = turn.last;
        let next = turn.next(&asking);
        // How far a member is behind the one served last, round and round.
        let behind = |member: usize| match before {
            Some(last) if member <= last => member + usize::from(u16::MAX) + 1 - last,
            Some(last) => member - last,
            None => member,
        };
        let mut asks = false;
        for member in asking {
            asks |= member == next;
            check!(behind(next) <= behind(member), "{next} after {before:?}, while {asking:?} ask");
        }
        cover!(s, "the next above", before.is_some_and(|last| next > last));
        cover!(s, "round and round", before.is_some_and(|last| next < last));
        cover!(s, "nobody before", before.is_none());
        cover!(s, "one of them was served last", before == Some(asking[0]));
        check!(asks && turn.last == Some(next), "{next} does not ask, or is not remembered: {asking:?}, {turn:?}");
    }
}
