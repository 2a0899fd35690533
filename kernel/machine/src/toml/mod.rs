//! TOML with places, through which the loader reads machine files.
//!
//! Invariant: this module knows nothing of machines, and every value carries the file, line and column where it was
//! written, also after a family and a machine have been merged.

pub(super) mod check;
pub(super) mod merge;
pub(super) mod node;
pub(super) mod parse;
pub(super) mod section;
pub(super) mod suggest;
