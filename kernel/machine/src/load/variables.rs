//! `[variables]`: which common variables the channels share.
//!
//! Invariant: ranges run upwards, start at 100 and do not overlap. Facts: reference channel-synchronisation.md 1.3.

use super::system_variables;
use crate::model::{Externals, ProgramVariables};
use crate::system_variables::SystemVariables;
use crate::toml::check::FindingCollector;
use crate::toml::node::{Node, TomlValue};
use crate::toml::section::TableReader;

/// First common variable; those below are local to a program.
const FIRST: i64 = 100;

/// Last common variable.
const LAST: i64 = 999_999;

/// Reads the section.
pub(super) fn read(
    top: &mut TableReader<'_>,
    (system, external): (SystemVariables, Externals),
    check: &FindingCollector,
) -> ProgramVariables {
    let mut variables =
        ProgramVariables { shared: Vec::new(), channel: Vec::new(), own_common: false, external, system };
    let Some(mut section) = top.table("variables", "[variables]") else { return variables };
    let mut taken: Vec<(u32, u32)> = Vec::new();
    variables.shared = ranges(&mut section, "shared", &mut taken, check);
    variables.channel = ranges(&mut section, "channel", &mut taken, check);
    system_variables::read_settings(&mut section, &mut variables.system, check);
    variables.own_common = section.flag("own_common").unwrap_or(false);
    let others = [("alarm", false), ("global", true)];
    variables.external.any = section.choice("other_external", &others).unwrap_or(false);
    section.finish();
    variables
}

fn ranges(
    section: &mut TableReader<'_>,
    key: &'static str,
    taken: &mut Vec<(u32, u32)>,
    check: &FindingCollector,
) -> Vec<(u32, u32)> {
    let mut ranges = Vec::new();
    for item in section.list(key).unwrap_or_default() {
        let Some((first, last)) = range(item) else {
            let expected = format!("[first, last] from {FIRST} to {LAST}, the smaller number first");
            check.error(&item.place, format!("`{key}` must be a list of {expected}"));
            continue;
        };
        if let Some((from, to)) = taken.iter().find(|(from, to)| *from <= last && first <= *to) {
            check.error(&item.place, format!("#{first}-#{last} overlaps #{from}-#{to}"));
        }
        taken.push((first, last));
        ranges.push((first, last));
    }
    ranges
}

fn range(item: &Node) -> Option<(u32, u32)> {
    let TomlValue::Array(ends) = &item.value else { return None };
    let [first, last] = ends.as_slice() else { return None };
    let (TomlValue::Integer(first), TomlValue::Integer(last)) = (&first.value, &last.value) else { return None };
    let valid = FIRST <= *first && first <= last && *last <= LAST;
    if valid { Some((u32::try_from(*first).ok()?, u32::try_from(*last).ok()?)) } else { None }
}
