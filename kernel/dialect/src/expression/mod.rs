//! Expressions of all dialects: one compiled form, one reader of operators, one evaluator.
//!
//! A dialect gives the words of its operators as a table, how operands are written, and what its variables and functions of its
//! own mean. `read` compiles a text, `evaluate` gives its value. *Invariant:* code leaves exactly one value on the stack.

mod code;
mod evaluate;
mod read;

pub(super) use code::{Code, Op};
pub(super) use evaluate::{Evaluate, Stack};
pub(super) use read::{COMPARISONS, Grammar, Operators, Part, Sign, read, signed};
