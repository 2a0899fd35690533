//! The moves of the tool beside a contour.
//!
//! *Invariant:* every move is an ordinary motion, made from the tool's position; `Place::position` is that of the
//! tool's centre (on a lathe of the imaginary tip). The feed is that of this point.

use std::f64::consts::TAU;

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::data;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::CornerShape;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::contour::corner;
use counterpoint_motion::contour::corner::{CornerPath, Link, Offset};
use counterpoint_motion::contour::element::{Element, NOISE, Spot, angle, beside, distance, plus};
use counterpoint_program::block::ContourEnd;

use super::held::HeldShift;
use super::{CutterCompensation, MoveShape, ProgrammedMove};
use crate::circular_move::CircularMove;
use crate::context::ActionContext;
use counterpoint_channel::arc::LastMove;
use counterpoint_channel::cutter::{CompensationStage, WaitingMove};

impl ActionContext<'_, '_> {
    /// A move as programmed, for circles that continue its direction.
    pub(crate) fn last_move(&self, step: &ProgrammedMove) -> Option<LastMove> {
        let MoveShape::Circle { made, axes, .. } = step.shape else {
            let mut by = step.to;
            by.iter_mut().zip(self.channel().state.place.contour()).for_each(|(to, from)| *to -= from);
            return Some(LastMove::By(by));
        };
        let scale = |axis: AxisSlot| self.channel().state.place.layout.axes[axis].scale;
        let [first, second] = axes;
        let center = [made.center[0] / scale(first), made.center[1] / scale(second)];
        Some(LastMove::Round { axes, center, turn: made.sweep.signum() })
    }

    /// Coordinate of a position as geometry.
    pub(crate) fn radial(&self, of: &Position, axis: AxisSlot) -> f64 {
        let scale = self.channel().state.place.layout.axes[axis].scale;
        of.at(axis) * scale
    }

    /// A position in the plane of compensation: that of the part under polar interpolation.
    pub(crate) fn plane_spot(&self, of: &Position, axes: [AxisSlot; 2]) -> Spot {
        match self.channel().state.place.polar() {
            Some(polar) => polar.part(&self.channel().state.place, of),
            None => axes.map(|axis| self.radial(of, axis)),
        }
    }

    /// Where the tool's centre is in the plane.
    pub(crate) fn spot_of(&self, cutter: &CutterCompensation) -> Spot {
        plus(self.plane_spot(&self.channel().state.place.position, cutter.axes), cutter.tip, 1.0)
    }

    /// The position that puts the tool's centre on a point straight from where it is, the other axes where `to` has
    /// them.
    pub(crate) fn position_at(&self, cutter: &CutterCompensation, to: &Position, spot: Spot) -> Position {
        let mut position = *to;
        if let Some(polar) = self.channel().state.place.polar() {
            polar.reach_straight(&self.channel().state.place, &mut position, spot);
            return position;
        }
        for (axis, value) in cutter.axes.into_iter().zip(plus(spot, cutter.tip, -1.0)) {
            let scale = self.channel().state.place.layout.axes[axis].scale;
            *position.at_mut(axis) = counterpoint_channel::frames::clean(value / scale, position.at(axis));
        }
        position
    }

    /// The same along an arc of the tool's centre.
    pub(crate) fn position_round(
        &self,
        cutter: &CutterCompensation,
        to: &Position,
        spot: Spot,
        made: &PlaneArc,
    ) -> Position {
        let mut position = self.position_at(cutter, to, spot);
        if let Some(polar) = self.channel().state.place.polar() {
            polar.reach(
                &self.channel().state.place,
                &mut position,
                spot,
                counterpoint_channel::round_centre::way_round(made),
            );
        }
        position
    }

    pub(crate) fn offset(&self, cutter: &CutterCompensation) -> Offset {
        let limit = libm::cos(self.channel().env.machine.compensation.corner_angle.to_radians());
        let shape = self.channel().env.machine.compensation.corner_shape.map(|shape| self.shape(shape));
        Offset {
            side: cutter.side,
            radius: cutter.radius,
            corner: self.channel().state.place.compensation.corner,
            limit,
            shape,
        }
    }

    /// Takes the distortion of round corners from the block.
    pub(crate) fn take_distortion(&mut self) {
        if self.block_has(data::CONTOUR_DISTORTION)
            && let Some(value) = self.take(data::CONTOUR_DISTORTION).map(|datum| datum.value)
        {
            self.channel_mut().state.remembered.remember(data::CONTOUR_DISTORTION, value);
        }
    }

    /// Limits of outside corners, with the distortion that the program has set.
    fn shape(&self, limits: CornerShape) -> corner::CornerThresholds {
        let asked = self.channel().state.remembered.value(data::CONTOUR_DISTORTION).unwrap_or(0.0);
        let [sharp, flat] = [limits.sharp, limits.flat].map(|turn| libm::cos(turn.to_radians()));
        corner::CornerThresholds { sharp, flat, distortion: asked.clamp(0.0, limits.distortion) / 100.0 }
    }

    /// A move that goes where it says, without compensation.
    pub(crate) fn on_contour(&mut self, step: &ProgrammedMove) -> Acted {
        self.straight(step, step.to)
    }

    /// A straight move of a step to a point.
    pub(crate) fn straight(&mut self, step: &ProgrammedMove, to: Position) -> Acted {
        self.without_cutter(|act| match step.shape {
            MoveShape::Rapid => act.rapid_within(step.coded, to, step.feed),
            MoveShape::Linear | MoveShape::Circle { .. } => act.feed_to(step.coded, to, step.feed, step.unit),
        })
    }

    /// Carries moves out while compensation does not take them.
    fn without_cutter<R>(&mut self, act: impl FnOnce(&mut Self) -> R) -> R {
        let cutter = self.channel_mut().state.place.frames().cutter.take();
        let result = act(self);
        if cutter.is_some() {
            self.channel_mut().state.place.frames().cutter = cutter;
        }
        result
    }

    /// Where a piece begins after one that did not know it: around the corner, or straight.
    pub(crate) fn come_to(&mut self, step: &ProgrammedMove, element: &Element) -> Acted {
        let Some(cutter) = self.channel_mut().state.place.cutter().cloned() else { return Ok(()) };
        let offset = self.offset(&cutter);
        let links = match cutter.stage {
            CompensationStage::Start => {
                if matches!(step.shape, MoveShape::Circle { .. }) {
                    vec![Link::Line(offset.at_start(element))]
                } else {
                    return Ok(());
                }
            }
            CompensationStage::Settled { corner, along } => {
                let start = offset.at_start(element);
                let turn = counterpoint_motion::contour::element::cross(along, element.start()) * cutter.side;
                if distance(self.spot_of(&cutter), start) < NOISE {
                    Vec::new()
                } else if turn > 0.0 {
                    self.report_overcut(cutter.ended);
                    vec![Link::Line(start)]
                } else {
                    offset.outside(corner, along, element)
                }
            }
            CompensationStage::Around { corner, along } => {
                Offset { corner: 2, ..offset }.outside(corner, along, element)
            }
            CompensationStage::Turned => vec![Link::Line(offset.at_start(element))],
            CompensationStage::On | CompensationStage::Ending(_) => return Ok(()),
        };
        if let Some(cutter) = self.channel_mut().state.place.cutter() {
            cutter.stage = CompensationStage::On;
        }
        self.links((step, element), &cutter, &links, self.channel().state.place.position)
    }

    /// Finishes the waiting move, now that the next piece is known (or will not be).
    pub(crate) fn next_element(&mut self, next: Option<&Element>) -> Acted {
        let Some(cutter) = self.channel_mut().state.place.cutter().filter(|cutter| !cutter.waiting.is_empty()) else {
            return Ok(());
        };
        let waiting = std::mem::take(&mut cutter.waiting);
        cutter.idle = 0;
        let mut begun = cutter.stage;
        let (now, exact_stop) =
            ((self.channel().at.clock, self.channel().at.micro), self.channel().block.flags.exact_stop);
        let place = self.channel().at.block_place();
        let (edited, spindle) = (self.channel().text.edited.clone(), self.channel().state.spindle);
        let mut events = self.channel_mut().emitter.release().into_iter();
        let (mut shift, mut out) = (HeldShift::default(), 0_usize);
        let (mut result, mut missing) = (Ok(()), None);
        for (at, waits) in waiting.iter().enumerate() {
            let next = waiting.iter().skip(at + 1).find_map(|later| later.element.as_ref()).or(next);
            self.put_back_events(&mut events, waits.events.saturating_sub(out), shift);
            out = out.max(waits.events);
            self.go_to(waits, shift);
            let before = self.channel().at.clock;
            self.channel_mut().state.spindle = waits.spindle;
            if result.is_ok() {
                missing = missing.or_else(|| self.missing(waits));
                result = self.make(waits, begun, next);
                begun = match self.channel_mut().state.place.cutter().map(|cutter| cutter.stage) {
                    Some(stage @ CompensationStage::Around { .. }) => stage,
                    _ if waits.element.is_some() || waits.smooth.is_some() => CompensationStage::On,
                    _ => begun,
                };
            }
            let at = &self.channel().at;
            shift.add(before, (at.clock, at.micro));
        }
        self.put_back_events(&mut events, usize::MAX, shift);
        self.channel_mut().state.spindle = spindle;
        (self.channel_mut().at.clock, self.channel_mut().at.micro) = shift.of(now);
        self.channel_mut().block.flags.exact_stop = exact_stop;
        self.channel_mut().at.go_to(place);
        self.channel_mut().text.edited = edited;
        if let Some((facts, text)) = missing.filter(|_| result.is_ok()) {
            self.diagnose(facts, text);
            return self.channel().check_stop();
        }
        result
    }

    /// Makes a move that has waited.
    fn make(&mut self, waits: &WaitingMove, begun: CompensationStage, next: Option<&Element>) -> Acted {
        let Some(cutter) = self.channel_mut().state.place.cutter().cloned() else { return Ok(()) };
        if let Some(smooth) = &waits.smooth {
            return self.smooth_approach(waits, smooth, next);
        }
        let (step, offset) = (&waits.step, self.offset(&cutter));
        let Some(element) = &waits.element else {
            let to = cutter.lifted(&step.to, &self.channel().state.place.position);
            return self.straight(step, to);
        };
        if matches!(begun, CompensationStage::Around { .. }) {
            self.come_to(step, element)?;
        }
        let stage = match next {
            Some(_) => CompensationStage::On,
            None => CompensationStage::Settled { corner: element.to, along: element.end() },
        };
        let ended = self.channel().at.line;
        if let Some(cutter) = self.channel_mut().state.place.cutter() {
            (cutter.stage, cutter.ended) = (stage, ended);
        }
        if begun == CompensationStage::Start && !matches!(step.shape, MoveShape::Circle { .. }) {
            if let Some(next) = next
                && let Some(corner) = self.around_start(element, next)?
            {
                let to = self.position_at(&cutter, &step.to, corner.end);
                self.straight(step, to)?;
                let level = self.channel().state.place.position;
                return self.links((step, element), &cutter, &corner.links, level);
            }
            let end = match (waits.end, next) {
                (ContourEnd::Beside(along), _) => beside(element.to, along, cutter.side, cutter.radius),
                (_, Some(next)) => offset.at_start(next),
                (_, None) => offset.at_end(element),
            };
            let to = self.position_at(&cutter, &step.to, end);
            self.straight(step, to)?;
            let links: Vec<_> = next.and_then(|next| arc_start(waits.end, &offset, next)).into_iter().collect();
            return self.links((step, element), &cutter, &links, to);
        }
        let here = self.spot_of(&cutter);
        let corner = match next {
            Some(next) if self.circle_follows(waits, &offset, (element, next)) => {
                if let Some(cutter) = self.channel_mut().state.place.cutter() {
                    cutter.stage = CompensationStage::Around { corner: element.to, along: element.end() };
                }
                let hurts = element.is_smaller(cutter.side, cutter.radius);
                CornerPath { end: offset.at_end(element), links: Vec::new(), hurts }
            }
            Some(next) if let ContourEnd::Beside(along) = waits.end => {
                let links = arc_start(waits.end, &offset, next).into_iter().collect();
                CornerPath { end: beside(element.to, along, cutter.side, cutter.radius), links, hurts: false }
            }
            Some(next) if waits.end == ContourEnd::Open => {
                CornerPath { end: offset.at_end(element), links: vec![Link::Line(offset.at_start(next))], hurts: false }
            }
            Some(next) if let ContourEnd::Extended(by) = waits.end => offset.extended(element, next, here, by),
            Some(next) if waits.end == ContourEnd::Round => Offset { corner: 2, ..offset }.between(element, next, here),
            Some(next) if waits.end == ContourEnd::Sharp => Offset { corner: 1, ..offset }.between(element, next, here),
            Some(next) => offset.between(element, next, here),
            None => {
                let hurts = element.is_smaller(cutter.side, cutter.radius);
                CornerPath { end: offset.at_end(element), links: Vec::new(), hurts }
            }
        };
        if corner.hurts {
            let text = format!(
                "the tool of radius {} does not fit into the contour at the end of '{}'",
                counterpoint_lang::format::wildcard_text(cutter.radius),
                self.channel().block_text()
            );
            self.diagnose(&diag::CUTTER_INTERFERENCE, text);
        }
        self.along(step, &cutter, element, corner.end)?;
        let to = self.channel().state.place.position;
        self.links((step, element), &cutter, &corner.links, to)
    }

    /// Whether the circle around the end of a piece belongs to the move after it.
    fn circle_follows(&self, waits: &WaitingMove, offset: &Offset, (first, second): (&Element, &Element)) -> bool {
        self.channel().env.machine.compensation.corner_after
            && waits.end == ContourEnd::Meets
            && offset.goes_around(first, second)
    }

    /// Along the offset of a piece to a point of it.
    pub(crate) fn along(
        &mut self,
        step: &ProgrammedMove,
        cutter: &CutterCompensation,
        element: &Element,
        end: Spot,
    ) -> Acted {
        let to = self.position_at(cutter, &step.to, end);
        let (Some(arc), MoveShape::Circle { axes, turns, .. }) = (&element.arc, step.shape) else {
            return self.straight(step, to);
        };
        let Some(radius) = element.offset_radius(cutter.side, cutter.radius) else { return self.straight(step, to) };
        let here = self.spot_of(cutter);
        let start_angle = angle(arc.center, here);
        let turn = arc.sweep.signum();
        let way = ((angle(arc.center, end) - start_angle) * turn).rem_euclid(TAU);
        // A whole circle, or nothing of one.
        let near = way < 1e-9 || TAU - way < 1e-9;
        let whole = f64::from(turns) * TAU;
        let part = arc.sweep.abs() - whole;
        let way = if near && part > TAU / 2.0 {
            TAU
        } else if near {
            0.0
        } else {
            way
        };
        if way + whole < 1e-12 {
            return self.straight(step, to);
        }
        let made =
            PlaneArc { center: plus(arc.center, cutter.tip, -1.0), radius, start_angle, sweep: turn * (way + whole) };
        let to = self.position_round(cutter, &step.to, end, &made);
        let ProgrammedMove { coded, unit, .. } = *step;
        let feed = self.edge_feed(step.feed, unit, radius / arc.radius);
        self.round(&CircularMove {
            made,
            coded,
            from: self.channel().state.place.position,
            to,
            axes,
            turns,
            feed,
            unit,
            screw: None,
        })
    }

    pub(crate) fn round(&mut self, circle: &CircularMove) -> Acted {
        self.without_cutter(|act| act.circle_to(circle))
    }

    /// The moves around a corner, the axes beside the plane standing.
    pub(crate) fn links(
        &mut self,
        (step, element): (&ProgrammedMove, &Element),
        cutter: &CutterCompensation,
        links: &[Link],
        level: Position,
    ) -> Acted {
        let length = element.length();
        for link in links {
            match *link {
                Link::Line(spot) => {
                    let to = self.position_at(cutter, &level, spot);
                    self.link(step, length, to, None)?;
                }
                Link::Round { to: spot, center, clockwise } => {
                    let here = self.spot_of(cutter);
                    let turn = if clockwise { -1.0 } else { 1.0 };
                    let (start_angle, radius) = (angle(center, here), distance(center, spot));
                    let sweep = ((angle(center, spot) - start_angle) * turn).rem_euclid(TAU) * turn;
                    let center = plus(center, cutter.tip, -1.0);
                    let made = PlaneArc { center, radius, start_angle, sweep };
                    let to = self.position_round(cutter, &level, spot, &made);
                    self.link(step, length, to, Some((made, cutter.axes)))?;
                }
            }
        }
        Ok(())
    }

    /// Feed per minute of a circle around a corner between rapid moves: the rate of the slower axis of the plane.
    fn rapid_round(&self, axes: [AxisSlot; 2], limit: Option<f64>) -> Option<f64> {
        let rates = axes.map(|axis| self.channel().state.place.layout.axes[axis].rapid * 60.0);
        let rate = rates.into_iter().chain(limit).fold(f64::INFINITY, f64::min);
        Some(rate).filter(|rate| rate.is_finite())
    }

    /// A move around a corner has the feed of its block; under inverse time the speed that the block has on the
    /// contour.
    fn link(
        &mut self,
        step: &ProgrammedMove,
        length: f64,
        to: Position,
        round: Option<(PlaneArc, [AxisSlot; 2])>,
    ) -> Acted {
        let (feed, unit) = match step.unit {
            FeedUnit::InverseTime => (step.feed.map(|feed| feed * length), FeedUnit::PerMinute),
            unit => (step.feed, unit),
        };
        match (round, step.shape) {
            (Some((made, axes)), shape) => {
                let from = self.channel().state.place.position;
                let (feed, unit) = match shape {
                    MoveShape::Rapid => (self.rapid_round(axes, feed), FeedUnit::PerMinute),
                    _ => (feed, unit),
                };
                self.round(&CircularMove { made, coded: 0, from, to, axes, turns: 0, feed, unit, screw: None })
            }
            _ => self.straight(&ProgrammedMove { feed, unit, ..step.clone() }, to),
        }
    }
}

/// The start of the offset of an arc, from the vector that the program gives.
fn arc_start(end: ContourEnd, offset: &Offset, next: &Element) -> Option<Link> {
    let given = matches!(end, ContourEnd::Beside(_)) && next.arc.is_some();
    given.then(|| Link::Line(offset.at_start(next)))
}
