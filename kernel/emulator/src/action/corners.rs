//! Codes that say what the corner at the end of their block is.
//!
//! Facts: reference okuma-osp.md (G75, G76). *Invariant:* the corner belongs to the move of its block.

use counterpoint_machine::ident::codes;

use crate::action::cutter;
use crate::action::entry::{Contour, Entry};

/// Codes and what they do.
pub(crate) const ENTRIES: &[Entry] = &[
    Entry::of(&[codes::CORNER_CHAMFER], |act, _, _| cutter::corner_code(act, false)).contour(Contour::Waits),
    Entry::of(&[codes::CORNER_ROUND], |act, _, _| cutter::corner_code(act, true)).contour(Contour::Waits),
];
