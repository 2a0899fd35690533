//! Where the kernel is, and the texts of its programs.

use std::sync::Arc;

use counterpoint_event::FileId;
use counterpoint_fault::Acted;
use counterpoint_program::key_words::StatementVocabulary;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;
use counterpoint_program::spot::BlockStart;

/// Where a kernel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProgramPlace {
    /// File of the block.
    pub file: FileId,
    /// Its line, from 1.
    pub line: u32,
    /// Lines of the program, or of the called text, that the block belongs to.
    pub range: ProgramRange,
    /// The text of the block is its unchanged line of the file, so the code compiled for the line is valid.
    pub as_read: bool,
    /// The program has jumped back or called, so a line may run again.
    pub repeats: bool,
}

/// Programs and the block in process.
pub trait ProgramHost {
    /// Where the kernel is.
    fn place(&self) -> ProgramPlace;

    /// File and line of the block, when its text is that line and was not changed.
    fn unchanged_line(&self) -> Option<(FileId, u32)>;

    /// Subprograms that are running.
    fn level(&self) -> usize;

    /// Where the block begins.
    fn spot(&self) -> BlockStart;

    /// File and lines of the running program, none before the first one. After a return it is the caller, while
    /// [`ProgramHost::place`] remains that of the block.
    fn program(&self) -> Option<(FileId, ProgramRange)>;

    /// File and lines of the programs that run, the innermost first.
    fn callers(&self) -> Vec<(FileId, ProgramRange)>;

    /// Text of a file that is loaded, as the file of the block is.
    fn source(&self, file: FileId) -> Option<Arc<ProgramSource>>;

    /// Whether blocks of the program may belong to another control: that of another component of a composite machine.
    fn shares_programs(&self) -> bool {
        false
    }

    /// Names of the files of the job and of those stored with the machine (`//ICAMFS/…`), in order of their ids.
    fn files(&self) -> Vec<String>;

    /// Loads a file.
    ///
    /// # Errors
    /// It cannot be read: an alarm.
    fn load(&mut self, file: FileId) -> Acted;

    /// File of the main program.
    fn main_file(&self) -> FileId;

    /// Text of the block for messages.
    fn block_text(&self) -> String;

    /// A part of the text of the block.
    fn part(&self, span: (u32, u32)) -> String;

    /// Copies the text of the block with blanks in place of comments and skipped portions. Returns the places of its
    /// messages, which are displayed if `displays`.
    fn strip(&mut self, text: &[u8], displays: bool, into: &mut Vec<u8>) -> Box<[(u32, u32)]>;

    /// Displays messages of the block that [`ProgramHost::strip`] found when its line was read for the first time.
    fn display_again(&mut self, text: &[u8], messages: &[(u32, u32)]);

    /// Names of words of the block other than letters.
    fn names(&self) -> StatementVocabulary<'_>;

    /// Visits the blocks of a line of a program: where each begins, and its text without comments and skipped portions.
    fn each_block(&self, line: &[u8], visit: &mut dyn FnMut(usize, &[u8], StatementVocabulary<'_>));

    /// Whether blocks after an optional-skip mark of this level are skipped; `None` for a mark without number.
    fn skips(&self, level: Option<u8>) -> bool;

    /// Counts work on this many elements within a block.
    ///
    /// # Errors
    /// When the job is to end, or a limit is reached.
    fn work(&mut self, elements: usize) -> Acted;

    /// Simulated time, ns.
    fn clock(&self) -> i64;

    /// Channel number.
    fn channel(&self) -> u16;
}
