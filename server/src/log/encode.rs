//! Kernel events to their wire encoding, by hand: the hot path of every job.
//!
//! Invariant: what [`event`] writes decodes with the generated types to the same content (tested), so the `.proto`
//! files stay the only contract. Numbers of fields are those of `event.proto`.

use counterpoint_kernel::log::event::{
    Direction, Event, FeedUnit, Kind, MAX_AXES, Motion, MotionKind, Outlet, Phase, Position, Primitive, Stop,
    ToolAction, VerdictKind,
};

const VARINT: u8 = 0;
const FIXED64: u8 = 1;
const BYTES: u8 = 2;

/// Appends one event as field 3 of an `EventBatch`; `axes` is the number of axes of its channel.
pub fn event(out: &mut Vec<u8>, seq: u64, event: &Event, axes: usize) {
    nested(out, 3, |out| {
        varint_field(out, 1, seq);
        varint_field(out, 2, event.t_ns as u64);
        varint_field(out, 3, u64::from(event.micro));
        varint_field(out, 4, event.dur_ns as u64);
        varint_field(out, 5, u64::from(event.channel));
        varint_field(out, 6, u64::from(event.file));
        varint_field(out, 7, u64::from(event.line));
        kind(out, &event.kind, axes.min(MAX_AXES));
    });
}

/// Appends an event that is encoded already.
pub(crate) fn encoded(out: &mut Vec<u8>, event: &[u8]) {
    nested(out, 3, |out| out.extend_from_slice(event));
}

/// Appends a number field; zero is left out as proto3 does.
pub(crate) fn varint_field(out: &mut Vec<u8>, field: u8, value: u64) {
    if value != 0 {
        key(out, field, VARINT);
        varint(out, value);
    }
}

fn kind(out: &mut Vec<u8>, kind: &Kind, axes: usize) {
    match kind {
        Kind::Lifecycle(phase) => nested(out, 10, |out| varint_field(out, 1, self::phase(*phase))),
        Kind::Block { number } => nested(out, 11, |out| varint_field(out, 1, *number)),
        Kind::Motion(motion) => nested(out, 12, |out| self::motion(out, motion, axes)),
        Kind::Dwell => nested(out, 13, |_| {}),
        Kind::Tool { action, tool, offset } => nested(out, 14, |out| {
            varint_field(out, 1, tool_action(*action));
            varint_field(out, 2, u64::from(*tool));
            varint_field(out, 3, u64::from(*offset));
        }),
        Kind::ToolData(data) => nested(out, 29, |out| {
            varint_field(out, 1, u64::from(data.tool));
            text_field(out, 2, &data.name);
            for (field, value) in (3..).zip([data.diameter, data.radius, data.length]) {
                if let Some(value) = value {
                    key(out, field, FIXED64);
                    out.extend_from_slice(&value.to_le_bytes());
                }
            }
            varint_field(out, 6, u64::from(data.place));
        }),
        Kind::Spindle(spindle) => nested(out, 15, |out| {
            varint_field(out, 1, u64::from(spindle.spindle));
            varint_field(out, 2, direction(spindle.direction));
            varint_field(out, 3, u64::from(spindle.css));
            double_field(out, 4, spindle.speed);
            double_field(out, 5, spindle.limit);
            double_field(out, 6, spindle.angle);
        }),
        Kind::Coolant(coolant) => nested(out, 16, |out| {
            varint_field(out, 1, u64::from(coolant.on));
            varint_field(out, 2, u64::from(coolant.fluid));
            match coolant.outlet {
                Outlet::Main => {}
                Outlet::Side => varint_field(out, 3, 1),
                Outlet::Device(number) => varint_field(out, 4, u64::from(number)),
            }
        }),
        Kind::Function { letter, value } => nested(out, 17, |out| {
            text_field(out, 1, letter.encode_utf8(&mut [0; 4]));
            double_field(out, 2, *value);
        }),
        Kind::Mode { text } => nested(out, 18, |out| text_field(out, 1, text)),
        Kind::Frame { shift } => nested(out, 19, |out| position_field(out, 1, shift, axes)),
        Kind::Stop(stop) => nested(out, 20, |out| varint_field(out, 1, stop_kind(*stop))),
        Kind::Call { program, level } => nested(out, 21, |out| {
            text_field(out, 1, program);
            varint_field(out, 2, u64::from(*level));
        }),
        Kind::Return { level } => nested(out, 22, |out| varint_field(out, 1, u64::from(*level))),
        Kind::Message { text, printed } => nested(out, 23, |out| {
            text_field(out, 1, text);
            varint_field(out, 2, u64::from(*printed));
        }),
        Kind::Wait(wait) => nested(out, 24, |out| {
            text_field(out, 1, &wait.key);
            varint_field(out, 2, primitive(wait.primitive));
            channels_field(out, 3, &wait.participants);
        }),
        Kind::Release(release) => nested(out, 25, |out| {
            text_field(out, 1, &release.key);
            varint_field(out, 2, primitive(release.primitive));
            varint_field(out, 3, release.since_ns as u64);
            varint_field(out, 4, release.meeting);
        }),
        Kind::Diagnostic(diagnostic) => nested(out, 26, |out| {
            varint_field(out, 1, u64::from(diagnostic.number));
            varint_field(out, 2, u64::from(diagnostic.severity));
            text_field(out, 3, &diagnostic.text);
            text_field(out, 4, &diagnostic.operation);
            text_field(out, 5, &diagnostic.kernel);
            if let Some(origin) = &diagnostic.origin {
                nested(out, 6, |out| {
                    text_field(out, 1, &origin.name);
                    text_field(out, 2, &origin.file);
                    varint_field(out, 3, u64::from(origin.line));
                    text_field(out, 4, &origin.statement);
                });
            }
        }),
        Kind::Trace { letter, text } => nested(out, 28, |out| {
            text_field(out, 1, letter.encode_utf8(&mut [0; 4]));
            text_field(out, 2, text);
        }),
        Kind::Verdict(verdict) => nested(out, 27, |out| {
            varint_field(out, 1, verdict_kind(verdict.kind));
            varint_field(out, 2, verdict.at_ns as u64);
            text_field(out, 3, &verdict.text);
            for member in &verdict.members {
                nested(out, 4, |out| {
                    varint_field(out, 1, u64::from(member.channel));
                    varint_field(out, 2, u64::from(member.file));
                    varint_field(out, 3, u64::from(member.line));
                    channels_field(out, 4, &member.waiting_for);
                });
            }
        }),
    }
}

fn motion(out: &mut Vec<u8>, motion: &Motion, axes: usize) {
    varint_field(out, 1, motion_kind(motion.kind));
    varint_field(out, 2, u64::from(motion.moving));
    position_field(out, 3, &motion.from, axes);
    position_field(out, 4, &motion.to, axes);
    if motion.plane_axes != [255; 2] || motion.center.iter().any(|c| c.to_bits() != 0) {
        key(out, 5, BYTES);
        varint(out, 16);
        out.extend_from_slice(&motion.center[0].to_le_bytes());
        out.extend_from_slice(&motion.center[1].to_le_bytes());
        nested(out, 6, |out| motion.plane_axes.iter().for_each(|&axis| varint(out, u64::from(axis))));
    }
    varint_field(out, 7, u64::from(motion.turns));
    double_field(out, 8, motion.feed);
    varint_field(out, 9, feed_unit(motion.feed_unit));
    double_field(out, 10, motion.length);
}

/// Appends a length-delimited field whose content `body` writes.
#[inline]
fn nested(out: &mut Vec<u8>, field: u8, body: impl FnOnce(&mut Vec<u8>)) {
    key(out, field, BYTES);
    let at = out.len();
    out.push(0);
    body(out);
    let length = out.len() - at - 1;
    match out.get_mut(at) {
        Some(slot) if length < 0x80 => *slot = length as u8,
        _ => widen(out, at, length),
    }
}

/// Replaces the one byte at `at` by a longer varint.
#[cold]
fn widen(out: &mut Vec<u8>, at: usize, length: usize) {
    let mut bytes = Vec::with_capacity(5);
    varint(&mut bytes, length as u64);
    out.splice(at..=at, bytes);
}

#[inline]
fn key(out: &mut Vec<u8>, field: u8, wire: u8) {
    varint(out, u64::from(field) << 3 | u64::from(wire));
}

#[inline]
fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[inline]
fn double_field(out: &mut Vec<u8>, field: u8, value: f64) {
    if value.to_bits() != 0 {
        key(out, field, FIXED64);
        out.extend_from_slice(&value.to_le_bytes());
    }
}

#[inline]
fn position_field(out: &mut Vec<u8>, field: u8, position: &Position, axes: usize) {
    if axes == 0 {
        return;
    }
    key(out, field, BYTES);
    varint(out, axes as u64 * 8);
    for value in position.iter().take(axes) {
        out.extend_from_slice(&value.to_le_bytes());
    }
}

fn text_field(out: &mut Vec<u8>, field: u8, text: &str) {
    if !text.is_empty() {
        key(out, field, BYTES);
        varint(out, text.len() as u64);
        out.extend_from_slice(text.as_bytes());
    }
}

fn channels_field(out: &mut Vec<u8>, field: u8, channels: &[u16]) {
    if !channels.is_empty() {
        nested(out, field, |out| channels.iter().for_each(|&channel| varint(out, u64::from(channel))));
    }
}

/// One pair of functions per enum: number on the wire, and back.
macro_rules! numbers {
    ($($to:ident / $from:ident : $type:ident { $($name:ident = $number:literal),* $(,)? })*) => { $(
        fn $to(value: $type) -> u64 {
            match value { $($type::$name => $number),* }
        }

        pub(crate) fn $from(number: u64) -> Option<$type> {
            match number { $($number => Some($type::$name),)* _ => None }
        }
    )* };
}

numbers! {
    phase / phase_of: Phase {
        MachineStart = 1, ProgramStart = 2, NotStarted = 3, ProgramEnd = 4, Alarmed = 5, Stopped = 6, Blocked = 7,
        MachineEnd = 8,
    }
    motion_kind / motion_kind_of: MotionKind { Rapid = 1, Linear = 2, ArcCw = 3, ArcCcw = 4, Thread = 5, ArcSpace = 6 }
    feed_unit / feed_unit_of: FeedUnit { PerMinute = 1, PerRevolution = 2, InverseTime = 3, Rapid = 4 }
    tool_action / tool_action_of: ToolAction { Select = 1, Load = 2, Offset = 3 }
    direction / direction_of: Direction { Off = 1, Clockwise = 2, CounterClockwise = 3, Oriented = 4, Locked = 5, Neutral = 6 }
    stop_kind / stop_of: Stop { Program = 1, Optional = 2, End = 3, Rewind = 4 }
    primitive / primitive_of: Primitive { Barrier = 1, Flag = 2, Order = 3, Count = 4, Signal = 5, Join = 6 }
    verdict_kind / verdict_kind_of: VerdictKind {
        Cycle = 1, Mismatch = 2, PartnerEnded = 3, PartnerAlarmed = 4, PartnerNeverStarted = 5, PartnerSpinning = 6,
        LeaseCycle = 7, Limit = 8,
    }
}
