//! State of the program flow: the running programs, the requests of the block for its end, labels and loops.
//!
//! Facts: reference control-emulator.md 5.7. *Invariant:* plain data; the stage `pipeline/follow` acts on it.

use std::sync::Arc;

use counterpoint_control_api as dialect;
use counterpoint_event::event::{FileId, Position, SourcePlace};
use counterpoint_program::block::Block;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;
use rustc_hash::FxHashMap;

use crate::callee::{Callee, Labels, Pending, Printing};
use crate::calling_words::{CodeMacro, WordKind};
use crate::figure::CopiedFigure;
use crate::kept_blocks::KnownBlocks;
use crate::loop_tracker::LoopTracker;
use crate::modal_calls::{ModalCall, ModalCalls};

/// One running program text.
#[derive(Debug, Clone)]
pub struct RunningProgram {
    /// File of the program.
    pub file: FileId,
    /// Where the user's program called it, if the text is a resident program.
    pub caller: SourcePlace,
    /// The program in its file.
    pub range: ProgramRange,
    /// Next line to read.
    pub next: u32,
    /// Byte in that line where the next block begins; above 0 after a character that ends blocks.
    pub offset: u32,
    /// Further passes after this one.
    pub repeats: u32,
    /// The end of its text is its return (a range call).
    pub closes: bool,
    /// It has variables of its own (a macro call).
    pub own_variables: bool,
    /// The callee.
    pub called: CallRecord,
    /// The modal call that called it.
    pub modal: Option<usize>,
    /// Kind of the word that called it; a call of another form has none.
    pub by: Option<WordKind>,
    /// Name for events.
    pub name: Arc<str>,
    /// Where the tool goes at its end, as programmed (a finishing cycle), and the axes that go first, bit by axis.
    pub back: Option<Box<(Position, u8)>>,
    /// Each pass is a copy of the figure.
    pub figure: Option<Box<CopiedFigure>>,
}

/// Program flow of a channel.
#[derive(Debug, Default)]
pub struct ProgramFlow {
    /// The main program and the subprograms that it has called.
    pub frames: Vec<RunningProgram>,
    /// Request of the block, carried out at its end.
    pub pending: Option<Pending>,
    /// The macro that a code of the block calls.
    pub code_macro: Option<Box<CodeMacro>>,
    /// Macros that blocks call without saying so.
    pub modal: ModalCalls,
    /// The pre-processor of another control calls after blocks that move.
    pub modal_text: bool,
    /// The pass of the loop that runs.
    pub pass: LoopTracker,
    /// Steps go over all blocks while at least this number of programs run; none if no program hides its blocks.
    pub hidden_from: Option<usize>,
    /// The program has jumped back or called, so a line may run again.
    pub repeats: bool,
    /// Printing statements.
    pub printing: Printing,
    /// Loops that the programs are in.
    pub loops: dialect::LoopStack,
    /// Byte at which the block being processed begins in its line.
    pub offset: u32,
    /// Places of programs, labels and blocks that were found.
    pub known: FlowCache,
    /// Plain words are for the pre-processor too.
    pub watched: bool,
    /// Definitions run into and texts of no program that have been reported, by file and line.
    pub reported: Vec<(FileId, u32)>,
    /// The rewind-stop that opens the program has been met.
    pub opened: bool,
}

/// Data derived from programs, kept for the next time.
#[derive(Debug, Default)]
pub struct FlowCache {
    /// Names of programs that were called by number.
    pub names: ProgramNameCache,
    /// Where programs that were called by number are.
    pub programs: ProgramLocationCache,
    /// Blocks that only lead on.
    pub blocks: KnownBlocks,
    /// Lines of labels by file and label.
    pub labels: FxHashMap<FileId, Arc<Labels>>,
    /// Bytes of labels.
    pub tables: usize,
}

/// Names of programs by number, as events have them: those that were called last.
#[derive(Debug, Default)]
pub struct ProgramNameCache([Option<(u32, Arc<str>)>; 8]);

impl ProgramNameCache {
    /// The name of a program.
    pub fn of(&mut self, number: u32) -> Arc<str> {
        let name = || Arc::from(format!("O{number:04}"));
        let place = number as usize % self.0.len();
        let Some(slot) = self.0.get_mut(place) else { return name() };
        match slot {
            Some((known, name)) if *known == number => Arc::clone(name),
            _ => Arc::clone(&slot.insert((number, name())).1),
        }
    }
}

/// Where a program is called: its number, the file that calls, and the main program's.
pub type Wanted = (u32, FileId, FileId);

/// Programs by number and by the files from which they were called: those that were called last.
///
/// *Invariant:* the texts of a job do not change, so a program that was found stays where it is.
#[derive(Debug, Default)]
pub struct ProgramLocationCache([Option<(Wanted, (FileId, ProgramRange))>; 8]);

impl ProgramLocationCache {
    /// Where a program was found.
    pub fn get(&self, wanted: Wanted) -> Option<(FileId, ProgramRange)> {
        let (known, found) = (*self.0.get(wanted.0 as usize % self.0.len())?)?;
        (known == wanted).then_some(found)
    }

    /// Keeps where a program is.
    pub fn keep(&mut self, wanted: Wanted, found: (FileId, ProgramRange)) {
        let place = wanted.0 as usize % self.0.len();
        if let Some(slot) = self.0.get_mut(place) {
            *slot = Some((wanted, found));
        }
    }
}

impl ProgramFlow {
    /// The frame being executed.
    pub fn frame(&mut self) -> Option<&mut RunningProgram> {
        self.frames.last_mut()
    }

    /// The callee, as events name it.
    pub fn name_of(&mut self, what: &Callee) -> Arc<str> {
        match what {
            Callee::Program(number) | Callee::ProgramFrom(number, _) => self.known.names.of(*number),
            Callee::Named(name) => format!("<{name}>").into(),
            Callee::Labels(first, last) => format!("label {first}-{last}").into(),
            Callee::Blocks(first, last) => format!("N{first}-N{last}").into(),
            Callee::From(first) => format!("N{first}").into(),
        }
    }

    /// Subprograms that are running.
    pub fn level(&self) -> usize {
        self.frames.len().saturating_sub(1)
    }
}

impl RunningProgram {
    /// The block to read next.
    pub fn next_block(&self) -> BlockStart {
        BlockStart { line: self.next, offset: self.offset }
    }

    /// A text from its first block on, once, as the main program.
    pub fn main(file: FileId, range: ProgramRange, name: Arc<str>) -> Self {
        Self {
            file,
            caller: SourcePlace::NONE,
            range,
            next: range.first,
            offset: 0,
            repeats: 0,
            closes: false,
            own_variables: false,
            modal: None,
            called: CallRecord { what: Callee::Program(0), passes: 1, block: None },
            by: None,
            name,
            back: None,
            figure: None,
        }
    }
}

/// The callee, and its total passes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CallRecord {
    /// The subprogram.
    pub what: Callee,
    /// Passes, at least 1.
    pub passes: u32,
    /// The block that calls, on a kernel with macros.
    pub block: Option<Arc<str>>,
}

impl ProgramFlow {
    /// Macro calls that are running.
    pub fn call_level(&self) -> usize {
        self.frames.iter().filter(|frame| frame.own_variables).count()
    }

    /// The modal call that blocks make here.
    pub fn acting_modal(&self) -> Option<usize> {
        let (calls, level) = (&self.modal.calls, self.call_level());
        if let Some(own) = calls.iter().rposition(|call| call.level == level) {
            return Some(own);
        }
        // In a macro that a modal call has called, the modal call before that one calls.
        let caller = self.frames.iter().rev().find(|frame| frame.own_variables)?.modal?;
        let before = caller.checked_sub(1)?;
        (calls.get(before)?.level == calls.get(caller)?.level).then_some(before)
    }

    /// The same, to look at.
    pub fn modal_call(&self) -> Option<&ModalCall> {
        self.modal.calls.get(self.acting_modal()?)
    }

    /// The next call is one that blocks make without saying so.
    pub fn call_is_modal(&mut self) {
        self.modal.calling = self.acting_modal();
    }

    /// Whether the words of a block are the arguments of a modal call.
    #[inline(always)]
    pub fn calls_each_block(&self, block: &Block) -> bool {
        !self.modal.is_empty() && self.is_argument_block(block)
    }

    #[cold]
    fn is_argument_block(&self, block: &Block) -> bool {
        self.modal_call().is_some_and(|call| call.each) && !block.words.is_empty()
    }

    /// Makes the modal call after a block that has moved.
    #[cold]
    pub fn call_modally(&mut self, block: &mut Block) {
        if !block.flags.moved {
            return;
        }
        let Some(call) = self.modal_call().filter(|call| !call.each) else { return };
        let (what, passes) = (call.what.clone(), call.passes);
        let (arguments, by) = (Some(call.arguments.clone()), call.by.map(Box::new));
        self.call_is_modal();
        block.flags.moved = false;
        self.pending = Some(Pending::Call { what, passes, arguments, by });
    }
}
