//! The fields of each kind of event.
//!
//! Invariant: positions are objects with every axis of the channel, in channel order.

use super::{bare_float, boolean, field, float, integer, text, value};
use crate::log::event::{
    Coolant, Direction, Event, Kind, Motion, MotionKind, Outlet, Position, Spindle, ToolData, Verdict,
};
use crate::log::geometry::Loop;
use crate::log::info::{Axis, Info};

/// Name of a kind.
pub(super) fn name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Lifecycle(_) => "lifecycle",
        Kind::Block { .. } => "block",
        Kind::Motion(_) => "motion",
        Kind::Dwell => "dwell",
        Kind::Tool { .. } => "tool",
        Kind::ToolData(_) => "tool_data",
        Kind::Spindle(_) => "spindle",
        Kind::Coolant(_) => "coolant",
        Kind::Function { .. } => "function",
        Kind::Mode { .. } => "mode",
        Kind::Frame { .. } => "frame",
        Kind::Stop(_) => "stop",
        Kind::Call { .. } => "call",
        Kind::Return { .. } => "return",
        Kind::Message { .. } => "message",
        Kind::Wait(_) => "wait",
        Kind::Release(_) => "release",
        Kind::Diagnostic(_) => "diagnostic",
        Kind::Verdict(_) => "verdict",
        Kind::Trace { .. } => "trace",
    }
}

/// Appends the fields of the event's kind.
pub(super) fn write(info: &Info, event: &Event, out: &mut Vec<u8>) {
    let axes = info.channel(event.channel).map_or(&[][..], |c| &c.axes);
    match &event.kind {
        Kind::Dwell => {}
        Kind::Lifecycle(phase) => serial(out, "phase", phase),
        Kind::Block { number } => serial(out, "number", number),
        Kind::Motion(motion) => write_motion(axes, motion, out),
        Kind::Tool { action, tool, offset } => {
            serial(out, "action", action);
            integer(out, "tool", i64::from(*tool));
            integer(out, "offset", i64::from(*offset));
        }
        Kind::ToolData(data) => write_tool_data(data, out),
        Kind::Spindle(spindle) => write_spindle(spindle, out),
        Kind::Coolant(coolant) => write_coolant(coolant, out),
        Kind::Function { letter, value } => {
            text(out, "letter", letter.encode_utf8(&mut [0; 4]));
            float(out, "value", *value);
        }
        Kind::Mode { text: words } => text(out, "text", words),
        Kind::Message { text: words, printed } => {
            text(out, "text", words);
            if *printed {
                boolean(out, "printed", *printed);
            }
        }
        Kind::Frame { shift } => position(out, "shift", axes, shift),
        Kind::Stop(stop) => serial(out, "stop", stop),
        Kind::Call { program, level } => {
            text(out, "program", program);
            integer(out, "level", i64::from(*level));
        }
        Kind::Return { level } => integer(out, "level", i64::from(*level)),
        Kind::Wait(wait) => {
            text(out, "key", &wait.key);
            serial(out, "primitive", &wait.primitive);
            serial(out, "participants", &wait.participants);
        }
        Kind::Release(release) => {
            text(out, "key", &release.key);
            serial(out, "primitive", &release.primitive);
            integer(out, "since_ns", release.since_ns);
            serial(out, "meeting", &release.meeting);
        }
        Kind::Diagnostic(diagnostic) => {
            integer(out, "number", i64::from(diagnostic.number));
            integer(out, "severity", i64::from(diagnostic.severity));
            text(out, "text", &diagnostic.text);
            if !diagnostic.operation.is_empty() {
                text(out, "operation", &diagnostic.operation);
            }
            if !diagnostic.kernel.is_empty() {
                text(out, "kernel", &diagnostic.kernel);
            }
            if let Some(origin) = &diagnostic.origin {
                serial(out, "origin", origin);
            }
        }
        Kind::Trace { letter, text: line } => {
            text(out, "letter", letter.encode_utf8(&mut [0; 4]));
            text(out, "text", line);
        }
        Kind::Verdict(verdict) => write_verdict(info, verdict, out),
    }
}

fn serial<T: serde::Serialize>(out: &mut Vec<u8>, name: &str, what: &T) {
    field(out, name);
    value(out, what);
}

fn write_motion(axes: &[Axis], motion: &Motion, out: &mut Vec<u8>) {
    let kind = match motion.kind {
        MotionKind::Rapid => "rapid",
        MotionKind::Linear => "linear",
        MotionKind::ArcCw => "arc_cw",
        MotionKind::ArcCcw => "arc_ccw",
        MotionKind::ArcSpace => "arc_space",
        MotionKind::Thread => "thread",
    };
    text(out, "motion", kind);
    position(out, "from", axes, &motion.from);
    position(out, "to", axes, &motion.to);
    if matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw) {
        let plane = motion.plane_axes.iter().map(|&i| axes.get(usize::from(i)));
        object(out, "center", plane.zip(motion.center).filter_map(|(axis, v)| Some((axis?, v))));
    }
    if let Some(space) = Loop::of(motion, axes) {
        let at = |point| space.seen.values(point).filter_map(|(at, value)| Some((axes.get(at)?, value)));
        object(out, "center", at(space.circle.center));
        object(out, "middle", at(space.circle.at(0.5)));
    }
    float(out, "feed", motion.feed);
    serial(out, "feed_unit", &motion.feed_unit);
    float(out, "length", motion.length);
    if motion.turns > 0 {
        integer(out, "turns", i64::from(motion.turns));
    }
}

/// What is not known is left out.
fn write_tool_data(data: &ToolData, out: &mut Vec<u8>) {
    integer(out, "tool", i64::from(data.tool));
    if !data.name.is_empty() {
        text(out, "name", &data.name);
    }
    for (name, value) in [("diameter", data.diameter), ("radius", data.radius), ("length", data.length)] {
        if let Some(value) = value {
            float(out, name, value);
        }
    }
    if data.place > 0 {
        integer(out, "place", i64::from(data.place));
    }
}

fn write_spindle(spindle: &Spindle, out: &mut Vec<u8>) {
    integer(out, "spindle", i64::from(spindle.spindle));
    serial(out, "direction", &spindle.direction);
    boolean(out, "css", spindle.css);
    float(out, "speed", spindle.speed);
    float(out, "limit", spindle.limit);
    if spindle.direction == Direction::Oriented {
        float(out, "angle", spindle.angle);
    }
}

fn write_coolant(coolant: &Coolant, out: &mut Vec<u8>) {
    boolean(out, "on", coolant.on);
    text(out, "fluid", coolant.word());
    match coolant.outlet {
        Outlet::Main => text(out, "outlet", "main"),
        Outlet::Side => text(out, "outlet", "side"),
        Outlet::Device(number) => {
            text(out, "outlet", "device");
            integer(out, "device", i64::from(number));
        }
    }
}

fn write_verdict(info: &Info, verdict: &Verdict, out: &mut Vec<u8>) {
    serial(out, "verdict", &verdict.kind);
    integer(out, "at_ns", verdict.at_ns);
    text(out, "text", &verdict.text);
    field(out, "members");
    out.push(b'[');
    for (index, member) in verdict.members.iter().enumerate() {
        out.extend_from_slice(if index == 0 { b"{\"channel\":" } else { b",{\"channel\":" });
        value(out, &member.channel);
        text(out, "file", if member.line == 0 { "" } else { info.file_name(member.file) });
        integer(out, "line", i64::from(member.line));
        serial(out, "waiting_for", &member.waiting_for);
        out.push(b'}');
    }
    out.push(b']');
}

fn position(out: &mut Vec<u8>, name: &str, axes: &[Axis], position: &Position) {
    object(out, name, axes.iter().zip(position.iter().copied()));
}

fn object<'a>(out: &mut Vec<u8>, name: &str, values: impl Iterator<Item = (&'a Axis, f64)>) {
    field(out, name);
    out.push(b'{');
    for (index, (axis, number)) in values.enumerate() {
        if index > 0 {
            out.push(b',');
        }
        value(out, axis.name.as_str());
        out.push(b':');
        bare_float(out, number);
    }
    out.push(b'}');
}
