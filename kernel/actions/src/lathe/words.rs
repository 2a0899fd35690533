//! Data of turning cycles.
//!
//! *Invariant:* a cycle takes only the words it uses; the rest stays in the block and is reported. Facts: reference
//! turning-cycles.md 1.2, 3, 4, 6.1.

use counterpoint_motion::contour::element::Spot;
use counterpoint_motion::turning::rough;

use crate::context::ActionContext;
use counterpoint_channel::turning::LathePlane;
use counterpoint_machine::ident::{DataId, data};

/// Largest sequence number.
const MOST: f64 = 4_294_967_295.0;

fn value(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<f64> {
    act.take(id).map(|datum| datum.value)
}

/// First and last contour block.
pub(crate) fn blocks(act: &mut ActionContext<'_, '_>) -> (Option<u32>, Option<u32>) {
    let mut number = |id| act.take(id).map(|datum| datum.value.clamp(0.0, MOST) as u32);
    (number(data::TURN_FIRST), number(data::TURN_LAST))
}

/// Depth and retraction from a line of settings; false if it has neither.
pub(crate) fn rough_settings(act: &mut ActionContext<'_, '_>, face: bool) -> bool {
    let depth = value(act, if face { data::TURN_DEPTH_Z } else { data::TURN_DEPTH_X });
    let depth = depth.or_else(|| value(act, data::TURN_DEPTH));
    let retract = value(act, data::TURN_RETRACT);
    let turning = &mut act.channel_mut().state.others.turning;
    turning.depth = depth.unwrap_or(turning.depth);
    turning.retract = retract.map_or(turning.retract, f64::abs);
    depth.is_some() || retract.is_some()
}

/// Words of a rough cycle.
pub(crate) struct RoughingWords {
    pub(crate) settings: rough::RoughSettings,
    /// With pockets, if a word says so.
    pub(crate) pockets: Option<bool>,
}

/// The words of a rough cycle beside its contour blocks.
pub(crate) fn rough(act: &mut ActionContext<'_, '_>, plane: &LathePlane, face: bool) -> RoughingWords {
    let allowance = allowance(act, plane);
    let semi = [data::TURN_SEMI_Z, data::TURN_SEMI_X].map(|id| value(act, id).unwrap_or(0.0));
    if let Some(depth) = value(act, data::TURN_DEPTH) {
        act.channel_mut().state.others.turning.depth = depth;
    }
    let pockets = value(act, data::TURN_TYPE).map(|kind| kind == 1.0);
    let turning = &act.channel().state.others.turning;
    let (depth, retract) = (turning.depth, turning.retract);
    RoughingWords {
        settings: rough::RoughSettings { face, depth, retract, allowance, semi, pockets: false, lap: None },
        pockets,
    }
}

/// Allowances along Z and X; that of X is in the form of programmed X.
fn allowance(act: &mut ActionContext<'_, '_>, plane: &LathePlane) -> Spot {
    let [z, x] = [data::TURN_ALLOWANCE_Z, data::TURN_ALLOWANCE_X].map(|id| value(act, id).unwrap_or(0.0));
    [z * plane.scales[0], x * plane.scales[1]]
}

/// Relief and repetitions of a pattern from a line of settings; false if it has none of them.
pub(crate) fn pattern_settings(act: &mut ActionContext<'_, '_>) -> bool {
    let own = [data::TURN_DEPTH_Z, data::TURN_DEPTH_X].map(|id| value(act, id));
    let repeats = value(act, data::TURN_REPEATS);
    let turning = &mut act.channel_mut().state.others.turning;
    for (slot, said) in turning.relief.iter_mut().zip(own) {
        *slot = said.unwrap_or(*slot);
    }
    turning.repeats = repeats.unwrap_or(turning.repeats);
    own.iter().any(Option::is_some) || repeats.is_some()
}

/// Allowances and repetitions of a pattern; relief of the one-line form is kept like that of settings.
pub(crate) fn pattern(act: &mut ActionContext<'_, '_>, plane: &LathePlane) -> (Spot, f64) {
    let allowance = allowance(act, plane);
    let relief = [data::TURN_RELIEF_Z, data::TURN_RELIEF_X].map(|id| value(act, id));
    let repeats = value(act, data::TURN_REPEATS);
    let turning = &mut act.channel_mut().state.others.turning;
    for (slot, said) in turning.relief.iter_mut().zip(relief) {
        *slot = said.unwrap_or(*slot);
    }
    turning.repeats = repeats.unwrap_or(turning.repeats);
    (allowance, turning.repeats.trunc())
}

/// The way back of pecks from a line of settings; false if the block is more than that.
pub(crate) fn peck_settings(act: &mut ActionContext<'_, '_>) -> bool {
    let more = act.has_axis_word() || [data::TURN_STEP_X, data::TURN_STEP_Z].iter().any(|id| act.block_has(*id));
    if more {
        return false;
    }
    if let Some(back) = value(act, data::TURN_RETRACT) {
        act.channel_mut().state.others.turning.back = back.abs();
    }
    true
}

/// Words of a cycle of pecks besides its end.
pub(crate) struct PeckWords {
    /// Along Z and X.
    pub(crate) steps: [f64; 2],
    pub(crate) relief: f64,
}

/// The words of pecks.
pub(crate) fn pecks(act: &mut ActionContext<'_, '_>) -> PeckWords {
    let steps = [data::TURN_STEP_Z, data::TURN_STEP_X].map(|id| value(act, id).unwrap_or(0.0));
    let relief = value(act, data::TURN_RETRACT).or_else(|| value(act, data::TURN_DEPTH)).unwrap_or(0.0);
    PeckWords { steps, relief }
}

/// The taper of a single cycle.
pub(crate) fn taper(act: &mut ActionContext<'_, '_>, face: bool) -> Option<f64> {
    value(act, if face { data::TURN_TAPER_Z } else { data::TURN_TAPER_X })
}
