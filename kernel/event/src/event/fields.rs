//! Writers and readers of the fields of events.
//!
//! Each kind of event names its fields once, in its [`EventRecord`]. The JSON lines, the wire, the fingerprint of the log
//! and the count of texts are each a [`FieldWriter`]; the reader of an encoding is a [`FieldReader`]. *Invariant:* numbers and
//! names of fields never change; a field that comes later is [`EventField::added`].

use std::borrow::Cow;
use std::sync::Arc;

use super::work::WorkClass;
use super::{FileId, MAX_AXES, Position};

/// When a field is written in a form that could leave it out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Always.
    Always,
    /// Unless it is zero, empty, false or not known.
    NotBlank,
    /// Never.
    Never,
}

/// Where and how one field is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EventField {
    /// Number on the wire, 0 = not there. The wire omits values that are zero or empty.
    pub tag: u8,
    /// Name in JSON.
    pub name: &'static str,
    /// Presence in JSON.
    pub json: Presence,
    /// Presence in the fingerprint. Fields that are not always there are the last of their kind.
    pub digest: Presence,
}

impl EventField {
    /// A field of all forms.
    #[must_use]
    pub const fn new(tag: u8, name: &'static str) -> Self {
        Self { tag, name, json: Presence::Always, digest: Presence::Always }
    }

    /// JSON leaves it out when there is nothing to say.
    #[must_use]
    pub const fn optional(self) -> Self {
        Self { json: Presence::NotBlank, ..self }
    }

    /// A field that its kind has not always had: logs that do not use it are written as before.
    #[must_use]
    pub const fn added(self) -> Self {
        Self { json: Presence::NotBlank, digest: Presence::NotBlank, ..self }
    }

    /// A field that the fingerprint does not count, because other fields imply it; JSON leaves it out when blank.
    #[must_use]
    pub const fn uncounted(self) -> Self {
        Self { json: Presence::NotBlank, digest: Presence::Never, ..self }
    }

    /// JSON has it only if `shown`.
    #[must_use]
    pub const fn shown_if(self, shown: bool) -> Self {
        if shown { self } else { Self { json: Presence::Never, ..self } }
    }

    /// For the wire only: other forms say the same in another way.
    #[must_use]
    pub const fn wire(tag: u8) -> Self {
        Self { tag, name: "", json: Presence::Never, digest: Presence::Never }
    }

    /// For JSON only.
    #[must_use]
    pub const fn shown(name: &'static str) -> Self {
        Self { tag: 0, name, json: Presence::Always, digest: Presence::Never }
    }

    /// For the fingerprint only.
    #[must_use]
    pub const fn counted() -> Self {
        Self { tag: 0, name: "", json: Presence::Never, digest: Presence::Always }
    }
}

/// The value of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EventValue<'a> {
    /// Yes or no.
    Bool(bool),
    /// A number of one byte.
    U8(u8),
    /// A number of two bytes.
    U16(u16),
    /// A number of four bytes.
    U32(u32),
    /// A number of eight bytes.
    U64(u64),
    /// A time, ns.
    I64(i64),
    /// A measure.
    Float(f64),
    /// A measure that may be unknown.
    Known(Option<f64>),
    /// A text.
    Text(&'a str),
    /// A letter.
    Letter(char),
    /// One of several states: its number, from 1, and its word.
    Word(u8, &'static str),
    /// A number that has a name.
    Named(u8, &'static str),
    /// Numbers of channels.
    Channels(&'a [u16]),
    /// A value for each axis of the channel.
    Position(&'a Position),
    /// Two axes by index, 255 = none.
    Axes(&'a [u8; 2]),
    /// Two measures.
    Pair(&'a [f64; 2]),
    /// The centre of the motion, and of a circle in space its middle, if it has one: how, depends on the axes of the
    /// channel.
    Center,
    /// A file, by name where it has one: that of line 0 has none.
    File(FileId, u32),
}

impl EventValue<'_> {
    /// Whether the value adds no information.
    #[must_use]
    pub fn is_blank(&self) -> bool {
        match self {
            Self::Bool(flag) => !flag,
            Self::U8(number) | Self::Word(number, _) | Self::Named(number, _) => *number == 0,
            Self::U16(number) | Self::File(number, _) => *number == 0,
            Self::U32(number) => *number == 0,
            Self::U64(number) => *number == 0,
            Self::I64(number) => *number == 0,
            Self::Float(number) => *number == 0.0,
            Self::Known(number) => number.is_none(),
            Self::Text(text) => text.is_empty(),
            Self::Letter(letter) => *letter == '\0',
            Self::Channels(list) => list.is_empty(),
            Self::Position(_) | Self::Axes(_) | Self::Pair(_) | Self::Center => false,
        }
    }
}

/// A form in which events are written, field by field.
pub trait FieldWriter {
    /// Writes one field.
    fn put(&mut self, field: EventField, value: EventValue<'_>);

    /// Writes an optional record.
    fn message<R: EventRecord>(&mut self, field: EventField, record: Option<&R>);

    /// Writes a list.
    fn messages<R: EventRecord>(&mut self, field: EventField, records: &[R]);
}

/// An encoded record: its fields by their numbers on the wire. A missing field reads as zero or empty.
pub trait FieldReader: Sized {
    /// A number.
    fn number(&self, tag: u8) -> u64;
    /// A measure.
    fn float(&self, tag: u8) -> f64;
    /// A measure that may be unknown.
    fn known(&self, tag: u8) -> Option<f64>;
    /// A text.
    fn text(&self, tag: u8) -> Cow<'_, str>;
    /// The numbers of a list.
    fn numbers(&self, tag: u8) -> impl Iterator<Item = u64>;
    /// Measures into their places, as many as there are.
    fn floats(&self, tag: u8, into: &mut [f64]);
    /// The record inside a field.
    fn message(&self, tag: u8) -> Option<Self>;
    /// All records of a list.
    fn messages(&self, tag: u8) -> impl Iterator<Item = Self>;
}

/// A type with fields: a kind of event, or a part of it.
pub trait EventRecord: Sized {
    /// Writes all fields, in their order.
    fn fields(&self, out: &mut impl FieldWriter);

    /// Reads them back; `None` if they are damaged.
    fn read(from: &impl FieldReader) -> Option<Self>;

    /// The kind of work of such an event, if it takes time.
    fn work(&self) -> Option<WorkClass> {
        None
    }

    /// The action in the words of the listing, if such an event is one. `number` writes a number as the listing does.
    fn action(&self, number: fn(f64) -> String) -> Option<String> {
        let _ = number;
        None
    }
}

/// The type of a field.
pub trait FieldType: Sized {
    /// Writes it.
    fn put(&self, field: EventField, out: &mut impl FieldWriter);

    /// Reads the value back; `None` if it is damaged.
    fn get(tag: u8, from: &impl FieldReader) -> Option<Self>;
}

/// Fields that are one value of the same name.
macro_rules! data {
    ($($type:ty: |$value:ident| $put:expr, |$from:ident, $tag:ident| $get:expr;)*) => { $(
        impl FieldType for $type {
            #[inline]
            fn put(&self, field: EventField, out: &mut impl FieldWriter) {
                let $value = self;
                out.put(field, $put);
            }

            #[inline]
            fn get($tag: u8, $from: &impl FieldReader) -> Option<Self> {
                $get
            }
        }
    )* };
}

data! {
    bool: |v| EventValue::Bool(*v), |from, tag| Some(from.number(tag) != 0);
    u8: |v| EventValue::U8(*v), |from, tag| Some(from.number(tag) as u8);
    u16: |v| EventValue::U16(*v), |from, tag| Some(from.number(tag) as u16);
    u32: |v| EventValue::U32(*v), |from, tag| Some(from.number(tag) as u32);
    u64: |v| EventValue::U64(*v), |from, tag| Some(from.number(tag));
    i64: |v| EventValue::I64(*v), |from, tag| Some(from.number(tag) as i64);
    f64: |v| EventValue::Float(*v), |from, tag| Some(from.float(tag));
    Option<f64>: |v| EventValue::Known(*v), |from, tag| Some(from.known(tag));
    char: |v| EventValue::Letter(*v), |from, tag| from.text(tag).chars().next();
    Box<str>: |v| EventValue::Text(v), |from, tag| Some(from.text(tag).into());
    Arc<str>: |v| EventValue::Text(v), |from, tag| Some(from.text(tag).into());
    Cow<'static, str>: |v| EventValue::Text(v), |from, tag| Some(Cow::Owned(from.text(tag).into_owned()));
    Arc<[u16]>: |v| EventValue::Channels(v), |from, tag| Some(from.numbers(tag).map(|number| number as u16).collect());
    Vec<u16>: |v| EventValue::Channels(v), |from, tag| Some(from.numbers(tag).map(|number| number as u16).collect());
    Box<Position>: |v| EventValue::Position(v), |from, tag| Some(Box::new(position(tag, from)));
}

impl<R: EventRecord> FieldType for Option<R> {
    fn put(&self, field: EventField, out: &mut impl FieldWriter) {
        out.message(field, self.as_ref());
    }

    fn get(tag: u8, from: &impl FieldReader) -> Option<Self> {
        match from.message(tag) {
            Some(inner) => R::read(&inner).map(Some),
            None => Some(None),
        }
    }
}

impl<R: EventRecord> FieldType for Vec<R> {
    fn put(&self, field: EventField, out: &mut impl FieldWriter) {
        out.messages(field, self);
    }

    fn get(tag: u8, from: &impl FieldReader) -> Option<Self> {
        from.messages(tag).map(|inner| R::read(&inner)).collect()
    }
}

/// Reads a position; axes that are not there are at zero.
pub(super) fn position(tag: u8, from: &impl FieldReader) -> Position {
    let mut position = [0.0; MAX_AXES];
    from.floats(tag, &mut position);
    position
}

/// Pointers to a record are written as the record.
macro_rules! pointers {
    ($($pointer:ident)*) => { $(
        impl<R: EventRecord> EventRecord for $pointer<R> {
            #[inline]
            fn fields(&self, out: &mut impl FieldWriter) {
                (**self).fields(out);
            }

            fn read(from: &impl FieldReader) -> Option<Self> {
                R::read(from).map(Self::new)
            }

            #[inline]
            fn work(&self) -> Option<WorkClass> {
                (**self).work()
            }

            fn action(&self, number: fn(f64) -> String) -> Option<String> {
                (**self).action(number)
            }
        }
    )* };
}

pointers! { Box Arc }

/// Adds up the bytes of the texts of an event.
#[derive(Debug, Default)]
pub(super) struct Texts(pub(super) usize);

impl FieldWriter for Texts {
    #[inline]
    fn put(&mut self, _: EventField, value: EventValue<'_>) {
        if let EventValue::Text(text) = value {
            self.0 += text.len();
        }
    }

    fn message<R: EventRecord>(&mut self, _: EventField, record: Option<&R>) {
        record.into_iter().for_each(|record| record.fields(self));
    }

    fn messages<R: EventRecord>(&mut self, _: EventField, records: &[R]) {
        records.iter().for_each(|record| record.fields(self));
    }
}
