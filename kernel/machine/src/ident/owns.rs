//! Codes to which all axis words of their block belong: a word that such a code does not take is a mistake of the
//! program and never moves an axis.
//!
//! Facts: programming manuals of the controls, which give these codes a block or a list of axis words of their own.
//! *Invariant:* a code that leaves axis words to the motion code of its block is not in this list.

use counterpoint_motion::frame::local::LocalFramePart;

use super::kind::CodeKind;
use super::kind::local::FrameChange;
use super::kind::plane::Tilt;
use super::{CodeId, codes};

/// Codes whose kind does not say it.
const OWN: &[CodeId] = &[
    codes::CYLINDER_MAP,
    codes::CYLINDER_ON,
    codes::DELAY,
    codes::DELAY_REV,
    codes::ENGRAVE,
    codes::FIGURE_SHIFT,
    codes::FIGURE_TURN,
    codes::GOHOME,
    codes::GOHOME_NTH,
    codes::GOHOME_RETURN,
    codes::OFFSET_SET,
    codes::POCKET,
    codes::POLE_LAST,
    codes::POLE_TOOL,
    codes::POLE_ZERO,
    codes::POSITION_PRESET,
    codes::STORED_LIMIT_ON,
    codes::WORK_AREA_HIGH,
    codes::WORK_AREA_LOW,
];

/// Whether all axis words of a block with this code belong to the code, unless its row says otherwise.
#[must_use]
pub fn owns_axes(id: CodeId) -> bool {
    match id.kind() {
        CodeKind::Local(_, FrameChange::On | FrameChange::Add)
        | CodeKind::Local(LocalFramePart::Mirror, FrameChange::Off) => true,
        CodeKind::Plane(Tilt::On(_) | Tilt::Add(_)) | CodeKind::Turning(_) => true,
        _ => OWN.contains(&id),
    }
}
