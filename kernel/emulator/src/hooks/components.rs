//! A channel of a composite machine changes its component: `$FAPPLY`.
//!
//! Facts: reference control-emulator.md 8.3, functions.md 9. Decisions: the change takes place before the next block,
//! after the remaining actions of the macros of the block in process. The component's Declaration runs when it is first
//! active. Modal codes that the new component has in the same group stay active, all others are its initial codes, and
//! no canned cycle stays active. Blocks that EXEC/NEXT has queued are those of the new component.

use counterpoint_control_api::LoopStack;
use counterpoint_event::event::Kind;
use counterpoint_event::event::OperatorMessage;
use counterpoint_fault::Acted;
use counterpoint_machine::Machine;
use counterpoint_machine::macros::model::Hook;

use crate::channel::Kernel;
use crate::channel::components::Resting;
use crate::channel::dialect_state::DialectState;
use counterpoint_channel::arc::ArcState;
use counterpoint_channel::context::BlockContext;
use counterpoint_channel::cycle::Cycle;
use counterpoint_channel::modal::{ModalCodes, group};
use counterpoint_channel::position::MotionState;
use counterpoint_channel::thread::ThreadingState;
use counterpoint_channel::turning::TurningState;

impl Kernel<'_> {
    /// Changes the component, if a macro has requested another one and none is running; none if nothing is to be done.
    pub(crate) fn change_component(&mut self) -> Option<Acted> {
        self.components.turns.wanted?;
        if !self.macros.calls.running.is_empty() {
            return None;
        }
        let to = self.components.turns.wanted.take()?;
        // A change counts as a block, so that startup macros that ask for each other indefinitely reach a limit.
        self.channel.at.blocks += 1;
        self.channel.at.idle_blocks += 1;
        let done = self.check_limits().and_then(|()| self.take_component(to));
        Some(done.and_then(|()| self.follow()))
    }

    fn take_component(&mut self, to: usize) -> Acted {
        self.plain_macro(Hook::ProgramShutdown)?;
        self.flush_lookahead()?;
        let Some(next) = self.components.all.get(to).copied() else { return Ok(()) };
        let turns = &mut self.components.turns;
        let left = turns.now.replace(to);
        turns.before = left;
        let known = turns.kept.iter().position(|(place, _)| *place == to).map(|at| turns.kept.swap_remove(at).1);
        let first = known.is_none();
        let mut old = std::mem::replace(&mut self.macros, known.unwrap_or_default());
        let before = self.channel.env.machine;
        (self.channel.env.machine, self.plan) = (next.machine, next.plan);
        self.channel.state.times.record_motions(next.plan.hooks.is_some());
        (self.channel.scanner, self.channel.context) = (&next.plan.scanner, BlockContext::default());
        if first {
            self.set_up_macros(next.macros);
        }
        let (new, shown) = (&mut *self.macros, &mut *old);
        std::mem::swap(&mut new.issued, &mut shown.issued);
        std::mem::swap(&mut new.books, &mut shown.books);
        std::mem::swap(&mut new.tools, &mut shown.tools);
        new.variables.store.continue_counts(&shown.variables.store);
        if let Some(left) = left {
            self.components.turns.kept.push((left, old));
        }
        self.take_preprocessor(before)?;
        self.fit_state(before);
        self.channel.text.tape = (
            next.plan.edits.tape.as_ref().map(|tape| tape.start).unwrap_or_default(),
            std::mem::take(&mut self.channel.text.tape.1),
        );
        let text = format!("component {}", next.name).into();
        self.channel.emit(0, Kind::Message(OperatorMessage { text, printed: false }));
        if first {
            self.plain_macro(Hook::Declaration)?;
        }
        self.plain_macro(Hook::ProgramStartup)
    }

    /// Variables, loops and interpreter of the new pre-processor, if it is another one; it reads the texts of the
    /// programs that run in its own way.
    fn take_preprocessor(&mut self, before: &Machine) -> Acted {
        let machine = self.channel.env.machine;
        if machine.preprocessor == before.preprocessor {
            return Ok(());
        }
        let levels: Vec<bool> = self.flow.frames.iter().skip(1).map(|frame| frame.own_variables).collect();
        let resting = &mut self.components.turns.dialects;
        let known = resting.iter().position(|one| one.of == machine.preprocessor).map(|at| resting.swap_remove(at));
        let first = known.is_none();
        let next = known.unwrap_or_else(|| Resting {
            of: machine.preprocessor,
            dialect: DialectState::new(machine, !self.channel.env.options.lint),
            loops: LoopStack::default(),
            levels: Vec::new(),
        });
        resting.push(Resting {
            of: before.preprocessor,
            dialect: std::mem::replace(&mut self.dialect, next.dialect),
            loops: std::mem::replace(&mut self.flow.loops, next.loops),
            levels: levels.clone(),
        });
        (self.flow.known.labels, self.flow.known.tables) = (Default::default(), 0);
        self.flow.known.programs = Default::default();
        self.flow.known.blocks = Default::default();
        if let Some(rested) = self.components.turns.dialects.last() {
            self.dialect.variables.follow(&rested.dialect.variables);
        }
        let reader = self.channel.env.whole.reader_for(machine.preprocessor);
        self.channel.env.sources = self.channel.env.sources.by(reader);
        for at in 0..self.flow.frames.len() {
            let Some(file) = self.flow.frames.get(at).map(|frame| frame.file) else { break };
            self.load(file)?;
        }
        if first {
            self.interpreter_start();
        }
        self.follow_levels(&next.levels, &levels);
        Ok(())
    }

    /// Subprograms that have returned while another pre-processor worked take their variables with them; those that it
    /// has called begin without any.
    fn follow_levels(&mut self, before: &[bool], now: &[bool]) {
        for own_variables in before.iter().skip(now.len()).rev() {
            if *own_variables {
                self.dialect.variables.leave();
            }
            self.interpreter_return();
        }
        if before.len() > now.len() {
            self.flow.loops.return_to(now.len());
        }
        for own_variables in now.iter().skip(before.len()) {
            if *own_variables {
                self.dialect.variables.enter(&[]);
            }
            self.interpreter_call();
        }
    }

    /// Adapts the state to the new definition; the memory of the machine itself stays.
    fn fit_state(&mut self, before: &Machine) {
        let machine = self.channel.env.machine;
        let old = std::mem::replace(&mut self.channel.state.modal, ModalCodes::empty());
        let fitted = self.channel.state.remembered.fitted(before, machine);
        self.channel.state.remembered = fitted;
        self.initial_codes();
        let state = &mut self.channel.state;
        for (of, id, row) in old.saved() {
            let name = &before.code_names[id];
            let Some(new) = machine.code_names.find(|own| own == name).filter(|_| of != group::CYCLE) else { continue };
            let same = |at: &counterpoint_machine::rows::CodeRow| at.enable && at.id == new && at.group == of;
            let form = row.map(|row| &before.codes[row].form);
            let rows = || machine.codes.entries().filter(|(_, row)| same(row));
            let found = rows().find(|(_, row)| Some(&row.form) == form).or_else(|| rows().next());
            match found {
                Some((row, _)) => state.modal.activate(of, new, Some(row)),
                None if row.is_none() => state.modal.activate(of, new, None),
                None => {}
            }
        }
        state.secondary = state.says_secondary();
        (state.cycle, state.arcs) = (Cycle::new(machine), ArcState::default());
        *state.threads = ThreadingState::new(machine);
        state.others.turning = TurningState::new(machine);
        let channel = machine.channels.iter().find(|channel| channel.number == self.channel.at.channel);
        if let Some(channel) = channel {
            state.place.layout = MotionState::new(machine, channel).layout;
        }
        if !self.channel.state.others.couplings.is_empty() {
            self.keep_couplings();
        }
        self.channel.block.clear();
    }
}
