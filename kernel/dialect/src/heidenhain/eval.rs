//! Values of formulas.
//!
//! Facts: reference control-emulator.md 4.3 (identification), programming manuals of the control: angles in degrees,
//! SGN of zero is 1, positions in texts count from 0, STRCOMP is 0, 1 or -1, INSTR gives the length if nothing is
//! found. Functions come from `libm`, so that every machine gives the same bits. Invariant: a value is finite.

use counterpoint_fault::Halt;
use std::sync::Arc;

use counterpoint_lang::value::Value as Given;

use super::formula::{Formula, Function, Kind, Name, Op};
use super::lex::{Cursor, capitals};
use super::variables::{Value, Variables};
use crate::host::{Answer, Host};
use crate::numeric::DEGREES;
use counterpoint_fault as diag;
use counterpoint_fault::Facts;

/// Longest text.
const LONGEST: usize = 8192;

/// Answers of a machine that lead to further questions.
const ANSWERS: u32 = 8;

/// What the machine says of a text.
pub(super) enum Asked {
    Value(Value),
    /// It is nothing, and nothing is to be said.
    Nothing,
    /// The text stays as it is.
    Kept,
    /// It does not say anything.
    Unknown,
}

/// What a parameter without value counts as.
fn blank(name: Name) -> Value {
    if name.kind == Kind::Text { Value::Text("".into()) } else { Value::Number(0.0) }
}

/// Where formulas get their values.
pub(super) struct Evaluator<'a> {
    pub(super) variables: &'a mut Variables,
    pub(super) host: &'a mut dyn Host,
    depth: u32,
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(variables: &'a mut Variables, host: &'a mut dyn Host) -> Self {
        Self { variables, host, depth: 0 }
    }

    fn fail<T>(&mut self, facts: &'static Facts, why: &str) -> Result<T, Halt> {
        let text = format!("{why} in '{}'", self.host.block_text());
        Err(self.host.alarm(facts, text))
    }

    /// Value of a formula.
    pub(super) fn value(&mut self, formula: &Formula) -> Result<Value, Halt> {
        match formula.0.as_slice() {
            [Op::Number(value)] => return Ok(Value::Number(*value)),
            [Op::Variable(name)] => return self.variable(*name),
            _ => {}
        }
        let mut stack: Vec<Value> = Vec::with_capacity(formula.0.len().min(16));
        for op in &formula.0 {
            let value = self.operate(op, &mut stack)?;
            stack.push(value);
        }
        Ok(stack.pop().unwrap_or(Value::Number(0.0)))
    }

    /// Value of a formula that has to be a number.
    pub(super) fn number(&mut self, formula: &Formula) -> Result<f64, Halt> {
        match self.value(formula)? {
            Value::Number(value) => Ok(value),
            Value::Text(text) => self.fail(&diag::MACRO_DOMAIN, &format!("the text \"{text}\" is no number")),
        }
    }

    fn pop_number(&mut self, stack: &mut Vec<Value>) -> Result<f64, Halt> {
        match stack.pop() {
            Some(Value::Number(value)) => Ok(value),
            Some(Value::Text(text)) => self.fail(&diag::MACRO_DOMAIN, &format!("the text \"{text}\" is no number")),
            None => Ok(0.0),
        }
    }

    fn pop_text(&mut self, stack: &mut Vec<Value>) -> Result<Arc<str>, Halt> {
        match stack.pop() {
            Some(Value::Text(text)) => Ok(text),
            Some(Value::Number(value)) => self.fail(&diag::MACRO_DOMAIN, &format!("the number {value} is no text")),
            None => Ok("".into()),
        }
    }

    fn operate(&mut self, op: &Op, stack: &mut Vec<Value>) -> Result<Value, Halt> {
        Ok(match op {
            Op::Number(value) => Value::Number(*value),
            Op::Text(text) => Value::Text(Arc::clone(text)),
            Op::Variable(name) => self.variable(*name)?,
            Op::Apply(function) => {
                let value = self.pop_number(stack)?;
                match apply(*function, value).filter(|value| value.is_finite()) {
                    Some(value) => Value::Number(value),
                    None => {
                        let why = format!("{} of {value} is not defined", shown(*function));
                        return self.fail(&diag::MACRO_DOMAIN, &why);
                    }
                }
            }
            Op::Unknown(text) => self.unknown(text)?,
            Op::Join => {
                let (right, left) = (self.pop_text(stack)?, self.pop_text(stack)?);
                if left.len() + right.len() > LONGEST {
                    return self.fail(&diag::MACRO_DOMAIN, "the text is too long");
                }
                Value::Text(format!("{left}{right}").into())
            }
            Op::ToChar => {
                let (places, value) = (self.pop_number(stack)?, self.pop_number(stack)?);
                let places = places.clamp(0.0, 16.0) as usize;
                Value::Text(format!("{:.places$}", value + 0.0).into())
            }
            Op::Substring => {
                let (length, begin) = (self.pop_number(stack)?, self.pop_number(stack)?);
                let text = self.pop_text(stack)?;
                let length = if length < 0.0 { usize::MAX } else { length as usize };
                Value::Text(text.chars().skip(begin.max(0.0) as usize).take(length).collect::<String>().into())
            }
            Op::ToNumber => {
                let text = self.pop_text(stack)?;
                match text.trim().parse::<f64>().ok().filter(|value| value.is_finite()) {
                    Some(value) => Value::Number(value),
                    None => return self.fail(&diag::MACRO_DOMAIN, &format!("the text \"{text}\" is no number")),
                }
            }
            Op::Find => {
                let begin = self.pop_number(stack)?.max(0.0) as usize;
                let (wanted, text) = (self.pop_text(stack)?, self.pop_text(stack)?);
                let all = text.chars().count();
                let skipped: usize = text.chars().take(begin).map(char::len_utf8).sum();
                let found = text.get(skipped..).and_then(|rest| Some((rest, rest.find(&*wanted)?)));
                let at = found.and_then(|(rest, at)| Some(begin + rest.get(..at)?.chars().count()));
                Value::Number(at.unwrap_or(all) as f64)
            }
            Op::Length => Value::Number(self.pop_text(stack)?.chars().count() as f64),
            Op::Compare => {
                let (right, left) = (self.pop_text(stack)?, self.pop_text(stack)?);
                Value::Number(f64::from(left.cmp(&right) as i8))
            }
            op => {
                let (right, left) = (self.pop_number(stack)?, self.pop_number(stack)?);
                let value = match combine(op, left, right) {
                    Some(value) => value,
                    None => return self.fail(&diag::MACRO_DIVISION, "division by zero"),
                };
                if !value.is_finite() {
                    return self.fail(&diag::MACRO_DOMAIN, "the result has no number");
                }
                Value::Number(value)
            }
        })
    }

    /// Value of a parameter.
    fn variable(&mut self, name: Name) -> Result<Value, Halt> {
        Ok(self.value_or_kept(name)?.unwrap_or_else(|| blank(name)))
    }

    /// Value of a parameter; none if the machine wants its text to stay.
    pub(super) fn value_or_kept(&mut self, name: Name) -> Result<Option<Value>, Halt> {
        if let Some(value) = self.variables.get(name) {
            return Ok(Some(value));
        }
        match self.ask(&name.to_string())? {
            Asked::Value(value) => Ok(Some(value)),
            Asked::Nothing => Ok(Some(blank(name))),
            Asked::Kept => Ok(None),
            Asked::Unknown if !Variables::exists(name) => {
                self.fail(&diag::MACRO_VARIABLE, &format!("there is no parameter {name}"))
            }
            Asked::Unknown => match self.variables.of_control(name) {
                Some(value) => Ok(Some(value)),
                None => {
                    let what = if name.kind == Kind::Text { "an empty text" } else { "0" };
                    let text = format!("{name} has no value in '{}', it counts as {what}", self.host.block_text());
                    self.host.diagnose(&diag::PARAMETER_UNSET, text);
                    Ok(Some(blank(name)))
                }
            },
        }
    }

    /// Value of a function that the control does not know.
    fn unknown(&mut self, text: &str) -> Result<Value, Halt> {
        match self.ask(text)? {
            Asked::Value(value) => Ok(value),
            Asked::Nothing | Asked::Kept => Ok(Value::Number(0.0)),
            Asked::Unknown => self.fail(&diag::MACRO_SYNTAX, &format!("nobody knows '{text}'")),
        }
    }

    /// What the machine says of a text.
    pub(super) fn ask(&mut self, text: &str) -> Result<Asked, Halt> {
        let instead = match self.host.identify(text, None)?.unless(text) {
            Answer::Unknown => return Ok(Asked::Unknown),
            Answer::Drop => return Ok(Asked::Nothing),
            Answer::Keep => return Ok(Asked::Kept),
            Answer::Instead(instead) => instead,
        };
        if self.depth >= ANSWERS {
            return self.fail(&diag::MACRO_SYNTAX, &format!("the machine answers '{text}' by ever further names"));
        }
        let instead = capitals(instead.trim());
        let mut cursor = Cursor::new(&instead);
        let formula = match Formula::parse(&mut cursor) {
            Ok(formula) if cursor.is_over() => formula,
            _ => {
                return self.fail(&diag::MACRO_SYNTAX, &format!("'{instead}', which stands for '{text}', is no value"));
            }
        };
        self.depth += 1;
        let value = self.value(&formula);
        self.depth -= 1;
        value.map(Asked::Value)
    }

    /// Sets a parameter.
    pub(super) fn assign(&mut self, name: Name, value: Value) -> Result<(), Halt> {
        self.host.effect();
        if self.variables.set(name, value.clone()) {
            return Ok(());
        }
        if Variables::exists(name) {
            let what = if name.kind == Kind::Text { "a text" } else { "a number" };
            return self.fail(&diag::MACRO_DOMAIN, &format!("{name} takes {what}"));
        }
        match self.host.identify(&name.to_string(), Some(&given(&value)))?.unless(&name.to_string()) {
            Answer::Drop | Answer::Keep => Ok(()),
            Answer::Instead(instead) => {
                let instead = capitals(instead.trim());
                match super::formula::parameter(&mut Cursor::new(&instead)) {
                    Some(other) if self.variables.set(other, value) => Ok(()),
                    _ => self.fail(&diag::MACRO_VARIABLE, &format!("'{instead}', given for {name}, is no parameter")),
                }
            }
            Answer::Unknown => self.fail(&diag::MACRO_VARIABLE, &format!("there is no parameter {name}")),
        }
    }
}

/// A value as macros have it.
pub(super) fn given(value: &Value) -> Given {
    match value {
        Value::Number(value) => Given::Real(*value),
        Value::Text(text) => Given::text(&**text),
    }
}

fn shown(function: Function) -> &'static str {
    match function {
        Function::Common(function) => function.name(),
        Function::Log => "LOG",
        _ => "the function",
    }
}

fn apply(function: Function, value: f64) -> Option<f64> {
    Some(match function {
        Function::Common(function) => function.value(value)?,
        Function::Minus => -value,
        Function::Square => value * value,
        Function::Log => libm::log10(value),
        Function::Frac => value.fract(),
        Function::Sign => {
            if value < 0.0 {
                -1.0
            } else {
                1.0
            }
        }
    })
}

/// None for a division by zero.
fn combine(op: &Op, left: f64, right: f64) -> Option<f64> {
    Some(match op {
        Op::Add => left + right,
        Op::Subtract => left - right,
        Op::Multiply => left * right,
        Op::Divide | Op::Modulo if right == 0.0 => return None,
        Op::Divide => left / right,
        Op::Modulo => left - right * (left / right).trunc(),
        Op::Power => libm::pow(left, right),
        Op::Legs => libm::sqrt(left * left + right * right),
        // The first leg lies opposite to the angle, 0 to 360 degrees.
        Op::Angle => (libm::atan2(left, right) * DEGREES).rem_euclid(360.0),
        _ => 0.0,
    })
}
