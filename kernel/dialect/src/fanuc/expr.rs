//! Expressions as postfix code over a small stack.
//!
//! Invariant: evaluation of a compiled expression cannot underflow its stack; a vacant value is one special NaN
//! that counts as zero in arithmetic and equals only itself. Functions come from `libm`, so that every machine gives
//! the same bits.

use counterpoint_fault::Halt;

pub(super) use crate::numeric::is_vacant;
use crate::numeric::{DEGREES, Function};

/// The value in arithmetic: vacant is zero.
pub(super) fn number(value: f64) -> f64 {
    if is_vacant(value) { 0.0 } else { value }
}

/// Why an expression has no value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum Fault {
    #[error("division by zero")]
    Division,
    #[error("the value is beyond the range of numbers")]
    Overflow,
    #[error("{0} of {1} is not defined")]
    Domain(&'static str, f64),
    #[error("there is no variable #{0}")]
    NoVariable(f64),
    #[error("variable #{0} cannot be written")]
    ReadOnly(u32),
    /// The identification macro wants the text to stay on the block.
    #[error("there is no variable #{0}")]
    Kept(u32),
    /// The same for the text of a function.
    #[error("there is no function {0}")]
    KeptFunction(String),
    #[error("there is no function {0}")]
    NoFunction(String),
    /// The kernel leaves its program.
    #[error("the program ends")]
    Halt(Halt),
}

impl From<Halt> for Fault {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

/// Access to variables.
pub(super) trait Variables {
    /// Value of `#index`, [`VACANT`] when it has none.
    fn get(&mut self, index: u32) -> Result<f64, Fault>;

    /// Value of a function that the control does not have, by the place of its text in the block.
    fn unknown_function(&mut self, span: (u32, u32)) -> Result<f64, Fault> {
        Err(Fault::NoFunction(format!("at column {}", span.0 + 1)))
    }

    /// Steps of one unit that ROUND rounds to: 1 in statements, those of the address after an address.
    fn steps(&self) -> f64 {
        1.0
    }
}

/// Postfix operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Op {
    Number(f64),
    /// `#n` with a fixed number.
    Variable(u32),
    /// `#` of the value on the stack.
    Indirect,
    /// `NAME[…]` that the control does not have: the place of its text in the block.
    Unknown(u32, u32),
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Neg,
    And,
    Or,
    Xor,
    /// `&&`: both are other than zero.
    Both,
    /// `||`: one of them is.
    Either,
    Eq,
    Ne,
    Gt,
    Ge,
    Lt,
    Le,
    Apply(Function),
    Atan2,
    Round,
}

/// A compiled expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Expr {
    pub(super) ops: Vec<Op>,
}

/// Deepest stack a compiled expression may need.
pub(super) const STACK: usize = 64;

impl Expr {
    /// A constant.
    pub(super) fn constant(value: f64) -> Self {
        Self { ops: vec![Op::Number(value)] }
    }

    /// The constant value, if it is one.
    pub(super) fn as_constant(&self) -> Option<f64> {
        match self.ops.as_slice() {
            [Op::Number(value)] => Some(*value),
            _ => None,
        }
    }

    /// Value.
    ///
    /// # Errors
    /// [`Fault`] of the first operation without a result.
    pub(super) fn eval(&self, variables: &mut impl Variables) -> Result<f64, Fault> {
        let mut stack = [0.0_f64; STACK];
        let mut top = 0_usize;
        for op in &self.ops {
            match op {
                Op::Number(value) => push(&mut stack, &mut top, *value),
                Op::Variable(index) => push(&mut stack, &mut top, variables.get(*index)?),
                Op::Indirect => {
                    let index = number(pop(&stack, &mut top));
                    push(&mut stack, &mut top, variables.get(variable_index(index)?)?);
                }
                Op::Unknown(start, end) => push(&mut stack, &mut top, variables.unknown_function((*start, *end))?),
                Op::Round => {
                    let value = number(pop(&stack, &mut top));
                    push(&mut stack, &mut top, to_step(value, variables.steps()));
                }
                Op::Neg => {
                    let value = number(pop(&stack, &mut top));
                    push(&mut stack, &mut top, -value);
                }
                Op::Apply(function) => {
                    let value = number(pop(&stack, &mut top));
                    let applied = function.value(value).ok_or(Fault::Domain(function.name(), value))?;
                    push(&mut stack, &mut top, applied);
                }
                op => {
                    let right = pop(&stack, &mut top);
                    let left = pop(&stack, &mut top);
                    push(&mut stack, &mut top, binary(*op, left, right)?);
                }
            }
        }
        let value = pop(&stack, &mut top);
        if value.is_finite() || is_vacant(value) { Ok(value) } else { Err(Fault::Overflow) }
    }
}

fn push(stack: &mut [f64; STACK], top: &mut usize, value: f64) {
    if let Some(slot) = stack.get_mut(*top) {
        *slot = value;
        *top += 1;
    }
}

fn pop(stack: &[f64; STACK], top: &mut usize) -> f64 {
    *top = top.saturating_sub(1);
    stack.get(*top).copied().unwrap_or(0.0)
}

/// A value rounded to the nearest of so many steps of one unit, halves away from zero.
pub(super) fn to_step(value: f64, steps: f64) -> f64 {
    let rounded = (value * steps).round() / steps;
    if rounded.is_finite() { rounded } else { value }
}

/// Index of a variable from a value, which is rounded to a whole number.
pub(super) fn variable_index(value: f64) -> Result<u32, Fault> {
    let index = value.round();
    if (0.0..=f64::from(u32::MAX)).contains(&index) { Ok(index as u32) } else { Err(Fault::NoVariable(value)) }
}

fn binary(op: Op, left: f64, right: f64) -> Result<f64, Fault> {
    let truth = |b: bool| if b { 1.0 } else { 0.0 };
    let (a, b) = (number(left), number(right));
    Ok(match op {
        // Vacant equals only vacant (reference channel-synchronisation.md 2.4, last rule).
        Op::Eq if is_vacant(left) || is_vacant(right) => truth(is_vacant(left) && is_vacant(right)),
        Op::Ne if is_vacant(left) || is_vacant(right) => truth(is_vacant(left) != is_vacant(right)),
        Op::Eq => truth(a == b),
        Op::Ne => truth(a != b),
        Op::Gt => truth(a > b),
        Op::Ge => truth(a >= b),
        Op::Lt => truth(a < b),
        Op::Le => truth(a <= b),
        Op::Add => a + b,
        Op::Sub => a - b,
        Op::Mul => a * b,
        Op::Div if b == 0.0 => return Err(Fault::Division),
        Op::Div => a / b,
        // Of whole numbers, with the sign of the dividend.
        Op::Mod if b.round() == 0.0 => return Err(Fault::Division),
        Op::Mod => a.round() % b.round() + 0.0,
        Op::And => ((a as i64) & (b as i64)) as f64,
        Op::Or => ((a as i64) | (b as i64)) as f64,
        Op::Both => truth(a != 0.0 && b != 0.0),
        Op::Either => truth(a != 0.0 || b != 0.0),
        Op::Xor => ((a as i64) ^ (b as i64)) as f64,
        Op::Atan2 => libm::atan2(a, b) * DEGREES,
        _ => a,
    })
}
