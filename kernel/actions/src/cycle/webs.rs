//! Holes through several webs: at feed through each, at rapid over the gaps between them.
//!
//! Facts: the moves are those of the emulated system's cycle for several webs. Decisions: the data of further webs are
//! this project's own, since the annex names none; a distance above a web where feed begins is the way back of the
//! cycle. *Invariant:* a web has a start and a depth, or it is left out and reported.

use counterpoint_channel::cycle::{Cycle, FURTHER_WEBS, Height};
use counterpoint_fault as diag;
use counterpoint_machine::ident::{DataId, data};

use crate::context::ActionContext;

/// Their data: start and depth.
pub(crate) const DATA: [[DataId; 2]; FURTHER_WEBS] = [
    [data::CYCLE_WEB_START_2, data::CYCLE_WEB_DEPTH_2],
    [data::CYCLE_WEB_START_3, data::CYCLE_WEB_DEPTH_3],
    [data::CYCLE_WEB_START_4, data::CYCLE_WEB_DEPTH_4],
];

/// Positions of the webs of a hole; distances count from `base` like the depth.
pub(crate) fn of_hole(act: &mut ActionContext<'_, '_>, state: &Cycle, base: f64) -> [Option<[f64; 2]>; FURTHER_WEBS] {
    let mut webs = [None; FURTHER_WEBS];
    for (number, (slot, given)) in (2..).zip(webs.iter_mut().zip(state.heights.webs)) {
        let at = |height: Option<Height>| height.map(|height| height.from(base));
        *slot = match given.map(at) {
            [Some(start), Some(depth)] => Some([start, depth]),
            [None, None] => None,
            _ => {
                let block = act.channel().block_text();
                let text = format!("web {number} needs its start and its depth in '{block}', it is skipped");
                act.diagnose(&diag::DATA_MISSING, text);
                None
            }
        };
    }
    webs
}
