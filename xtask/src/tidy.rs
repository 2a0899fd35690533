//! Rules for the code: crates depend only on lower layers (`floors`), and no measure in `RULES` is exceeded.
//!
//! `xtask/tidy.toml` lists known exceptions. Invariant: that list only shrinks. A new exception is a finding, and so is
//! an entry that is no longer needed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;
use syn::visit::{self, Visit};

use crate::code::{self, Code, is_test};
use crate::counts::{self, Types};
use crate::wording::{Words, long_lines};
use crate::{floors, graph, modules, repeats};

/// Lines of a file.
pub const LINES: usize = 500;
/// Fields of a struct.
pub const FIELDS: usize = 15;
/// Characters of a line of prose or of a machine definition.
const COLUMNS: usize = 120;
const LIST: &str = "xtask/tidy.toml";

/// A measure: its table in the list, its unit, its maximum, and the remedy.
struct Rule {
    table: &'static str,
    unit: &'static str,
    most: usize,
    remedy: &'static str,
}

const fn rule(table: &'static str, unit: &'static str, most: usize, remedy: &'static str) -> Rule {
    Rule { table, unit, most, remedy }
}

const RULES: [Rule; 16] = [
    rule("files", "lines", LINES, "split it by idea"),
    rule("types", "fields", FIELDS, "split it by idea"),
    rule("methods", "methods", 80, "split it into several types"),
    rule("spread", "files with methods", 12, "pass functions only the part that they need"),
    rule("derefs", "Deref and DerefMut", 0, "name the part that is meant"),
    rule("closed", "names of a type that the folder must not know", 0, "call a service of its context"),
    rule("cycles", "modules in cycles", 0, "make dependencies point downwards only"),
    rule("circles", "files in cycles", 0, "make dependencies point downwards only"),
    rule("crates", "thousand lines", 12, "split it by idea"),
    rule("names", "types with the same name", 1, "make each name clear without its path"),
    rule("shared_names", "per cent of types that share a name", 20, "make each name clear without its path"),
    rule("words", "per 10,000 words of comments", 6, "use a noun, or name the role"),
    rule("scanned", "texts made for the scanner", 0, "pass on typed words"),
    rule("machine_names", "names of machines", 0, "move the case into the machine definition"),
    rule("columns", "lines longer than 120 characters", 0, "split the lines"),
    rule("repeats", "lines that other files also have", 0, "include one file in both"),
];

/// Measured numbers by name.
type Measured = BTreeMap<String, usize>;

/// The exceptions to each rule.
#[derive(Debug, Default, Deserialize, PartialEq)]
struct Exceptions {
    /// Types that may have any number of fields.
    #[serde(default)]
    tables: BTreeSet<String>,
    #[serde(flatten)]
    rules: BTreeMap<String, Measured>,
}

impl Exceptions {
    /// Notes a measure if it exceeds its rule.
    fn note(&mut self, table: &str, name: impl Into<String>, size: usize) {
        if RULES.iter().any(|rule| rule.table == table && size > rule.most) {
            self.rules.entry(table.to_owned()).or_default().insert(name.into(), size);
        }
    }
}

/// Counts the fields of structs.
struct Fields<'c> {
    path: &'c str,
    wide: Vec<(String, usize)>,
}

impl<'ast> Visit<'ast> for Fields<'_> {
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        if !is_test(&item.attrs) {
            self.wide.push((format!("{}: {}", self.path, item.ident), item.fields.len()));
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }
}

fn measure_file(code: &Code, machines: &BTreeSet<String>, found: &mut Exceptions) {
    found.note("files", &code.path, code.text.lines().count());
    let mut fields = Fields { path: &code.path, wide: Vec::new() };
    fields.visit_file(&code.file);
    for (name, size) in fields.wide {
        found.note("types", name, size);
    }
    let [named, scanned] = counts::mentions(code, machines);
    found.note("machine_names", &code.path, named);
    found.note("closed", &code.path, counts::closed(&code.path, &code.text));
    found.note("scanned", &code.path, scanned);
}

fn measure_crate(name: &str, codes: &[Code], found: &mut Exceptions) -> Types {
    for module in modules::cycles(&modules::arrows(codes)).into_iter().flatten() {
        found.note("cycles", format!("{name}: {module}"), 1);
    }
    for circle in modules::cycles(&modules::file_arrows(codes)) {
        for module in &circle {
            found.note("circles", format!("{name}: {module}"), circle.len());
        }
    }
    let lines: usize = codes.iter().map(|code| code.text.lines().count()).sum();
    found.note("crates", name, lines.div_ceil(1000));
    let types = counts::types(codes);
    for (one, count) in &types.defined {
        found.note("names", format!("{name}: {one}"), *count);
    }
    for (one, count) in &types.methods {
        found.note("methods", format!("{name}: {one}"), *count);
    }
    for (one, count) in &types.derefs {
        found.note("derefs", format!("{name}: {one}"), *count);
    }
    for (one, files) in &types.files {
        found.note("spread", format!("{name}: {one}"), files.len());
    }
    types
}

/// Measures prose and machine definitions.
fn measure_texts(root: &Path, found: &mut Exceptions) -> Result<(), String> {
    let texts = code::texts(root, &["md", "h", "spf", "mac", "toml"])?;
    let columns = |path: &str| [".md", ".h", ".spf"].iter().any(|end| path.ends_with(end));
    for (path, text) in texts.iter().filter(|(path, _)| columns(path)) {
        found.note("columns", path, long_lines(text, COLUMNS));
    }
    let machines = texts.into_iter().filter(|(path, _)| path.starts_with("machines/") && !path.ends_with(".md"));
    for (path, lines) in repeats::repeated(&machines.collect()) {
        found.note("repeats", path, lines);
    }
    Ok(())
}

fn measure(root: &Path) -> Result<Exceptions, String> {
    let mut found = Exceptions::default();
    let machines = code::machines(root)?;
    let mut crates = Vec::new();
    let mut words = Words::default();
    for name in code::crates(root)? {
        let codes: Vec<Code> = code::files(root, &name)?;
        for code in &codes {
            measure_file(code, &machines, &mut found);
            words.add(&code.text);
        }
        crates.push(measure_crate(&name, &codes, &mut found));
    }
    found.note("shared_names", "all crates", counts::shared_names(&crates));
    let [what, people] = words.shares();
    found.note("words", "what", what);
    found.note("words", "somebody, nobody, whoever", people);
    measure_texts(root, &mut found)?;
    Ok(found)
}

/// Compares the measures of a rule with the allowed exceptions.
fn sizes(rule: &Rule, found: &Measured, known: &Measured, out: &mut Vec<String>) {
    let Rule { table, unit, most, remedy } = rule;
    for (name, size) in found {
        match known.get(name) {
            Some(allowed) if size <= allowed => {}
            Some(allowed) => {
                out.push(format!("{name}: {size} {unit}, [{table}] in {LIST} allows {allowed}: {remedy}"));
            }
            None => out.push(format!("{name}: {size} {unit}, at most {most} are allowed: {remedy}")),
        }
    }
    for name in known.keys().filter(|name| !found.contains_key(*name)) {
        out.push(format!("{name} no longer needs an exception: remove it from [{table}] in {LIST}"));
    }
}

fn compare(found: &Exceptions, known: &Exceptions) -> Vec<String> {
    let mut out = Vec::new();
    let none = Measured::new();
    for rule in &RULES {
        let [mut now, before] = [found, known].map(|list| list.rules.get(rule.table).unwrap_or(&none).clone());
        if rule.table == "types" {
            for name in known.tables.iter().filter(|name| now.remove(*name).is_none()) {
                out.push(format!("{name} no longer needs an exception: remove it from tables in {LIST}"));
            }
        }
        sizes(rule, &now, &before, &mut out);
    }
    let unknown = known.rules.keys().filter(|table| !RULES.iter().any(|rule| rule.table == **table));
    out.extend(unknown.map(|table| format!("[{table}] in {LIST} is not a rule: remove it")));
    out
}

fn written(found: &Exceptions, tables: &BTreeSet<String>) -> String {
    let list: Vec<String> = tables.iter().map(|name| format!("    {name:?},\n")).collect();
    let mut out = format!(
        "# Exceptions that `cargo xtask tidy` accepts. The list only shrinks; `cargo xtask tidy --update` rewrites it.\n\n\
         # Types that are tables by nature.\ntables = [\n{}]\n",
        list.concat()
    );
    for Rule { table, unit, most, .. } in &RULES {
        let _ = write!(out, "\n# More than {most} {unit}.\n[{table}]\n");
        let known = found.rules.get(*table).into_iter().flatten();
        for (name, size) in known.filter(|(name, _)| *table != "types" || !tables.contains(*name)) {
            let _ = writeln!(out, "{name:?} = {size}");
        }
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
        let wide = found.rules.get("types");
        let tables = known.tables.into_iter().filter(|name| wide.is_some_and(|wide| wide.contains_key(name)));
        std::fs::write(&path, written(&found, &tables.collect())).map_err(|error| format!("{LIST}: {error}"))?;
        return Ok(Vec::new());
    }
    let mut findings = compare(&found, &known);
    findings.append(&mut floors::findings(&graph::packages(root)?));
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Exceptions {
        toml::from_str(text).expect("a list")
    }

    #[test]
    fn the_list_only_shrinks() {
        let known =
            list("[cycles]\n'k: a' = 1\n'k: b' = 1\n[files]\n'a.rs' = 600\n'b.rs' = 600\n[types]\n'a.rs: T' = 20");
        assert_eq!(compare(&known, &known), [""; 0]);
        let found =
            list("[cycles]\n'k: b' = 1\n'k: c' = 1\n[files]\n'a.rs' = 601\n'c.rs' = 501\n[types]\n'a.rs: T' = 19");
        let findings = compare(&found, &known).join("\n");
        for part in [
            "k: c: 1 modules in cycles, at most 0",
            "k: a no longer needs an exception",
            "a.rs: 601 lines, [files] in xtask/tidy.toml allows 600: split",
            "c.rs: 501 lines, at most 500",
            "b.rs no longer needs an exception",
        ] {
            assert!(findings.contains(part), "{part}\n{findings}");
        }
        assert_eq!(findings.lines().count(), 5);
        assert_eq!(list(&written(&found, &found.tables)).rules["files"], found.rules["files"]);
    }

    #[test]
    fn tables_may_have_any_number_of_fields() {
        let wide = list("[types]\n'a.rs: T' = 20");
        let table = list("tables = ['a.rs: T']");
        assert_eq!(compare(&wide, &table), [""; 0]);
        assert_eq!(compare(&Exceptions::default(), &table).len(), 1);
        assert_eq!(
            compare(&Exceptions::default(), &list("[rooms]")),
            ["[rooms] in xtask/tidy.toml is not a rule: remove it"]
        );
    }

    #[test]
    fn a_measure_is_noted_if_it_exceeds_its_rule() {
        let mut found = Exceptions::default();
        for rule in &RULES {
            found.note(rule.table, "kept", rule.most);
            found.note(rule.table, "broken", rule.most + 1);
        }
        assert_eq!(found.rules.len(), RULES.len());
        assert!(found.rules.values().all(|measured| measured.keys().eq(["broken"])));
    }
}
