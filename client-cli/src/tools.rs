//! `--tools FILE`: tools, tool offsets and work offsets of one run.
//!
//! The rows become a machine that extends the one of the run. A TOML file has them as a machine definition has; a CSV
//! file, as tool lists of CAM systems and spreadsheets are, has a line for each tool. Invariant: every error in a row
//! is reported with the line of the user's file.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::standard_input;

/// Tables of a TOML file.
const TABLES: &str = "[[tool.offsets]], [[tool.data]], [[tool.names]] and [[work_offsets]]";
const KEYS: [&str; 3] = ["offsets", "data", "names"];

/// Rows for a machine definition.
#[derive(Debug)]
pub(crate) struct Tools {
    file: String,
    /// Rows as inline arrays, which stand before the sections of the definition; of a CSV file.
    arrays: String,
    /// Sections, which stand behind; of a TOML file.
    sections: String,
    /// By line of the definition: the line of the file.
    lines: Vec<usize>,
}

impl Tools {
    /// Reads a file. `tool_axis` is the name of the axis that the length of a tool of a CSV file counts along.
    pub(crate) fn read(path: &Path, tool_axis: Option<&str>) -> Result<Self, Error> {
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
            "csv" | "tsv" | "txt" => of_csv(file, &text, tool_axis),
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

fn of_toml(file: String, text: String) -> Result<Tools, Error> {
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
    Ok(Tools { file, arrays: String::new(), sections: text, lines })
}

/// Columns of a CSV file.
const COLUMNS: &str = "number, name, diameter, radius, tip, length";

/// What a column of a CSV file is.
#[derive(Debug, Clone, PartialEq)]
enum Column {
    Number,
    Name,
    Diameter,
    Radius,
    Tip,
    Length,
    RadiusWear,
    LengthWear,
    Axis(String),
    Wear(String),
}

impl Column {
    fn of(title: &str) -> Self {
        let title = title.trim();
        let worn = title.split_once([' ', '_', '-']).and_then(|(one, other)| {
            let is_wear = |word: &str| word.eq_ignore_ascii_case("wear");
            if is_wear(one) { Some(other) } else { Some(one).filter(|_| is_wear(other)) }
        });
        if let Some(of) = worn {
            return match of.to_ascii_lowercase().as_str() {
                "radius" => Self::RadiusWear,
                "length" => Self::LengthWear,
                _ => Self::Wear(of.to_owned()),
            };
        }
        match title.to_ascii_lowercase().as_str() {
            "number" | "no" | "nr" | "tool" | "t" | "offset" => Self::Number,
            "name" | "comment" | "description" => Self::Name,
            "diameter" | "dia" => Self::Diameter,
            "radius" => Self::Radius,
            "tip" => Self::Tip,
            "length" => Self::Length,
            _ => Self::Axis(title.to_owned()),
        }
    }
}

fn of_csv(file: String, text: &str, tool_axis: Option<&str>) -> Result<Tools, Error> {
    let wrong = |line: u64, text: String| Error::Usage(format!("{file}:{line}: {text}"));
    let text = format!("{}\n", text.trim_start_matches('\u{feff}').trim_end());
    let head = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let delimiter = [';', '\t', ','].into_iter().max_by_key(|one| head.matches(*one).count()).unwrap_or(',');
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter as u8)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let titles = reader.headers().map_err(|error| wrong(1, error.to_string()))?.clone();
    let columns: Vec<Column> = titles.iter().map(Column::of).collect();
    if !columns.contains(&Column::Number) {
        let text =
            "the first line names the columns: number, and name, diameter, radius, tip, length or the names of axes";
        return Err(wrong(1, text.to_owned()));
    }
    let along = tool_axis.filter(|axis| !columns.contains(&Column::Axis((*axis).to_owned())));
    let (mut offsets, mut data) = (String::from("tool.offsets = [\n"), String::from("tool.data = [\n"));
    let (mut of_offsets, mut of_data) = (vec![0], vec![0]);
    let mut record = csv::StringRecord::new();
    while reader
        .read_record(&mut record)
        .map_err(|error| wrong(error.position().map_or(0, csv::Position::line), error.to_string()))?
    {
        // The position of a record is that of the comments before it.
        let line = reader.position().line().saturating_sub(1);
        let cells = columns.iter().zip(&record).filter(|(_, cell)| !cell.is_empty());
        if cells.clone().next().is_none() {
            continue;
        }
        if record.len() > columns.len() {
            return Err(wrong(line, format!("{} columns, where the first line names {}", record.len(), columns.len())));
        }
        let (mut offset, mut facts, mut values, mut wear) = (String::new(), String::new(), Vec::new(), Vec::new());
        let (mut radius, mut number) = (None, None);
        for (column, cell) in cells {
            let read = || {
                let cell = if delimiter == ';' { cell.replace(',', ".") } else { cell.to_owned() };
                cell.parse::<f64>().ok().filter(|value| value.is_finite())
            };
            let value = || {
                read().ok_or_else(|| match column {
                    // An unknown column is read as an axis; a text in it shows that it is something else.
                    Column::Axis(title) | Column::Wear(title) => wrong(
                        line,
                        format!("unknown column '{title}': columns are {COLUMNS}, and the names of axes; an axis would need a number, not '{cell}'"),
                    ),
                    _ => wrong(line, format!("'{cell}' is not a number")),
                })
            };
            match column {
                Column::Number => {
                    let digits = cell.trim_start_matches(['T', 't', 'D', 'H']);
                    let whole =
                        digits.parse::<u32>().map_err(|_| wrong(line, format!("'{cell}' is not a tool number")))?;
                    number = Some(whole);
                }
                Column::Name => drop(write!(facts, ", name = {}", toml::Value::String(cell.to_owned()))),
                Column::Diameter => {
                    let value = value()?;
                    radius = radius.or(Some(value / 2.0));
                    let _ = write!(facts, ", diameter = {value:?}");
                }
                Column::Radius => radius = Some(value()?),
                Column::Tip => drop(write!(offset, ", tip = {}", value()?)),
                Column::Length => {
                    let value = value()?;
                    let _ = write!(facts, ", length = {value:?}");
                    values.extend(along.map(|axis| format!("{axis} = {value:?}")));
                }
                Column::RadiusWear => drop(write!(offset, ", radius_wear = {:?}", value()?)),
                Column::LengthWear => {
                    let value = value()?;
                    wear.extend(along.map(|axis| format!("{axis} = {value:?}")));
                }
                Column::Axis(axis) => {
                    values.push(format!("{} = {:?}", toml::Value::String(axis.clone()), value()?));
                }
                Column::Wear(axis) => {
                    wear.push(format!("{} = {:?}", toml::Value::String(axis.clone()), value()?));
                }
            }
        }
        let Some(number) = number else { return Err(wrong(line, "the tool has no number".to_owned())) };
        if let Some(radius) = radius {
            let _ = write!(offset, ", radius = {radius:?}");
        }
        if !wear.is_empty() {
            let _ = write!(offset, ", wear = {{ {} }}", wear.join(", "));
        }
        let _ = writeln!(offsets, "{{ number = {number}{offset}, values = {{ {} }} }},", values.join(", "));
        of_offsets.push(line as usize);
        if !facts.is_empty() {
            let _ = writeln!(data, "{{ number = {number}{facts} }},");
            of_data.push(line as usize);
        }
    }
    let lines = [of_offsets, vec![0], of_data, vec![0]].concat();
    Ok(Tools { file, arrays: format!("{offsets}]\n{data}]\n"), sections: String::new(), lines })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str) -> Result<Tools, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let file = path.display().to_string();
        Tools::read(&path, Some("Z")).map_err(|error| error.to_string().replace(&file, name))
    }

    #[test]
    fn a_spreadsheet_becomes_rows_that_know_their_lines() {
        let text = "number;name;diameter;length;X\n# drills\nT1;DRILL 6,8;6,8;120,5;\n2;FACE;63;80;1\n";
        let mut tools = read("tools.csv", text).unwrap();
        let definition = tools.definition("m-tools", "m");
        let table: toml::Table = toml::from_str(&definition).unwrap();
        let offsets = table["tool"]["offsets"].as_array().unwrap();
        assert_eq!(offsets[0]["radius"].as_float(), Some(3.4));
        assert_eq!(offsets[0]["values"]["Z"].as_float(), Some(120.5));
        assert_eq!((offsets[1]["number"].as_integer(), offsets[1]["values"]["X"].as_float()), (Some(2), Some(1.0)));
        assert_eq!(table["tool"]["data"][0]["name"].as_str(), Some("DRILL 6,8"));
        let line = |text: &str| definition.lines().position(|line| line.contains(text)).unwrap() as u32 + 1;
        assert_eq!(tools.place(line("radius = 3.4")).map(|place| place.1), Some(3));
        assert_eq!(tools.place(line("name = \"FACE\"")).map(|place| place.1), Some(4));
        assert_eq!(tools.place(line("[ce]")), None);
    }

    #[test]
    fn columns_of_wear_are_beside_those_of_geometry() {
        let mut tools =
            read("tools.csv", "no,radius,radius wear,X,wear X,wear_length\n3,0.8,-0.02,10,0.1,-0.05\n4,,,,,\n")
                .unwrap();
        let table: toml::Table = toml::from_str(&tools.definition("m-tools", "m")).unwrap();
        let offset = &table["tool"]["offsets"][0];
        assert_eq!((offset["radius"].as_float(), offset["radius_wear"].as_float()), (Some(0.8), Some(-0.02)));
        assert_eq!((offset["values"]["X"].as_float(), offset["wear"]["X"].as_float()), (Some(10.0), Some(0.1)));
        assert_eq!(offset["wear"]["Z"].as_float(), Some(-0.05));
        assert!(table["tool"]["offsets"][1].get("wear").is_none());
    }

    #[test]
    fn a_toml_file_keeps_its_lines() {
        let mut tools = read("tools.toml", "# mine\n[[tool.offsets]]\nnumber = 1\nradius = 5\n").unwrap();
        let definition = tools.definition("m-tools", "m");
        assert!(toml::from_str::<toml::Table>(&definition).is_ok(), "{definition}");
        let line = definition.lines().position(|line| line == "number = 1").unwrap() as u32 + 1;
        assert_eq!(tools.place(line).map(|place| place.1), Some(3));
    }

    #[test]
    fn what_is_no_table_of_tools_is_refused_with_its_line() {
        for (name, text, with) in [
            ("tools.csv", "name,radius\nA,1\n", "tools.csv:1: the first line names the columns"),
            ("tools.csv", "number,radius\n1,round\n", "tools.csv:2: 'round' is not a number"),
            ("tools.csv", "number,radius\nA1,2\n", "tools.csv:2: 'A1' is not a tool number"),
            ("tools.csv", "number,radius\n1,2,3\n", "tools.csv:2: 3 columns"),
            ("tools.csv", "number,radius\n,2\n", "tools.csv:2: the tool has no number"),
            ("tools.toml", "[[codes]]\nid = 1\n", "`codes` is not for a table of tools"),
            ("tools.toml", "[tool]\noffset_digits = 2\n", "`tool` is not for a table of tools"),
            ("tools.toml", "[[tool.offsets]\n", "tools.toml: TOML parse error at line 1"),
            ("tools.xls", "", "a file .toml or .csv"),
        ] {
            let error = read(name, text).unwrap_err();
            assert!(error.contains(with), "{error}");
        }
    }
}
