//! Axes, frames and modes for the interpreter.

use counterpoint_channel::channel_axis::ChannelAxis;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_channel::offset_tables::{OffsetTable, Radii};
use counterpoint_channel::word_values::axis_diameter_factor;
use counterpoint_control_api::{AxisPlace, FrameHost, ModalSnapshot};
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::affine::Affine;

use crate::channel::Kernel;

/// Factor from positions as the program counts them to those of an axis.
fn program_factor(channel: &ChannelContext<'_>, axis: AxisSlot) -> f64 {
    let turns = channel.state.place.layout.axes[axis].rotary;
    let length = if turns { 1.0 } else { channel.unit_factor(Dimension::Length) };
    length * axis_diameter_factor(channel, axis)
}

/// The axis along which tool lengths count: the axis normal to the plane.
fn length_axis(channel: &ChannelContext<'_>) -> Option<AxisSlot> {
    let role = match channel.state.modal.code(group::PLANE) {
        Some(codes::PLANE_ZX) => 1,
        Some(codes::PLANE_YZ) => 0,
        _ => 2,
    };
    channel.state.place.layout.cartesian.get(role).copied().flatten()
}

/// Length along the tool and radius of an offset, wear included.
fn offset_size(channel: &ChannelContext<'_>, offset: u32) -> [f64; 2] {
    let length = length_axis(channel).map_or(0.0, |axis| channel.worn_length(offset).at(axis));
    [length, channel.worn_radius(offset)]
}

impl FrameHost for Kernel<'_> {
    fn axes(&self) -> Vec<AxisPlace> {
        let programmed = self.channel.state.place.programmed();
        let machine = self.channel.state.place.machine_point(&self.channel.state.place.position);
        let counted = self.channel.state.place.counted();
        let places = self.channel.state.place.layout.axes.entries().map(|(slot, axis)| {
            let named = &self.channel.env.machine.axes[axis.machine];
            let factor = program_factor(&self.channel, slot);
            AxisPlace {
                name: named.name.clone(),
                letter: named.letter.clone(),
                turns: axis.rotary,
                diameter: axis_diameter_factor(&self.channel, slot) * axis.scale < 1.0,
                work: programmed.at(slot) / factor,
                from: counted.at(slot) / factor,
                machine: machine.at(slot) / factor,
                line: self
                    .channel
                    .state
                    .place
                    .line_of(slot)
                    .map_or([1.0, 0.0], |line| [line.factor, line.shift / factor]),
            }
        });
        places.collect()
    }

    fn axis_letter(&self, name: &str) -> Option<&str> {
        let machine = &self.channel.env.machine.axes;
        let mut axes = self.channel.state.place.layout.axes.iter().map(|axis| &machine[axis.machine]);
        let is = |text: &str| text.eq_ignore_ascii_case(name);
        axes.find(|axis| is(&axis.letter) || is(&axis.name)).map(|axis| &*axis.letter)
    }

    fn positions(&self) -> Vec<(&str, f64, f64)> {
        let programmed = self.channel.state.place.programmed();
        let machine = self.channel.state.place.machine_point(&self.channel.state.place.position);
        let axes = self.channel.state.place.layout.axes.entries();
        let named = |axis: &ChannelAxis| &*self.channel.env.machine.axes[axis.machine].name;
        axes.map(|(slot, axis)| (named(axis), programmed.at(slot), machine.at(slot))).collect()
    }

    fn relative(&self) -> bool {
        self.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE)
    }

    fn moves_straight(&self) -> bool {
        matches!(self.channel.state.modal.code(group::MOTION), Some(codes::RAPID | codes::INTERP_LINEAR))
    }

    fn local_frame(&self) -> [f64; 12] {
        let map = self.channel.state.place.frames.as_deref().map_or(Affine::SAME, |frames| frames.local.programmed());
        let mut rows = <[f64; 12]>::try_from(map.cells()).unwrap_or_default();
        for (row, axis) in self.channel.state.place.layout.cartesian.iter().enumerate() {
            let Some(at) = *axis else { continue };
            let scale = self.channel.state.place.layout.axes[at].scale;
            if let Some(shift) = rows.get_mut(row * 4 + 3) {
                *shift /= scale * program_factor(&self.channel, at);
            }
        }
        rows
    }

    fn plane_angles(&self) -> Option<Vec<(String, f64)>> {
        let angles = self.channel.state.place.tilted()?.angles.as_ref()?;
        let machine = &self.channel.env.machine.axes;
        let of = |(axis, angle): &(AxisSlot, f64)| {
            let letter = machine[self.channel.state.place.layout.axes[*axis].machine].letter.clone();
            (letter, self.channel.state.place.programmed_angle(*axis, *angle))
        };
        Some(angles.iter().map(of).collect())
    }

    fn rapid_rate(&self, letter: &str) -> Option<f64> {
        let machine = &self.channel.env.machine.axes;
        let mut axes = self.channel.state.place.layout.axes.iter().map(|axis| &machine[axis.machine]);
        axes.find(|axis| axis.letter == letter).map(|axis| axis.rapid)
    }

    fn part_table(&self) -> Option<(String, [f64; 3])> {
        let (axis, direction) = self.channel.part_table()?;
        let letter = &self.channel.env.machine.axes[self.channel.state.place.layout.axes[axis].machine].letter;
        Some((letter.clone(), direction))
    }

    fn tool_direction(&self) -> Option<[f64; 3]> {
        let Some(tip) = self.channel.state.place.tip() else { return Some([0.0, 0.0, 1.0]) };
        let machine = self.channel.state.place.machine_point(&self.channel.state.place.position);
        tip.chain.direction(|axis| machine.at(axis))
    }

    fn keeps_moves_back(&self) -> bool {
        self.channel.state.place.is_compensated()
    }

    fn work_offset(&self) -> u32 {
        self.channel.state.place.in_force.work_offset
    }

    fn offset(&self, number: u32) -> Vec<f64> {
        let values = self.channel.offset_values(OffsetTable::Work, number);
        self.channel
            .state
            .place
            .layout
            .axes
            .ids()
            .map(|axis| values.at(axis) / program_factor(&self.channel, axis))
            .collect()
    }

    fn set_offset(&mut self, number: u32, values: &[f64]) -> bool {
        let mut offset = self.channel.offset_values(OffsetTable::Work, number);
        for (axis, value) in self.channel.state.place.layout.axes.ids().zip(values) {
            *offset.at_mut(axis) = value * program_factor(&self.channel, axis);
        }
        Kernel::set_offset(self, OffsetTable::Work, number, offset)
    }

    fn offset_turn(&self, number: u32) -> Option<[f64; 9]> {
        let cells = self.channel.state.place.offsets.as_deref().and_then(|offsets| offsets.turn(number))?.cells();
        let rows = cells.chunks(4).filter_map(|row| row.get(..3)).flatten().copied();
        <[f64; 9]>::try_from(rows.collect::<Vec<_>>()).ok()
    }

    fn turn_offset(&mut self, number: u32, turn: Option<[f64; 9]>) -> bool {
        let affine = |[a, b, c, d, e, f, g, h, i]: [f64; 9]| [a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0];
        let turn = match turn.map(|turn| Affine::of_cells(affine(turn))) {
            Some(None) => return false,
            Some(turn) => turn,
            None => None,
        };
        let stored = self.channel.state.place.offsets.get_or_insert_default().store_turn(number, turn);
        self.reframe();
        stored
    }

    fn go_beside(&mut self, letter: &str, to: f64, feed: Option<f64>) {
        let Some(axis) = slot_of(&self.channel, letter) else { return };
        let to = to * program_factor(&self.channel, axis);
        let turns = self.channel.state.place.layout.axes[axis].rotary;
        let factor = if turns { 1.0 } else { self.channel.unit_factor(Dimension::Feed) };
        self.channel.state.go_beside(axis, to, feed.map(|feed| feed * factor));
    }

    fn meet_fixed_stop(&mut self, letter: &str, meets: bool) -> bool {
        let Some(axis) = slot_of(&self.channel, letter) else { return false };
        let stops = &mut self.channel.state.others.spindles.fixed_stops;
        stops.named = if meets { stops.named | axis.bit() } else { stops.named & !axis.bit() };
        stops.met &= stops.named;
        true
    }

    fn is_at_fixed_stop(&self, letter: &str) -> bool {
        let met = self.channel.state.others.spindles.fixed_stops.met;
        slot_of(&self.channel, letter).is_some_and(|axis| met & axis.bit() != 0)
    }

    fn count_feed(&mut self, letters: &[String]) {
        let axes: Vec<AxisSlot> = letters.iter().filter_map(|letter| slot_of(&self.channel, letter)).collect();
        self.channel.set_feed_group(&axes);
    }

    fn set_feed_radius(&mut self, letter: &str, radius: f64) -> bool {
        let Some(axis) =
            slot_of(&self.channel, letter).filter(|axis| self.channel.state.place.layout.axes[*axis].rotary)
        else {
            return false;
        };
        self.channel.set_feed_radius(axis, radius * self.channel.unit_factor(Dimension::Length));
        true
    }

    fn area_side(&self, letter: &str, high: bool) -> Option<(Option<f64>, bool)> {
        let axis = slot_of(&self.channel, letter)?;
        let (limit, counts) = self.channel.area_side(axis, high);
        Some((limit.map(|limit| limit / program_factor(&self.channel, axis)), counts))
    }

    fn set_area_side(&mut self, letter: &str, high: bool, limit: Option<f64>, counts: Option<bool>) -> bool {
        let Some(axis) = slot_of(&self.channel, letter) else { return false };
        let limit = limit.map(|limit| limit * program_factor(&self.channel, axis));
        if let Some(side) = self.channel.work_area().side(axis, high) {
            (side.limit, side.enabled) = (limit.or(side.limit), counts.or(side.enabled));
        }
        true
    }

    fn tool(&self) -> u32 {
        self.channel.state.place.tools.current
    }

    fn tool_number(&mut self, name: &str) -> Option<u32> {
        let tool = &self.channel.env.machine.tool;
        let name = name.trim();
        tool.number_of(name).or_else(|| self.channel.state.others.tools.called.number(name, tool.named_from?))
    }

    fn known_tool(&self, name: &str) -> Option<u32> {
        let (tool, name) = (&self.channel.env.machine.tool, name.trim());
        tool.number_of(name).or_else(|| self.channel.state.others.tools.called.known(name, tool.named_from?))
    }

    fn name_tool(&mut self, number: u32, name: &str) {
        self.channel.state.others.tools.called.name(number, name.trim());
    }

    fn polar(&self) -> [Option<f64>; 2] {
        let remembered = &self.channel.state.remembered;
        let radius =
            remembered.value(data::POLE_RADIUS).map(|radius| radius / self.channel.unit_factor(Dimension::Length));
        [remembered.value(data::POLE_ANGLE), radius]
    }

    fn steps_are_radii(&self) -> bool {
        self.channel.state.steps_are_radii()
    }

    fn tool_in_force(&self) -> [f64; 2] {
        let place = &self.channel.state.place;
        let length = if place.in_force.length_sign == 0.0 { 0 } else { place.in_force.length_number };
        let radius = self.channel.state.remembered.diameter();
        [
            if length == 0 { 0.0 } else { offset_size(&self.channel, length)[0] },
            if radius == 0 { 0.0 } else { offset_size(&self.channel, radius)[1] },
        ]
    }

    fn tool_size(&self, offset: u32) -> [f64; 2] {
        offset_size(&self.channel, offset)
    }

    fn set_tool_size(&mut self, offset: u32, at: usize, value: f64) -> bool {
        if at > 0 {
            return self.channel.set_offset_radius(Radii::Cutter, offset, value);
        }
        let Some(along) = length_axis(&self.channel) else { return false };
        let mut values = self.channel.offset_values(OffsetTable::Length, offset);
        *values.at_mut(along) = value;
        self.channel.state.place.offsets.get_or_insert_default().store(OffsetTable::Length, offset, values)
    }

    fn tool_offset(&self, offset: u32) -> Vec<f64> {
        let values = self.channel.worn_length(offset);
        self.channel
            .state
            .place
            .layout
            .axes
            .ids()
            .map(|axis| values.at(axis) / program_factor(&self.channel, axis))
            .collect()
    }

    fn set_tool_offset(&mut self, offset: u32, values: &[f64]) -> bool {
        let mut lengths = self.channel.offset_values(OffsetTable::Length, offset);
        for (axis, value) in self.channel.state.place.layout.axes.ids().zip(values) {
            *lengths.at_mut(axis) = value * program_factor(&self.channel, axis);
        }
        Kernel::set_offset(self, OffsetTable::Length, offset, lengths)
    }

    fn length_in_force(&self) -> Vec<f64> {
        let values = self.channel.tool_shift();
        self.channel
            .state
            .place
            .layout
            .axes
            .ids()
            .map(|axis| values.at(axis) / program_factor(&self.channel, axis))
            .collect()
    }

    fn set_preset(&mut self, values: &[f64]) {
        for (axis, value) in self.channel.state.place.layout.axes.clone().ids().zip(values) {
            let value = value * program_factor(&self.channel, axis);
            *self.channel.state.place.preset.at_mut(axis) = value;
        }
        self.reframe();
    }

    fn travel(&self, letter: &str) -> Option<(f64, f64)> {
        let axes = &self.channel.env.machine.axes;
        let is = |axis: &&ChannelAxis| axes[axis.machine].letter.eq_ignore_ascii_case(letter);
        self.channel.state.place.layout.axes.iter().find(is)?.limits
    }

    fn tip(&self, offset: u32) -> u8 {
        self.channel.offset_tip(offset)
    }

    fn set_tip(&mut self, offset: u32, tip: f64) -> bool {
        self.channel.state.place.offsets.get_or_insert_default().set_tip(offset, tip)
    }

    fn wear(&self, offset: u32, of: usize) -> f64 {
        match self.channel.state.place.layout.cartesian.get(of) {
            Some(axis) => axis.map_or(0.0, |axis| self.channel.offset_values(OffsetTable::Wear, offset).at(axis)),
            None => self.channel.offset_radius(Radii::Wear, offset),
        }
    }

    fn set_wear(&mut self, offset: u32, of: usize, value: f64) -> bool {
        let axis = match self.channel.state.place.layout.cartesian.get(of) {
            Some(axis) => *axis,
            None => return self.channel.set_offset_radius(Radii::Wear, offset, value),
        };
        let Some(axis) = axis else { return false };
        let mut values = self.channel.offset_values(OffsetTable::Wear, offset);
        *values.at_mut(axis) = value;
        Kernel::set_offset(self, OffsetTable::Wear, offset, values)
    }

    fn feed(&self) -> f64 {
        let (id, _) = feed_of(self.channel.state.modal.code(group::FEED));
        self.channel.state.remembered.value(id).unwrap_or(0.0)
    }

    fn is_active(&self, code: CodeId) -> bool {
        self.channel.state.modal.has(code)
    }

    fn modes(&self) -> ModalSnapshot {
        ModalSnapshot(self.channel.state.modal.saved())
    }

    fn restore_modes(&mut self, modes: &ModalSnapshot) {
        counterpoint_channel::units::put_modes_back(&mut self.channel, &modes.0);
    }
}

/// The axis of the channel that the program calls by a letter.
fn slot_of(channel: &ChannelContext<'_>, letter: &str) -> Option<AxisSlot> {
    let machine = &channel.env.machine.axes;
    let mut axes = channel.state.place.layout.axes.entries();
    axes.find(|(_, axis)| machine[axis.machine].letter.eq_ignore_ascii_case(letter)).map(|(slot, _)| slot)
}
