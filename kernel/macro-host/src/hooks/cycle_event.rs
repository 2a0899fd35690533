//! The event of a cycle: its macro sees the heights before the first move, and the hole is made where it says OUTPUT.
//!
//! Facts: reference control-emulator.md 4.3. Decision: `$P3` to `$P6` may be changed, in the frame of the motion macro.

use counterpoint_channel::cycle::CycleHole;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::values::code_value;
use counterpoint_fault::Acted;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::index::BySlot;
use counterpoint_machine::macros::model::Hook;

use crate::context::MacroHooks;

impl MacroHooks<'_, '_> {
    /// Makes a hole, by way of its macro if there is one.
    pub(crate) fn cycle_event(&mut self, hole: &CycleHole) -> Acted {
        let Some(code) = self.kernel.macros.ready(Hook::Cycle) else {
            return (self.kernel.plan.actions.make_hole)(self.kernel, hole);
        };
        let preset = self.kernel.channel.state.place.preset.at(hole.axis);
        let height = |value: Option<f64>| value.map_or(MacroValue::Null, |value| MacroValue::Real(value + preset));
        let reference =
            self.kernel.channel.state.cycle.activator.then_some(self.kernel.channel.state.cycle.heights.reference);
        let mut arguments = [
            code_value(self.kernel.channel.state.cycle.code),
            height(reference),
            height(Some(hole.clear)),
            height(Some(hole.back)),
            height(hole.depth),
            height(hole.bottom),
        ];
        self.run_macro(code, OutputTask::Cycle(Box::new(*hole)), &mut arguments).map(|_| ())
    }

    /// OUTPUT of the cycle macro: clearance, return, depth and lower clearance as they are now.
    pub(crate) fn output_cycle(&mut self, hole: CycleHole, heights: [Option<f64>; 4]) -> Acted {
        let preset = self.kernel.channel.state.place.preset.at(hole.axis);
        let [clear, back, depth, bottom] =
            heights.map(|height| height.filter(|value| value.is_finite()).map(|value| value - preset));
        let hole = CycleHole {
            clear: clear.unwrap_or(hole.clear),
            back: back.unwrap_or(hole.back),
            depth: depth.or(hole.depth),
            bottom: bottom.or(hole.bottom),
            ..hole
        };
        (self.kernel.plan.actions.make_hole)(self.kernel, &hole)
    }
}
