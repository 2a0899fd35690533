//! Values of formulas.
//!
//! Facts: reference control-emulator.md 4.3 (identification), programming manuals of the control: angles in degrees,
//! SGN of zero is 1, positions in texts count from 0, STRCOMP is 0, 1 or -1, INSTR gives the length if nothing is
//! found. Functions come from `libm`, so that every machine gives the same bits. Invariant: a value is finite.

use std::sync::Arc;

use counterpoint_control_api::expression::{Evaluate, Stack};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};
use counterpoint_fault as diag;
use counterpoint_fault::{DiagnosticFacts, Halt};
use counterpoint_lang::value::MacroValue;

use super::formula::{Formula, HeidenhainOp, formula};
use super::lex::{HeidenhainCursor, capitals};
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};
use super::variables::QParameterStore;

/// Longest text.
const LONGEST: usize = 8192;

/// Answers of a machine that lead to further questions.
const ANSWERS: u32 = 8;

/// The machine's rows of a text.
pub(super) enum IdentificationResult {
    Value(ParameterValue),
    /// No value and no report.
    Nothing,
    /// The text stays as it is.
    Kept,
    /// It does not say anything.
    Unknown,
}

/// Value of a parameter without a value.
fn blank(name: QParameter) -> ParameterValue {
    if name.kind == ParameterKind::Text { ParameterValue::Text("".into()) } else { ParameterValue::Number(0.0) }
}

/// Where formulas get their values.
pub(super) struct Evaluator<'a> {
    pub(super) variables: &'a mut QParameterStore,
    pub(super) host: &'a mut dyn InterpreterHost,
    depth: u32,
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(variables: &'a mut QParameterStore, host: &'a mut dyn InterpreterHost) -> Self {
        Self { variables, host, depth: 0 }
    }

    fn fail<T>(&mut self, facts: &'static DiagnosticFacts, why: &str) -> Result<T, Halt> {
        let text = format!("{why} in '{}'", self.host.block_text());
        Err(self.host.alarm(facts, text))
    }

    /// Value of a formula.
    pub(super) fn value(&mut self, formula: &Formula) -> Result<ParameterValue, Halt> {
        self.evaluate(formula)
    }

    /// Value of a formula that has to be a number.
    pub(super) fn number(&mut self, formula: &Formula) -> Result<f64, Halt> {
        let value = self.value(formula)?;
        self.as_number(value)
    }

    fn as_number(&mut self, value: ParameterValue) -> Result<f64, Halt> {
        match value {
            ParameterValue::Number(value) => Ok(value),
            ParameterValue::Text(text) => {
                self.fail(&diag::MACRO_DOMAIN, &format!("the text \"{text}\" is not a valid number"))
            }
        }
    }

    fn as_text(&mut self, value: ParameterValue) -> Result<Arc<str>, Halt> {
        match value {
            ParameterValue::Text(text) => Ok(text),
            ParameterValue::Number(value) => {
                self.fail(&diag::MACRO_DOMAIN, &format!("the number {value} is not a text"))
            }
        }
    }

    /// Value of a parameter.
    fn variable(&mut self, name: QParameter) -> Result<ParameterValue, Halt> {
        Ok(self.value_or_kept(name)?.unwrap_or_else(|| blank(name)))
    }

    /// Value of a parameter; none if the machine wants its text to stay.
    pub(super) fn value_or_kept(&mut self, name: QParameter) -> Result<Option<ParameterValue>, Halt> {
        if let Some(value) = self.variables.get(name) {
            return Ok(Some(value));
        }
        match self.ask(&name.to_string())? {
            IdentificationResult::Value(value) => Ok(Some(value)),
            IdentificationResult::Nothing => Ok(Some(blank(name))),
            IdentificationResult::Kept => Ok(None),
            IdentificationResult::Unknown if !QParameterStore::exists(name) => {
                self.fail(&diag::MACRO_VARIABLE, &format!("parameter {name} does not exist"))
            }
            IdentificationResult::Unknown => match self.variables.of_control(name, &*self.host) {
                Some(value) => Ok(Some(value)),
                None => {
                    let what = if name.kind == ParameterKind::Text { "an empty text" } else { "0" };
                    let text = format!("{name} has no value in '{}'; {what} is used", self.host.block_text());
                    self.host.diagnose(&diag::PARAMETER_UNSET, text);
                    Ok(Some(blank(name)))
                }
            },
        }
    }

    /// Value of a function that the control does not know.
    fn unknown(&mut self, text: &str) -> Result<ParameterValue, Halt> {
        match self.ask(text)? {
            IdentificationResult::Value(value) => Ok(value),
            IdentificationResult::Nothing | IdentificationResult::Kept => Ok(ParameterValue::Number(0.0)),
            IdentificationResult::Unknown => {
                self.fail(&diag::MACRO_SYNTAX, &format!("'{text}' is not a known function"))
            }
        }
    }

    /// The machine's rows of a text.
    pub(super) fn ask(&mut self, text: &str) -> Result<IdentificationResult, Halt> {
        let instead = match self.host.identify(text, None)?.unless(text) {
            IdentificationAnswer::Unknown => return Ok(IdentificationResult::Unknown),
            IdentificationAnswer::Drop => return Ok(IdentificationResult::Nothing),
            IdentificationAnswer::Keep => return Ok(IdentificationResult::Kept),
            IdentificationAnswer::Instead(instead) => instead,
        };
        if self.depth >= ANSWERS {
            return self.fail(
                &diag::MACRO_SYNTAX,
                &format!("the answers of the machine for '{text}' lead to further names without end"),
            );
        }
        let instead = capitals(instead.trim());
        let mut cursor = HeidenhainCursor::new(&instead);
        let formula = match formula(&mut cursor) {
            Ok(formula) if cursor.is_over() => formula,
            _ => {
                return self.fail(
                    &diag::MACRO_SYNTAX,
                    &format!("'{instead}', the answer of the machine for '{text}', is not a valid value"),
                );
            }
        };
        self.depth += 1;
        let value = self.value(&formula);
        self.depth -= 1;
        value.map(IdentificationResult::Value)
    }

    /// Sets a parameter.
    pub(super) fn assign(&mut self, name: QParameter, value: ParameterValue) -> Result<(), Halt> {
        self.host.effect();
        if self.variables.set(name, value.clone()) {
            return Ok(());
        }
        if QParameterStore::exists(name) {
            let what = if name.kind == ParameterKind::Text { "a text" } else { "a number" };
            return self.fail(&diag::MACRO_DOMAIN, &format!("{name} takes {what}"));
        }
        match self.host.identify(&name.to_string(), Some(&given(&value)))?.unless(&name.to_string()) {
            IdentificationAnswer::Drop | IdentificationAnswer::Keep => Ok(()),
            IdentificationAnswer::Instead(instead) => {
                let instead = capitals(instead.trim());
                match super::formula::parameter(&mut HeidenhainCursor::new(&instead)) {
                    Some(other) if self.variables.set(other, value) => Ok(()),
                    _ => self.fail(
                        &diag::MACRO_VARIABLE,
                        &format!("'{instead}', the answer of the machine for {name}, is not a valid parameter"),
                    ),
                }
            }
            IdentificationAnswer::Unknown => {
                self.fail(&diag::MACRO_VARIABLE, &format!("parameter {name} does not exist"))
            }
        }
    }
}

/// A value as macros have it.
pub(super) fn given(value: &ParameterValue) -> MacroValue {
    match value {
        ParameterValue::Number(value) => MacroValue::Real(*value),
        ParameterValue::Text(text) => MacroValue::text(&**text),
    }
}

impl Evaluate<ParameterValue, HeidenhainOp> for Evaluator<'_> {
    type Stop = Halt;

    fn own(&mut self, own: &HeidenhainOp, stack: &mut Stack<ParameterValue>) -> Result<ParameterValue, Halt> {
        Ok(match own {
            HeidenhainOp::Variable(name) => return self.variable(*name),
            HeidenhainOp::Unknown(text) => return self.unknown(text),
            HeidenhainOp::ToChar => {
                let (places, value) = (self.as_number(stack.pop())?, self.as_number(stack.pop())?);
                let places = places.clamp(0.0, 16.0) as usize;
                ParameterValue::Text(format!("{:.places$}", value + 0.0).into())
            }
            HeidenhainOp::Substring => {
                let (length, begin) = (self.as_number(stack.pop())?, self.as_number(stack.pop())?);
                let text = self.as_text(stack.pop())?;
                let length = if length < 0.0 { usize::MAX } else { length as usize };
                ParameterValue::Text(text.chars().skip(begin.max(0.0) as usize).take(length).collect::<String>().into())
            }
            HeidenhainOp::ToNumber => {
                let text = self.as_text(stack.pop())?;
                match text.trim().parse::<f64>().ok().filter(|value| value.is_finite()) {
                    Some(value) => ParameterValue::Number(value),
                    None => {
                        return self.fail(&diag::MACRO_DOMAIN, &format!("the text \"{text}\" is not a valid number"));
                    }
                }
            }
            HeidenhainOp::Find => {
                let begin = self.as_number(stack.pop())?.max(0.0) as usize;
                let (wanted, text) = (self.as_text(stack.pop())?, self.as_text(stack.pop())?);
                let all = text.chars().count();
                let skipped: usize = text.chars().take(begin).map(char::len_utf8).sum();
                let found = text.get(skipped..).and_then(|rest| Some((rest, rest.find(&*wanted)?)));
                let at = found.and_then(|(rest, at)| Some(begin + rest.get(..at)?.chars().count()));
                ParameterValue::Number(at.unwrap_or(all) as f64)
            }
            HeidenhainOp::Length => ParameterValue::Number(self.as_text(stack.pop())?.chars().count() as f64),
            HeidenhainOp::Compare => {
                let (right, left) = (self.as_text(stack.pop())?, self.as_text(stack.pop())?);
                ParameterValue::Number(f64::from(left.cmp(&right) as i8))
            }
        })
    }

    fn apply(&mut self, function: NumericFunction, value: ParameterValue) -> Result<ParameterValue, Halt> {
        let value = self.as_number(value)?;
        match function.value(value).filter(|value| value.is_finite()) {
            Some(value) => Ok(ParameterValue::Number(value)),
            None => self.fail(&diag::MACRO_DOMAIN, &format!("{} of {value} is not defined", function.name())),
        }
    }

    fn combine(
        &mut self,
        operator: NumericOperator,
        left: ParameterValue,
        right: ParameterValue,
    ) -> Result<ParameterValue, Halt> {
        if operator == NumericOperator::Join {
            let (right, left) = (self.as_text(right)?, self.as_text(left)?);
            if left.len() + right.len() > LONGEST {
                return self.fail(&diag::MACRO_DOMAIN, "the text is too long");
            }
            return Ok(ParameterValue::Text(format!("{left}{right}").into()));
        }
        let (right, left) = (self.as_number(right)?, self.as_number(left)?);
        match operator.value(left, right) {
            Some(value) if value.is_finite() => Ok(ParameterValue::Number(value)),
            Some(_) => self.fail(&diag::MACRO_DOMAIN, "the result is out of range"),
            None => self.fail(&diag::MACRO_DIVISION, "division by zero"),
        }
    }
}
