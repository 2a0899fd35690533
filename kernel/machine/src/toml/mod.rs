//! TOML with places, through which the loader reads machine files.
//!
//! Invariant: nothing here knows what a machine is, and every value carries the file, line and column it was
//! written at, also after a family and a machine have been merged.

pub(super) mod check;
pub(super) mod merge;
pub(super) mod node;
pub(super) mod parse;
pub(super) mod section;
pub(super) mod suggest;
