//! Motions: the kind of events that a log has most of.

use super::Position;
use super::declare::words;
use super::fields::{EventField, EventRecord, EventValue, FieldReader, FieldType, FieldWriter, position};
use super::work::WorkClass;

words! {
    /// How the tool moves.
    pub enum MotionKind {
        /// Positioning.
        Rapid = 1 "rapid",
        /// Straight feed.
        Linear = 2 "linear",
        /// Circle, clockwise seen along the negative normal of the plane.
        ArcCw = 3 "arc_cw",
        /// Circle, counter-clockwise.
        ArcCcw = 4 "arc_ccw",
        /// Thread cut: feed locked to the spindle.
        Thread = 5 "thread",
        /// Circle in space.
        ArcSpace = 6 "arc_space",
    }
}

words! {
    /// The meaning of a feed value.
    pub enum FeedUnit {
        /// Machine units per minute.
        PerMinute = 1 "per_minute",
        /// Machine units per revolution of the spindle.
        PerRevolution = 2 "per_revolution",
        /// Inverse time: one over minutes for the block.
        InverseTime = 3 "inverse_time",
        /// No feed: rapid traverse.
        Rapid = 4 "rapid",
    }
}

/// One motion in the work frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Rapid, linear, arc or thread.
    pub kind: MotionKind,
    /// Bit `i` set: axis `i` of the channel was coded in the block or moves.
    pub moving: u8,
    /// Start position.
    pub from: Position,
    /// End position.
    pub to: Position,
    /// Arc centre by the two plane axes of `plane_axes`, in programmed units (radius values are given as
    /// diameters on a diameter axis); of a circle in space where its middle is over the chord, as
    /// `counterpoint_motion::space::Circle::bulge` gives it by radius values of X, Y and Z. A linear move with
    /// `plane_axes` is an arc on the face of the part by polar interpolation: its centre, in radius values along X at
    /// C0 and at right angles to it. Unused otherwise.
    pub center: [f64; 2],
    /// Axis indices (channel order) of the first and second axis of the arc's plane, or of the linear and the rotary axis
    /// of polar interpolation; 255 = none.
    pub plane_axes: [u8; 2],
    /// Full turns in addition to the arc from start to end.
    pub turns: u16,
    /// Feed in `feed_unit`; thread: lead in machine units per revolution; 0 for rapid.
    pub feed: f64,
    /// Unit of `feed`.
    pub feed_unit: FeedUnit,
    /// Length of the tool path in machine units (rotary axes do not count unless nothing else moves).
    pub length: f64,
}

impl Motion {
    /// Whether it starts where another one ended: the same numbers bit by bit, which asks less than a comparison of
    /// numbers.
    #[must_use]
    #[inline(always)]
    pub fn starts_at(&self, end: &Position) -> bool {
        let differing = |(a, b): (&f64, &f64)| a.to_bits() ^ b.to_bits();
        self.from.iter().zip(end).map(differing).fold(0, |all, bits| all | bits) == 0
    }

    /// A move along a straight line in the axes' space.
    #[must_use]
    pub fn straight(
        kind: MotionKind,
        moving: u8,
        [from, to]: [Position; 2],
        (feed, feed_unit): (f64, FeedUnit),
        length: f64,
    ) -> Self {
        let (center, plane_axes, turns) = ([0.0; 2], [255; 2], 0);
        Self { kind, moving, from, to, center, plane_axes, turns, feed, feed_unit, length }
    }
}

/// The axes of no plane.
const NO_PLANE: [u8; 2] = [255; 2];

impl EventRecord for Motion {
    #[inline]
    fn fields(&self, out: &mut impl FieldWriter) {
        self.kind.put(EventField::new(1, "motion"), out);
        self.moving.put(EventField::wire(2), out);
        out.put(EventField::new(3, "from"), EventValue::Position(&self.from));
        out.put(EventField::new(4, "to"), EventValue::Position(&self.to));
        out.put(EventField::shown("center"), EventValue::Center);
        if self.plane_axes != NO_PLANE || self.center.iter().any(|value| value.to_bits() != 0) {
            out.put(EventField::wire(5), EventValue::Pair(&self.center));
            out.put(EventField::wire(6), EventValue::Axes(&self.plane_axes));
        }
        self.turns.put(EventField::wire(7), out);
        self.feed.put(EventField::new(8, "feed"), out);
        self.feed_unit.put(EventField::new(9, "feed_unit"), out);
        self.length.put(EventField::new(10, "length"), out);
        self.turns.put(EventField::shown("turns").optional(), out);
    }

    fn read(from: &impl FieldReader) -> Option<Self> {
        let mut center = [0.0; 2];
        from.floats(5, &mut center);
        let mut plane_axes = NO_PLANE;
        plane_axes.iter_mut().zip(from.numbers(6)).for_each(|(slot, axis)| *slot = axis as u8);
        Some(Self {
            kind: FieldType::get(1, from)?,
            moving: FieldType::get(2, from)?,
            from: position(3, from),
            to: position(4, from),
            center,
            plane_axes,
            turns: FieldType::get(7, from)?,
            feed: FieldType::get(8, from)?,
            feed_unit: FieldType::get(9, from)?,
            length: FieldType::get(10, from)?,
        })
    }

    #[inline]
    fn work(&self) -> Option<WorkClass> {
        Some(if self.kind == MotionKind::Rapid { WorkClass::Rapid } else { WorkClass::Feed })
    }
}
