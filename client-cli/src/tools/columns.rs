//! Columns of a table of tools: the meaning of each title, and the unit of its values.
//!
//! *Invariant:* a title that names neither a column nor an axis of the machine is an error of the first line.

use super::{LengthUnit, ToolImportContext};

/// Columns of a CSV file, for messages.
const COLUMNS: &str =
    "number, name, offset, diameter, radius, corner radius, tip, length, wear radius, wear length, unit";

/// The meaning of a column.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ToolColumn {
    Number,
    Offset,
    Edge,
    Name,
    Unit,
    Diameter,
    Radius,
    Corner,
    Tip,
    Length,
    RadiusWear,
    LengthWear,
    Axis(String),
    Wear(String),
}

/// A column and the unit that its title gives.
pub(super) fn column(title: &str, machine: &ToolImportContext) -> Result<(ToolColumn, Option<LengthUnit>), String> {
    let title = title.trim();
    let last = title.rfind([' ', '_', '(', '[']).map(|at| title.split_at(at));
    let unit = last.and_then(|(before, last)| {
        let unit = LengthUnit::of(last.trim_matches([' ', '_', '(', ')', '[', ']']))?;
        Some((before.trim_end(), unit)).filter(|(before, _)| !before.is_empty())
    });
    let Some((before, unit)) = unit else { return Ok((meaning(title, machine)?, None)) };
    let column = meaning(before, machine)?;
    if !column.is_length(machine) {
        return Err(format!("column '{title}' has a unit of length, but its values are not lengths"));
    }
    Ok((column, Some(unit)))
}

fn meaning(title: &str, machine: &ToolImportContext) -> Result<ToolColumn, String> {
    let worn = title.split_once([' ', '_', '-']).and_then(|(one, other)| {
        let is_wear = |word: &str| word.eq_ignore_ascii_case("wear");
        if is_wear(one) { Some(other) } else { Some(one).filter(|_| is_wear(other)) }
    });
    if let Some(of) = worn {
        return match of.to_ascii_lowercase().as_str() {
            "radius" => Ok(ToolColumn::RadiusWear),
            "length" => Ok(ToolColumn::LengthWear),
            _ => axis(of, title, machine).map(ToolColumn::Wear),
        };
    }
    let is_axis = machine.has_axis(title);
    Ok(match title.to_lowercase().as_str() {
        "number" | "no" | "nr" | "tool" | "t" => ToolColumn::Number,
        "offset" | "h" => ToolColumn::Offset,
        "edge" | "d" if machine.edges > 0 => ToolColumn::Edge,
        "name" | "comment" | "description" => ToolColumn::Name,
        "unit" | "units" => ToolColumn::Unit,
        "diameter" | "dia" | "ø" => ToolColumn::Diameter,
        "radius" => ToolColumn::Radius,
        "r" if !is_axis => ToolColumn::Radius,
        "corner radius" | "corner_radius" => ToolColumn::Corner,
        "r2" if !is_axis => ToolColumn::Corner,
        "tip" => ToolColumn::Tip,
        "length" => ToolColumn::Length,
        "l" if !is_axis => ToolColumn::Length,
        "dl" if !is_axis => ToolColumn::LengthWear,
        "dr" if !is_axis => ToolColumn::RadiusWear,
        _ => ToolColumn::Axis(axis(title, title, machine)?),
    })
}

/// The name of an axis; any name if the axes of the machine are not known.
fn axis(name: &str, title: &str, machine: &ToolImportContext) -> Result<String, String> {
    if machine.axes.is_empty() || machine.has_axis(name) {
        return Ok(name.to_owned());
    }
    let axes = machine.axes.join(", ");
    Err(format!("unknown column '{title}': columns are {COLUMNS}, and the axes of the machine ({axes})"))
}

impl ToolColumn {
    /// Whether its values are lengths.
    pub(super) fn is_length(&self, machine: &ToolImportContext) -> bool {
        match self {
            Self::Number | Self::Offset | Self::Edge | Self::Name | Self::Unit | Self::Tip => false,
            Self::Axis(name) | Self::Wear(name) => !machine.turns(name),
            _ => true,
        }
    }
}
