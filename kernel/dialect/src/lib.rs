//! Dialects: conversion of a program line with variables and statements into plain words, for each control.
//!
//! Facts: reference control-emulator.md 5.4. `definition` defines a dialect, `table` names all of them, and `host` is
//! the view that their interpreters have of the kernel. An [`Interpreter`] gets the text of a block that is more than
//! plain words and leaves words. *Invariants:* an interpreter reaches its kernel only through `Host`; the
//! folders of the controls use the shared modules (`expression`, `call_stack`, `contour`, `numeric`, `text`,
//! `words`) and never each other.

mod call_stack;
mod contour;
mod definition;
mod expression;
mod fanuc;
mod heidenhain;
mod host;
mod interpreter;
mod isg;
mod numeric;
mod okuma;
mod open_loops;
pub mod outline;
mod plain;
mod siemens;
mod statement;
mod table;
mod text;
mod words;

pub use call_stack::{Aside, CallStack};
pub use counterpoint_program::search::Search;
pub use definition::{Dialect, Unknown};
pub use host::{
    Answer, AxisPlace, Call, Coordination, Flow, Frames, Loops, MadeWord, Modes, NO_OFFSET, NotThere, Operands, Place,
    Programs, Report, Shape, Signal, Values, Words,
};
pub use interpreter::{CycleWord, Interpreter, MacroCall, MadeBlocks, Remaining, Setting};
pub use numeric::{VACANT, is_vacant};
pub use outline::{Argument, Called, Deed, Goal, Named, Reader, Signalled, Step, sequence};
pub use table::{all, of};
