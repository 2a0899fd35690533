//! The compiled form of an expression: operations in postfix order.
//!
//! *Invariant:* operations are in the order in which the program wrote their operands, so evaluation requests values in
//! that order.

use crate::numeric::{Function, Operator};

/// An operation: `V` is a value, `X` an operand that only the dialect has, such as a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Op<V, X> {
    /// A constant.
    Value(V),
    /// A function of one value.
    Apply(Function),
    /// An operator between two values.
    Combine(Operator),
    /// An operator between a value and a constant, which [`Code::new`] makes of both.
    CombineWith(Operator, V),
    /// An operation of the dialect.
    Own(X),
}

/// A compiled expression.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Code<V, X> {
    ops: Box<[Op<V, X>]>,
}

impl<V, X> Code<V, X> {
    /// From operations that leave one value.
    pub(crate) fn new(ops: Vec<Op<V, X>>) -> Self {
        let mut out: Vec<Op<V, X>> = Vec::with_capacity(ops.len());
        for op in ops {
            match (op, out.pop()) {
                (Op::Combine(operator), Some(Op::Value(right))) => out.push(Op::CombineWith(operator, right)),
                (op, before) => out.extend(before.into_iter().chain([op])),
            }
        }
        Self { ops: out.into() }
    }

    /// A constant.
    pub(crate) fn constant(value: V) -> Self {
        Self::new(vec![Op::Value(value)])
    }

    /// One operation of the dialect, without operands.
    pub(crate) fn own(own: X) -> Self {
        Self::new(vec![Op::Own(own)])
    }

    /// Its operations.
    pub(crate) fn ops(&self) -> &[Op<V, X>] {
        &self.ops
    }

    /// The same, to be made part of another expression.
    pub(crate) fn into_ops(self) -> Vec<Op<V, X>> {
        self.ops.into_vec()
    }

    /// Its value, if it is a constant.
    pub(crate) fn as_constant(&self) -> Option<&V> {
        match &*self.ops {
            [Op::Value(value)] => Some(value),
            _ => None,
        }
    }

    /// The operation of the dialect that it consists of, as a variable alone.
    pub(crate) fn as_own(&self) -> Option<&X> {
        match &*self.ops {
            [Op::Own(own)] => Some(own),
            _ => None,
        }
    }
}
