//! Runs the macros of a machine: a kernel is their host, and calls them at points of its work.
//!
//! *Invariant:* the kernel reaches this crate only through [`hooks::POINTS`] of its plan; a kernel without macros never
//! calls this crate.

mod context;
pub mod hooks;
mod host;

use std::sync::Arc;

use counterpoint_emulator::channel::Kernel;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::compile::MacroProgram;
use counterpoint_machine::macros::model::Hook;

use context::{KernelHost, MacroHooks};

/// Gives a kernel the macros of its machine; does nothing without a program.
pub fn set_up(kernel: &mut Kernel<'_>, program: Option<&Arc<MacroProgram>>) {
    MacroHooks::new(kernel).set_up_macros(program);
}

/// Runs a macro without arguments if it is on.
///
/// # Errors
/// The macro made the kernel leave its program.
pub fn run(kernel: &mut Kernel<'_>, hook: Hook) -> Acted {
    MacroHooks::new(kernel).plain_macro(hook)
}

/// Closes the units that are open at the end of a kernel, and removes its temporary files.
pub fn close_files(kernel: &mut Kernel<'_>, halt: Halt) {
    KernelHost::new(kernel).close_files(halt);
}

/// Channel of the model that a kernel starts on, as Machine Startup has set it.
pub fn model_channel(kernel: &Kernel<'_>, at: i64) -> f64 {
    host::channel_of(kernel, at)
}

/// Tells a kernel the program, the name and the channel of the model of another kernel.
pub fn set_program_of(kernel: &mut Kernel<'_>, at: i64, program: &str, name: &str, channel: f64) {
    host::set_program_of(&mut KernelHost::new(kernel), at, program, name, channel);
}
