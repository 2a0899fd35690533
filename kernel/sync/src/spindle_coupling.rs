//! Spindles that turn together: a follower has the speed of its leader and, if the program asks for it, its phase.
//!
//! *Invariant:* a spindle that has followers does not follow a spindle; while a spindle follows, its own command has no
//! effect.

use std::borrow::Cow;

use crate::shared::{DrivingMove, SharedSpindle, SharedState, SpindleCommand, SpindleCoupling};
use counterpoint_event::event::SpindleDirection;
use counterpoint_motion::driven_speed::DrivenSpeed;
use counterpoint_motion::surface_speed::SurfaceSpeed;

impl SpindleCoupling {
    /// The command of the follower while the leader has the command `leader`.
    #[must_use]
    pub fn command(&self, leader: &SpindleCommand) -> SpindleCommand {
        let times = self.ratio.abs();
        let direction = match leader.direction {
            SpindleDirection::Clockwise if self.turns_against() => SpindleDirection::CounterClockwise,
            SpindleDirection::CounterClockwise if self.turns_against() => SpindleDirection::Clockwise,
            direction => direction,
        };
        SpindleCommand {
            direction,
            rpm: leader.rpm * times,
            surface: leader.surface * times,
            limit: leader.limit * times,
            least: leader.least * times,
            ..*leader
        }
    }

    /// Whether the follower has the other direction than its leader.
    fn turns_against(&self) -> bool {
        (self.ratio < 0.0) != self.mirrored
    }

    fn follower(&self, leader: &SharedSpindle, own: &SharedSpindle) -> SharedSpindle {
        let times = self.ratio.abs();
        let scaled = |SurfaceSpeed { surface, max, min }: SurfaceSpeed| SurfaceSpeed {
            surface: surface * times,
            max: max * times,
            min: min * times,
        };
        let course = leader.course.map(|course| DrivingMove {
            driven: DrivenSpeed { speed: scaled(course.driven.speed), ..course.driven },
            ..course
        });
        let (command, now) = (self.command(&leader.command), leader.now * times);
        let settled = leader.settled.max(own.settled);
        SharedSpindle { command, now, course, coupling: own.coupling, ceiling: own.ceiling, settled, ..*leader }
    }
}

/// Why spindles cannot be coupled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CouplingRefusal {
    /// The follower follows another spindle, by index.
    FollowsOther(usize),
    /// The leader follows a spindle itself.
    LeaderFollows(usize),
    /// A spindle follows the follower.
    FollowerLeads(usize),
}

impl SharedState {
    /// The current state of a spindle: its own state or, while it follows, the state derived from its leader.
    #[must_use]
    pub fn spindle(&self, index: usize) -> Option<Cow<'_, SharedSpindle>> {
        let own = self.spindles.get(index)?;
        let Some(coupling) = own.coupling else { return Some(Cow::Borrowed(own)) };
        self.spindles.get(coupling.leader).map(|leader| Cow::Owned(coupling.follower(leader, own)))
    }

    /// Spindles that follow `leader`.
    pub fn followers(&self, leader: usize) -> impl Iterator<Item = (usize, SpindleCoupling)> + '_ {
        let follows = move |spindle: &SharedSpindle| spindle.coupling.filter(|coupling| coupling.leader == leader);
        self.spindles.iter().enumerate().filter_map(move |(at, spindle)| follows(spindle).map(|of| (at, of)))
    }

    /// Makes a spindle follow another spindle. Without a new phase, it keeps its current phase. `most`: largest speeds
    /// of all spindles, rev/min. Returns the previous coupling.
    ///
    /// # Errors
    /// One of the two spindles is coupled with a third spindle.
    pub fn couple(
        &mut self,
        follower: usize,
        coupling: SpindleCoupling,
        most: &[f64],
    ) -> Result<Option<SpindleCoupling>, CouplingRefusal> {
        let of = |index: usize| self.spindles.get(index).and_then(|spindle| spindle.coupling);
        let before = of(follower);
        if let Some(other) = before.filter(|before| before.leader != coupling.leader) {
            return Err(CouplingRefusal::FollowsOther(other.leader));
        }
        if let Some(other) = of(coupling.leader) {
            return Err(CouplingRefusal::LeaderFollows(other.leader));
        }
        if let Some((other, _)) = self.followers(follower).next() {
            return Err(CouplingRefusal::FollowerLeads(other));
        }
        let phase = coupling.phase.or_else(|| before.and_then(|before| before.phase));
        // Two chucks that face each other have opposite words for one direction: a spindle that turns keeps its own.
        let mirrored = before.map_or_else(|| self.is_mirrored(follower, &coupling), |before| before.mirrored);
        if let Some(spindle) = self.spindles.get_mut(follower) {
            spindle.coupling = Some(SpindleCoupling { phase, mirrored, ..coupling });
        }
        self.limit_together(coupling.leader, most);
        Ok(before)
    }

    /// Whether both spindles turn, the follower in the other direction than the coupling says.
    fn is_mirrored(&self, follower: usize, coupling: &SpindleCoupling) -> bool {
        let [own, leader] = [follower, coupling.leader].map(|at| self.spindles.get(at).map(|spindle| spindle.command));
        let turns = [SpindleDirection::Clockwise, SpindleDirection::CounterClockwise];
        own.zip(leader).is_some_and(|(own, leader)| {
            let wanted = coupling.command(&leader).direction;
            turns.contains(&own.direction) && turns.contains(&wanted) && own.direction != wanted
        })
    }

    /// Ends a coupling; the follower keeps turning at `rpm`. Returns the coupling that ended.
    pub fn uncouple(&mut self, follower: usize, rpm: f64, most: &[f64]) -> Option<SpindleCoupling> {
        let command = self.spindle(follower)?.command;
        let spindle = self.spindles.get_mut(follower)?;
        let coupling = spindle.coupling.take()?;
        (spindle.command.direction, spindle.command.angle) = (command.direction, command.angle);
        (spindle.command.css, spindle.command.rpm) = (false, if rpm > 0.0 { rpm } else { command.rpm });
        (spindle.course, spindle.now, spindle.ceiling) = (None, rpm, None);
        self.limit_together(coupling.leader, most);
        Some(coupling)
    }

    /// Limits coupled spindles so that none exceeds its largest speed.
    fn limit_together(&mut self, leader: usize, most: &[f64]) {
        let of = |index: usize| most.get(index).copied().unwrap_or(f64::INFINITY);
        let followers: Vec<(usize, f64)> = self.followers(leader).map(|(at, coupling)| (at, coupling.ratio)).collect();
        let slowest = followers.iter().map(|(at, ratio)| of(*at) / ratio.abs()).fold(of(leader), f64::min);
        for (at, ratio) in [(leader, 1.0)].into_iter().chain(followers.iter().copied()) {
            if let Some(spindle) = self.spindles.get_mut(at) {
                spindle.ceiling = (!followers.is_empty()).then_some(slowest * ratio.abs());
            }
        }
    }
}
