//! Macros of a running kernel.

mod asked;
pub(crate) mod host;
pub(crate) mod reused;
pub(crate) mod runtime;

pub(crate) use runtime::STACK;
