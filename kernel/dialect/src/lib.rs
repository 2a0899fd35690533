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
pub use counterpoint_program::search::LabelSearchOrder;
pub use definition::{Dialect, Unknown};
pub use host::{
    AxisPlace, Coordination, FlowHost, FrameHost, IdentificationAnswer, LoopStack, MadeWord, ModalSnapshot, NO_OFFSET,
    NamedContour, NotThere, Operands, ProgramHost, ProgramPlace, ReportHost, Signal, SubprogramCall, ValueHost,
    WordHost,
};
pub use interpreter::{CycleWord, Interpreter, MacroCall, MadeBlocks, Remaining, SettingOutcome};
pub use numeric::{VACANT, is_vacant};
pub use outline::{
    CallOutline, JumpDestination, NamedStatement, OutlineReader, OutlineStep, SignalOp, Signalled, StatementArgument,
    sequence,
};
pub use table::{all, of};
