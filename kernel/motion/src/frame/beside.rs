//! The local frame of axes other than X, Y and Z: rotary and parallel axes have their own scale, mirror and
//! translation.
//!
//! Parts and additive parts act in the order of the frame of X, Y and Z (`local`); a rotation does not change these
//! axes. *Invariant:* the linear map of each axis has an inverse.

use super::local::{FrameError, LocalFramePart};

/// Most axes of a channel.
pub const AXES: usize = 8;

/// Most additive parts.
const MOST: usize = 200;

/// Largest number of a line and of its inverse.
const BOUND: f64 = 1e12;

/// The linear map of one axis: `value · factor + shift`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisMap {
    /// Factor.
    pub factor: f64,
    /// Shift, as the axis is programmed.
    pub shift: f64,
}

/// A line for each axis of the channel.
pub type Lines = [AxisMap; AXES];

/// Lines that change nothing.
pub const SAME: Lines = [AxisMap::SAME; AXES];

impl AxisMap {
    /// The line that changes nothing.
    pub const SAME: Self = Self { factor: 1.0, shift: 0.0 };

    /// A shift.
    #[must_use]
    pub fn shift(shift: f64) -> Self {
        Self { shift, ..Self::SAME }
    }

    /// A factor about a fixed point.
    #[must_use]
    pub fn scale(factor: f64, about: f64) -> Self {
        Self { factor, shift: about - factor * about }
    }

    /// The line of a programmed value.
    #[must_use]
    pub fn to_work(self, programmed: f64) -> f64 {
        programmed * self.factor + self.shift
    }

    /// The inverse.
    #[must_use]
    pub fn to_program(self, work: f64) -> f64 {
        (work - self.shift) / self.factor
    }

    /// This line after another line.
    fn after(self, first: Self) -> Self {
        Self { factor: self.factor * first.factor, shift: self.to_work(first.shift) }
    }

    fn is_sound(self) -> bool {
        let back = [1.0 / self.factor, self.shift / self.factor];
        [self.factor, self.shift].into_iter().chain(back).all(|number| number.abs() <= BOUND)
    }
}

/// The local frame of the axes other than X, Y and Z.
#[derive(Debug, Clone)]
pub struct AuxiliaryFrame {
    /// The part of each kind.
    parts: [Option<Lines>; 4],
    /// Additive parts, oldest first.
    added: Vec<(LocalFramePart, Lines)>,
    /// Switched off by a macro: the parts are kept.
    off: bool,
    /// From the program to the work frame.
    map: Lines,
}

impl Default for AuxiliaryFrame {
    fn default() -> Self {
        Self { parts: [None; 4], added: Vec::new(), off: false, map: SAME }
    }
}

impl AuxiliaryFrame {
    /// Whether nothing is programmed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.iter().all(Option::is_none) && self.added.is_empty()
    }

    /// Programmed and not switched off.
    #[must_use]
    pub fn is_on(&self) -> bool {
        !self.is_empty() && !self.off
    }

    /// From the program to the work frame.
    #[must_use]
    pub fn map(&self) -> &Lines {
        &self.map
    }

    /// The part of a kind.
    #[must_use]
    pub fn part(&self, part: LocalFramePart) -> Option<&Lines> {
        self.parts.get(part as usize)?.as_ref()
    }

    /// All parts of a kind, oldest first.
    pub fn parts(&self, part: LocalFramePart) -> impl Iterator<Item = &Lines> {
        let added = self.added.iter().filter(move |(of, _)| *of == part).map(|(_, lines)| lines);
        self.part(part).into_iter().chain(added)
    }

    /// This frame with another part of a kind, without the additive ones of that kind.
    ///
    /// # Errors
    /// A line would have no way back.
    pub fn with(&self, part: LocalFramePart, lines: Option<Lines>) -> Result<Self, FrameError> {
        let mut changed = self.clone();
        changed.added.retain(|(of, _)| *of != part);
        if let Some(slot) = changed.parts.get_mut(part as usize) {
            *slot = lines.filter(|lines| *lines != SAME);
        }
        changed.off = false;
        changed.composed()
    }

    /// This frame with one more part inside of all others.
    ///
    /// # Errors
    /// A line would have no way back, or there are too many parts.
    pub fn with_added(&self, part: LocalFramePart, lines: Lines) -> Result<Self, FrameError> {
        if self.added.len() >= MOST {
            return Err(FrameError::TooMany);
        }
        let mut changed = self.clone();
        if lines != SAME {
            changed.added.push((part, lines));
        }
        changed.off = false;
        changed.composed()
    }

    /// This frame with its parts switched off, or on again.
    #[must_use]
    pub fn switched(&self, on: bool) -> Self {
        let changed = Self { off: !on, ..self.clone() };
        changed.composed().unwrap_or_else(|_| self.clone())
    }

    fn composed(mut self) -> Result<Self, FrameError> {
        let outer = self.parts.iter().rev().flatten();
        let lines = outer.chain(self.added.iter().map(|(_, lines)| lines)).filter(|_| !self.off);
        let mut map = SAME;
        for inner in lines {
            for (line, inner) in map.iter_mut().zip(inner) {
                *line = line.after(*inner);
            }
        }
        if map.iter().any(|line| !line.is_sound()) {
            return Err(FrameError::NoWayBack);
        }
        self.map = map;
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(line: AxisMap) -> Lines {
        let mut lines = SAME;
        lines[0] = line;
        lines
    }

    #[test]
    fn parts_act_in_the_order_of_the_frame_and_additive_ones_inside() {
        // Scale 2, mirror at 10, shift 30: 5 becomes 10, then 10, then 40; 7 becomes 14, then 6, then 36.
        let frame =
            AuxiliaryFrame::default().with(LocalFramePart::Translate, Some(first(AxisMap::shift(30.0)))).unwrap();
        let frame = frame.with(LocalFramePart::Scale, Some(first(AxisMap::scale(2.0, 0.0)))).unwrap();
        let frame = frame.with(LocalFramePart::Mirror, Some(first(AxisMap::scale(-1.0, 10.0)))).unwrap();
        let [line, other, ..] = *frame.map();
        assert_eq!([line.to_work(5.0), line.to_work(7.0), line.to_program(36.0)], [40.0, 36.0, 7.0]);
        assert_eq!(other, AxisMap::SAME);
        // An additive shift by 1 counts before all of them: 4 counts as 5.
        let added = frame.with_added(LocalFramePart::Translate, first(AxisMap::shift(1.0))).unwrap();
        assert_eq!(added.map()[0].to_work(4.0), 40.0);
        assert_eq!(added.switched(false).map(), &SAME);
        assert_eq!(added.switched(false).switched(true).map(), added.map());
        let shifts_gone = added.with(LocalFramePart::Translate, None).unwrap();
        assert_eq!(shifts_gone.map()[0].to_work(5.0), 10.0);
    }

    #[test]
    fn a_line_without_a_way_back_is_refused() {
        let flat = AuxiliaryFrame::default().with(LocalFramePart::Scale, Some(first(AxisMap::scale(0.0, 0.0))));
        assert_eq!(flat.map(|_| ()), Err(FrameError::NoWayBack));
        assert!(AuxiliaryFrame::default().with(LocalFramePart::Translate, Some(SAME)).unwrap().is_empty());
    }
}
