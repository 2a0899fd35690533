//! How the contract is written.

use std::collections::{BTreeMap, BTreeSet};

use prost_types::{DescriptorProto, EnumDescriptorProto, FileDescriptorProto, FileDescriptorSet};

/// The import path of the whole contract in Go: the folder of its files, which no move of the repository changes.
const GO_PACKAGE: &str = "counterpoint/v1;counterpointv1";

/// The findings of the rules in a file.
struct Findings<'f> {
    file: &'f FileDescriptorProto,
    /// Places with a comment before them.
    commented: BTreeSet<Vec<i32>>,
    out: Vec<String>,
}

fn is_lower_snake(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}

fn is_pascal(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_uppercase()) && name.chars().all(|c| c.is_ascii_alphanumeric())
}

/// `JobState` as `JOB_STATE`.
fn upper_snake(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.push(c.to_ascii_uppercase());
    }
    out
}

impl Findings<'_> {
    fn say(&mut self, name: &str, rule: &str) {
        self.out.push(format!("{}: {name} {rule}", self.file.name()));
    }

    fn check(&mut self, good: bool, name: &str, rule: &str) {
        if !good {
            self.say(name, rule);
        }
    }

    fn comment(&mut self, path: &[i32], name: &str) {
        self.check(self.commented.contains(path), name, "has no comment");
    }

    fn file(&mut self) {
        let (file, package) = (self.file, self.file.package());
        let folder = file.name().rsplit_once('/').map_or("", |(folder, _)| folder);
        self.check(folder == package.replace('.', "/"), package, "is not in the folder of its package");
        let version = package.rsplit('.').next().unwrap_or("");
        let number = version.strip_prefix('v').is_some_and(|rest| rest.parse::<u32>().is_ok());
        self.check(number, package, "has no version at its end, like v1");
        let stem = file.name().rsplit('/').next().and_then(|name| name.strip_suffix(".proto")).unwrap_or("");
        self.check(is_lower_snake(stem), file.name(), "is not lower_snake_case");
        self.check(
            file.public_dependency.is_empty() && file.weak_dependency.is_empty(),
            "it",
            "has a public or weak import",
        );
        self.check(file.syntax() == "proto3", "it", "is not proto3");
        let of_go = file.options.as_ref().map_or("", |options| options.go_package());
        self.check(of_go == GO_PACKAGE, "go_package", "is not that of the other files");
        for (at, message) in (0..).zip(&file.message_type) {
            self.message(message, vec![4, at]);
        }
        for (at, one) in (0..).zip(&file.enum_type) {
            self.enumeration(one, vec![5, at]);
        }
    }

    fn message(&mut self, message: &DescriptorProto, path: Vec<i32>) {
        let name = message.name();
        // The entries of a map are made by the compiler.
        if message.options.as_ref().is_some_and(prost_types::MessageOptions::map_entry) {
            return;
        }
        self.check(is_pascal(name), name, "is not PascalCase");
        self.comment(&path, name);
        let below = |kind: i32, at: i32| [path.as_slice(), &[kind, at]].concat();
        for (at, field) in (0..).zip(&message.field) {
            let name = format!("{name}.{}", field.name());
            self.check(is_lower_snake(field.name()), &name, "is not lower_snake_case");
            self.comment(&below(2, at), &name);
        }
        for (at, oneof) in (0..).zip(&message.oneof_decl) {
            // Optional fields have one that the compiler makes.
            if !oneof.name().starts_with('_') {
                let name = format!("{name}.{}", oneof.name());
                self.check(is_lower_snake(oneof.name()), &name, "is not lower_snake_case");
                self.comment(&below(8, at), &name);
            }
        }
        for (at, nested) in (0..).zip(&message.nested_type) {
            self.message(nested, below(3, at));
        }
        for (at, one) in (0..).zip(&message.enum_type) {
            self.enumeration(one, below(4, at));
        }
    }

    fn enumeration(&mut self, one: &EnumDescriptorProto, path: Vec<i32>) {
        let (name, prefix) = (one.name(), upper_snake(one.name()) + "_");
        self.check(is_pascal(name), name, "is not PascalCase");
        self.comment(&path, name);
        let aliases = one.options.as_ref().is_some_and(prost_types::EnumOptions::allow_alias);
        self.check(!aliases, name, "allows two names for a number");
        for (at, value) in (0..).zip(&one.value) {
            let shape = value.name().starts_with(&prefix)
                && value.name().chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
            self.check(shape, value.name(), &format!("is not UPPER_SNAKE_CASE that begins with {prefix}"));
            let first = (at == 0) == (value.number() == 0);
            self.check(first, value.name(), "is not in its place: the first value is 0");
            let zero = value.number() != 0 || value.name() == format!("{prefix}UNSPECIFIED");
            self.check(zero, value.name(), "has the number 0 and does not end with _UNSPECIFIED");
            self.comment(&[path.as_slice(), &[2, at]].concat(), value.name());
        }
    }

    /// Services; `uses` counts the inputs and outputs of methods.
    fn services(&mut self, uses: &mut BTreeMap<String, usize>) {
        for (at, service) in (0..).zip(&self.file.service) {
            let name = service.name();
            self.check(is_pascal(name), name, "is not PascalCase");
            self.comment(&[6, at], name);
            for (number, method) in (0..).zip(&service.method) {
                let (method_name, path) = (method.name(), [6, at, 2, number]);
                self.check(is_pascal(method_name), method_name, "is not PascalCase");
                self.comment(&path, method_name);
                for (kind, suffix) in [(method.input_type(), "Request"), (method.output_type(), "Response")] {
                    let short = kind.rsplit('.').next().unwrap_or("");
                    let plain = format!("{method_name}{suffix}");
                    let good = short == plain || short == format!("{name}{plain}");
                    self.check(good, method_name, &format!("has {short} where {plain} is expected"));
                    *uses.entry(kind.to_owned()).or_default() += 1;
                }
            }
        }
    }
}

/// The findings of the rules.
pub(super) fn findings(set: &FileDescriptorSet) -> Vec<String> {
    let (mut all, mut uses) = (Vec::new(), BTreeMap::new());
    for file in &set.file {
        let locations = file.source_code_info.iter().flat_map(|info| &info.location);
        let commented = locations.filter(|place| !place.leading_comments().trim().is_empty());
        let commented = commented.map(|place| place.path.clone()).collect();
        let mut findings = Findings { file, commented, out: Vec::new() };
        findings.file();
        findings.services(&mut uses);
        all.append(&mut findings.out);
    }
    let several = uses.into_iter().filter(|(_, count)| *count > 1);
    all.extend(several.map(|(name, _)| format!("{name} belongs to several methods")));
    all
}
