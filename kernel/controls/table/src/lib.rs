//! The table of the controls: every pre-processor that a machine definition can name, with its dialect.
//!
//! *Invariant:* only this crate knows which controls exist; a control knows none of the others.

mod plain;
mod table;

pub use table::{all, of};
