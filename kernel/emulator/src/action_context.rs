//! Everything that an action may access: the channel, and a few services of the kernel that it belongs to.
//!
//! *Invariant:* an action cannot reach the flow of the program, the machine's macros, the plan or the coordinator. The
//! kernel executes its requests to them, calls and ends at the end of the block.

use std::sync::Arc;

use crate::channel::Kernel;
use crate::channel::custom_macro::code_calls::take_name;
use crate::pipeline::codes::without_action;
use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::channel_axis::ChannelAxis;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::coupled_axes::couples_alone;
use counterpoint_channel::coupling::Parking;
use counterpoint_channel::cycle::CycleHole;
use counterpoint_channel::figure::CopiedFigure;
use counterpoint_channel::frame_transforms::PolarInterpolation;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_channel::offset_tables::OffsetTable;
use counterpoint_channel::tool_data::report_tool;
use counterpoint_channel::trace::{trace_instead, trace_line};
use counterpoint_channel::turning::ContourCycle;
use counterpoint_channel::word_values::{axis_diameter_factor, block_has, read_words_again};
use counterpoint_control_api::{NotThere, is_vacant};
use counterpoint_event::event::{FeedUnit, Motion, Position, ToolAction};
use counterpoint_fault::{Acted, DiagnosticFacts, Halt, StopCode};
use counterpoint_machine::ident::{CodeId, DataId, data};
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::macros::model::Hook;
use counterpoint_motion::law::SpindleRotation;
use counterpoint_program::block::RetrievedValue;
use counterpoint_program::data_plan::DataSource;
use counterpoint_sync::shared::SpindleCommand;
use counterpoint_sync::wait;
use counterpoint_sync::wait::Wait;
use counterpoint_waits::coupling::CoupledPair;

/// The context of an action.
pub struct ActionContext<'k, 'a> {
    kernel: &'k mut Kernel<'a>,
}

impl<'k, 'a> ActionContext<'k, 'a> {
    /// Reads the numbers of the block again, in the unit that the block has selected. Reports values of the part that
    /// may be in the other unit.
    pub fn unit_selected(&mut self, inch: bool) -> Acted {
        read_words_again(&mut self.kernel.channel);
        crate::channel::part_data::check(self.kernel, inch)
    }

    /// The context of an action of this kernel.
    #[inline(always)]
    pub fn new(kernel: &'k mut Kernel<'a>) -> Self {
        Self { kernel }
    }

    /// The data of the channel.
    #[inline(always)]
    pub fn channel(&self) -> &ChannelContext<'a> {
        &self.kernel.channel
    }

    /// The data of the channel, mutable.
    #[inline(always)]
    pub fn channel_mut(&mut self) -> &mut ChannelContext<'a> {
        &mut self.kernel.channel
    }
}

/// Data of the block.
impl ActionContext<'_, '_> {
    /// Takes the value of `id` off the block, if it is there.
    #[inline(always)]
    pub fn take(&mut self, id: DataId) -> Option<RetrievedValue> {
        self.kernel.take(id)
    }

    /// Takes the program name off the block.
    pub fn take_name(&mut self) -> Option<Arc<str>> {
        take_name(&mut self.kernel.channel)
    }

    /// Value of a common variable, 0 without one.
    pub fn common(&mut self, number: u32) -> Result<f64, Halt> {
        match self.kernel.numbered(number) {
            Err(NotThere::Halt(halt)) => Err(halt),
            value => Ok(value.ok().filter(|value| !is_vacant(*value)).unwrap_or(0.0)),
        }
    }

    /// Writes a common variable; nothing on a machine without it.
    pub fn set_common(&mut self, number: u32, value: f64) -> Acted {
        match self.kernel.set_numbered(number, value) {
            Err(NotThere::Halt(halt)) => Err(halt),
            _ => Ok(()),
        }
    }

    /// Whether a value of `id` is in the block.
    #[inline]
    pub fn block_has(&self, id: DataId) -> bool {
        block_has(&self.kernel.channel, id)
    }

    /// Whether a free word that can move an axis or shape an arc is in the block.
    #[inline]
    pub fn has_motion_word(&self) -> bool {
        self.channel().block.has_any(self.kernel.channel.tables.registers.motion)
    }

    /// Whether a free word of an axis is in the block.
    #[inline]
    pub fn has_axis_word(&self) -> bool {
        let axes =
            self.channel().state.place.layout.axes.iter().fold(0, |bits, axis| bits | self.registers_of(axis.data));
        self.channel().block.has_any(axes)
    }

    /// Registers of corners and of directions of lines.
    #[inline]
    pub fn contour_registers(&self) -> counterpoint_program::registers::ContourRegisters {
        self.kernel.channel.tables.registers.contour
    }

    /// Where the values of an identifier come from.
    #[inline]
    pub fn sources(&self, id: DataId) -> &[DataSource] {
        self.kernel.channel.tables.sources_of(id)
    }

    /// Registers that can supply an identifier, bit by register.
    #[inline]
    pub fn registers_of(&self, id: DataId) -> u128 {
        self.kernel.channel.tables.registers_of(id)
    }

    /// Factor from programmed positions of an axis to its own, where programs choose between diameter and radius.
    #[inline]
    pub fn axis_diameter_factor(&self, axis: AxisSlot) -> f64 {
        axis_diameter_factor(&self.kernel.channel, axis)
    }

    /// Whether the lead of a thread and the feed per revolution are one word that stays active.
    #[inline]
    pub fn lead_is_feed(&self) -> bool {
        self.kernel.channel.tables.rules.lead_is_feed
    }

    /// Feed of the active mode: the word in the block, otherwise the remembered one.
    #[inline]
    pub fn active_feed(&mut self) -> (Option<f64>, FeedUnit) {
        let (id, unit) = feed_of(self.channel().state.modal.code(group::FEED));
        match self.take(id) {
            Some(datum) => {
                self.channel_mut().state.remembered.remember(id, datum.value);
                (Some(datum.value), unit)
            }
            // Inverse time belongs to its block alone.
            None if unit == FeedUnit::InverseTime => (None, unit),
            None => (self.channel().state.remembered.value(id), unit),
        }
    }

    /// Takes the word of an axis of the interpolation, in the axis's own unit.
    pub fn take_polar(&mut self, polar: PolarInterpolation, axis: AxisSlot) -> Option<RetrievedValue> {
        let ChannelAxis { data: id, scale, .. } = self.channel().state.place.layout.axes[axis];
        let registers = |id: DataId| self.registers_of(id);
        if polar.cartesian && axis != polar.rotary && registers(id) & registers(data::C2P_INTERP_Y) != 0 {
            // A word across is none of the axis that has its letter.
            return None;
        }
        let own = match (axis == polar.linear, axis == polar.rotary, polar.cartesian) {
            (true, ..) if polar.is_cylinder() => None,
            (true, _, true) => Some(data::C2P_INTERP_X),
            (true, _, false) => Some(data::C2P_INTERP_PLRX),
            (_, true, true) => Some(data::C2P_INTERP_Y),
            _ => None,
        };
        // The words of the interpolation are radii.
        let scale = if polar.is_cylinder() { 1.0 } else { scale };
        let radius =
            own.and_then(|own| self.take(own)).map(|datum| RetrievedValue { value: datum.value / scale, ..datum });
        let spare =
            axis == polar.rotary && polar.cartesian && self.channel().state.place.axis_of_data(data::AXIS_Y).is_none();
        let across = radius.or_else(|| if spare { self.take(data::AXIS_Y) } else { None });
        across.or_else(|| {
            // A word of the rotary axis itself is in degrees, but the value taken here is the length along the circle.
            let degrees = axis == polar.rotary && polar.cartesian;
            let way = polar.per_degree().filter(|_| degrees).unwrap_or(1.0);
            self.take(id).map(|datum| RetrievedValue { value: datum.value * way, ..datum })
        })
    }

    /// Reports which of the data that an action could have used have rows that are all switched off.
    pub fn report_switched_off(&mut self, ids: &[DataId]) {
        self.kernel.report_switched_off(ids);
    }
}

/// Events and diagnostics.
impl ActionContext<'_, '_> {
    /// Logs a diagnostic at the current block.
    pub fn diagnose(&mut self, facts: &DiagnosticFacts, text: impl Into<String>) {
        self.kernel.diagnose(facts, text);
    }

    /// Logs an alarm of the control and returns its effect.
    pub fn alarm(&mut self, facts: &DiagnosticFacts, text: impl Into<String>) -> Halt {
        self.kernel.alarm(facts, text)
    }

    /// A code that nothing handles.
    pub fn without_action(&mut self, id: CodeId) {
        without_action(self.kernel, id);
    }

    /// Adds a line to the trace if it shows this letter.
    pub fn trace(&mut self, letter: char, line: impl FnOnce(&ChannelContext<'_>) -> String) {
        trace_line(&mut self.kernel.channel, letter, line);
    }

    /// Adds an action to the trace that takes the place of that of the next event.
    pub fn trace_instead(&mut self, text: &str) {
        trace_instead(&mut self.kernel.channel, text);
    }

    /// Records that the block has an effect that an endless loop could not hide.
    #[inline]
    pub fn note_effect(&mut self) {
        self.kernel.flow.pass.effects = true;
    }

    /// The block has let time pass, and nothing else, ns.
    pub fn note_dwell(&mut self, ns: i64) {
        self.kernel.flow.pass.dwell(ns);
    }

    /// Counts as much work as a block within this one.
    ///
    /// # Errors
    /// The job is to end.
    pub fn count_as_block(&mut self) -> Acted {
        self.kernel.count_as_block()
    }
}

/// The machine: motions, spindle, tools, heads, cycles. Its macros see them.
impl ActionContext<'_, '_> {
    /// Executes a motion.
    #[inline(always)]
    pub fn travel(&mut self, seconds: f64, motion: &Motion) -> Acted {
        self.kernel.travel(seconds, motion)
    }

    /// Reports a circle that turns an axis back beyond its limits, at `values` in radius.
    pub fn check_swing(&mut self, to: &Position, axis: AxisSlot, values: [Option<f64>; 2]) -> Acted {
        self.kernel.check_swing(to, axis, values)
    }

    /// Executes a motion that its macro has seen.
    #[inline]
    pub fn move_to(&mut self, seconds: f64, motion: &Motion) -> Acted {
        self.kernel.move_to(seconds, motion)
    }

    /// Commanded state of the channel's spindle as of now.
    pub fn spindle_command(&mut self) -> Result<SpindleCommand, Halt> {
        self.kernel.current()
    }

    /// How the spindle turns now, `None` while it does not.
    pub fn spindle_speed(&mut self) -> Result<Option<SpindleRotation>, Halt> {
        self.kernel.spindle_speed()
    }

    /// How the spindle turns during a time by its revolutions that begins now, `None` while it does not turn.
    pub fn speed_from_now(&mut self) -> Result<Option<SpindleRotation>, Halt> {
        self.kernel.speed_from_now()
    }

    /// The same for a cut, which begins together with that of the other channel in balance cutting.
    #[inline]
    pub fn speed_of_cut(&mut self) -> Result<Option<SpindleRotation>, Halt> {
        self.kernel.speed_of_cut()
    }

    /// Records that the time of a block of this many seconds, which begins now, uses the spindle speed known now.
    #[inline]
    pub fn assume_speed(&mut self, seconds: f64) {
        if self.channel().state.spindle.shared && !self.channel().reports.plausible.changed_speed {
            let (line, begin) = (self.channel().at.line, self.channel().now());
            self.channel_mut().state.spindle.assume(line, begin, seconds);
        }
    }

    /// Compares the spindle speed during the last revolution-timed move with the speed assumed for it.
    #[inline]
    pub fn compare_last_speed(&mut self) -> Acted {
        self.kernel.compare_last_speed()
    }

    /// Changes the command of the spindle, logs it, and lets the spindle run up.
    pub fn command_spindle(&mut self, change: impl Fn(&mut SpindleCommand)) -> Acted {
        self.kernel.command_spindle(change)
    }

    /// Selects or loads a tool, or changes its offset.
    pub fn tool_event(&mut self, action: ToolAction, tool: u32, offset: u32, ns: i64) -> Acted {
        self.kernel.tool_event(action, tool, offset, ns)
    }

    /// Reports the known data of the active tool if they have changed.
    pub fn report_tool(&mut self) {
        report_tool(&mut self.kernel.channel, &self.kernel.macros, self.kernel.plan.hooks.is_some());
    }

    /// Tools and heads have a macro that is on.
    pub fn has_tool_macro(&self) -> bool {
        self.kernel.macros.ready(Hook::Tool).is_some()
    }

    /// Selects (1) or loads (2) a head.
    pub fn head_event(&mut self, kind: f64, id: u32) -> Acted {
        self.kernel.head_event(kind, id)
    }

    /// Makes a hole, by way of its macro if there is one.
    pub fn cycle_event(&mut self, hole: &CycleHole) -> Acted {
        self.kernel.cycle_event(hole)
    }

    /// Whether a macro of the machine is running.
    pub fn is_inside_macro(&self) -> bool {
        !self.kernel.macros.calls.running.is_empty()
    }

    /// Makes the sum of all offsets active; the machine does not move.
    pub fn reframe(&mut self) {
        self.kernel.reframe();
    }

    /// Sets an offset; `false` when there is no room for it or it is out of all bounds.
    pub fn set_offset(&mut self, table: OffsetTable, number: u32, values: counterpoint_event::event::Position) -> bool {
        self.kernel.set_offset(table, number, values)
    }

    /// Finishes the move that compensation keeps back, without knowing the next one.
    #[inline]
    pub fn flush_lookahead(&mut self) -> Acted {
        self.kernel.flush_lookahead()
    }

    /// Takes whole turns off the position of an axis; nothing moves.
    pub fn unwind_axis(&mut self, axis: AxisSlot, modulo: counterpoint_channel::clamps::Modulo) {
        self.kernel.unwind_axis(axis, modulo);
    }
}

/// Requests to the flow of the program, which act at the end of the block, and to the other channels.
impl ActionContext<'_, '_> {
    /// Subprograms that are running, with the main program.
    pub fn call_depth(&self) -> usize {
        self.kernel.flow.frames.len()
    }

    /// Passes of a repeat word.
    pub fn passes(&mut self, count: f64) -> u32 {
        self.kernel.passes(count)
    }

    /// Calls a program by its number.
    pub fn call_program(&mut self, number: u32, passes: u32) {
        self.call(Callee::Program(number), passes);
    }

    /// Calls a program whose passes are copies of a figure.
    pub fn call_figure(&mut self, program: u32, passes: u32, figure: Box<CopiedFigure>) {
        self.kernel.ask(Pending::Figure { program, passes, figure });
    }

    /// Calls a program by its number, from a sequence number on.
    pub fn call_program_from(&mut self, number: u32, first: u32, passes: u32) {
        self.call(Callee::ProgramFrom(number, first), passes);
    }

    /// Calls a program by its name.
    pub fn call_named(&mut self, name: Arc<str>, passes: u32) {
        self.call(Callee::Named(name), passes);
    }

    fn call(&mut self, what: Callee, passes: u32) {
        self.kernel.ask(Pending::Call { what, passes, arguments: None, by: None });
    }

    /// Calls the blocks from one label or sequence number to another in the current file.
    pub fn call_range(&mut self, by_labels: bool, (first, last): (u32, u32), passes: u32) {
        let what = if by_labels { Callee::Labels(first, last) } else { Callee::Blocks(first, last) };
        self.kernel.ask(Pending::CallRange { what, passes });
    }

    /// Calls the blocks of the current program from a sequence number to its return.
    pub fn call_from(&mut self, first: u32, passes: u32) {
        self.kernel.ask(Pending::CallRange { what: Callee::From(first), passes });
    }

    /// Returns from the subprogram, optionally to a sequence number of the caller.
    pub fn return_from(&mut self, target: Option<u32>) {
        self.kernel.ask(Pending::Return(target));
    }

    /// Cuts along contour blocks of the program.
    pub fn cut_contour(&mut self, cycle: ContourCycle) {
        self.kernel.ask(Pending::Contour(Box::new(cycle)));
    }

    /// Passes the data blocks that follow.
    pub fn pass_data_blocks(&mut self) {
        self.kernel.ask(Pending::DataBlocks);
    }

    /// Ends the program.
    pub fn end_program(&mut self, stop: StopCode) {
        self.kernel.ask(Pending::End(stop));
    }

    /// Waits for other channels.
    pub fn wait_for(&mut self, wait: Wait) -> Acted {
        self.kernel.wait(wait)
    }

    /// Couples axes of this channel and another one.
    pub fn couple(&mut self, pair: CoupledPair, parking: Parking) -> Acted {
        self.kernel.couple(pair, parking)
    }

    /// The same where the program of this channel alone has the code.
    pub fn couple_alone(&mut self, pair: CoupledPair, parking: Parking) -> Acted {
        self.kernel.couple_alone(pair, parking)
    }

    /// Ends a coupling that only this channel has commanded.
    pub fn end_alone(&mut self, pair: CoupledPair) -> Acted {
        self.kernel.end_alone(pair)
    }

    /// Whether the program of this channel alone has the code of synchronous control.
    pub fn couples_alone(&mut self) -> bool {
        couples_alone(&mut self.kernel.channel, &self.kernel.flow)
    }

    /// Ends a coupling.
    pub fn end_coupling(&mut self, pair: CoupledPair) -> Acted {
        self.kernel.end_coupling(pair)
    }

    /// The alarm for a code that is not allowed for an axis to which moves are added, if one of these is such an axis.
    pub fn added_to(&mut self, moved: u8, alarm: &str) -> Acted {
        self.kernel.added_to(moved, alarm)
    }

    /// Executes an act at which other channels may continue; it is shown as this wait would be.
    pub fn let_continue(&mut self, deed: wait::WaitOp, shown: Wait) -> Acted {
        self.kernel.let_continue(deed, shown)
    }
}
