//! What a channel remembers from block to block: modal codes, modal data, positions, frames.

use crate::diag;
use crate::log::event::{FeedUnit, MAX_AXES, Position};
use crate::machine::ident::data;
use crate::machine::ident::{CodeId, DataId, codes};
use crate::machine::model::{AxisRole, Machine};
use crate::multi::shared::Command;

/// Modal groups the kernel itself asks for (reference control-emulator.md 3.2).
pub(crate) mod group {
    pub(crate) const MOTION: u16 = 1;
    pub(crate) const PLANE: u16 = 2;
    pub(crate) const POSITION: u16 = 3;
    pub(crate) const FEED: u16 = 5;
    pub(crate) const UNITS: u16 = 6;
    pub(crate) const DIAMETER: u16 = 7;
    pub(crate) const CYCLE: u16 = 9;
    pub(crate) const RETRACT: u16 = 10;
    pub(crate) const EXACT_STOP: u16 = 15;
    pub(crate) const COOLANT: u16 = 54;
    pub(crate) const COOLANT_SIDE: u16 = 540;
    pub(crate) const SPINDLES: u16 = 67;
    pub(crate) const HEAD: u16 = 68;
    pub(crate) const ACROSS: u16 = 109;
}

/// Modal codes and data.
#[derive(Debug)]
pub(crate) struct Modal {
    /// Active code row of each group, `None` = `CODE_NONE`.
    groups: Vec<Option<(CodeId, u16)>>,
    /// Remembered values by data identifier.
    data: Vec<Option<f64>>,
    /// Groups whose active code fires again on blocks without a code of the group; `true` = on every block.
    pub(crate) refires: Vec<(u16, bool)>,
}

impl Modal {
    pub(crate) fn new(machine: &Machine) -> Self {
        let data_ids = data::TABLE.len() + machine.custom_data.len();
        Self { groups: vec![None; 1000], data: vec![None; data_ids], refires: Vec::new() }
    }

    /// Active code of a group.
    pub(crate) fn code(&self, group: u16) -> Option<CodeId> {
        self.groups.get(usize::from(group)).copied().flatten().map(|(id, _)| id)
    }

    /// Active row of a group.
    pub(crate) fn row(&self, group: u16) -> Option<u16> {
        self.groups.get(usize::from(group)).copied().flatten().map(|(_, row)| row)
    }

    /// Makes a code the active one of its group (group 0 has none).
    pub(crate) fn activate(&mut self, group: u16, id: CodeId, row: u16) {
        if group != 0
            && let Some(slot) = self.groups.get_mut(usize::from(group))
        {
            *slot = Some((id, row));
            if !self.refires.is_empty() {
                self.refires.retain(|&(g, _)| g != group);
            }
        }
    }

    /// Makes a code active that fires again on every block.
    pub(crate) fn activate_persistent(&mut self, group: u16, id: CodeId, row: u16) {
        self.activate(group, id, row);
        if group != 0 {
            self.refires.push((group, true));
        }
    }

    /// The active code of the group fires once on the next block without a code of the group.
    pub(crate) fn refire_once(&mut self, group: u16) {
        if self.code(group).is_some() && !self.refires.iter().any(|&(g, _)| g == group) {
            self.refires.push((group, false));
        }
    }

    /// Active codes of all groups.
    pub(crate) fn saved(&self) -> Vec<(u16, CodeId, u16)> {
        let groups = self.groups.iter().zip(0_u16..);
        groups.filter_map(|(active, group)| active.map(|(id, row)| (group, id, row))).collect()
    }

    /// Puts active codes back; groups that had none have none again.
    pub(crate) fn restore(&mut self, saved: &[(u16, CodeId, u16)]) {
        self.groups.fill(None);
        for &(group, id, row) in saved {
            if let Some(slot) = self.groups.get_mut(usize::from(group)) {
                *slot = Some((id, row));
            }
        }
        let groups = &self.groups;
        self.refires.retain(|&(group, _)| groups.get(usize::from(group)).is_some_and(Option::is_some));
    }

    /// Remembered value.
    pub(crate) fn value(&self, id: DataId) -> Option<f64> {
        self.data.get(usize::from(id.0)).copied().flatten()
    }

    /// Remembers a value.
    pub(crate) fn remember(&mut self, id: DataId, value: f64) {
        if let Some(slot) = self.data.get_mut(usize::from(id.0)) {
            *slot = Some(value);
        }
    }
}

/// An axis of the channel as the motion actions use it.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    /// Index in the machine's axis list.
    pub(crate) machine: usize,
    /// Identifier of its words.
    pub(crate) data: DataId,
    pub(crate) role: AxisRole,
    pub(crate) rotary: bool,
    /// Factor from programmed value to geometry: 0.5 on a diameter axis.
    pub(crate) scale: f64,
    /// Rapid rate per second, geometry units.
    pub(crate) rapid: f64,
    /// Acceleration, geometry units.
    pub(crate) acceleration: Option<f64>,
    pub(crate) home: f64,
    pub(crate) references: [Option<f64>; 3],
    pub(crate) limits: Option<(f64, f64)>,
}

/// What the axes of a channel do not allow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// One of them has limits of travel.
    pub(crate) limited: bool,
    /// An end beyond them stops the channel before the move.
    pub(crate) stop: bool,
    /// Registers of axes that other channels have, where their words are alarms, bit by register.
    pub(crate) foreign: u128,
}

/// Where the channel stands and how it moves.
#[derive(Debug)]
pub(crate) struct Place {
    /// Axes in channel order.
    pub(crate) axes: Vec<Axis>,
    /// One of them turns.
    pub(crate) rotary: bool,
    /// What the axes do not allow.
    pub(crate) bounds: Bounds,
    /// Axes whose absolute words are angles, not positions, bit by axis.
    pub(crate) angles: u8,
    /// Programmed position in the work frame.
    pub(crate) position: Position,
    /// Machine frame = work frame + shift.
    pub(crate) shift: Position,
    /// Part of the shift from presets and manual settings, without work and tool offsets.
    pub(crate) preset: Position,
    /// Active work offset number, 0 = none.
    pub(crate) work_offset: u32,
    /// Active tool offset number, 0 = none.
    pub(crate) tool_offset: u32,
    /// Active length compensation: +1, −1 or 0.
    pub(crate) length_sign: f64,
    /// Its number.
    pub(crate) length_number: u32,
    /// Intermediate point of the last home move, for the return.
    pub(crate) home_via: Option<Position>,
    /// Channel axis of the X, Y and Z roles.
    pub(crate) cartesian: [Option<u8>; 3],
    /// Current tool.
    pub(crate) tool: u32,
    /// Preselected tool.
    pub(crate) selected: u32,
    /// It has been told that the machine has no tool offsets.
    pub(crate) told_offsets: bool,
    /// A tool has been preselected, be it none (T0).
    pub(crate) chosen: bool,
    /// Clamped axes, bit by axis.
    pub(crate) clamped: u8,
    /// What lies between the program and the work frame; none while nothing of it is active.
    pub(crate) frames: Option<Box<super::frames::Frames>>,
    /// Offsets that macros have set; none while those of the machine hold.
    pub(crate) offsets: Option<Box<super::frames::offsets::Offsets>>,
    /// Numbers, sets and directions of compensations.
    pub(crate) compensation: crate::action::compensation::Compensation,
}

impl Place {
    /// A channel at home, work offset 1 active if the machine has it.
    pub(crate) fn new(machine: &Machine, channel: &crate::machine::model::Channel) -> Self {
        let axes: Vec<Axis> = channel
            .axes
            .iter()
            .take(MAX_AXES)
            .filter_map(|&index| {
                machine.axes.get(index).map(|a| {
                    let scale = if a.diameter { 0.5 } else { 1.0 };
                    Axis {
                        machine: index,
                        data: a.data,
                        role: a.role,
                        rotary: a.role.is_rotary(),
                        scale,
                        rapid: a.rapid / 60.0,
                        acceleration: a.acceleration,
                        home: a.home,
                        references: a.references,
                        limits: a.limits,
                    }
                })
            })
            .collect();
        let find = |role: AxisRole| axes.iter().position(|a| a.role == role).map(|i| i as u8);
        let cartesian = [find(AxisRole::X), find(AxisRole::Y), find(AxisRole::Z)];
        Self {
            position: machine.home(channel),
            rotary: axes.iter().any(|axis| axis.rotary),
            bounds: Bounds {
                limited: axes.iter().any(|axis| axis.limits.is_some()),
                stop: machine.stops_at(&diag::OVER_TRAVEL),
                foreign: foreign(machine, &axes),
            },
            angles: crate::action::turning::angles(machine, &axes),
            axes,
            shift: [0.0; MAX_AXES],
            preset: [0.0; MAX_AXES],
            work_offset: 1,
            tool_offset: 0,
            length_sign: 0.0,
            length_number: 0,
            home_via: None,
            cartesian,
            tool: 0,
            selected: 0,
            told_offsets: false,
            chosen: false,
            clamped: 0,
            frames: None,
            offsets: None,
            compensation: crate::action::compensation::Compensation::of(machine),
        }
    }
}

/// Registers that only move axes which the channel does not have; none where such words are no alarms.
fn foreign(machine: &Machine, axes: &[Axis]) -> u128 {
    if !machine.stops_at(&diag::AXIS_NOT_IN_CHANNEL) {
        return 0;
    }
    let registers = machine.tables.data_of_register.iter().enumerate().take(127);
    let foreign = registers.filter(|(_, rows)| {
        let mut ids = rows.iter().filter_map(|&row| machine.data.get(usize::from(row))).map(|row| row.id);
        let names = ["REG_AXIS_", "REG_LCS_TRANS_", "REG_LCS_ROT_CENTER_", "REG_LCS_SCALE_CENTER_", "REG_C2P_INTERP_"];
        let only = ids.clone().all(|id| names.iter().any(|name| machine.data_name(id).starts_with(name)));
        let moves = ids.clone().any(|id| machine.data_name(id).starts_with("REG_AXIS_"));
        only && moves && !ids.any(|id| axes.iter().any(|axis| axis.data == id))
    });
    foreign.fold(0, |bits, (register, _)| bits | 1 << register)
}

/// Plane of arcs: names for listings and the roles of its axes (first, second), and the identifiers of their
/// centre words.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    pub(crate) first: usize,
    pub(crate) second: usize,
    pub(crate) centers: [DataId; 2],
}

/// Plane of a plane code.
pub(crate) fn plane(code: CodeId) -> Option<Plane> {
    match code {
        codes::PLANE_XY => Some(Plane { first: 0, second: 1, centers: [data::ARC_CENTER_X, data::ARC_CENTER_Y] }),
        codes::PLANE_ZX => Some(Plane { first: 2, second: 0, centers: [data::ARC_CENTER_Z, data::ARC_CENTER_X] }),
        codes::PLANE_YZ => Some(Plane { first: 1, second: 2, centers: [data::ARC_CENTER_Y, data::ARC_CENTER_Z] }),
        _ => None,
    }
}

/// Identifier and unit of the feed under a feed mode.
pub(crate) fn feed_of(mode: Option<CodeId>) -> (DataId, FeedUnit) {
    match mode {
        Some(codes::FEED_UPR) => (data::FEED_UPR, FeedUnit::PerRevolution),
        Some(codes::FEED_1T) => (data::FEED_1T, FeedUnit::InverseTime),
        _ => (data::FEED_UPM, FeedUnit::PerMinute),
    }
}

/// Spindle of the channel: its own state, or a copy of the shared one.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SpindleState {
    /// Index in the machine's spindle list, `None` = channel without spindle.
    pub(crate) index: Option<usize>,
    /// Other channels command it too.
    pub(crate) shared: bool,
    /// Last known command.
    pub(crate) command: Command,
    /// Speed now when another channel drives it.
    pub(crate) now: f64,
}
