//! Jumps, loops, calls and returns of the interpreter.

use counterpoint_channel::block_places::block_after;
use counterpoint_channel::callee::Pending;
use counterpoint_control_api::{FlowHost, LoopStack, NamedContour, SubprogramCall};
use counterpoint_fault::{Acted, Halt};
use counterpoint_motion::contour::element::Element;
use counterpoint_motion::turning::strip::Strip;
use counterpoint_program::spot::BlockStart;

use crate::channel::Kernel;

impl FlowHost for Kernel<'_> {
    fn go_to(&mut self, line: u32) -> Acted {
        self.jump_to_line(line)
    }

    fn go_to_block(&mut self, block: BlockStart) -> Acted {
        self.jump_to(block)
    }

    fn sequence(&mut self, number: u32) -> Result<BlockStart, Halt> {
        self.find_sequence(number)
    }

    fn after(&self, block: BlockStart) -> BlockStart {
        block_after(&self.channel, &self.flow, block)
    }

    fn catch_up(&mut self) -> Acted {
        self.flush_lookahead()
    }

    fn loops(&mut self) -> &mut LoopStack {
        &mut self.flow.loops
    }

    fn call(&mut self, call: SubprogramCall) {
        self.ask(Pending::CallText(Box::new(call)));
    }

    fn calls_modally(&mut self, on: bool) {
        self.flow.modal_text = on;
    }

    fn cut_along(&mut self, shape: NamedContour) {
        self.channel.state.others.turning.shape = Some(shape);
    }

    fn read_contour(&mut self, call: SubprogramCall) {
        self.ask(Pending::ReadContour(Box::new(call)));
    }

    fn reads_contour(&self) -> bool {
        self.channel.state.others.turning.reads
    }

    fn contour(&self) -> &[Element] {
        &self.channel.state.others.turning.kept.elements
    }

    fn contour_heights(&self) -> Option<&[[f64; 2]]> {
        let kept = &self.channel.state.others.turning.kept;
        let plane = kept.plane.as_ref()?;
        let mut across = self.channel.state.place.layout.cartesian.iter().flatten();
        let across = across.find(|axis| !plane.axes.contains(axis))?;
        let coded = kept.first?.coded & 1_u8.checked_shl(u32::try_from(across.index()).ok()?)? != 0;
        coded.then_some(&kept.heights[..])
    }

    fn contour_begins_rapid(&self) -> bool {
        self.channel.state.others.turning.kept.first.is_some_and(|first| first.rapid)
    }

    fn remove_stock(&mut self, strip: Strip) {
        self.ask(Pending::Strip(Box::new(strip)));
    }

    fn return_from(&mut self) {
        self.ask(Pending::Return(None));
    }

    fn continue_block(&mut self) {
        self.dialect.left.continues = true;
    }

    fn watch(&mut self, on: bool) {
        self.flow.watched = on;
    }

    fn effect(&mut self) {
        self.flow.pass.effects = true;
    }

    fn tests_loop(&mut self, on: bool) {
        self.flow.pass.condition = on;
    }
}
