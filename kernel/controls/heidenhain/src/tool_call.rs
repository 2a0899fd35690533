//! TOOL CALL and TOOL DEF.
//!
//! Facts: programming manuals of the control: TOOL CALL with a tool changes it, without one it changes S, F and the
//! allowances of the tool in the spindle; `5.1` has its own row in the tool table, but is the same tool of the
//! magazine; L and R of TOOL DEF are those of the tool. Decisions: an allowance that a TOOL CALL without a tool
//! does not name keeps its value; L and R of TOOL DEF replace those of the table. Invariant: a length or radius takes
//! effect at the next TOOL CALL.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::eval::{Evaluator, IdentificationResult};
use super::foreign_axes::refuse_axes;
use super::formula::Formula;
use super::path_state::AXES;
use super::q_parameter::ParameterValue;
use super::tools::{LENGTH, RADIUS, is_indexed, row};
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, MADE, Rest, headed, shown};

/// Register for the row of an indexed tool.
const ROW: &str = "TOOLROW";

/// Text that a TOOL CALL without a tool leaves if it has allowances.
const SIZES: &str = "TOOL SIZES";

impl Heidenhain {
    /// Number of a tool; none for an unknown name.
    fn tool(&mut self, host: &mut dyn InterpreterHost, tool: &Formula) -> Result<Option<String>, Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let name = match evaluator.value(tool)? {
            ParameterValue::Number(number) => return Ok(Some(shown(number))),
            ParameterValue::Text(name) => name,
        };
        let quoted = format!("\"{name}\"");
        Ok(match evaluator.ask(&quoted)? {
            IdentificationResult::Value(ParameterValue::Number(number)) => Some(shown(number)),
            IdentificationResult::Value(ParameterValue::Text(text)) => Some(text.to_string()),
            IdentificationResult::Kept => Some(quoted),
            IdentificationResult::Nothing => None,
            IdentificationResult::Unknown => {
                if let Some(number) = host.tool_number(&name) {
                    host.name_tool(number, &name);
                    return Ok(Some(number.to_string()));
                }
                let text = format!("tool {quoted} not found in '{}'", host.block_text());
                host.diagnose(&diag::TOOL_NAME, text);
                None
            }
        })
    }

    pub(super) fn call_tool(
        &mut self,
        host: &mut dyn InterpreterHost,
        tool: Option<&Formula>,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let number = match tool {
            Some(tool) => self.tool(host, tool)?,
            None => None,
        };
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        refuse_axes(host, "TOOL CALL", &seen)?;
        self.feed_units(host, &mut seen)?;
        for word in &seen {
            if word.value.is_none()
                && let Some(at) = AXES.iter().position(|axis| word.is(axis))
            {
                // Q109 counts X, Y, Z as 0 to 2, U, V, W as 6 to 8, as the axes are here.
                self.variables.control.tool_axis = Some(at);
                self.path.plane = match at % 3 {
                    0 => [1, 2],
                    1 => [2, 0],
                    _ => [0, 1],
                };
            }
            if word.is("F") {
                self.path.rates.of_tool = Some(word.apart());
                self.path.rates.last = Some(word.apart());
            }
        }
        let called = number.as_deref().and_then(|number| number.parse::<f64>().ok());
        let is_allowance = |word: &EvaluatedWord| matches!(&*word.name, "DL" | "DR" | "DR2") && word.value.is_some();
        let changes = tool.is_none() && seen.iter().any(is_allowance);
        if called.is_some() || changes {
            self.take_allowances(host, called, &mut seen);
        }
        self.functions_of(&seen);
        // Allowances belong to the tool table, unless the machine has registers for them.
        let stays =
            |word: &EvaluatedWord| !matches!(&*word.name, "DL" | "DR" | "DR2" | ROW) || host.is_register(&word.name);
        let left = seen.into_iter().filter(stays);
        Ok(vec![match number {
            Some(number) if host.is_register(ROW) => {
                let number = called.map_or(number, |called| shown(called.trunc()));
                std::iter::once(with_tool("TOOL CALL ", number)).chain(left).collect()
            }
            Some(number) => std::iter::once(with_tool("TOOL CALL ", number)).chain(left).collect(),
            None if changes && host.is_code_text(SIZES) => headed(SIZES, left),
            None => left.collect(),
        }])
    }

    /// The allowances of the block, with those of the tool table; without a tool, allowances that it does not name
    /// stay. An indexed tool gets its row.
    fn take_allowances(&mut self, host: &mut dyn InterpreterHost, called: Option<f64>, seen: &mut Vec<EvaluatedWord>) {
        let tool = called.or(self.variables.control.tool).unwrap_or_else(|| f64::from(host.tool()));
        let before = if called.is_some() { [0.0; 2] } else { self.variables.control.allowances };
        let said = |name: &str| seen.iter().find(|word| word.is(name)).and_then(|word| word.value);
        let allowances = [said("DL").unwrap_or(before[0]), said("DR").unwrap_or(before[1])];
        for (name, value) in ["DL", "DR"].into_iter().zip(allowances) {
            if value != 0.0 && !seen.iter().any(|word| word.is(name)) {
                seen.push(EvaluatedWord::made(name, value));
            }
        }
        self.tools.add_allowances(host, tool, seen);
        // Offsets of the machine are in its own unit.
        let factor = if self.units.inches { host.length_factor() } else { 1.0 };
        for word in seen.iter_mut().filter(|word| matches!(&*word.name, "DL" | "DR") && factor != 1.0) {
            *word = EvaluatedWord::made(&word.name.clone(), word.value.unwrap_or(0.0) * factor);
        }
        let control = &mut self.variables.control;
        (control.tool, control.allowances) = (Some(tool), allowances);
        let allowance = |word: &EvaluatedWord| matches!(&*word.name, "DL" | "DR" | "DR2") && word.value != Some(0.0);
        self.space.allowances = seen.iter().any(|word| word.value.is_some() && allowance(word));
        if is_indexed(tool) {
            seen.push(EvaluatedWord::made(ROW, f64::from(row(tool))));
        }
    }

    pub(super) fn define_tool(
        &mut self,
        host: &mut dyn InterpreterHost,
        tool: &Formula,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let Some(number) = self.tool(host, tool)? else { return Ok(Vec::new()) };
        let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        refuse_axes(host, "TOOL DEF", &seen)?;
        let defined = number.parse::<f64>().ok();
        for (name, column) in [("L", LENGTH), ("R", RADIUS)] {
            let value = seen.iter().find(|word| word.is(name)).and_then(|word| word.value);
            let (Some(tool), Some(value)) = (defined, value) else { continue };
            // Tool 0 has no length and no radius.
            if row(tool) > 0 && !self.tools.write_column(host, row(tool), column, value) {
                let text = format!("{name} of tool {number} cannot be set in '{}'", host.block_text());
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            }
            host.effect();
        }
        // Length and radius are those of the tool table, not words of the block.
        let others = seen.into_iter().filter(|word| !word.is("L") && !word.is("R"));
        let number = match defined.filter(|tool| is_indexed(*tool) && host.is_register(ROW)) {
            Some(tool) => shown(tool.trunc()),
            None => number,
        };
        Ok(vec![std::iter::once(with_tool("TOOL DEF ", number)).chain(others).collect()])
    }

    /// PRESET SELECT: a row of the preset table by its number, as cycle 247; transformations end unless the block
    /// has KEEP TRANS.
    pub(super) fn select_preset(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        let is_known = |word: &EvaluatedWord| matches!(&*word.name, "#" | "KEEP" | "TRANS" | "WP");
        let row = seen.iter().find(|word| word.is("#")).and_then(|word| word.value);
        let Some(row) = row.filter(|_| seen.iter().all(is_known)) else { return Err(self.not_understood(host)) };
        let keeps = seen.iter().any(|word| word.is("KEEP"));
        let mut lines = if keeps { Vec::new() } else { self.shifts.define(host, 247, &mut Vec::new()) };
        lines.push(vec![EvaluatedWord::made("CYCL DEF ", 247.0), EvaluatedWord::made("Q339=", row)]);
        Ok(lines)
    }
}

/// A call or definition of a tool by its number, or by the text that the machine has for it.
fn with_tool(name: &str, number: String) -> EvaluatedWord {
    let value = number.parse().ok();
    EvaluatedWord { name: name.into(), value, rest: Rest::Written(number.into()), span: MADE, function: None }
}
