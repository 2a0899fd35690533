//! Which of the angles that bring the tool into a direction the rotary axes go to.
//!
//! A direction has up to two pairs of angles ([`Chain::solve`]), each of them with whole turns; the travel of the axes
//! and a rule decide. Angles are degrees of the machine frame. *Invariant:* the same question has the same answer,
//! regardless of the noise of its computation. Facts: Fanuc operator's manual of the 16i (B-63534EN, tool axis
//! direction control: the pair is chosen axis by axis); Heidenhain user's manual (PLANE, SEQ, with a table of
//! examples); Siemens operating manual (CYCLE800, direction).

use super::affine::Point;
use super::kinematics::{Angles, Chain};

/// Differences below this are none, degrees.
const NOISE: f64 = 1e-9;

/// Differences of paths below this decide nothing, degrees.
const EQUAL: f64 = 1e-6;

/// A rotary axis as it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryAxisState {
    /// Where it is.
    pub at: f64,
    /// Its travel, if that ends.
    pub travel: Option<(f64, f64)>,
}

/// Which of the angles that differ by whole turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TurnChoice {
    /// The one next to where the axis is.
    Nearest,
    /// The one of half a turn to either side of zero.
    Half,
}

/// Which of two pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairChoice {
    /// The least rotation of both axes together; of equals the one that [`Chain::solve`] gives first.
    Least,
    /// The same; of equals the pair whose tilting axis has the larger angle.
    LeastLarger,
    /// The least rotation of the first axis, then of the second one, then the first one nearer to a whole turn, then
    /// the second one. The first axis is the one next to the machine; of a table and a head it is the table.
    AxisByAxis,
}

/// A request about the tilting axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TiltRequest {
    /// Its angle is not below zero, or not above; there is no other way.
    Sign(bool),
    /// The larger or smaller of its angles; the other angle if that one is out of reach.
    Larger(bool),
}

/// Behaviour of an axis for which any angle is suitable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FreeAxisPolicy {
    /// It stays.
    Stays,
    /// It goes to this angle.
    At(f64),
}

/// How a pair is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairRule {
    /// Which turn of an angle.
    pub turns: TurnChoice,
    /// Which pair.
    pub way: PairChoice,
    /// Which pair, said by the program.
    pub side: Option<TiltRequest>,
    /// An axis that has nothing to do.
    pub free: FreeAxisPolicy,
}

/// Why the axes cannot go there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrientationError {
    /// No angles bring the tool into the direction.
    Direction,
    /// The travel of the axes ends before.
    Travel,
    /// No pair is on the side that was requested.
    Side,
}

/// A pair of angles with their turns.
#[derive(Debug, Clone, PartialEq)]
pub struct AnglePair<A> {
    /// Angles by axis.
    pub angles: Vec<(A, f64)>,
    /// All of them are within the travel.
    pub inside: bool,
}

/// Nearest whole number of turns; halfway between two the smaller, regardless of noise.
fn whole_turns(of: f64) -> f64 {
    (of.abs() - 0.5 - 1e-9).ceil().max(0.0).copysign(of)
}

/// The turn of an angle next to another one.
pub fn next_to(angle: f64, at: f64) -> f64 {
    angle + 360.0 * whole_turns((at - angle) / 360.0)
}

/// An angle without the noise of its computation.
fn clean(angle: f64) -> f64 {
    let tidy = (angle / NOISE).round() * NOISE;
    let tidy = (tidy * 1e9).round() / 1e9;
    if tidy.is_finite() { tidy + 0.0 } else { angle }
}

impl RotaryAxisState {
    fn allows(&self, angle: f64) -> bool {
        self.travel.is_none_or(|(low, high)| angle >= low - NOISE && angle <= high + NOISE)
    }

    /// The turn of an angle by a rule, another one where the travel ends before.
    fn turn(&self, angle: f64, turns: TurnChoice) -> f64 {
        let wanted = match turns {
            TurnChoice::Nearest => next_to(angle, self.at),
            TurnChoice::Half => {
                let half = next_to(angle, 0.0);
                if (half + 180.0).abs() < NOISE { 180.0 } else { half }
            }
        };
        let wanted = clean(wanted);
        if self.allows(wanted) {
            return wanted;
        }
        let center = if turns == TurnChoice::Nearest { self.at } else { 0.0 };
        let others = self.travel.into_iter().flat_map(|(low, high)| {
            // The outermost turns within the travel; the nearest one is one of them, since the wanted one is outside.
            let first = wanted + 360.0 * ((low - NOISE - wanted) / 360.0).ceil();
            let last = wanted + 360.0 * ((high + NOISE - wanted) / 360.0).floor();
            [first, last]
        });
        let inside = others.map(clean).filter(|angle| self.allows(*angle));
        inside.min_by(|a, b| (a - center).abs().total_cmp(&(b - center).abs())).unwrap_or(wanted)
    }
}

impl<A: Copy + PartialEq> Chain<A> {
    /// The axis that tilts the tool, by which programs choose. Of two tables it is the one next to the machine,
    /// otherwise the head next to the tool (Heidenhain: the first rotary axis from the tool, or the last one from the
    /// table).
    pub fn tilting(&self) -> Option<A> {
        self.heads.last().or(self.tables.first()).map(|joint| joint.axis)
    }

    /// The order in which axes are looked at: next to the machine first, tables before heads.
    fn order(&self) -> impl Iterator<Item = A> + '_ {
        self.tables.iter().chain(&self.heads).map(|joint| joint.axis)
    }

    /// The pairs of angles that bring the tool into a direction, with their turns.
    pub fn pairs(&self, direction: Point, rule: &PairRule, stand: impl Fn(A) -> RotaryAxisState) -> Vec<AnglePair<A>> {
        let pair = |solution: &Angles<A>| {
            let of = |(axis, angle): &(A, Option<f64>)| {
                let stands = stand(*axis);
                let free = match rule.free {
                    FreeAxisPolicy::At(angle) => Some(angle),
                    FreeAxisPolicy::Stays => None,
                };
                let wanted = angle.or(free).filter(|angle| angle.is_finite());
                (*axis, wanted.map_or(stands.at, |angle| stands.turn(angle, rule.turns)))
            };
            let angles: Vec<(A, f64)> = solution.iter().map(of).collect();
            let inside = angles.iter().all(|(axis, angle)| stand(*axis).allows(*angle));
            AnglePair { angles, inside }
        };
        self.solve(direction).iter().map(pair).collect()
    }

    /// The pair of a rule among these.
    pub fn choose<'p>(
        &self,
        pairs: impl Iterator<Item = &'p AnglePair<A>>,
        rule: &PairRule,
        stand: impl Fn(A) -> RotaryAxisState,
    ) -> Option<&'p AnglePair<A>>
    where
        A: 'p,
    {
        let tilting = self.tilting();
        let of = |pair: &AnglePair<A>, axis: A| {
            pair.angles.iter().find(|(at, _)| *at == axis).map_or(0.0, |(_, angle)| *angle)
        };
        let tilt = |pair: &AnglePair<A>| tilting.map_or(0.0, |axis| of(pair, axis));
        let way = |pair: &AnglePair<A>, axis: A| (of(pair, axis) - stand(axis).at).abs();
        let off = |pair: &AnglePair<A>, axis: A| next_to(of(pair, axis), 0.0).abs();
        let turned = |pair: &AnglePair<A>| self.order().map(|axis| way(pair, axis)).sum::<f64>();
        // The first of these that differ decides.
        let looks = |pair: &AnglePair<A>| {
            let mut looks = Vec::with_capacity(5);
            if let Some(TiltRequest::Larger(larger)) = rule.side {
                looks.push(if larger { -tilt(pair) } else { tilt(pair) });
            }
            match rule.way {
                PairChoice::Least => looks.push(turned(pair)),
                PairChoice::LeastLarger => looks.extend([turned(pair), -tilt(pair)]),
                PairChoice::AxisByAxis => {
                    looks.extend(self.order().map(|axis| way(pair, axis)));
                    looks.extend(self.order().map(|axis| off(pair, axis)));
                }
            }
            looks
        };
        let before = |a: &&AnglePair<A>, b: &&AnglePair<A>| {
            let differ = looks(a).into_iter().zip(looks(b)).find(|(a, b)| (a - b).abs() > EQUAL);
            differ.map_or(std::cmp::Ordering::Equal, |(a, b)| a.total_cmp(&b))
        };
        pairs.min_by(before)
    }

    /// The angles to which the axes go so that the tool has a direction on the part.
    ///
    /// # Errors
    /// No pair of angles does it, none within the travel, or none on the side that was requested.
    pub fn reach(
        &self,
        direction: Point,
        rule: &PairRule,
        stand: impl Fn(A) -> RotaryAxisState + Copy,
    ) -> Result<Vec<(A, f64)>, OrientationError> {
        let pairs = self.pairs(direction, rule, stand);
        if pairs.is_empty() {
            return Err(OrientationError::Direction);
        }
        let tilting = self.tilting();
        let fits = |pair: &&AnglePair<A>| match rule.side {
            Some(TiltRequest::Sign(positive)) => pair
                .angles
                .iter()
                .filter(|(axis, _)| Some(*axis) == tilting)
                .all(|(_, angle)| if positive { *angle > -EQUAL } else { *angle < EQUAL }),
            _ => true,
        };
        if !pairs.iter().any(|pair| pair.inside) {
            return Err(OrientationError::Travel);
        }
        let fitting = pairs.iter().filter(|pair| pair.inside).filter(fits);
        self.choose(fitting, rule, stand).map(|pair| pair.angles.clone()).ok_or(OrientationError::Side)
    }
}

#[cfg(test)]
mod tests;
