//! The interface of the controls: a [`Dialect`] converts a program line with variables and statements into plain words.
//!
//! Facts: reference control-emulator.md 5.4. `definition` defines a dialect, and `host` is the view that interpreters
//! have of the kernel. An [`Interpreter`] gets the text of a block that is more than plain words and leaves words. The
//! other modules are the parts that several controls share. *Invariants:* an interpreter reaches its kernel only through
//! `host`; nothing here belongs to one control.

pub mod call_stack;
pub mod contour;
pub mod definition;
pub mod expression;
pub mod host;
pub mod interpreter;
pub mod numeric;
pub mod open_loops;
pub mod outline;
pub mod statement;
pub mod text;
pub mod words;

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
