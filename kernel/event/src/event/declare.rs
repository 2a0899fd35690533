//! Declarations of events: types whose fields say how they are written, in the place where they are declared.

/// Declares a type with its fields: `pub name: Type = number on the wire,`. In brackets after the number may be
/// `optional`, `added` or `uncounted` (see [`EventField`](super::fields::EventField)), `wire` for the wire only, `as "name"` for another name
/// in JSON, `if test` when JSON has the field only if the test of the whole holds. Functions after the type belong to
/// its [`EventRecord`](super::fields::EventRecord).
macro_rules! record {
    (
        $(#[$meta:meta])*
        pub struct $type:ident {
            $($(#[$about:meta])* pub $field:ident: $kind:ty = $tag:literal $([$($how:tt)*])?,)*
        }
        $($more:tt)*
    ) => {
        $(#[$meta])*
        pub struct $type {
            $($(#[$about])* pub $field: $kind,)*
        }

        impl super::fields::EventRecord for $type {
            #[inline]
            fn fields(&self, out: &mut impl super::fields::FieldWriter) {
                $(
                    let field = super::declare::record!(@ self, $tag, $field, $($($how)*)?);
                    super::fields::FieldType::put(&self.$field, field, out);
                )*
            }

            #[inline]
            fn read(from: &impl super::fields::FieldReader) -> Option<Self> {
                Some(Self { $($field: super::fields::FieldType::get($tag, from)?,)* })
            }

            $($more)*
        }
    };
    (@ $all:ident, $tag:literal, $field:ident,) => { super::fields::EventField::new($tag, stringify!($field)) };
    (@ $all:ident, $tag:literal, $field:ident, optional) => {
        super::fields::EventField::new($tag, stringify!($field)).optional()
    };
    (@ $all:ident, $tag:literal, $field:ident, added) => {
        super::fields::EventField::new($tag, stringify!($field)).added()
    };
    (@ $all:ident, $tag:literal, $field:ident, uncounted) => {
        super::fields::EventField::new($tag, stringify!($field)).uncounted()
    };
    (@ $all:ident, $tag:literal, $field:ident, wire) => { super::fields::EventField::wire($tag) };
    (@ $all:ident, $tag:literal, $field:ident, as $name:literal) => {
        super::fields::EventField::new($tag, $name)
    };
    (@ $all:ident, $tag:literal, $field:ident, if $test:path) => {
        super::fields::EventField::new($tag, stringify!($field)).shown_if($test($all))
    };
}

/// Declares a type that is one of several words: `Name = number on the wire "word in JSON",`. Numbers count from 1.
macro_rules! words {
    (
        $(#[$meta:meta])*
        pub enum $type:ident {
            $($(#[$about:meta])* $name:ident = $number:literal $word:literal,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $type {
            $($(#[$about])* $name,)*
        }

        impl $type {
            /// Number on the wire, from 1.
            #[must_use]
            pub const fn number(self) -> u8 {
                match self {
                    $(Self::$name => $number,)*
                }
            }

            /// Word in JSON.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$name => $word,)*
                }
            }

            /// Finds one by its number on the wire.
            #[must_use]
            pub const fn of_number(number: u64) -> Option<Self> {
                match number {
                    $($number => Some(Self::$name),)*
                    _ => None,
                }
            }
        }

        impl super::fields::FieldType for $type {
            #[inline]
            fn put(&self, field: super::fields::EventField, out: &mut impl super::fields::FieldWriter) {
                out.put(field, super::fields::EventValue::Word(self.number(), self.word()));
            }

            #[inline]
            fn get(tag: u8, from: &impl super::fields::FieldReader) -> Option<Self> {
                Self::of_number(from.number(tag))
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.word())
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                match <std::borrow::Cow<'de, str> as serde::Deserialize<'de>>::deserialize(deserializer)?.as_ref() {
                    $($word => Ok(Self::$name),)*
                    other => Err(serde::de::Error::unknown_variant(other, &[$($word),*])),
                }
            }
        }
    };
}

/// Declares the kinds of events: `number in the oneof of the wire "word in JSON" Name(Type),`.
macro_rules! kinds {
    ($(#[$meta:meta])* pub enum Kind { $($(#[$about:meta])* $number:literal $word:literal $name:ident($type:ty),)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq)]
        pub enum Kind {
            $($(#[$about])* $name($type),)*
        }

        impl Kind {
            /// Number in the oneof of the wire.
            #[inline]
            #[must_use]
            pub const fn number(&self) -> u8 {
                match self {
                    $(Self::$name(_) => $number,)*
                }
            }

            /// Word in JSON.
            #[must_use]
            pub const fn word(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $word,)*
                }
            }

            /// Writes the fields of its type.
            #[inline]
            pub fn fields(&self, out: &mut impl fields::FieldWriter) {
                match self {
                    $(Self::$name(record) => fields::EventRecord::fields(record, out),)*
                }
            }

            /// Kind of work of its time; `None` for kinds that never take time by themselves, and for waits, whose
            /// length is only known at their release.
            #[inline]
            #[must_use]
            pub fn work(&self) -> Option<WorkClass> {
                match self {
                    $(Self::$name(record) => fields::EventRecord::work(record),)*
                }
            }

            /// Its action in the words of the listing, if it is one that needs nothing else to be known. `number`
            /// writes a number as the listing does.
            #[must_use]
            pub fn action(&self, number: fn(f64) -> String) -> Option<String> {
                match self {
                    $(Self::$name(record) => fields::EventRecord::action(record, number),)*
                }
            }

            /// Reads an event by its number; `None` if it is damaged or unknown.
            #[must_use]
            pub fn read(number: u64, from: &impl fields::FieldReader) -> Option<Self> {
                match number {
                    $($number => fields::EventRecord::read(from).map(Self::$name),)*
                    _ => None,
                }
            }
        }
    };
}

pub(crate) use {kinds, record, words};
