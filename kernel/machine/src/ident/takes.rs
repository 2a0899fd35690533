//! Which data the built-in actions of codes take.
//!
//! Facts: reference control-emulator.md 6. The kind of a code decides, or the code itself where its kind leaves that
//! open. In a list of data a star is the rest of a name.

use counterpoint_event::event::SpindleDirection;
use counterpoint_motion::frame::local::LocalFramePart;

use super::kind::CodeKind;
use super::kind::cycle::{HoleCycle, Out, PeckStyle};
use super::kind::local::FrameChange;
use super::kind::plane::Tilt;
use super::kind::thread::{ThreadCycle, ThreadCycleSetting};
use super::{CodeId, codes};

/// Words of axes and feed.
const MOVE: &str = "REG_FEED_UPM REG_FEED_UPR REG_FEED_1T REG_AXIS_* REG_CORNER_* REG_LINE_ANGLE REG_POLE_*";

/// Words of circles.
const ARC: &str = "REG_FEED_UPM REG_FEED_UPR REG_AXIS_* REG_ARC_CENTER_* REG_ARC_RADIUS REG_ARC_ANGLE REG_ARC_TURNS REG_CORNER_* REG_POLE_*";

/// Words that define a circle to come.
const DEFINITION: &str = "REG_ARC_CENTER_* REG_ARC_RADIUS";

/// Words of drilling cycles whose kind the block gives.
const CYCLE: &str = "REG_FEED_UPM REG_FEED_UPR REG_CYCLE_* REG_AXIS_*";

/// Words of all drilling cycles.
const EVERY_CYCLE: &str = "REG_FEED_UPM REG_FEED_UPR REG_CYCLE_UPM REG_CYCLE_UPR REG_CYCLE_TPU REG_CYCLE_CLEAR REG_CYCLE_DEPTH_* REG_CYCLE_RETRACT REG_CYCLE_REPEAT REG_AXIS_*";

/// Words of drilling cycles of some kinds, with the kinds.
type OfKinds = (fn(HoleCycle) -> bool, &'static str);

/// All of them.
const OF_KINDS: [OfKinds; 8] = [
    (HoleCycle::dwells, "REG_CYCLE_DWELL"),
    (
        |kind| kind.steps() != PeckStyle::None,
        "REG_CYCLE_STEP REG_CYCLE_STEP_DECR REG_CYCLE_STEP_MIN REG_CYCLE_STEP_BACK",
    ),
    (|kind| kind.steps() == PeckStyle::Small, "REG_CYCLE_STEP_OUT"),
    // Under rigid tapping the step makes pecks.
    (|kind| kind.taps() && kind.steps() == PeckStyle::None, "REG_CYCLE_STEP"),
    (HoleCycle::taps, "REG_CYCLE_TAP_TYPE REG_CYCLE_RIGID_ORIENT"),
    (|kind| kind.out() == Out::Oriented, "REG_CYCLE_ORIENT REG_CYCLE_BORE_*"),
    (HoleCycle::bores_back, "REG_CYCLE_BOTTOM"),
    (HoleCycle::has_webs, "REG_CYCLE_WEB_* REG_CYCLE_STEP_BACK"),
];

/// Words of waits.
const WAIT: &str = "REG_SYNC REG_SYNC_*";

/// Codes whose data do not follow from their kind.
const OWN: &[(&[CodeId], &str)] = &[
    (&[codes::RAPID], "REG_RAPID_FEED REG_AXIS_* REG_CORNER_* REG_LINE_ANGLE REG_POLE_*"),
    (
        &[
            codes::INTERP_LINEAR,
            codes::INTERP_LINEAR_X10,
            codes::INTERP_LINEAR_X100,
            codes::INTERP_SKIP,
            codes::INTERP_THREAD_OFF,
            codes::INTERP_ARC_TANGENT,
        ],
        MOVE,
    ),
    (&[codes::INTERP_DEF_CLW, codes::INTERP_DEF_CCLW, codes::INTERP_DEF_CENTER, codes::INTERP_DEF_RADIUS], DEFINITION),
    (&[codes::RTCP_ON, codes::RTCP2_ON], "REG_COMP_LENGTH REG_TIP_FEED"),
    (&[codes::INTERP_ARC_3D], "REG_FEED_UPM REG_FEED_UPR REG_AXIS_* REG_ARC_3D_POINT_*"),
    (&[codes::CORNER_CHAMFER, codes::CORNER_ROUND], "REG_CORNER_SIZE"),
    (&[codes::POLE_TOOL, codes::POLE_ZERO, codes::POLE_LAST], "REG_AXIS_* REG_POLE_*"),
    (&[codes::DELAY], "REG_DELAY"),
    (&[codes::DELAY_REV], "REG_DELAY_REV"),
    (&[codes::GOHOME, codes::GOHOME_RETURN], "REG_AXIS_*"),
    (&[codes::WORK_AREA_LOW, codes::WORK_AREA_HIGH], "REG_AXIS_* REG_SPINDLE_RPM_MAX"),
    (&[codes::GOHOME_NTH], "REG_GOHOME_NTH REG_AXIS_*"),
    (&[codes::FEED_UPM], "REG_FEED_UPM"),
    (&[codes::FEED_UPR], "REG_FEED_UPR"),
    (&[codes::FEED_1T], "REG_FEED_1T"),
    (&[codes::SPINDLE_RPM], "REG_SPINDLE_RPM"),
    (&[codes::SPINDLE_MAXRPM], "REG_SPINDLE_RPM_MAX"),
    (&[codes::SPINDLE_CSS, codes::SPINDLE_CSS_MAIN, codes::SPINDLE_CSS_SIDE], "REG_SPINDLE_CSS"),
    (&[codes::SPINDLE_CSS_RADIAL], "REG_SPINDLE_CSS_RADIAL"),
    (&[codes::SPINDLE_CSS_ID], "REG_SPINDLE_CSS_ID"),
    (&[codes::TOOL_SELECT, codes::TOOL_LOAD], "REG_TOOL"),
    (&[codes::TOOL_LOAD_POINT, codes::TOOL_LOAD_RETURN], "REG_AXIS_*"),
    (&[codes::HEAD_ID], "REG_HEAD_ID"),
    (
        &[codes::ENGRAVE],
        "REG_ENGRAVE_KIND REG_ENGRAVE_ANGLE REG_ENGRAVE_HEIGHT REG_ENGRAVE_PLUNGE REG_ENGRAVE_CLEAR REG_FEED_UPM REG_FEED_UPR REG_AXIS_*",
    ),
    (
        &[codes::POCKET],
        "REG_POCKET_OUTLINE REG_POCKET_STEP_X REG_POCKET_STEP_Y REG_POCKET_FINISH REG_POCKET_LEVEL REG_POCKET_CLEAR REG_COMP_DIAM REG_FEED_UPM REG_FEED_UPR REG_AXIS_*",
    ),
    (&[codes::RETRACT_TOOL], "REG_TILT_RETRACT REG_FEED_UPM REG_FEED_UPR"),
    (&[codes::AM_ON, codes::AM_OFF], "REG_AM"),
    (&[codes::FEED_DOWN], "REG_DOWN_FEED"),
    (&[codes::CONTOUR_EXTENDED], "REG_CONTOUR_EXTENSION"),
    (
        &[
            codes::SMOOTH_LINE_IN,
            codes::SMOOTH_QUARTER_IN,
            codes::SMOOTH_HALF_IN,
            codes::SMOOTH_LINE_OUT,
            codes::SMOOTH_QUARTER_OUT,
            codes::SMOOTH_HALF_OUT,
        ],
        "REG_SMOOTH_* REG_FEED_UPM REG_FEED_UPR",
    ),
    (&[codes::CALSUB_ID], "REG_CALSUB_ID REG_CALSUB_REPEAT REG_CALSUB_BLOCK_START REG_CALSUB_SEQUENCE"),
    (&[codes::CALSUB_RANGE], "REG_CALSUB_BLOCK_START REG_CALSUB_BLOCK_END REG_RANGE_REPEAT REG_LABEL REG_LABEL_END"),
    (&[codes::CYCLE_ON], CYCLE),
    (&[codes::COMP_DIAM_LEFT, codes::COMP_DIAM_RIGHT], "REG_COMP_DIAM REG_CONTOUR_ALLOWANCE REG_CONTOUR_DISTORTION"),
    (&[codes::COMP_3D_VECTOR], "REG_COMP_DIAM REG_COMP_DIAM_P REG_COMP_DIAM_Q REG_COMP_DIAM_R"),
    (&[codes::COMP_WORKP_ON], "REG_COMP_WORKP"),
    (&[codes::COMP_EXTFIXT, codes::COMP_EXTFIXT_RANGE], "REG_COMP_EXTFIXT_RANGE REG_COMP_EXTFIXT_REG"),
    (&[codes::C2P_CART_ON, codes::C2P_POLAR_ON], "REG_C2P_INTERP_*"),
    (&[codes::CYLINDER_ON, codes::CYLINDER_MAP], "REG_CYLINDER_RADIUS REG_AXIS_*"),
    (&[codes::SYNC_REG, codes::SYNC_REG_MAIN, codes::SYNC_REG_SIDE, codes::SYNC_REG_START], WAIT),
    (&[codes::SYNC_REG_STOP, codes::SYNC_START_MAIN, codes::SYNC_START_SIDE], WAIT),
    (&[codes::BALANCE_ON, codes::BALANCE_OFF], "REG_SYNC_PATHS"),
    (&[codes::COUPLE_SYNCHRONOUS], "REG_COUPLE_MASTER REG_COUPLE_SLAVE REG_COUPLE_PARKING"),
    (
        &[codes::COUPLE_COMPOSITE, codes::COUPLE_COMPOSITE_OFF, codes::COUPLE_SUPERIMPOSED],
        "REG_COUPLE_MASTER REG_COUPLE_SLAVE",
    ),
    (&[codes::COUPLE_SPINDLES, codes::COUPLE_SPINDLES_PHASE], "REG_COUPLE_SPINDLE_*"),
    (
        &[codes::COUPLE_SPINDLES_OFF, codes::COUPLE_SPINDLES_PHASE_OFF],
        "REG_COUPLE_SPINDLE_LEADER REG_COUPLE_SPINDLE_FOLLOWER",
    ),
    (&[codes::FIXED_STOP_MOVE], "REG_FEED_UPM REG_FEED_UPR REG_AXIS_* REG_FIXED_STOP_*"),
    (&[codes::COUPLE_SYNCHRONOUS_OFF, codes::COUPLE_SUPERIMPOSED_OFF], "REG_COUPLE_SLAVE"),
    (
        &[codes::INTERP_THREAD_ARC_CLW, codes::INTERP_THREAD_ARC_CCLW],
        "REG_INTERP_THREAD_* REG_ARC_RADIUS REG_ARC_CENTER_* REG_AXIS_*",
    ),
    (&[codes::TURN_PASS], "REG_TURN_PASS_*"),
    (&[codes::GOHOME_CHECK, codes::GOHOME_FLOATING, codes::RAPID_ONE_WAY, codes::POSITION_PRESET_OFF], "REG_AXIS_*"),
    (&[codes::TOOL_MEASURE], "REG_OFFSET_VALUE REG_FEED_UPM REG_AXIS_*"),
    (
        &[codes::TOOL_LENGTHEN, codes::TOOL_SHORTEN, codes::TOOL_LENGTHEN_TWICE, codes::TOOL_SHORTEN_TWICE],
        "REG_COMP_DIAM REG_AXIS_* REG_ARC_CENTER_*",
    ),
    (&[codes::FIGURE_TURN], "REG_CALSUB_ID REG_CALSUB_REPEAT REG_LCS_ROT_CENTER_* REG_LCS_ROT_ANGLE"),
    (&[codes::FIGURE_SHIFT], "REG_CALSUB_ID REG_CALSUB_REPEAT REG_ARC_CENTER_*"),
    (&[codes::OFFSET_SET], "REG_OFFSET_* REG_AXIS_*"),
    (&[codes::STORED_LIMIT_ON], "REG_STORED_LIMIT_*"),
    (&[codes::DISPLY], "the text of the message"),
    (&[codes::COMMENT], "the text of the comment"),
];

/// The data that the action of a code takes.
fn taken(id: CodeId) -> &'static str {
    match id.kind() {
        CodeKind::Arc(_) => ARC,
        CodeKind::Thread(_) => "REG_INTERP_THREAD_* REG_AXIS_*",
        CodeKind::ThreadCycle(ThreadCycle { multi: false, .. }) => {
            "REG_THREAD_SINGLE_* REG_INTERP_THREAD_PITCH REG_INTERP_THREAD_ANGLE REG_AXIS_*"
        }
        CodeKind::ThreadCycle(ThreadCycle { multi: true, .. }) => {
            "REG_THREAD_MULTI_* REG_THREAD_CHAMFER_* REG_INTERP_THREAD_PITCH REG_INTERP_THREAD_ANGLE REG_AXIS_*"
        }
        CodeKind::ThreadSetting(ThreadCycleSetting::Chamfer(_)) => "REG_THREAD_CHAMFER_*",
        CodeKind::Cycle(_) => EVERY_CYCLE,
        CodeKind::Turning(_) => "REG_TURN_* REG_FEED_UPM REG_FEED_UPR REG_AXIS_*",
        CodeKind::Local(LocalFramePart::Mirror, _) => "REG_AXIS_*",
        CodeKind::Local(LocalFramePart::Translate, FrameChange::On | FrameChange::Add) => "REG_LCS_TRANS_*",
        CodeKind::Local(LocalFramePart::Rotate, FrameChange::On | FrameChange::Add) => "REG_LCS_ROT_*",
        CodeKind::Local(LocalFramePart::Scale, FrameChange::On | FrameChange::Add) => "REG_LCS_SCALE REG_LCS_SCALE_*",
        CodeKind::Plane(Tilt::On(_) | Tilt::Add(_)) => "REG_TILT_*",
        CodeKind::Plane(Tilt::Turn) => "REG_FEED_UPM REG_TILT_RETRACT",
        CodeKind::Plane(Tilt::Move) => "REG_FEED_UPM REG_TILT_RETRACT REG_TILT_DISTANCE",
        CodeKind::Length { .. } => "REG_COMP_LENGTH",
        CodeKind::TipFormat(2) => "REG_RTCP_VECTOR_*",
        CodeKind::TipFormat(3) => "REG_RTCP_2PT_*",
        CodeKind::TipFormat(4) => "REG_RTCP_RPY_*",
        CodeKind::TipFormat(5) => "REG_RTCP_EULER_*",
        CodeKind::TipFormat(6) => "REG_RTCP_CUSTOM_*",
        CodeKind::Spindle { direction: SpindleDirection::Clockwise | SpindleDirection::CounterClockwise, .. } => {
            "REG_SPINDLE_RPM"
        }
        CodeKind::Spindle { direction: SpindleDirection::Oriented, .. } => "REG_SPINDLE_ORIENT",
        CodeKind::Coolant(_) => "REG_COOLANT_PRESSURE",
        _ => OWN.iter().find(|(ids, _)| ids.contains(&id)).map_or("", |(_, list)| list),
    }
}

/// Data that the action of a code takes; a star is the rest of a name. Empty for a code that takes none, or has no
/// built-in action.
#[must_use]
pub fn data_of(code: &str) -> Vec<&'static str> {
    let Some(id) = super::code(code).filter(|id| super::code_facts(*id).is_some_and(|facts| facts.built_in)) else {
        return Vec::new();
    };
    let list = taken(id);
    if list.starts_with("the ") {
        return vec![list];
    }
    let mut all: Vec<&str> = list.split_whitespace().collect();
    if let CodeKind::Cycle(kind) = id.kind() {
        let own = OF_KINDS.iter().filter(|(has, _)| has(kind));
        all.extend(own.flat_map(|(_, list)| list.split_whitespace()));
    }
    all
}

/// Codes whose actions take this data.
#[must_use]
pub fn codes_of(data: &str) -> Vec<&'static str> {
    let takes = |code: &str| data_of(code).into_iter().any(|pattern| fits(pattern, data));
    codes::TABLE.iter().map(|facts| facts.name).filter(|code| takes(code)).collect()
}

/// Whether a list with this entry names this identifier.
#[must_use]
pub fn fits(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == pattern,
    }
}

#[cfg(test)]
mod tests {
    use super::super::data;
    use super::*;

    #[test]
    fn every_list_names_data_that_exist() {
        for facts in codes::TABLE {
            for pattern in data_of(facts.name).into_iter().filter(|word| word.starts_with("REG_")) {
                assert!(data::TABLE.iter().any(|facts| fits(pattern, facts.name)), "{pattern} of {}", facts.name);
            }
        }
        for id in OWN.iter().flat_map(|(ids, _)| *ids) {
            assert!(!taken(*id).is_empty() && OWN.iter().filter(|(ids, _)| ids.contains(id)).count() == 1, "{id:?}");
        }
        assert_eq!(data_of("CODE_DELAY"), ["REG_DELAY"]);
        assert_eq!(data_of("CODE_DELAY_REV"), ["REG_DELAY_REV"]);
        assert!(data_of("CODE_CYCLE_OFF").is_empty() && data_of("CODE_STOP").is_empty());
        let has = |code: &str, data: &str| data_of(code).iter().any(|pattern| fits(pattern, data));
        for (data, codes, others) in [
            ("REG_CYCLE_BORE_JOG", "CODE_CYCLE_BORE_ORIENT CODE_CYCLE_BORE_BACK", "CODE_CYCLE_TAP CODE_CYCLE_DRILL"),
            ("REG_CYCLE_BOTTOM", "CODE_CYCLE_BORE_BACK", "CODE_CYCLE_TAP CODE_CYCLE_DEEP"),
            ("REG_CYCLE_STEP", "CODE_CYCLE_DEEP CODE_CYCLE_BRKCHP CODE_CYCLE_TAP", "CODE_CYCLE_DRILL CODE_CYCLE_BORE"),
            ("REG_CYCLE_DWELL", "CODE_CYCLE_TAP CODE_CYCLE_DRILL_DWELL", "CODE_CYCLE_DRILL"),
            ("REG_CYCLE_CLEAR", "CODE_CYCLE_TAP CODE_CYCLE_DRILL CODE_CYCLE_ON", "CODE_CYCLE_OFF"),
        ] {
            assert!(codes.split(' ').all(|code| has(code, data)), "{data}: {codes}");
            assert!(!others.split(' ').any(|code| has(code, data)), "{data}: not {others}");
        }
        assert_eq!(codes_of("REG_TOOL"), ["CODE_TOOL_LOAD", "CODE_TOOL_SELECT"]);
    }
}
