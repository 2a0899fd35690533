//! The actions of codes: one file for each idea, with its entries in the registry.
//!
//! Facts: reference control-emulator.md 6. Invariants: an action takes its data in the documented order (feed before
//! axes) and never touches another channel except through a shared operation; it reaches its kernel only through `ActionContext`.

mod arc;
mod area;
mod beside;
mod change_point;
mod circular_move;
mod clamp;
mod compensation;
mod context;
mod coolant;
mod corners;
mod couple;
mod cutter;
mod cycle;
mod cylinder;
mod dwell;
mod engrave;
pub(crate) mod entry;
mod execute;
mod feeds;
mod figure;
mod fixed_stop;
mod frame;
mod head;
mod home;
mod improbable;
mod lathe;
mod lengthen;
mod local;
mod local_beside;
mod measure;
mod mode;
mod motion;
mod offset_words;
mod offsets;
mod pocket;
mod polar;
mod polar_words;
mod pole;
mod retract;
mod skip;
mod spindle;
mod spindles;
mod stop;
mod stored;
mod subprogram;
mod sync;
mod thread;
mod tilt;
mod time;
mod tip;
mod tool;
mod tool_offsets;
mod turned;
mod turning;

use counterpoint_channel::turning::ContourTask;
use counterpoint_emulator::channel::actions::Action;
use counterpoint_emulator::channel::actions::ActionTable;
use counterpoint_emulator::channel::actions::CompensationChange;
use counterpoint_emulator::channel::actions::StraightMoves;
use counterpoint_emulator::channel::chucks;
use counterpoint_emulator::channel::paired_spindles;
use counterpoint_machine::ident::CodeId;
use entry::ActionEntry;

use crate::context::ActionContext;
use crate::cutter::end_compensation;
use crate::cutter::flush_due;
use crate::cutter::moves::next_element;
use crate::cutter::resized::resize_compensation;
use crate::cutter::switch_compensation;
use crate::cycle::path::make_hole;
use crate::motion::straight_again;

/// The registry.
static ENTRIES: &[&[ActionEntry]] = &[
    arc::ENTRIES,
    area::ENTRIES,
    beside::ENTRIES,
    change_point::ENTRIES,
    clamp::ENTRIES,
    compensation::ENTRIES,
    coolant::ENTRIES,
    corners::ENTRIES,
    cutter::smooth::ENTRIES,
    couple::ENTRIES,
    cycle::ENTRIES,
    dwell::ENTRIES,
    feeds::ENTRIES,
    figure::ENTRIES,
    fixed_stop::ENTRIES,
    frame::ENTRIES,
    head::ENTRIES,
    home::ENTRIES,
    lathe::ENTRIES,
    lengthen::ENTRIES,
    local::ENTRIES,
    measure::ENTRIES,
    mode::ENTRIES,
    motion::ENTRIES,
    offsets::ENTRIES,
    polar::ENTRIES,
    polar_words::ENTRIES,
    cylinder::ENTRIES,
    pole::ENTRIES,
    engrave::ENTRIES,
    pocket::ENTRIES,
    retract::ENTRIES,
    skip::ENTRIES,
    spindle::ENTRIES,
    spindles::ENTRIES,
    stop::ENTRIES,
    stored::ENTRIES,
    subprogram::ENTRIES,
    sync::ENTRIES,
    thread::ENTRIES,
    thread::cycle::ENTRIES,
    tilt::ENTRIES,
    tip::ENTRIES,
    tool::ENTRIES,
    turning::ENTRIES,
];

/// The built-in actions, as a plan takes them.
pub static ACTIONS: ActionTable = ActionTable { reading: Some(&READING), ..BASE };

/// The actions by which contour blocks are read.
static READING: ActionTable = ActionTable {
    of: lathe::reading,
    speed_word: |_| Ok(()),
    offset_words: |_, _| Ok(()),
    record: Some(|kernel, _, motion| lathe::record(&mut ActionContext::new(kernel), motion)),
    ..BASE
};

const BASE: ActionTable = ActionTable {
    of: |id| {
        find(id).map(|entry| entry as &dyn Action).or_else(|| paired_spindles::find(id)).or_else(|| chucks::find(id))
    },
    flush_lookahead: |kernel| next_element(&mut ActionContext::new(kernel), None),
    flush_due: |kernel, hole| flush_due(&mut ActionContext::new(kernel), hole),
    end_compensation: |kernel, halt| end_compensation(&mut ActionContext::new(kernel), halt),
    change_compensation: |kernel, change| match change {
        CompensationChange::Code => switch_compensation(&mut ActionContext::new(kernel)),
        CompensationChange::Number => resize_compensation(&mut ActionContext::new(kernel)),
    },
    speed_word: |kernel| spindle::speed_word(&mut ActionContext::new(kernel)),
    offset_words: |kernel, free| offset_words::select(&mut ActionContext::new(kernel), free),
    make_hole: |kernel, hole| make_hole(&mut ActionContext::new(kernel), hole),
    reading: None,
    record: None,
    cut_contour: |kernel, cycle, reading| match cycle.task {
        ContourTask::Pocket(pocket) => pocket::cut(&mut ActionContext::new(kernel), &pocket, cycle.feed, reading),
        _ => lathe::cut(&mut ActionContext::new(kernel), cycle, reading),
    },
    strip: |kernel, strip| lathe::strip(&mut ActionContext::new(kernel), strip),
    copy_figure: |kernel, figure, on| figure::put(&mut ActionContext::new(kernel), figure, on),
    straight: StraightMoves {
        back: |kernel, to| lathe::go_back(&mut ActionContext::new(kernel), to),
        along: |kernel, rapid, coded, to| motion::go_straight(&mut ActionContext::new(kernel), rapid, coded, to),
        change: |kernel, motion, rapid, to| straight_again(&mut ActionContext::new(kernel), motion, rapid, to),
        shorten: |kernel, long, to| motion::straight_to(&mut ActionContext::new(kernel), long, false, to),
    },
};

/// The action of a code, if it has a built-in one.
fn find(id: CodeId) -> Option<&'static ActionEntry> {
    ENTRIES.iter().copied().flatten().find(|entry| entry.takes(id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_machine::ident::{self, codes};

    #[test]
    fn a_code_has_one_action_at_most() {
        for facts in codes::TABLE {
            let entries =
                ENTRIES.iter().copied().flatten().filter(|entry| entry.takes(ident::code(facts.name).unwrap()));
            assert!(entries.count() <= 1, "{}", facts.name);
        }
    }
}
