//! The work frame: presets, work offsets, tool offsets, length compensation.
//!
//! Invariant: changing the frame never moves the machine; the programmed position is what changes.

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Frame, Kind, MAX_AXES, OffsetKind, Position};
use crate::machine::ident::{codes, data};
use crate::state::block::Firing;
use crate::state::frames::offsets::Table;
use crate::state::modal::group;
use counterpoint_fault::Acted;

/// This block's positions are in the machine frame. In incremental mode the word is ignored: distances are distances in
/// any frame.
pub(super) fn machine_frame(kernel: &mut Kernel<'_>) -> Acted {
    // The mode that the block says, wherever it says so, else the active one.
    let code = |firing: &Firing| kernel.channel.env.machine.codes.get(usize::from(firing.row)).filter(|row| row.enable);
    let rows = kernel.channel.block.firings.iter().rev().filter_map(code);
    let said = rows.filter(|row| row.group == group::POSITION).map(|row| row.id).next();
    let mode = said.or_else(|| kernel.channel.state.modal.code(group::POSITION));
    if mode == Some(codes::POSITION_RELATIVE) {
        let text = format!("machine coordinates are ignored in incremental mode in '{}'", kernel.block_text());
        kernel.diagnose(&diag::MACHINE_INCREMENTAL, text);
        return Ok(());
    }
    kernel.channel.block.machine_frame = true;
    Ok(())
}

/// The place where the axes stand gets the programmed values.
pub(super) fn preset(kernel: &mut Kernel<'_>) -> Acted {
    // Nothing turns: words are positions, also of axes whose words are angles.
    let angles = std::mem::take(&mut kernel.channel.state.place.angles);
    let (coded, target) = kernel.targets();
    kernel.channel.state.place.angles = angles;
    if coded == 0 {
        return Ok(());
    }
    let turned = kernel.channel.state.place.frames.is_some();
    let stands = kernel.channel.contour();
    for (index, value) in target.iter().enumerate() {
        if (turned || coded & (1 << index) != 0)
            && let (Some(preset), Some(position)) =
                (kernel.channel.state.place.preset.get_mut(index), stands.get(index))
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
    kernel.missing_work_offset(number);
    kernel.channel.state.place.work_offset = number;
    kernel.emit(0, Kind::mode(format!("comp workp n={number}")));
    kernel.reframe();
    Ok(())
}

/// Cancels work offsets.
pub(super) fn work_offset_off(kernel: &mut Kernel<'_>) -> Acted {
    kernel.channel.state.place.work_offset = 0;
    kernel.emit(0, Kind::mode("comp workp off"));
    kernel.reframe();
    Ok(())
}

/// Tool length compensation of a type (1 to 4) with the H word; sign 0 cancels.
pub(super) fn length(kernel: &mut Kernel<'_>, sign: f64, set: u8) -> Acted {
    let asks = sign != 0.0 || kernel.block_has(data::COMP_LENGTH);
    let number = if asks { kernel.take(data::COMP_LENGTH).map(|d| d.value) } else { None };
    if sign == 0.0 && kernel.channel.tip().is_some_and(|tip| tip.with_length) {
        super::tip::off(kernel)?;
    }
    kernel.channel.state.place.length_sign = sign;
    let mode = if sign == 0.0 {
        kernel.channel.state.place.length_number = 0;
        Kind::mode("comp length off")
    } else {
        if let Some(number) = number.filter(|n| (0.0..=999_999.0).contains(n)) {
            kernel.channel.state.place.length_number = number as u32;
        }
        kernel.channel.state.place.compensation.set = set;
        let number = kernel.channel.state.place.length_number;
        let text = match set {
            1 => format!("comp length n={number}"),
            _ => format!("comp length n={number} set={set}"),
        };
        Kind::compensation(text, OffsetKind::Length, f64::from(number))
    };
    kernel.emit(0, mode);
    kernel.reframe();
    Ok(())
}

/// Length compensation that another code brings along.
pub(super) fn length_on(kernel: &mut Kernel<'_>, number: u32) {
    (kernel.channel.state.place.length_sign, kernel.channel.state.place.length_number) = (1.0, number);
    kernel.emit(0, Kind::compensation(format!("comp length n={number}"), OffsetKind::Length, f64::from(number)));
    kernel.reframe();
}

/// Everything between the program and the axes is as at the begin of a job, but for what offsets say; the machine
/// stands still.
pub(crate) fn forget(kernel: &mut Kernel<'_>) {
    if kernel.channel.end_tip() {
        kernel.emit(0, Kind::mode("rtcp off"));
    }
    let place = &mut kernel.channel.state.place;
    (place.frames, place.clamped) = (None, 0);
    (place.work_offset, place.tool_offset) = (1, 0);
    (place.length_sign, place.length_number) = (0.0, 0);
    place.preset = [0.0; MAX_AXES];
    kernel.reframe();
}

impl Kernel<'_> {
    /// Tells of a work offset that has no values.
    pub(super) fn missing_work_offset(&mut self, number: u32) {
        let known = self.channel.env.machine.work_offsets.len();
        let set = self.channel.state.place.offsets.as_deref().is_some_and(|offsets| offsets.has_work(number));
        if known > 0 && number as usize > known && !set {
            let text = format!(
                "work offset {number} has no values in machine {}, zero is used",
                self.channel.env.machine.name
            );
            self.diagnose(&diag::NO_OFFSET, text);
        }
    }

    /// Frame at program start.
    pub(crate) fn initial_frame(&mut self) {
        self.channel.state.place.shift = self.channel.wanted_shift();
        for (position, shift) in self.channel.state.place.position.iter_mut().zip(self.channel.state.place.shift) {
            *position -= shift;
        }
        if self.channel.state.place.shift != [0.0; MAX_AXES] {
            let shift = Box::new(self.channel.state.place.shift);
            self.emit(0, Kind::Frame(Frame { shift }));
        }
    }

    /// Sets an offset; `false` when there is no room for it or it is out of all bounds.
    pub(crate) fn set_offset(&mut self, table: Table, number: u32, values: Position) -> bool {
        let stored = self.channel.store_offset(table, number, values);
        if stored {
            self.reframe();
        }
        stored
    }

    /// Puts the sum of all offsets into force; the machine stands still.
    pub(crate) fn reframe(&mut self) {
        let wanted = self.channel.wanted_shift();
        if wanted == self.channel.state.place.shift {
            return;
        }
        let before = self.channel.counts_from();
        if self.channel.state.place.frames.is_some() {
            self.settle_for_macro();
            let levels = self.channel.cycle_levels();
            self.channel.standing(|channel| {
                channel.state.place.shift = wanted;
                channel.refresh_tip();
            });
            self.channel.keep_levels(levels);
        } else {
            self.channel.state.cycle.reframed(&self.channel.state.place.shift, &wanted);
            for ((position, old), new) in
                self.channel.state.place.position.iter_mut().zip(self.channel.state.place.shift).zip(wanted)
            {
                *position += old - new;
            }
            self.channel.state.place.shift = wanted;
        }
        self.channel.keep_ways(before);
        self.emit(0, Kind::Frame(Frame { shift: Box::new(wanted) }));
    }
}
