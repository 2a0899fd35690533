//! The work frame: presets, work offsets, tool offsets, length compensation.
//!
//! Invariant: changing the frame never moves the machine; the programmed position is what changes.

use crate::channel::{Acted, Kernel};
use crate::diag;
use crate::log::event::{Kind, MAX_AXES, Position};
use crate::machine::ident::data;

/// This block's positions are in the machine frame.
pub(super) fn machine_frame(kernel: &mut Kernel<'_>) -> Acted {
    kernel.block.machine_frame = true;
    Ok(())
}

/// The place where the axes stand gets the programmed values.
pub(super) fn preset(kernel: &mut Kernel<'_>) -> Acted {
    let (coded, target) = kernel.targets();
    if coded == 0 {
        return Ok(());
    }
    let turned = kernel.place.frames.is_some();
    for (index, value) in target.iter().enumerate() {
        if (turned || coded & (1 << index) != 0)
            && let (Some(preset), Some(position)) =
                (kernel.place.preset.get_mut(index), kernel.place.position.get(index))
        {
            *preset += position - value;
        }
    }
    kernel.reframe();
    Ok(())
}

/// Selects a work offset.
pub(super) fn work_offset(kernel: &mut Kernel<'_>) -> Acted {
    let number = kernel.take(data::COMP_WORKP).map_or(1.0, |d| d.value);
    let number = if (1.0..=999.0).contains(&number) { number as u32 } else { 0 };
    let known = kernel.machine.work_offsets.len();
    if known > 0 && number as usize > known {
        let text = format!("work offset {number} has no values in machine {}, zero is used", kernel.machine.name);
        kernel.diagnose(&diag::NO_OFFSET, text);
    }
    kernel.place.work_offset = number;
    kernel.emit(0, Kind::Mode { text: format!("comp workp n={number}").into() });
    kernel.reframe();
    Ok(())
}

/// Cancels work offsets.
pub(super) fn work_offset_off(kernel: &mut Kernel<'_>) -> Acted {
    kernel.place.work_offset = 0;
    kernel.emit(0, Kind::Mode { text: "comp workp off".into() });
    kernel.reframe();
    Ok(())
}

/// Tool length compensation with the H word; sign 0 cancels.
pub(super) fn length(kernel: &mut Kernel<'_>, sign: f64) -> Acted {
    let number = kernel.take(data::COMP_LENGTH).map(|d| d.value);
    kernel.place.length_sign = sign;
    let text = if sign == 0.0 {
        kernel.place.length_number = 0;
        "comp length off".to_owned()
    } else {
        if let Some(number) = number.filter(|n| (0.0..=999_999.0).contains(n)) {
            kernel.place.length_number = number as u32;
        }
        format!("comp length n={}", kernel.place.length_number)
    };
    kernel.emit(0, Kind::Mode { text: text.into() });
    kernel.reframe();
    Ok(())
}

impl Kernel<'_> {
    /// Frame at program start.
    pub(crate) fn initial_frame(&mut self) {
        self.place.shift = self.wanted_shift();
        for (position, shift) in self.place.position.iter_mut().zip(self.place.shift) {
            *position -= shift;
        }
        if self.place.shift != [0.0; MAX_AXES] {
            let shift = Box::new(self.place.shift);
            self.emit(0, Kind::Frame { shift });
        }
    }

    /// Puts the sum of all offsets into force; the machine stands still.
    pub(super) fn reframe(&mut self) {
        let wanted = self.wanted_shift();
        if wanted == self.place.shift {
            return;
        }
        if self.place.frames.is_some() {
            let machine = self.machine_point(&self.place.position);
            self.place.shift = wanted;
            self.place.position = self.point_of_machine(&machine);
            self.frames_changed();
        } else {
            for ((position, old), new) in self.place.position.iter_mut().zip(self.place.shift).zip(wanted) {
                *position += old - new;
            }
            self.place.shift = wanted;
        }
        self.emit(0, Kind::Frame { shift: Box::new(wanted) });
    }

    fn wanted_shift(&self) -> Position {
        let place = &self.place;
        let work = (place.work_offset as usize).checked_sub(1).and_then(|i| self.machine.work_offsets.get(i));
        let offset = |number: u32| self.machine.tool.offsets.iter().find(|o| o.number == number);
        let tool = offset(place.tool_offset);
        let length = offset(place.length_number);
        let mut shift = place.preset;
        for (slot, axis) in shift.iter_mut().zip(&place.axes) {
            let value = |list: Option<&Vec<f64>>| list.and_then(|v| v.get(axis.machine)).copied().unwrap_or(0.0);
            *slot += value(work) + value(tool.map(|t| &t.values));
            if place.length_sign != 0.0 {
                *slot += place.length_sign * value(length.map(|t| &t.values));
            }
        }
        shift
    }
}
