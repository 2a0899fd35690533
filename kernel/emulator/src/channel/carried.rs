//! Kernel state that survives a restart of the machine with another file.
//!
//! Facts: reference control-emulator.md 5.8. *Invariant:* only a kernel whose program came to its end is carried on,
//! and only on a machine whose Machine Shutdown may start it again; everything that belongs to one run of all kernels
//! (clock of the coordinator, waits, streams) begins again.

use std::sync::Arc;

use counterpoint_channel::arc::ArcState;
use counterpoint_channel::at::{BlockPlace, ExecutionPoint};
use counterpoint_channel::burden::Burden;
use counterpoint_channel::channel_context::{BlockText, ChannelContext, Reports};
use counterpoint_channel::context::BlockContext;
use counterpoint_channel::cycle::Cycle;
use counterpoint_channel::flow::{ProgramFlow, RunningProgram};
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::probing::Probing;
use counterpoint_channel::queued_codes::initial_codes;
use counterpoint_channel::thread::ThreadingState;
use counterpoint_channel::times::TimeRecord;
use counterpoint_channel::{ChannelMemory, RareState};
use counterpoint_event::SourcePlace;
use counterpoint_event::event::FileId;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::pattern::SearchMemory;
use counterpoint_machine::macros::model::Hook;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::tape;
use counterpoint_sync::tag::Tag;
use rustc_hash::FxHashMap;

use super::Kernel;
use super::components::ComponentSelection;
use super::dialect_state::DialectState;

/// How the life of a kernel ended.
pub struct Lived {
    /// Number of the channel.
    pub channel: u16,
    /// Why it ended.
    pub halt: Halt,
    /// Tag of the end of its program in the log, if the program has ended.
    pub ended: Option<Tag>,
    /// The state that it keeps if it may be started again.
    pub left: Option<Box<CarriedState>>,
}

/// State of a kernel between two runs.
pub struct CarriedState {
    /// Number of the channel.
    pub channel: u16,
    clock: i64,
    events: u64,
    /// All, and those of the user's programs.
    blocks: [u64; 3],
    idle_blocks: u64,
    diagnostics: u32,
    raised: FxHashMap<u32, u32>,
    burden: Burden,
    tape: (tape::TapeRuleSet, SearchMemory),
    context: BlockContext,
    state: ChannelMemory,
    flow: ProgramFlow,
    dialect: DialectState,
    macros: Box<Runtime>,
    turns: ComponentSelection,
}

/// Memory of the master between Machine Startup and Machine Shutdown.
pub struct MasterMemory {
    macros: Box<Runtime>,
    context: BlockContext,
    times: Box<TimeRecord>,
}

impl Kernel<'_> {
    /// Sends the events of the master, and keeps its memory for Machine Shutdown.
    pub fn into_master(mut self) -> MasterMemory {
        self.channel.come_to_rest();
        self.channel.flush();
        MasterMemory { macros: self.macros, context: self.channel.context, times: self.channel.state.times }
    }

    /// Continues as the master at the end of the log, at this time, ns, and micro step.
    pub fn take_over_master(&mut self, memory: MasterMemory, (clock, micro): (i64, u32)) {
        (self.channel.at.clock, self.channel.at.micro) = (clock, micro);
        (self.macros, self.channel.state.times) = (memory.macros, memory.times);
        self.channel.context = memory.context;
        self.macros.course.closing = true;
        self.macros.issued.later.clear();
    }
}

impl Kernel<'_> {
    /// Takes the kernel apart by name, so that a new part of it is either carried on or begins again here.
    fn into_carried(self) -> CarriedState {
        let events = self.channel.emitter.count();
        let Self { channel, ports: _, plan: _, flow, dialect, macros, components } = self;
        let ChannelContext {
            env: _,
            at,
            block: _,
            text,
            context,
            tables: _,
            acting: _,
            state,
            reports,
            burden,
            emitter: _,
        } = channel;
        let ExecutionPoint {
            channel,
            clock,
            micro: _,
            file: _,
            line: _,
            caller: _,
            blocks,
            user_blocks,
            made_blocks,
            idle_blocks,
            timed: _,
        } = at;
        let BlockText { edited: _, tape } = text;
        let Reports {
            diagnostics,
            alarms: _,
            raised,
            waits: _,
            unrecognised: _,
            race: _,
            reset: _,
            plausible: _,
            swallowed: _,
            unit_named: _,
        } = reports;
        CarriedState {
            channel,
            clock,
            events,
            blocks: [blocks, user_blocks, made_blocks],
            idle_blocks,
            diagnostics,
            raised,
            burden,
            tape,
            context,
            state,
            flow,
            dialect,
            macros,
            turns: components.turns,
        }
    }

    fn put_back(&mut self, carried: CarriedState) {
        let at = &mut self.channel.at;
        ([at.blocks, at.user_blocks, at.made_blocks], at.idle_blocks) = (carried.blocks, carried.idle_blocks);
        self.channel.reports.diagnostics = carried.diagnostics;
        self.channel.reports.raised = carried.raised;
        self.channel.burden = carried.burden;
        self.channel.text.tape = carried.tape;
        self.channel.context = carried.context;
        self.channel.state = carried.state;
        self.flow = carried.flow;
        self.dialect = carried.dialect;
        self.macros = carried.macros;
        self.components.turns = carried.turns;
        if let Some(component) = self.components.current() {
            (self.channel.env.machine, self.plan) = (component.machine, component.plan);
            self.channel.tables = &self.plan.tables;
            self.channel.state.times.record_motions(self.plan.hooks.is_some());
            let reader = self.channel.env.whole.reader_for(component.machine.preprocessor);
            self.channel.env.sources = self.channel.env.sources.by(reader);
        }
        self.channel.emitter.count_from(carried.events);
    }
}

impl Kernel<'_> {
    /// The end of its life.
    pub(crate) fn lived(self, halt: Halt, ended: Option<Tag>) -> Lived {
        let hook = self.channel.env.whole.macros.as_deref().and_then(|macros| macros.hook(Hook::MachineShutdown));
        let channel = self.channel.at.channel;
        let left = (hook.is_some() && matches!(halt, Halt::ProgramEnd(_))).then(|| Box::new(self.into_carried()));
        Lived { channel, halt, ended, left }
    }

    /// Takes over the earlier state of the kernel; from its end until now it was idle.
    pub fn take_over(&mut self, carried: CarriedState) {
        let idle = self.channel.at.clock.saturating_sub(carried.clock);
        self.put_back(carried);
        if idle > 0 {
            self.channel.at.idle_blocks = 0;
        }
        self.channel.state.times.add_waiting(idle);
    }

    /// Begins another program. It counts as a block, so that a macro that restarts indefinitely comes to a limit.
    pub(crate) fn begin_again(&mut self, file: FileId, range: ProgramRange, name: Arc<str>, reset: bool) -> Acted {
        self.macros.course.closing = false;
        self.channel.at.blocks += 1;
        self.channel.at.idle_blocks += 1;
        self.check_limits()?;
        self.load(file)?;
        self.start_over(file, range, name, reset)
    }

    /// Starts the next program after the previous one has ended.
    pub fn start_over(&mut self, file: FileId, range: ProgramRange, name: Arc<str>, reset: bool) -> Acted {
        if reset {
            self.channel.state.forget_words(self.channel.env.machine);
            initial_codes(&mut self.channel);
            (
                self.channel.state.place.tools.current,
                self.channel.state.place.tools.selected,
                self.channel.state.place.tools.chosen,
            ) = (0, 0, false);
            (self.channel.state.cycle, self.channel.state.arcs) =
                (Cycle::new(self.channel.env.machine), ArcState::default());
            self.forget_frame();
            if let Some(channel) =
                self.channel.env.machine.channels.iter().find(|channel| channel.number == self.channel.at.channel)
            {
                *self.channel.state.others = RareState::new(self.channel.env.machine, channel);
            }
            (*self.channel.state.threads, *self.channel.state.skip) =
                (ThreadingState::new(self.channel.env.machine), Probing::default());
            let runtime = &mut *self.macros;
            runtime.variables.store.counts = Default::default();
            runtime.books.forget_operations();
            runtime.variables.store.listed.clear();
            runtime.tools.clear();
        }
        self.channel.block.clear();
        if !reset {
            self.switch_compensation();
        }
        self.channel.at.go_to(BlockPlace { file, line: 0, caller: SourcePlace::NONE });
        for _ in self.flow.frames.iter().filter(|frame| frame.own_variables) {
            self.dialect.variables.leave();
        }
        self.flow = ProgramFlow::default();
        self.flow.frames.push(RunningProgram::main(file, range, name));
        if let Some(interpreter) = self.dialect.interpreter.as_deref_mut() {
            interpreter.restart(reset);
            self.flow.watched = interpreter.watches();
        }
        self.interpreter_start();
        self.plan.hooks.map_or(Ok(()), |hooks| (hooks.program.start_again)(self))?;
        let done = self.follow();
        self.went_on(done)
    }
}
