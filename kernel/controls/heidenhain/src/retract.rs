//! M140: the tool goes back along its axis.
//!
//! Facts: programming manuals of the control (M140 MB and MB MAX, at the start of its block, with a feed of its own, at
//! rapid without one). Invariant: the words after it in the block form a block of their own, with the previous feed.

use super::Heidenhain;
use super::words::{EvaluatedWord, LeftBlock};
use counterpoint_control_api::host::InterpreterHost;

/// MB as the tables of the machine have it up to the end of travel.
const TO_THE_END: f64 = -1.0;

impl Heidenhain {
    /// Takes M140 with its words off a block and returns the blocks that execute it. There are none if the block has no
    /// such words or the machine has no register for them.
    pub(super) fn retract(&self, host: &dyn InterpreterHost, seen: &mut Vec<EvaluatedWord>) -> Vec<LeftBlock> {
        let at = seen.iter().position(|word| word.is("M") && word.value == Some(140.0));
        let Some(at) = at.filter(|_| host.is_register("MB")) else { return Vec::new() };
        let mut own = vec![seen.remove(at)];
        if seen.get(at).is_some_and(|word| word.is("MB")) {
            let way = seen.remove(at);
            if way.value.is_none() && seen.get(at).is_some_and(|word| word.is("MAX")) {
                seen.remove(at);
                own.push(EvaluatedWord::made("MB", TO_THE_END));
            } else {
                own.push(way);
            }
        }
        let feed = if seen.get(at).is_some_and(EvaluatedWord::is_rate) { Some(seen.remove(at)) } else { None };
        let changes = feed.as_ref().is_some_and(|feed| feed.is("F"));
        own.push(feed.unwrap_or_else(|| EvaluatedWord::text("FMAX")));
        let mut blocks = vec![own];
        blocks.extend(self.path.rates.last.clone().filter(|_| changes).map(|feed| vec![feed]));
        blocks
    }
}
