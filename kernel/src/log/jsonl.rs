//! One event as one line of JSON.
//!
//! Every object begins with `seq, t_ns, dur_ns, channel, kind, file, line`; the kind's own fields follow. `file` is
//! empty when `line` is 0 and belongs to no block. Invariant: each line is valid JSON whatever the texts and numbers
//! of the event are; a number that JSON cannot hold is `null`.

mod kinds;
#[cfg(test)]
mod tests;

use crate::log::event::Event;
use crate::log::info::Info;

/// Appends the event as one JSON object and a newline. `seq` is its number in the log, from 1.
pub fn write_event(info: &Info, seq: u64, event: &Event, out: &mut Vec<u8>) {
    out.extend_from_slice(b"{\"seq\":");
    value(out, &seq);
    integer(out, "t_ns", event.t_ns);
    integer(out, "dur_ns", event.dur_ns);
    integer(out, "channel", i64::from(event.channel));
    text(out, "kind", kinds::name(&event.kind));
    text(out, "file", if event.line == 0 { "" } else { info.file_name(event.file) });
    integer(out, "line", i64::from(event.line));
    kinds::write(info, event, out);
    out.extend_from_slice(b"}\n");
}

/// `,"name":`; names are plain ASCII of this project.
fn field(out: &mut Vec<u8>, name: &str) {
    out.extend_from_slice(b",\"");
    out.extend_from_slice(name.as_bytes());
    out.extend_from_slice(b"\":");
}

fn integer(out: &mut Vec<u8>, name: &str, number: i64) {
    field(out, name);
    value(out, &number);
}

fn float(out: &mut Vec<u8>, name: &str, number: f64) {
    field(out, name);
    bare_float(out, number);
}

/// Shortest text that reads back as the same number; whole numbers without `.0`, no minus zero.
fn bare_float(out: &mut Vec<u8>, number: f64) {
    value(out, &(number + 0.0));
    if out.ends_with(b".0") {
        out.truncate(out.len() - 2);
    }
}

fn text(out: &mut Vec<u8>, name: &str, text: &str) {
    field(out, name);
    value(out, text);
}

fn boolean(out: &mut Vec<u8>, name: &str, flag: bool) {
    field(out, name);
    value(out, &flag);
}

/// Writes by the rules of `serde_json`: escapes, shortest floats, `null` for what is not finite.
fn value<T: serde::Serialize + ?Sized>(out: &mut Vec<u8>, value: &T) {
    let start = out.len();
    if serde_json::to_writer(&mut *out, value).is_err() {
        // Cannot happen with a writer in memory; the line stays valid all the same.
        out.truncate(start);
        out.extend_from_slice(b"null");
    }
}
