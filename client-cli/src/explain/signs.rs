//! Signs of the program text: block skip, rewind-stop, comments, end of block.
//!
//! *Invariant:* the signs are those of `[format]` of the machine.

use counterpoint_kernel::machine::model::ProgramTextFormat;

/// The meaning of a sign on a machine.
pub(super) fn meaning(format: &ProgramTextFormat, sign: &str) -> Option<String> {
    let is = |mark: Option<char>| mark.is_some_and(|mark| sign.chars().eq([mark]));
    let around = |pair: Option<&(String, String)>, kind: &str| {
        let (start, end) = pair?;
        let until = if end.is_empty() { "the end of the block".to_owned() } else { format!("'{end}'") };
        (sign == start).then(|| format!("begins a {kind}, up to {until}"))
    };
    if is(format.opskip_mark) {
        let level = format.opskip_default;
        return Some(format!(
            "block skip: the block is skipped if its level is on; without a digit the level is {level}"
        ));
    }
    if !format.rws.is_empty() && sign == format.rws {
        return Some("rewind-stop: start and end of the program text, alone on a line".to_owned());
    }
    if is(format.eob) {
        return Some("end of the block".to_owned());
    }
    around(format.comment.as_ref(), "comment").or_else(|| around(format.message.as_ref(), "message to the operator"))
}
