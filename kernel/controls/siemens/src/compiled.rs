//! Expressions in compiled form, with the names and arguments in them.

use counterpoint_control_api::expression;
use counterpoint_control_api::expression::CompiledExpression;

use super::value::Data;
use super::variable_store::MOST_PARAMETERS;

/// An operation that only this control has.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SiemensOp {
    /// A variable, an axis, a system variable.
    Name(IndexedName),
    /// A function by its name, with its arguments.
    Call(String, Vec<SiemensArgument>),
}

pub(super) type Op = expression::ExpressionOp<Data, SiemensOp>;

/// An expression.
pub(super) type Expression = CompiledExpression<Data, SiemensOp>;

/// The name that an expression consists of.
pub(super) fn as_name(expression: &Expression) -> Option<&IndexedName> {
    match expression.as_own() {
        Some(SiemensOp::Name(name)) => Some(name),
        _ => None,
    }
}

/// A name in capital letters with its indices; `R5` is `R` with the index 5.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct IndexedName {
    pub(super) name: String,
    pub(super) index: Vec<Expression>,
}

impl IndexedName {
    /// Number of the R parameter that it is, as written.
    #[inline]
    pub(super) fn parameter(&self) -> Option<u32> {
        match (self.name.as_bytes(), self.index.as_slice()) {
            (b"R", [index]) => match index.as_constant() {
                Some(Data::Int(number @ 0..=MOST_PARAMETERS)) => Some(*number as u32),
                _ => None,
            },
            _ => None,
        }
    }
}

/// An argument as it is written, and as an expression if it is one; both empty if it was left out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SiemensArgument {
    pub(super) text: String,
    pub(super) value: Result<Option<Expression>, String>,
}
