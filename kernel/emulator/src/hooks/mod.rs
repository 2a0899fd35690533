//! The steps of machine macros in the processing of a block, its codes, its events and its program.
//!
//! *Invariant:* the kernel reaches these functions through [`POINTS`] of its plan, so that nothing below depends on
//! them.

mod block;
mod codes;
mod components;
mod embedded;
mod events;
mod nested;
mod program;
mod remarks;
mod run;
mod subprogram;

use crate::channel::hook_points::{BlockHooks, CodeHooks, HookPoints, ProgramHooks};

/// The points of a machine with macros.
pub static POINTS: HookPoints = HookPoints {
    block: BlockHooks {
        next: |kernel| kernel.change_component().or_else(|| kernel.next_issued()),
        begin: |kernel| {
            kernel.channel.context.begin(None);
            kernel.macros.variables.store.number = 0;
        },
        edit: |kernel| kernel.edit_block(),
        preprocessed: |kernel| kernel.after_preprocessor(),
        made: |kernel| kernel.words_as_text(),
        reads_left: |kernel| kernel.reads_left(),
        statement: |kernel, text| kernel.remarks_of_statement(text),
        consumed: |kernel| kernel.consumed_block(),
        words: |kernel| kernel.before_codes(),
        remarks: |kernel| kernel.remarks_of_block(),
    },
    codes: CodeHooks {
        begin: |kernel, origin| kernel.begin_codes(origin),
        implied: |kernel| kernel.imply_by_data(),
        act: |kernel, code, id| kernel.act_with_macros(code, id),
        acted: |kernel| kernel.pending_halt(),
        take: |kernel, id| kernel.take_with_macros(id),
        end: |kernel, origin| kernel.end_codes(origin),
        dropped: |kernel| kernel.drop_added_data(),
    },
    program: ProgramHooks {
        start: |kernel| kernel.begin_macros(),
        call: |kernel, called, found| {
            let level = kernel.flow.frames.len();
            kernel.subprogram_startup(called, 0, found, level)
        },
        next_pass: |kernel| kernel.next_pass(),
        returned: |kernel, called, place| {
            let (last, level) = (called.passes.saturating_sub(1), kernel.flow.frames.len());
            kernel.subprogram_shutdown(called, last, place, level)
        },
    },
    moved: |kernel, seconds, motion| kernel.book_motion(seconds, motion),
    motion: |kernel, seconds, motion| kernel.motion_event(seconds, motion),
};
