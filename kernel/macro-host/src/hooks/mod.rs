//! The steps of machine macros in the processing of a block, its codes, its events and its program.
//!
//! *Invariant:* the kernel reaches these functions through [`POINTS`] of its plan, so that nothing below depends on
//! them.

mod block;
mod codes;
mod components;
mod cycle_event;
mod embedded;
mod events;
mod nested;
mod program;
mod remarks;
mod run;
mod subprogram;

use counterpoint_machine::macros::model::Hook;

use crate::context::{KernelHost, MacroHooks};
use counterpoint_emulator::channel::hook_points::{BlockHooks, CodeHooks, HookPoints, ProgramHooks};

/// The points of a machine with macros.
pub static POINTS: HookPoints = HookPoints {
    block: BlockHooks {
        next: |kernel| {
            let mut hooks = MacroHooks::new(kernel);
            components::change_component(&mut hooks).or_else(|| hooks.next_issued())
        },
        begin: |kernel| {
            kernel.channel.context.begin(None);
            kernel.macros.variables.store.number = 0;
        },
        edit: |kernel| MacroHooks::new(kernel).edit_block(),
        preprocessed: |kernel| MacroHooks::new(kernel).after_preprocessor(),
        made: |kernel| MacroHooks::new(kernel).words_as_text(),
        reads_left: block::reads_left,
        statement: |kernel, text| MacroHooks::new(kernel).remarks_of_statement(text),
        consumed: |kernel| MacroHooks::new(kernel).consumed_block(),
        words: |kernel| MacroHooks::new(kernel).before_codes(),
        remarks: |kernel| MacroHooks::new(kernel).remarks_of_block(),
    },
    codes: CodeHooks {
        begin: |kernel, origin| MacroHooks::new(kernel).begin_codes(origin),
        implied: |kernel| MacroHooks::new(kernel).imply_by_data(),
        act: |kernel, code, id| MacroHooks::new(kernel).act_with_macros(code, id),
        acted: |kernel| MacroHooks::new(kernel).pending_halt(),
        take: |kernel, id| MacroHooks::new(kernel).take_with_macros(id),
        end: |kernel, origin| MacroHooks::new(kernel).end_codes(origin),
        dropped: |kernel| MacroHooks::new(kernel).drop_added_data(),
    },
    program: ProgramHooks {
        start: |kernel| MacroHooks::new(kernel).begin_macros(),
        call: |kernel, called, found| {
            let level = kernel.flow.frames.len();
            MacroHooks::new(kernel).subprogram_startup(called, 0, found, level)
        },
        next_pass: |kernel| MacroHooks::new(kernel).next_pass(),
        returned: |kernel, called, place| {
            let (last, level) = (called.passes.saturating_sub(1), kernel.flow.frames.len());
            MacroHooks::new(kernel).subprogram_shutdown(called, last, place, level)
        },
        start_again: |kernel| MacroHooks::new(kernel).plain_macro(Hook::ProgramStartup),
        end: |kernel, halt| MacroHooks::new(kernel).end_program(halt),
        close: |kernel, halt| KernelHost::new(kernel).close_files(halt),
    },
    tool: |kernel, action, tool, offset, ns| MacroHooks::new(kernel).tool_event(action, tool, offset, ns),
    head: |kernel, kind, id| MacroHooks::new(kernel).head_event(kind, id),
    loaded: |kernel, tool, before| MacroHooks::new(kernel).book_tool(tool, before),
    cycle: |kernel, hole| MacroHooks::new(kernel).cycle_event(hole),
    identify: |kernel, text, assigned| MacroHooks::new(kernel).ask_identification(text, assigned),
    diagnostic: |kernel, diagnostic, text, stops| KernelHost::new(kernel).issue(diagnostic, text, (None, stops)),
    moved: |kernel, seconds, motion| MacroHooks::new(kernel).book_motion(seconds, motion),
    motion: |kernel, seconds, motion| MacroHooks::new(kernel).motion_event(seconds, motion),
};
