//! Motions: event, clock, position.
//!
//! *Invariant:* after an alarm of its block nothing moves; a motion of a clamped axis is reported and made
//! nevertheless.

use counterpoint_channel::arc::LastMove;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::code_time::end_before_feed;
use counterpoint_channel::laws::log_law;
use counterpoint_channel::stretch::{emit_move, paced};
use counterpoint_event::event::{Kind, Motion, MotionKind};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::index::BySlot;

use super::Kernel;
use crate::channel::{chucks, exchange, fixed_stops};

impl Kernel<'_> {
    /// Executes a motion, by way of its macro if the machine has one.
    #[inline]
    pub fn travel(&mut self, seconds: f64, motion: &Motion) -> Acted {
        self.channel.check_stop()?;
        if self.channel.state.others.attends() {
            return self.travel_attended(seconds, motion);
        }
        self.begin_travel(seconds, motion)
    }

    #[inline(always)]
    pub(super) fn begin_travel(&mut self, seconds: f64, motion: &Motion) -> Acted {
        self.check_travel_before(motion)?;
        if self.channel.tables.rules.overlaps {
            end_before_feed(&mut self.channel, motion.kind);
        }
        if let Some(instead) = self.plan.motion {
            return instead(self, seconds, motion);
        }
        self.move_to(seconds, motion)
    }

    /// A motion that needs checks: other axes move with it, the working area limits it, or another channel begins at
    /// the same time.
    #[cold]
    #[inline(never)]
    fn travel_attended(&mut self, seconds: f64, motion: &Motion) -> Acted {
        if let Some(beside) = self.channel.state.others.beside.take() {
            let seconds = paced(&self.channel, seconds, motion).map_or(seconds, |stretch| stretch.piece.alone());
            self.channel.come_to_rest();
            // The path stops at the end of the block.
            let pace = self.channel.emitter.take_pace();
            let moved = self.travel_attended(seconds.max(beside.seconds), &beside.with(motion));
            self.channel.emitter.put_pace(pace);
            return moved;
        }
        self.check_area(motion)?;
        if self.channel.state.others.balance.is_some() {
            self.check_travel_before(motion)?;
            self.pair_cut(motion.kind)?;
        }
        if self.channel.state.others.spindles.fixed_stops.any() {
            return fixed_stops::travel(self, seconds, motion);
        }
        chucks::travel(self, seconds, motion)
    }

    /// Two channels that cut in balance begin the cuts of their blocks together; rapid moves are free.
    #[cold]
    #[inline(never)]
    pub(super) fn pair_cut(&mut self, kind: MotionKind) -> Acted {
        let balance = self.channel.state.others.balance;
        match balance.filter(|_| kind != MotionKind::Rapid && !self.channel.block.flags.paired) {
            Some(wait) => {
                self.channel.block.flags.paired = true;
                self.wait(wait)
            }
            None => Ok(()),
        }
    }

    /// The motion itself.
    #[inline(always)]
    pub fn move_to(&mut self, seconds: f64, motion: &Motion) -> Acted {
        if let Some(hooks) = self.plan.hooks {
            (hooks.moved)(self, seconds, motion);
        }
        if self.channel.state.place.clamped != 0 {
            self.check_clamps(motion);
        }
        let (mut seconds, mut stretch) = (seconds, paced(&self.channel, seconds, motion));
        if self.channel.state.place.layout.exchanged != 0
            && exchange::moves_exchanged(&self.channel.state.place, motion)
        {
            // When such a move ends has to be known to the channel that gets the axis.
            self.channel.come_to_rest();
            seconds = stretch.take().map_or(seconds, |stretch| stretch.piece.alone());
            self.exchanged_move(seconds, motion)?;
        }
        let drives = self.drive_spindle(seconds, motion)?;
        self.channel.block.flags.moved = true;
        self.flow.pass.effects = true;
        if self.channel.tables.rules.keeps_last_move {
            self.channel.state.arcs.last = Some(last_move(&self.channel, motion));
            self.channel.state.arcs.feed = Some((motion.feed, motion.feed_unit));
        }
        self.channel.state.place.position = motion.to;
        let ns = counterpoint_channel::at::nanoseconds(seconds);
        if let Some(stretch) = stretch {
            emit_move(&mut self.channel, ns, motion, &stretch);
            self.channel.at.advance(ns);
        } else {
            self.channel.emitter.emit_as(&self.channel.at, ns, |kind| match kind {
                Kind::Motion(place) => *place = *motion,
                other => *other = Kind::Motion(*motion),
            });
            log_law(&mut self.channel, ns, motion);
            self.channel.advance(ns);
        }
        self.check_travel(motion);
        if drives { Ok(()) } else { self.follow_radius() }
    }

    /// A motion while axes are clamped.
    #[cold]
    #[inline(never)]
    pub(crate) fn check_clamps(&mut self, motion: &Motion) {
        let round = matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw);
        let clamped = self.channel.state.place.clamped;
        for axis in self.channel.state.place.layout.axes.ids().filter(|axis| clamped & axis.bit() != 0) {
            let turns = round && motion.plane_axes.map(usize::from).contains(&axis.index());
            if !turns && motion.from.at(axis) == motion.to.at(axis) {
                continue;
            }
            let text = format!(
                "axis {} is clamped and moves in '{}'",
                self.channel.axis_name(axis),
                self.channel.block_text()
            );
            self.diagnose(&diag::CLAMPED, text);
        }
    }
}

/// Data of this move for a circle tangent to it.
fn last_move(channel: &ChannelContext<'_>, motion: &Motion) -> LastMove {
    let turn = match motion.kind {
        MotionKind::ArcCw => Some(-1.0),
        MotionKind::ArcCcw => Some(1.0),
        _ => None,
    };
    let axes = motion.plane_axes.map(|axis| channel.state.place.layout.axes.id(usize::from(axis)));
    match (turn, axes) {
        (Some(turn), [Some(first), Some(second)]) => {
            LastMove::Round { axes: [first, second], center: motion.center, turn }
        }
        _ => {
            let mut by = motion.to;
            by.iter_mut().zip(&motion.from).for_each(|(to, from)| *to -= from);
            LastMove::By(by)
        }
    }
}
