//! `$P_GG`: which function of a G group is active; `G[group]=n`: the function with this number.
//!
//! Facts: list of G functions, which numbers them in each group. *Invariant:* a function that is not in the table has
//! no number, so that reading it is reported.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_machine::ident::{CodeId, codes};

/// Group, code, number in the group.
const FUNCTIONS: &[(i64, CodeId, i64)] = &[
    (1, codes::RAPID, 1),
    (1, codes::INTERP_LINEAR, 2),
    (1, codes::INTERP_ARC_CLW, 3),
    (1, codes::INTERP_ARC_CCLW, 4),
    (1, codes::INTERP_ARC_3D, 5),
    (7, codes::COMP_DIAM_OFF, 1),
    (7, codes::COMP_DIAM_LEFT, 2),
    (7, codes::COMP_DIAM_RIGHT, 3),
    (8, codes::COMP_WORKP_OFF, 1),
    (10, codes::EXACTSTOP_ON, 1),
    (10, codes::EXACTSTOP_OFF, 2),
    (17, codes::CONTOUR_NORMAL, 1),
    (17, codes::CONTOUR_AROUND, 2),
    (18, codes::COMP_CORNER_ARC, 1),
    (18, codes::COMP_CORNER_LINEAR, 2),
    (22, codes::COMP_IN_MACHINE, 1),
    (22, codes::COMP_IN_FRAME, 2),
    (43, codes::SMOOTH_SIDE_TOOL, 1),
    (43, codes::SMOOTH_SIDE_LEFT, 2),
    (43, codes::SMOOTH_SIDE_RIGHT, 3),
    (43, codes::SMOOTH_SIDE_POINT, 4),
    (44, codes::SMOOTH_IN_SPACE, 1),
    (44, codes::SMOOTH_IN_PLANE, 2),
    (14, codes::POSITION_ABSOLUTE, 1),
    (14, codes::POSITION_RELATIVE, 2),
    (15, codes::FEED_1T, 1),
    (15, codes::FEED_UPM, 2),
    (15, codes::FEED_UPR, 3),
    (29, codes::XAXIS_RADIUS, 1),
    (29, codes::XAXIS_DIAMETER, 2),
    (29, codes::XAXIS_DIAMETER_ABSOLUTE, 3),
];
/// Settable frames.
const FRAMES: i64 = 8;
/// Types of the feed; with a cutting speed it is G96 or G961.
const FEEDS: i64 = 15;

/// Units: G70 and G700 inches, G71 and G710 millimetres; the first of each pair converts only lengths.
const UNITS: i64 = 13;

/// Number of the active function of a group; none if it is not known.
pub(super) fn active(host: &dyn InterpreterHost, group: i64) -> Option<i64> {
    let is_active = |wanted: CodeId| host.is_active(wanted);
    if group == FRAMES && host.work_offset() > 0 {
        return Some(i64::from(host.work_offset()) + 1);
    }
    if group == FEEDS && is_active(codes::SPINDLE_CSS) {
        return Some(if is_active(codes::FEED_UPR) { 4 } else { 7 });
    }
    if group == UNITS {
        let lengths = is_active(codes::UNITS_PRIMARY) || is_active(codes::UNITS_SECONDARY_LENGTHS);
        let first = lengths.then_some(1).or_else(|| is_active(codes::UNITS_SECONDARY).then_some(3));
        return first.map(|first| if host.is_inch() { first } else { first + 1 });
    }
    FUNCTIONS.iter().find(|(of, code, _)| *of == group && is_active(*code)).map(|(_, _, number)| *number)
}

/// Functions of a group in the order of their numbers, as they are written.
const WRITTEN: &[(i64, &[&str])] = &[
    (1, &["G0", "G1", "G2", "G3", "CIP"]),
    (6, &["G17", "G18", "G19"]),
    (7, &["G40", "G41", "G42"]),
    (FRAMES, &["G500", "G54", "G55", "G56", "G57"]),
    (10, &["G60", "G64"]),
    (12, &["G601", "G602", "G603"]),
    (UNITS, &["G70", "G71", "G700", "G710"]),
    (14, &["G90", "G91"]),
    (FEEDS, &["G93", "G94", "G95", "G96", "G97"]),
    (17, &["NORM", "KONT"]),
    (18, &["G450", "G451"]),
    (29, &["DIAMOF", "DIAMON", "DIAM90"]),
];

/// The word of a function by its group and number; none if it is not known.
pub(super) fn written(group: i64, number: i64) -> Option<String> {
    let (_, words) = WRITTEN.iter().find(|(of, _)| *of == group)?;
    let word = usize::try_from(number).ok().and_then(|number| words.get(number.checked_sub(1)?));
    // Behind G57 the settable frames continue with G505.
    let further = || (group == FRAMES && (6..=100).contains(&number)).then(|| format!("G{}", 499 + number));
    word.map(|word| (*word).to_owned()).or_else(further)
}
