//! Axes of a channel, their positions, and the frames between the program and them.

use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_fault as diag;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::index::{AxisSlot, IdTable};
use counterpoint_machine::model::{AxisRole, Machine, RotaryPositioning};

use super::channel_axis::{ChannelAxis, TravelBounds};
use super::feed_group::FeedGroup;

/// The axes of a channel, which do not change while it runs.
#[derive(Debug)]
pub struct AxisLayout {
    /// Axes in channel order.
    pub axes: IdTable<AxisSlot, ChannelAxis>,
    /// One of them turns.
    pub rotary: bool,
    /// The limits of the axes.
    pub bounds: TravelBounds,
    /// Axes whose absolute words are angles, not positions, bit by axis.
    pub angles: u8,
    /// Axes that channels exchange, bit by axis.
    pub exchanged: u8,
    /// Channel axis of the X, Y and Z roles.
    pub cartesian: [Option<AxisSlot>; 3],
}

impl AxisLayout {
    /// Channel axis with this letter.
    pub fn axis_of_letter(&self, machine: &Machine, letter: char) -> Option<AxisSlot> {
        let role = "XYZ".find(letter).and_then(|at| self.cartesian.get(at).copied().flatten());
        role.or_else(|| {
            self.axes.find(|axis| {
                let own = &machine.axes[axis.machine].letter;
                own.len() == 1 && own.starts_with(letter)
            })
        })
    }

    /// Whether the axis is not X, Y or Z: a rotary or parallel axis.
    pub fn is_beside(&self, axis: AxisSlot) -> bool {
        !self.cartesian.contains(&Some(axis))
    }
}

/// Numbers of the active offsets.
#[derive(Debug, Clone, Copy)]
pub struct InForce {
    /// Work offset, 0 = none.
    pub work_offset: u32,
    /// Tool offset, 0 = none.
    pub tool_offset: u32,
    /// Length compensation: +1, −1 or 0.
    pub length_sign: f64,
    /// Its number.
    pub length_number: u32,
    /// Axes for which length compensation is suspended, one bit each.
    pub length_off: u8,
    /// The active values, if the offset has received new values since.
    pub length_held: Option<Position>,
}

impl InForce {
    /// Activates a length offset with a sign; 0 ends length compensation.
    pub fn set_length(&mut self, sign: f64, number: u32) {
        (self.length_sign, self.length_number) = (sign, number);
        (self.length_off, self.length_held) = (0, None);
    }
}

impl Default for InForce {
    fn default() -> Self {
        Self { work_offset: 1, tool_offset: 0, length_sign: 0.0, length_number: 0, length_off: 0, length_held: None }
    }
}

/// Tools of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct ToolState {
    /// Tool in use.
    pub current: u32,
    /// Preselected tool.
    pub selected: u32,
    /// A tool has been preselected, be it none (T0).
    pub chosen: bool,
    /// It has been reported that the machine has no tool offsets.
    pub offsets_reported: bool,
}

/// Where the channel is and how it moves.
#[derive(Debug)]
pub struct MotionState {
    /// Its axes.
    pub layout: AxisLayout,
    /// Programmed position in the work frame.
    pub position: Position,
    /// Machine frame = work frame + shift.
    pub shift: Position,
    /// Part of the shift from presets and manual settings, without work and tool offsets.
    pub preset: Position,
    /// Active offsets.
    pub in_force: InForce,
    /// Intermediate point of the last home move, for the return.
    pub home_via: Option<Position>,
    /// Tools.
    pub tools: ToolState,
    /// Clamped axes, bit by axis.
    pub clamped: u8,
    /// The axes that the feed counts for; all without it.
    pub feed_group: Option<Box<FeedGroup>>,
    /// The feed does not count the changes of all axes as they are.
    pub weighs: bool,
    /// The area that the program has set; none until it does.
    pub stored: Option<Box<super::stored::StoredArea>>,
    /// Transformations between the program and the work frame; none if none is active.
    pub frames: Option<Box<super::frame_transforms::FrameTransforms>>,
    /// Offsets that macros have set; none while those of the machine hold.
    pub offsets: Option<Box<super::offset_tables::Offsets>>,
    /// Numbers, sets and directions of compensations.
    pub compensation: super::compensation::CompensationModes,
}

impl MotionState {
    /// A channel at home, work offset 1 active if the machine has it.
    pub fn new(machine: &Machine, channel: &counterpoint_machine::model::Channel) -> Self {
        let axes = channel.axes.map(|_, &id| {
            let a = &machine.axes[id];
            let scale = if a.diameter { 0.5 } else { 1.0 };
            ChannelAxis {
                machine: id,
                data: a.data,
                role: a.role,
                rotary: a.role.is_rotary(),
                scale,
                rapid: a.rapid / 60.0,
                dynamics: a.dynamics.per_second(),
                home: a.home,
                references: a.positioning.references,
                floating: a.positioning.floating,
                one_way: a.positioning.one_way,
                limits: a.limits,
            }
        });
        let find = |role: AxisRole| axes.find(|axis| axis.role == role);
        let cartesian = [find(AxisRole::X), find(AxisRole::Y), find(AxisRole::Z)];
        let bounds = TravelBounds {
            limited: axes.iter().any(|axis| axis.limits.is_some()),
            nearness: TravelBounds::nearness(&axes),
            stop: machine.stops_at(&diag::OVER_TRAVEL),
            foreign: foreign(machine, &axes),
        };
        let feed_group = FeedGroup::of(machine, &axes);
        Self {
            position: machine.home(channel),
            weighs: FeedGroup::weighs(feed_group.as_deref(), &axes),
            feed_group,
            layout: AxisLayout {
                rotary: axes.iter().any(|axis| axis.rotary),
                bounds,
                angles: angles(machine, &axes),
                exchanged: exchanged(machine, &axes),
                axes,
                cartesian,
            },
            shift: [0.0; MAX_AXES],
            preset: [0.0; MAX_AXES],
            in_force: InForce::default(),
            home_via: None,
            tools: ToolState::default(),
            clamped: 0,
            stored: None,
            frames: None,
            offsets: None,
            compensation: super::compensation::CompensationModes::of(machine),
        }
    }
}

/// Registers of axes that channels exchange, and where such words are alarms, those that only move axes which the
/// channel does not have.
fn foreign(machine: &Machine, axes: &IdTable<AxisSlot, ChannelAxis>) -> u128 {
    let exchanged = machine.tables.data_of_register.entries().filter(|(_, rows)| {
        let mut ids = rows.iter().map(|&row| machine.data[row].id);
        ids.any(|id| axes.iter().any(|axis| axis.data == id && machine.axes[axis.machine].master.is_some()))
    });
    let exchanged = exchanged.fold(0, |bits, (register, _)| bits | register.bit());
    if !machine.stops_at(&diag::AXIS_NOT_IN_CHANNEL) {
        return exchanged;
    }
    let registers = machine.tables.data_of_register.entries();
    let foreign = registers.filter(|(_, rows)| {
        let mut ids = rows.iter().map(|&row| &machine.data[row]).map(|row| row.id);
        let positions = |kind| matches!(kind, DataKind::Axis(_) | DataKind::FramePoint | DataKind::Polar);
        let only = ids.clone().all(|id| positions(id.kind()));
        let moves = ids.clone().any(|id| id.kind().is_axis());
        only && moves && !ids.any(|id| axes.iter().any(|axis| axis.data == id))
    });
    foreign.fold(exchanged, |bits, (register, _)| bits | register.bit())
}

/// Axes of a channel that channels exchange, bit by axis.
fn exchanged(machine: &Machine, axes: &IdTable<AxisSlot, ChannelAxis>) -> u8 {
    let is = |axis: &ChannelAxis| machine.axes[axis.machine].master.is_some();
    axes.entries().filter(|(_, axis)| is(axis)).fold(0, |bits, (slot, _)| bits | slot.bit())
}

/// Axes of a channel whose absolute words are angles, bit by axis.
fn angles(machine: &Machine, axes: &IdTable<AxisSlot, ChannelAxis>) -> u8 {
    let is = |axis: &ChannelAxis| machine.axes[axis.machine].turn != RotaryPositioning::Position;
    axes.entries().filter(|(_, axis)| is(axis)).fold(0, |bits, (slot, _)| bits | slot.bit())
}
