//! Values of expressions, and assignments to parameters.
//!
//! Facts: LinuxCNC documentation, "Parameters": an assignment takes effect after all values of its block are read.

use counterpoint_fault as diag;

use super::expr::{ParameterName, Rs274Expr, Rs274Op, number_of};
use super::parameters::HIGHEST;
use super::text::{BlockText, Rs274Cursor, Rs274Mistake};
use super::{Outcome, Rs274, Rs274Stop};
use counterpoint_control_api::expression::{Evaluate, Stack};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator, truth};

/// Evaluates with the parameters of a kernel.
struct Rs274Evaluator<'e> {
    rs274: &'e mut Rs274,
    host: &'e mut dyn InterpreterHost,
}

impl Evaluate<f64, Rs274Op> for Rs274Evaluator<'_> {
    type Stop = Rs274Stop;

    fn own(&mut self, own: &Rs274Op, stack: &mut Stack<f64>) -> Outcome<f64> {
        match own {
            Rs274Op::Fixed(number) => Ok(self.rs274.read_number(self.host, *number)),
            Rs274Op::Numbered => {
                let value = stack.pop();
                let number = number_of(value).ok_or_else(|| no_parameter(&value.to_string()))?;
                Ok(self.rs274.read_number(self.host, number))
            }
            Rs274Op::Named(name) => self.rs274.read_named(self.host, name),
            Rs274Op::ExistsNumber => Ok(truth(number_of(stack.pop()).is_some_and(|number| number <= HIGHEST))),
            Rs274Op::Exists(name) => Ok(truth(self.rs274.named_value(self.host, name).is_some())),
        }
    }

    fn apply(&mut self, function: NumericFunction, value: f64) -> Outcome<f64> {
        finite(function.value(value), function.name())
    }

    fn combine(&mut self, operator: NumericOperator, left: f64, right: f64) -> Outcome<f64> {
        match operator.value(left, right) {
            None => Err(Rs274Mistake::new(&diag::MACRO_DIVISION, 1, "division by zero").into()),
            value => finite(value, "the operator"),
        }
    }
}

fn finite(value: Option<f64>, name: &str) -> Outcome<f64> {
    match value {
        Some(value) if value.is_finite() => Ok(value),
        _ => Err(Rs274Mistake::new(&diag::MACRO_DOMAIN, 1, format!("{name} has no value here")).into()),
    }
}

fn no_parameter(number: &str) -> Rs274Stop {
    let text = format!("#{number} does not exist: parameters have whole numbers from 1 on");
    Rs274Mistake::new(&diag::MACRO_VARIABLE, 1, text).into()
}

impl Rs274 {
    /// Value of an expression.
    pub(super) fn value(&mut self, host: &mut dyn InterpreterHost, expr: &Rs274Expr) -> Outcome<f64> {
        match expr.as_constant() {
            Some(value) => Ok(*value),
            None => Rs274Evaluator { rs274: self, host }.evaluate(expr),
        }
    }

    /// Value of a named parameter.
    fn read_named(&mut self, host: &mut dyn InterpreterHost, name: &str) -> Outcome<f64> {
        if let Some(value) = self.named_value(host, name) {
            return Ok(value);
        }
        let asked = format!("#<{name}>");
        if let IdentificationAnswer::Instead(answer) = host.identify(&asked, None)?.unless(&asked)
            && let Ok(value) = answer.trim().parse()
        {
            return Ok(value);
        }
        let text = format!("#<{name}> has no value: set it before, or test it with EXISTS[#<{name}>]");
        Err(Rs274Mistake::new(&diag::MACRO_VARIABLE, 1, text).into())
    }

    /// Value of a named parameter, if it has one.
    pub(super) fn named_value(&mut self, host: &dyn InterpreterHost, name: &str) -> Option<f64> {
        self.parameters.named(name).or_else(|| self.system_named(host, name))
    }

    /// The parameter that an assignment sets.
    pub(super) fn target(&mut self, host: &mut dyn InterpreterHost, name: &ParameterName) -> Outcome<Target> {
        Ok(match name {
            ParameterName::Named(name) => Target::Named(name.clone()),
            ParameterName::Number(number) => {
                let value = self.value(host, number)?;
                Target::Number(number_of(value).ok_or_else(|| no_parameter(&value.to_string()))?)
            }
        })
    }

    /// Sets a parameter.
    pub(super) fn set(&mut self, host: &mut dyn InterpreterHost, target: &Target, value: f64) -> Outcome<()> {
        let changed = match target {
            Target::Named(name) if self.system_named(host, name).is_some() => {
                let text = format!("#<{name}> can only be read");
                return Err(Rs274Mistake::new(&diag::MACRO_VARIABLE, 1, text).into());
            }
            Target::Named(name) => self.parameters.set_named(name, value)?,
            Target::Number(number) => match self.set_system(host, *number, value)? {
                true => true,
                false => self.parameters.set_number(*number, value)?,
            },
        };
        if changed {
            host.effect();
        }
        Ok(())
    }

    /// A parameter in native spelling, for macros.
    pub(super) fn read_spelled(&mut self, host: &mut dyn InterpreterHost, text: &str) -> Option<f64> {
        match spelled(text)? {
            Target::Number(number) => Some(self.read_number(host, number)),
            Target::Named(name) => self.named_value(host, &name),
        }
    }

    /// Sets a parameter in native spelling. Returns whether it was set.
    pub(super) fn set_spelled(&mut self, host: &mut dyn InterpreterHost, text: &str, value: f64) -> bool {
        spelled(text).is_some_and(|target| self.set(host, &target, value).is_ok())
    }
}

/// A parameter that is set.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Target {
    Number(u32),
    Named(Box<str>),
}

/// `#5` or `#<name>`.
pub(super) fn spelled(text: &str) -> Option<Target> {
    let text = BlockText::read(text.as_bytes()).ok()?;
    let mut cursor = Rs274Cursor::new(&text);
    if !cursor.takes("#") {
        return None;
    }
    if cursor.here() == Some(b'<') {
        return super::expr::name(&mut cursor).ok().map(Target::Named);
    }
    number_of(cursor.number()?).map(Target::Number)
}
