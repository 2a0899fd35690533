//! A path as data: its blocks, its state between blocks, and the block at work.
//!
//! *Invariant:* positions are in units of the program.

use counterpoint_control_api::contour::{PathShape, Point};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault::Halt;

use super::words::EvaluatedWord;

/// Letters of the axes.
pub(super) const AXES: [&str; 9] = ["X", "Y", "Z", "A", "B", "C", "U", "V", "W"];

/// A feed above the rates of all axes.
pub(super) const FASTEST: f64 = 99_999.0;

/// A position by axis.
pub(super) type Position = [f64; AXES.len()];

/// Kind of a path block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PathBlockKind {
    Line,
    /// A line with a direction of the tool and a normal of the surface.
    Space,
    Arc,
    Radius,
    Tangent,
    PolarLine,
    PolarArc,
    PolarTangent,
    Pole,
    Chamfer,
    Round,
    Approach(PathShape),
    Depart(PathShape),
    /// The pole of free contours.
    FreePole,
    /// The solution of free contours.
    FreeSelect,
    /// Elements of free contours.
    FreeLine {
        tangent: bool,
    },
    FreeArc {
        tangent: bool,
    },
    /// As G words say, or the last of them.
    Iso,
}

impl PathBlockKind {
    /// Key words of the shapes.
    pub(super) const WORDS: [(&'static str, Self); 30] = [
        ("L", Self::Line),
        ("LN", Self::Space),
        ("C", Self::Arc),
        ("CR", Self::Radius),
        ("CT", Self::Tangent),
        ("LP", Self::PolarLine),
        ("CP", Self::PolarArc),
        ("CTP", Self::PolarTangent),
        ("CC", Self::Pole),
        ("CHF", Self::Chamfer),
        ("RND", Self::Round),
        ("APPR LT", Self::Approach(PathShape::Straight)),
        ("APPR LN", Self::Approach(PathShape::Normal)),
        ("APPR CT", Self::Approach(PathShape::Circle)),
        ("APPR LCT", Self::Approach(PathShape::LineAndCircle)),
        ("APPR PLT", Self::Approach(PathShape::Straight)),
        ("APPR PLN", Self::Approach(PathShape::Normal)),
        ("APPR PCT", Self::Approach(PathShape::Circle)),
        ("APPR PLCT", Self::Approach(PathShape::LineAndCircle)),
        ("DEP LT", Self::Depart(PathShape::Straight)),
        ("DEP LN", Self::Depart(PathShape::Normal)),
        ("DEP CT", Self::Depart(PathShape::Circle)),
        ("DEP LCT", Self::Depart(PathShape::LineAndCircle)),
        ("DEP PLCT", Self::Depart(PathShape::LineAndCircle)),
        ("FPOL", Self::FreePole),
        ("FSELECT", Self::FreeSelect),
        ("FL", Self::FreeLine { tangent: false }),
        ("FLT", Self::FreeLine { tangent: true }),
        ("FC", Self::FreeArc { tangent: false }),
        ("FCT", Self::FreeArc { tangent: true }),
    ];

    /// Whether this is a circle in one of its forms.
    pub(super) fn is_arc(self) -> bool {
        matches!(
            self,
            Self::Arc | Self::Radius | Self::Tangent | Self::PolarArc | Self::PolarTangent | Self::FreeArc { .. }
        )
    }

    /// An element of a free contour.
    pub(super) fn is_free(self) -> bool {
        matches!(self, Self::FreeLine { .. } | Self::FreeArc { .. })
    }

    /// Key word of the block, where one begins it.
    pub(super) fn head(self) -> &'static str {
        match self {
            Self::Iso => "",
            shape => Self::WORDS.iter().find(|(_, known)| *known == shape).map_or("", |(word, _)| word),
        }
    }
}

/// Axis of a word, and whether it counts from where the program is.
pub(super) fn axis(name: &str) -> Option<(usize, bool)> {
    let (letter, incremental) = match name.strip_prefix('I') {
        Some(letter) if !letter.is_empty() => (letter, true),
        _ => (name, false),
    };
    Some((AXES.iter().position(|axis| *axis == letter)?, incremental))
}

/// A path block with its values.
#[derive(Debug, Clone)]
pub(super) struct PathBlock {
    pub(super) shape: PathBlockKind,
    pub(super) iso: bool,
    pub(super) seen: Vec<EvaluatedWord>,
    /// Line that it is in.
    pub(super) line: u32,
    /// Number of its block.
    pub(super) number: Option<u32>,
    /// Meaning of FMAX in a circle.
    pub(super) rapid: Option<EvaluatedWord>,
}

/// A corner that the block before has made room for.
#[derive(Debug, Clone, Copy)]
pub(super) struct PendingCorner {
    /// Line of the block that makes it.
    pub(super) line: u32,
    pub(super) to: Point,
    /// Direction of the element after it.
    pub(super) heading: Point,
    /// Radius, none for a chamfer.
    pub(super) radius: Option<f64>,
    pub(super) clockwise: bool,
}

/// Radius compensation.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RadiusCompensation {
    /// The tool goes left of the contour.
    pub(super) is_left: Option<bool>,
    /// The next straight line ends it.
    pub(super) ends: bool,
}

/// Data of the path.
#[derive(Debug, Clone)]
pub(super) struct PathState {
    /// Axes of the working plane.
    pub(super) plane: [usize; 2],
    pub(super) poles: Poles,
    /// Direction at the end of the last element.
    pub(super) heading: Option<Point>,
    pub(super) clockwise: Option<bool>,
    /// Programmed point, where a corner has led the tool elsewhere.
    pub(super) base: Option<Position>,
    pub(super) corner: Option<PendingCorner>,
    /// Motion word of ISO programs.
    pub(super) mode: Option<u32>,
    /// The next block without a motion word has to say it again.
    pub(super) restate: bool,
    /// G91.
    pub(super) increments: bool,
    pub(super) side: RadiusCompensation,
    pub(super) free: FreeContour,
    pub(super) rates: ProgrammedFeeds,
    /// The last element was an arc.
    pub(super) round: bool,
}

impl Default for PathState {
    fn default() -> Self {
        Self {
            plane: [0, 1],
            poles: Poles::default(),
            heading: None,
            clockwise: None,
            base: None,
            corner: None,
            mode: None,
            restate: false,
            increments: false,
            side: RadiusCompensation::default(),
            free: FreeContour::default(),
            rates: ProgrammedFeeds::default(),
            round: false,
        }
    }
}

/// A path block at work.
pub(super) struct PathBuilder<'a> {
    pub(super) path: &'a mut PathState,
    pub(super) host: &'a mut dyn InterpreterHost,
    pub(super) step: &'a PathBlock,
    /// Path blocks that follow.
    pub(super) ahead: &'a [PathBlock],
    /// Where the tool is, and where the program is.
    pub(super) actual: Position,
    pub(super) start: Position,
    /// The block cannot be made.
    pub(super) refused: Option<Halt>,
}

/// Where the tool is, in units of the program.
pub(super) fn actual(host: &dyn InterpreterHost) -> Position {
    let mut out = Position::default();
    let factor = host.length_factor();
    for (name, position, _) in host.positions() {
        let letter = name.trim_end_matches(|c: char| c.is_ascii_digit());
        if let Some(at) = AXES.iter().position(|axis| *axis == letter)
            && let Some(slot) = out.get_mut(at)
        {
            *slot = if matches!(at, 3..=5) { position } else { position / factor };
        }
    }
    out
}

/// Centres of circles that blocks have defined.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Poles {
    /// In the working plane.
    pub(super) flat: Option<Point>,
    /// The last one, where it is in another plane: its axes, and where it is along them.
    pub(super) upright: Option<([usize; 2], Point)>,
}

/// Data of free contours besides the path.
#[derive(Debug, Clone, Default)]
pub(super) struct FreeContour {
    pub(super) pole: Option<Point>,
    /// Where the contour of CLSD+ begins.
    pub(super) begins: Option<Point>,
    /// Elements with the number of their block: end, direction there.
    pub(super) known: Vec<(u32, Point, Option<Point>)>,
    /// FSELECT entries: the number of elements that FSELECT follows after the current one, its number and its line.
    pub(super) selects: Vec<(usize, usize, u32)>,
    /// Lines of those that have selected something.
    pub(super) decided: Vec<u32>,
    /// The end of the current element.
    pub(super) end: Option<Point>,
}

/// A value of a step.
pub(super) fn of_step(step: &PathBlock, name: &str) -> Option<f64> {
    step.seen.iter().find(|word| word.is(name) && !word.is_off()).and_then(|word| word.value)
}

/// The direction of rotation of a step.
pub(super) fn sense_of(step: &PathBlock) -> Option<bool> {
    step.seen.iter().find(|word| word.is("DR") && word.value.is_none()).map(|word| word.turns() == Some(true))
}

/// Feeds that a program has given.
#[derive(Debug, Clone, Default)]
pub(super) struct ProgrammedFeeds {
    /// The last one, as written.
    pub(super) last: Option<EvaluatedWord>,
    /// That of TOOL CALL.
    pub(super) of_tool: Option<EvaluatedWord>,
    /// A corner had a feed of its own.
    pub(super) gives_back: bool,
    /// The block before was at rapid.
    pub(super) rapid_before: bool,
}

/// Angle of a tangential line after an arc.
pub(super) fn exit_angle(step: &PathBlock) -> Option<f64> {
    let own = step.seen.iter().find(|word| word.is("AN")).and_then(|word| word.value);
    own.filter(|_| step.shape == PathBlockKind::FreeLine { tangent: true })
}
