//! Axes that the feed of the path counts for; other axes of a move arrive at the same time.
//!
//! Facts: Siemens programming manual, fundamentals, "Feedrate (G93, G94, G95, F, FGROUP, FL, FGREF)", whose example of
//! FGROUP is worked in tests/spec/emulator/siemens-points.md; function manual K2, "Synchronized axes". A degree counts
//! as a millimetre, or as the travel at the radius of its axis. *Decision:* if only other axes move, the feed counts
//! for all of them. *Invariant:* a channel without a group counts all axes.

use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_event::info::MachineUnit;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::{AxisSlot, BySlot, IdTable};
use counterpoint_machine::model::AxisRole;

use super::channel_axis::ChannelAxis;
use super::channel_context::ChannelContext;

/// Smaller changes count as zero.
const NOISE: f64 = 1e-9;

/// The axes, and the length that a unit of each counts as.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedGroup {
    /// Axes of the group, bit by axis.
    axes: u8,
    /// The length that a unit of an axis counts as, geometry units.
    units: Position,
    /// Whether a degree of some axis does not count as a millimetre.
    has_radii: bool,
}

impl FeedGroup {
    /// The group that a channel begins with; none where all axes count.
    pub fn of(machine: &Machine, axes: &IdTable<AxisSlot, ChannelAxis>) -> Option<Box<Self>> {
        let geometry = |axis: &ChannelAxis| matches!(axis.role, AxisRole::X | AxisRole::Y | AxisRole::Z);
        let bits = axes.entries().filter(|(_, axis)| geometry(axis)).fold(0, |bits, (slot, _)| bits | slot.bit());
        machine.habits.feed_of_geometry.then(|| Box::new(Self::made(machine, axes, bits)))
    }

    /// A group of these axes.
    fn made(machine: &Machine, axes: &IdTable<AxisSlot, ChannelAxis>, bits: u8) -> Self {
        Self { axes: bits, units: Self::units_of(machine, axes), has_radii: false }
    }

    /// A degree is a millimetre.
    fn units_of(machine: &Machine, axes: &IdTable<AxisSlot, ChannelAxis>) -> Position {
        let degree = match machine.unit {
            MachineUnit::Inch => 1.0 / 25.4,
            MachineUnit::Mm => 1.0,
        };
        let mut units = [1.0; MAX_AXES];
        for (unit, axis) in units.iter_mut().zip(axes) {
            *unit = if axis.rotary { degree } else { 1.0 };
        }
        units
    }

    /// Whether the feed does not count the changes of all axes as they are.
    pub fn weighs(group: Option<&Self>, axes: &IdTable<AxisSlot, ChannelAxis>) -> bool {
        axes.entries().any(|(slot, axis)| axis.rotary || group.is_some_and(|group| group.axes & slot.bit() == 0))
    }

    /// Square of the travel outside the circle that the feed counts: along axes other than those of the circle.
    pub fn rise(&self, axes: &IdTable<AxisSlot, ChannelAxis>, changes: &Position, circle: [AxisSlot; 2]) -> f64 {
        let beside = axes.ids().filter(|axis| !circle.contains(axis) && self.axes & axis.bit() != 0);
        beside.map(|axis| (changes.at(axis) * self.units.at(axis)).powi(2)).sum()
    }

    /// Seconds of a move at feed; no axis that moves along exceeds its rate.
    pub fn seconds(&self, axes: &IdTable<AxisSlot, ChannelAxis>, seconds: f64, changes: &Position) -> f64 {
        axes.entries()
            .filter(|(axis, _)| self.axes & axis.bit() == 0)
            .map(|(axis, of)| changes.at(axis).abs() / of.rapid)
            .filter(|needed| needed.is_finite())
            .fold(seconds, f64::max)
    }

    /// Radii of rotary axes make their feed that of a length.
    pub fn turns_by_length(&self) -> bool {
        self.has_radii
    }
}

impl ChannelContext<'_> {
    /// Makes the feed count for these axes only, or for those of the control if there are none.
    pub fn set_feed_group(&mut self, axes: &[AxisSlot]) {
        let bits = axes.iter().fold(0, |bits, axis| bits | axis.bit());
        let layout = &self.state.place.layout;
        let radii = self.state.place.feed_group.take().filter(|group| group.has_radii);
        let mut group = match axes {
            [] => FeedGroup::of(self.env.machine, &layout.axes),
            _ => Some(Box::new(FeedGroup::made(self.env.machine, &layout.axes, bits))),
        };
        if let (Some(group), Some(radii)) = (&mut group, radii) {
            (group.units, group.has_radii) = (radii.units, true);
        }
        self.state.place.put_feed_group(group);
    }

    /// Makes a degree of a rotary axis count as the travel at this radius, geometry units.
    pub fn set_feed_radius(&mut self, axis: AxisSlot, radius: f64) {
        let axes = &self.state.place.layout.axes;
        let all = || Box::new(FeedGroup::made(self.env.machine, axes, u8::MAX));
        let mut group = self.state.place.feed_group.take().unwrap_or_else(all);
        *group.units.at_mut(axis) = radius.to_radians();
        group.has_radii = true;
        self.state.place.put_feed_group(Some(group));
    }

    /// Restores the group of the control, as at the start of a program.
    pub fn reset_feed_group(&mut self) {
        let group = FeedGroup::of(self.env.machine, &self.state.place.layout.axes);
        self.state.place.put_feed_group(group);
    }

    /// The travel of the axes that the feed counts for.
    pub(super) fn ways_of_group(&self, group: &FeedGroup, changes: &Position) -> Position {
        let axes = &self.state.place.layout.axes;
        // Coordinates of the part count, for any names of the axes.
        let part = self
            .state
            .place
            .polar()
            .map_or(0, |polar| polar.axes().into_iter().fold(0, |bits, axis| bits | axis.bit()));
        let counts = group.axes | part;
        let moves = |axis: AxisSlot| changes.at(axis).abs() > NOISE;
        let leads = axes.ids().any(|axis| counts & axis.bit() != 0 && moves(axis));
        let turns = |axis: AxisSlot| axes[axis].rotary && part & axis.bit() == 0;
        let alone = !group.has_radii && axes.ids().filter(|axis| moves(*axis)).all(turns);
        let mut out = *changes;
        for axis in axes.ids() {
            if leads && counts & axis.bit() == 0 {
                *out.at_mut(axis) = 0.0;
            } else if turns(axis) {
                // Degrees alone have the feed as written, for any unit of length.
                *out.at_mut(axis) *= if alone { self.unit_factor(Dimension::Feed) } else { group.units.at(axis) };
            }
        }
        out
    }
}
