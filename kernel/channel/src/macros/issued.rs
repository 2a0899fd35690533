//! Blocks that macros issue.

use std::collections::VecDeque;
use std::sync::Arc;

use counterpoint_lang::value::MacroValue;

use counterpoint_program::block::Block;

/// Blocks that EXEC/NEXT may leave waiting.
pub const MOST_QUEUED: usize = 10_000;

/// A block that EXEC/NEXT left for later.
#[derive(Debug, Clone)]
pub enum Later {
    /// Text, and whether macros match.
    Text(Arc<String>, bool),
    /// Identifiers with values.
    Items(Arc<[MacroValue]>, bool),
}

/// Blocks that macros have issued.
#[derive(Debug, Default)]
pub struct Issued {
    /// Blocks left for later.
    pub later: VecDeque<Later>,
    /// Blocks for nested processing.
    pub spares: Vec<Block>,
}
