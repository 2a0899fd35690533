//! The report of `calibrate`: for people, as JSON, and as a machine definition.

use std::fmt::Write as _;

use counterpoint_kernel::machine::Machine;
use serde_json::json;
use toml_edit::{DocumentMut, Item, Table, value};

use super::data::FitParameter;
use super::{Calibration, Fitted};
use crate::error::Error;
use crate::text::{more, table};

/// Lines shown at most.
const ROWS: usize = 10;

/// Quality of the times: root of the mean square of the differences, seconds; and the sum, as a part of the measured
/// time.
struct Quality {
    rms: f64,
    whole: f64,
}

impl Quality {
    fn of(calibration: &Calibration, which: usize) -> Self {
        let lines = calibration.lines.iter().map(|(_, times)| (times[0], times.get(which).copied().unwrap_or(0.0)));
        let count = calibration.lines.len().max(1) as f64;
        let (mut squares, mut measured, mut computed) = (0.0, 0.0, 0.0);
        for (own, other) in lines {
            squares += (other - own) * (other - own);
            measured += own;
            computed += other;
        }
        Self { rms: (squares / count).sqrt(), whole: if measured > 0.0 { computed / measured - 1.0 } else { 0.0 } }
    }
}

/// A number with four digits that count.
fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Factor between two values from which the measured times are doubtful.
const DOUBTFUL: f64 = 10.0;

/// Values and lines that no machine explains: data that would change by a factor of ten, and lines whose times still
/// differ by that factor and by more than a second.
pub(super) fn doubts(machine: &Machine, calibration: &Calibration) -> Vec<String> {
    let far = |a: f64, b: f64| a > 0.0 && b > 0.0 && (a / b).max(b / a) >= DOUBTFUL;
    let mut all = Vec::new();
    for Fitted { datum, before, fitted } in &calibration.data {
        if let Some((before, (after, _))) = before.zip(*fitted).filter(|(before, (after, _))| far(*before, *after)) {
            let (before, after) = (number(before), number(after));
            all.push(format!("{} would be {after} instead of {before}: check the measured times", datum.name(machine)));
        }
    }
    for (line, [measured, _, after]) in &calibration.lines {
        if far(*measured, *after) && (measured - after).abs() > 1.0 {
            all.push(format!(
                "line {line}: {measured:.3} s were measured, but the machine takes {after:.3} s: no datum explains the difference"
            ));
        }
    }
    all
}

/// The report for people.
pub(super) fn text(machine: &Machine, calibration: &Calibration, all: bool) -> String {
    let [before, after] = [1, 2].map(|which| Quality::of(calibration, which));
    let mut out = format!(
        "{} lines: the times differ by {:.3} s a line (root mean square) and {:+.1} % in all; before by {:.3} s and {:+.1} %\n\n",
        calibration.lines.len(),
        after.rms,
        after.whole * 100.0,
        before.rms,
        before.whole * 100.0,
    );
    if calibration.data.is_empty() {
        out.push_str("nothing was fitted: no datum of the machine changes a measured line\n");
    } else {
        let mut rows = vec![["datum", "before", "after", "error", "unit"].map(str::to_owned).to_vec()];
        for one in &calibration.data {
            let known = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), number);
            rows.push(vec![
                one.datum.name(machine),
                known(one.before),
                known(one.after()),
                one.fitted
                    .map_or_else(|| "not determined, unchanged".to_owned(), |(_, error)| format!("±{}", number(error))),
                one.datum.unit().to_owned(),
            ]);
        }
        out.push_str(&table(&rows, 1));
    }
    let mut worst: Vec<_> = calibration.lines.iter().collect();
    worst.sort_by(|(_, a), (_, b)| (b[2] - b[0]).abs().total_cmp(&(a[2] - a[0]).abs()));
    let most = if all { usize::MAX } else { ROWS };
    let mut rows = vec![["line", "measured", "before", "after", "difference"].map(str::to_owned).to_vec()];
    for (line, [measured, before, after]) in worst.iter().take(most) {
        let seconds = |value: &f64| format!("{value:.3} s");
        rows.push(vec![
            line.to_string(),
            seconds(measured),
            seconds(before),
            seconds(after),
            format!("{:+.3} s", after - measured),
        ]);
    }
    let _ = write!(out, "\nlargest differences\n{}", table(&rows, 0));
    more(&mut out, worst.len(), most, "lines (--verbose shows all)");
    out
}

/// The same as JSON.
pub(super) fn json(machine: &Machine, calibration: &Calibration) -> Result<String, Error> {
    let quality = |which| {
        let Quality { rms, whole } = Quality::of(calibration, which);
        json!({ "rms_s": rms, "whole": whole })
    };
    let data = calibration.data.iter().map(|one| {
        let error = one.fitted.map(|(_, error)| error);
        json!({ "datum": one.datum.name(machine), "before": one.before, "after": one.after(), "error": error })
    });
    let lines = calibration.lines.iter().map(|(line, [measured, before, after])| {
        json!({ "line": line, "measured_s": measured, "before_s": before, "after_s": after })
    });
    let all = json!({
        "before": quality(1),
        "after": quality(2),
        "data": data.collect::<Vec<_>>(),
        "lines": lines.collect::<Vec<_>>(),
        "warnings": doubts(machine, calibration),
    });
    let text = serde_json::to_string_pretty(&all).map_err(|error| Error::Usage(error.to_string()))?;
    Ok(text + "\n")
}

/// A definition with the fitted data in it.
pub(super) fn definition(text: &str, machine: &Machine, calibration: &Calibration) -> Result<String, Error> {
    let parsed: Result<DocumentMut, _> = text.parse();
    let mut document = parsed.map_err(|error| Error::Usage(error.to_string()))?;
    for Fitted { datum, fitted, .. } in &calibration.data {
        let Some((after, _)) = *fitted else { continue };
        let fitted = value(number(after).parse::<f64>().unwrap_or(after));
        match datum {
            FitParameter::Acceleration(axis) => {
                on_axis(&mut document, &machine.axes[*axis].name, "acceleration", fitted)
            }
            FitParameter::Rapid(axis) => on_axis(&mut document, &machine.axes[*axis].name, "rapid", fitted),
            FitParameter::CornerDeviation
            | FitParameter::BlockTime
            | FitParameter::ToolChange
            | FitParameter::ToolStep => {
                if let Some(time) = time(&mut document) {
                    time.insert(&datum.name(machine), fitted);
                }
            }
            FitParameter::M(m, _) => {
                let codes =
                    time(&mut document).map(|time| time.entry("m_codes").or_insert_with(|| Item::Table(Table::new())));
                if let Some(codes) = codes.and_then(Item::as_table_like_mut) {
                    codes.insert(&m.to_string(), fitted);
                }
            }
        }
    }
    Ok(document.to_string())
}

fn time(document: &mut DocumentMut) -> Option<&mut Table> {
    document.entry("time").or_insert_with(|| Item::Table(Table::new())).as_table_mut()
}

fn on_axis(document: &mut DocumentMut, name: &str, key: &str, fitted: Item) {
    let rows = document.get_mut("axes").and_then(Item::as_array_of_tables_mut);
    let named = |row: &&mut Table| row.get("name").and_then(Item::as_str) == Some(name);
    if let Some(row) = rows.and_then(|rows| rows.iter_mut().find(named)) {
        row.insert(key, fitted);
    }
}
