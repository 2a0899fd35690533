//! FN 18: SYSREAD and FN 17: SYSWRITE.
//!
//! Facts: programming manuals of the control (system data by ID, NR and IDX), reference control-emulator.md 4.3. The
//! machine is asked first. Invariant: unknown system data are reported; a parameter becomes 0, nothing is written.

use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::eval::{Evaluator, IdentificationResult};
use super::formula::Formula;
use super::path_state::AXES;
use super::q_parameter::{ParameterValue, QParameter};
use super::tools::row;
use super::words::shown;

impl Heidenhain {
    pub(super) fn system_read(
        &mut self,
        host: &mut dyn InterpreterHost,
        to: QParameter,
        (id, number, index): (&Formula, &Formula, Option<&Formula>),
    ) -> Result<(), Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let (id, number) = (evaluator.number(id)?, evaluator.number(number)?);
        let index = match index {
            Some(index) => Some(evaluator.number(index)?),
            None => None,
        };
        let value = self.system_data(host, id, number, index)?;
        Evaluator::new(&mut self.variables, host).assign(to, value)
    }

    /// System data that are a number, 0 if they are a text.
    pub(super) fn system_number(
        &mut self,
        host: &mut dyn InterpreterHost,
        id: f64,
        number: f64,
        index: Option<f64>,
    ) -> Result<f64, Halt> {
        Ok(match self.system_data(host, id, number, index)? {
            ParameterValue::Number(value) => value,
            ParameterValue::Text(_) => 0.0,
        })
    }

    /// Value of system data: that of the machine, or one that is known here.
    fn system_data(
        &mut self,
        host: &mut dyn InterpreterHost,
        id: f64,
        number: f64,
        index: Option<f64>,
    ) -> Result<ParameterValue, Halt> {
        let asked = name_of(id, number, index);
        let value = match Evaluator::new(&mut self.variables, host).ask(&asked)? {
            // The machine gives a feed in its own unit.
            IdentificationResult::Value(ParameterValue::Number(feed))
                if self.units.inches && (id, number) == (20.0, 9.0) =>
            {
                ParameterValue::Number(self.units.of_program(feed, host))
            }
            IdentificationResult::Value(value) => value,
            IdentificationResult::Nothing | IdentificationResult::Kept => ParameterValue::Number(0.0),
            IdentificationResult::Unknown => {
                let known = self.system_value(host, id, number, index);
                if known.is_none() {
                    let text = format!("no value is known for {asked} in '{}'; 0 is used", host.block_text());
                    host.diagnose(&diag::SYSTEM_DATA_UNKNOWN, text);
                }
                ParameterValue::Number(known.unwrap_or(0.0))
            }
        };
        Ok(value)
    }

    /// System data that the kernel and this program know.
    fn system_value(&self, host: &dyn InterpreterHost, id: f64, number: f64, index: Option<f64>) -> Option<f64> {
        let control = &self.variables.control;
        let (id, number) = (whole(id)?, whole(number)?);
        let tool = || control.tool.unwrap_or_else(|| f64::from(host.tool()));
        let of_tool = || index.map_or_else(|| Some(tool() as u32), whole);
        let of_row = || index.map_or_else(|| Some(row(tool())), row_of);
        match (id, number) {
            (20 | 60, 1) => Some(tool().trunc()),
            (20, 3) | (60, 2) => Some(control.tool_axis.map_or(-1.0, |axis| axis as f64)),
            (20, 5) => Some(control.spindle.map_or(-1.0, f64::from)),
            (20, 8) => Some(f64::from(u8::from(control.coolant))),
            (30, number) => self.cycles.old.get(number.checked_sub(1)? as usize).copied(),
            (50, column) => self.tools.column(host, of_row()?, column),
            (51, column) => self.tools.pocket(whole(index?)?, column),
            (52, 1) => Some(self.tools.pocket_of(of_tool()?)),
            (60, 4) => Some(control.allowances[0]),
            (60, 5) => Some(control.allowances[1]),
            // The radius, the length: without an allowance, with that of the table, with that of TOOL CALL as well.
            (200, 1 | 2) => {
                let [length, radius] = control.allowances;
                let (size, more, called) = if number == 1 { (2, 5, radius) } else { (1, 4, length) };
                let column = |column: u32| self.tools.column(host, row(tool()), column);
                match index.map_or(Some(3), whole)? {
                    1 => column(size),
                    2 => Some(column(size)? + column(more)?),
                    3 => Some(column(size)? + column(more)? + called),
                    _ => None,
                }
            }
            (210, 2) => Some(self.shifts.angle()),
            (210, 3) => Some(f64::from(self.shifts.mirror_bits())),
            (210, 4) => self.shifts.factor(whole(index?)?.checked_sub(1)? as usize),
            (210, 6) => Some(if host.plane_angles().is_some() { -1.0 } else { 0.0 }),
            (220, 2) => self.shifts.datum((whole(index?)?).checked_sub(1)? as usize),
            (230, 2 | 3) => {
                let letter = AXES.get((whole(index?)?).checked_sub(1)? as usize)?;
                let (low, high) = host.travel(letter)?;
                let turns = matches!(*letter, "A" | "B" | "C");
                let value = if number == 2 { low } else { high };
                Some(if turns { value } else { value / host.length_factor() })
            }
            (530, 1) => Some(f64::from(host.work_offset())),
            (240 | 270, 1) => {
                let index = index.filter(|index| (1.0..=9.0).contains(index))? as usize;
                let letter = AXES.get(index - 1)?;
                let positions = host.positions();
                let is = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()) == *letter;
                let (_, work, machine) = positions.iter().find(|(name, ..)| is(name))?;
                let value = if id == 240 { *machine } else { *work };
                let turns = (4..=6).contains(&index);
                Some(if turns { value } else { value / host.length_factor() })
            }
            _ => None,
        }
    }

    /// FN 17: SYSWRITE.
    pub(super) fn system_write(
        &mut self,
        host: &mut dyn InterpreterHost,
        (id, number, index): (&Formula, &Formula, Option<&Formula>),
        value: &Formula,
    ) -> Result<(), Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let (id, number, value) = (evaluator.number(id)?, evaluator.number(number)?, evaluator.number(value)?);
        let index = match index {
            Some(index) => Some(evaluator.number(index)?),
            None => None,
        };
        let asked = name_of(id, number, index);
        if host.identify(&asked, Some(&counterpoint_lang::value::MacroValue::Real(value)))?
            != IdentificationAnswer::Unknown
        {
            return Ok(());
        }
        host.effect();
        let tool = self.variables.control.tool.unwrap_or_else(|| f64::from(host.tool()));
        let at = index.map_or_else(|| Some(tool as u32), whole);
        let tool = index.map_or_else(|| Some(row(tool)), row_of);
        let written = match (whole(id), whole(number), at) {
            (Some(50), Some(column), _) => tool.is_some_and(|tool| self.tools.write_column(host, tool, column, value)),
            (Some(51), Some(column), Some(pocket)) => self.tools.write_pocket(pocket, column, value),
            _ => false,
        };
        if !written {
            let text = format!("{asked} cannot be written in '{}'", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        Ok(())
    }
}

/// System, number and index as programs write them.
fn name_of(id: f64, number: f64, index: Option<f64>) -> String {
    let index = index.map_or_else(String::new, |index| format!(" IDX{}", shown(index)));
    format!("ID{} NR{}{index}", shown(id), shown(number))
}

/// The row of a tool in the tool table.
fn row_of(tool: f64) -> Option<u32> {
    (0.0..32_768.0).contains(&tool).then(|| row(tool))
}

/// A whole number that may be a system, a number of it or an index.
fn whole(value: f64) -> Option<u32> {
    (0.0..100_000.0).contains(&value).then_some(value as u32)
}
