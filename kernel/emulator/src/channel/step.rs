//! Places where an operator may stop a kernel: before a block, at a wait, after a write of a variable that channels
//! share.
//!
//! *Invariant:* nothing here changes the next action of the kernel, except a reset; a kernel without stepping never
//! gets here.

use counterpoint_channel::addresses::shown_words;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_event::SourcePlace;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_ports::dialog::answers::DialogValue;
use counterpoint_ports::step::{Go, KernelSnapshot, StepEvent, Stepper};
use counterpoint_sync::shared::SharedState;
use counterpoint_sync::wait;

use super::Kernel;
use crate::channel::dialect_state::DialectState;
use crate::channel::parts::Ports;

/// Most variables that are shown.
const MOST: usize = 1000;

impl Kernel<'_> {
    /// The job is to end, is suspended, or is stepped through. `goes_on`: the job has not been stopped before this
    /// block.
    #[cold]
    #[inline(never)]
    pub(crate) fn interfered(&mut self, goes_on: bool) -> Acted {
        self.ports.control.wait_while_suspended();
        if !goes_on || self.ports.control.cancelled() {
            return Err(Halt::Stopped);
        }
        let Some(stepper) = self.ports.stepper else { return Ok(()) };
        let hidden = hides_block(&self.channel, &mut self.flow, &self.dialect);
        let at = &self.channel.at;
        if (at.caller.is_some() || hidden) && !stepper.breaks_at(SourcePlace::new(at.file, at.line)) {
            // Steps go over the blocks of resident programs.
            return Ok(());
        }
        let (channel, clock) = (self.channel.at.channel, self.channel.emitter.bound(&self.channel.at));
        let first = self.ports.coordinator.is_furthest_behind(channel, clock);
        let variables = &self.dialect.variables;
        let place =
            snapshot_of_place(&self.channel, &self.flow, SourcePlace::new(self.channel.at.file, self.channel.at.line));
        if stepper.stands(&place, first, (variables.writes(), &|| variables.with_value(MOST))) {
            return Ok(());
        }
        wait_for_operator(&self.channel, &self.macros, &self.ports, stepper);
        if self.ports.control.cancelled() || !self.ports.coordinator.publish(channel, clock) {
            return Err(Halt::Stopped);
        }
        match stepper.goes(channel) {
            Go::On => Ok(()),
            Go::Reset => {
                self.channel.reports.reset = true;
                let text = format!("channel {channel} is reset by the operator before '{}'", self.channel.block_text());
                Err(self.fatal(&diag::CHANNEL_RESET, text))
            }
        }
    }

    /// The kernel comes to a wait.
    #[cold]
    #[inline(never)]
    pub(super) fn comes_to_wait(&mut self, wait: &wait::Wait) {
        if !self.ports.stepper.is_some_and(Stepper::listens) {
            return;
        }
        let known = self.channel.reports.waits.wait(wait);
        self.comes_to(StepEvent::Wait(&known, wait.key.number));
    }

    /// Called when the kernel has written data that all channels share.
    #[cold]
    #[inline(never)]
    pub(super) fn has_written(&mut self, door: SharedTarget<'_>) {
        if !self.ports.stepper.is_some_and(Stepper::listens) {
            return;
        }
        let Some(variable) = door.variable() else { return };
        let name = self.macros.variable_name(&variable);
        let value = self.ports.coordinator.unordered(|order| match door {
            SharedTarget::Common(index) => order.shared.variables.get(&index).copied(),
            _ => None,
        });
        self.comes_to(StepEvent::Write(&name, value));
    }

    fn comes_to(&mut self, event: StepEvent<'_>) {
        let Some(stepper) = self.ports.stepper.filter(|_| self.channel.at.channel > 0) else { return };
        if !self.ports.control.cancelled()
            && stepper.comes_to(event, &mut || snapshot(&self.channel, &self.flow, &self.dialect))
        {
            wait_for_operator(&self.channel, &self.macros, &self.ports, stepper);
        }
    }
}

/// Whether steps go over the block because its program hides its blocks. Reads statements that hide or show blocks.
fn hides_block(channel: &ChannelContext<'_>, flow: &mut ProgramFlow, dialect: &DialectState) -> bool {
    let at = &channel.at;
    let running = flow.frames.len();
    flow.hidden_from = flow.hidden_from.filter(|from| *from <= running);
    let source = channel.env.sources.get(at.file);
    let line = |line| source.map(|source| source.line(line)).unwrap_or_default();
    // The declaration comes after the head of the program and its first comments.
    let is_head = |text: &[u8]| matches!(text.trim_ascii_start().first(), None | Some(b'%' | b';'));
    let begins = flow.frames.last().is_some_and(|frame| frame.range.first == at.line);
    let last = flow.frames.last().filter(|_| begins).map_or(at.line, |frame| frame.range.last);
    let declared = (at.line..=last).map(line).find(|text| !is_head(text));
    let text = declared.unwrap_or_default();
    match dialect.interpreter.as_deref().and_then(|interpreter| interpreter.shows_blocks(text)) {
        Some(true) => flow.hidden_from = None,
        Some(false) => flow.hidden_from = flow.hidden_from.or(Some(running)),
        None => {}
    }
    flow.hidden_from.is_some()
}

/// Waits until the operator lets this kernel continue.
fn wait_for_operator(channel: &ChannelContext<'_>, macros: &Runtime, ports: &Ports<'_>, stepper: &dyn Stepper) {
    let coordinator = ports.coordinator;
    if !coordinator.pause_for_step() {
        let globals = &macros.program.globals;
        stepper.hold_alone(channel.at.channel, &mut || coordinator.unordered(|order| common(&order.shared, globals)));
    }
}

fn snapshot(channel: &ChannelContext<'_>, flow: &ProgramFlow, dialect: &DialectState) -> KernelSnapshot {
    KernelSnapshot {
        variables: dialect.variables.with_value(MOST),
        ..snapshot_of_place(channel, flow, channel.at.user_place())
    }
}

/// The same without variables.
fn snapshot_of_place(channel: &ChannelContext<'_>, flow: &ProgramFlow, place: SourcePlace) -> KernelSnapshot {
    let at = &channel.at;
    KernelSnapshot {
        channel: at.channel,
        file: place.file,
        line: place.line,
        level: flow.frames.len().saturating_sub(1) as u32,
        t_ns: at.clock,
        position: channel.state.place.position,
        variables: Vec::new(),
        words: shown_words(channel, flow),
    }
}

/// Variables that all channels share and that have a value: numbered ones, named ones, GLOBALs of macros by their
/// names.
pub fn common(shared: &SharedState, globals: &[String]) -> Vec<(String, DialogValue)> {
    let mut numbers: Vec<_> = shared.variables.iter().map(|(number, value)| (*number, *value)).collect();
    numbers.sort_unstable_by_key(|(number, _)| *number);
    let mut named: Vec<_> = shared.named.iter().filter_map(|(name, value)| Some((&**name, shown(value)?))).collect();
    named.sort_unstable_by_key(|(name, _)| *name);
    let numbers = numbers.into_iter().map(|(number, value)| (format!("#{number}"), DialogValue::Number(value)));
    let named = named.into_iter().map(|(name, value)| (name.to_owned(), value));
    let globals = globals.iter().zip(&shared.globals).filter_map(|(name, value)| Some((name.clone(), shown(value)?)));
    numbers.chain(named).chain(globals).take(MOST).collect()
}

/// A value short enough to be read at a glance.
fn shown(value: &MacroValue) -> Option<DialogValue> {
    match value {
        MacroValue::Real(number) => Some(DialogValue::Number(*number)),
        MacroValue::Logical(flag) => Some(DialogValue::Flag(*flag)),
        MacroValue::Text(text) => Some(DialogValue::Text(text.to_string())),
        _ => None,
    }
}
