//! Tool tip control: the program gives the position of the tool tip on the part, for any position of the rotary axes.
//!
//! While it is active a point of the work frame is that of the tip with the tables at zero; the linear axes follow.
//! Facts: reference control-emulator.md 6.8. *Invariant:* switching it never moves the machine.

use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::kinematics::{Angles, Chain, Joint, unit};
use counterpoint_motion::frame::orient::{FreeAxisPolicy, PairChoice, PairRule, TurnChoice, next_to};

use super::clean;
use crate::channel_context::ChannelContext;
use crate::frame_transforms::Tip;
use crate::position::MotionState;

/// Settings that stay when it is switched off.
#[derive(Debug, Clone)]
pub struct TipSettings {
    /// `$TCPFMT`
    pub format: u8,
    /// `$TCPSET`
    pub method: u8,
    /// Rotary axes that a macro has chosen.
    pub chosen: Vec<AxisSlot>,
    /// Rotary axes as a macro has changed them.
    pub changed: Vec<Joint<AxisSlot>>,
    /// Tool direction that a macro has given.
    pub direction: Option<Point>,
    /// Largest rate of the linear axes as they follow the rotary ones, units per minute.
    pub follow: Option<f64>,
    /// Words of the orientation that came last, by format.
    pub words: [Point; 7],
}

impl Default for TipSettings {
    fn default() -> Self {
        Self {
            format: 0,
            method: 1,
            chosen: Vec::new(),
            changed: Vec::new(),
            direction: None,
            follow: None,
            words: [[0.0; 3]; 7],
        }
    }
}

/// Whether the axis turns the part.
fn is_table(id: DataId) -> bool {
    [data::AXIS_AT, data::AXIS_BT, data::AXIS_CT, data::AXIS_CT2].contains(&id)
}

fn at(position: &Position, axis: AxisSlot) -> f64 {
    position.at(axis)
}

impl MotionState {
    /// Difference of two positions, axis by axis.
    pub(super) fn less(&self, of: &Position, by: &Position) -> Position {
        let mut out = [0.0; MAX_AXES];
        for ((slot, of), by) in out.iter_mut().zip(of).zip(by) {
            *slot = of - by;
        }
        out
    }
}

impl Tip {
    /// The linear axes at a point of the part; `machine` has the rotary axes.
    pub(super) fn to_linear(&self, place: &MotionState, point: Point, machine: &Position) -> Point {
        let fixture = place.geometry(&place.less(&place.shift, &self.tool));
        self.chain.linear(plus(point, fixture), place.geometry(&self.tool), |axis| at(machine, axis))
    }

    /// How far the linear axes follow the rotary ones at the rate of a place of the path between two points of the work
    /// frame.
    pub fn following(&self, place: &MotionState, [from, to]: [&Position; 2], share: f64) -> f64 {
        let mut at = *from;
        for (slot, to) in at.iter_mut().zip(to) {
            *slot += (to - *slot) * share;
        }
        let fixture = place.geometry(&place.less(&place.shift, &self.tool));
        let tilt = place.frames.as_deref().and_then(|frames| frames.tilt.as_deref());
        let point = place.geometry(&at);
        let part = plus(tilt.map_or(point, |tilt| tilt.outwards(point)), fixture);
        let angle = |axis: AxisSlot| at.at(axis) + place.shift.at(axis);
        let turning = |axis: AxisSlot| to.at(axis) - from.at(axis);
        self.chain.following(part, place.geometry(&self.tool), angle, turning)
    }

    /// The point of the part where the axes are.
    pub(super) fn to_part(&self, place: &MotionState, linear: Point, machine: &Position) -> Option<Point> {
        let fixture = place.geometry(&place.less(&place.shift, &self.tool)).map(|value| -value);
        let tip = self.chain.tip(linear, place.geometry(&self.tool), |axis| at(machine, axis))?;
        Some(plus(tip, fixture))
    }
}

fn plus([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [a + x, b + y, c + z]
}

impl ChannelContext<'_> {
    /// The rotary axes of the channel as tool tip control uses them: those that a macro has chosen, otherwise the first
    /// two.
    pub fn chain(&self) -> Chain<AxisSlot> {
        let settings = &self.state.others.tip;
        let joint = |(slot, axis): (AxisSlot, &crate::channel_axis::ChannelAxis)| {
            let own = &self.env.machine.axes[axis.machine];
            let made = Joint { axis: slot, vector: own.vector, center: own.center };
            let chosen = settings.chosen.is_empty() || settings.chosen.contains(&slot);
            let changed = settings.changed.iter().find(|changed| changed.axis == slot).copied();
            (axis.rotary && chosen).then(|| (axis.data, changed.unwrap_or(made)))
        };
        let joints: Vec<(DataId, Joint<AxisSlot>)> =
            self.state.place.layout.axes.entries().filter_map(joint).take(2).collect();
        let side = |table: bool| joints.iter().filter(|(id, _)| is_table(*id) == table).map(|(_, j)| *j).collect();
        let tool = settings.direction.unwrap_or(self.env.machine.kinematics.tool);
        Chain { tables: side(true), heads: side(false), tool }
    }

    /// Whether the channel has axes that tilt the tool.
    pub fn can_tilt(&self) -> bool {
        self.chain().is_possible() && !self.state.place.has_axes().contains(&false)
    }

    /// Switches it on; `false` if the channel has no axes for it. The machine does not move.
    pub fn start_tip(&mut self, with_length: bool) -> bool {
        if !self.can_tilt() {
            return false;
        }
        self.keep_tip(0.0, with_length);
        true
    }

    /// Switches it on for a point that lies a distance behind the tip, away from the spindle.
    pub fn keep_tip(&mut self, behind: f64, with_length: bool) {
        let chain = self.chain();
        let mut tool = self.tool_shift();
        for (role, part) in unit(chain.tool).unwrap_or_default().into_iter().enumerate() {
            if let Some(axis) = self.state.place.layout.cartesian.get(role).copied().flatten() {
                *tool.at_mut(axis) += part * behind / self.state.place.scale_of(role);
            }
        }
        let levels = self.state.cycle_levels();
        self.standing(|channel| channel.state.place.frames().tip = Some(Box::new(Tip { chain, tool, with_length })));
        self.state.keep_levels(levels);
    }

    /// Switches it off; `false` if it was. The machine does not move.
    pub fn end_tip(&mut self) -> bool {
        if self.state.place.tip().is_none() {
            return false;
        }
        let levels = self.state.cycle_levels();
        self.standing(|channel| {
            if let Some(frames) = channel.state.place.frames.as_deref_mut() {
                frames.tip = None;
            }
        });
        self.state.keep_levels(levels);
        true
    }

    /// Takes over new offsets of the tool, and new settings; the point of the program is found again by the caller.
    pub fn refresh_tip(&mut self) {
        if self.state.place.tip().is_none() {
            return;
        }
        let (chain, tool) = (self.chain(), self.tool_shift());
        if let Some(tip) = self.state.place.frames.as_deref_mut().and_then(|frames| frames.tip.as_deref_mut()) {
            (tip.chain, tip.tool) = (chain, tool);
        }
    }

    /// Direction of the tool on the part with the axes at a position of the work frame.
    pub fn tool_direction(&self, work: &Position) -> Point {
        let chain = self.chain();
        let direction = chain.direction(|axis| at(work, axis) + at(&self.state.place.shift, axis));
        direction.unwrap_or([0.0, 0.0, 1.0])
    }

    /// The same in the local frame.
    pub fn local_direction(&self, work: &Position) -> Point {
        let direction = self.tool_direction(work);
        let Some(frames) = self.state.place.frames.as_deref() else { return direction };
        frames.direction_back(direction).and_then(unit).unwrap_or(direction)
    }
}

impl MotionState {
    /// Active tool tip control.
    pub fn tip(&self) -> Option<&Tip> {
        self.frames.as_deref().and_then(|frames| frames.tip.as_deref())
    }

    /// Puts the angles of a solution next to where the axes are, in the work frame.
    pub fn near(&self, solution: &Angles<AxisSlot>) -> Angles<AxisSlot> {
        let near = |(axis, angle): &(AxisSlot, Option<f64>)| {
            let stands = at(&self.position, *axis);
            let angle = angle.map_or(stands, |angle| {
                let angle = angle - at(&self.shift, *axis);
                next_to(angle, stands)
            });
            (*axis, Some(super::clean(angle, stands) + 0.0))
        };
        solution.iter().map(near).collect()
    }

    /// How far the axes would have to turn.
    pub fn turned(&self, solution: &Angles<AxisSlot>) -> f64 {
        solution.iter().map(|(axis, angle)| (angle.unwrap_or(0.0) - at(&self.position, *axis)).abs()).sum()
    }

    /// Whether the axes stay within their limits.
    pub fn within(&self, solution: &Angles<AxisSlot>) -> bool {
        solution.iter().all(|(axis, angle)| {
            let machine = angle.unwrap_or(0.0) + at(&self.shift, *axis);
            let limits = self.layout.axes[*axis].limits;
            limits.is_none_or(|(low, high)| (low..=high).contains(&machine))
        })
    }
}

/// The solution with the least turning that stays within the limits, near where the axes are.
pub fn least_turning(channel: &ChannelContext<'_>, direction: Point) -> Option<Vec<(AxisSlot, f64)>> {
    let chain = channel.chain();
    let rule = PairRule { turns: TurnChoice::Nearest, way: PairChoice::Least, side: None, free: FreeAxisPolicy::Stays };
    let pairs = chain.pairs(direction, &rule, |axis| channel.state.place.stand(axis));
    let any = !pairs.iter().any(|pair| pair.inside);
    let pick = pairs.iter().filter(|pair| any || pair.inside);
    let chosen = chain.choose(pick, &rule, |axis| channel.state.place.stand(axis))?;
    let work = |(axis, angle): &(AxisSlot, f64)| {
        let stands = channel.state.place.position.at(*axis);
        (*axis, clean(angle - channel.state.place.shift.at(*axis), stands) + 0.0)
    };
    Some(chosen.angles.iter().map(work).collect())
}
