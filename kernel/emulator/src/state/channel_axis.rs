//! The axes of a channel.

use counterpoint_machine::ident::DataId;
use counterpoint_machine::index::{AxisId, AxisSlot, IdTable};
use counterpoint_machine::model::{AxisRole, Dynamics};

/// An axis of the channel as the motion actions use it.
#[derive(Debug, Clone)]
pub(crate) struct ChannelAxis {
    /// Which axis of the machine it is.
    pub(crate) machine: AxisId,
    /// Identifier of its words.
    pub(crate) data: DataId,
    pub(crate) role: AxisRole,
    pub(crate) rotary: bool,
    /// Factor from programmed value to geometry: 0.5 on a diameter axis.
    pub(crate) scale: f64,
    /// Rapid rate per second, geometry units.
    pub(crate) rapid: f64,
    /// How fast its speed changes, geometry units; its corner speed per second.
    pub(crate) dynamics: Dynamics,
    pub(crate) home: f64,
    pub(crate) references: [Option<f64>; 3],
    pub(crate) floating: Option<f64>,
    pub(crate) one_way: f64,
    pub(crate) limits: Option<(f64, f64)>,
}

/// Number of axes that suffices for most channels.
pub(crate) const FIRST_AXES: usize = 4;

/// The limits of the axes of a channel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TravelBounds {
    /// One of them has limits of travel.
    pub(crate) limited: bool,
    /// For each of the first axes, the reciprocal of the smaller distance of its limits from zero; 0 without limits. A
    /// position whose products with these are at most 1 is within all limits.
    pub(crate) nearness: [f64; FIRST_AXES],
    /// An end beyond them stops the channel before the move.
    pub(crate) stop: bool,
    /// Registers of axes that other channels have, where their words are alarms, bit by register.
    pub(crate) foreign: u128,
}

impl TravelBounds {
    /// See [`nearness`](Self::nearness); infinite if a later axis has limits.
    pub(crate) fn nearness(axes: &IdTable<AxisSlot, ChannelAxis>) -> [f64; FIRST_AXES] {
        let mut nearness = [0.0; FIRST_AXES];
        for (slot, axis) in axes.entries() {
            let Some((low, high)) = axis.limits else { continue };
            match nearness.get_mut(slot.index()) {
                Some(nearness) => *nearness = 1.0 / high.min(-low).max(0.0),
                None => return [f64::INFINITY; FIRST_AXES],
            }
        }
        nearness
    }
}
