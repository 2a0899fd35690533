//! Defaults that follow from an identifier when its row omits them, beyond the columns of the tables.
//!
//! Invariant: every identifier has an answer. Facts: reference control-emulator.md 1.3, 6.2.

use crate::ident::dimension::Dimension;
use crate::ident::{self, CodeId, DataId, codes, data};
use crate::model::AxisRole;
use crate::rows::Modality;

/// Modality of a code in a group.
pub(super) fn modality(id: CodeId, group: u16) -> Modality {
    let one_block =
        [codes::EXACTSTOP, codes::EXACTSTOP_CLW, codes::EXACTSTOP_CCLW, codes::EXACTSTOP_LINEAR, codes::INTERP_SKIP];
    if group == 0 || one_block.contains(&id) { Modality::NonModal } else { Modality::Modal }
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
    match id {
        data::AXIS_X => AxisRole::X,
        data::AXIS_Y => AxisRole::Y,
        data::AXIS_Z => AxisRole::Z,
        _ if id.dimension() == Dimension::Angle => AxisRole::Rotary,
        _ => AxisRole::Linear,
    }
}
