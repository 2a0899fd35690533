//! Lines of `events.jsonl`, with the fields that the state at an instant needs.
//!
//! *Invariant:* unknown kinds and fields are ignored, so lines of later versions can be read.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};

use counterpoint_event::event::{AxesLaw, FeedUnit, MAX_AXES, Motion, MotionKind, MotionLaw, Position, UnknownLaw};
use counterpoint_event::info::JobAxis;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::driven_speed::{DrivenSpeed, RadiusProgress};
use counterpoint_motion::law::{FeedSchedule, PathLaw, SpeedRamp, SpindleRotation};
use counterpoint_motion::space::SpaceArc;
use counterpoint_motion::surface_speed::SurfaceSpeed;
use counterpoint_motion::thread::Lead;

use crate::geometry::spatial;

/// The fields that every line has.
#[derive(Debug, Deserialize)]
pub(crate) struct EventLine {
    pub(crate) t_ns: i64,
    pub(crate) dur_ns: i64,
    pub(crate) channel: u16,
    pub(crate) kind: String,
    pub(crate) file: String,
    pub(crate) line: u32,
    #[serde(default)]
    caller_file: String,
    #[serde(default)]
    caller_line: u32,
}

impl EventLine {
    /// Whether it belongs to a block of the user's own programs, and not to one of a shipped program.
    pub(crate) fn is_own(&self) -> bool {
        self.caller_line == 0
    }

    /// The innermost place in the programs of the user; `None` if the event belongs to no block.
    pub(crate) fn user_place(&self) -> Option<(&str, u32)> {
        match (self.caller_line, self.line) {
            (0, 0) => None,
            (0, line) => Some((&self.file, line)),
            (line, _) => Some((&self.caller_file, line)),
        }
    }
}

/// Values by axis, in the order of the line.
#[derive(Debug, Default)]
pub(crate) struct ByAxis(pub(crate) Vec<(String, f64)>);

impl<'de> Deserialize<'de> for ByAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Pairs;
        impl<'de> Visitor<'de> for Pairs {
            type Value = ByAxis;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with a number for each axis")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ByAxis, A::Error> {
                let mut pairs = Vec::new();
                while let Some((axis, value)) = map.next_entry::<String, Option<f64>>()? {
                    pairs.push((axis, value.unwrap_or(f64::INFINITY)));
                }
                Ok(ByAxis(pairs))
            }
        }
        deserializer.deserialize_map(Pairs)
    }
}

impl ByAxis {
    /// Values by index of the axis; absent axes are at zero.
    pub(crate) fn position(&self, axes: &[JobAxis]) -> Position {
        let mut position = [0.0; MAX_AXES];
        for (slot, axis) in position.iter_mut().zip(axes) {
            *slot = self.value(&axis.name).unwrap_or(0.0);
        }
        position
    }

    fn value(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(axis, _)| axis == name).map(|(_, value)| *value)
    }
}

/// A motion.
#[derive(Debug, Deserialize)]
pub(crate) struct MotionLine {
    pub(crate) motion: MotionKind,
    from: ByAxis,
    to: ByAxis,
    #[serde(default)]
    center: ByAxis,
    middle: Option<ByAxis>,
    pub(crate) feed: Option<f64>,
    pub(crate) feed_unit: FeedUnit,
    length: Option<f64>,
    #[serde(default)]
    turns: u16,
}

impl MotionLine {
    /// The motion of a channel with these axes.
    pub(crate) fn motion(&self, axes: &[JobAxis]) -> Motion {
        let (from, to) = (self.from.position(axes), self.to.position(axes));
        let feed = (self.feed.unwrap_or(0.0), self.feed_unit);
        let mut motion = Motion::straight(self.motion, 0, [from, to], feed, self.length.unwrap_or(0.0));
        motion.turns = self.turns;
        if let Some(middle) = &self.middle {
            let seen = spatial(axes);
            let [from, via, to] = [from, middle.position(axes), to].map(|point| seen.point(&point));
            if let Ok(arc) = SpaceArc::through(from, via, to) {
                motion.center = arc.bulge(from, to);
            }
            return motion;
        }
        let plane = motion.plane_axes.iter_mut().zip(&mut motion.center);
        for ((axis, slot), (name, value)) in plane.zip(&self.center.0) {
            let index = axes.iter().position(|axis| axis.name == *name);
            *axis = index.and_then(|index| u8::try_from(index).ok()).unwrap_or(u8::MAX);
            *slot = *value;
        }
        motion
    }
}

/// A law. Infinite numbers are `null`.
#[derive(Debug, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case")]
pub(crate) enum LawLine {
    Axes { arrives: ByAxis, ramps: ByAxis },
    Path { ramp: Option<RampLine>, turning: Option<TurningLine>, surface_arc: Option<ArcLine> },
    Unknown { reason: UnknownLaw },
}

#[derive(Debug, Deserialize)]
pub(crate) struct RampLine {
    entry: f64,
    top: f64,
    exit: f64,
    acceleration: Option<f64>,
    length: f64,
}

#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct SurfaceLine {
    speed: f64,
    max: Option<f64>,
    min: f64,
}

impl SurfaceLine {
    fn speed(self) -> SurfaceSpeed {
        SurfaceSpeed { surface: self.speed, max: self.max.unwrap_or(f64::INFINITY), min: self.min }
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct DriverLine {
    minutes: f64,
    elapsed: f64,
    start_radius: f64,
    end_radius: f64,
    by_revolution: bool,
}

#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct TurningLine {
    lead: f64,
    lead_change: f64,
    way: f64,
    start_radius: f64,
    end_radius: f64,
    rpm: f64,
    surface: Option<SurfaceLine>,
    driver: Option<DriverLine>,
}

impl TurningLine {
    fn schedule(self) -> FeedSchedule {
        let spindle = match (self.surface, self.driver) {
            (None, _) => SpindleRotation::Fixed(self.rpm),
            (Some(surface), None) => SpindleRotation::Surface(surface.speed()),
            (Some(surface), Some(driver)) => {
                let progress = if driver.by_revolution { RadiusProgress::ByRevolution } else { RadiusProgress::ByTime };
                let radii = [driver.start_radius, driver.end_radius];
                let driven = DrivenSpeed { speed: surface.speed(), radii, minutes: driver.minutes, progress };
                SpindleRotation::Driven(driven, driver.elapsed)
            }
        };
        let lead = Lead { start: self.lead, change: self.lead_change };
        FeedSchedule::Turning { lead, way: self.way, radii: [self.start_radius, self.end_radius], spindle }
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
pub(crate) struct ArcLine {
    center: f64,
    radius: f64,
    start: f64,
    sweep: f64,
    radial: u8,
    surface: Option<SurfaceLine>,
}

impl ArcLine {
    fn schedule(self) -> Option<FeedSchedule> {
        let arc =
            PlaneArc { center: [self.center; 2], radius: self.radius, start_angle: self.start, sweep: self.sweep };
        Some(FeedSchedule::SurfaceArc { arc, radial: usize::from(self.radial == 1), speed: self.surface?.speed() })
    }
}

impl LawLine {
    /// The law of a motion of a channel with these axes.
    pub(crate) fn law(&self, axes: &[JobAxis]) -> MotionLaw {
        match self {
            Self::Axes { arrives, ramps } => {
                MotionLaw::Axes(AxesLaw { arrives: arrives.position(axes), ramps: ramps.position(axes) })
            }
            Self::Path { ramp, turning, surface_arc } => {
                let ramp = ramp.as_ref().map(|ramp| SpeedRamp {
                    length: ramp.length,
                    entry: ramp.entry,
                    top: ramp.top,
                    exit: ramp.exit,
                    acceleration: ramp.acceleration.unwrap_or(f64::INFINITY),
                });
                let turning = turning.map(TurningLine::schedule);
                let schedule = turning.or_else(|| surface_arc.and_then(ArcLine::schedule));
                MotionLaw::Path(PathLaw { ramp, schedule: schedule.unwrap_or(FeedSchedule::Steady) })
            }
            Self::Unknown { reason } => MotionLaw::Unknown(*reason),
        }
    }
}

/// A change of the work frame: machine position = programmed position + shift.
#[derive(Debug, Deserialize)]
pub(crate) struct FrameLine {
    pub(crate) shift: ByAxis,
}

/// A tool.
#[derive(Debug, Deserialize)]
pub(crate) struct ToolLine {
    pub(crate) action: String,
    pub(crate) tool: u32,
    pub(crate) offset: u32,
}

/// A modal state in words, and the axis that a coupling has moved.
#[derive(Debug, Deserialize)]
pub(crate) struct ModeLine {
    pub(crate) text: String,
    pub(crate) carried: Option<CarriedLine>,
}

/// The place of the channel after another one has moved an axis.
#[derive(Debug, Deserialize)]
pub(crate) struct CarriedLine {
    pub(crate) to: ByAxis,
}

/// A wait.
#[derive(Debug, Deserialize)]
pub(crate) struct WaitLine {
    pub(crate) key: String,
    pub(crate) participants: Vec<u16>,
}

/// A phase.
#[derive(Debug, Deserialize)]
pub(crate) struct PhaseLine {
    pub(crate) phase: String,
}

/// A subprogram.
#[derive(Debug, Deserialize)]
pub(crate) struct LevelLine {
    pub(crate) level: u16,
}
