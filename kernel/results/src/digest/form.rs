//! The fields of each kind of event but motions and blocks, in little-endian bytes.
//!
//! Words count from 0 here. *Invariant:* texts and lists carry their length; fields that a kind has not always had are
//! left out at its end while they say nothing.

use counterpoint_event::event::Kind;
use counterpoint_event::event::fields::{EventField, EventRecord, EventValue, FieldWriter, Presence};

/// Number on the wire of the first kind; it has number 0 here.
const FIRST: u8 = 10;

pub(super) fn number(kind: &Kind) -> u8 {
    kind.number().wrapping_sub(FIRST)
}

pub(super) fn write_kind(out: &mut Vec<u8>, kind: &Kind) {
    if matches!(kind, Kind::Motion(_) | Kind::Block(_)) {
        return;
    }
    let end = out.len();
    let mut form = Bytes { out, end };
    kind.fields(&mut form);
    let Bytes { out, end } = form;
    out.truncate(end);
}

/// The bytes so far, and where the last field that counts ends.
struct Bytes<'a> {
    out: &'a mut Vec<u8>,
    end: usize,
}

impl Bytes<'_> {
    /// The last written value counts.
    fn counts(&mut self) {
        self.end = self.out.len();
    }
}

impl FieldWriter for Bytes<'_> {
    // The type of a field is known where it is put, so only one arm of this remains.
    #[inline(always)]
    fn put(&mut self, field: EventField, value: EventValue<'_>) {
        if field.digest == Presence::Never {
            return;
        }
        let out = &mut *self.out;
        match value {
            EventValue::Bool(flag) => out.push(u8::from(flag)),
            EventValue::U8(number) | EventValue::Named(number, _) => out.push(number),
            EventValue::U16(number) | EventValue::File(number, _) => out.extend_from_slice(&number.to_le_bytes()),
            EventValue::U32(number) => out.extend_from_slice(&number.to_le_bytes()),
            EventValue::U64(number) => out.extend_from_slice(&number.to_le_bytes()),
            EventValue::I64(number) => out.extend_from_slice(&number.to_le_bytes()),
            EventValue::Float(number) => float(out, number),
            EventValue::Known(number) => {
                out.push(u8::from(number.is_some()));
                number.into_iter().for_each(|number| float(out, number));
            }
            EventValue::Text(text) => {
                length(out, text.len());
                out.extend_from_slice(text.as_bytes());
            }
            EventValue::Letter(letter) => out.extend_from_slice(&u32::from(letter).to_le_bytes()),
            EventValue::Word(number, _) => out.push(number.wrapping_sub(1)),
            EventValue::Channels(channels) => {
                length(out, channels.len());
                channels.iter().for_each(|channel| out.extend_from_slice(&channel.to_le_bytes()));
            }
            EventValue::Position(position) => position.iter().for_each(|&number| float(out, number)),
            EventValue::Pair(pair) => pair.iter().for_each(|&number| float(out, number)),
            EventValue::Axes(axes) => out.extend_from_slice(axes),
            // Motions have a form of their own.
            EventValue::Center => {}
        }
        if field.digest == Presence::Always || !value.is_blank() {
            self.counts();
        }
    }

    fn message<R: EventRecord>(&mut self, field: EventField, record: Option<&R>) {
        let Some(record) = record.filter(|_| field.digest != Presence::Never) else { return };
        record.fields(self);
        self.counts();
    }

    fn messages<R: EventRecord>(&mut self, field: EventField, records: &[R]) {
        if field.digest != Presence::Never {
            length(self.out, records.len());
            self.counts();
            records.iter().for_each(|record| record.fields(self));
        }
    }
}

pub(super) fn bits(value: f64) -> u64 {
    // Adding zero turns -0.0 into 0.0 and changes nothing else; every NaN counts as the same one.
    if value.is_nan() { f64::NAN.to_bits() } else { (value + 0.0).to_bits() }
}

fn float(out: &mut Vec<u8>, value: f64) {
    out.extend_from_slice(&bits(value).to_le_bytes());
}

fn length(out: &mut Vec<u8>, count: usize) {
    out.extend_from_slice(&u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
}
