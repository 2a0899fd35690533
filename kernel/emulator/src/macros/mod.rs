//! The memory of the macros of a running kernel.
//!
//! *Invariant:* state with methods of its own; none of it knows the kernel.

mod asked;
pub(crate) mod books;
pub(crate) mod calls;
pub(crate) mod hooks;
pub(crate) mod issued;
pub mod parts;
pub(crate) mod reused;
pub mod runtime;
pub(crate) mod settings;
pub mod store;
pub(crate) mod tool_table;
pub(crate) mod values;

pub use calls::STACK;
