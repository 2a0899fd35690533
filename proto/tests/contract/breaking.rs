//! Changes that clients of an older contract would notice.

use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
    MethodDescriptorProto,
};

/// Compares two items of one number or name.
fn same<T: PartialEq + std::fmt::Debug>(out: &mut Vec<String>, of: &str, what: &str, before: T, now: T) {
    if before != now {
        out.push(format!("{of}: its {what} was {before:?}, it is {now:?} now"));
    }
}

fn field(
    out: &mut Vec<String>,
    of: &str,
    before: &FieldDescriptorProto,
    now: &FieldDescriptorProto,
    oneofs: [&str; 2],
) {
    same(out, of, "name", before.name(), now.name());
    same(out, of, "type", (before.r#type, before.type_name()), (now.r#type, now.type_name()));
    same(out, of, "cardinality", (before.label, before.proto3_optional()), (now.label, now.proto3_optional()));
    if before.name() == now.name() {
        same(out, of, "name in JSON", before.json_name(), now.json_name());
    }
    same(out, of, "oneof", oneofs[0], oneofs[1]);
}

fn message(out: &mut Vec<String>, of: &str, before: &DescriptorProto, now: &DescriptorProto) {
    let oneof = |message: &DescriptorProto, field: &FieldDescriptorProto| {
        let at = field.oneof_index.and_then(|at| usize::try_from(at).ok());
        at.and_then(|at| message.oneof_decl.get(at)).map(|one| one.name().to_owned()).unwrap_or_default()
    };
    for old in &before.field {
        let name = format!("{of}.{}", old.name());
        match now.field.iter().find(|new| new.number() == old.number()) {
            Some(new) => field(out, &name, old, new, [&oneof(before, old), &oneof(now, new)]),
            None => out.push(format!("{name} was removed")),
        }
    }
    for range in &before.reserved_range {
        let kept = now.reserved_range.iter().any(|new| new.start() <= range.start() && range.end() <= new.end());
        if !kept {
            out.push(format!("{of}: the numbers {} to {} are not reserved any more", range.start(), range.end() - 1));
        }
    }
    for name in before.reserved_name.iter().filter(|name| !now.reserved_name.contains(name)) {
        out.push(format!("{of}: the name {name} is not reserved any more"));
    }
    for old in &before.nested_type {
        let name = format!("{of}.{}", old.name());
        match now.nested_type.iter().find(|new| new.name() == old.name()) {
            Some(new) => message(out, &name, old, new),
            None => out.push(format!("{name} was removed")),
        }
    }
    enums(out, of, &before.enum_type, &now.enum_type);
}

fn enums(out: &mut Vec<String>, of: &str, before: &[EnumDescriptorProto], now: &[EnumDescriptorProto]) {
    for old in before {
        let name = format!("{of}.{}", old.name());
        let Some(new) = now.iter().find(|new| new.name() == old.name()) else {
            out.push(format!("{name} was removed"));
            continue;
        };
        for value in &old.value {
            match new.value.iter().find(|other| other.number() == value.number()) {
                Some(other) => same(out, &format!("{name} {}", value.number()), "name", value.name(), other.name()),
                None => out.push(format!("{} was removed", value.name())),
            }
        }
        for range in &old.reserved_range {
            let kept = new.reserved_range.iter().any(|new| new.start() <= range.start() && range.end() <= new.end());
            if !kept {
                out.push(format!("{name}: the numbers {} to {} are not reserved any more", range.start(), range.end()));
            }
        }
    }
}

fn method(out: &mut Vec<String>, of: &str, before: &MethodDescriptorProto, now: &MethodDescriptorProto) {
    if before.input_type() != now.input_type() {
        out.push(format!("{of} takes {} instead of {}", now.input_type(), before.input_type()));
    }
    if before.output_type() != now.output_type() {
        out.push(format!("{of} answers with {} instead of {}", now.output_type(), before.output_type()));
    }
    let streams = |method: &MethodDescriptorProto| (method.client_streaming(), method.server_streaming());
    same(out, of, "use of streams", streams(before), streams(now));
}

/// Parts of `before` that `now` takes back.
pub(super) fn findings(before: &FileDescriptorSet, now: &FileDescriptorSet) -> Vec<String> {
    let mut out = Vec::new();
    for old in &before.file {
        let name = old.name();
        let Some(new) = now.file.iter().find(|new| new.name() == name) else {
            out.push(format!("{name} was removed"));
            continue;
        };
        same(&mut out, name, "package", old.package(), new.package());
        same(&mut out, name, "syntax", old.syntax(), new.syntax());
        let of_go = |file: &FileDescriptorProto| file.options.as_ref().and_then(|options| options.go_package.clone());
        // Programs in Go import this path. Without one they had to choose it themselves.
        if let Some(path) = of_go(old) {
            same(&mut out, name, "go_package", Some(path), of_go(new));
        }
        for old in &old.message_type {
            let name = format!("{}.{}", new.package(), old.name());
            match new.message_type.iter().find(|new| new.name() == old.name()) {
                Some(new) => message(&mut out, &name, old, new),
                None => out.push(format!("{name} was removed")),
            }
        }
        enums(&mut out, new.package(), &old.enum_type, &new.enum_type);
        for old in &old.service {
            let name = format!("{}.{}", new.package(), old.name());
            let Some(new) = new.service.iter().find(|new| new.name() == old.name()) else {
                out.push(format!("{name} was removed"));
                continue;
            };
            for old in &old.method {
                let name = format!("{name}.{}", old.name());
                match new.method.iter().find(|new| new.name() == old.name()) {
                    Some(new) => method(&mut out, &name, old, new),
                    None => out.push(format!("{name} was removed")),
                }
            }
        }
    }
    out
}
