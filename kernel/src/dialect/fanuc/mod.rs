//! Fanuc custom macro: variables, expressions, branches and loops.
//!
//! Facts: reference control-emulator.md 5.4 (Fanuc row). Pure: text in, compiled statement out; variables are
//! reached through a trait. Invariant: compiling is linear in the length of the line and never panics; nesting of
//! brackets is limited.

mod compile;
mod control;
mod cursor;
mod expr;
mod formula;
pub(crate) mod loops;
pub(crate) mod print;
mod statement;
mod words;

pub(crate) use compile::compile;
pub(crate) use control::Control;
pub(crate) use expr::{Expr, Fault, VACANT, Variables, is_vacant, number, to_step, variable_index};
pub(crate) use statement::{Item, Line, Name, Statement, TemplateWord};
