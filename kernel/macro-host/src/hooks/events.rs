//! Event macros of motions and tools: the event takes place where its macro executes OUTPUT.
//!
//! Facts: reference control-emulator.md 4.3. Decision: the end of a straight move and rapid or linear may be changed;
//! circles and threads stay as they are.

use counterpoint_channel::ChannelMemory;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::macros::store::{column, names};
use counterpoint_channel::macros::tool_table::MOST_TOOLS;
use counterpoint_emulator::channel::tool_events::load_head;
use counterpoint_event::event::{Motion, MotionKind, Position, ToolAction};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::macros::model::Hook;
use counterpoint_results::geometry::Loop;

use crate::context::MacroHooks;

impl MacroHooks<'_, '_> {
    /// A motion on a kernel with macros.
    #[inline(never)]
    pub(crate) fn motion_event(&mut self, seconds: f64, motion: &Motion) -> Acted {
        let Some(code) = self.kernel.macros.ready(Hook::Motion) else { return self.kernel.move_to(seconds, motion) };
        let round = matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw);
        let kind = match motion.kind {
            MotionKind::ArcCw | MotionKind::ArcCcw | MotionKind::ArcSpace => 1.0,
            MotionKind::Thread => 2.0,
            MotionKind::Rapid => 4.0,
            MotionKind::Linear => 5.0,
        };
        let mut arguments: [MacroValue; 8] = std::array::from_fn(|_| MacroValue::Null);
        arguments[0] = MacroValue::Real(kind);
        arguments[1] = self.ends(code, motion);
        if round {
            let [center, normal, plane] = self.circle(motion);
            arguments[2] = center;
            arguments[3] = normal;
            arguments[5] = MacroValue::Real(if motion.kind == MotionKind::ArcCw { 1.0 } else { 2.0 });
            arguments[6] = plane;
        }
        if motion.kind == MotionKind::ArcSpace {
            let [center, normal, middle] = loop_in_space(&self.kernel.channel, motion);
            (arguments[2], arguments[3], arguments[4]) = (center, normal, middle);
            (arguments[5], arguments[6]) = (MacroValue::Real(2.0), MacroValue::Real(0.0));
        }
        arguments[7] = self.coded(code, motion);
        self.run_macro(code, OutputTask::Motion(seconds, Box::new(*motion)), &mut arguments).map(|_| ())
    }

    /// `$P2`: the end by the six elements of `$AXES`.
    fn ends(&mut self, code: u16, motion: &Motion) -> MacroValue {
        let preset = self.kernel.channel.state.place.preset;
        let runtime = &mut *self.kernel.macros;
        if !runtime.calls.uses(code, 2) {
            return MacroValue::Null;
        }
        let slots = runtime.arguments.slots;
        MacroValue::Sequence(runtime.arguments.positions.with(|values| {
            values.clear();
            values.extend(
                slots.map(|axis| MacroValue::Real(axis.map_or(0.0, |axis| motion.to.at(axis) + preset.at(axis)))),
            );
        }))
    }

    /// `$P8`: axes coded in the block.
    fn coded(&mut self, code: u16, motion: &Motion) -> MacroValue {
        let runtime = &mut *self.kernel.macros;
        if !runtime.calls.uses(code, 8) {
            return MacroValue::Null;
        }
        let slots = runtime.arguments.slots;
        MacroValue::Sequence(runtime.arguments.flags.with(|values| {
            values.clear();
            values.extend(slots.map(|axis| {
                let coded = axis.is_some_and(|axis| motion.moving & axis.bit() != 0);
                MacroValue::Real(f64::from(u8::from(coded)))
            }));
        }))
    }

    /// Centre, plane normal and number of the plane of a circle.
    fn circle(&self, motion: &Motion) -> [MacroValue; 3] {
        let [first, second] =
            motion.plane_axes.map(|axis| self.kernel.channel.state.place.layout.axes.id(usize::from(axis)));
        let cartesian = self.kernel.channel.state.place.layout.cartesian;
        let preset = |axis: AxisSlot| self.kernel.channel.state.place.preset.at(axis);
        let center: Vec<f64> = cartesian
            .iter()
            .map(|axis| match *axis {
                Some(slot) if *axis == first => motion.center[0] + preset(slot),
                Some(slot) if *axis == second => motion.center[1] + preset(slot),
                Some(axis) => motion.to.at(axis) + preset(axis),
                None => 0.0,
            })
            .collect();
        let [x, y, z] = cartesian;
        let has = |axis: Option<AxisSlot>| axis.is_some() && (axis == first || axis == second);
        let (normal, plane) = match (has(x), has(y), has(z)) {
            (true, true, _) => ([0.0, 0.0, 1.0], 1.0),
            (true, _, true) => ([0.0, 1.0, 0.0], 2.0),
            _ => ([1.0, 0.0, 0.0], 3.0),
        };
        [MacroValue::numbers(&center), MacroValue::numbers(&normal), MacroValue::Real(plane)]
    }

    /// OUTPUT of the motion macro.
    pub(crate) fn output_motion(
        &mut self,
        seconds: f64,
        motion: &Motion,
        kind: Option<&MacroValue>,
        end: Option<&MacroValue>,
    ) -> Acted {
        if !matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear) {
            return self.kernel.move_to(seconds, motion);
        }
        let rapid = match kind.and_then(MacroValue::as_real) {
            Some(4.0) => true,
            Some(5.0) => false,
            _ => motion.kind == MotionKind::Rapid,
        };
        let to = self.changed_end(motion, end);
        if to == motion.to && rapid == (motion.kind == MotionKind::Rapid) {
            return self.kernel.move_to(seconds, motion);
        }
        (self.kernel.plan.actions.straight.change)(self.kernel, motion, rapid, to)
    }

    /// The end of a motion with the changes of the macro.
    fn changed_end(&mut self, motion: &Motion, end: Option<&MacroValue>) -> Position {
        let mut to = motion.to;
        let runtime = &*self.kernel.macros;
        let (slots, preset) = (runtime.arguments.slots, self.kernel.channel.state.place.preset);
        let values = match end {
            None => return to,
            Some(MacroValue::Sequence(values)) if values.len() == 6 => values,
            Some(_) => {
                self.kernel.diagnose(&diag::MACRO_RESULT, "$P2 of a motion macro is not a sequence of six numbers");
                return to;
            }
        };
        for (axis, value) in slots.into_iter().zip(values.iter()) {
            let (Some(axis), MacroValue::Real(value)) = (axis, value) else { continue };
            let shift = preset.at(axis);
            if to.at(axis) + shift != *value && value.is_finite() {
                *to.at_mut(axis) = value - shift;
            }
        }
        to
    }

    /// A tool change on a kernel with macros.
    pub(crate) fn tool_event(&mut self, action: ToolAction, tool: u32, offset: u32, ns: i64) -> Acted {
        let Some(code) = self.kernel.macros.ready(Hook::Tool) else {
            return self.kernel.change_tool(action, tool, offset, ns);
        };
        let kind = if action == ToolAction::Select { 1.0 } else { 2.0 };
        let mut arguments = [MacroValue::Real(kind), MacroValue::Real(0.0), MacroValue::Real(f64::from(tool))];
        self.run_macro(code, OutputTask::Tool(action, tool, offset, ns), &mut arguments).map(|_| ())
    }

    /// A head is selected (1) or loaded (2): the tool event macro sees it with `$P2` 1.
    pub(crate) fn head_event(&mut self, kind: f64, id: u32) -> Acted {
        let Some(code) = self.kernel.macros.ready(Hook::Tool) else {
            return load_head(&mut self.kernel.channel, kind, id);
        };
        let mut arguments = [MacroValue::Real(kind), MacroValue::Real(1.0), MacroValue::Real(f64::from(id))];
        self.run_macro(code, OutputTask::Head(kind, id), &mut arguments).map(|_| ())
    }

    /// Assigns a row of the tool table to a loaded tool, with the name set for it.
    fn tool_row(&mut self, tool: u32) {
        let (facts, clock) = (self.kernel.channel.env.machine.tool.facts(tool), self.kernel.channel.now());
        let Runtime { tools, variables, .. } = &mut *self.kernel.macros;
        let (names, store) = (names(), &mut variables.store);
        let Some(at) = tools.load(store, tool, facts) else {
            let text = format!("the tool table is full: it has {MOST_TOOLS} rows");
            return self.kernel.diagnose(&diag::TOOL_TABLE, text);
        };
        let row = at as i64;
        self.kernel.channel.state.times.switch_tool(at, clock);
        store.set(names.tool_row, MacroValue::Real(row as f64));
        store.set(names.tool_rows, MacroValue::Real(tools.loaded().len() as f64 + 1.0));
        let name = store.get(names.tool_name).clone();
        if name.as_text().is_some_and(|name| !name.trim().is_empty()) {
            store.set_element(names.tool_table, (column::NAME, row), name);
        }
        store.set(names.tool_name, MacroValue::text(""));
        let length = store.element(names.tool_table, (column::LENGTH, row)).and_then(MacroValue::as_real);
        store.set(names.tool_length, MacroValue::Real(length.unwrap_or(0.0)));
        tools.sort(store);
    }

    /// Records a loaded tool, and the previous one.
    pub(crate) fn book_tool(&mut self, tool: u32, before: u32) {
        let store = &mut self.kernel.macros.variables.store;
        store.set(names().last_tool, MacroValue::Real(f64::from(before)));
        if store.get(names().first_tool).as_real() == Some(0.0) {
            store.set(names().first_tool, MacroValue::Real(f64::from(tool)));
        }
        self.tool_row(tool);
        let Runtime { books, variables, .. } = &mut *self.kernel.macros;
        books.begin_with_tool(&mut self.kernel.channel, &variables.store);
    }

    /// Writes a motion down for the tables of tools and operations.
    pub(crate) fn book_motion(&mut self, seconds: f64, motion: &Motion) {
        let runtime = &mut *self.kernel.macros;
        runtime.arguments.before = self.kernel.channel.state.place.position;
        let ChannelMemory { times, spindle, .. } = &mut self.kernel.channel.state;
        times.add_motion(&spindle.command, motion.kind == MotionKind::Rapid, (seconds, motion.length));
        runtime.books.note_travel(&self.kernel.channel, motion);
    }
}

/// Centre, normal and middle of a circle in space, which is counter-clockwise about its normal.
fn loop_in_space(channel: &ChannelContext<'_>, motion: &Motion) -> [MacroValue; 3] {
    let axes = channel.env.info.channel(channel.at.channel).map_or(&[][..], |channel| channel.axes.as_slice());
    let Some(space) = Loop::of(motion, axes) else { return std::array::from_fn(|_| MacroValue::Null) };
    let programmed = |point: [f64; 3]| {
        let mut values = [0.0; 3];
        for (axis, value) in space.seen.values(point) {
            let slot = space.seen.coordinate(axis).and_then(|side| values.get_mut(side));
            if let Some((slot, axis)) = slot.zip(channel.state.place.layout.axes.id(axis)) {
                *slot = value + channel.state.place.preset.at(axis);
            }
        }
        MacroValue::numbers(&values)
    };
    [programmed(space.circle.center), MacroValue::numbers(&space.circle.normal), programmed(space.circle.at(0.5))]
}
