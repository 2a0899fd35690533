//! The system variables of the control: types, indices, access, first values.
//!
//! Invariant: every name occurs once, and every row is complete; the tests count the rows of each category. Facts:
//! reference system-variables.md. `$CI`, `$CHSIZ`, `$CHMAX`, `$MNEST` and `$ERRNO` are listed, but kept by the machine
//! that runs macros; the constants are part of the language.

use std::collections::HashMap;
use std::sync::OnceLock;

use counterpoint_lang::host::SystemVariable;
use counterpoint_lang::ident;
use counterpoint_lang::value::{MacroValue, ValueType};

use super::pattern::expand;

/// Access of programs to a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControlVariableAccess {
    /// Not assignable.
    Read,
    /// Every macro.
    Write,
    /// Macros that run before Machine Startup ends; a later write has no effect and is worth a warning.
    Start,
}

/// A system variable.
#[derive(Debug, Clone)]
pub struct ControlVariable {
    /// Name with its dollar sign, upper case.
    pub name: String,
    /// Type, none if it may vary.
    pub kind: Option<ValueType>,
    /// Largest value of each index, none without a limit; empty for a single value.
    pub indices: Vec<Option<u32>>,
    /// Access of programs to it.
    pub access: ControlVariableAccess,
    /// Its owner.
    pub category: &'static str,
    /// Value before anything sets it.
    pub first: MacroValue,
    /// Smallest and largest number that may be written.
    pub range: Option<(f64, f64)>,
    /// A description in one sentence.
    pub about: &'static str,
}

impl ControlVariable {
    /// Name with the largest indices, as `$TLTAB(1..50,1..200)`.
    #[must_use]
    pub fn form(&self) -> String {
        if self.indices.is_empty() {
            return self.name.clone();
        }
        let index = |most: &Option<u32>| most.map_or_else(|| "n".to_owned(), |most| format!("1..{most}"));
        let indices: Vec<String> = self.indices.iter().map(index).collect();
        format!("{}({})", self.name, indices.join(","))
    }

    /// The variable as a compiler needs it.
    #[must_use]
    pub fn symbol(&self) -> SystemVariable {
        SystemVariable {
            name: self.name.clone(),
            kind: self.kind,
            writable: self.access != ControlVariableAccess::Read,
            indices: u8::try_from(self.indices.len()).unwrap_or(u8::MAX),
        }
    }
}

/// All system variables.
pub fn table() -> &'static [ControlVariable] {
    static TABLE: OnceLock<Vec<ControlVariable>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let lines = include_str!("system.tsv").lines().filter(|line| !line.starts_with('#'));
        lines.filter_map(row).flatten().collect()
    })
}

/// The variable with this name, upper case.
#[must_use]
pub fn find(name: &str) -> Option<&'static ControlVariable> {
    static NAMES: OnceLock<HashMap<&'static str, &'static ControlVariable>> = OnceLock::new();
    NAMES.get_or_init(|| table().iter().map(|variable| (variable.name.as_str(), variable)).collect()).get(name).copied()
}

fn row(line: &'static str) -> Option<Vec<ControlVariable>> {
    let columns: Vec<&str> = line.split('\t').collect();
    let [names, kind, indices, access, category, first, range, about] = *columns.as_slice() else { return None };
    let kind = match kind {
        "N" => Some(ValueType::Real),
        "L" => Some(ValueType::Logical),
        "S" => Some(ValueType::Text),
        "Q" => Some(ValueType::Sequence),
        "K" => Some(ValueType::Keyword),
        "C" => Some(ValueType::Code),
        "A" => None,
        _ => return None,
    };
    let access = match access {
        "ro" => ControlVariableAccess::Read,
        "rw" => ControlVariableAccess::Write,
        "start" => ControlVariableAccess::Start,
        _ => return None,
    };
    let indices: Vec<Option<u32>> = match indices {
        "" => Vec::new(),
        some => some.split(',').map(|most| most.parse().ok()).collect(),
    };
    let range = match range.split_once("..") {
        Some((low, high)) => Some((low.parse().ok()?, high.parse().ok()?)),
        None => None,
    };
    let first = first_value(first, kind)?;
    let variable = |name| ControlVariable {
        name,
        kind,
        indices: indices.clone(),
        access,
        category,
        first: first.clone(),
        range,
        about,
    };
    Some(expand(names).into_iter().map(variable).collect())
}

fn first_value(text: &str, kind: Option<ValueType>) -> Option<MacroValue> {
    Some(match text {
        "-" => kind.map_or(MacroValue::Null, ValueType::initial),
        "$NULL" => MacroValue::Null,
        ".TRUE." => MacroValue::Logical(true),
        text => match text.strip_prefix('\'').and_then(|text| text.strip_suffix('\'')) {
            Some(text) => MacroValue::text(text),
            None => match text.parse() {
                Ok(number) => MacroValue::Real(number),
                Err(_) => MacroValue::Keyword(ident::minor_code(text)?),
            },
        },
    })
}

/// The product that has a variable of this name when the control has none (reference system-variables.md 20).
#[must_use]
pub fn product_of(name: &str) -> Option<&'static str> {
    const POST: &str = "the post product";
    const NAMES: [&str; 9] =
        ["$LOOK", "$LOOKAH", "$MLOOK", "$TLOOK", "$ANYLOOK", "$CUTTER", "$HLDTAB", "$HI", "$CLREC"];
    let axes = name.strip_prefix("$N").filter(|rest| matches!(rest.len(), 2 | 3));
    let ahead = axes.is_some_and(|rest| {
        let (axis, kind) = rest.split_at(1);
        "XYZUVWENABCIJK".contains(axis) && matches!(kind, "M" | "C" | "J" | "TM" | "HM" | "TJ" | "HJ")
    });
    (find(name).is_none() && (ahead || NAMES.contains(&name) || name.ends_with("SHFT"))).then_some(POST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Variables of each category: read-only, writable, writable at the start.
    const COUNTS: [(&str, [usize; 3]); 19] = [
        ("compensation", [4, 8, 0]),
        ("composite", [7, 0, 0]),
        ("constants", [4, 0, 0]),
        ("coolant, feed, spindle", [1, 13, 0]),
        ("cycles", [2, 32, 0]),
        ("diagnostics", [1, 7, 0]),
        ("environment", [19, 5, 0]),
        ("kernels", [3, 2, 6]),
        ("lathe", [4, 8, 0]),
        ("macros", [2, 14, 0]),
        ("model", [16, 12, 0]),
        ("motion", [16, 13, 0]),
        ("operations", [3, 6, 0]),
        ("positions", [78, 6, 0]),
        ("program", [9, 4, 0]),
        ("subprograms", [4, 1, 0]),
        ("time", [1, 4, 0]),
        ("tools", [4, 11, 0]),
        ("units", [4, 2, 0]),
    ];

    #[test]
    fn every_row_of_the_reference_is_there_with_its_access() {
        let mut counts: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
        for variable in table() {
            counts.entry(variable.category).or_default()[variable.access as usize] += 1;
        }
        assert_eq!(counts.into_iter().collect::<Vec<_>>(), COUNTS);
        assert_eq!(table().len(), 336);
    }

    #[test]
    fn every_line_is_complete() {
        let lines = include_str!("system.tsv").lines().filter(|line| !line.starts_with('#'));
        for line in lines {
            assert!(row(line).is_some_and(|rows| !rows.is_empty()), "{line}");
            assert!(line.ends_with('.'), "{line}");
        }
        let mut names: Vec<&str> = table().iter().map(|variable| variable.name.as_str()).collect();
        names.sort_unstable();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count, "a name occurs twice");
        for variable in table() {
            let fits =
                variable.first.kind().is_none() || variable.kind.is_none() || variable.first.kind() == variable.kind;
            assert!(fits, "{}", variable.name);
            assert!(variable.range.is_none() || variable.kind == Some(ValueType::Real), "{}", variable.name);
        }
    }

    #[test]
    fn the_page_shows_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/macro-language/system-variables.md");
        let page = std::fs::read_to_string(path).unwrap();
        let mut shown = page.lines().filter(|line| line.starts_with("| `$"));
        for line in include_str!("system.tsv").lines().filter(|line| !line.starts_with('#')) {
            let columns: Vec<&str> = line.split('\t').collect();
            let variables = row(line).unwrap();
            let variable = &variables[0];
            let form = variable.form().replacen(&variable.name, columns[0], 1);
            let kind = variable.kind.map_or("any", ValueType::name);
            let range = if columns[6].is_empty() { String::new() } else { format!(" {}", columns[6]) };
            let access = match variable.access {
                ControlVariableAccess::Read => "read",
                ControlVariableAccess::Write => "write",
                ControlVariableAccess::Start => "start",
            };
            let first = if columns[5] == "-" { String::new() } else { format!("`{}`", columns[5]) };
            let wanted = format!("| `{form}` | {kind}{range} | {access} | {first} | {} |", variable.about);
            assert_eq!(shown.next(), Some(wanted.as_str()));
        }
        assert_eq!(shown.next(), None);
    }

    #[test]
    fn facts_of_the_reference() {
        let facts = |name: &str| find(name).map(|v| (v.kind, v.access, v.form()));
        assert_eq!(facts("$CECODE"), Some((Some(ValueType::Code), ControlVariableAccess::Read, "$CECODE".to_owned())));
        assert_eq!(facts("$TLTAB"), Some((None, ControlVariableAccess::Write, "$TLTAB(1..50,1..200)".to_owned())));
        assert_eq!(facts("$LZM"), Some((Some(ValueType::Real), ControlVariableAccess::Read, "$LZM".to_owned())));
        assert_eq!(
            facts("$MCEMCD"),
            Some((Some(ValueType::Text), ControlVariableAccess::Start, "$MCEMCD(n)".to_owned()))
        );
        assert_eq!(find("$SPINDLE").unwrap().first.kind(), Some(ValueType::Keyword));
        assert_eq!(
            (product_of("$NXM"), product_of("$NMCD"), product_of("$XX")),
            (Some("the post product"), None, None)
        );
    }
}
