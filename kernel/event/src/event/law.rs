//! The law of a motion: its position at each instant between its ends.
//!
//! A law follows its motion in the stream of the channel, with the same start and duration. Jobs record laws on
//! request. The fingerprint of a log is the same with or without laws. *Invariant:* a law needs no data of the machine;
//! its planned time is scaled to the duration of the motion.

use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::driven_speed::{DrivenSpeed, RadiusProgress};
use counterpoint_motion::law::{AxisRamp, FeedSchedule, PathLaw, SpeedRamp, SpindleRotation};
use counterpoint_motion::surface_speed::SurfaceSpeed;
use counterpoint_motion::thread::Lead;

use super::declare::{record, words};
use super::fields::{EventField, EventRecord, EventValue, FieldReader, FieldType, FieldWriter, position};
use super::{MAX_AXES, Position};

words! {
    /// The form of a law.
    pub enum LawForm {
        /// Each axis moves at its own rate and holds its position after its arrival.
        Axes = 1 "axes",
        /// All axes move together along the path.
        Path = 2 "path",
        /// Only the ends are known.
        Unknown = 3 "unknown",
    }
}

words! {
    /// Why the positions between the ends of a motion are not known.
    pub enum UnknownLaw {
        /// The acceleration changes gradually.
        Jerk = 1 "jerk",
        /// The motion has no usable feed and is timed as rapid.
        WithoutFeed = 2 "without_feed",
        /// Polar or cylindrical interpolation moves the axes.
        Polar = 3 "polar",
        /// Rotary axes move under tool centre point control.
        ToolTip = 4 "tool_tip",
        /// The frame is rotated, so the axes of the motion are not those of the machine.
        Frame = 5 "frame",
    }
}

/// The progress of a motion between its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionLaw {
    /// Each axis moves at its own rate.
    Axes(AxesLaw),
    /// All axes move together along the path.
    Path(PathLaw),
    /// Only the ends are known.
    Unknown(UnknownLaw),
}

/// Axes that move at their own rates, by axis of the channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxesLaw {
    /// Seconds until the arrival of the axis; 0: the axis does not move.
    pub arrives: Position,
    /// Seconds of its acceleration and of its deceleration.
    pub ramps: Position,
}

impl AxesLaw {
    /// The law of these axes.
    #[must_use]
    pub fn new(axes: impl Iterator<Item = AxisRamp>) -> Self {
        let mut law = Self { arrives: [0.0; MAX_AXES], ramps: [0.0; MAX_AXES] };
        for ((axis, arrives), ramp) in axes.zip(&mut law.arrives).zip(&mut law.ramps) {
            (*arrives, *ramp) = (axis.arrives, axis.ramp);
        }
        law
    }

    /// The axes, in the order of the channel.
    pub fn axes(&self) -> impl Iterator<Item = AxisRamp> {
        self.arrives.iter().zip(&self.ramps).map(|(arrives, ramp)| AxisRamp { arrives: *arrives, ramp: *ramp })
    }
}

record! {
    /// The speed along a path with limited acceleration. Geometry units, seconds.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LawRamp {
        /// Speed at the start.
        pub entry: f64 = 1,
        /// Highest speed.
        pub top: f64 = 2,
        /// Speed at the end.
        pub exit: f64 = 3,
        /// Acceleration and deceleration; infinite: speeds change at once.
        pub acceleration: f64 = 4,
        /// Length of the path.
        pub length: f64 = 5,
    }
}

record! {
    /// A surface speed and the limits of the spindle.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LawSurface {
        /// Length units per minute.
        pub speed: f64 = 1,
        /// Highest rev/min; infinite without a limit.
        pub max: f64 = 2,
        /// Lowest rev/min.
        pub min: f64 = 3,
    }
}

record! {
    /// A move of another channel whose radius determines the spindle speed.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LawDriver {
        /// Duration of that move, minutes.
        pub minutes: f64 = 1,
        /// Minutes from the start of that move to the start of this motion.
        pub elapsed: f64 = 2,
        /// Radius at the start of that move.
        pub start_radius: f64 = 3,
        /// Radius at the end of that move.
        pub end_radius: f64 = 4,
        /// The radius changes with revolutions; otherwise with time.
        pub by_revolution: bool = 5,
    }
}

record! {
    /// A feed by revolutions of a spindle, along a path on which the radius changes evenly.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LawTurning {
        /// Feed per revolution, or the lead of a thread at its start.
        pub lead: f64 = 1,
        /// Change of the lead with each revolution.
        pub lead_change: f64 = 2,
        /// Length along which the lead is measured.
        pub way: f64 = 3,
        /// Radius of the part at the start.
        pub start_radius: f64 = 4,
        /// Radius of the part at the end.
        pub end_radius: f64 = 5,
        /// Constant rev/min; 0: the spindle follows a surface speed.
        pub rpm: f64 = 6,
        /// The surface speed.
        pub surface: Option<LawSurface> = 7 [optional],
        /// The move that drives the spindle; `None`: this motion drives it.
        pub driver: Option<LawDriver> = 8 [optional],
    }
}

record! {
    /// A feed by revolutions under constant surface speed along an arc.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LawArc {
        /// Radial coordinate of the centre.
        pub center: f64 = 1,
        /// Radius of the arc.
        pub radius: f64 = 2,
        /// Angle at the start of the arc, radians.
        pub start: f64 = 3,
        /// Sweep angle of the arc, radians; negative: clockwise.
        pub sweep: f64 = 4,
        /// The radial axis of the plane: 0 the first, 1 the second.
        pub radial: u8 = 5,
        /// The surface speed.
        pub surface: Option<LawSurface> = 6 [optional],
    }
}

fn surface_fields(speed: &SurfaceSpeed) -> Option<LawSurface> {
    Some(LawSurface { speed: speed.surface, max: speed.max, min: speed.min })
}

fn surface(fields: Option<LawSurface>) -> Option<SurfaceSpeed> {
    fields.map(|LawSurface { speed, max, min }| SurfaceSpeed { surface: speed, max, min })
}

fn turning_fields(schedule: &FeedSchedule) -> Option<LawTurning> {
    let FeedSchedule::Turning { lead, way, radii: [start_radius, end_radius], spindle } = *schedule else {
        return None;
    };
    let (rpm, surface, driver) = match spindle {
        SpindleRotation::Fixed(rpm) => (rpm, None, None),
        SpindleRotation::Surface(speed) => (0.0, surface_fields(&speed), None),
        SpindleRotation::Driven(driven, elapsed) => {
            let DrivenSpeed { speed, radii: [start_radius, end_radius], minutes, progress } = driven;
            let by_revolution = progress == RadiusProgress::ByRevolution;
            let driver = LawDriver { minutes, elapsed, start_radius, end_radius, by_revolution };
            (0.0, surface_fields(&speed), Some(driver))
        }
    };
    let Lead { start, change } = lead;
    Some(LawTurning { lead: start, lead_change: change, way, start_radius, end_radius, rpm, surface, driver })
}

fn turning(fields: LawTurning) -> Option<FeedSchedule> {
    let LawTurning { lead, lead_change, way, start_radius, end_radius, rpm, surface: speed, driver } = fields;
    let spindle = match (surface(speed), driver) {
        (None, _) => SpindleRotation::Fixed(rpm),
        (Some(speed), None) => SpindleRotation::Surface(speed),
        (Some(speed), Some(LawDriver { minutes, elapsed, start_radius, end_radius, by_revolution })) => {
            let progress = if by_revolution { RadiusProgress::ByRevolution } else { RadiusProgress::ByTime };
            SpindleRotation::Driven(
                DrivenSpeed { speed, radii: [start_radius, end_radius], minutes, progress },
                elapsed,
            )
        }
    };
    let lead = Lead { start: lead, change: lead_change };
    Some(FeedSchedule::Turning { lead, way, radii: [start_radius, end_radius], spindle })
}

fn arc_fields(schedule: &FeedSchedule) -> Option<LawArc> {
    let FeedSchedule::SurfaceArc { arc, radial, speed } = schedule else { return None };
    Some(LawArc {
        center: arc.center.get(*radial).copied().unwrap_or(0.0),
        radius: arc.radius,
        start: arc.start_angle,
        sweep: arc.sweep,
        radial: u8::from(*radial == 1),
        surface: surface_fields(speed),
    })
}

fn surface_arc(fields: LawArc) -> Option<FeedSchedule> {
    let LawArc { center, radius, start, sweep, radial, surface: speed } = fields;
    let arc = PlaneArc { center: [center; 2], radius, start_angle: start, sweep };
    Some(FeedSchedule::SurfaceArc { arc, radial: usize::from(radial == 1), speed: surface(speed)? })
}

impl EventRecord for MotionLaw {
    fn fields(&self, out: &mut impl FieldWriter) {
        let form = EventField::new(1, "law");
        match self {
            Self::Axes(axes) => {
                LawForm::Axes.put(form, out);
                out.put(EventField::new(2, "arrives"), EventValue::Position(&axes.arrives));
                out.put(EventField::new(3, "ramps"), EventValue::Position(&axes.ramps));
            }
            Self::Path(PathLaw { ramp, schedule }) => {
                LawForm::Path.put(form, out);
                let ramp = ramp.map(|SpeedRamp { length, entry, top, exit, acceleration }| LawRamp {
                    entry,
                    top,
                    exit,
                    acceleration,
                    length,
                });
                ramp.put(EventField::new(4, "ramp"), out);
                turning_fields(schedule).put(EventField::new(5, "turning"), out);
                arc_fields(schedule).put(EventField::new(6, "surface_arc"), out);
            }
            Self::Unknown(reason) => {
                LawForm::Unknown.put(form, out);
                reason.put(EventField::new(7, "reason"), out);
            }
        }
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        Some(match LawForm::get(1, from)? {
            LawForm::Axes => Self::Axes(AxesLaw { arrives: position(2, from), ramps: position(3, from) }),
            LawForm::Path => {
                let ramp: Option<LawRamp> = FieldType::get(4, from)?;
                let ramp = ramp.map(|LawRamp { entry, top, exit, acceleration, length }| SpeedRamp {
                    length,
                    entry,
                    top,
                    exit,
                    acceleration,
                });
                let (turning_of, arc_of) = (FieldType::get(5, from)?, FieldType::get(6, from)?);
                let schedule = match (turning_of, arc_of) {
                    (Some(fields), _) => turning(fields)?,
                    (None, Some(fields)) => surface_arc(fields)?,
                    (None, None) => FeedSchedule::Steady,
                };
                Self::Path(PathLaw { ramp, schedule })
            }
            LawForm::Unknown => Self::Unknown(FieldType::get(7, from)?),
        })
    }
}
