//! Arrivals at waits, and the verdict on waits that never end.

use counterpoint_event::event::{Verdict, VerdictKind, VerdictMember};
use counterpoint_event::info::Info;

use super::{Order, Wake};
use crate::tag::Tag;
use crate::verdict;
use crate::wait::{ChannelSet, Finish, Terminal, WaitMark, WaitOp, WaitingChannel};
use crate::waits::{ArrivalOutcome, RefusedPairs, ShortfallReason};

/// The effect of the arrival on the arriving kernel.
pub enum ArrivalReply {
    /// It continues at once.
    Go {
        /// Time of the release, ns.
        t: i64,
        /// Its order at that time.
        micro: u32,
        /// Number of the sync point.
        sync_point: u64,
        /// Why a partner of a count did not come.
        short: Option<ShortfallReason>,
    },
    /// It waits, with the verdict if no wait can end any more.
    Stand(Option<Verdict>),
    /// The channel cannot arrive here, regardless of the others.
    Illegal {
        /// Why.
        text: String,
    },
    /// The control refuses to pair the wait with another one.
    Alarm {
        /// Its text.
        text: String,
        /// The verdict.
        verdict: Verdict,
    },
}

impl Order {
    /// The verdict on the channels that can never continue, if that is new of some of them.
    pub fn judge(&mut self, t: i64, info: &Info) -> Option<Verdict> {
        let dead = ChannelSet(self.waits.dead().0 & !self.judged.0);
        if dead.is_empty() {
            return None;
        }
        self.judged = ChannelSet(self.judged.0 | dead.0);
        if verdict::depends_on_order(dead, &self.waits) {
            return None;
        }
        Some(verdict::of(dead, t, &self.waits, info))
    }

    /// A channel takes a resource that another channel holds; if that is an axis that moves, the channel waits for the
    /// end of the move.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn take(&mut self, tag: Tag, key: WaitMark) -> Result<Option<ArrivalReply>, String> {
        self.act(tag, WaitOp::Take(key))?;
        let end = self.waits.lease(key).1.map(|moved| moved.end_ns).filter(|end| *end > tag.t);
        Ok(end.map(|t| {
            self.sync_points += 1;
            ArrivalReply::Go { t, micro: 0, sync_point: self.sync_points, short: None }
        }))
    }

    /// A channel arrives before it has come to rest: unless [`ArrivalReply::Go`] lets it continue, it runs on until it
    /// [`stops`](Self::stops).
    pub fn arrive_in_motion(
        &mut self,
        waiting: WaitingChannel,
        own: Finish,
        info: &Info,
    ) -> (ArrivalReply, Option<String>) {
        self.moving = self.moving.with(waiting.tag.channel);
        let (after, warning) = self.arrive(waiting, own, info);
        if !matches!(after, ArrivalReply::Stand(_)) {
            self.moving = self.moving.without(waiting.tag.channel);
        }
        (after, warning)
    }

    /// A channel that has arrived in motion would stop now. Returns how its wait has ended meanwhile, or the verdict if
    /// no wait can end any more and the channel is blocked.
    ///
    /// # Errors
    /// The verdict, if there is one.
    pub fn stops(&mut self, tag: Tag, info: &Info) -> Result<Wake, Option<Verdict>> {
        self.moving = self.moving.without(tag.channel);
        if let Some(at) = self.moved.iter().position(|(channel, _)| *channel == tag.channel) {
            return Ok(self.moved.swap_remove(at).1);
        }
        let verdict = if self.waits.hopeful(tag.channel) { None } else { self.judge(tag.t, info) };
        self.block(tag.channel);
        Err(verdict)
    }

    /// Executes the arrival of a channel at a wait; returns the control's warnings.
    pub fn arrive(&mut self, waiting: WaitingChannel, own: Finish, info: &Info) -> (ArrivalReply, Option<String>) {
        let tag = waiting.tag;
        if let Some(races) = &mut self.races {
            races.arrive(tag.channel, &waiting.wait);
        }
        let arrived = self.waits.arrive(waiting);
        let after = match arrived.arrival {
            ArrivalOutcome::Released(released) => {
                let sync_point = self.release(released, Some(tag.channel));
                ArrivalReply::Go { t: released.t, micro: released.micro, sync_point, short: released.short }
            }
            ArrivalOutcome::Blocked if self.moving.has(tag.channel) => ArrivalReply::Stand(None),
            ArrivalOutcome::Blocked => {
                let verdict = if self.waits.hopeful(tag.channel) { None } else { self.judge(tag.t, info) };
                self.block(tag.channel);
                ArrivalReply::Stand(verdict)
            }
            ArrivalOutcome::Mismatch(refused) => {
                let text = verdict::of_refused(&refused, &self.waits, info);
                refuse(self, &refused, text, own)
            }
            ArrivalOutcome::Illegal { text } => ArrivalReply::Illegal { text },
        };
        self.release_all(arrived.others);
        let warning = arrived.warning.map(|refused| verdict::of_refused(&refused, &self.waits, info));
        (after, warning)
    }
}

/// The control refuses to pair waits: all of them alarm.
fn refuse(order: &mut Order, refused: &RefusedPairs, text: String, own: Finish) -> ArrivalReply {
    let (channels, arriving) = (refused.channels(), refused.arriving);
    let member = |waiting: &WaitingChannel| {
        let waiting_for = channels.without(waiting.tag.channel).iter().collect();
        VerdictMember { channel: waiting.tag.channel, file: waiting.file, line: waiting.line, waiting_for }
    };
    let mut members: Vec<VerdictMember> = refused.standing.iter().map(|(other, _)| member(other)).collect();
    members.sort_by_key(|member| member.channel);
    let Tag { t, micro, channel } = arriving.tag;
    for member in &members {
        let finish = Finish { how: Terminal::Alarmed, file: member.file, line: member.line };
        order.waits.finish(member.channel, finish);
        let tag = Tag { t, micro: micro + 1, channel: member.channel };
        order.resume(member.channel, Wake::Alarm { tag, text: text.clone() });
    }
    order.waits.finish(channel, own);
    members.push(member(&arriving));
    members.sort_by_key(|member| member.channel);
    let verdict = Verdict { kind: VerdictKind::Mismatch, at_ns: t, text: text.clone().into(), members };
    ArrivalReply::Alarm { text, verdict }
}
