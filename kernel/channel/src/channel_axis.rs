//! The axes of a channel.

use counterpoint_machine::ident::DataId;
use counterpoint_machine::index::{AxisId, AxisSlot, IdTable};
use counterpoint_machine::model::{AxisRole, Dynamics};

/// An axis of the channel as the motion actions use it.
#[derive(Debug, Clone)]
pub struct ChannelAxis {
    /// Which axis of the machine it is.
    pub machine: AxisId,
    /// Identifier of its words.
    pub data: DataId,
    /// Its role in the channel.
    pub role: AxisRole,
    /// It turns; its positions are degrees.
    pub rotary: bool,
    /// Factor from programmed value to geometry: 0.5 on a diameter axis.
    pub scale: f64,
    /// Rapid rate per second, geometry units.
    pub rapid: f64,
    /// How fast its speed changes, geometry units; its corner speed per second.
    pub dynamics: Dynamics,
    /// Machine position of the first reference point, geometry units.
    pub home: f64,
    /// Machine positions of the second to fourth reference point, geometry units.
    pub references: [Option<f64>; 3],
    /// Machine position of the floating reference point, geometry units.
    pub floating: Option<f64>,
    /// Overrun of single direction positioning, geometry units; its sign is the direction of approach.
    pub one_way: f64,
    /// Smallest and largest machine position, geometry units.
    pub limits: Option<(f64, f64)>,
}

/// Number of axes that suffices for most channels.
pub const FIRST_AXES: usize = 4;

/// The limits of the axes of a channel.
#[derive(Debug, Clone, Copy)]
pub struct TravelBounds {
    /// One of them has limits of travel.
    pub limited: bool,
    /// For each of the first axes, the reciprocal of the smaller distance of its limits from zero; 0 without limits. A
    /// position whose products with these are at most 1 is within all limits.
    pub nearness: [f64; FIRST_AXES],
    /// An end beyond them stops the channel before the move.
    pub stop: bool,
    /// Registers of axes that other channels have, where their words are alarms, bit by register.
    pub foreign: u128,
}

impl TravelBounds {
    /// See [`nearness`](Self::nearness); infinite if a later axis has limits.
    pub fn nearness(axes: &IdTable<AxisSlot, ChannelAxis>) -> [f64; FIRST_AXES] {
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
