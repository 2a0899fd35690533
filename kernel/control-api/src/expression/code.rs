//! The compiled form of an expression: operations in postfix order.
//!
//! *Invariant:* operations are in the order in which the program wrote their operands, so evaluation requests values in
//! that order.

use crate::numeric::{NumericFunction, NumericOperator};

/// An operation: `V` is a value, `X` an operand that only the dialect has, such as a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExpressionOp<V, X> {
    /// A constant.
    Value(V),
    /// A function of one value.
    Apply(NumericFunction),
    /// An operator between two values.
    Combine(NumericOperator),
    /// An operator between a value and a constant, which [`CompiledExpression::new`] makes of both.
    CombineWith(NumericOperator, V),
    /// An operation of the dialect.
    Own(X),
}

/// A compiled expression.
#[derive(Debug, Clone, PartialEq)]
pub struct CompiledExpression<V, X> {
    ops: Box<[ExpressionOp<V, X>]>,
}

impl<V, X> CompiledExpression<V, X> {
    /// From operations that leave one value.
    pub fn new(ops: Vec<ExpressionOp<V, X>>) -> Self {
        let mut out: Vec<ExpressionOp<V, X>> = Vec::with_capacity(ops.len());
        for op in ops {
            match (op, out.pop()) {
                (ExpressionOp::Combine(operator), Some(ExpressionOp::Value(right))) => {
                    out.push(ExpressionOp::CombineWith(operator, right))
                }
                (op, before) => out.extend(before.into_iter().chain([op])),
            }
        }
        Self { ops: out.into() }
    }

    /// A constant.
    pub fn constant(value: V) -> Self {
        Self::new(vec![ExpressionOp::Value(value)])
    }

    /// One operation of the dialect, without operands.
    pub fn own(own: X) -> Self {
        Self::new(vec![ExpressionOp::Own(own)])
    }

    /// Its operations.
    pub fn ops(&self) -> &[ExpressionOp<V, X>] {
        &self.ops
    }

    /// The same, to be made part of another expression.
    pub fn into_ops(self) -> Vec<ExpressionOp<V, X>> {
        self.ops.into_vec()
    }

    /// Its value, if it is a constant.
    pub fn as_constant(&self) -> Option<&V> {
        match &*self.ops {
            [ExpressionOp::Value(value)] => Some(value),
            _ => None,
        }
    }

    /// The operation of the dialect that it consists of, as a variable alone.
    pub fn as_own(&self) -> Option<&X> {
        match &*self.ops {
            [ExpressionOp::Own(own)] => Some(own),
            _ => None,
        }
    }
}
