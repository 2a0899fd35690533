//! One channel of the control: reads its program block by block, executes codes, runs the macros of the machine.
//!
//! A block goes through the stages of `pipeline`; the plan of the machine says which hooks run between them and which
//! action a code has. *Invariant:* arrows between the modules go down only: `hooks` and `action` are reached through
//! the plan, an action sees its channel and the services of `act`, never flow, macros, plan or coordinator.

mod act;
pub mod action;
pub mod channel;
pub mod hooks;
mod host;
mod lint;
mod pipeline;
mod trace;
