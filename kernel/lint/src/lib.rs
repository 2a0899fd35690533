//! Follows a program without executing it: its calls, its jumps and its acts for other channels. So its waits can be
//! judged before anything moves.
//!
//! Words between channels, calls and ends act as in a run; nothing else does, and no variable has a value. If only a
//! run could decide how the program continues, the channel is checked no further, and the place and the reason are
//! reported. *Invariant:* blocks take no time, the number of blocks that are read is bounded, and an unknown effect
//! never counts as good.

mod region;
mod regions;
mod statements;
mod unknown;
mod words;

use std::sync::Arc;

use counterpoint_channel::at::BlockPlace;
use counterpoint_channel::block_places::is_reshaped;
use counterpoint_channel::callee::Pending;
use counterpoint_control_api::outline::{OutlineReader, OutlineStep};
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::pipeline::edit::reshape;
use counterpoint_emulator::pipeline::read::{before_rewind_stop, begin_block, is_rewind_stop, text_ends, too_long};
use counterpoint_emulator::pipeline::split::split;
use counterpoint_event::event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::model::MainReturn;
use counterpoint_program::scan::ScanResult;
use counterpoint_program::spot::BlockStart;
use rustc_hash::{FxHashMap, FxHashSet};

/// Begins an expression or statement of the macro language within a block.
const EMBEDDED: [&[u8]; 2] = [b"!{", b"#{"];

/// Most blocks of one channel that are read.
const MOST: u64 = 1_000_000;

/// Most places of jumps that are remembered; a loop without end that is longer ends at [`MOST`].
const MOST_PLACES: usize = 10_000;

/// A place of a program with its callers and their remaining passes.
type Standing = Vec<(FileId, BlockStart, u32)>;

/// The path through the program of one channel.
struct Linter<'w, 'k> {
    kernel: &'w mut Kernel<'k>,
    /// Reads blocks that are more than plain words; none if the dialect has no reader.
    reader: Option<Box<dyn OutlineReader>>,
    /// Blocks read, those of parts that were only looked through included.
    read: u64,
    /// Where jumps back have led.
    stood: FxHashSet<Standing>,
    /// The content of searched programs, by file and lines.
    looked: FxHashMap<(FileId, u32, u32), Option<u32>>,
    /// Whether it has been reported that loops are assumed to end.
    loops: bool,
    /// Words that have been reported as unknown.
    unknown: FxHashSet<String>,
}

/// The content of a block.
enum Outline {
    /// Plain words, which are in the block.
    Words,
    /// Steps.
    Steps(Vec<OutlineStep>),
}

/// Follows the program to its end, or to where only a run can tell how it continues.
pub fn walk(kernel: &mut Kernel<'_>) -> Halt {
    let reader = kernel.dialect.kind.reader(kernel.channel.env.machine);
    let machine = kernel.channel.env.machine;
    let first = machine.channels.first().map(|channel| channel.number);
    if machine.macros.is_some() && first == Some(kernel.channel.at.channel) {
        let text = "macros of the machine are not executed; their effects on other channels are not checked";
        kernel.diagnose(&diag::LINT_MACROS, text);
    }
    let (stood, looked) = (FxHashSet::default(), FxHashMap::default());
    let unknown = FxHashSet::default();
    let mut walk = Linter { kernel, reader, read: 0, stood, looked, loops: false, unknown };
    if let Err(halt) = walk.report_unknown_of_program() {
        return halt;
    }
    loop {
        if let Err(halt) = walk.next() {
            return halt;
        }
    }
}

impl Linter<'_, '_> {
    /// Follows one block.
    fn next(&mut self) -> Acted {
        let done = self.block();
        self.kernel.went_on(done)
    }

    fn block(&mut self) -> Acted {
        let Some(text) = self.text()? else { return Ok(()) };
        if text.is_empty() {
            return Ok(());
        }
        begin_block(self.kernel)?;
        self.kernel.channel.at.idle_blocks = 0;
        if self.read > MOST {
            return Err(self.lost(&format!("it has more than {MOST} blocks")));
        }
        match self.outline(&text) {
            Outline::Words => self.words_of_block(&[])?,
            Outline::Steps(steps) => self.steps(steps)?,
        }
        self.follow()
    }

    /// The text of the next block, empty where it is blank; none after the text of a program has ended.
    fn text(&mut self) -> Result<Option<Arc<[u8]>>, Halt> {
        let kernel = &mut *self.kernel;
        let sources = kernel.channel.env.sources;
        let Some(frame) = kernel.flow.frame() else { return Err(Halt::ProgramEnd(None)) };
        let (file, line, caller) = (frame.file, frame.next, frame.caller);
        if line > frame.range.last {
            return text_ends(kernel).map(|()| None);
        }
        frame.next = line + 1;
        let Some(source) = sources.get(file) else { return Err(Halt::ProgramEnd(None)) };
        self.read += 1;
        kernel.channel.at.go_to(BlockPlace { file, line, caller });
        let text = source.line(line);
        if text.iter().all(u8::is_ascii_whitespace) {
            return Ok(Some(Arc::default()));
        }
        if text.len() > kernel.channel.env.options.limits.block_length {
            return Err(too_long(kernel, text.len()));
        }
        let text: Arc<[u8]> = if is_reshaped(&mut kernel.channel, &kernel.flow, source) {
            reshape(kernel, text, line)?.text().into()
        } else {
            text.into()
        };
        let text = before_rewind_stop(&kernel.channel, &text).map(Arc::from).unwrap_or(text);
        let blank = text.iter().all(u8::is_ascii_whitespace) || is_rewind_stop(&kernel.channel, &text);
        Ok(Some(if blank { Arc::default() } else { text }))
    }

    /// The content of a block.
    fn outline(&mut self, text: &[u8]) -> Outline {
        if text.windows(2).any(|pair| EMBEDDED.contains(&pair)) {
            self.kernel.channel.block.clear();
            return Outline::Steps(vec![OutlineStep::Hidden(
                "text of the macro language stands in the block".to_owned(),
            )]);
        }
        match split(self.kernel, text, true) {
            ScanResult::Words => Outline::Words,
            ScanResult::Statement => {
                self.kernel.channel.block.clear();
                match self.reader.as_deref_mut() {
                    Some(reader) => Outline::Steps(reader.outline(self.kernel, text)),
                    None => {
                        Outline::Steps(vec![OutlineStep::Hidden("blocks of this control act only in a run".to_owned())])
                    }
                }
            }
        }
    }

    /// Calls, returns and the end that the block asks for.
    fn follow(&mut self) -> Acted {
        if self.kernel.flow.pending.as_ref().is_some_and(Pending::calls) {
            self.check_calls()?;
        }
        let returns = matches!(self.kernel.flow.pending, Some(Pending::Return(_)));
        if returns && self.kernel.flow.level() == 0 {
            let again = self.kernel.channel.env.machine.subprograms.main_return == MainReturn::Restart;
            match self.kernel.flow.pending.take() {
                Some(Pending::Return(Some(number))) => {
                    let target = self.kernel.find_sequence(number)?;
                    return self.jump(target);
                }
                Some(Pending::Return(None)) if again => {
                    return Err(self.lost("the program begins again and never ends, one pass is judged"));
                }
                pending => self.kernel.flow.pending = pending,
            }
        }
        self.kernel.follow()
    }

    /// Continues at a block of the program. A place where the program has been with the same callers is one of a loop
    /// without end.
    fn jump(&mut self, target: BlockStart) -> Acted {
        let Some(frame) = self.kernel.flow.frame() else { return Ok(()) };
        let back = target < frame.next_block();
        (frame.next, frame.offset) = (target.line, target.offset);
        if back {
            let frames = self.kernel.flow.frames.iter();
            let standing = frames.map(|frame| (frame.file, frame.next_block(), frame.repeats)).collect();
            if self.stood.len() >= MOST_PLACES {
                self.stood.clear();
            }
            if !self.stood.insert(standing) {
                return Err(self.lost("a loop without end, one pass of it is judged"));
            }
        }
        Ok(())
    }

    /// Calls are known unless a macro may redirect or skip them.
    fn check_calls(&mut self) -> Acted {
        let macros = self.kernel.channel.env.machine.macros.as_ref();
        match macros.is_some_and(|macros| macros.hook(Hook::SubprogramStartup).is_some()) {
            true => Err(self.lost("a macro of the machine decides about calls")),
            false => Ok(()),
        }
    }

    /// The channel is judged up to this block.
    fn lost(&mut self, reason: &str) -> Halt {
        let text = format!("the waits are judged up to here: {reason}, at '{}'", self.kernel.channel.block_text());
        self.kernel.diagnose(&diag::LINT_LOST, text);
        Halt::Blocked
    }
}
