//! The interface of an interpreter to its kernel, by concern.
//!
//! Facts: reference control-emulator.md 4.3 (identification), 5.4, 5.7. *Invariants:* what other channels can see goes
//! through [`Values`], in order of simulated time; a jump back and a call are counted by the kernel, so that endless
//! loops come to a limit; nothing here reads a clock or a file system.

mod coordination;
mod flow;
mod frames;
mod programs;
mod report;
mod values;
mod words;

pub use coordination::{Coordination, Operands, Signal};
pub use flow::{Call, Flow, Loops, Shape};
pub use frames::{AxisPlace, Frames, Modes};
pub use programs::{Place, Programs};
pub use report::Report;
pub use values::{Answer, NotThere, Values};
pub use words::{MadeWord, Words};

/// All that an interpreter can ask of its kernel.
pub trait Host: Programs + Flow + Values + Words + Frames + Report + Coordination {}

impl<T: Programs + Flow + Values + Words + Frames + Report + Coordination> Host for T {}
