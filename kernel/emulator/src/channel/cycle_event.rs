//! The event of a cycle: its macro sees the heights before the first move, and the hole is made where it says OUTPUT.
//!
//! Facts: reference control-emulator.md 4.3. Decision: `$P3` to `$P6` may be changed, in the frame of the motion macro.

use counterpoint_fault::Acted;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::index::BySlot;

use super::Kernel;
use counterpoint_channel::cycle::CycleHole;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::values::code_value;
use counterpoint_machine::macros::model::Hook;

impl Kernel<'_> {
    /// Makes a hole, by way of its macro if there is one.
    pub(crate) fn cycle_event(&mut self, hole: &CycleHole) -> Acted {
        let Some(code) = self.macros.ready(Hook::Cycle) else { return (self.plan.actions.make_hole)(self, hole) };
        let preset = self.channel.state.place.preset.at(hole.axis);
        let height = |value: Option<f64>| value.map_or(MacroValue::Null, |value| MacroValue::Real(value + preset));
        let reference = self.channel.state.cycle.activator.then_some(self.channel.state.cycle.heights.reference);
        let mut arguments = [
            code_value(self.channel.state.cycle.code),
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
        let preset = self.channel.state.place.preset.at(hole.axis);
        let [clear, back, depth, bottom] =
            heights.map(|height| height.filter(|value| value.is_finite()).map(|value| value - preset));
        let hole = CycleHole {
            clear: clear.unwrap_or(hole.clear),
            back: back.unwrap_or(hole.back),
            depth: depth.or(hole.depth),
            bottom: bottom.or(hole.bottom),
            ..hole
        };
        (self.plan.actions.make_hole)(self, &hole)
    }
}
