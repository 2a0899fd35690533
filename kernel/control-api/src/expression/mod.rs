//! Expressions of all dialects: one compiled form, one reader of operators, one evaluator.
//!
//! A dialect supplies the words of its operators as a table, the form of operands, and the meaning of its own variables
//! and functions. `read` compiles a text, `evaluate` gives its value. *Invariant:* code leaves exactly one value on the
//! stack.

mod code;
mod evaluate;
mod read;

pub use code::{CompiledExpression, ExpressionOp};
pub use evaluate::{Evaluate, Stack};
pub use read::{COMPARISONS, ExpressionPart, Grammar, Operators, PrefixOperator, read, signed};
