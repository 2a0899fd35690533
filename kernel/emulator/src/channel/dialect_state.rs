//! The dialect of a channel, with its memory.
//!
//! *Invariant:* `interpreter` is taken out only while the interpreter runs.

use super::cycle_moves::KnownMoves;
use counterpoint_channel::channel_variables::ChannelVariables;
use counterpoint_control_api::{Dialect, Interpreter, MadeBlocks};
use counterpoint_machine::Machine;
use counterpoint_program::kept_words::LeftWords;

/// The dialect of a channel.
pub struct DialectState {
    /// The kind of dialect.
    pub kind: &'static dyn Dialect,
    /// Numbered variables.
    pub variables: ChannelVariables,
    /// Interpreter of statements other than plain words; it is `None` while it runs.
    pub interpreter: Option<Box<dyn Interpreter>>,
    /// Programs that the interpreter has read are out of date; the interpreter is notified when it is put back.
    pub(crate) is_stale: bool,
    /// Blocks of the current cycle; between cycles only their memory is kept.
    pub(crate) cycle_blocks: MadeBlocks,
    /// Blocks of cycles that are straight moves, by their words.
    pub(crate) cycle_moves: KnownMoves,
    /// Words that the interpreter leaves to the next stages.
    pub left: LeftWords,
}

impl DialectState {
    /// The dialect of a machine, with its interpreter if it `executes`.
    pub fn new(machine: &Machine, executes: bool) -> Self {
        let kind = counterpoint_controls::of(machine);
        Self {
            kind,
            variables: ChannelVariables::new(&machine.variables),
            interpreter: if executes { kind.interpreter(machine) } else { None },
            is_stale: false,
            cycle_blocks: MadeBlocks::default(),
            cycle_moves: KnownMoves::default(),
            left: LeftWords::default(),
        }
    }
}
