//! Paths and their times where no spindle counts, and the factor by which a rate may exceed its limit.
//!
//! Facts: reference channel-synchronisation.md 3, control-emulator.md 6.9.

use counterpoint_event::event::Position;
use counterpoint_machine::ident::codes;
use counterpoint_machine::model::{Dynamics, RapidPath};
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::law::SpeedRamp;
use counterpoint_motion::profile::{stop_to_stop, stop_to_stop_smoothly};

use crate::channel_context::ChannelContext;
use crate::laws::note_law;
use crate::modal::group;

/// Rates with a smaller difference are equal: a rapid move has exactly the rate.
pub const EVEN: f64 = 1.0 + 1e-6;

/// A path whose time is requested.
#[derive(Debug, Clone, Copy)]
pub struct TimedPath<'a> {
    /// Start.
    pub from: &'a Position,
    /// End.
    pub to: &'a Position,
    /// Length that the feed applies to, geometry units.
    pub length: f64,
    /// Arc and index of its radial coordinate (0, 1), when it is one and X is in its plane.
    pub arc: Option<(&'a PlaneArc, Option<usize>)>,
}

/// Seconds of a rapid move.
pub fn rapid_seconds(channel: &ChannelContext<'_>, from: &Position, to: &Position) -> f64 {
    let changes = if !channel.state.place.couples() {
        channel.state.place.changes(from, to)
    } else {
        channel.state.place.changes(&channel.state.place.machine_point(from), &channel.state.place.machine_point(to))
    };
    match channel.env.machine.time.rapid {
        RapidPath::SlowestAxis => channel
            .state
            .place
            .layout
            .axes
            .iter()
            .zip(&changes)
            .map(|(axis, change)| {
                let Dynamics { acceleration, jerk, .. } = axis.dynamics;
                stop_to_stop_smoothly(*change, axis.rapid, acceleration, jerk)
            })
            .fold(0.0, f64::max),
        RapidPath::Linear => {
            let length = changes.iter().map(|c| c * c).sum::<f64>().sqrt();
            let (mut speed, mut acceleration, mut jerk) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            for (axis, change) in channel.state.place.layout.axes.iter().zip(&changes) {
                if *change != 0.0 {
                    let share = length / change.abs();
                    speed = speed.min(axis.rapid * share);
                    acceleration = acceleration.min(axis.dynamics.acceleration.map_or(f64::INFINITY, |a| a * share));
                    jerk = jerk.min(axis.dynamics.jerk.map_or(f64::INFINITY, |j| j * share));
                }
            }
            let finite = |value: f64| value.is_finite().then_some(value);
            stop_to_stop_smoothly(length, speed, finite(acceleration), finite(jerk))
        }
    }
}

/// Seconds at a steady speed, with speed changes at both ends under exact stop.
pub fn paced(channel: &mut ChannelContext<'_>, path: &TimedPath<'_>, speed: f64) -> f64 {
    let exact =
        channel.block.flags.exact_stop || channel.state.modal.code(group::EXACT_STOP) == Some(codes::EXACTSTOP_ON);
    // Where moves are planned ahead, the stop is planned as well.
    if !exact || channel.emitter.has_pace() {
        return path.length / speed;
    }
    let changes = channel.state.place.changes(path.from, path.to);
    let mut acceleration = f64::INFINITY;
    for (axis, change) in channel.state.place.layout.axes.iter().zip(&changes) {
        if *change != 0.0
            && let Some(a) = axis.dynamics.acceleration
        {
            acceleration = acceleration.min(a * path.length / change.abs());
        }
    }
    if acceleration.is_finite() && path.length > 0.0 {
        let ramp = SpeedRamp::alone(path.length, speed, acceleration);
        note_law(channel, |law| law.ramp = Some(ramp));
    }
    stop_to_stop(path.length, speed, acceleration.is_finite().then_some(acceleration))
}
