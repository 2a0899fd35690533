//! A table of tools as a CSV file: a line for each tool, the columns named in the first line.
//!
//! Invariants: a row of the definition knows its line of the file; a tool of a control with edges gets the offset of
//! its edge; a column `X` means each axis that programs call X; lengths are converted into the unit of the machine.

use std::fmt::Write as _;

use super::columns::{self, ToolColumn};
use super::{LengthUnit, ToolDefinitions, ToolImportContext};
use crate::error::Error;

/// First number for tools that have a name and no number.
const FIRST_WITHOUT_NUMBER: u32 = 20_001;

/// Values of a line.
#[derive(Debug, Default)]
struct ToolCsvRow {
    number: Option<u32>,
    offset: Option<u32>,
    edge: Option<u32>,
    name: Option<String>,
    radius: Option<f64>,
    /// Further keys of the offset and of the data of the tool.
    of_offset: String,
    of_data: String,
    values: Vec<String>,
    wear: Vec<String>,
}

impl ToolCsvRow {
    /// Adds a value along each axis that programs call by a name; a name without an axis stays, for the message of the
    /// loader.
    fn along(into: &mut Vec<String>, axis: &str, value: f64, machine: &ToolImportContext) {
        let known = machine.axes(axis);
        let axes = if known.is_empty() { vec![axis] } else { known };
        into.extend(axes.into_iter().map(|axis| format!("{} = {value:?}", toml::Value::String(axis.to_owned()))));
    }

    /// Reads a cell.
    ///
    /// # Errors
    /// The reason why the column does not take it.
    fn take(
        &mut self,
        (column, scale): (&ToolColumn, f64),
        cell: &str,
        table: &ToolCsvReader<'_>,
    ) -> Result<(), String> {
        let value = || {
            let cell = if table.decimal_comma { cell.replace(',', ".") } else { cell.to_owned() };
            let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
            let converted = |value: f64| if scale == 1.0 { value } else { (value * scale * 1e9).round() / 1e9 };
            value.map(converted).ok_or_else(|| format!("'{cell}' is not a number"))
        };
        let whole = || cell.trim_start_matches(['T', 't', 'D', 'd', 'H', 'h']).parse::<u32>();
        let machine = table.machine;
        match column {
            ToolColumn::Number => match whole() {
                Ok(number) => self.number = Some(number),
                Err(_) if machine.by_name && !table.columns.contains(&ToolColumn::Name) => {
                    self.name = Some(cell.to_owned())
                }
                Err(_) => return Err(format!("'{cell}' is not a tool number")),
            },
            ToolColumn::Offset => self.offset = Some(whole().map_err(|_| format!("'{cell}' is not an offset number"))?),
            ToolColumn::Edge => {
                let edge = whole().ok().filter(|edge| (1..machine.edges).contains(edge));
                self.edge =
                    Some(edge.ok_or_else(|| format!("'{cell}' is not an edge (D1 to D{})", machine.edges - 1))?);
            }
            ToolColumn::Name => self.name = Some(cell.to_owned()),
            ToolColumn::Diameter => {
                let value = value()?;
                self.radius = self.radius.or(Some(value / 2.0));
                let _ = write!(self.of_data, ", diameter = {value:?}");
            }
            ToolColumn::Unit => {}
            ToolColumn::Radius => self.radius = Some(value()?),
            ToolColumn::Corner => drop(write!(self.of_data, ", radius = {:?}", value()?)),
            ToolColumn::Tip => drop(write!(self.of_offset, ", tip = {}", value()?)),
            ToolColumn::Length => {
                let value = value()?;
                if value < 0.0 {
                    return Err(format!(
                        "the length {value} is below zero; a distance from the machine zero belongs to a column `Z`"
                    ));
                }
                let _ = write!(self.of_data, ", length = {value:?}");
                if table.length_is_along_z {
                    Self::along(&mut self.values, "Z", value, machine);
                }
            }
            ToolColumn::RadiusWear => drop(write!(self.of_offset, ", radius_wear = {:?}", value()?)),
            ToolColumn::LengthWear if table.length_is_along_z => Self::along(&mut self.wear, "Z", value()?, machine),
            ToolColumn::LengthWear => {}
            ToolColumn::Axis(axis) => Self::along(&mut self.values, axis, value()?, machine),
            ToolColumn::Wear(axis) => Self::along(&mut self.wear, axis, value()?, machine),
        }
        Ok(())
    }

    /// Number of the tool, which a name may replace, and of its offset.
    fn numbers(&self, table: &mut ToolCsvReader<'_>) -> Result<(u32, u32), String> {
        let offset = self.offset.filter(|_| table.columns.contains(&ToolColumn::Offset));
        let number = match (self.number.or(offset), &self.name) {
            (Some(number), _) => number,
            (None, Some(name)) if table.machine.by_name => table.number_of(name),
            _ => return Err("the tool has no number".to_owned()),
        };
        let edges = table.machine.edges;
        let own =
            || if edges > 0 { number.saturating_mul(edges).saturating_add(self.edge.unwrap_or(1)) } else { number };
        Ok((number, offset.unwrap_or_else(own)))
    }
}

/// The head of the file, and the tools so far.
struct ToolCsvReader<'m> {
    machine: &'m ToolImportContext,
    columns: Vec<ToolColumn>,
    /// Numbers may have a decimal comma.
    decimal_comma: bool,
    length_is_along_z: bool,
    /// Tools that have data.
    tools: Vec<u32>,
    /// Names of tools without a number, in order.
    names: Vec<String>,
}

impl ToolCsvReader<'_> {
    fn number_of(&mut self, name: &str) -> u32 {
        let known = self.names.iter().position(|known| known.eq_ignore_ascii_case(name));
        let at = known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        FIRST_WITHOUT_NUMBER.saturating_add(at as u32)
    }
}

/// Reads the text of a file.
pub(super) fn read(file: String, text: &str, machine: &ToolImportContext) -> Result<ToolDefinitions, Error> {
    let wrong = |line: u64, text: String| Error::Usage(format!("{file}:{line}: {text}"));
    let text = format!("{}\n", text.trim_start_matches('\u{feff}').trim_end());
    let (head_line, head) = (1..).zip(text.lines()).find(|(_, line)| !line.starts_with('#')).unwrap_or((1, ""));
    let delimiter = [';', '\t', ','].into_iter().max_by_key(|one| head.matches(*one).count()).unwrap_or(',');
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter as u8)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let titles = reader.headers().map_err(|error| wrong(1, error.to_string()))?.clone();
    let known: Result<Vec<_>, String> = titles.iter().map(|title| columns::column(title, machine)).collect();
    let (columns, units): (Vec<ToolColumn>, Vec<Option<LengthUnit>>) =
        known.map_err(|text| wrong(head_line, text))?.into_iter().unzip();
    for (at, column) in columns.iter().enumerate() {
        let before = columns.iter().take(at).position(|other| other == column);
        if let Some(first) = before.and_then(|first| titles.get(first)) {
            let second = titles.get(at).unwrap_or_default();
            return Err(wrong(
                head_line,
                format!("the columns '{first}' and '{second}' mean the same; remove one of them"),
            ));
        }
    }
    let has = |column: &ToolColumn| columns.contains(column);
    if !(has(&ToolColumn::Number) || has(&ToolColumn::Offset) || machine.by_name && has(&ToolColumn::Name)) {
        let text =
            "the first line names the columns: number, and name, diameter, radius, tip, length or the names of axes";
        return Err(wrong(head_line, text.to_owned()));
    }
    let is_z = |column: &ToolColumn| matches!(column, ToolColumn::Axis(axis) if axis.trim_end_matches(|c: char| c.is_ascii_digit()).eq_ignore_ascii_case("Z"));
    let length_is_along_z = !columns.iter().any(is_z) && !machine.axes("Z").is_empty();
    let mut table = ToolCsvReader {
        machine,
        columns: columns.clone(),
        decimal_comma: delimiter == ';',
        length_is_along_z,
        tools: Vec::new(),
        names: Vec::new(),
    };
    let (mut offsets, mut data) = (String::from("tool.offsets = [\n"), String::from("tool.data = [\n"));
    let (mut of_offsets, mut of_data) = (vec![0], vec![0]);
    let mut record = csv::StringRecord::new();
    while reader
        .read_record(&mut record)
        .map_err(|error| wrong(error.position().map_or(0, csv::Position::line), error.to_string()))?
    {
        // The position of a record is that of the comments before it.
        let line = reader.position().line().saturating_sub(1);
        let cells = columns.iter().zip(&units).zip(&record).filter(|(_, cell)| !cell.is_empty());
        if cells.clone().next().is_none() {
            continue;
        }
        if record.len() > columns.len() {
            return Err(wrong(line, format!("{} columns, where the first line names {}", record.len(), columns.len())));
        }
        let of_row = unit_of_row(&columns, &record).map_err(|text| wrong(line, text))?;
        let lacks = |((column, unit), _): ((&ToolColumn, &Option<LengthUnit>), &str)| {
            unit.is_none() && column.is_length(machine)
        };
        if of_row.is_none() && has(&ToolColumn::Unit) && cells.clone().any(lacks) {
            return Err(wrong(line, "the row does not say the unit of its lengths (mm, inch)".to_owned()));
        }
        let mut row = ToolCsvRow::default();
        for ((column, unit), cell) in cells {
            let unit = unit.or(of_row).filter(|_| column.is_length(machine));
            let scale = unit.map_or(1.0, |unit| unit.in_unit(machine.unit));
            row.take((column, scale), cell, &table).map_err(|text| wrong(line, text))?;
        }
        let (number, offset) = row.numbers(&mut table).map_err(|text| wrong(line, text))?;
        if let Some(radius) = row.radius {
            let _ = write!(row.of_offset, ", radius = {radius:?}");
        }
        if !row.wear.is_empty() {
            let _ = write!(row.of_offset, ", wear = {{ {} }}", row.wear.join(", "));
        }
        let _ =
            writeln!(offsets, "{{ number = {offset}{}, values = {{ {} }} }},", row.of_offset, row.values.join(", "));
        of_offsets.push(line as usize);
        if let Some(name) = &row.name {
            let _ = write!(row.of_data, ", name = {}", toml::Value::String(name.clone()));
        }
        // Further edges of a tool have no data of their own.
        let another_edge = machine.edges > 0 && table.tools.contains(&number);
        if !row.of_data.is_empty() && !another_edge {
            table.tools.push(number);
            if offset != number {
                let _ = write!(row.of_data, ", offset = {offset}");
            }
            let _ = writeln!(data, "{{ number = {number}{} }},", row.of_data);
            of_data.push(line as usize);
        }
    }
    let lines = [of_offsets, vec![0], of_data, vec![0]].concat();
    let names_unit = units.iter().any(Option::is_some) || columns.contains(&ToolColumn::Unit);
    let note = (!names_unit && columns.iter().any(|column| column.is_length(machine))).then(|| {
        let (unit, other) = (machine.unit, machine.unit.other());
        format!("{file}: lengths are in {unit}, the unit of the machine; a table in {other} says so in its titles (`length {other}`)")
    });
    Ok(ToolDefinitions { file, arrays: format!("{offsets}]\n{data}]\n"), sections: String::new(), lines, note })
}

/// The unit in the column of units of a row.
fn unit_of_row(columns: &[ToolColumn], record: &csv::StringRecord) -> Result<Option<LengthUnit>, String> {
    let cell = columns.iter().position(|column| *column == ToolColumn::Unit).and_then(|at| record.get(at));
    let Some(cell) = cell.filter(|cell| !cell.is_empty()) else { return Ok(None) };
    LengthUnit::of(cell).map(Some).ok_or_else(|| format!("'{cell}' is not a unit of length (mm, inch)"))
}
