//! States of compensation: numbers, sets and directions of offsets, extended and dynamic fixtures, corners.
//!
//! Facts: reference control-emulator.md 6.6, system-variables.md 7. Decisions: docs/emulation.md, "Offsets".

use counterpoint_lang::format::wildcard_text;

use crate::channel::Kernel;
use crate::log::event::{Kind, OffsetKind};
use crate::machine::ident::{DataId, codes, data};
use crate::state::compensation::number_of;
use counterpoint_fault::Acted;

/// An extended work offset: its register, in a range if the control has several.
pub(super) fn extended(kernel: &mut Kernel<'_>) -> Acted {
    let range = whole(kernel, data::COMP_EXTFIXT_RANGE);
    let Some(register) = whole(kernel, data::COMP_EXTFIXT_REG) else {
        let text = format!("an extended work offset needs its number in '{}'", kernel.block_text());
        kernel.diagnose(&crate::diag::DATA_MISSING, text);
        return Ok(());
    };
    let number = number_of(range.unwrap_or(1), register);
    kernel.missing_work_offset(number);
    kernel.channel.state.place.work_offset = number;
    let text = match range {
        Some(range) => format!("comp extfixt n={range},{register}"),
        None => format!("comp extfixt n={register}"),
    };
    kernel.emit(0, Kind::mode(text));
    kernel.reframe();
    Ok(())
}

fn whole(kernel: &mut Kernel<'_>, id: DataId) -> Option<u32> {
    kernel.take(id).map(|datum| datum.value).filter(|value| (0.0..=9999.0).contains(value)).map(|value| value as u32)
}

/// Dynamic fixture compensation.
pub(super) fn dynamic(kernel: &mut Kernel<'_>, on: bool) -> Acted {
    kernel.channel.state.place.compensation.dynamic = on;
    super::mode::mode(kernel, if on { "comp dynfix on" } else { "comp dynfix off" })
}

/// Corners of compensated paths.
pub(super) fn corner(kernel: &mut Kernel<'_>, arc: bool) -> Acted {
    kernel.channel.state.place.compensation.corner = if arc { 2 } else { 1 };
    super::mode::mode(kernel, if arc { "comp corner arc" } else { "comp corner linear" })
}

/// The vector form of cutter compensation: number and direction.
pub(super) fn vector(kernel: &mut Kernel<'_>) -> Acted {
    take_diameter(kernel);
    let words = [data::COMP_DIAM_P, data::COMP_DIAM_Q, data::COMP_DIAM_R].map(|id| kernel.take(id).map(|d| d.value));
    for (slot, word) in kernel.channel.state.place.compensation.vector.iter_mut().zip(words) {
        *slot = word.filter(|value| value.is_finite()).unwrap_or(*slot);
    }
    let direction = kernel.channel.state.place.compensation.vector.map(wildcard_text).join(",");
    let number = kernel.channel.state.place.compensation.diameter;
    let text = format!("comp diam vector n={number} pqr={direction}");
    super::cutter::switched(kernel, codes::COMP_3D_VECTOR)?;
    kernel.emit(0, Kind::compensation(text, OffsetKind::Diameter, f64::from(number)));
    Ok(())
}

/// Takes the number of a diameter offset; the last one stays.
pub(super) fn take_diameter(kernel: &mut Kernel<'_>) -> Option<f64> {
    let number = kernel.take(data::COMP_DIAM).map(|datum| datum.value);
    if let Some(number) = number.filter(|number| (0.0..=999_999.0).contains(number)) {
        kernel.channel.state.place.compensation.diameter = number as u32;
    }
    number
}
