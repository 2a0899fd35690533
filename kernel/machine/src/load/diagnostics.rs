//! `[[diagnostics]]`, `diagnostics_file`, `min_severity`: changes of diagnostics by the machine.
//!
//! Invariant: sorted by number, one rule per number. A diagnostic that stops a channel cannot be silenced, because the
//! channel would stop without a message. Facts: reference control-emulator.md 7.5.

use crate::model::{DiagnosticRule, Diagnostics};
use crate::toml::node::DefinitionPlace;
use crate::toml::section::TableReader;
use counterpoint_fault as diag;
use counterpoint_ports::files::JobFiles;

/// Most rules.
const MOST: usize = 2000;

/// Largest number.
const LARGEST: i64 = 99_999_999;

/// Reads the rules; rows go over the file.
pub(super) fn read(top: &mut TableReader<'_>, files: &dyn JobFiles) -> Diagnostics {
    let mut rules = Vec::new();
    read_file(top, files, &mut rules);
    let from_file = rules.len();
    for mut row in top.rows("diagnostics", "[[diagnostics]]", MOST) {
        row.require("number", "the number of a diagnostic");
        let number = row.integer("number", 1..=LARGEST).map(|number| number as u32);
        let severity = row.integer("severity", 0..=99).map(|severity| severity as u8);
        let text = row.text("text").map(str::to_owned);
        let enable = row.flag("enable").unwrap_or(true);
        let repeat = row.integer("repeat", 0..=i64::from(u32::MAX)).map(|repeat| repeat as u32);
        let stops = row.flag("stops");
        let alarm = row.flag("alarm").unwrap_or(false);
        if let Some(number) = number {
            let rule = DiagnosticRule { number, severity, text, enable, repeat, stops, alarm };
            if rules.iter().skip(from_file).any(|other: &DiagnosticRule| other.number == number) {
                row.error("number", format!("number {number} already has a row"));
            }
            rules.iter().take(from_file).position(|other| other.number == number).map(|index| rules.remove(index));
            if let Some(text) = wrong(&rule) {
                row.error("number", text);
            }
            rules.push(rule);
        }
        row.finish();
    }
    rules.sort_by_key(|rule| rule.number);
    let min_severity = top.integer("min_severity", 0..=99).map_or(0, |severity| severity as u8);
    Diagnostics { rules, min_severity, refusals: Vec::new() }
}

/// Why a rule cannot be.
fn wrong(rule: &DiagnosticRule) -> Option<String> {
    let known = diag::ALL.iter().find(|facts| facts.number == rule.number);
    let silenced = !rule.enable || rule.repeat == Some(0);
    if silenced && rule.stops.unwrap_or(rule.alarm || known.is_some_and(|facts| facts.alarm)) {
        return Some(format!("{:08} is an alarm that stops the channel, it cannot be switched off", rule.number));
    }
    if known.is_none() && rule.enable && (rule.text.is_none() || rule.severity.is_none()) {
        return Some(format!("{:08} is a number of your own, it needs `severity` and `text`", rule.number));
    }
    None
}

/// The error file: `\ number severity text`. A minus before the number switches it off, `!` starts a comment line. A
/// definition continues in the next lines; a backslash at the end of a line joins them without a blank.
fn read_file(top: &mut TableReader<'_>, files: &dyn JobFiles, rules: &mut Vec<DiagnosticRule>) {
    let Some(name) = top.name("diagnostics_file", 64) else { return };
    let owner = top.place_of("diagnostics_file").file.clone();
    let folder = owner.rsplit_once('/').map_or("", |(folder, _)| folder);
    let path = format!("{folder}/{name}");
    let content = match files.read(&path) {
        Ok(content) if !name.contains("..") => content,
        Ok(_) => return top.error("diagnostics_file", "`diagnostics_file` must be a file beside the machine file"),
        Err(error) => return top.error("diagnostics_file", error.to_string()),
    };
    let text = String::from_utf8_lossy(&content).into_owned();
    for (line, definition) in definitions(&text) {
        let place = DefinitionPlace { file: path.as_str().into(), line, column: 1 };
        match parse(&definition) {
            Some(rule) => {
                if let Some(text) = wrong(&rule) {
                    top.error_at(&place, text);
                }
                rules.retain(|other: &DiagnosticRule| other.number != rule.number);
                rules.push(rule);
            }
            None => top.error_at(&place, "expected `\\ number severity text`"),
        }
    }
}

/// Definitions with the lines where they begin, put together from their lines.
fn definitions(text: &str) -> Vec<(u32, String)> {
    let mut out: Vec<(u32, String)> = Vec::new();
    let mut joins = false;
    for (number, line) in (1u32..).zip(text.lines()) {
        let line = line.trim();
        let comment = line.starts_with('!') && !line.starts_with("!(");
        if comment || line.is_empty() {
            continue;
        }
        let (line, next_joins) = match line.strip_suffix('\\') {
            Some(line) if line.len() > 1 => (line, true),
            _ => (line, false),
        };
        match (line.strip_prefix('\\'), out.last_mut()) {
            (None, Some((_, definition))) => {
                if !joins {
                    definition.push(' ');
                }
                definition.push_str(line);
            }
            (start, _) => out.push((number, start.unwrap_or(line).to_owned())),
        }
        joins = next_joins;
    }
    out
}

fn parse(definition: &str) -> Option<DiagnosticRule> {
    let mut words = definition.split_whitespace();
    let number = words.next()?;
    let (number, enable) = number.strip_prefix('-').map_or((number, true), |number| (number, false));
    let number = number.parse().ok().filter(|number| (1..=LARGEST as u32).contains(number))?;
    let severity = words.next()?.parse().ok().filter(|severity| *severity <= 99)?;
    let text = words.collect::<Vec<_>>().join(" ");
    let text = (!text.is_empty()).then_some(text);
    Some(DiagnosticRule { number, severity: Some(severity), text, enable, repeat: None, stops: None, alarm: false })
}
