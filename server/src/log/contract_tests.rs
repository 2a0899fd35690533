//! The numbers and words of the events' types against the `.proto` files.

use std::collections::BTreeSet;

use counterpoint_kernel::log::event::fields::{EventField, EventRecord, EventValue, FieldWriter};
use counterpoint_proto::DESCRIPTORS;
use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

use super::codec_tests::events;

/// How a value is encoded.
#[derive(Debug, PartialEq, Eq)]
enum Wire {
    Varint,
    Fixed64,
    Bytes,
}

impl Wire {
    fn of(value: EventValue<'_>) -> Self {
        match value {
            EventValue::Float(_) | EventValue::Known(_) => Self::Fixed64,
            EventValue::Text(_) | EventValue::Letter(_) | EventValue::Channels(_) => Self::Bytes,
            EventValue::Position(_) | EventValue::Axes(_) | EventValue::Pair(_) | EventValue::Center => Self::Bytes,
            _ => Self::Varint,
        }
    }

    /// As the contract has it; lists of numbers are packed.
    fn declared(field: &FieldDescriptorProto) -> Self {
        match field.r#type() {
            Type::String | Type::Message => Self::Bytes,
            _ if field.label() == Label::Repeated => Self::Bytes,
            Type::Double => Self::Fixed64,
            _ => Self::Varint,
        }
    }
}

/// Compares every field that is written with its declaration.
struct Contract<'a> {
    file: &'a FileDescriptorProto,
    message: &'a DescriptorProto,
    /// Fields that have been seen, by message and name.
    seen: &'a mut BTreeSet<(String, String)>,
}

impl<'a> Contract<'a> {
    fn declared(&mut self, tag: u8) -> &'a FieldDescriptorProto {
        let field = self.message.field.iter().find(|field| field.number() == i32::from(tag));
        let field = field.unwrap_or_else(|| panic!("{} has no field {tag}", self.message.name()));
        self.seen.insert((self.message.name().to_owned(), field.name().to_owned()));
        field
    }

    /// The same for the message inside a field.
    fn inside(&mut self, tag: u8, write: impl FnOnce(&mut Contract<'_>)) {
        let message = find(self.file, self.declared(tag));
        write(&mut Contract { file: self.file, message, seen: self.seen });
    }
}

/// The message that a field is of.
fn find<'a>(file: &'a FileDescriptorProto, field: &FieldDescriptorProto) -> &'a DescriptorProto {
    let name = field.type_name().rsplit('.').next().unwrap();
    file.message_type.iter().find(|message| message.name() == name).unwrap()
}

impl FieldWriter for Contract<'_> {
    fn put(&mut self, field: EventField, value: EventValue<'_>) {
        if field.tag == 0 {
            return;
        }
        let declared = self.declared(field.tag);
        assert_eq!(Wire::of(value), Wire::declared(declared), "{}", declared.name());
        if let EventValue::Word(number, word) = value {
            let name = declared.type_name().rsplit('.').next().unwrap();
            let words = self.file.enum_type.iter().find(|words| words.name() == name).unwrap();
            let declared = words.value.iter().find(|value| value.number() == i32::from(number)).unwrap();
            assert!(declared.name().ends_with(&format!("_{}", word.to_uppercase())), "{} {word}", declared.name());
        }
    }

    fn message<R: EventRecord>(&mut self, field: EventField, record: Option<&R>) {
        if let Some(record) = record {
            self.inside(field.tag, |inner| record.fields(inner));
        }
    }

    fn messages<R: EventRecord>(&mut self, field: EventField, records: &[R]) {
        records.iter().for_each(|record| self.message(field, Some(record)));
    }
}

#[test]
fn fields_have_the_numbers_and_words_of_the_contract() {
    let set = FileDescriptorSet::decode(DESCRIPTORS).unwrap();
    let file = set.file.iter().find(|file| file.name().ends_with("event.proto")).unwrap();
    let message = file.message_type.iter().find(|message| message.name() == "Event").unwrap();
    let mut seen = BTreeSet::new();
    for event in events() {
        let mut contract = Contract { file, message, seen: &mut seen };
        event.head(1, &mut contract);
        contract.inside(event.kind.number(), |inner| event.kind.fields(inner));
    }
    // Nothing is declared that no event has.
    let mut messages = vec![message];
    while let Some(message) = messages.pop() {
        for field in &message.field {
            assert!(seen.contains(&(message.name().to_owned(), field.name().to_owned())), "{field:?} is never written");
            if field.r#type() == Type::Message {
                messages.push(find(file, field));
            }
        }
    }
}
