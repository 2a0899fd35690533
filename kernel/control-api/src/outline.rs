//! The effect of a block on the flow of its program and on other channels, as far as its text shows: for checks that
//! execute nothing.
//!
//! A control reads its blocks with the same reader as its interpreter. *Invariants:* nothing is executed and no
//! variable has a value. Effects that only a run could determine are marked as such ([`JumpDestination::Computed`],
//! [`OutlineStep::Computed`], [`OutlineStep::Hidden`]).

use counterpoint_event::FileId;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;

use crate::LabelSearchOrder;
use crate::host::{ProgramHost, Signal};

/// Reads blocks without executing them.
pub trait OutlineReader {
    /// Effects of a block that is more than plain words, in the order of its text.
    fn outline(&mut self, programs: &mut dyn ProgramHost, text: &[u8]) -> Vec<OutlineStep>;
}

/// An effect of a block.
#[derive(Debug, Clone, PartialEq)]
pub enum OutlineStep {
    /// Words for the tables of the machine.
    Words(Vec<u8>),
    /// A word with this address has a value that is computed.
    Computed(String),
    /// A name with arguments, which may be a statement between channels, a code of the machine or a call.
    Named(NamedStatement),
    /// A statement of signals.
    Signal(Signalled),
    /// A jump in any case.
    Jump(JumpDestination),
    /// A jump that depends on a condition.
    Branch(JumpDestination),
    /// A branch or, if it `loops`, a loop.
    Block {
        /// The block up to which it goes.
        end: BlockStart,
        /// It may run again.
        loops: bool,
    },
    /// A call of a program.
    Call(CallOutline),
    /// A return.
    Return,
    /// The rest of the block, which depends on a condition.
    If(Vec<OutlineStep>),
    /// Steps of each following block that moves.
    Modal(Vec<OutlineStep>),
    /// The program raises an alarm of its own.
    Alarm,
    /// It may do anything, for this reason.
    Hidden(String),
    /// The control cannot read it.
    Mistake(String),
}

/// Where a jump leads.
#[derive(Debug, Clone, PartialEq)]
pub enum JumpDestination {
    /// To this block.
    At(BlockStart),
    /// There is no such block.
    Missing(String),
    /// The block is computed.
    Computed,
}

/// A name with arguments.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedStatement {
    /// In capitals.
    pub name: String,
    /// Its arguments.
    pub arguments: Vec<StatementArgument>,
    /// The program of this name, or the program that an argument names.
    pub program: Option<(FileId, ProgramRange)>,
    /// Passes if it is a call; none if they are computed.
    pub passes: Option<u32>,
}

/// An argument of a statement.
#[derive(Debug, Clone, PartialEq)]
pub enum StatementArgument {
    /// A number.
    Number(f64),
    /// A name alone.
    Name(String),
    /// A text.
    Text(String),
    /// Anything else.
    Computed,
}

/// The effect of a statement of signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalOp {
    /// Sends.
    Send,
    /// Waits.
    Wait,
    /// Takes a signal if it is there.
    Read,
    /// Removes signals.
    Remove,
}

/// A statement of signals.
#[derive(Debug, Clone, PartialEq)]
pub struct Signalled {
    /// Its effect.
    pub deed: SignalOp,
    /// Name of its row in the machine.
    pub row: &'static str,
    /// The signal; none if a part of it is computed.
    pub signal: Option<Signal>,
}

/// A call.
#[derive(Debug, Clone, PartialEq)]
pub struct CallOutline {
    /// The callee, for messages.
    pub name: String,
    /// Where it is; none if there is no such program.
    pub place: Option<(FileId, ProgramRange)>,
    /// How often it runs; none if that is computed.
    pub passes: Option<u32>,
}

/// The block with a sequence number, as jumps look for it: onwards, then from the top of the program.
#[must_use]
pub fn sequence(programs: &dyn ProgramHost, number: f64) -> JumpDestination {
    let (place, here) = (programs.place(), programs.spot());
    let missing = || JumpDestination::Missing(format!("block N{number}"));
    if number.fract() != 0.0 || !(1.0..=f64::from(u32::MAX)).contains(&number) {
        return missing();
    }
    let Some(source) = programs.source(place.file) else { return missing() };
    let next = BlockStart { line: here.line, offset: here.offset.saturating_add(1) };
    let around = (BlockStart::line(place.range.first), BlockStart { line: place.range.last, offset: u32::MAX });
    LabelSearchOrder::Around
        .find(source.sequences(number as u32), next, around)
        .map_or_else(missing, JumpDestination::At)
}
