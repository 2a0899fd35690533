//! The law of the next move of a channel, as far as the feed determines the law.
//!
//! The action that times a move notes the progress of the feed; the kernel takes the note when it makes the move.
//! *Invariant:* a job that records no laws has no draft, and pays one test for each move.

use counterpoint_event::event::{AxesLaw, Kind, Motion, MotionKind, MotionLaw, UnknownLaw};
use counterpoint_machine::model::RapidPath;
use counterpoint_motion::law::{AxisRamp, FeedSchedule, PathLaw, SpeedRamp};

use crate::ChannelMemory;
use crate::channel_axis::ChannelAxis;
use crate::channel_context::ChannelContext;
use crate::position::MotionState;

/// The progress of the feed in the next move.
#[derive(Debug)]
pub struct LawDraft {
    /// Progress along the path.
    pub schedule: FeedSchedule,
    /// Acceleration and deceleration at the ends, if the look-ahead does not plan them.
    pub ramp: Option<SpeedRamp>,
    /// Why the positions between the ends are not known.
    pub unknown: Option<UnknownLaw>,
}

impl Default for LawDraft {
    fn default() -> Self {
        Self { schedule: FeedSchedule::Steady, ramp: None, unknown: None }
    }
}

/// Notes the progress of the feed in the next move.
#[inline(always)]
pub fn note_law(channel: &mut ChannelContext<'_>, note: impl FnOnce(&mut LawDraft)) {
    if let Some(draft) = &mut channel.state.law {
        note(draft);
    }
}

/// Logs the law of a move that has just been logged, with its duration in ns, if the job records laws.
#[inline(always)]
pub fn log_law(channel: &mut ChannelContext<'_>, ns: i64, motion: &Motion) {
    if channel.state.law.is_some() {
        log_taken_law(channel, ns, motion);
    }
}

#[cold]
#[inline(never)]
fn log_taken_law(channel: &mut ChannelContext<'_>, ns: i64, motion: &Motion) {
    if let Some(law) = take_law(&mut channel.state, channel.env.machine.time.rapid, motion).filter(|_| ns > 0) {
        channel.emitter.emit(&channel.at, ns, Kind::Law(law));
    }
}

/// The law of this move; `None` if the job records no laws.
#[inline(always)]
pub fn take_law(state: &mut ChannelMemory, rapid: RapidPath, motion: &Motion) -> Option<MotionLaw> {
    if state.law.is_none() { None } else { drafted_law(state, rapid, motion) }
}

#[cold]
fn drafted_law(state: &mut ChannelMemory, rapid: RapidPath, motion: &Motion) -> Option<MotionLaw> {
    let LawDraft { schedule, ramp, unknown } = std::mem::take(state.law.as_deref_mut()?);
    if state.place.polar().is_some() {
        return Some(MotionLaw::Unknown(UnknownLaw::Polar));
    }
    if state.place.tip().is_some() {
        return Some(MotionLaw::Unknown(UnknownLaw::ToolTip));
    }
    if motion.kind == MotionKind::Rapid {
        return Some(rapid_law(&state.place, rapid, motion));
    }
    Some(unknown.map_or(MotionLaw::Path(PathLaw { ramp, schedule }), MotionLaw::Unknown))
}

fn rapid_law(place: &MotionState, rapid: RapidPath, motion: &Motion) -> MotionLaw {
    let changes = place.changes(&motion.from, &motion.to);
    let axes = || place.layout.axes.iter().zip(&changes);
    if axes().any(|(axis, change)| *change != 0.0 && axis.dynamics.jerk.is_some()) {
        return MotionLaw::Unknown(UnknownLaw::Jerk);
    }
    if place.couples() {
        return MotionLaw::Unknown(UnknownLaw::Frame);
    }
    let acceleration = |axis: &ChannelAxis| axis.dynamics.acceleration.unwrap_or(f64::INFINITY);
    match rapid {
        RapidPath::SlowestAxis => MotionLaw::Axes(AxesLaw::new(
            axes().map(|(axis, change)| AxisRamp::new(*change, axis.rapid, acceleration(axis))),
        )),
        RapidPath::Linear => {
            let length = changes.iter().map(|change| change * change).sum::<f64>().sqrt();
            let (mut speed, mut limit) = (f64::INFINITY, f64::INFINITY);
            for (axis, change) in axes().filter(|(_, change)| **change != 0.0) {
                let share = length / change.abs();
                speed = speed.min(axis.rapid * share);
                limit = limit.min(acceleration(axis) * share);
            }
            let ramp = (length > 0.0 && limit.is_finite()).then(|| SpeedRamp::alone(length, speed, limit));
            MotionLaw::Path(PathLaw { ramp, schedule: FeedSchedule::Steady })
        }
    }
}
