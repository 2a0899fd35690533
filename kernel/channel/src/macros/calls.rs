//! Running macros: the state of the machine that runs them, the running macros, and their work at OUTPUT.
//!
//! *Invariant:* a macro that runs cannot be selected again until it has ended. While a macro runs, its state lies with
//! the machine that runs it, and a call back into the kernel puts it here first. Facts: reference control-emulator.md
//! 4, macro-language.md 7.

use std::sync::{Arc, OnceLock};

use counterpoint_fault::Halt;
use counterpoint_lang::compile::MacroProgram;
use counterpoint_lang::fault::MacroFault;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{MacroLimits, MacroState};

use crate::cycle::CycleHole;
use counterpoint_event::event::{Motion, ToolAction};
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::macros::system;
use counterpoint_program::block::PendingCode;

/// Steps that one call of a macro may take, with everything it calls.
pub const TICKS: u64 = 5_000_000;

/// Macros active at once; functions nest without a stack of this program.
const DEPTH: u32 = 100_000;

/// Macros that EXEC, OUTPUT and embedded code may nest: a thread with [`STACK`] holds that many.
const MOST_NESTED: usize = 1000;

/// Stack of a thread that runs macros, in bytes.
pub const STACK: usize = 256 << 20;

/// Action of OUTPUT in a running macro.
#[derive(Debug, Clone)]
pub enum OutputTask {
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
    Cycle(Box<CycleHole>),
    /// A diagnostic is issued: number, severity and original text, for values that the macro does not read.
    Diagnostic(Arc<[MacroValue; 3]>),
}

impl OutputTask {
    /// Whether a tool or a head is only selected.
    pub fn selects(&self) -> bool {
        match self {
            Self::Tool(action, ..) => *action == ToolAction::Select,
            Self::Head(kind, _) => *kind == 1.0,
            _ => false,
        }
    }
}

/// A running macro.
#[derive(Debug)]
pub struct RunningMacro {
    /// Its index in the program.
    pub code: u16,
    /// The effect of OUTPUT.
    pub task: OutputTask,
    /// MATCH is on.
    pub matching: bool,
    /// OUTPUT commands so far.
    pub outputs: u32,
    /// User functions that run in it, as the trace names them, innermost last.
    pub functions: Vec<String>,
}

/// Running macros of a kernel.
#[derive(Debug, Default)]
pub struct RunningMacros {
    state: Option<Box<MacroState>>,
    #[allow(clippy::vec_box, reason = "boxes change places with the state of a running macro")]
    spares: Vec<Box<MacroState>>,
    /// Running macros, innermost last.
    pub running: Vec<RunningMacro>,
    /// Running macros by index.
    busy: Vec<bool>,
    /// Arguments that each macro uses, bit by number.
    arguments: Vec<u128>,
    /// Whether any macro reads the block as the pre-processor left it.
    pub read_block: bool,
    /// Why the kernel leaves its program, found while a macro was running.
    pub halt: Option<Halt>,
    /// Running macros are being ended because of that.
    pub ending: bool,
}

/// The system variable of the block as the pre-processor left it.
fn block_variable() -> Option<u16> {
    static PLACE: OnceLock<Option<u16>> = OnceLock::new();
    *PLACE.get_or_init(|| {
        let place = system::table().iter().position(|variable| variable.name == "$MCD");
        place.and_then(|place| u16::try_from(place).ok())
    })
}

fn limits(memory: u64) -> MacroLimits {
    let memory = usize::try_from(memory).unwrap_or(usize::MAX);
    MacroLimits { ticks: TICKS, depth: DEPTH, memory, ..MacroLimits::default() }
}

impl RunningMacros {
    /// Nothing runs yet; `kernels` > 1 means that there is a master.
    pub fn new(kernel: u16, kernels: usize, memory: u64) -> Self {
        let mut state = MacroState::new(limits(memory));
        state.channel = u32::from(kernel).max(1);
        state.channels = u32::try_from(kernels).unwrap_or(1).max(1);
        Self { state: Some(Box::new(state)), ..Self::default() }
    }

    /// Whether a macro of a cycle is running: its blocks are the moves of that cycle.
    pub fn inside_cycle_macro(&self) -> bool {
        let calls = self.running.as_slice();
        calls.iter().any(|call| match &call.task {
            OutputTask::Code(_, id) => matches!(id.kind(), CodeKind::Cycle(_)) || *id == codes::CYCLE_ON,
            OutputTask::Cycle(_) => true,
            _ => false,
        })
    }

    /// Follows a program after it has grown.
    pub fn measure(&mut self, program: &MacroProgram) {
        self.busy.resize(program.macros.len(), false);
        for code in program.macros.iter().skip(self.arguments.len()) {
            let bits = code.signature.arguments.iter().filter(|(number, _)| *number < 128);
            self.arguments.push(bits.fold(0, |bits, (number, _)| bits | 1 << number));
            self.read_block |= block_variable().is_some_and(|variable| code.reads(variable));
        }
    }

    /// Whether a macro uses an argument.
    pub fn uses(&self, code: u16, argument: u8) -> bool {
        self.arguments.get(usize::from(code)).is_some_and(|bits| bits & 1 << argument != 0)
    }

    /// Whether a macro is running.
    pub fn is_busy(&self, code: u16) -> bool {
        self.busy.get(usize::from(code)).copied().unwrap_or(true)
    }

    fn set_busy(&mut self, code: u16, busy: bool) {
        if let Some(slot) = self.busy.get_mut(usize::from(code)) {
            *slot = busy;
        }
    }

    /// The innermost running macro.
    pub fn innermost(&mut self) -> Option<&mut RunningMacro> {
        self.running.last_mut()
    }

    /// Notes that a macro starts.
    pub fn begin(&mut self, code: u16, task: OutputTask) {
        self.running.push(RunningMacro { code, task, matching: true, outputs: 0, functions: Vec::new() });
        self.set_busy(code, true);
    }

    /// Notes that a macro has ended; returns how often it executed OUTPUT.
    pub fn end(&mut self, code: u16) -> u32 {
        self.set_busy(code, false);
        self.running.pop().map_or(0, |call| call.outputs)
    }

    /// Lets no further macro begin where the stack of the thread would not hold it; returns the limit before.
    pub fn limit_nesting(&self, state: &mut MacroState) -> u32 {
        let limit = state.limits.depth;
        if self.running.len() > MOST_NESTED {
            state.limits.depth = state.depth;
        }
        limit
    }

    /// Takes the state of the language's machine (open units, variables); none while it lies with a running macro. It
    /// is to be [put back](Self::put_state).
    pub fn take_state(&mut self) -> Option<Box<MacroState>> {
        self.state.take()
    }

    /// Puts the state back.
    pub fn put_state(&mut self, state: Box<MacroState>) {
        self.state = Some(state);
    }

    /// Takes over the state of a running macro while the kernel works.
    pub fn lend_state(&mut self, state: &mut MacroState) {
        let mut spare = self.spares.pop().unwrap_or_else(|| Box::new(MacroState::new(limits(0))));
        std::mem::swap(&mut *spare, state);
        self.state = Some(spare);
    }

    /// Returns the state to the running macro.
    pub fn return_state(&mut self, state: &mut MacroState) {
        if let Some(mut spare) = self.state.take() {
            std::mem::swap(&mut *spare, state);
            self.spares.push(spare);
        }
    }

    /// Remaining steps of the running macros, before they are set.
    pub fn ticks(&mut self, left: Option<u64>) -> Option<u64> {
        let state = self.state.as_deref_mut()?;
        let before = state.ticks;
        state.ticks = left.unwrap_or(before);
        Some(before)
    }

    /// Keeps a reason to leave the program; running macros end.
    pub fn stop(&mut self, halt: Halt) {
        self.halt = Some(halt);
        self.ending = !self.running.is_empty();
    }

    /// Forgets the reason to leave the program.
    pub fn resume(&mut self) {
        (self.halt, self.ending) = (None, false);
    }

    /// The reason to leave the program, if it can be acted on here: all running macros end, or none runs.
    pub fn pending(&mut self) -> Option<Halt> {
        let halt = self.halt.filter(|_| self.ending || self.running.is_empty())?;
        if self.running.is_empty() {
            self.resume();
        }
        Some(halt)
    }
}

/// The fault that unwinds all running macros.
pub fn unwinding(state: &mut MacroState) -> MacroFault {
    state.ticks = 0;
    MacroFault::new(counterpoint_lang::diag::DiagnosticNumber::TICKS, "the run ends")
}
