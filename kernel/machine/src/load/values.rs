//! Small readings that several sections share: factors, and values by axis name.
//!
//! Invariant: a list of values by axis has one number per axis of the machine.

use crate::index::{AxisId, IdTable};
use crate::model::Axis;
use crate::toml::check::FindingCollector;
use crate::toml::section::{TableReader, number};
use crate::toml::suggest::did_you_mean;

/// `mul`, not zero.
pub(super) fn factor(section: &mut TableReader<'_>) -> f64 {
    let mul = section.number("mul").unwrap_or(1.0);
    if mul == 0.0 {
        section.error("mul", "`mul` must not be zero");
        return 1.0;
    }
    mul
}

/// `values = { X1 = …, Z1 = … }`: one value per axis of the machine, 0 where none is given.
pub(super) fn by_axis(
    section: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) -> IdTable<AxisId, f64> {
    some_by_axis(section, "values", axes, check).map(|_, value| value.unwrap_or_default())
}

/// The values of a key by axis name, none where none is given.
pub(super) fn some_by_axis(
    section: &mut TableReader<'_>,
    key: &'static str,
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) -> IdTable<AxisId, Option<f64>> {
    let mut values = axes.map(|_, _| None);
    let Some(table) = section.free_table(key) else { return values };
    for entry in &table.entries {
        let value = number(&entry.node, &entry.key, check);
        match axes.find(|axis| axis.name == entry.key) {
            Some(axis) => values[axis] = value,
            None => {
                let near = did_you_mean(&entry.key, axes.iter().map(|axis| axis.name.as_str()));
                check.missing(&entry.place, format!("no axis has the name \"{}\"{near}", entry.key.escape_debug()));
            }
        }
    }
    values
}
