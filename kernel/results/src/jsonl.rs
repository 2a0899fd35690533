//! One event as one line of JSON.
//!
//! Every object begins with `seq, t_ns, dur_ns, channel, kind, file, line`, and with `caller_file, caller_line` inside a
//! shipped program; the kind's own fields follow, and the word of a diagnostic after its fields. `file` is empty when
//! `line` is 0 and belongs to no block. *Invariants:* each line is valid JSON, whatever the texts and numbers of the event
//! are; a number that JSON cannot hold is `null`; positions are objects with every axis of the channel, in
//! channel order.

#[cfg(test)]
mod tests;

use crate::geometry::Loop;
use counterpoint_event::event::fields::{EventField, EventRecord, EventValue, FieldWriter, Presence};
use counterpoint_event::event::{Event, Kind, Motion, MotionKind};
use counterpoint_event::info::{Info, JobAxis};
use counterpoint_fault as diag;

/// Appends the event as one JSON object and a newline. `seq` is its number in the log, from 1.
pub fn write_event(info: &Info, seq: u64, event: &Event, out: &mut Vec<u8>) {
    let axes = info.channel(event.channel).map_or(&[][..], |c| &c.axes);
    let motion = if let Kind::Motion(motion) = &event.kind { Some(motion) } else { None };
    let mut object = Object { info, axes, motion, out, first: true };
    object.out.push(b'{');
    event.head(seq, &mut object);
    event.kind.fields(&mut object);
    if let Kind::Diagnostic(diagnostic) = &event.kind
        && let Some(name) = diag::name(diagnostic.number)
    {
        object.name("name");
        serial(object.out, name);
    }
    out.extend_from_slice(b"}\n");
}

/// A JSON object that is being written.
struct Object<'a> {
    info: &'a Info,
    /// Those of the channel.
    axes: &'a [JobAxis],
    motion: Option<&'a Motion>,
    out: &'a mut Vec<u8>,
    /// It has no member yet.
    first: bool,
}

impl FieldWriter for Object<'_> {
    #[inline]
    fn put(&mut self, field: EventField, value: EventValue<'_>) {
        match field.json {
            Presence::Never => return,
            Presence::NotBlank if value.is_blank() => return,
            _ => {}
        }
        if value == EventValue::Center {
            self.motion.into_iter().for_each(|motion| self.center(field.name, motion));
        } else {
            self.name(field.name);
            self.value(value);
        }
    }

    fn message<R: EventRecord>(&mut self, field: EventField, record: Option<&R>) {
        if field.json == Presence::Never {
            return;
        }
        if let Some(record) = record {
            self.name(field.name);
            self.object(record);
        }
    }

    fn messages<R: EventRecord>(&mut self, field: EventField, records: &[R]) {
        if field.json == Presence::Never {
            return;
        }
        self.name(field.name);
        self.out.push(b'[');
        for (index, record) in records.iter().enumerate() {
            if index > 0 {
                self.out.push(b',');
            }
            self.object(record);
        }
        self.out.push(b']');
    }
}

impl Object<'_> {
    /// Appends `"name":`; names are plain ASCII of this project.
    fn name(&mut self, name: &str) {
        self.out.extend_from_slice(if std::mem::take(&mut self.first) { b"\"" } else { b",\"" });
        self.out.extend_from_slice(name.as_bytes());
        self.out.extend_from_slice(b"\":");
    }

    fn object(&mut self, record: &impl EventRecord) {
        self.out.push(b'{');
        let mut inner = Object { motion: None, out: self.out, first: true, ..*self };
        record.fields(&mut inner);
        self.out.push(b'}');
    }

    fn value(&mut self, value: EventValue<'_>) {
        let out = &mut *self.out;
        match value {
            EventValue::Bool(flag) => serial(out, &flag),
            EventValue::U8(number) => serial(out, &number),
            EventValue::U16(number) => serial(out, &number),
            EventValue::U32(number) => serial(out, &number),
            EventValue::U64(number) => serial(out, &number),
            EventValue::I64(number) => serial(out, &number),
            EventValue::Float(number) => float(out, number),
            EventValue::Known(number) => float(out, number.unwrap_or(f64::NAN)),
            EventValue::Text(text) | EventValue::Word(_, text) | EventValue::Named(_, text) => serial(out, text),
            EventValue::Letter(letter) => serial(out, &letter),
            EventValue::Channels(channels) => serial(out, channels),
            EventValue::Position(position) => by_axis(out, self.axes.iter().zip(position.iter().copied())),
            EventValue::Axes(axes) => serial(out, axes),
            EventValue::Pair(pair) => serial(out, pair),
            EventValue::File(file, line) => serial(out, if line == 0 { "" } else { self.info.file_name(file) }),
            EventValue::Center => {}
        }
    }

    /// The centre of an arc in its plane; centre and middle of a circle in space.
    fn center(&mut self, name: &str, motion: &Motion) {
        let axes = self.axes;
        if matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw) {
            let plane = motion.plane_axes.iter().map(|&i| axes.get(usize::from(i)));
            self.name(name);
            by_axis(self.out, plane.zip(motion.center).filter_map(|(axis, value)| Some((axis?, value))));
        }
        if let Some(space) = Loop::of(motion, axes) {
            for (name, point) in [(name, space.circle.center), ("middle", space.circle.at(0.5))] {
                self.name(name);
                by_axis(self.out, space.seen.values(point).filter_map(|(at, value)| Some((axes.get(at)?, value))));
            }
        }
    }
}

/// An object with a value for each of some axes.
fn by_axis<'a>(out: &mut Vec<u8>, values: impl Iterator<Item = (&'a JobAxis, f64)>) {
    out.push(b'{');
    for (index, (axis, number)) in values.enumerate() {
        if index > 0 {
            out.push(b',');
        }
        serial(out, axis.name.as_str());
        out.push(b':');
        float(out, number);
    }
    out.push(b'}');
}

/// Shortest text that reads back as the same number; whole numbers without `.0`, no minus zero.
fn float(out: &mut Vec<u8>, number: f64) {
    serial(out, &(number + 0.0));
    if out.ends_with(b".0") {
        out.truncate(out.len() - 2);
    }
}

/// Writes by the rules of `serde_json`: escapes, shortest floats, `null` for numbers that are not finite.
fn serial<T: serde::Serialize + ?Sized>(out: &mut Vec<u8>, value: &T) {
    let start = out.len();
    if serde_json::to_writer(&mut *out, value).is_err() {
        // Cannot happen with a writer in memory; the line stays valid nevertheless.
        out.truncate(start);
        out.extend_from_slice(b"null");
    }
}
