//! The interface of an interpreter to its kernel, by concern.
//!
//! Facts: reference control-emulator.md 4.3 (identification), 5.4, 5.7. *Invariants:* data that other channels can see
//! go through [`Values`], in order of simulated time; the kernel counts jumps back and calls, so that endless loops
//! reach a limit; nothing here reads a clock or a file system.

mod coordination;
mod flow;
mod frames;
mod programs;
mod report;
mod values;
mod words;

pub use coordination::{Coordination, Operands, Signal};
pub use flow::{Call, Flow, Loops, Shape};
pub use frames::{AxisPlace, Frames, Modes, NO_OFFSET};
pub use programs::{Place, Programs};
pub use report::Report;
pub use values::{Answer, NotThere, Values};
pub use words::{MadeWord, Words};

/// All requests of an interpreter to its kernel.
pub trait Host: Programs + Flow + Values + Words + Frames + Report + Coordination {}

impl<T: Programs + Flow + Values + Words + Frames + Report + Coordination> Host for T {}
