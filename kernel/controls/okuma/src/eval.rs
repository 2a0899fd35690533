//! Values of expressions, and where values go.
//!
//! Facts: reference control-emulator.md 4.3, 5.4. Order for variables that the program does not own: the identification
//! macro, then the data of the control, then a diagnostic and 0. Decisions: a local variable without a value is
//! unknown, except for a comparison with EMPTY; VSIO and VAPA with the letter of an axis are its position in program
//! coordinates; VPBR1 to VPBR9 are the switches of branches, all off. Invariant: no value is infinite or not a number.

use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;

use super::cursor::OkumaCursor;
use super::expr::{Expr, OkumaExpressionReader, OkumaOp, OkumaVariable};
use super::math::OkumaMathError;
use super::names::LocalVariableName;
use super::store::OkumaVariableStore;
use counterpoint_control_api::expression::{Evaluate, Stack};
use counterpoint_control_api::host::{IdentificationAnswer, InterpreterHost};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator, truth};
use counterpoint_fault as diag;

/// Why there is no value.
#[derive(Debug)]
pub(super) enum EvaluationStop {
    Halt(Halt),
    /// The identification macro leaves the text as it is.
    Keep,
}

impl From<Halt> for EvaluationStop {
    fn from(halt: Halt) -> Self {
        EvaluationStop::Halt(halt)
    }
}

/// Evaluates with the variables of a kernel.
pub(super) struct OkumaEvaluator<'e> {
    pub(super) store: &'e mut OkumaVariableStore,
    pub(super) host: &'e mut dyn InterpreterHost,
    /// An answer of the identification macro is evaluated: it is not asked again.
    answering: bool,
}

impl<'e> OkumaEvaluator<'e> {
    pub(super) fn new(store: &'e mut OkumaVariableStore, host: &'e mut dyn InterpreterHost) -> Self {
        Self { store, host, answering: false }
    }

    /// The value of an expression; 0 if it has none.
    pub(super) fn value(&mut self, expr: &Expr) -> Result<f64, EvaluationStop> {
        self.evaluate(expr)
    }

    /// Whether a variable has a value.
    fn has_value(&mut self, variable: &OkumaVariable) -> Result<bool, EvaluationStop> {
        match variable {
            OkumaVariable::Local(name) => Ok(self.store.local(*name).is_some()),
            OkumaVariable::Common(family, index) => match family.common(self.value(index)?) {
                Some(common) => Ok(self.store.common(self.host, common)?.is_some()),
                None => Ok(false),
            },
            OkumaVariable::System(..) => Ok(true),
        }
    }

    /// The value to assign; none removes the value of a variable.
    pub(super) fn assigned(&mut self, expr: &Expr) -> Result<Option<f64>, EvaluationStop> {
        if let Some(OkumaOp::Empty) = expr.as_own() { Ok(None) } else { self.value(expr).map(Some) }
    }

    fn checked(&mut self, value: Option<f64>, fault: OkumaMathError) -> Result<f64, EvaluationStop> {
        let fault = match value {
            Some(value) if value.is_finite() => return Ok(value),
            Some(_) => OkumaMathError::Overflow,
            None => fault,
        };
        let facts = if fault == OkumaMathError::Division { &diag::MACRO_DIVISION } else { &diag::MACRO_DOMAIN };
        let text = format!("{fault} in '{}'", self.host.block_text());
        Err(EvaluationStop::Halt(self.host.alarm(facts, text)))
    }

    fn variable(&mut self, variable: &OkumaVariable) -> Result<f64, EvaluationStop> {
        match variable {
            OkumaVariable::Local(name) => match self.store.local(*name) {
                Some(value) => Ok(value),
                None => self.unknown(&name.to_string(), "local variable"),
            },
            OkumaVariable::Common(family, index) => {
                let index = self.value(index)?;
                match family.common(index) {
                    Some(common) => Ok(self.store.common(self.host, common)?.unwrap_or(0.0)),
                    None => self.unknown(&format!("{}{index}", family.prefix()), "common variable"),
                }
            }
            OkumaVariable::System(name, indices) => {
                let text = self.spelled(name, indices)?;
                self.unknown(&text, "variable")
            }
        }
    }

    /// A variable with the values of its indices.
    pub(super) fn asked_name(&mut self, variable: &OkumaVariable) -> Result<String, EvaluationStop> {
        match variable {
            OkumaVariable::Local(name) => Ok(name.to_string()),
            OkumaVariable::Common(family, index) => Ok(format!("{}{}", family.prefix(), self.value(index)?)),
            OkumaVariable::System(name, indices) => self.spelled(name, indices),
        }
    }

    /// A name with the values of its indices.
    fn spelled(&mut self, name: &str, indices: &[Expr]) -> Result<String, EvaluationStop> {
        let mut text = name.to_owned();
        for (at, index) in indices.iter().enumerate() {
            let index = self.value(index)?;
            text.push_str(&format!("{}{index}", if at == 0 { "[" } else { "," }));
        }
        if !indices.is_empty() {
            text.push(']');
        }
        Ok(text)
    }

    /// Value of a variable that the program does not own.
    fn unknown(&mut self, text: &str, kind: &str) -> Result<f64, EvaluationStop> {
        let answer =
            if self.answering { IdentificationAnswer::Unknown } else { self.host.identify(text, None)?.unless(text) };
        match answer {
            IdentificationAnswer::Drop => Ok(0.0),
            IdentificationAnswer::Keep => Err(EvaluationStop::Keep),
            IdentificationAnswer::Instead(instead) => self.instead(&instead),
            IdentificationAnswer::Unknown => match system(self.host, text) {
                Some(value) => Ok(value),
                None => {
                    let text = format!("{kind} {text} does not exist in '{}'; 0 is used", self.host.block_text());
                    self.host.diagnose(&diag::OKUMA_UNKNOWN, text);
                    Ok(0.0)
                }
            },
        }
    }

    /// Value of an answer of the identification macro.
    fn instead(&mut self, text: &str) -> Result<f64, EvaluationStop> {
        let upper = text.to_ascii_uppercase();
        let mut cursor = OkumaCursor::new(upper.as_bytes());
        let read = OkumaExpressionReader::new(&mut cursor).expression();
        match read.and_then(|expr| cursor.end().map(|()| expr)) {
            Ok(expr) => {
                let outer = std::mem::replace(&mut self.answering, true);
                let value = self.value(&expr);
                self.answering = outer;
                value
            }
            Err(mistake) => {
                let text = format!("{mistake} in '{}', the answer of a macro", text.trim());
                Err(EvaluationStop::Halt(self.host.alarm(&diag::MACRO_SYNTAX, text)))
            }
        }
    }

    /// Sets a variable.
    pub(super) fn assign(&mut self, variable: &OkumaVariable, value: Option<f64>) -> Result<(), EvaluationStop> {
        match variable {
            OkumaVariable::Local(name) => {
                self.set_local(*name, value);
                Ok(())
            }
            OkumaVariable::Common(family, index) => {
                let index = self.value(index)?;
                match family.common(index) {
                    Some(common) => Ok(self.store.set_common(self.host, common, value)?),
                    None => self.assign_unknown(&format!("{}{index}", family.prefix()), value),
                }
            }
            OkumaVariable::System(name, indices) => {
                let text = self.spelled(name, indices)?;
                self.assign_unknown(&text, value)
            }
        }
    }

    fn set_local(&mut self, name: LocalVariableName, value: Option<f64>) {
        if self.store.set_local(name, value) {
            self.host.effect();
        }
    }

    /// Sets a variable that the program does not own; only the identification macro can do this.
    pub(super) fn assign_unknown(&mut self, text: &str, value: Option<f64>) -> Result<(), EvaluationStop> {
        let assigned = value.map_or(MacroValue::Null, MacroValue::Real);
        let answer = if self.answering {
            IdentificationAnswer::Unknown
        } else {
            self.host.identify(text, Some(&assigned))?.unless(text)
        };
        match answer {
            IdentificationAnswer::Drop => return Ok(()),
            IdentificationAnswer::Keep => return Err(EvaluationStop::Keep),
            IdentificationAnswer::Instead(instead) => {
                let upper = instead.to_ascii_uppercase();
                let mut cursor = OkumaCursor::new(upper.as_bytes());
                let name = super::expr::name_text(&mut cursor);
                let target = OkumaExpressionReader::new(&mut cursor).variable(name);
                if let Ok(target) = target.and_then(|target| cursor.end().map(|()| target)) {
                    let outer = std::mem::replace(&mut self.answering, true);
                    let assigned = self.assign(&target, value);
                    self.answering = outer;
                    return assigned;
                }
            }
            IdentificationAnswer::Unknown => {}
        }
        let text = format!("{text} cannot be set in '{}'; ignored", self.host.block_text());
        self.host.diagnose(&diag::OKUMA_UNKNOWN, text);
        Ok(())
    }
}

impl Evaluate<f64, OkumaOp> for OkumaEvaluator<'_> {
    type Stop = EvaluationStop;

    fn own(&mut self, own: &OkumaOp, stack: &mut Stack<f64>) -> Result<f64, EvaluationStop> {
        match own {
            OkumaOp::Empty => Ok(0.0),
            OkumaOp::Variable(variable) => self.variable(variable),
            OkumaOp::HasValue(variable) => self.has_value(variable).map(truth),
            OkumaOp::IsValue => {
                stack.pop();
                Ok(1.0)
            }
            OkumaOp::Steps(steps) => {
                let unit = if self.host.is_inch() { 10_000.0 } else { 1_000.0 };
                self.checked(Some(steps.value(stack.pop(), unit)), OkumaMathError::Overflow)
            }
            OkumaOp::Unknown(text) => self.unknown(text, "function"),
        }
    }

    fn apply(&mut self, function: NumericFunction, value: f64) -> Result<f64, EvaluationStop> {
        self.checked(function.value(value), OkumaMathError::Domain(function.name(), value))
    }

    fn combine(&mut self, operator: NumericOperator, left: f64, right: f64) -> Result<f64, EvaluationStop> {
        self.checked(operator.value(left, right), OkumaMathError::Division)
    }
}

/// Variables of the control that the kernel knows.
pub(super) fn system(host: &dyn InterpreterHost, name: &str) -> Option<f64> {
    if let Some(number) = name.strip_prefix("VPBR") {
        return matches!(number.as_bytes(), [b'1'..=b'9']).then_some(0.0);
    }
    let axis = name.strip_prefix("VSIO").or_else(|| name.strip_prefix("VAPA"))?;
    let is = |name: &str| name == axis || name.trim_end_matches(|c: char| c.is_ascii_digit()) == axis;
    host.positions().into_iter().find(|(name, ..)| is(name)).map(|(_, work, _)| work)
}
