//! Values of expressions.
//!
//! Invariant: a vacant value counts as zero in arithmetic and equals only itself.

use counterpoint_fault::Halt;

use counterpoint_control_api::expression::{self, CompiledExpression, Evaluate, Stack};
pub(super) use counterpoint_control_api::numeric::is_vacant;
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator, truth};

/// The value in arithmetic: vacant is zero.
#[inline]
pub(super) fn number(value: f64) -> f64 {
    if is_vacant(value) { 0.0 } else { value }
}

/// Why an expression has no value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum FanucValueError {
    #[error("division by zero")]
    Division,
    #[error("the value is out of range")]
    Overflow,
    #[error("{0} of {1} is not defined")]
    Domain(&'static str, f64),
    #[error("variable #{0} does not exist")]
    NoVariable(f64),
    #[error("the value is not possible for variable #{0}")]
    TooBig(u32),
    #[error("variable #{0} cannot be written")]
    ReadOnly(u32),
    /// The identification macro wants the text to stay in the block.
    #[error("variable #{0} does not exist")]
    Kept(u32),
    /// The same for the text of a function.
    #[error("function {0} does not exist")]
    KeptFunction(String),
    #[error("function {0} does not exist")]
    NoFunction(String),
    /// The kernel leaves its program.
    #[error("the program ends")]
    Halt(Halt),
}

impl From<Halt> for FanucValueError {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

/// Access to variables.
pub(super) trait VariableAccess {
    /// Value of `#index`, [`VACANT`] when it has none.
    fn get(&mut self, index: u32) -> Result<f64, FanucValueError>;

    /// Value of a function that the control does not have, by the place of its text in the block.
    fn unknown_function(&mut self, span: (u32, u32)) -> Result<f64, FanucValueError> {
        Err(FanucValueError::NoFunction(format!("at column {}", span.0 + 1)))
    }

    /// Steps of one unit that ROUND rounds to: 1 in statements, those of the address after an address.
    fn steps(&self) -> f64 {
        1.0
    }
}

/// An operation that only this control has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FanucOp {
    /// `#n` with a fixed number.
    Variable(u32),
    /// `#` of the value on the stack.
    Indirect,
    /// `NAME[…]` that the control does not have: the place of its text in the block.
    Unknown(u32, u32),
    /// ROUND, which depends on where the expression is.
    Round,
    /// Minus sign after an address. It belongs to the reference: if the variable has no value, the word is ignored.
    Minus,
}

pub(super) type Op = expression::ExpressionOp<f64, FanucOp>;

/// A compiled expression.
pub(super) type Expr = CompiledExpression<f64, FanucOp>;

/// Most values that may wait for their operator.
pub(super) const STACK: usize = 64;

/// Value of an expression.
///
/// # Errors
/// [`FanucValueError`] of the first operation without a result.
pub(super) fn value(expr: &Expr, variables: &mut impl VariableAccess) -> Result<f64, FanucValueError> {
    let value = FanucEvaluator(variables).evaluate(expr)?;
    if value.is_finite() || is_vacant(value) { Ok(value) } else { Err(FanucValueError::Overflow) }
}

/// The variables as values of expressions.
struct FanucEvaluator<'v, V>(&'v mut V);

impl<V: VariableAccess> Evaluate<f64, FanucOp> for FanucEvaluator<'_, V> {
    type Stop = FanucValueError;

    fn own(&mut self, own: &FanucOp, stack: &mut Stack<f64>) -> Result<f64, FanucValueError> {
        match own {
            FanucOp::Variable(index) => self.0.get(*index),
            FanucOp::Indirect => self.0.get(variable_index(number(stack.pop()))?),
            FanucOp::Unknown(start, end) => self.0.unknown_function((*start, *end)),
            FanucOp::Minus => {
                let value = stack.pop();
                Ok(if is_vacant(value) { value } else { -value })
            }
            FanucOp::Round => Ok(to_step(number(stack.pop()), self.0.steps())),
        }
    }

    fn apply(&mut self, function: NumericFunction, value: f64) -> Result<f64, FanucValueError> {
        let value = number(value);
        function.value(value).ok_or_else(|| FanucValueError::Domain(function.name(), value))
    }

    fn combine(&mut self, operator: NumericOperator, left: f64, right: f64) -> Result<f64, FanucValueError> {
        // Vacant equals only vacant (reference channel-synchronisation.md 2.4, last rule).
        match operator {
            NumericOperator::Eq if is_vacant(left) || is_vacant(right) => {
                Ok(truth(is_vacant(left) && is_vacant(right)))
            }
            NumericOperator::Ne if is_vacant(left) || is_vacant(right) => {
                Ok(truth(is_vacant(left) != is_vacant(right)))
            }
            operator => match operator.value(number(left), number(right)) {
                Some(value) => Ok(value),
                None => Err(FanucValueError::Division),
            },
        }
    }
}

/// A value rounded to the nearest of this many steps of one unit, halves away from zero.
pub(super) fn to_step(value: f64, steps: f64) -> f64 {
    let rounded = (value * steps).round() / steps;
    if rounded.is_finite() { rounded } else { value }
}

/// Index of a variable from a value, which is rounded to a whole number.
pub(super) fn variable_index(value: f64) -> Result<u32, FanucValueError> {
    let index = value.round();
    if (0.0..=f64::from(u32::MAX)).contains(&index) {
        Ok(index as u32)
    } else {
        Err(FanucValueError::NoVariable(value))
    }
}
