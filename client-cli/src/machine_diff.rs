//! `machine diff` and `machine show --changed`: two definitions row by row.
//!
//! *Invariant:* every key that differs is shown once, with both values; if a definition lacks the key, its value is
//! absent.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use counterpoint_kernel::machine::{
    DefinedComponent, DefinitionKey, DefinitionRow, WrittenDefinition, is_section_of_composites, show, without_key,
};
use serde::Serialize;
use serde_json::Value;

use crate::arguments::MachinePart;
use crate::error::Error;
use crate::local_machine::LocalMachine;
use crate::machine_view::{self, TableView};
use crate::say;

/// Keys that name the definition itself and therefore always differ.
const NAMES: [&str; 6] = ["name", "number", "revision", "created", "author", "description"];

/// Label of the section of the keys above all sections, in the text output.
const ABOVE: &str = "above all sections";

/// The differences.
#[derive(Debug, Serialize)]
struct Difference {
    a: String,
    b: String,
    rows: Vec<Changed>,
}

/// A row that differs.
#[derive(Debug, Serialize, PartialEq)]
struct Changed {
    section: String,
    row: String,
    /// The letter of the definition that has the row, if the other definition lacks it.
    only: Option<char>,
    keys: Vec<ChangedKey>,
}

/// A key that differs.
#[derive(Debug, Serialize, PartialEq)]
struct ChangedKey {
    key: String,
    a: Option<String>,
    b: Option<String>,
    /// The places of the values.
    a_place: Option<String>,
    b_place: Option<String>,
}

/// Compares two machines.
pub(crate) fn diff(a: &str, b: &str, json: bool) -> Result<u8, Error> {
    let (one, other) = (LocalMachine::open(a)?, LocalMachine::open(b)?);
    let rows = changes(&flat(one.definition()?), &flat(other.definition()?));
    print(&Difference { a: one.name, b: other.name, rows }, json)?;
    Ok(0)
}

/// The rows of a definition and of its components, whose sections begin with the component: `MILL: codes`.
fn flat(definition: WrittenDefinition) -> WrittenDefinition {
    let WrittenDefinition { chain, mut rows, components } = definition;
    for component in components {
        for row in component.definition.rows {
            let place = if row.section.is_empty() { ABOVE } else { &row.section };
            rows.push(DefinitionRow { section: format!("{}: {place}", component.designator), ..row });
        }
    }
    WrittenDefinition { chain, rows, components: Vec::new() }
}

/// The definition from which a machine differs: that of its family, whose components are those of the family; otherwise
/// the definitions that the rows of the components name.
fn base(local: &LocalMachine, own: &WrittenDefinition) -> Result<WrittenDefinition, Error> {
    let mut base = local.family(own)?.unwrap_or_default();
    for component in &own.components {
        if base.components.iter().all(|known| known.designator != component.designator) {
            let mut definition = local.beside(&component.machine)?;
            definition.rows.retain(|row| !is_section_of_composites(&row.section));
            base.components.push(DefinedComponent { definition, ..component.clone() });
        }
    }
    Ok(base)
}

/// The differences of a machine from the family that it extends, or from the defaults without a family.
pub(crate) fn changed(machine: &str, part: MachinePart, view: &TableView, json: bool) -> Result<u8, Error> {
    let local = LocalMachine::open(machine)?;
    let own = local.definition()?;
    let name = own.chain.get(1).map_or("the defaults", String::as_str).to_owned();
    let mut rows = changes(&flat(base(&local, &own)?), &flat(own));
    for row in rows.iter_mut().filter(|row| row.row.is_empty()) {
        let section = &row.section;
        row.keys.retain_mut(|key| {
            let default = if key.a.is_none() { default_of(&local, section, &key.key) } else { None };
            let Some(default) = default.map(|value| value.to_string()) else { return true };
            let differs = key.b.as_ref() != Some(&default);
            key.a = Some(format!("{default} (default)"));
            differs
        });
    }
    rows.retain(|row| !row.keys.is_empty());
    let sections = sections(part)?;
    rows.retain(|row| sections.is_empty() || sections.contains(&section_of(row)));
    let all = rows.len();
    if let Some(filter) = &view.filter {
        rows.retain(|row| machine_view::has(&serde_json::to_string(row).unwrap_or_default(), filter));
    }
    if let Some(column) = &view.sort {
        sort(&mut rows, column)?;
    }
    let missed = all > 0 && rows.is_empty();
    if json || !missed {
        print(&Difference { a: name, b: local.name, rows }, json)?;
    }
    Ok(if missed { machine_view::no_row(view.filter.as_deref().unwrap_or_default()) } else { 0 })
}

/// Sections of a part of the machine; none means all.
fn sections(part: MachinePart) -> Result<&'static [&'static str], Error> {
    Ok(match part {
        MachinePart::All => &[],
        MachinePart::Codes => &["codes", "questionnaire", "time.m_codes"],
        MachinePart::Data => &["data"],
        MachinePart::Groups => &["codes", "initial", "questionnaire"],
        MachinePart::Macros => &["macros", "macros.code", "macros.data"],
        MachinePart::Axes => &["axes", "kinematics"],
        MachinePart::Channels => &["channels", "spindles", "components"],
        MachinePart::Refusals => &["refusals"],
        MachinePart::Undefined => {
            return Err(Error::Usage("--changed: the part `undefined` has no keys that could differ".to_owned()));
        }
    })
}

/// The section of a row without the name of its component.
fn section_of(row: &Changed) -> &str {
    row.section.split_once(": ").map_or(&row.section, |(_, section)| section)
}

/// Sorts the rows of each section by a key, by their name, or by their place.
fn sort(rows: &mut [Changed], column: &str) -> Result<(), Error> {
    let key = machine_view::key(column);
    let of = |row: &Changed| match key {
        "name" => Some(row.row.clone()),
        "file" => row.keys.first().and_then(|key| key.b_place.clone().or_else(|| key.a_place.clone())),
        _ => row.keys.iter().find(|own| own.key == key).and_then(|own| own.b.clone().or_else(|| own.a.clone())),
    };
    if !rows.is_empty() && rows.iter().all(|row| of(row).is_none()) {
        let mut keys: Vec<String> = rows.iter().flat_map(|row| &row.keys).map(|key| key.key.clone()).collect();
        keys.extend(["name".to_owned(), "file".to_owned()]);
        keys.sort_unstable();
        keys.dedup();
        return Err(machine_view::no_column(column, &keys));
    }
    let mut order: Vec<String> = Vec::new();
    for row in rows.iter() {
        if !order.contains(&row.section) {
            order.push(row.section.clone());
        }
    }
    let place = |row: &Changed| order.iter().position(|section| *section == row.section);
    let text = |row: &Changed| of(row).unwrap_or_default();
    rows.sort_by(|a, b| place(a).cmp(&place(b)).then_with(|| machine_view::natural(&text(a), &text(b))));
    Ok(())
}

/// The default for a missing key, if the data of the machine show it.
fn default_of(local: &LocalMachine, section: &str, key: &str) -> Option<Value> {
    let machine = without_key(&local.files, &local.name, section, key)?;
    let all = show::json(&machine);
    let part = section.split('.').filter(|part| !part.is_empty()).try_fold(&all, |value, part| value.get(part))?;
    part.get(key).filter(|value| !value.is_null()).cloned()
}

/// Rows by section and name.
type Rows<'d> = BTreeMap<(&'d str, &'d str), Vec<&'d DefinitionRow>>;

fn changes(a: &WrittenDefinition, b: &WrittenDefinition) -> Vec<Changed> {
    let (mut rows, before, after) = (Vec::new(), by_name(a), by_name(b));
    // Sections in the order of the first definition, then those of the second one alone.
    let mut order: Vec<(&str, &str)> = Vec::new();
    let mut seen = std::collections::BTreeSet::new();
    for row in a.rows.iter().chain(&b.rows) {
        let name = (row.section.as_str(), row.name.as_str());
        if seen.insert(name) {
            order.push(name);
        }
    }
    let mut sections: Vec<&str> = Vec::new();
    for (section, _) in &order {
        if !sections.contains(section) {
            sections.push(section);
        }
    }
    let place = |section: &str| sections.iter().position(|known| *known == section);
    order.sort_by_key(|(section, _)| place(section));
    for name in order {
        let of = |rows: &Rows<'_>| rows.get(&name).map(|rows| rows.iter().map(|row| (*row).clone()).collect());
        let (mut a, mut b): (Vec<DefinitionRow>, Vec<DefinitionRow>) =
            (of(&before).unwrap_or_default(), of(&after).unwrap_or_default());
        // Equal rows cancel out; the others of one name are compared in their order.
        a.retain(|row| match b.iter().position(|other| same(row, other)) {
            Some(at) => {
                b.remove(at);
                false
            }
            None => true,
        });
        let mut others = b.into_iter();
        for row in a {
            rows.extend(pair(Some(&row), others.next().as_ref()));
        }
        for row in others {
            rows.extend(pair(None, Some(&row)));
        }
    }
    rows
}

fn by_name(definition: &WrittenDefinition) -> Rows<'_> {
    let mut rows = Rows::new();
    for row in &definition.rows {
        rows.entry((row.section.as_str(), row.name.as_str())).or_default().push(row);
    }
    rows
}

fn same(a: &DefinitionRow, b: &DefinitionRow) -> bool {
    differing(Some(a), Some(b)).is_empty()
}

fn pair(a: Option<&DefinitionRow>, b: Option<&DefinitionRow>) -> Option<Changed> {
    let row = a.or(b)?;
    let keys = differing(a, b);
    let only = match (a, b) {
        (Some(_), None) => Some('a'),
        (None, Some(_)) => Some('b'),
        _ => None,
    };
    (!keys.is_empty()).then(|| Changed { section: row.section.clone(), row: row.name.clone(), only, keys })
}

/// Keys with different values, without those that only name a definition.
fn differing(a: Option<&DefinitionRow>, b: Option<&DefinitionRow>) -> Vec<ChangedKey> {
    let keys = |row: Option<&DefinitionRow>| row.map_or_else(Vec::new, |row| row.keys.clone());
    let (a_keys, b_keys) = (keys(a), keys(b));
    let find = |keys: &[DefinitionKey], key: &str| keys.iter().find(|known| known.key == key).cloned();
    let mut names: Vec<&str> = a_keys.iter().map(|key| key.key.as_str()).collect();
    names.extend(b_keys.iter().map(|key| key.key.as_str()).filter(|key| find(&a_keys, key).is_none()));
    let section = a.or(b).map_or("", |row| row.section.as_str());
    let section = section.split_once(": ").map_or(section, |(_, section)| section);
    let names_it = |key: &str| {
        section == "ce" && NAMES.contains(&key)
            || (section.is_empty() || section == ABOVE) && ["extends", "abstract"].contains(&key)
    };
    let differs = names.into_iter().filter(|key| !names_it(key)).filter_map(|key| {
        let (one, other) = (find(&a_keys, key), find(&b_keys, key));
        let value = |key: &Option<DefinitionKey>| key.as_ref().map(|key| key.value.clone());
        let place = |key: &Option<DefinitionKey>| key.as_ref().map(|key| key.place.clone());
        (value(&one) != value(&other)).then(|| ChangedKey {
            key: key.to_owned(),
            a: value(&one),
            b: value(&other),
            a_place: place(&one),
            b_place: place(&other),
        })
    });
    differs.collect()
}

fn print(difference: &Difference, json: bool) -> Result<(), Error> {
    if json {
        return say::line(&serde_json::to_string_pretty(difference).unwrap_or_default());
    }
    say::data(text(difference).as_bytes())
}

fn text(difference: &Difference) -> String {
    let Difference { a, b, rows } = difference;
    if rows.is_empty() {
        return format!("{a} and {b} are the same\n");
    }
    let (mut out, mut section) = (format!("- {a}\n+ {b}\n"), None);
    for row in rows {
        if section != Some(&row.section) {
            let title = if row.section.is_empty() { ABOVE } else { &row.section };
            let _ = writeln!(out, "\n{title}");
            section = Some(&row.section);
        }
        if let Some(only) = row.only.filter(|_| !row.row.is_empty()) {
            let sign = if only == 'a' { '-' } else { '+' };
            let own = |key: &ChangedKey| match only {
                'a' => (key.a.clone(), key.a_place.clone()),
                _ => (key.b.clone(), key.b_place.clone()),
            };
            let keys: Vec<String> =
                row.keys.iter().filter_map(|key| Some(format!("{} = {}", key.key, own(key).0?))).collect();
            let at = row.keys.first().and_then(|key| own(key).1).unwrap_or_default();
            let _ = writeln!(out, "  {sign} {}  [{at}]", keys.join(", "));
            continue;
        }
        if !row.row.is_empty() {
            let _ = writeln!(out, "  {}", row.row);
        }
        for key in &row.keys {
            let indent = if row.row.is_empty() { "  " } else { "    " };
            let side = |value: &Option<String>, place: &Option<String>| {
                let place = place.as_ref().map(|place| format!("  [{place}]")).unwrap_or_default();
                format!("{}{place}", value.as_deref().unwrap_or("not given"))
            };
            let _ = writeln!(out, "{indent}{}", key.key);
            let _ = writeln!(out, "{indent}  - {}", side(&key.a, &key.a_place));
            let _ = writeln!(out, "{indent}  + {}", side(&key.b, &key.b_place));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(section: &str, name: &str, keys: &[(&str, &str)]) -> DefinitionRow {
        let key = |(key, value): &(&str, &str)| DefinitionKey {
            key: (*key).to_owned(),
            value: (*value).to_owned(),
            place: "m/machine.toml:1".to_owned(),
        };
        let keys = keys.iter().map(key).collect();
        DefinitionRow { section: section.to_owned(), name: name.to_owned(), place: String::new(), keys }
    }

    #[test]
    fn equal_rows_cancel_out_and_others_are_compared() {
        let definition = |rows| WrittenDefinition { rows, ..WrittenDefinition::default() };
        let a = definition(vec![
            row("ce", "", &[("name", "a")]),
            row("refusals", "PS1", &[("text", "one")]),
            row("refusals", "PS1", &[("text", "two")]),
            row("time", "", &[("stations", "12"), ("rapid", "x")]),
        ]);
        let b = definition(vec![
            row("ce", "", &[("name", "b")]),
            row("time", "", &[("stations", "8"), ("rapid", "x")]),
            row("refusals", "PS1", &[("text", "two")]),
            row("refusals", "PS2", &[("text", "one")]),
        ]);
        let found = changes(&a, &b);
        let shown: Vec<_> = found.iter().map(|row| (row.section.as_str(), row.row.as_str(), row.only)).collect();
        assert_eq!(shown, [("refusals", "PS1", Some('a')), ("refusals", "PS2", Some('b')), ("time", "", None)]);
        let stations = found.last().and_then(|row| row.keys.first());
        assert_eq!(stations.map(|key| (key.a.as_deref(), key.b.as_deref())), Some((Some("12"), Some("8"))));
        assert!(changes(&a, &a).is_empty());
    }
}
