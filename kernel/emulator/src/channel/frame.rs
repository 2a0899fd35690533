//! The work frame of a channel changes: presets, work offsets, tool offsets, length compensation.
//!
//! *Invariant:* changing the frame never moves the machine; only the programmed position changes.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::clamps::Modulo;
use counterpoint_channel::offset_tables::OffsetTable;
use counterpoint_event::event::{FrameShift, Kind, MAX_AXES, Position};
use counterpoint_fault as diag;
use counterpoint_machine::index::{AxisSlot, BySlot};

use super::Kernel;

impl Kernel<'_> {
    /// Sets an offset; `false` when there is no room for it or it is out of all bounds.
    pub fn set_offset(&mut self, table: OffsetTable, number: u32, values: Position) -> bool {
        self.channel.hold_length(table, number);
        let stored = self.channel.state.place.offsets.get_or_insert_default().store(table, number, values);
        if stored {
            self.reframe();
        }
        stored
    }

    /// Makes the sum of all offsets active; the machine does not move.
    pub fn reframe(&mut self) {
        let wanted = self.channel.wanted_shift();
        let turn = self
            .channel
            .state
            .place
            .offsets
            .as_deref()
            .and_then(|offsets| offsets.turn(self.channel.state.place.in_force.work_offset));
        let turned = self.channel.state.place.frames.as_deref().and_then(|frames| frames.local.outer());
        let turns = turn.as_ref() != turned;
        if wanted == self.channel.state.place.shift && !turns {
            return;
        }
        let before = self.channel.counts_from();
        // The levels of a cycle move with the axis.
        let travels = self.channel.block.flags.travels;
        if self.channel.state.place.frames.is_some() || turns {
            self.flush_for_macro();
            let levels = self.channel.state.cycle_levels();
            let mut refused = None;
            self.channel.standing(|channel| {
                channel.state.place.shift = wanted;
                if turns {
                    let has = channel.state.place.has_axes();
                    refused = channel.state.place.frames().local.turn(turn, has).err();
                }
                channel.refresh_tip();
                channel.refresh_tilt();
            });
            self.channel.state.keep_levels(levels.filter(|_| !travels));
            if refused.is_some() {
                let text = format!(
                    "the axes of the channel cannot rotate work offset {} in '{}'; the rotation is ignored",
                    self.channel.state.place.in_force.work_offset,
                    self.channel.block_text()
                );
                self.diagnose(&diag::FRAME_REFUSED, text);
            }
        } else {
            if !travels {
                self.channel.state.cycle.reframed(&self.channel.state.place.shift, &wanted);
            }
            for ((position, old), new) in
                self.channel.state.place.position.iter_mut().zip(self.channel.state.place.shift).zip(wanted)
            {
                *position += old - new;
            }
            self.channel.state.place.shift = wanted;
        }
        self.channel.state.place.keep_ways(before);
        self.channel.emit(0, Kind::Frame(FrameShift { shift: Box::new(wanted) }));
    }

    /// Resets the transformations between program and axes to those at the start of a job, except for offsets; the
    /// machine does not move.
    pub(crate) fn forget_frame(&mut self) {
        if self.channel.end_tip() {
            self.channel.emit(0, Kind::mode("rtcp off"));
        }
        if self.channel.end_tilt() {
            self.channel.emit(0, Kind::mode("tilt off"));
        }
        self.channel.state.others.tilt = Default::default();
        let place = &mut self.channel.state.place;
        (place.frames, place.clamped) = (None, 0);
        (place.in_force.work_offset, place.in_force.tool_offset) = (1, 0);
        place.in_force.set_length(0.0, 0);
        place.preset = [0.0; MAX_AXES];
        self.reframe();
    }

    /// Takes whole turns off the position of an axis; nothing moves.
    pub fn unwind_axis(&mut self, axis: AxisSlot, modulo: Modulo) {
        self.flush_for_macro();
        let mut machine = self.channel.state.place.machine_point(&self.channel.state.place.position);
        let slot = machine.at_mut(axis);
        let (before, after) = (*slot, modulo.of(*slot));
        if before == after {
            return;
        }
        *slot = after;
        self.channel.state.place.position = self.channel.state.place.way_of_machine(&machine);
        if let Some(cutter) = self.channel.state.place.cutter() {
            *cutter.contour.at_mut(axis) += after - before;
        }
        self.channel.state.place.frames_changed();
        let text =
            format!("unwind {}={}", self.channel.axis_name(axis), counterpoint_lang::format::wildcard_text(after));
        self.channel.emit(0, Kind::mode(text));
    }
}

/// Frame at program start.
pub(crate) fn initial_frame(channel: &mut ChannelContext<'_>) {
    channel.state.place.shift = channel.wanted_shift();
    for (position, shift) in channel.state.place.position.iter_mut().zip(channel.state.place.shift) {
        *position -= shift;
    }
    if channel.state.place.shift != [0.0; MAX_AXES] {
        let shift = Box::new(channel.state.place.shift);
        channel.emit(0, Kind::Frame(FrameShift { shift }));
    }
}
