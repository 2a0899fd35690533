//! What follows from a data or code identifier when its row does not say.
//!
//! Invariant: every identifier has an answer. Facts: reference control-emulator.md 1.3, 6.2.

use crate::ident::{self, CodeId, DataId, codes};
use crate::model::AxisRole;
use crate::rows::{Dimension, Modality};

/// Modality of a code in a group.
pub(super) fn modality(id: CodeId, group: u16) -> Modality {
    let one_block =
        [codes::EXACTSTOP, codes::EXACTSTOP_CLW, codes::EXACTSTOP_CCLW, codes::EXACTSTOP_LINEAR, codes::INTERP_SKIP];
    if group == 0 || one_block.contains(&id) { Modality::NonModal } else { Modality::Modal }
}

/// Whether the last value of a data identifier is remembered: axes, feed, spindle and tool data are.
pub(super) fn modal(id: DataId) -> bool {
    let name = name(id);
    let feeds = ["FEED_UPM", "FEED_UPR", "FEED_1T", "FEED_UPM_MAX", "RAPID_FEED", "TOOL"];
    name.starts_with("AXIS_") || name.starts_with("SPINDLE_") || feeds.contains(&name)
}

/// Dimension of a data identifier.
pub(super) fn dimension(id: DataId) -> Dimension {
    let name = name(id);
    let has = |part: &str| name.split('_').any(|word| word == part);
    if let Some(axis) = name.strip_prefix("AXIS_") {
        return if axis.starts_with(['A', 'B', 'C', 'N']) { Dimension::Angle } else { Dimension::Length };
    }
    match name {
        "SPINDLE_CSS" => return Dimension::SurfaceSpeed,
        "DELAY" | "CYCLE_DWELL" => return Dimension::Time,
        "FEED_UPM" | "FEED_UPR" | "FEED_UPM_MAX" | "RAPID_FEED" | "CYCLE_UPM" | "CYCLE_UPR" => return Dimension::Feed,
        "SPINDLE_ORIENT" | "CYCLE_ORIENT" | "CYCLE_RIGID_ORIENT" => return Dimension::Angle,
        "SPINDLE_CSS_RADIAL" | "RADIAL_DIST" | "THREAD_CHAMFER_LENGTH" => return Dimension::Length,
        _ => {}
    }
    if has("ANGLE") || name.starts_with("RTCP_RPY") || name.starts_with("RTCP_EULER") {
        return Dimension::Angle;
    }
    if is_length(name, has) { Dimension::Length } else { Dimension::None }
}

fn is_length(name: &str, has: impl Fn(&str) -> bool) -> bool {
    let starts = |prefix: &str| name.starts_with(prefix);
    let arc = starts("ARC_CENTER") || starts("ARC_RADIUS") || starts("ARC_3D_POINT");
    let frame = starts("LCS_TRANS") || starts("LCS_ROT_CENTER") || starts("LCS_SCALE_CENTER") || starts("C2P_");
    let cycle = starts("CYCLE_")
        && (has("DEPTH") || has("CLEAR") || has("RETRACT") || has("BOTTOM") || has("STEP") || has("JOG"));
    let thread = (starts("THREAD_") || starts("INTERP_THREAD_PITCH"))
        && !(has("STARTS") || has("CUTS") || has("INFEED") || has("PWORD"));
    arc || frame || cycle || thread
}

/// Axis data of an axis letter; a rotary letter means the axis on the workpiece side.
pub(super) fn axis_data(letter: &str) -> Option<DataId> {
    let suffix = match letter {
        "A" | "B" | "C" => format!("{letter}T"),
        _ => letter.to_owned(),
    };
    ident::data(&format!("REG_AXIS_{suffix}"))
}

/// Role of an axis by its data.
pub(super) fn role(id: DataId) -> AxisRole {
    match name(id) {
        "AXIS_X" => AxisRole::X,
        "AXIS_Y" => AxisRole::Y,
        "AXIS_Z" => AxisRole::Z,
        _ if dimension(id) == Dimension::Angle => AxisRole::Rotary,
        _ => AxisRole::Linear,
    }
}

/// Name of a built-in data identifier without `REG_`; empty for a custom one.
fn name(id: DataId) -> &'static str {
    ident::data_facts(id).and_then(|facts| facts.name.strip_prefix("REG_")).unwrap_or_default()
}
