//! Cycles along a contour with a name (Okuma LAP).
//!
//! The pre-processor finds the contour before its block is split; the cycle takes it. Facts: reference okuma-osp.md 4.
//! *Invariant:* a cycle that moves has a contour and depths above 0; amounts get their direction from the contour.

use counterpoint_channel::turning::{ContourBlocks, ContourCycle, ContourTask, LathePlane};
use counterpoint_event::event::FeedUnit;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::turning::LapCycle;
use counterpoint_machine::ident::{DataId, data};
use counterpoint_motion::turning::lap::{DepthChange, LapSettings};
use counterpoint_motion::turning::rough;

use crate::context::ActionContext;

/// Places from which levels have other values: along X, along Z, depth, feed.
const CHANGES: [[DataId; 4]; 2] = [
    [data::TURN_CHANGE_X, data::TURN_CHANGE_Z, data::TURN_CHANGE_DEPTH, data::TURN_CHANGE_FEED],
    [data::TURN_CHANGE_X_2, data::TURN_CHANGE_Z_2, data::TURN_CHANGE_DEPTH_2, data::TURN_CHANGE_FEED_2],
];

/// A depth that no contour is deep enough for: there are no levels.
const WHOLE: f64 = 1e12;

/// Starts a cycle along the contour that its block names.
pub(crate) fn cycle(act: &mut ActionContext<'_, '_>, plane: &LathePlane, kind: LapCycle) -> Acted {
    let stays = std::mem::take(&mut act.channel_mut().state.others.turning.stays);
    let Some(shape) = act.channel_mut().state.others.turning.shape.take() else {
        let text = format!("the cycle needs the name of its contour in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::CONTOUR_RANGE, text));
    };
    let value = |act: &mut ActionContext<'_, '_>, id| act.take(id).map(|datum| datum.value);
    let across = if shape.face { plane.scales[0] } else { plane.scales[1] };
    let amounts = [data::TURN_ALLOWANCE_Z, data::TURN_ALLOWANCE_X].map(|id| value(act, id).unwrap_or(0.0).abs());
    if kind == LapCycle::Thread {
        let blocks = ContourBlocks::Named { name: shape.name, first: shape.first, last: shape.last, blank: None };
        let feed = (None, FeedUnit::PerRevolution);
        act.cut_contour(ContourCycle {
            blocks,
            task: ContourTask::Thread { face: shape.face },
            feed,
            feeds: [None; 2],
        });
        return Ok(());
    }
    let allowance = [amounts[0] * plane.scales[0], amounts[1] * plane.scales[1]];
    let depth = value(act, data::TURN_DEPTH).map_or(0.0, |depth| depth * across);
    let (mut changes, mut feeds) = ([None; 2], [None; 2]);
    for (ids, (change, feed)) in CHANGES.into_iter().zip(changes.iter_mut().zip(feeds.iter_mut())) {
        let [along_x, along_z, deep, rate] = ids.map(|id| value(act, id));
        let place = if shape.face { along_z } else { along_x };
        *change = place.map(|place| DepthChange { from: place * across, depth: deep.map(|deep| deep * across) });
        *feed = rate;
    }
    let feed = act.active_feed();
    let blocks = ContourBlocks::Named { name: shape.name, first: shape.first, last: shape.last, blank: shape.blank };
    let finishes = kind == LapCycle::Finish;
    if finishes && allowance == [0.0; 2] {
        let [along_z, along_x] = plane.axes.map(|axis| axis.bit());
        let off = if shape.face { along_z } else { along_x };
        act.cut_contour(ContourCycle { blocks, task: ContourTask::Finish { stays, off }, feed, feeds });
        return Ok(());
    }
    let depth = if finishes { WHOLE } else { depth };
    let depths = changes.iter().flatten().filter_map(|change: &DepthChange| change.depth);
    if let Some(wrong) = std::iter::once(depth).chain(depths).find(|depth| !(*depth > 0.0 && depth.is_finite())) {
        let text = format!(
            "the depth of a level is {} in '{}', it must be above 0",
            wrong / across,
            act.channel().block_text()
        );
        return Err(act.alarm(&diag::CONTOUR_DEPTH, text));
    }
    let lap = LapSettings { copies: kind != LapCycle::Bar, changes, stays };
    let retract = act.channel().env.machine.turning.retract;
    let settings = rough::RoughSettings {
        face: shape.face,
        depth,
        retract,
        allowance,
        semi: [0.0; 2],
        pockets: true,
        lap: Some(lap),
    };
    act.cut_contour(ContourCycle { blocks, task: ContourTask::Rough(settings, Some(true)), feed, feeds });
    Ok(())
}
