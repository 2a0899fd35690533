//! `[[external]]`: variables that programs share with the PLC of the machine.
//!
//! Invariant: names are in capitals and each has one row. Facts: reference channel-synchronisation.md 1.7.

use crate::model::{External, ExternalKind, Externals};
use crate::preprocessor::Preprocessor;
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Most rows.
const MOST: usize = 1000;

/// Most elements of an array.
const ELEMENTS: i64 = 10_000;

/// Longest name.
const LONGEST: usize = 64;

/// Reads the rows.
pub(super) fn read(top: &mut TableReader<'_>, preprocessor: Preprocessor, check: &FindingCollector) -> Externals {
    let mut externals = Externals::default();
    for mut section in top.rows("external", "[[external]]", MOST) {
        if !preprocessor.row().external_variables {
            let name = preprocessor.row().name;
            check.error(section.place(), format!("the pre-processor \"{name}\" has no external variables"));
        }
        section.require("name", "what stands behind V.E.");
        let name = name(&mut section);
        let row = row(&mut section, name.clone().unwrap_or_default());
        if name.as_deref().is_some_and(|name| externals.find(name).is_some()) {
            section.error("name", format!("V.E.{} has a row above", row.name));
        } else if name.is_some() {
            externals.rows.push(row);
        }
        section.finish();
    }
    externals
}

/// Names with points are members of structures.
fn name(section: &mut TableReader<'_>) -> Option<String> {
    let name = section.name("name", LONGEST)?.to_ascii_uppercase();
    let is_part = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
    };
    if name.split('.').all(is_part) {
        return Some(name);
    }
    section.error("name", "a name has letters, digits and underscores, without the V.E. in front");
    None
}

fn row(section: &mut TableReader<'_>, name: String) -> External {
    let own = section.choice("scope", &[("global", false), ("channel", true)]).unwrap_or(false);
    let synchronous = section.flag("synchronous").unwrap_or(true);
    let accesses = [("read-write", (true, true)), ("read", (true, false)), ("write", (false, true))];
    let (readable, writable) = section.choice("access", &accesses).unwrap_or((true, true));
    let kinds = [("real", ExternalKind::Real), ("integer", ExternalKind::Integer), ("boolean", ExternalKind::Boolean)];
    let kind = section.choice("type", &kinds).unwrap_or(ExternalKind::Real);
    let elements = section.integer("elements", 0..=ELEMENTS).unwrap_or(0) as u32;
    let value = section.number("value").unwrap_or(0.0);
    let fits = match kind {
        ExternalKind::Real => true,
        ExternalKind::Integer => value.fract() == 0.0,
        ExternalKind::Boolean => value == 0.0 || value == 1.0,
    };
    if !fits {
        section.error("value", "the value does not go with the type");
    }
    External { name, own, synchronous, readable, writable, kind, elements, value }
}
