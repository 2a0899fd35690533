//! The unit in which the programs of a machine begin, as lines of a definition.

use counterpoint_kernel::log::info::MachineUnit;

use crate::error::Error;

/// Codes of the unit of the machine, of the other unit, and of the other unit for lengths only.
const CODES: [&str; 3] = ["CODE_UNITS_PRIMARY", "CODE_UNITS_SECONDARY", "CODE_UNITS_SECONDARY_LENGTHS"];

/// The line `initial` of a machine that begins in the wanted unit. `tables` are the definitions of the machine and of
/// its families, the nearest first.
pub(super) fn initial(machine: &str, tables: &[toml::Table], wanted: MachineUnit) -> Result<String, Error> {
    let own = tables.iter().find_map(|table| table.get("ce")?.get("units")?.as_str());
    let unit = if own == Some("inch") { MachineUnit::Inch } else { MachineUnit::Mm };
    let code = if unit == wanted { has(tables, &CODES[..1]) } else { has(tables, &CODES[1..]) };
    let (Some(code), Some(_), Some(_)) = (code, has(tables, &CODES[..1]), has(tables, &CODES[1..])) else {
        return Err(Error::Usage(format!(
            "--set units: machine '{machine}' has no codes for both units (rows of [[codes]] with CODE_UNITS_PRIMARY and \
             CODE_UNITS_SECONDARY): its programs are always in {}",
            unit.name()
        )));
    };
    let before = tables.iter().find_map(|table| table.get("initial")?.as_array());
    let others = before.into_iter().flatten().filter_map(toml::Value::as_str).filter(|id| !CODES.contains(id));
    let ids: Vec<String> = others.chain([code]).map(|id| format!("\"{id}\"")).collect();
    Ok(format!("initial = [{}]\n", ids.join(", ")))
}

/// The first of these codes that has a row.
fn has(tables: &[toml::Table], ids: &[&'static str]) -> Option<&'static str> {
    let rows = || tables.iter().filter_map(|table| table.get("codes")?.as_array()).flatten();
    let enabled = |row: &&toml::Value| row.get("enable").and_then(toml::Value::as_bool) != Some(false);
    let named = |id: &&str| rows().filter(enabled).any(|row| row.get("id").and_then(toml::Value::as_str) == Some(*id));
    ids.iter().copied().find(|id| named(id))
}
