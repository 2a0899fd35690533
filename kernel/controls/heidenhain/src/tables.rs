//! Tables of points (.PNT) and of datums (.D) among the files of the job.
//!
//! Facts: programming manuals of the control (SEL PATTERN, SEL TABLE, cycle 7 with `#`; the first line says the unit,
//! the second names the columns, `[END]` closes). Decisions: a row with a value in every column is read by order, any
//! other by the places of the names; FADE with Y hides a point. Invariant: lengths are in the unit of the program.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::formula::Formula;
use super::lex::capitals;
use super::path_state::AXES;
use super::patterns::PatternPoint;
use super::words::EvaluatedWord;

/// Most rows of a table.
const MOST: u32 = 10_000;

/// Millimetres of an inch.
const INCH: f64 = 25.4;

/// Axes that turn: their columns have no unit.
const TURNS: [&str; 3] = ["A", "B", "C"];

/// A row: its cells by the names of their columns.
type Row = Vec<(String, String)>;

/// The rows of a table.
fn rows(host: &dyn InterpreterHost, file: FileId, inch: bool) -> Vec<Row> {
    let Some(source) = host.source(file) else { return Vec::new() };
    let mut names: Vec<(usize, String)> = Vec::new();
    let (mut rows, mut factor) = (Vec::new(), 1.0);
    for line in 1..=source.lines().min(MOST) {
        let text = capitals(&String::from_utf8_lossy(source.line(line)).replace('\t', " ").replace(',', "."));
        let text = text.trim_end();
        if text.starts_with("BEGIN") {
            let own = text.contains(" INCH");
            factor = if own == inch {
                1.0
            } else if own {
                INCH
            } else {
                1.0 / INCH
            };
        } else if text.trim_start().starts_with("[END]") {
            break;
        } else if names.is_empty() {
            names = columns(text).map(|(at, name)| (at, name.to_owned())).collect();
        } else if !text.is_empty() {
            rows.push(cells(text, &names, factor));
        }
    }
    rows
}

/// The words of a line with their places.
fn columns(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split(' ')
        .scan(0, |at, word| {
            let here = *at;
            *at += word.len() + 1;
            Some((here, word))
        })
        .filter(|(_, word)| !word.is_empty())
}

fn cells(text: &str, names: &[(usize, String)], factor: f64) -> Row {
    let words: Vec<(usize, &str)> = columns(text).collect();
    let by_order = words.len() == names.len();
    let cell = |at: usize, place: usize| {
        if by_order {
            return words.get(at).map_or("", |(_, word)| word);
        }
        let end = names.get(at + 1).map_or(text.len(), |(next, _)| (*next).min(text.len()));
        text.get(place.min(end)..end).unwrap_or_default().trim()
    };
    let cells = names.iter().enumerate().map(|(at, (place, name))| {
        let text = cell(at, *place);
        let length = !matches!(name.as_str(), "NR" | "D" | "FADE" | "DOC") && !TURNS.contains(&name.as_str());
        let scaled =
            text.parse::<f64>().ok().filter(|_| length && factor != 1.0).map(|value| (value * factor).to_string());
        (name.clone(), scaled.unwrap_or_else(|| text.to_owned()))
    });
    cells.collect()
}

fn number(row: &Row, name: &str) -> Option<f64> {
    row.iter().find(|(column, _)| column == name)?.1.parse().ok()
}

impl Heidenhain {
    /// A table of the job by its name.
    fn table(&mut self, host: &mut dyn InterpreterHost, name: &str, ending: &str) -> Result<Vec<Row>, Halt> {
        let name = name.trim().trim_matches('"');
        for name in [name.to_owned(), format!("{name}{ending}")] {
            if let Some((file, _)) = self.find_program(host, &name, false)? {
                return Ok(rows(host, file, self.units.inches));
            }
        }
        let text = format!("table {name} not found for '{}'; add it to the files of the job", host.block_text());
        Err(host.alarm(&diag::SUBPROGRAM_MISSING, text))
    }

    /// SEL PATTERN: the points of a table.
    pub(super) fn select_points(&mut self, host: &mut dyn InterpreterHost, name: &Formula) -> Result<(), Halt> {
        let name = self.text(host, name)?;
        let rows = self.table(host, &name, ".PNT")?;
        let shown = rows.iter().filter(|row| !row.iter().any(|(column, cell)| column == "FADE" && cell == "Y"));
        let value = |row: &Row, name: &str| number(row, name).unwrap_or(0.0);
        let spots = shown.map(|row| PatternPoint {
            at: self.plane_letters().map(|letter| value(row, letter)),
            above: value(row, self.tool_letter()),
            clearance: number(row, "CLEARANCE"),
        });
        let spots = spots.collect();
        self.cycles.pattern.define(spots);
        Ok(())
    }

    /// SEL TABLE: the table that rows of cycle 7 are of.
    pub(super) fn select_datums(&mut self, host: &mut dyn InterpreterHost, name: &Formula) -> Result<(), Halt> {
        self.selected.datums = Some(self.text(host, name)?);
        Ok(())
    }

    /// A row of a datum table as words of cycle 7.
    pub(super) fn datum_row(
        &mut self,
        host: &mut dyn InterpreterHost,
        wanted: f64,
        table: Option<&str>,
    ) -> Result<Vec<EvaluatedWord>, Halt> {
        let Some(table) = table.map(str::to_owned).or_else(|| self.selected.datums.as_deref().map(str::to_owned))
        else {
            let text = format!("no datum table is selected for '{}'; program SEL TABLE first", host.block_text());
            return Err(host.alarm(&diag::SUBPROGRAM_MISSING, text));
        };
        let rows = self.table(host, &table, ".D")?;
        let is = |row: &&Row| number(row, "D").or_else(|| number(row, "NR")) == Some(wanted);
        let Some(row) = rows.iter().find(is) else {
            let row = super::words::shown(wanted);
            let text = format!("row {row} of table {table} does not exist for '{}'", host.block_text());
            return Err(host.alarm(&diag::SUBPROGRAM_MISSING, text));
        };
        // Machines without an axis have its column, too.
        let values = AXES.iter().enumerate().filter_map(|(at, letter)| Some((at, letter, number(row, letter)?)));
        let moves = values.filter(|(at, _, value)| *at < 3 || *value != 0.0);
        Ok(moves.map(|(_, letter, value)| EvaluatedWord::made(letter, value)).collect())
    }
}
