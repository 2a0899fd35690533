//! Wire encoding back to kernel events, for results made from the log.
//!
//! The types of the events define the fields. *Invariant:* decoding the output of [`super::encode`] gives the same
//! event, bit for bit (tested), so a result made later equals the one made while the job ran. Damage gives `None`,
//! never a panic.

use std::borrow::Cow;

use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::event::fields::FieldReader;

/// A value on the wire.
#[derive(Clone, Copy)]
enum WireValue<'a> {
    Number(u64),
    Fixed(u64),
    Bytes(&'a [u8]),
}

impl<'a> WireValue<'a> {
    fn number(self) -> u64 {
        match self {
            Self::Number(n) | Self::Fixed(n) => n,
            Self::Bytes(_) => 0,
        }
    }

    fn bytes(self) -> &'a [u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            _ => &[],
        }
    }
}

/// The fields of a message, in order.
struct WireFields<'a>(&'a [u8]);

impl<'a> WireFields<'a> {
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.0.split_first()?;
            self.0 = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn next_field(&mut self) -> Option<(u64, WireValue<'a>)> {
        let key = self.varint()?;
        let value = match key & 7 {
            0 => WireValue::Number(self.varint()?),
            1 => {
                let (bytes, rest) = self.0.split_first_chunk::<8>()?;
                self.0 = rest;
                WireValue::Fixed(u64::from_le_bytes(*bytes))
            }
            2 => {
                let length = usize::try_from(self.varint()?).ok()?;
                let (bytes, rest) = self.0.split_at_checked(length)?;
                self.0 = rest;
                WireValue::Bytes(bytes)
            }
            _ => return None,
        };
        Some((key >> 3, value))
    }
}

impl<'a> Iterator for WireFields<'a> {
    type Item = (u64, WireValue<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() { None } else { self.next_field() }
    }
}

/// First field of the oneof with the kind of an event.
const FIRST_KIND: u64 = 10;

/// Whether an encoded batch begins and ends with these numbers of its first and last event, as all stored ones do.
pub(crate) fn spans(batch: &[u8], first: u64, last: u64) -> bool {
    let mut end = Vec::with_capacity(12);
    super::encode::varint_field(&mut end, 2, last);
    matches!(WireFields(batch).next(), Some((1, WireValue::Number(begin))) if begin == first) && batch.ends_with(&end)
}

/// The encoded events of an encoded batch.
pub(crate) fn events(batch: &[u8]) -> impl Iterator<Item = &[u8]> {
    WireFields(batch).filter(|(field, _)| *field == 3).map(|(_, value)| value.bytes())
}

/// Number of the oneof field with the kind of an encoded event; 0 when there is none.
pub(crate) fn kind_field(event: &[u8]) -> u64 {
    WireFields(event).map(|(field, _)| field).find(|field| *field >= FIRST_KIND).unwrap_or(0)
}

/// Sequence number of an encoded event.
pub(crate) fn seq(event: &[u8]) -> u64 {
    WireFields(event).find(|(field, _)| *field == 1).map_or(0, |(_, value)| value.number())
}

/// Fields that a message may have, 0 counted.
const MOST: usize = 12;

/// A message: the last value of each of its fields; missing fields are zero.
struct WireMessage<'a> {
    values: [WireValue<'a>; MOST],
    bytes: &'a [u8],
}

impl<'a> WireMessage<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let mut message = Self { values: [const { WireValue::Number(0) }; MOST], bytes };
        WireFields(bytes).for_each(|(field, value)| message.set(field, value));
        message
    }

    fn set(&mut self, field: u64, value: WireValue<'a>) {
        if let Some(slot) = self.values.get_mut(field as usize) {
            *slot = value;
        }
    }

    fn get(&self, tag: u8) -> WireValue<'a> {
        self.values.get(usize::from(tag)).copied().unwrap_or(WireValue::Number(0))
    }
}

impl<'a> FieldReader for WireMessage<'a> {
    fn number(&self, tag: u8) -> u64 {
        self.get(tag).number()
    }

    fn float(&self, tag: u8) -> f64 {
        f64::from_bits(self.get(tag).number())
    }

    fn known(&self, tag: u8) -> Option<f64> {
        match self.get(tag) {
            WireValue::Fixed(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn text(&self, tag: u8) -> Cow<'_, str> {
        String::from_utf8_lossy(self.get(tag).bytes())
    }

    fn numbers(&self, tag: u8) -> impl Iterator<Item = u64> {
        let mut fields = WireFields(self.get(tag).bytes());
        std::iter::from_fn(move || fields.varint())
    }

    fn floats(&self, tag: u8, into: &mut [f64]) {
        for (slot, chunk) in into.iter_mut().zip(self.get(tag).bytes().chunks_exact(8)) {
            *slot = chunk.try_into().map_or(0.0, f64::from_le_bytes);
        }
    }

    fn message(&self, tag: u8) -> Option<Self> {
        match self.get(tag) {
            WireValue::Bytes(bytes) => Some(Self::new(bytes)),
            _ => None,
        }
    }

    fn messages(&self, tag: u8) -> impl Iterator<Item = Self> {
        let fields = WireFields(self.bytes).filter(move |(field, _)| *field == u64::from(tag));
        fields.map(|(_, value)| Self::new(value.bytes()))
    }
}

/// Decodes one event, and its number in the log.
pub(crate) fn event(bytes: &[u8]) -> Option<(u64, Event)> {
    let (mut number, mut kind) = (0, &[][..]);
    for (field, value) in WireFields(bytes).filter(|(field, _)| *field >= FIRST_KIND) {
        (number, kind) = (field, value.bytes());
    }
    Event::read(&WireMessage::new(bytes), (number, &WireMessage::new(kind)))
}
