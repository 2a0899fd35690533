//! A channel of a composite machine changes its component: `$FAPPLY`.
//!
//! Facts: reference control-emulator.md 8.3, functions.md 9. Decisions: the change takes place before the next block,
//! after the remaining actions of the macros of the block in process. The component's Declaration runs when it is first
//! active. Modal codes that the new component has in the same group stay active, all others are its initial codes, and
//! no canned cycle stays active. Blocks that EXEC/NEXT has queued are those of the new component.

use counterpoint_channel::arc::ArcState;
use counterpoint_channel::context::BlockContext;
use counterpoint_channel::coupled_axes::keep_couplings;
use counterpoint_channel::cycle::Cycle;
use counterpoint_channel::modal::{ModalCodes, group};
use counterpoint_channel::position::MotionState;
use counterpoint_channel::queued_codes::initial_codes;
use counterpoint_channel::thread::ThreadingState;
use counterpoint_channel::turning::TurningState;
use counterpoint_control_api::LoopStack;
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::channel::components::Resting;
use counterpoint_emulator::channel::dialect_state::DialectState;
use counterpoint_event::event::{Kind, OperatorMessage};
use counterpoint_fault::Acted;
use counterpoint_machine::Machine;
use counterpoint_machine::macros::model::Hook;

use crate::context::MacroHooks;

/// Changes the component, if a macro has requested another one and none is running; none if nothing is to be done.
pub(crate) fn change_component(hooks: &mut MacroHooks<'_, '_>) -> Option<Acted> {
    hooks.kernel.components.turns.wanted?;
    if !hooks.kernel.macros.calls.running.is_empty() {
        return None;
    }
    let to = hooks.kernel.components.turns.wanted.take()?;
    // A change counts as a block, so that startup macros that ask for each other indefinitely reach a limit.
    hooks.kernel.channel.at.blocks += 1;
    hooks.kernel.channel.at.idle_blocks += 1;
    let done = hooks.kernel.check_limits().and_then(|()| take_component(hooks, to));
    Some(done.and_then(|()| hooks.kernel.follow()))
}

fn take_component(hooks: &mut MacroHooks<'_, '_>, to: usize) -> Acted {
    hooks.plain_macro(Hook::ProgramShutdown)?;
    hooks.kernel.flush_lookahead()?;
    let Some(next) = hooks.kernel.components.all.get(to).copied() else { return Ok(()) };
    let turns = &mut hooks.kernel.components.turns;
    let left = turns.now.replace(to);
    turns.before = left;
    let known = turns.kept.iter().position(|(place, _)| *place == to).map(|at| turns.kept.swap_remove(at).1);
    let first = known.is_none();
    let mut old = std::mem::replace(&mut hooks.kernel.macros, known.unwrap_or_default());
    let before = hooks.kernel.channel.env.machine;
    (hooks.kernel.channel.env.machine, hooks.kernel.plan) = (next.machine, next.plan);
    hooks.kernel.channel.state.times.record_motions(next.plan.hooks.is_some());
    (hooks.kernel.channel.tables, hooks.kernel.channel.context) = (&next.plan.tables, BlockContext::default());
    if first {
        hooks.set_up_macros(next.macros);
    }
    let (new, shown) = (&mut *hooks.kernel.macros, &mut *old);
    std::mem::swap(&mut new.issued, &mut shown.issued);
    std::mem::swap(&mut new.books, &mut shown.books);
    std::mem::swap(&mut new.tools, &mut shown.tools);
    new.variables.store.continue_counts(&shown.variables.store);
    if let Some(left) = left {
        hooks.kernel.components.turns.kept.push((left, old));
    }
    take_preprocessor(hooks.kernel, before)?;
    fit_state(hooks.kernel, before);
    hooks.kernel.channel.text.tape = (
        next.plan.tables.edits.tape.as_ref().map(|tape| tape.start).unwrap_or_default(),
        std::mem::take(&mut hooks.kernel.channel.text.tape.1),
    );
    let text = format!("component {}", next.name).into();
    hooks.kernel.channel.emit(0, Kind::Message(OperatorMessage { text, printed: false }));
    if first {
        hooks.plain_macro(Hook::Declaration)?;
    }
    hooks.plain_macro(Hook::ProgramStartup)
}

/// Variables, loops and interpreter of the new pre-processor, if it is another one; it reads the texts of the
/// programs that run in its own way.
fn take_preprocessor(kernel: &mut Kernel<'_>, before: &Machine) -> Acted {
    let machine = kernel.channel.env.machine;
    if machine.preprocessor == before.preprocessor {
        return Ok(());
    }
    let levels: Vec<bool> = kernel.flow.frames.iter().skip(1).map(|frame| frame.own_variables).collect();
    let resting = &mut kernel.components.turns.dialects;
    let known = resting.iter().position(|one| one.of == machine.preprocessor).map(|at| resting.swap_remove(at));
    let first = known.is_none();
    let next = known.unwrap_or_else(|| Resting {
        of: machine.preprocessor,
        dialect: DialectState::new(machine, !kernel.channel.env.options.lint),
        loops: LoopStack::default(),
        levels: Vec::new(),
    });
    resting.push(Resting {
        of: before.preprocessor,
        dialect: std::mem::replace(&mut kernel.dialect, next.dialect),
        loops: std::mem::replace(&mut kernel.flow.loops, next.loops),
        levels: levels.clone(),
    });
    (kernel.flow.known.labels, kernel.flow.known.tables) = (Default::default(), 0);
    kernel.flow.known.programs = Default::default();
    kernel.flow.known.blocks = Default::default();
    if let Some(rested) = kernel.components.turns.dialects.last() {
        kernel.dialect.variables.follow(&rested.dialect.variables);
    }
    let reader = kernel.channel.env.whole.reader_for(machine.preprocessor);
    kernel.channel.env.sources = kernel.channel.env.sources.by(reader);
    for at in 0..kernel.flow.frames.len() {
        let Some(file) = kernel.flow.frames.get(at).map(|frame| frame.file) else { break };
        kernel.load(file)?;
    }
    if first {
        kernel.interpreter_start();
    }
    follow_levels(kernel, &next.levels, &levels);
    Ok(())
}

/// Subprograms that have returned while another pre-processor worked take their variables with them; those that it
/// has called begin without any.
fn follow_levels(kernel: &mut Kernel<'_>, before: &[bool], now: &[bool]) {
    for own_variables in before.iter().skip(now.len()).rev() {
        if *own_variables {
            kernel.dialect.variables.leave();
        }
        kernel.interpreter_return();
    }
    if before.len() > now.len() {
        kernel.flow.loops.return_to(now.len());
    }
    for own_variables in now.iter().skip(before.len()) {
        if *own_variables {
            kernel.dialect.variables.enter(&[]);
        }
        kernel.interpreter_call();
    }
}

/// Adapts the state to the new definition; the memory of the machine itself stays.
fn fit_state(kernel: &mut Kernel<'_>, before: &Machine) {
    let machine = kernel.channel.env.machine;
    let old = std::mem::replace(&mut kernel.channel.state.modal, ModalCodes::empty());
    let fitted = kernel.channel.state.remembered.fitted(before, machine);
    kernel.channel.state.remembered = fitted;
    initial_codes(&mut kernel.channel);
    let state = &mut kernel.channel.state;
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
    let channel = machine.channels.iter().find(|channel| channel.number == kernel.channel.at.channel);
    if let Some(channel) = channel {
        state.place.layout = MotionState::new(machine, channel).layout;
    }
    if !kernel.channel.state.others.couplings.is_empty() {
        keep_couplings(&mut kernel.channel);
    }
    kernel.channel.block.clear();
}
