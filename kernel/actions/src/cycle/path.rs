//! The moves of one hole.
//!
//! *Invariant:* every move goes through the motion actions, so events, limits, times and macros are theirs. Steps are
//! counted from the clearance height. Facts: reference control-emulator.md 6.4.

use crate::context::ActionContext;
use crate::{dwell, spindle};
use counterpoint_channel::cycle::Cycle;
use counterpoint_channel::cycle::CycleHole;
use counterpoint_event::event::{Position, SpindleDirection};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::cycle::{HoleCycle, Out, PeckStyle};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::CycleApproach;

/// Most steps of a hole.
const MOST_STEPS: u32 = 10_000;

/// A hole being made.
pub(crate) struct Drill<'h> {
    pub(crate) hole: &'h CycleHole,
    kind: HoleCycle,
    pub(crate) cycle: Cycle,
    /// Direction of the spindle when the hole began.
    turning: SpindleDirection,
}

impl ActionContext<'_, '_> {
    /// Makes a hole with the current data of the cycle.
    pub(crate) fn make_hole(&mut self, hole: &CycleHole) -> Acted {
        let cycle = self.channel().state.cycle;
        let Some(kind) = HoleCycle::numbered(cycle.number) else { return Ok(()) };
        let turning = self.spindle_command()?.direction;
        let drill = Drill { hole, kind, cycle, turning };
        self.approach(hole)?;
        let Some(depth) = hole.depth else { return Ok(()) };
        if kind.bores_back() {
            return match hole.bottom {
                Some(bottom) => self.bore_back(&drill, depth, bottom),
                None => Ok(()),
            };
        }
        self.go_down(&drill, depth)?;
        self.further_webs(&drill, depth)?;
        self.rest(&drill, 0)?;
        self.come_out(&drill)
    }

    /// To the position at the clearance height.
    fn approach(&mut self, hole: &CycleHole) -> Acted {
        let along = hole.axis.bit();
        let mut target = hole.target;
        if self.channel().env.machine.cycles.approach == CycleApproach::PositionFirst {
            *target.at_mut(hole.axis) = self.channel().state.place.programmed().at(hole.axis);
            self.rapid_to_point(hole.coded & !along, target)?;
            return self.rapid_to_point(along, self.level(hole.axis, hole.clear));
        }
        *target.at_mut(hole.axis) = hole.clear;
        self.rapid_to_point(hole.coded | along, target)
    }

    fn level(&self, axis: AxisSlot, level: f64) -> Position {
        let mut target = self.channel().state.place.programmed();
        *target.at_mut(axis) = level;
        target
    }

    /// Along the axis of the cycle at rapid.
    pub(crate) fn lift(&mut self, drill: &Drill<'_>, level: f64) -> Acted {
        self.rapid_to_point(drill.hole.axis.bit(), self.level(drill.hole.axis, level))
    }

    /// Along the axis of the cycle at feed.
    pub(crate) fn plunge(&mut self, drill: &Drill<'_>, level: f64, ratio: f64) -> Acted {
        let (feed, unit) = drill.cycle.rates.feed;
        if drill.kind.is_rigid() {
            self.check_tap_rate((feed.map(|feed| feed * ratio), unit), drill.hole.axis)?;
        }
        let target = self.level(drill.hole.axis, level);
        self.feed_to_point(drill.hole.axis.bit(), target, feed.map(|feed| feed * ratio), unit)
    }

    /// Dwell at depth (0), per step (1), at the top (2).
    fn rest(&mut self, drill: &Drill<'_>, place: usize) -> Acted {
        let amount = drill.cycle.rates.dwell.get(place).copied().filter(|_| drill.kind.dwells());
        dwell::of_cycle(self, amount.unwrap_or(0.0))
    }

    /// From the clearance height to the depth, in steps if the kind has them.
    fn go_down(&mut self, drill: &Drill<'_>, depth: f64) -> Acted {
        let steps = drill.kind.steps();
        let step = drill.cycle.pecks.first.filter(|step| *step > 0.0 && step.is_finite());
        let Some(step) = step.filter(|_| steps != PeckStyle::None) else {
            if steps != PeckStyle::None && self.channel().env.machine.cycles.step_required {
                let text =
                    format!("a cycle needs its step in '{}', it is drilled in one step", self.channel().block_text());
                self.diagnose(&diag::DATA_MISSING, text);
            }
            return self.plunge(drill, depth, 1.0);
        };
        self.in_steps(drill, depth, step)
    }

    /// Size of a program's unit along an axis for the cycle's own lengths: the program may be scaled, steps and shifts
    /// are not.
    pub(crate) fn own_scale(&self, axis: AxisSlot) -> f64 {
        let place = &self.channel().state.place;
        let role = place.layout.cartesian.iter().position(|own| *own == Some(axis));
        let scaled = role
            .filter(|_| place.frames.is_some())
            .and_then(|role| self.channel().state.place.frame_values().scale.get(role).copied());
        let factor = scaled.map(f64::abs).filter(|factor| *factor > 0.0 && factor.is_finite()).unwrap_or(1.0);
        place.layout.axes[axis].scale * factor
    }

    fn in_steps(&mut self, drill: &Drill<'_>, depth: f64, first: f64) -> Acted {
        let (hole, cycle) = (drill.hole, &drill.cycle);
        let scale = self.own_scale(hole.axis);
        let (whole, down) = ((depth - hole.clear).abs() * scale, (depth - hole.clear).signum());
        let at = |reached: f64| hole.clear + down * reached / scale;
        let (mut reached, mut step, mut last_out) = (0.0, first, 0.0);
        for _ in 0..MOST_STEPS {
            let next = reached + step;
            if next >= whole - 1e-9 {
                return self.plunge(drill, depth, 1.0);
            }
            self.plunge(drill, at(next), 1.0)?;
            self.rest(drill, 1)?;
            let above = (next - cycle.pecks.retract).max(0.0);
            let leaves = cycle.pecks.out > 0.0 && next - last_out >= cycle.pecks.out - 1e-9;
            last_out = if leaves { next } else { last_out };
            self.between(drill, at(above), leaves)?;
            reached = next;
            let less = (step - cycle.pecks.decrement).max(cycle.pecks.least);
            step = if less > 0.0 { less } else { step };
        }
        let text = format!(
            "the cycle of '{}' has more than {MOST_STEPS} steps, the rest is drilled in one step",
            self.channel().block_text()
        );
        self.diagnose(&diag::CYCLE_STEPS, text);
        self.plunge(drill, depth, 1.0)
    }

    /// Between two steps: fully out and back to `above`, or only up to there.
    fn between(&mut self, drill: &Drill<'_>, above: f64, leaves: bool) -> Acted {
        let full = leaves || drill.kind.steps() == PeckStyle::Full;
        let ratio = drill.cycle.rates.ratio;
        if !drill.kind.taps() {
            if full {
                self.lift(drill, drill.hole.clear)?;
                self.rest(drill, 2)?;
            }
            return self.lift(drill, above);
        }
        self.reverse(drill)?;
        self.plunge(drill, if full { drill.hole.clear } else { above }, ratio)?;
        self.turn_again(drill)?;
        if full {
            self.rest(drill, 2)?;
            self.plunge(drill, above, ratio)?;
        }
        Ok(())
    }

    fn come_out(&mut self, drill: &Drill<'_>) -> Acted {
        let (hole, ratio) = (drill.hole, drill.cycle.rates.ratio);
        match drill.kind.out() {
            Out::Rapid => self.lift(drill, hole.back),
            Out::Feed => {
                self.plunge(drill, hole.clear, ratio)?;
                self.lift(drill, hole.back)
            }
            Out::Reversed => {
                self.reverse(drill)?;
                self.plunge(drill, hole.clear, ratio)?;
                self.turn_again(drill)?;
                self.rest(drill, 2)?;
                self.lift(drill, hole.back)
            }
            Out::Stopped => {
                self.turn(drill, SpindleDirection::Off)?;
                self.lift(drill, hole.back)?;
                self.turn_again(drill)
            }
            Out::Oriented => {
                self.turn(drill, SpindleDirection::Oriented)?;
                self.shift_aside(drill, 1.0)?;
                self.lift(drill, hole.back)?;
                self.shift_aside(drill, -1.0)?;
                self.turn_again(drill)
            }
        }
    }

    /// Beside the centre down to the lower clearance, up at feed, and out beside the centre.
    fn bore_back(&mut self, drill: &Drill<'_>, depth: f64, bottom: f64) -> Acted {
        self.turn(drill, SpindleDirection::Oriented)?;
        self.shift_aside(drill, 1.0)?;
        self.lift(drill, bottom)?;
        self.shift_aside(drill, -1.0)?;
        self.turn_again(drill)?;
        self.plunge(drill, depth, 1.0)?;
        self.rest(drill, 0)?;
        self.come_out(drill)
    }

    /// The shift of oriented boring, away from the centre (1) or back (−1).
    fn shift_aside(&mut self, drill: &Drill<'_>, way: f64) -> Acted {
        let cycle = &drill.cycle;
        let mut target = self.channel().state.place.programmed();
        let mut coded = 0_u8;
        let given = cycle.boring.shifts.iter().any(Option::is_some);
        // The first axis of the plane: X of G17, Z of G18, Y of G19 (Fanuc parameter 5101#4 and #5 at 0).
        let along = cycle.axis.map_or(2, |(along, _)| along);
        let axes = self.channel().state.place.layout.cartesian;
        let first =
            [(along + 1) % 3, (along + 2) % 3].into_iter().find(|role| axes.get(*role).copied().flatten().is_some());
        for (role, axis) in axes.iter().enumerate() {
            let part = match cycle.boring.shifts.get(role).copied().flatten() {
                Some(part) => part,
                None if !given && Some(role) == first => cycle.boring.shift,
                None => 0.0,
            };
            let Some(axis) = axis.filter(|_| part != 0.0) else { continue };
            *target.at_mut(axis) += way * part / self.own_scale(axis);
            coded |= axis.bit();
        }
        self.rapid_to_point(coded, target)
    }

    /// Stops or orients a spindle that turned when the hole began.
    fn turn(&mut self, drill: &Drill<'_>, direction: SpindleDirection) -> Acted {
        match drill.turning {
            SpindleDirection::Clockwise | SpindleDirection::CounterClockwise => spindle::turn_inside(self, direction),
            _ => Ok(()),
        }
    }

    /// The direction that the hole began with.
    fn turn_again(&mut self, drill: &Drill<'_>) -> Acted {
        self.change_direction(drill, drill.turning)
    }

    fn reverse(&mut self, drill: &Drill<'_>) -> Acted {
        let opposite = match drill.turning {
            SpindleDirection::Clockwise => SpindleDirection::CounterClockwise,
            _ => SpindleDirection::Clockwise,
        };
        self.change_direction(drill, opposite)
    }

    /// Through a standstill if the spindle turns the other way.
    fn change_direction(&mut self, drill: &Drill<'_>, direction: SpindleDirection) -> Acted {
        if drill.kind.taps() {
            self.turn(drill, SpindleDirection::Off)?;
        }
        self.turn(drill, direction)
    }
}
