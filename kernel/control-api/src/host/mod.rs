//! The interface of an interpreter to its kernel, by concern.
//!
//! Facts: reference control-emulator.md 4.3 (identification), 5.4, 5.7. *Invariants:* data that other channels can see
//! go through [`ValueHost`], in order of simulated time; the kernel counts jumps back and calls, so that endless loops
//! reach a limit; nothing here reads a clock or a file system.

mod coordination;
mod flow;
mod frames;
mod programs;
mod report;
mod values;
mod words;

pub use coordination::{Coordination, Operands, Signal};
pub use flow::{FlowHost, LoopStack, NamedContour, SubprogramCall};
pub use frames::{AxisPlace, FrameHost, ModalSnapshot, NO_OFFSET};
pub use programs::{ProgramHost, ProgramPlace};
pub use report::ReportHost;
pub use values::{IdentificationAnswer, NotThere, ValueHost};
pub use words::{MadeWord, WordHost};

/// All requests of an interpreter to its kernel.
pub trait InterpreterHost:
    ProgramHost + FlowHost + ValueHost + WordHost + FrameHost + ReportHost + Coordination
{
}

impl<T: ProgramHost + FlowHost + ValueHost + WordHost + FrameHost + ReportHost + Coordination> InterpreterHost for T {}
