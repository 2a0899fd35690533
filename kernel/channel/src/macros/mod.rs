//! The memory of the macros of a running kernel.
//!
//! *Invariant:* state with methods of its own; none of it knows the kernel.

pub mod asked;
pub mod books;
pub mod calls;
pub mod hooks;
pub mod issued;
pub mod parts;
pub mod reused;
pub mod runtime;
pub mod settings;
pub mod store;
pub mod tool_table;
pub mod values;

pub use calls::STACK;
