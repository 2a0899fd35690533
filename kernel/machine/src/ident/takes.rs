//! Which data the built-in actions of codes take.
//!
//! Facts: reference control-emulator.md 6. A row tells how identifiers of codes begin; the longest that fits counts. A
//! star stands for the rest of a name.

use super::codes;

/// Words of axes and feed.
const MOVE: &str = "REG_FEED_UPM REG_FEED_UPR REG_FEED_1T REG_AXIS_* REG_CORNER_* REG_LINE_ANGLE REG_POLE_*";

const ROWS: &[(&str, &str)] = &[
    ("CODE_RAPID", "REG_RAPID_FEED REG_AXIS_* REG_CORNER_* REG_LINE_ANGLE REG_POLE_*"),
    ("CODE_INTERP_ARC_TANGENT", MOVE),
    ("CODE_POLE", "REG_AXIS_* REG_POLE_*"),
    ("CODE_INTERP_LINEAR", MOVE),
    (
        "CODE_INTERP_ARC",
        "REG_FEED_UPM REG_FEED_UPR REG_AXIS_* REG_ARC_CENTER_* REG_ARC_RADIUS REG_ARC_ANGLE REG_ARC_TURNS REG_CORNER_* REG_POLE_*",
    ),
    (
        "CODE_INTERP_HELIX",
        "REG_FEED_UPM REG_FEED_UPR REG_AXIS_* REG_ARC_CENTER_* REG_ARC_RADIUS REG_ARC_ANGLE REG_ARC_TURNS",
    ),
    ("CODE_INTERP_DEF", "REG_ARC_CENTER_* REG_ARC_RADIUS"),
    ("CODE_INTERP_ARC_3D", "REG_FEED_UPM REG_FEED_UPR REG_AXIS_* REG_ARC_3D_POINT_*"),
    ("CODE_INTERP_THREAD", "REG_INTERP_THREAD_* REG_AXIS_*"),
    ("CODE_INTERP_SKIP", MOVE),
    ("CODE_DELAY", "REG_DELAY"),
    ("CODE_DELAY_REV", "REG_DELAY_REV"),
    ("CODE_GOHOME", "REG_AXIS_*"),
    ("CODE_FEED_UPM", "REG_FEED_UPM"),
    ("CODE_FEED_UPR", "REG_FEED_UPR"),
    ("CODE_FEED_1T", "REG_FEED_1T"),
    ("CODE_SPINDLE_CLW", "REG_SPINDLE_RPM"),
    ("CODE_SPINDLE_CCLW", "REG_SPINDLE_RPM"),
    ("CODE_SPINDLE_ORIENT", "REG_SPINDLE_ORIENT"),
    ("CODE_SPINDLE_RPM", "REG_SPINDLE_RPM"),
    ("CODE_SPINDLE_MAXRPM", "REG_SPINDLE_RPM_MAX"),
    ("CODE_SPINDLE_CSS", "REG_SPINDLE_CSS"),
    ("CODE_SPINDLE_CSS_RADIAL", "REG_SPINDLE_CSS_RADIAL"),
    ("CODE_SPINDLE_CSS_ID", "REG_SPINDLE_CSS_ID"),
    ("CODE_COOLANT", "REG_COOLANT_PRESSURE"),
    ("CODE_TOOL_SELECT", "REG_TOOL"),
    ("CODE_TOOL_LOAD", "REG_TOOL"),
    ("CODE_TOOL_LOAD_POINT", "REG_AXIS_*"),
    ("CODE_TOOL_LOAD_RETURN", "REG_AXIS_*"),
    ("CODE_HEAD_ID", "REG_HEAD_ID"),
    ("CODE_AM_", "REG_AM"),
    ("CODE_CALSUB_ID", "REG_CALSUB_ID REG_CALSUB_REPEAT"),
    ("CODE_CALSUB_RANGE", "REG_CALSUB_BLOCK_START REG_CALSUB_BLOCK_END REG_RANGE_REPEAT REG_LABEL REG_LABEL_END"),
    ("CODE_CYCLE_", "REG_FEED_UPM REG_FEED_UPR REG_CYCLE_* REG_AXIS_*"),
    ("CODE_CYCLE_OFF", ""),
    ("CODE_CYCLE_RETRACT", ""),
    ("CODE_TURN_", "REG_TURN_* REG_FEED_UPM REG_FEED_UPR REG_AXIS_*"),
    ("CODE_THREAD_SINGLE", "REG_THREAD_SINGLE_*"),
    ("CODE_THREAD_MULTI", "REG_THREAD_MULTI_*"),
    ("CODE_THREAD_CHAMFER", "REG_THREAD_CHAMFER_*"),
    ("CODE_COMP_LENGTH", "REG_COMP_LENGTH"),
    ("CODE_COMP_DIAM", "REG_COMP_DIAM"),
    ("CODE_COMP_DIAM_OFF", ""),
    ("CODE_COMP_3D_VECTOR", "REG_COMP_DIAM REG_COMP_DIAM_P REG_COMP_DIAM_Q REG_COMP_DIAM_R"),
    ("CODE_COMP_WORKP", "REG_COMP_WORKP"),
    ("CODE_COMP_WORKP_OFF", ""),
    ("CODE_COMP_EXTFIXT", "REG_COMP_EXTFIXT_RANGE REG_COMP_EXTFIXT_REG"),
    ("CODE_LCS_TRANSLATE", "REG_LCS_TRANS_*"),
    ("CODE_LCS_ROTATE", "REG_LCS_ROT_*"),
    ("CODE_LCS_SCALE", "REG_LCS_SCALE REG_LCS_SCALE_*"),
    ("CODE_LCS_MIRROR", "REG_AXIS_*"),
    ("CODE_LCS_TRANSLATE_OFF", ""),
    ("CODE_LCS_ROTATE_OFF", ""),
    ("CODE_LCS_SCALE_OFF", ""),
    ("CODE_RTCP_ORIENT_VECTOR", "REG_RTCP_VECTOR_*"),
    ("CODE_RTCP_ORIENT_2PT", "REG_RTCP_2PT_*"),
    ("CODE_RTCP_ORIENT_RPY", "REG_RTCP_RPY_*"),
    ("CODE_RTCP_ORIENT_EULER", "REG_RTCP_EULER_*"),
    ("CODE_RTCP_ORIENT_CUSTOM", "REG_RTCP_CUSTOM_*"),
    ("CODE_C2P_CART_ON", "REG_C2P_INTERP_*"),
    ("CODE_C2P_POLAR_ON", "REG_C2P_INTERP_*"),
    ("CODE_SYNC", "REG_SYNC REG_SYNC_*"),
    ("CODE_DISPLY", "the text of the message"),
    ("CODE_COMMENT", "the text of the comment"),
];

/// Data that the action of a code takes; a star stands for the rest of a name. Empty for a code that takes none, or has no
/// built-in action.
#[must_use]
pub fn data_of(code: &str) -> Vec<&'static str> {
    let built_in = codes::TABLE.iter().any(|facts| facts.name == code && facts.built_in);
    let fits = ROWS.iter().filter(|(start, _)| built_in && code.starts_with(start));
    let Some((_, list)) = fits.max_by_key(|(start, _)| start.len()) else { return Vec::new() };
    if list.starts_with("the ") { vec![list] } else { list.split_whitespace().collect() }
}

/// Codes whose actions take this data.
#[must_use]
pub fn codes_of(data: &str) -> Vec<&'static str> {
    let takes = |code: &str| data_of(code).into_iter().any(|pattern| fits(pattern, data));
    codes::TABLE.iter().map(|facts| facts.name).filter(|code| takes(code)).collect()
}

fn fits(pattern: &str, name: &str) -> bool {
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
    fn every_row_names_what_there_is() {
        for (start, list) in ROWS {
            assert!(codes::TABLE.iter().any(|facts| facts.name.starts_with(start)), "{start}");
            for pattern in list.split_whitespace().filter(|word| word.starts_with("REG_")) {
                assert!(data::TABLE.iter().any(|facts| fits(pattern, facts.name)), "{pattern}");
            }
        }
        assert_eq!(data_of("CODE_DELAY"), ["REG_DELAY"]);
        assert_eq!(data_of("CODE_DELAY_REV"), ["REG_DELAY_REV"]);
        assert!(data_of("CODE_CYCLE_OFF").is_empty() && data_of("CODE_STOP").is_empty());
        assert_eq!(codes_of("REG_TOOL"), ["CODE_TOOL_LOAD", "CODE_TOOL_SELECT"]);
    }
}
