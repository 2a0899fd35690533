//! Contours of SL cycles as data.

use counterpoint_event::FileId;
use counterpoint_motion::contour::closed::ClosedContour;
use counterpoint_motion::contour::element::Element;

use super::path_state::PathState;
use super::statement::Label;
use super::words::EvaluatedWord;

/// A contour that has been read.
#[derive(Debug, Clone)]
pub(super) struct SlContour {
    pub(super) elements: Vec<Element>,
    /// The tool goes left of it.
    pub(super) is_left: Option<bool>,
}

/// A pocket or an island.
#[derive(Debug, Clone)]
pub(super) struct AreaBoundary {
    pub(super) outline: ClosedContour,
    pub(super) is_pocket: bool,
}

/// Place of a contour.
#[derive(Debug, Clone)]
pub(super) enum ContourSource {
    Label(FileId, Label),
    Program(String),
}

/// A subprogram that is a contour.
#[derive(Debug, Clone)]
pub(super) struct ContourSubprogram {
    pub(super) source: ContourSource,
    /// Pocket or island by CONTOUR DEF; in cycle 14 the side of the contour decides.
    pub(super) is_pocket: Option<bool>,
    /// DEPTH: that of a pocket, or how far an island lies below the surface.
    pub(super) depth: Option<f64>,
}

/// The contours of cycle 14 or CONTOUR DEF.
#[derive(Debug, Default)]
pub(super) struct Contours {
    pub(super) labels: Vec<ContourSubprogram>,
    /// Combination of the contours by SEL CONTOUR.
    pub(super) formula: Option<AreaExpression>,
    /// Overlapping pockets become their intersection if the first starts in the second.
    pub(super) by_start: bool,
    /// Cycle 270 says how a train begins and ends.
    pub(super) train: bool,
    /// They lie on a cylinder.
    pub(super) unrolled: Option<Unrolled>,
    pub(super) read: Vec<SlContour>,
    /// While a contour is recorded: the path before it.
    pub(super) before: Option<Box<PathState>>,
}

impl Contours {
    /// Those that a formula joins.
    pub(super) fn joined(labels: Vec<ContourSubprogram>, formula: AreaExpression) -> Self {
        Self { labels, formula: Some(formula), ..Self::default() }
    }

    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        self.read.iter().map(|contour| contour.elements.len() * size_of::<Element>()).sum::<usize>()
            + self.labels.len() * 60
            + self.formula.as_ref().map_or(0, AreaExpression::size) * 60
    }

    /// Words of a contour that is being read, as it is unrolled from a cylinder.
    pub(super) fn unroll(&mut self, seen: &mut [EvaluatedWord]) {
        if let Some(unrolled) = self.unrolled.as_mut().filter(|_| self.before.is_some()) {
            unrolled.words(seen);
        }
    }

    /// DEPTH of a contour.
    pub(super) fn depth(&self, at: usize) -> Option<f64> {
        self.labels.get(at)?.depth
    }
}

/// How two areas make one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Join {
    Common,
    Union,
    Either,
    Without,
}

/// Composition of an area; contours by their places.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AreaExpression {
    Contour(usize),
    Outside(Box<AreaExpression>),
    Of(Join, Box<AreaExpression>, Box<AreaExpression>),
}

impl AreaExpression {
    /// Whether a spot lies in it that is held by these contours.
    pub(super) fn holds(&self, held: &[bool]) -> bool {
        match self {
            Self::Contour(at) => held.get(*at).copied().unwrap_or(false),
            Self::Outside(area) => !area.holds(held),
            Self::Of(join, one, other) => {
                let (one, other) = (one.holds(held), other.holds(held));
                match join {
                    Join::Common => one && other,
                    Join::Union => one || other,
                    Join::Either => one != other,
                    Join::Without => one && !other,
                }
            }
        }
    }

    /// Contours whose points may be outside of it.
    pub(super) fn taken_away(&self) -> Vec<usize> {
        match self {
            Self::Contour(_) => Vec::new(),
            Self::Outside(area) => area.contours(),
            Self::Of(Join::Either, one, other) => [one.contours(), other.contours()].concat(),
            Self::Of(Join::Without, one, other) => [one.taken_away(), other.contours()].concat(),
            Self::Of(Join::Common | Join::Union, one, other) => [one.taken_away(), other.taken_away()].concat(),
        }
    }

    fn contours(&self) -> Vec<usize> {
        match self {
            Self::Contour(at) => vec![*at],
            Self::Outside(area) => area.contours(),
            Self::Of(_, one, other) => [one.contours(), other.contours()].concat(),
        }
    }

    /// Contours and joins of it.
    pub(super) fn size(&self) -> usize {
        match self {
            Self::Contour(_) => 1,
            Self::Outside(area) => 1 + area.size(),
            Self::Of(_, one, other) => 1 + one.size() + other.size(),
        }
    }

    pub(super) fn joined(self, join: Join, other: Self) -> Self {
        Self::Of(join, Box::new(self), Box::new(other))
    }
}

/// An area down to a level, above which it is that of the stage before; the level as a depth below the surface, none
/// for that of the cycle.
pub(super) struct AreaStage {
    pub(super) depth: Option<f64>,
    pub(super) figures: Vec<AreaBoundary>,
}

/// How the contour of a cylinder is read, and where its axes lie.
#[derive(Debug, Clone)]
pub(super) struct Unrolled {
    /// Letter of the rotary axis.
    pub(super) rotary: &'static str,
    /// Letters of the axes along the cylinder and across it.
    pub(super) along: &'static str,
    pub(super) across: &'static str,
    /// Sense of the axis along the cylinder against that of the rotary axis.
    pub(super) sense: f64,
    /// Sense of the axis across, as the tool goes around.
    pub(super) round: f64,
    /// Units of the program for a unit of X: more than 1 where X is in degrees.
    pub(super) scale: f64,
    /// Whether the contour names the rotary axis, as old programs do; its first block decides.
    pub(super) by_name: Option<bool>,
}

impl Unrolled {
    /// Words of a contour as they are unrolled: X is the way round, Y lies along the axis.
    pub(super) fn words(&mut self, seen: &mut [EvaluatedWord]) {
        let bare = |name: &str| name.strip_prefix('I').filter(|rest| !rest.is_empty()).unwrap_or(name).to_owned();
        let is = |word: &EvaluatedWord, letter: &str| word.value.is_some() && bare(&word.name) == letter;
        if self.by_name.is_none() && seen.iter().any(|word| is(word, "X") || is(word, "Y") || is(word, self.rotary)) {
            self.by_name = Some(seen.iter().any(|word| is(word, self.rotary)));
        }
        for word in seen {
            let Some(mut value) = word.value else { continue };
            let mut name = word.name.to_string();
            if self.by_name == Some(true) {
                let to = if is(word, self.rotary) {
                    "X"
                } else if is(word, self.along) {
                    "Y"
                } else {
                    ""
                };
                if !to.is_empty() {
                    name = if name.len() > 1 { format!("I{to}") } else { to.to_owned() };
                }
            }
            if matches!(&*name, "X" | "IX" | "CCX" | "ICCX" | "P1X" | "P2X" | "P3X" | "PDX") {
                value *= self.scale;
            }
            if name != *word.name || Some(value) != word.value {
                *word = EvaluatedWord::made(&name, value);
            }
        }
    }
}
