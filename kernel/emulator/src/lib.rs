//! One channel of the control: reads its program block by block and executes the statements of its codes.
//!
//! A block goes through the stages of `pipeline`. The plan of the machine says which hooks run between them and which
//! action a code has. *Invariant:* modules depend only on modules below them, and none of them knows the actions,
//! the macro host or the check without a run: the kernel reaches these through the tables of its plan.

pub mod action_context;
pub mod channel;
pub mod pipeline;
