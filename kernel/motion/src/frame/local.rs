//! The local frame: scale, mirror, rotation and translation of the program.
//!
//! Each kind has a part of its own; from the program to the work frame they act in the order scale, mirror, rotation,
//! translation. Additive parts act before all of them, the newest first: each is given in the frame that was active
//! when it came. *Invariant:* the map has a way back and moves no axis that the channel does not have. Facts: reference
//! control-emulator.md 6.7.

use super::affine::{Affine, Point};

/// Most additive parts.
const MOST: usize = 200;

/// Largest number of a frame and of its way back.
const BOUND: f64 = 1e12;

/// A kind of parts, from the program outwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LocalFramePart {
    /// Scale factors.
    Scale,
    /// Mirrored axes.
    Mirror,
    /// Rotation.
    Rotate,
    /// Translation.
    Translate,
}

impl LocalFramePart {
    const ALL: [Self; 4] = [Self::Scale, Self::Mirror, Self::Rotate, Self::Translate];
}

/// A part as it was programmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Programmed {
    /// The map of the part.
    pub map: Affine,
    /// Distances, direction or angles, factors, or 1 for a mirrored axis.
    pub values: Point,
    /// Centre of a rotation or scale.
    pub center: Option<Point>,
    /// The meaning of the values of a rotation.
    pub order: &'static str,
    /// Angle about a direction, degrees.
    pub angle: f64,
}

impl Programmed {
    /// A part without a centre or a rotation.
    pub fn new(map: Affine, values: Point) -> Self {
        Self { map, values, center: None, order: "", angle: 0.0 }
    }
}

/// Why a frame cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Points would lie on each other, or out of all bounds.
    NoWayBack,
    /// An axis would have to move that the channel does not have.
    MissingAxis,
    /// Too many additive parts.
    TooMany,
}

/// The local frame of a channel.
#[derive(Debug, Clone)]
pub struct LocalFrame {
    /// The part of each kind.
    parts: [Option<Programmed>; 4],
    /// Additive parts, oldest first.
    added: Vec<(LocalFramePart, Programmed)>,
    /// A frame that a macro has given, outside all of these.
    given: Option<Affine>,
    /// The rotation of the work offset, outside all.
    outer: Option<Affine>,
    /// Switched off by a macro: the parts are kept.
    off: bool,
    /// From the program to the work frame.
    map: Affine,
    /// The way back.
    back: Affine,
}

impl Default for LocalFrame {
    fn default() -> Self {
        let (map, back) = (Affine::SAME, Affine::SAME);
        Self { parts: [None; 4], added: Vec::new(), given: None, outer: None, off: false, map, back }
    }
}

impl LocalFrame {
    /// Whether nothing is programmed.
    pub fn is_empty(&self) -> bool {
        !self.is_programmed() && self.given.is_none() && self.outer.is_none()
    }

    /// Whether the program has given a part.
    pub fn is_programmed(&self) -> bool {
        self.parts.iter().any(Option::is_some) || !self.added.is_empty()
    }

    /// Programmed and not switched off.
    pub fn is_on(&self) -> bool {
        self.is_programmed() && !self.off
    }

    /// From the program to the work frame.
    pub fn map(&self) -> &Affine {
        &self.map
    }

    /// The programmed part of the frame: without the rotation of the work offset.
    pub fn programmed(&self) -> Affine {
        match self.outer {
            None => self.map,
            Some(_) => Self { outer: None, ..self.clone() }.made(),
        }
    }

    /// The rotation of the work offset.
    pub fn outer(&self) -> Option<&Affine> {
        self.outer.as_ref()
    }

    /// A programmed point in the work frame.
    pub fn to_work(&self, point: Point) -> Point {
        self.map.point(point)
    }

    /// A point of the work frame as programmed.
    pub fn to_program(&self, point: Point) -> Point {
        self.back.point(point)
    }

    /// The part of a kind.
    pub fn part(&self, part: LocalFramePart) -> Option<&Programmed> {
        self.parts.get(part as usize)?.as_ref()
    }

    /// All parts of a kind, oldest first.
    pub fn parts(&self, part: LocalFramePart) -> impl Iterator<Item = &Programmed> {
        let added = self.added.iter().filter(move |(of, _)| *of == part).map(|(_, given)| given);
        self.part(part).into_iter().chain(added)
    }

    /// The newest part of all that has a centre.
    pub fn center(&self) -> Option<Point> {
        let added = self.added.iter().rev().filter(|(part, _)| *part != LocalFramePart::Mirror).map(|(_, given)| given);
        let own = [LocalFramePart::Rotate, LocalFramePart::Scale].into_iter().filter_map(|part| self.part(part));
        added.chain(own).find_map(|given| given.center)
    }

    /// A point of the work frame as seen by the part of a kind: the transformations outside that part are removed.
    pub fn inside_of(&self, part: LocalFramePart, point: Point) -> Option<Point> {
        let outer = self.composed(part as usize + 1);
        outer.inverse().map(|back| back.point(point))
    }

    /// The transformation set by a macro and the parts from a kind outwards.
    fn composed(&self, from: usize) -> Affine {
        let mut map = match (self.outer, self.given) {
            (Some(outer), Some(given)) => outer.after(&given),
            (outer, given) => outer.or(given).unwrap_or(Affine::SAME),
        };
        for part in LocalFramePart::ALL.into_iter().rev().take_while(|part| *part as usize >= from) {
            if let Some(given) = self.part(part).filter(|_| !self.off) {
                map = map.after(&given.map);
            }
        }
        map
    }

    /// Sets the part of a kind; additive ones of that kind end.
    pub fn set(&mut self, part: LocalFramePart, given: Option<Programmed>, has: [bool; 3]) -> Result<(), FrameError> {
        let given = given.filter(|given| given.map != Affine::SAME);
        self.change(has, |local| {
            local.added.retain(|(of, _)| *of != part);
            if let Some(slot) = local.parts.get_mut(part as usize) {
                *slot = given;
            }
            local.off = false;
        })
    }

    /// Adds a part.
    pub fn add(&mut self, part: LocalFramePart, given: Programmed, has: [bool; 3]) -> Result<(), FrameError> {
        if self.added.len() >= MOST {
            return Err(FrameError::TooMany);
        }
        self.change(has, |local| {
            local.added.push((part, given));
            local.off = false;
        })
    }

    /// The frame of a macro, or none.
    pub fn give(&mut self, given: Option<Affine>, has: [bool; 3]) -> Result<(), FrameError> {
        self.change(has, |local| local.given = given.filter(|map| *map != Affine::SAME))
    }

    /// The rotation of the work offset, or none.
    pub fn turn(&mut self, outer: Option<Affine>, has: [bool; 3]) -> Result<(), FrameError> {
        self.change(has, |local| local.outer = outer.filter(|map| *map != Affine::SAME))
    }

    /// Switches the programmed parts off, or on again.
    pub fn switch(&mut self, on: bool, has: [bool; 3]) -> Result<(), FrameError> {
        self.change(has, |local| local.off = !on)
    }

    /// From the program to the work frame, of its parts.
    fn made(&self) -> Affine {
        let added = self.added.iter().filter(|_| !self.off);
        added.fold(self.composed(0), |map, (_, given)| map.after(&given.map))
    }

    /// Takes a change over if the frame has a way back afterwards. `has`: the channel has an X, Y, Z axis.
    fn change(&mut self, has: [bool; 3], with: impl FnOnce(&mut Self)) -> Result<(), FrameError> {
        let mut changed = self.clone();
        with(&mut changed);
        let map = changed.made();
        let back = map.inverse().ok_or(FrameError::NoWayBack)?;
        if [map, back].iter().any(|map| map.cells().iter().any(|cell| cell.abs() > BOUND)) {
            return Err(FrameError::NoWayBack);
        }
        if [map, back].iter().any(|map| map.leaves(has)) {
            return Err(FrameError::MissingAxis);
        }
        (changed.map, changed.back) = (map, back);
        *self = changed;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [bool; 3] = [true; 3];

    fn turned(degrees: f64) -> Programmed {
        Programmed::new(Affine::rotation([0.0, 0.0, 1.0], degrees).unwrap(), [0.0, 0.0, 1.0])
    }

    fn shifted(x: f64) -> Programmed {
        Programmed::new(Affine::translation([x, 0.0, 0.0]), [x, 0.0, 0.0])
    }

    #[test]
    fn additive_parts_count_in_the_frame_they_came_in() {
        let mut local = LocalFrame::default();
        local.set(LocalFramePart::Rotate, Some(turned(90.0)), ALL).unwrap();
        local.set(LocalFramePart::Translate, Some(shifted(10.0)), ALL).unwrap();
        local.add(LocalFramePart::Translate, shifted(5.0), ALL).unwrap();
        assert_eq!(local.to_work([1.0, 0.0, 0.0]), [10.0, 6.0, 0.0]);
        assert_eq!(local.to_program([10.0, 6.0, 0.0]), [1.0, 0.0, 0.0]);
        local.set(LocalFramePart::Translate, None, ALL).unwrap();
        assert_eq!(local.to_work([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        local.switch(false, ALL).unwrap();
        assert_eq!(local.to_work([1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        assert!(local.is_programmed() && !local.is_on());
    }

    #[test]
    fn the_rotation_of_the_work_offset_is_outside_of_all() {
        let mut local = LocalFrame::default();
        local.set(LocalFramePart::Translate, Some(shifted(10.0)), ALL).unwrap();
        local.turn(Affine::rotation([0.0, 0.0, 1.0], 90.0), ALL).unwrap();
        assert_eq!(local.to_work([1.0, 0.0, 0.0]), [0.0, 11.0, 0.0]);
        assert_eq!(local.programmed().point([1.0, 0.0, 0.0]), [11.0, 0.0, 0.0]);
        local.set(LocalFramePart::Translate, None, ALL).unwrap();
        assert!(!local.is_empty() && !local.is_programmed());
        local.turn(None, ALL).unwrap();
        assert!(local.is_empty());
    }

    #[test]
    fn a_frame_without_a_way_back_changes_nothing() {
        let mut local = LocalFrame::default();
        let flat = Programmed::new(Affine::scale([0.0, 1.0, 1.0]), [0.0, 1.0, 1.0]);
        assert_eq!(local.set(LocalFramePart::Scale, Some(flat), ALL), Err(FrameError::NoWayBack));
        assert_eq!(
            local.set(LocalFramePart::Rotate, Some(turned(30.0)), [true, false, true]),
            Err(FrameError::MissingAxis)
        );
        assert!(local.is_empty());
    }
}
