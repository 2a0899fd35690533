//! The macros of one running kernel: what is switched on, what is running, what they left for later.
//!
//! Invariants: a macro that runs is no candidate again until it has ended; while a macro runs, its state lies with the
//! machine that runs it, and whoever calls back into the kernel puts it here first; a kernel without macros has no
//! runtime at all. Facts: reference control-emulator.md 4, macro-language.md 3.2, 3.3, 7.

mod running;

use std::collections::VecDeque;
use std::sync::Arc;

use counterpoint_lang::compile::Program;
use counterpoint_lang::fault::Fault;
use counterpoint_lang::host::Folder;
use counterpoint_lang::value::{Elements, Value};
use counterpoint_lang::vm::{Limits, State};
use rustc_hash::FxHashMap;

use super::asked::Asked;
use super::host::variables::Store;
use super::host::{operations::Operations, sums::Sums, travel::Travel};
use super::reused::Reused;
use crate::channel::scan::Scanner;
use crate::log::event::{FileId, MAX_AXES, Motion, Origin, ToolAction};
use crate::machine::ident::{CodeId, DataId};
use crate::machine::macros::model::{HOOKS, Hook, Macros};
use crate::state::block::{Block, PendingCode};
use crate::state::cycle::Hole;
use counterpoint_fault::Halt;

/// Steps that one call of a macro may take, with everything it calls.
pub(crate) const TICKS: u64 = 5_000_000;

/// Macros active at once; functions nest without a stack of this program.
const DEPTH: u32 = 100_000;

/// Macros that EXEC, OUTPUT and embedded code may nest: a thread with [`STACK`] holds that many.
const MOST_NESTED: usize = 1000;

/// Stack of a thread that runs macros, in bytes.
pub(crate) const STACK: usize = 256 << 20;

/// Blocks that EXEC/NEXT may leave waiting.
pub(crate) const MOST_QUEUED: usize = 10_000;

/// What OUTPUT does in a running macro.
#[derive(Debug, Clone)]
pub(crate) enum Task {
    /// Nothing: startup, shutdown, data and identification macros.
    None,
    /// The action of a code.
    Code(PendingCode, CodeId),
    /// A comment or a message to the operator.
    Remark(CodeId, Arc<String>),
    /// A motion, with its duration in seconds.
    Motion(f64, Box<Motion>),
    /// A tool is selected or loaded: action, tool, offset, ns.
    Tool(ToolAction, u32, u32, i64),
    /// A head is selected (1) or loaded (2).
    Head(f64, u32),
    /// A hole of a canned cycle is made.
    Cycle(Box<Hole>),
    /// A diagnostic is issued: number, severity and text as they came, for what the macro does not look at.
    Diagnostic(Arc<[Value; 3]>),
}

impl Task {
    /// A tool or a head is only selected.
    pub(crate) fn selects(&self) -> bool {
        match self {
            Self::Tool(action, ..) => *action == ToolAction::Select,
            Self::Head(kind, _) => *kind == 1.0,
            _ => false,
        }
    }
}

/// A running macro.
#[derive(Debug)]
pub(crate) struct Call {
    /// Its index in the program.
    pub(crate) code: u16,
    /// What OUTPUT does.
    pub(crate) task: Task,
    /// MATCH is on.
    pub(crate) matching: bool,
    /// OUTPUT commands so far.
    pub(crate) outputs: u32,
    /// User functions that run in it, as the trace names them, innermost last.
    pub(crate) functions: Vec<String>,
}

/// A block that EXEC/NEXT left for later.
#[derive(Debug, Clone)]
pub(crate) enum Later {
    /// Text, and whether macros match.
    Text(Arc<String>, bool),
    /// Identifiers with values.
    Items(Arc<[Value]>, bool),
}

/// Where the run goes on after the shutdown macro.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Restart {
    /// File of the job.
    pub(crate) file: FileId,
    /// First line.
    pub(crate) line: u32,
    /// As if it were the first file; else counters, tool and modal codes carry on.
    pub(crate) reset: bool,
}

/// Macros of one kernel.
#[derive(Debug)]
pub(crate) struct Runtime {
    /// The machine's program, or a longer copy with the embedded code met so far.
    pub(crate) program: Arc<Program>,
    state: Option<Box<State>>,
    #[allow(clippy::vec_box, reason = "boxes change places with the state of a running macro")]
    spares: Vec<Box<State>>,
    /// Running macros, innermost last.
    pub(crate) calls: Vec<Call>,
    /// Running macros by index.
    pub(crate) busy: Vec<bool>,
    /// Arguments that each macro uses, bit by number.
    uses: Vec<u128>,
    /// Why the kernel leaves its program, found while a macro was running.
    pub(crate) halt: Option<Halt>,
    /// Running macros are being ended because of that.
    pub(crate) ending: bool,
    /// Macro of each hook that is switched on.
    pub(crate) hooks: [Option<u16>; HOOKS],
    /// Code macros that are on.
    pub(crate) codes_on: Vec<bool>,
    /// Data macros that are on.
    pub(crate) data_on: Vec<bool>,
    /// What is processed now may match code and data macros.
    pub(crate) matching: bool,
    /// Blocks left for later.
    pub(crate) later: VecDeque<Later>,
    /// Blocks for nested processing.
    pub(crate) blocks: Vec<Block>,
    /// Text of the block in process if it is not the line of the file.
    pub(crate) text: Option<Arc<String>>,
    /// Left-over text of the block if a macro has set it.
    pub(crate) left: Option<Arc<String>>,
    /// Pushed modal states.
    pub(crate) saved: Vec<Vec<(u16, CodeId, u16)>>,
    /// Data that fire a modal group.
    pub(crate) data_codes: Vec<(DataId, u16)>,
    /// What macros have asked the outside for.
    pub(crate) asked: Asked,
    /// Operations of the program.
    pub(crate) operations: Operations,
    /// `$TLSUM`
    pub(crate) tool_sums: Sums,
    /// `$OPSUM`
    pub(crate) operation_sums: Sums,
    /// `$TLMIN`, `$TLMAX`
    pub(crate) tool_travel: Travel,
    /// `$OPMIN`, `$OPMAX`
    pub(crate) operation_travel: Travel,
    /// Column of each axis of the channel in those.
    pub(crate) columns: [Option<usize>; MAX_AXES],
    /// Sequence number of the last block that had one.
    pub(crate) last_sequence: u32,
    /// The scanner with levels of optional skip that a macro has switched.
    pub(crate) scanner: Option<Arc<Scanner>>,
    /// The scanner without marks of optional skip, once EXEC has issued a text.
    pub(crate) unmarked: Option<Arc<Scanner>>,
    /// The block in process is a text that EXEC issued.
    pub(crate) issued: bool,
    /// The pre-processor has worked on the block: what it takes off is gone.
    pub(crate) preprocessed: bool,
    /// Level of its first mark of optional skip, if the machine has data for that.
    pub(crate) mark: Option<u8>,
    /// Compiled embedded code by text; none where it has errors.
    pub(crate) embedded: FxHashMap<String, Option<(u16, bool)>>,
    /// Global variables that this kernel has for itself.
    pub(crate) globals: Vec<Value>,
    /// From this index on, global variables belong to all kernels; none if there is no master.
    pub(crate) shared_globals: Option<u32>,
    /// System variables that are kept here.
    pub(crate) store: Store,
    /// Changed severities and switches of diagnostics by number.
    pub(crate) severities: FxHashMap<u32, (u8, bool)>,
    /// How often each diagnostic came.
    pub(crate) counts: FxHashMap<u32, u32>,
    /// The statement that raised the diagnostic which the diagnostic macro sees.
    pub(crate) origin: Option<Box<Origin>>,
    /// Current folder, temporary files and open stores of values.
    pub(crate) folder: Folder,
    /// The kernel comes to its end: what it writes is what it had open.
    pub(crate) leaving: bool,
    /// Texts handed to block macros.
    pub(crate) texts: Reused<Arc<String>>,
    /// Positions handed to event macros.
    pub(crate) positions: Reused<Elements>,
    /// Flags handed to event macros.
    pub(crate) flags: Reused<Elements>,
    /// Channel axis of each of the six elements of `$AXES`.
    pub(crate) slots: [Option<usize>; 6],
    /// Tools loaded so far; the first row of the tool table is the dummy tool.
    pub(crate) tools: Vec<u32>,
    /// The rows of the tool tables as macros see them, by place in `tools`; empty while that is their order.
    pub(crate) tool_order: Vec<u16>,
    /// Macros have written facts of a tool that are not told yet.
    pub(crate) tools_changed: bool,
    /// Start of the last motion.
    pub(crate) before: crate::log::event::Position,
    /// What the identification macro gave is being evaluated; it is not asked again.
    pub(crate) identifying: bool,
    /// Another file that the shutdown macro goes on with.
    pub(crate) restart: Option<Restart>,
    /// The pre-processor has left words of the block.
    pub(crate) made: bool,
    /// The kernel's program macros are over: NEXT is dropped.
    pub(crate) closing: bool,
}

fn limits(memory: u64) -> Limits {
    let memory = usize::try_from(memory).unwrap_or(usize::MAX);
    Limits { ticks: TICKS, depth: DEPTH, memory, ..Limits::default() }
}

impl Runtime {
    /// Everything switched on as at the start of a run; `kernels` > 1 means that there is a master.
    pub(crate) fn new(macros: &Macros, program: &Arc<Program>, kernel: u16, (kernels, memory): (usize, u64)) -> Self {
        let mut state = State::new(limits(memory));
        state.channel = u32::from(kernel).max(1);
        state.channels = u32::try_from(kernels).unwrap_or(1).max(1);
        let mut runtime = Self {
            program: Arc::clone(program),
            state: Some(Box::new(state)),
            spares: Vec::new(),
            calls: Vec::new(),
            busy: Vec::new(),
            uses: Vec::new(),
            halt: None,
            ending: false,
            hooks: macros.hooks,
            codes_on: macros.codes.iter().map(|one| one.enabled).collect(),
            data_on: macros.data.iter().map(|one| one.enabled).collect(),
            matching: true,
            later: VecDeque::new(),
            blocks: Vec::new(),
            text: None,
            left: None,
            saved: Vec::new(),
            data_codes: Vec::new(),
            asked: Asked::default(),
            operations: Operations::default(),
            tool_sums: Sums::default(),
            operation_sums: Sums::default(),
            tool_travel: Travel::default(),
            operation_travel: Travel::default(),
            columns: [None; MAX_AXES],
            last_sequence: 0,
            scanner: None,
            unmarked: None,
            issued: false,
            preprocessed: false,
            mark: None,
            embedded: FxHashMap::default(),
            globals: Vec::new(),
            shared_globals: (kernels > 1).then_some(100),
            store: Store::new(),
            severities: FxHashMap::default(),
            counts: FxHashMap::default(),
            origin: None,
            folder: Folder::default(),
            leaving: false,
            texts: Reused::default(),
            positions: Reused::default(),
            flags: Reused::default(),
            slots: [None; 6],
            tools: Vec::new(),
            tool_order: Vec::new(),
            tools_changed: false,
            before: [0.0; crate::log::event::MAX_AXES],
            identifying: false,
            restart: None,
            made: false,
            closing: false,
        };
        runtime.measure();
        runtime
    }

    /// Follows the program after it has grown.
    pub(crate) fn measure(&mut self) {
        self.busy.resize(self.program.macros.len(), false);
        for code in self.program.macros.iter().skip(self.uses.len()) {
            let bits = code.arguments.iter().filter(|(number, _)| *number < 128);
            self.uses.push(bits.fold(0, |bits, (number, _)| bits | 1 << number));
        }
    }

    /// A macro uses an argument.
    pub(crate) fn uses(&self, code: u16, argument: u8) -> bool {
        self.uses.get(usize::from(code)).is_some_and(|bits| bits & 1 << argument != 0)
    }

    /// A macro is running.
    pub(crate) fn is_busy(&self, code: u16) -> bool {
        self.busy.get(usize::from(code)).copied().unwrap_or(true)
    }

    /// The macro of a hook, if it may run now.
    #[inline]
    pub(crate) fn ready(&self, hook: Hook) -> Option<u16> {
        self.hooks.get(hook as usize).copied().flatten().filter(|&code| !self.is_busy(code))
    }

    fn set_busy(&mut self, code: u16, busy: bool) {
        if let Some(slot) = self.busy.get_mut(usize::from(code)) {
            *slot = busy;
        }
    }

    /// Open units and variables, while no macro runs; they are to be [given back](Self::give_back).
    pub(crate) fn state(&mut self) -> Option<Box<State>> {
        self.state.take()
    }

    pub(crate) fn give_back(&mut self, state: Box<State>) {
        self.state = Some(state);
    }

    /// Steps that the running macros have left, before they are set.
    pub(crate) fn ticks(&mut self, left: Option<u64>) -> Option<u64> {
        let state = self.state.as_deref_mut()?;
        let before = state.ticks;
        state.ticks = left.unwrap_or(before);
        Some(before)
    }

    /// The innermost running macro.
    pub(crate) fn call(&mut self) -> Option<&mut Call> {
        self.calls.last_mut()
    }
}

/// The fault that unwinds all running macros.
pub(crate) fn unwinding(state: &mut State) -> Fault {
    state.ticks = 0;
    Fault::new(counterpoint_lang::diag::Number::TICKS, "the run ends")
}
