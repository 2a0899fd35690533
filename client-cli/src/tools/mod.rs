//! `--tools FILE`: tools, tool offsets and work offsets of one run.
//!
//! The rows become a machine that extends the one of the run. A TOML file has them in the form of a machine definition.
//! A CSV file has a line for each tool, as tool lists of CAM systems and spreadsheets do. Invariant: every error in a
//! row is reported with the line of the user's file.

mod columns;
mod csv_file;
mod unit;

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::standard_input;
use unit::LengthUnit;

/// Tables of a TOML file.
const TABLES: &str = "[[tool.offsets]], [[tool.data]], [[tool.names]] and [[work_offsets]]";
const KEYS: [&str; 3] = ["offsets", "data", "names"];

/// Facts of a machine that give a CSV file its meaning.
#[derive(Debug, Default)]
pub(crate) struct ToolImportContext {
    /// Names of its axes.
    pub(crate) axes: Vec<String>,
    /// Offsets of a tool: edge D of tool T has the offset `edges` × T + D; 0 = the number of the tool.
    pub(crate) edges: u32,
    /// Programs call tools by their names.
    pub(crate) by_name: bool,
    /// Names of its rotary axes.
    rotary: Vec<String>,
    /// Its unit of length.
    unit: LengthUnit,
}

impl ToolImportContext {
    /// Facts from definitions of machines; earlier definitions take precedence.
    pub(crate) fn of<'t>(texts: impl Iterator<Item = &'t str>) -> Self {
        let tables: Vec<toml::Table> = texts.filter_map(|text| toml::from_str(text).ok()).collect();
        let text = |axis: &toml::Value, key: &str| axis.get(key).and_then(toml::Value::as_str).map(str::to_owned);
        let name = |axis: &toml::Value| text(axis, "name");
        let turns = |axis: &&toml::Value| match (text(axis, "role"), name(axis)) {
            (Some(role), _) => role == "rotary",
            (None, name) => name.is_some_and(|name| name.starts_with(['A', 'B', 'C'])),
        };
        let axes = tables.iter().find_map(|table| table.get("axes")?.as_array());
        let axes: Vec<&toml::Value> = axes.into_iter().flatten().collect();
        let unit = tables.iter().find_map(|table| table.get("ce")?.get("units")?.as_str());
        let tool = |key: &str| tables.iter().find_map(|table| table.get("tool")?.get(key));
        let edges = tool("edges").and_then(toml::Value::as_integer).and_then(|edges| u32::try_from(edges).ok());
        Self {
            rotary: axes.iter().copied().filter(turns).filter_map(name).collect(),
            axes: axes.into_iter().filter_map(name).collect(),
            edges: edges.unwrap_or(0),
            by_name: tool("named_from").is_some(),
            unit: unit.and_then(LengthUnit::of).unwrap_or_default(),
        }
    }

    /// Whether programs call an axis by a name.
    fn has_axis(&self, name: &str) -> bool {
        !self.axes(name).is_empty()
    }

    /// Whether the axes of a name turn.
    fn turns(&self, name: &str) -> bool {
        self.axes(name).into_iter().any(|axis| self.rotary.iter().any(|rotary| rotary == axis))
    }

    /// The axes that programs call by a name: the axis of that name, or those that have a digit after it (X1, X2).
    fn axes(&self, name: &str) -> Vec<&str> {
        let exact = self.axes.iter().find(|axis| axis.eq_ignore_ascii_case(name));
        let is_numbered = |axis: &&String| {
            let (letters, digits) = axis.split_at(axis.trim_end_matches(|c: char| c.is_ascii_digit()).len());
            !digits.is_empty() && letters.eq_ignore_ascii_case(name)
        };
        match exact {
            Some(axis) => vec![axis],
            None => self.axes.iter().filter(is_numbered).map(String::as_str).collect(),
        }
    }
}

/// Rows for a machine definition.
#[derive(Debug)]
pub(crate) struct ToolDefinitions {
    file: String,
    /// Rows as inline arrays, which come before the sections of the definition; of a CSV file.
    arrays: String,
    /// Sections, which come after; of a TOML file.
    sections: String,
    /// Line of the file for each line of the definition.
    lines: Vec<usize>,
    /// The unit that was assumed.
    pub(crate) note: Option<String>,
}

impl ToolDefinitions {
    /// Reads a file of tools for a machine.
    pub(crate) fn read(path: &Path, machine: &ToolImportContext) -> Result<Self, Error> {
        standard_input::refuse("--tools", path)?;
        let file = path.display().to_string();
        let text =
            fs::read(path).map_err(|error| Error::File { path: file.clone(), error }).map(String::from_utf8)?.map_err(
                |_| Error::Usage(format!("{file}: a table of tools is text in UTF-8; save it again in that form")),
            )?;
        match path
            .extension()
            .and_then(|extension| extension.to_str())
            .unwrap_or_default()
            .to_ascii_lowercase()
            .as_str()
        {
            "toml" => of_toml(file, text),
            "csv" | "tsv" | "txt" => csv_file::read(file, &text, machine),
            _ => Err(Error::Usage(format!("{file}: a table of tools is a file .toml or .csv"))),
        }
    }

    /// The definition of a machine that extends another one by the rows.
    pub(crate) fn definition(&mut self, machine: &str, base: &str) -> String {
        let head = format!("extends = \"{base}\"\n");
        let name = format!("[ce]\nname = \"{machine}\"\n");
        if self.arrays.is_empty() {
            self.lines.splice(0..0, [0; 3]);
        } else {
            self.lines.insert(0, 0);
        }
        [head.as_str(), &self.arrays, &name, &self.sections].concat()
    }

    /// The place in the user's file of a line of the definition.
    pub(crate) fn place(&self, line: u32) -> Option<(&str, u32)> {
        let line = *self.lines.get((line as usize).checked_sub(1)?)?;
        (line > 0).then_some((self.file.as_str(), line as u32))
    }
}

fn of_toml(file: String, text: String) -> Result<ToolDefinitions, Error> {
    let text = text.replace("\r\n", "\n");
    let table: toml::Table = toml::from_str(&text).map_err(|error| Error::Usage(format!("{file}: {error}")))?;
    let has = |key: &str, value: &toml::Value| match (key, value) {
        ("work_offsets", _) => true,
        ("tool", toml::Value::Table(tool)) => tool.keys().all(|key| KEYS.contains(&key.as_str())),
        _ => false,
    };
    if let Some((key, _)) = table.iter().find(|(key, value)| !has(key, value)) {
        return Err(Error::Usage(format!("{file}: `{key}` is not for a table of tools, which has only {TABLES}")));
    }
    let lines = (1..=text.lines().count()).collect();
    Ok(ToolDefinitions { file, arrays: String::new(), sections: text, lines, note: None })
}

#[cfg(test)]
mod tests;
