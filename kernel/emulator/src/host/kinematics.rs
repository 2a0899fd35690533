//! `$FDK`, `$FIK`, `$FKINCFG`, `$FKINROT`: the rotary axes of the channel as functions of macros.
//!
//! Facts: reference functions.md 10. Machine positions are those of `$XM`, so neither tools nor fixtures count, except
//! that the fixture offset has placed the part. Decision: a position that cannot be reached is `$NULL`.

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::{Fault, Outcome};
use counterpoint_lang::value::Value;
use counterpoint_machine::index::{AxisSlot, BySlot};

use super::rotary::{Named, is};
use crate::channel::Kernel;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::kinematics::{Angles, Chain, Joint, unit};

/// Six numbers by the elements of `$AXES`, or position and direction.
type Six = [f64; 6];

fn numbers(value: Option<&Value>, mut into: Six) -> Outcome<Six> {
    match value {
        Some(Value::Sequence(given)) => {
            for (slot, value) in into.iter_mut().zip(given.iter()) {
                *slot = value.as_real().ok_or_else(|| Fault::kind("a number", value))?;
            }
            Ok(into)
        }
        None => Ok(into),
        Some(value) => Err(Fault::kind("a sequence", value)),
    }
}

fn halves([x, y, z, i, j, k]: Six) -> (Point, Point) {
    ([x, y, z], [i, j, k])
}

impl Kernel<'_> {
    /// Machine positions of `$XM` where the axes are.
    fn machine_now(&self) -> Position {
        let mut at = self.channel.machine_point(&self.channel.state.place.position);
        for ((slot, shift), preset) in
            at.iter_mut().zip(&self.channel.state.place.shift).zip(&self.channel.state.place.preset)
        {
            *slot += preset - shift;
        }
        at
    }

    /// From positions of `$XM` to the joints without a tool, by channel axis.
    fn fixture(&self) -> Position {
        let tool = self.channel.tool_shift();
        let mut fixture = [0.0; MAX_AXES];
        for (((slot, shift), preset), tool) in
            fixture.iter_mut().zip(&self.channel.state.place.shift).zip(&self.channel.state.place.preset).zip(tool)
        {
            *slot = shift - preset - tool;
        }
        fixture
    }

    fn by_elements(&self, of: &Position) -> Six {
        self.six_axes().map(|axis| axis.map_or(0.0, |axis| of.at(axis)))
    }

    fn programmed_units(&self, point: Point) -> Point {
        let mut point = point;
        for (role, slot) in point.iter_mut().enumerate() {
            *slot /= self.channel.state.place.scale_of(role);
        }
        point
    }

    /// `$FDK`: position and direction on the part of machine positions.
    pub(crate) fn forward(&self, arguments: &[Value]) -> Outcome<Value> {
        let given = numbers(arguments.first(), self.by_elements(&self.machine_now()))?;
        let fixture = self.fixture();
        let mut joints = self.machine_now();
        for (axis, value) in self.six_axes().into_iter().zip(given) {
            if let Some(axis) = axis {
                *joints.at_mut(axis) = value;
            }
        }
        for (slot, fixture) in joints.iter_mut().zip(fixture) {
            *slot += fixture;
        }
        let chain = self.channel.chain();
        let angle = |axis: AxisSlot| joints.at(axis);
        let tip = chain.tip(self.channel.state.place.geometry(&joints), [0.0; 3], angle);
        let (Some(tip), Some(direction)) = (tip, chain.direction(angle)) else { return Ok(Value::Null) };
        let base = self.channel.state.place.geometry(&fixture);
        let mut point = tip;
        for (slot, base) in point.iter_mut().zip(base) {
            *slot -= base;
        }
        Ok(Value::numbers(&[self.programmed_units(point), direction].concat()))
    }

    /// `$FIK`: machine positions of a position and direction on the part.
    pub(crate) fn backward(&self, arguments: &[Value]) -> Outcome<Value> {
        let (given, number) = match arguments {
            [] => (None, None),
            [first @ Value::Sequence(_)] => (Some(first), None),
            [first] => (None, Some(first)),
            [first, second, ..] => (Some(first), Some(second)),
        };
        let now = match self.forward(&[])? {
            value @ Value::Sequence(_) => numbers(Some(&value), [0.0; 6])?,
            _ => return Ok(Value::Null),
        };
        let (point, direction) = halves(numbers(given, now)?);
        let number = number.and_then(Value::as_real).unwrap_or(0.0);
        if ![0.0, 1.0, 2.0].contains(&number) {
            return Err(Fault::new(Number::OUT_OF_RANGE, format!("a solution is 0, 1 or 2, not {number}")));
        }
        let chain = self.channel.chain();
        let all: Vec<Angles<AxisSlot>> = if chain.tables.is_empty() && chain.heads.is_empty() {
            vec![Vec::new()]
        } else {
            chain.solve(direction).iter().map(|one| self.channel.near(one)).collect()
        };
        let reached: Vec<Six> = all.iter().map(|solution| self.machine_positions(&chain, solution, point)).collect();
        let chosen = self.chosen(&all, &reached, number).and_then(|at| reached.get(at));
        Ok(chosen.map_or(Value::Null, |six| Value::numbers(six)))
    }

    /// Machine positions of a solution, by the elements of `$AXES`.
    fn machine_positions(&self, chain: &Chain<AxisSlot>, solution: &Angles<AxisSlot>, point: Point) -> Six {
        let fixture = self.fixture();
        let mut joints = self.machine_now();
        for (slot, fixture) in joints.iter_mut().zip(fixture) {
            *slot += fixture;
        }
        for (axis, angle) in solution {
            let shift = self.channel.state.place.shift.at(*axis);
            if let Some(angle) = angle {
                *joints.at_mut(*axis) = angle + shift;
            }
        }
        let angle = |axis: AxisSlot| joints.at(axis);
        let base = self.channel.state.place.geometry(&fixture);
        let mut part = point;
        for (role, (slot, base)) in part.iter_mut().zip(base).enumerate() {
            *slot = *slot * self.channel.state.place.scale_of(role) + base;
        }
        let mut linear = chain.linear(part, [0.0; 3], angle);
        for (slot, base) in linear.iter_mut().zip(base) {
            *slot -= base;
        }
        let mut out = joints;
        for ((slot, fixture), axis) in out.iter_mut().zip(fixture).zip(&self.channel.state.place.layout.axes) {
            *slot -= if axis.rotary { fixture } else { 0.0 };
        }
        let mut six = self.by_elements(&out);
        for (slot, value) in six.iter_mut().zip(self.programmed_units(linear)) {
            *slot = value;
        }
        six
    }

    /// The solution with a number: 0 is the first within the limits, 1 the one with the least turning (of equal
    /// solutions the one with the shortest travel of the linear axes), 2 the other solution.
    fn chosen(&self, all: &[Angles<AxisSlot>], reached: &[Six], number: f64) -> Option<usize> {
        if number != 1.0 && number != 2.0 {
            return all.iter().position(|one| self.channel.within(one)).or((!all.is_empty()).then_some(0));
        }
        let [x, y, z, ..] = self.by_elements(&self.machine_now());
        let way = |[a, b, c, ..]: &Six| (a - x).hypot(b - y).hypot(c - z);
        // Differences of rounding decide nothing.
        let rounded = |value: f64| (value * 1e6).round();
        let mut sorted: Vec<(f64, f64, usize)> = all
            .iter()
            .zip(reached)
            .enumerate()
            .map(|(at, (one, six))| (rounded(self.channel.turned(one)), rounded(way(six)), at))
            .collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let wanted = if number == 2.0 { sorted.last() } else { sorted.first() };
        wanted.map(|(.., at)| *at)
    }

    /// Takes over changed kinematics; nothing moves. `false` if tool tip control could not continue.
    fn change_kinematics(&mut self, change: impl FnOnce(&mut crate::state::frames::tip::Settings)) -> bool {
        let before = self.channel.state.others.tip.clone();
        change(&mut self.channel.state.others.tip);
        if self.channel.tip().is_none() {
            return true;
        }
        if !self.channel.chain().is_possible() {
            self.channel.state.others.tip = before;
            return false;
        }
        let machine = self.channel.machine_point(&self.channel.state.place.position);
        self.channel.refresh_tip();
        self.channel.state.place.position = self.channel.point_of_machine(&machine);
        self.channel.frames_changed();
        true
    }

    /// `$FKINCFG`: moves a rotary axis or the tool axis, or puts it back.
    pub(crate) fn configure(&mut self, arguments: &[Value]) -> Value {
        let done = self.configured(arguments).unwrap_or(false);
        Value::Real(f64::from(u8::from(done)))
    }

    fn configured(&mut self, arguments: &[Value]) -> Option<bool> {
        let (named, count) = self.named_axis(arguments, 0)?;
        let rest = arguments.get(count..)?;
        if is(rest.first(), "OFF") {
            return Some(match named {
                Named::Missing => false,
                Named::Tool => self.change_kinematics(|settings| settings.direction = None),
                Named::Axis(axis) => self.change_kinematics(|s| s.changed.retain(|joint| joint.axis != axis)),
            });
        }
        let mut six = [0.0; 6];
        for (slot, value) in six.iter_mut().zip(rest.iter()) {
            *slot = value.as_real()?;
        }
        let (center, vector) = halves(six);
        let valid = rest.len() == 6 && unit(vector).is_some() && center.iter().all(|value| value.is_finite());
        Some(match named {
            Named::Tool if valid => self.change_kinematics(|settings| settings.direction = Some(vector)),
            Named::Axis(axis) if valid && self.channel.state.place.layout.axes[axis].rotary => {
                self.change_kinematics(|settings| {
                    settings.changed.retain(|joint| joint.axis != axis);
                    settings.changed.push(Joint { axis, vector, center });
                })
            }
            _ => false,
        })
    }

    /// `$FKINROT`: the rotary axes of tool tip control.
    pub(crate) fn choose_rotary(&mut self, arguments: &[Value]) -> Value {
        let (mut at, mut chosen) = (0, Vec::new());
        while at < arguments.len() {
            match self.named_axis(arguments, at) {
                Some((Named::Axis(axis), count)) if self.channel.state.place.layout.axes[axis].rotary => {
                    if chosen.contains(&axis) {
                        return Value::Real(0.0);
                    }
                    chosen.push(axis);
                    at += count;
                }
                _ => return Value::Real(0.0),
            }
        }
        let valid = (1..=2).contains(&chosen.len());
        let done = valid && self.change_kinematics(|settings| settings.chosen = chosen);
        Value::Real(f64::from(u8::from(done)))
    }
}
