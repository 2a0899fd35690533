//! Kernel events to their wire encoding: the hot path of every job.
//!
//! Numbers and order of the fields come from the types of the events. *Invariant:* the output of [`event`] decodes with
//! the generated types to the same content (tested), so the `.proto` files stay the only contract.

use counterpoint_kernel::log::event::fields::{EventField, EventRecord, EventValue, FieldWriter};
use counterpoint_kernel::log::event::{Event, MAX_AXES};

const VARINT: u8 = 0;
const FIXED64: u8 = 1;
const BYTES: u8 = 2;

/// Appends one event as field 3 of an `EventBatch`; `axes` is the number of axes of its channel.
pub fn event(out: &mut Vec<u8>, seq: u64, event: &Event, axes: usize) {
    let mut wire = Wire { out, axes: axes.min(MAX_AXES) };
    wire.nested(3, |wire| {
        event.head(seq, wire);
        wire.nested(event.kind.number(), |wire| event.kind.fields(wire));
    });
}

/// Appends an event that is encoded already.
pub(crate) fn encoded(out: &mut Vec<u8>, event: &[u8]) {
    Wire { out, axes: 0 }.bytes(3, event);
}

/// Appends a number field; zero is left out as proto3 does.
pub(crate) fn varint_field(out: &mut Vec<u8>, tag: u8, value: u64) {
    Wire { out, axes: 0 }.number(tag, value);
}

/// A message that is being written.
struct Wire<'a> {
    out: &'a mut Vec<u8>,
    /// Axes of the channel.
    axes: usize,
}

impl FieldWriter for Wire<'_> {
    #[inline(always)]
    fn put(&mut self, field: EventField, value: EventValue<'_>) {
        let tag = field.tag;
        if tag == 0 {
            return;
        }
        match value {
            EventValue::Bool(flag) => self.number(tag, u64::from(flag)),
            EventValue::U8(number) | EventValue::Word(number, _) | EventValue::Named(number, _) => {
                self.number(tag, number.into())
            }
            EventValue::U16(number) | EventValue::File(number, _) => self.number(tag, number.into()),
            EventValue::U32(number) => self.number(tag, number.into()),
            EventValue::U64(number) => self.number(tag, number),
            EventValue::I64(number) => self.number(tag, number as u64),
            EventValue::Float(number) if number.to_bits() == 0 => {}
            EventValue::Float(number) | EventValue::Known(Some(number)) => {
                self.key(tag, FIXED64);
                self.out.extend_from_slice(&number.to_le_bytes());
            }
            EventValue::Known(None) | EventValue::Center => {}
            EventValue::Text(text) => self.text(tag, text),
            EventValue::Letter(letter) => self.text(tag, letter.encode_utf8(&mut [0; 4])),
            EventValue::Channels([]) => {}
            EventValue::Channels(channels) => self.varints(tag, channels),
            EventValue::Position(position) => self.floats(tag, position.get(..self.axes).unwrap_or_default()),
            EventValue::Axes(axes) => self.varints(tag, axes),
            EventValue::Pair(pair) => self.floats(tag, pair),
        }
    }

    fn message<R: EventRecord>(&mut self, field: EventField, record: Option<&R>) {
        if let (Some(record), 1..) = (record, field.tag) {
            self.nested(field.tag, |wire| record.fields(wire));
        }
    }

    fn messages<R: EventRecord>(&mut self, field: EventField, records: &[R]) {
        records.iter().for_each(|record| self.message(field, Some(record)));
    }
}

impl Wire<'_> {
    /// Appends a length-delimited field whose content `body` writes.
    #[inline]
    fn nested(&mut self, tag: u8, body: impl FnOnce(&mut Self)) {
        self.key(tag, BYTES);
        let at = self.out.len();
        self.out.push(0);
        body(self);
        let length = self.out.len() - at - 1;
        match self.out.get_mut(at) {
            Some(slot) if length < 0x80 => *slot = length as u8,
            _ => self.widen(at, length),
        }
    }

    /// Replaces the one byte at `at` by a longer varint.
    #[cold]
    fn widen(&mut self, at: usize, length: usize) {
        let mut bytes = Vec::with_capacity(5);
        varint(&mut bytes, length as u64);
        self.out.splice(at..=at, bytes);
    }

    #[inline]
    fn key(&mut self, tag: u8, wire: u8) {
        varint(self.out, u64::from(tag) << 3 | u64::from(wire));
    }

    #[inline]
    fn number(&mut self, tag: u8, value: u64) {
        if value != 0 {
            self.key(tag, VARINT);
            varint(self.out, value);
        }
    }

    fn text(&mut self, tag: u8, text: &str) {
        if !text.is_empty() {
            self.bytes(tag, text.as_bytes());
        }
    }

    fn bytes(&mut self, tag: u8, bytes: &[u8]) {
        self.key(tag, BYTES);
        varint(self.out, bytes.len() as u64);
        self.out.extend_from_slice(bytes);
    }

    #[inline]
    fn floats(&mut self, tag: u8, values: &[f64]) {
        if values.is_empty() {
            return;
        }
        self.key(tag, BYTES);
        varint(self.out, values.len() as u64 * 8);
        values.iter().for_each(|value| self.out.extend_from_slice(&value.to_le_bytes()));
    }

    fn varints<N: Copy + Into<u64>>(&mut self, tag: u8, numbers: &[N]) {
        self.nested(tag, |wire| numbers.iter().for_each(|&number| varint(wire.out, number.into())));
    }
}

#[inline]
fn varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}
