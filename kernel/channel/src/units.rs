//! Factors from the units of a program to those of the machine.

use super::ChannelMemory;
use super::channel_context::ChannelContext;
use super::modal::group;
use counterpoint_event::info::MachineUnit;
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::ident::{DataId, codes};
use counterpoint_machine::index::CodeRowId;

impl ChannelMemory {
    /// Whether the active code of the units selects the secondary unit of length.
    pub fn says_secondary(&self) -> bool {
        let active = self.modal.code(group::UNITS);
        matches!(active, Some(codes::UNITS_SECONDARY | codes::UNITS_SECONDARY_LENGTHS))
    }

    /// Feeds and surface speeds are in the secondary unit, too.
    pub fn counts_feeds_in_secondary(&self) -> bool {
        self.secondary && self.modal.code(group::UNITS) != Some(codes::UNITS_SECONDARY_LENGTHS)
    }
}

impl ChannelContext<'_> {
    /// Factor from program units to machine units.
    pub fn unit_factor(&self, dimension: Dimension) -> f64 {
        if !self.state.secondary {
            return 1.0;
        }
        if dimension == Dimension::Feed && !self.state.counts_feeds_in_secondary() {
            return 1.0;
        }
        match (dimension, self.env.machine.unit) {
            (Dimension::Length | Dimension::Feed, MachineUnit::Mm) => 25.4,
            (Dimension::Length | Dimension::Feed, MachineUnit::Inch) => 1.0 / 25.4,
            (Dimension::FeedTenths, MachineUnit::Inch) => 10.0 / 25.4,
            // The least increment of an inch is ten times finer.
            (Dimension::Increments | Dimension::FeedTenths, MachineUnit::Mm) => 2.54,
            (Dimension::Increments, MachineUnit::Inch) => 10.0 / 25.4,
            _ => 1.0,
        }
    }

    /// The same for a word: a distance along X may be a radius though positions are diameters.
    #[cold]
    pub fn position_factor(&self, id: DataId, incremental: bool) -> f64 {
        let relative = incremental || self.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
        let is_radius = relative && self.state.steps_are_radii() && matches!(id.kind(), DataKind::Axis(_));
        self.state.diameter_factor() * if is_radius { 2.0 } else { 1.0 }
    }
}

/// Restores saved modal codes: group, code, row.
pub fn put_modes_back(channel: &mut ChannelContext<'_>, saved: &[(u16, CodeId, Option<CodeRowId>)]) {
    channel.state.modal.restore(saved);
    channel.state.follow_cycle();
    channel.follow_spindle();
    channel.state.follow_clamps();
    channel.state.secondary = channel.state.says_secondary();
}

impl ChannelMemory {
    /// Factor from programmed positions of X to those of its axis. The program may use radii for a diameter axis, or
    /// diameters for another axis (reference control-emulator.md 6.2).
    #[cold]
    pub fn diameter_factor(&self) -> f64 {
        match (self.modal.code(group::DIAMETER_X), self.place.scale_of(0) < 1.0) {
            (Some(codes::XAXIS_RADIUS), true) => 2.0,
            (Some(codes::XAXIS_DIAMETER), false) => 0.5,
            _ => 1.0,
        }
    }

    /// Distances along X are radii, though positions are diameters (Siemens DIAM90).
    #[cold]
    pub fn steps_are_radii(&self) -> bool {
        let counts = self.modal.code(group::DIAMETER_X) == Some(codes::XAXIS_DIAMETER_ABSOLUTE);
        counts && self.place.scale_of(0) < 1.0
    }
}
