//! Rules for the code: arrows between crates go down the floors (`floors`), no cycles between the modules of a crate,
//! files of at most [`LINES`] lines, types of at most [`FIELDS`] fields, except for types that are a table by nature
//! (settings, rows, messages on the wire).
//!
//! Known exceptions are listed in `xtask/tidy.toml`. Invariant: that list only shrinks: a new exception is a finding,
//! and so is an unneeded entry.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;
use syn::visit::{self, Visit};

use crate::code::{self, Code, is_test};
use crate::{floors, graph, modules};

/// Lines of a file.
pub const LINES: usize = 500;
/// Fields of a struct.
pub const FIELDS: usize = 15;
const LIST: &str = "xtask/tidy.toml";

/// Exceptions that remain to be fixed, or that stay for a reason.
#[derive(Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Exceptions {
    /// By crate: modules that are in a cycle.
    #[serde(default)]
    cycles: BTreeMap<String, BTreeSet<String>>,
    /// Longest length by file.
    #[serde(default)]
    files: BTreeMap<String, usize>,
    /// Most fields by type.
    #[serde(default)]
    types: BTreeMap<String, usize>,
    /// Types that may have any number of fields.
    #[serde(default)]
    tables: BTreeSet<String>,
}

/// Counts the fields of structs.
struct Types<'c> {
    path: &'c str,
    wide: BTreeMap<String, usize>,
}

impl<'ast> Visit<'ast> for Types<'_> {
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        let fields = item.fields.len();
        if fields > FIELDS && !is_test(&item.attrs) {
            self.wide.insert(format!("{}: {}", self.path, item.ident), fields);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }
}

fn measure(root: &Path) -> Result<Exceptions, String> {
    let mut found = Exceptions::default();
    for name in code::crates(root)? {
        let codes: Vec<Code> = code::files(root, &name)?;
        for code in &codes {
            if code.lines > LINES {
                found.files.insert(code.path.clone(), code.lines);
            }
            let mut types = Types { path: &code.path, wide: BTreeMap::new() };
            types.visit_file(&code.file);
            found.types.append(&mut types.wide);
        }
        let cycles: BTreeSet<String> = modules::cycles(&modules::arrows(&codes)).into_iter().flatten().collect();
        if !cycles.is_empty() {
            found.cycles.insert(name, cycles);
        }
    }
    Ok(found)
}

/// Compares sizes with those that are allowed.
fn sizes(
    found: &BTreeMap<String, usize>,
    known: &BTreeMap<String, usize>,
    (what, most): (&str, usize),
    out: &mut Vec<String>,
) {
    for (name, size) in found {
        match known.get(name) {
            Some(allowed) if size <= allowed => {}
            Some(allowed) => out.push(format!("{name} has {size} {what}, {LIST} allows {allowed}: make it smaller")),
            None => out.push(format!("{name} has {size} {what}, at most {most} are allowed: divide it by ideas")),
        }
    }
    for name in known.keys().filter(|name| !found.contains_key(*name)) {
        out.push(format!("{name} needs no exception any more: take it out of {LIST}"));
    }
}

fn compare(found: &Exceptions, known: &Exceptions) -> Vec<String> {
    let mut out = Vec::new();
    let none = BTreeSet::new();
    let crates: BTreeSet<&String> = found.cycles.keys().chain(known.cycles.keys()).collect();
    for name in crates {
        let now = found.cycles.get(name).unwrap_or(&none);
        let before = known.cycles.get(name).unwrap_or(&none);
        for module in now.difference(before) {
            out.push(format!("{name}: module {module} uses and is used by others in a cycle: let arrows go down only"));
        }
        for module in before.difference(now) {
            out.push(format!("{name}: module {module} is in no cycle any more: take it out of {LIST}"));
        }
    }
    sizes(&found.files, &known.files, ("lines", LINES), &mut out);
    let (tables, types): (BTreeMap<_, _>, _) =
        found.types.clone().into_iter().partition(|(name, _)| known.tables.contains(name));
    sizes(&types, &known.types, ("fields", FIELDS), &mut out);
    for name in known.tables.iter().filter(|name| !tables.contains_key(*name)) {
        out.push(format!("{name} needs no exception any more: take it out of {LIST}"));
    }
    out
}

fn written(found: &Exceptions, tables: &BTreeSet<String>) -> String {
    let list: Vec<String> = tables.iter().map(|name| format!("    {name:?},\n")).collect();
    let mut out = format!(
        "# What `cargo xtask tidy` lets pass. The list only shrinks; `cargo xtask tidy --update` rewrites it.\n\n# Types that are a table by nature.\ntables = [\n{}]\n",
        list.concat()
    );
    out.push_str("\n# Modules in cycles, by crate.\n[cycles]\n");
    for (name, modules) in &found.cycles {
        let modules: Vec<String> = modules.iter().map(|module| format!("{module:?}")).collect();
        let _ = writeln!(out, "{name:?} = [{}]", modules.join(", "));
    }
    out.push_str("\n# Files with more than 500 lines.\n[files]\n");
    for (name, size) in &found.files {
        let _ = writeln!(out, "{name:?} = {size}");
    }
    out.push_str("\n# Types with more than 15 fields.\n[types]\n");
    for (name, size) in found.types.iter().filter(|(name, _)| !tables.contains(*name)) {
        let _ = writeln!(out, "{name:?} = {size}");
    }
    out
}

/// Findings about the code below `root`; `update` rewrites the list of exceptions instead.
///
/// # Errors
/// When a file cannot be read or parsed.
pub fn check(root: &Path, update: bool) -> Result<Vec<String>, String> {
    let found = measure(root)?;
    let path = root.join(LIST);
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{LIST}: {error}"))?;
    let known: Exceptions = toml::from_str(&text).map_err(|error| format!("{LIST}: {error}"))?;
    if update {
        let tables = known.tables.into_iter().filter(|name| found.types.contains_key(name)).collect();
        std::fs::write(&path, written(&found, &tables)).map_err(|error| format!("{LIST}: {error}"))?;
        return Ok(Vec::new());
    }
    let mut findings = compare(&found, &known);
    findings.append(&mut floors::findings(&graph::packages(root)?));
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_only_shrinks() {
        let list = |text: &str| toml::from_str::<Exceptions>(text).expect("a list");
        let known = list("[cycles]\nkernel = ['a', 'b']\n[files]\n'a.rs' = 600\n'b.rs' = 600\n[types]\n'a.rs: T' = 20");
        assert_eq!(compare(&known, &known), [""; 0]);
        let found = list("[cycles]\nkernel = ['b', 'c']\n[files]\n'a.rs' = 601\n'c.rs' = 501\n[types]\n'a.rs: T' = 19");
        let findings = compare(&found, &known).join("\n");
        for part in [
            "module c uses",
            "module a is in no cycle",
            "a.rs has 601 lines",
            "c.rs has 501",
            "b.rs needs no exception",
        ] {
            assert!(findings.contains(part), "{part}\n{findings}");
        }
        assert_eq!(findings.lines().count(), 5);
        assert_eq!(list(&written(&found, &found.tables)), found);
        let wide = list("[types]\n'a.rs: T' = 20");
        let table = list("tables = ['a.rs: T']");
        assert_eq!(compare(&wide, &table), [""; 0]);
        assert_eq!(compare(&Exceptions::default(), &table).len(), 1);
    }
}
