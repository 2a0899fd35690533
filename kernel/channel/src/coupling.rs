//! Axes of the channel that are coupled with axes of other channels.

use counterpoint_machine::index::AxisSlot;
use counterpoint_waits::coupling::{CoupledPair, CouplingKind};

use super::channel_axis::ChannelAxis;

/// Which of both axes does not move in synchronous control (Fanuc L).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parking {
    /// None.
    #[default]
    Neither,
    /// The words of the master move the slave alone.
    Master,
    /// The slave stays.
    Slave,
}

impl Parking {
    /// Its number in the program.
    pub fn number(self) -> f64 {
        match self {
            Self::Neither => 0.0,
            Self::Master => 1.0,
            Self::Slave => 2.0,
        }
    }

    /// By the number in the program.
    pub fn of(number: f64) -> Option<Self> {
        [Self::Neither, Self::Master, Self::Slave]
            .into_iter()
            .zip([0.0, 1.0, 2.0])
            .find(|(_, n)| *n == number)
            .map(|p| p.0)
    }
}

/// An axis of the channel and the one that it is coupled with.
#[derive(Debug)]
pub struct Coupling {
    /// Both axes.
    pub pair: CoupledPair,
    /// The axis of this channel.
    pub slot: AxisSlot,
    /// This channel has the slave.
    pub slave: bool,
    /// Which of them does not move.
    pub parking: Parking,
    /// Where the own axis was when they were coupled, geometry units, machine frame.
    pub stood: f64,
    /// Where the words of the channel started from; the same, unless it is the place of the other axis.
    pub from: f64,
    /// How often both channels have met so.
    pub meetings: u8,
    /// While the words of the channel move the other axis: the own one, and where both stood, as [`ChannelAxis::moving`] takes
    /// it.
    pub own: Option<(ChannelAxis, (f64, f64, f64))>,
}

/// The state of couplings that one channel commands alone, as one channel sees them.
#[derive(Debug, Clone, Copy, Default)]
pub struct OneSidedCouplings {
    /// Whether the program of the channel, and programs of other channels, have the code; none until first needed.
    pub words: Option<[bool; 2]>,
    /// How many of them the channel has learned of.
    pub learned: usize,
}

impl Coupling {
    /// Whether the own axis follows the other axis, so that its words are not commands.
    pub fn follows(&self) -> bool {
        self.slave && self.pair.kind == CouplingKind::Synchronous
    }
}

/// Axes of a channel, bit by axis, of couplings of which something holds.
pub fn slots(couplings: &[Coupling], of: impl Fn(&Coupling) -> bool) -> u8 {
    couplings.iter().filter(|coupling| of(coupling)).fold(0, |bits, coupling| bits | coupling.slot.bit())
}

impl ChannelAxis {
    /// As this axis is commanded when its words move `other`, which is at `stands` where this one counts `from`; both
    /// in geometry units.
    pub fn moving(&self, other: &counterpoint_machine::model::Axis, (stands, from, sign): (f64, f64, f64)) -> Self {
        let scale = if other.diameter { 0.5 } else { 1.0 };
        let point = |value: f64| (from + sign * (value * scale - stands)) / self.scale;
        let limits = other.limits.map(|(low, high)| (point(low), point(high)));
        Self {
            rapid: other.rapid / 60.0,
            dynamics: other.dynamics.per_second(),
            home: point(other.home),
            references: other.positioning.references.map(|place| place.map(point)),
            floating: other.positioning.floating.map(point),
            limits: limits.map(|(one, two)| (one.min(two), one.max(two))),
            ..self.clone()
        }
    }
}
