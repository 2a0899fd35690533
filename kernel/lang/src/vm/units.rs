//! Text files by unit number, and reading from texts.
//!
//! *Invariant:* failures of files only set `$ERRNO`. Facts: reference macro-language.md 3.4; choices of this project: a
//! missing file is created when it is written, FRONT truncates, lines end with LF.

use super::slots::{get, set};

use crate::bytecode::Slot;
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::format;
use crate::host::MacroHost;
use crate::ident;
use crate::state::{LINE, MacroState, OpenUnit, unit_number};
use crate::value::MacroValue;

const END_OF_FILE: i32 = -1;
const CANNOT_OPEN: i32 = 2;
const NOT_OPEN: i32 = 9;
const BAD_INPUT: i32 = 22;
/// Steps that opening a file costs beside its length.
const FILE_TICKS: usize = 100;
/// Bytes that can be written to a file before it is closed.
const MOST_WRITTEN: usize = 64 << 20;
pub(super) fn open(state: &mut MacroState, host: &mut dyn MacroHost, arguments: &[MacroValue]) -> Outcome<()> {
    let first = arguments.first().unwrap_or(&MacroValue::Unset);
    let number = unit_number(first.as_real().ok_or_else(|| MacroFault::kind("a unit number", first))?)?;
    let (mut rear, mut path) = (false, format!("unit{number}"));
    for value in arguments.iter().skip(1) {
        match value {
            MacroValue::Keyword(code) => rear = ident::minor_name(*code) == Some("REAR"),
            MacroValue::Text(text) => path = text.trim().to_owned(),
            other => return Err(MacroFault::kind("FRONT, REAR or a file name", other)),
        }
    }
    state.spend(size(state, f64::from(number)) / 64)?;
    close(state, host, f64::from(number));
    // A loss of data by the close above stays reported after this file opens.
    let lost = state.status == CANNOT_OPEN;
    if state.units.len() >= state.limits.units {
        return Err(MacroFault::new(
            DiagnosticNumber::UNITS,
            format!("more than {} units are open", state.limits.units),
        ));
    }
    let upper = path.to_ascii_uppercase();
    let console = upper == "STDIN" || upper == "STDOUT";
    state.status = if console { 0 } else { host.may_open(state, &path) };
    if state.status != 0 {
        return Ok(());
    }
    let text = if console { None } else { host.read_file(&path) };
    if text.is_none() && !console {
        // It is made by writing, so there must be nothing, and a place for it.
        state.status = host.may_write(&path);
        if state.status != 0 {
            return Ok(());
        }
    }
    let read = text.as_ref().map_or(0, String::len);
    state.spend(FILE_TICKS + read / 64)?;
    let lines: Vec<String> = text.unwrap_or_default().lines().map(str::to_owned).collect();
    state.spend(lines.len())?;
    let next = if rear { lines.len() } else { 0 };
    if lost {
        state.status = CANNOT_OPEN;
    }
    let unit = OpenUnit { path, lines, next, rear, console, read, ..OpenUnit::default() };
    state.grow(unit.bytes());
    state.units.insert(number, unit);
    Ok(())
}

/// Bytes that closing a unit writes.
pub(super) fn size(state: &MacroState, number: f64) -> usize {
    unit_number(number).ok().and_then(|number| state.units.get(&number)).map_or(0, OpenUnit::bytes)
}

pub(super) fn close(state: &mut MacroState, host: &mut dyn MacroHost, number: f64) {
    let Ok(number) = unit_number(number) else {
        state.status = NOT_OPEN;
        return;
    };
    state.status = match state.units.remove(&number) {
        Some(unit) if unit.changed => {
            let mut text = unit.lines.join("\n");
            text.push('\n');
            if host.write_file(&unit.path, &text) { 0 } else { CANNOT_OPEN }
        }
        Some(_) => 0,
        None => NOT_OPEN,
    };
}

pub(super) fn close_all(state: &mut MacroState, host: &mut dyn MacroHost) {
    let mut open: Vec<u8> = state.units.keys().copied().collect();
    open.sort_unstable();
    for number in open {
        close(state, host, f64::from(number));
    }
}

pub(super) fn write(state: &mut MacroState, host: &mut dyn MacroHost, number: f64, text: &str) -> Outcome<()> {
    let number = unit_number(number)?;
    let most = state.limits.elements;
    let Some(unit) = state.units.get_mut(&number) else {
        state.status = NOT_OPEN;
        return Ok(());
    };
    if unit.console {
        host.write_console(text);
    } else {
        let status = *unit.writable.get_or_insert_with(|| host.may_write(&unit.path));
        if status != 0 {
            state.status = status;
            return Ok(());
        }
        if !unit.changed && !unit.rear {
            unit.lines.truncate(unit.next);
        }
        unit.written += text.len() + 1;
        if unit.lines.len() >= most || unit.written > MOST_WRITTEN {
            let message = format!("a file has more than {most} lines or {MOST_WRITTEN} bytes");
            return Err(MacroFault::new(DiagnosticNumber::SIZE, message));
        }
        unit.lines.push(text.to_owned());
        unit.next = unit.lines.len();
        unit.changed = true;
        state.grow(text.len() + LINE);
    }
    state.status = 0;
    Ok(())
}

fn line(state: &mut MacroState, host: &mut dyn MacroHost, number: f64, again: bool) -> Outcome<Option<String>> {
    let number = unit_number(number)?;
    let Some(unit) = state.units.get_mut(&number) else {
        state.status = NOT_OPEN;
        return Ok(None);
    };
    if unit.console {
        let line = host.read_console();
        state.status = if line.is_some() { 0 } else { END_OF_FILE };
        return Ok(line);
    }
    if again {
        unit.next = unit.next.saturating_sub(1);
    }
    let line = unit.lines.get(unit.next).cloned();
    unit.next += usize::from(line.is_some());
    state.status = if line.is_some() { 0 } else { END_OF_FILE };
    Ok(line)
}

/// READ from a unit or a text into registers.
pub(super) fn read(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    sources: &[Slot],
    targets: &[Slot],
    again: bool,
    frame: &mut [MacroValue],
) -> Outcome<()> {
    let source = sources.first().map_or(MacroValue::Unset, |slot| get(frame, *slot).clone());
    let format = sources.get(1).map_or(MacroValue::Unset, |slot| get(frame, *slot).clone());
    let text = format.as_text().ok_or_else(|| MacroFault::kind("a format", &format))?;
    let format = state.format(text, true)?;
    if format.arguments != targets.len() {
        let message = format!("the format has {} codes for {} variables", format.arguments, targets.len());
        return Err(MacroFault::new(DiagnosticNumber::FORMAT_MISMATCH, message));
    }
    let line = match &source {
        MacroValue::Text(text) => {
            state.status = 0;
            Some(text.as_ref().clone())
        }
        MacroValue::Real(number) => line(state, host, *number, again)?,
        other => return Err(MacroFault::kind("a unit number or a text", other)),
    };
    let values = match line {
        Some(line) => {
            state.spend(line.len() / 16)?;
            let (values, good) = format::read(&format, &line);
            if !good {
                state.status = BAD_INPUT;
            }
            values
        }
        None => vec![MacroValue::Null; targets.len()],
    };
    for (slot, value) in targets.iter().zip(values) {
        state.made(&value)?;
        set(frame, *slot, value);
    }
    Ok(())
}
