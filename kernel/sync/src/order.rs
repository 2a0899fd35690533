//! The order in which kernels act on shared data: the rules, without threads.
//!
//! A kernel asks for an operation with its tag and gets its turn when no other kernel can act before that tag any more.
//! Operations go in, [`OrderEffect`]s come out: which kernels continue and how far each has come. Nothing here locks, waits
//! or signals; that is the coordinator's business.
//!
//! Invariants: operations take their turns in ascending order of their tags; one kernel has the turn at a time; a
//! kernel that waits is woken once for each wait. Facts: reference channel-synchronisation.md 1.1, 2.3.

mod alone;
pub mod arrive;
#[cfg(test)]
mod explore;
pub mod idle;
pub mod spin;

use crate::channels::Channels;
use crate::primitives::Letter;
use crate::races::RaceDetector;
use crate::shared::SharedState;
use crate::tag::Tag;
use crate::wait::{ChannelSet, Finish, WaitOp, WaitingChannel};
use crate::waits::{ArrivalOutcome, JobWaits, Released, ShortfallReason};

/// Bound of a kernel that is blocked at a wait.
pub const BLOCKED: i64 = i64::MAX - 1;
/// Bound of a kernel that is done.
pub const DONE: i64 = i64::MAX;

/// Activity of a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum KernelStatus {
    /// Executing blocks; it acts at its bound at the earliest.
    Running,
    /// Asks for an operation.
    Parked(Tag),
    /// Waits for something outside of the job's order and acts at this tag at the earliest.
    Away(Tag),
    /// Waits for a partner.
    Blocked,
    /// Finished in any way.
    Done,
}

/// Why a wait of a kernel is over.
#[derive(Debug, Clone, PartialEq)]
pub enum Wake {
    /// The operation that it asked for is next: it has the turn.
    Turn,
    /// Its partners have arrived; continue at this tag.
    Released {
        /// Where to continue.
        tag: Tag,
        /// Ordinal of the sync point.
        sync_point: u64,
        /// The channel whose operation ended the wait.
        by: u16,
        /// Every kernel that is not done took part, so none acts before the tag.
        all: bool,
        /// Why a partner of a count did not come.
        short: Option<ShortfallReason>,
    },
    /// The control raised an alarm for this wait.
    Alarm {
        /// When.
        tag: Tag,
        /// Text of the alarm.
        text: String,
    },
    /// The kernel was idle; it runs this program from this tag on.
    Started {
        /// Where to begin.
        tag: Tag,
        /// The programs to run.
        program: idle::StartableProgram,
    },
    /// Others did something while the kernel rested in a loop: it continues with the pass that begins at this tag.
    Roused {
        /// Begin of the pass.
        tag: Tag,
        /// Passes that it has left out.
        passes: u64,
    },
    /// No kernel is left that could end this wait.
    Over,
    /// The job was stopped.
    Stopped,
}

/// Effect of an operation on the kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrderEffect {
    /// The kernel acts at this time at the earliest ([`BLOCKED`], [`DONE`]).
    Bound(u16, i64),
    /// Another kernel executed the arrival of this one, which is blocked now.
    Blocked(u16),
    /// The wait of the kernel is over; a blocked one continues at the tag.
    Woken(u16, Option<Tag>),
    /// Nothing after this tag happens.
    Stop(Tag),
}

/// A kernel as the order knows it.
#[derive(Debug, Clone)]
struct Seat {
    status: KernelStatus,
    /// It acts at this time at the earliest.
    bound: i64,
    /// Its bound when it was blocked.
    since: i64,
    /// The arrival that it asks for.
    arriving: Option<WaitingChannel>,
    wake: Option<Wake>,
    /// The program that it runs when it is started.
    program: Option<idle::StartableProgram>,
    /// The loop that it could not leave at its last pass.
    spin: Option<spin::Spin>,
    /// It rests in that loop.
    nap: Option<spin::Nap>,
}

/// The kernels of a job and their shared data.
#[derive(Debug, Clone)]
pub struct Order {
    channels: Channels,
    seats: Vec<Seat>,
    /// The kernel that has the turn.
    acting: Option<u16>,
    stop: Option<Tag>,
    /// Sync points so far.
    pub sync_points: u64,
    /// Tag of the last operation.
    now: Tag,
    /// Number of changes of shared data so far.
    changes: u64,
    /// Kernels that rest in a loop.
    napping: ChannelSet,
    /// Channels that a verdict has been given on.
    judged: ChannelSet,
    /// Channels that have arrived in motion and will say whether they stop.
    moving: ChannelSet,
    /// How the waits of such channels ended meanwhile.
    moved: Vec<(u16, Wake)>,
    /// Variables, spindles and files that the kernels share.
    pub shared: SharedState,
    /// Waits of all kernels.
    pub waits: JobWaits,
    /// Accesses that nothing puts in order, if the job looks for them.
    pub races: Option<Box<RaceDetector>>,
    effects: Vec<OrderEffect>,
}

impl Order {
    /// The order of a run that begins.
    pub fn new(channels: Channels, shared: SharedState, waits: JobWaits) -> Self {
        let seat = || Seat {
            status: KernelStatus::Running,
            bound: 0,
            since: 0,
            arriving: None,
            wake: None,
            program: None,
            spin: None,
            nap: None,
        };
        let seats = (0..channels.count()).map(|_| seat()).collect();
        let (acting, stop, effects) = (None, None, Vec::new());
        Self {
            channels,
            seats,
            acting,
            stop,
            sync_points: 0,
            now: Tag { t: 0, micro: 0, channel: 0 },
            changes: 0,
            napping: ChannelSet::default(),
            judged: ChannelSet::default(),
            moving: ChannelSet::default(),
            moved: Vec::new(),
            shared,
            waits,
            races: None,
            effects,
        }
    }

    fn seat(&mut self, channel: u16) -> Option<&mut Seat> {
        self.seats.get_mut(self.channels.index(channel))
    }

    /// How far a kernel has come.
    pub fn status(&self, channel: u16) -> KernelStatus {
        self.seats.get(self.channels.index(channel)).map_or(KernelStatus::Done, |seat| seat.status)
    }

    /// The last tag of the job, once it has been stopped.
    pub fn stopped(&self) -> Option<Tag> {
        self.stop
    }

    /// The changes since the last call; return the list to [`recycle`](Self::recycle).
    pub fn effects(&mut self) -> Vec<OrderEffect> {
        std::mem::take(&mut self.effects)
    }

    /// Keeps the memory of a list of effects.
    pub fn recycle(&mut self, effects: Vec<OrderEffect>) {
        if self.effects.is_empty() {
            self.effects = effects;
        }
    }

    /// A running kernel has come so far.
    pub fn hear(&mut self, bounds: impl Iterator<Item = i64>) {
        for (seat, bound) in self.seats.iter_mut().zip(bounds) {
            if seat.status == KernelStatus::Running {
                seat.bound = bound;
            }
        }
    }

    /// A running kernel asks for an operation at this tag, or arrives at a wait. Its next [`Wake`] is the answer.
    pub fn request(&mut self, tag: Tag, arriving: Option<WaitingChannel>) {
        let refused = self.stop.is_some_and(|stop| stop < tag);
        let Some(seat) = self.seat(tag.channel) else { return };
        if refused {
            seat.wake = Some(Wake::Stopped);
            return;
        }
        seat.status = KernelStatus::Parked(tag);
        seat.bound = seat.bound.max(tag.t);
        seat.arriving = arriving;
        let bound = seat.bound;
        self.effects.push(OrderEffect::Bound(tag.channel, bound));
    }

    /// Whether nothing has been decided that is not executed yet.
    pub fn has_effects(&self) -> bool {
        !self.effects.is_empty()
    }

    /// A running kernel does nothing before this tag until it is [`back`](Self::back).
    pub fn away(&mut self, tag: Tag) {
        if let Some(seat) = self.seat(tag.channel) {
            seat.status = KernelStatus::Away(tag);
        }
    }

    /// It continues where it was.
    pub fn back(&mut self, channel: u16) {
        if let Some(seat) = self.seat(channel).filter(|seat| matches!(seat.status, KernelStatus::Away(_))) {
            seat.status = KernelStatus::Running;
        }
    }

    /// The answer to a kernel's last request or wait, if it is there.
    pub fn take_wake(&mut self, channel: u16) -> Option<Wake> {
        self.seat(channel)?.wake.take()
    }

    /// The next turn in order, or the end of all waits that no kernel is left to end. Returns the tag that cannot have
    /// its turn yet because running kernels may still act before it.
    pub fn settle(&mut self) -> Option<Tag> {
        while self.acting.is_none() {
            let parked = |seat: &Seat| if let KernelStatus::Parked(tag) = seat.status { Some(tag) } else { None };
            let Some(tag) = self.seats.iter().filter_map(parked).min() else {
                self.end_hopeless();
                return None;
            };
            if !self.is_next(tag) {
                return Some(tag);
            }
            self.now = tag;
            let seat = self.seats.get_mut(self.channels.index(tag.channel))?;
            let arriving = seat.arriving.take();
            if !arriving.is_some_and(|waiting| self.arrive_for(waiting)) {
                self.seat(tag.channel)?.status = KernelStatus::Running;
                self.acting = Some(tag.channel);
                self.wake(tag.channel, Wake::Turn);
            }
        }
        None
    }

    /// Whether no other kernel can act before this tag.
    fn is_next(&self, tag: Tag) -> bool {
        self.seats.iter().zip(self.channels.numbers()).all(|(seat, channel)| {
            *channel == tag.channel
                || match seat.status {
                    KernelStatus::Running => seat.bound > tag.t,
                    KernelStatus::Parked(other) | KernelStatus::Away(other) => other > tag,
                    KernelStatus::Blocked | KernelStatus::Done => true,
                }
        })
    }

    /// Running kernels that may still act before this tag, by index.
    pub fn earlier(&self, tag: Tag) -> impl Iterator<Item = usize> {
        let seats = self.seats.iter().zip(self.channels.numbers()).enumerate();
        let earlier = move |seat: &Seat| seat.status == KernelStatus::Running && seat.bound <= tag.t;
        seats.filter(move |(_, (seat, channel))| **channel != tag.channel && earlier(seat)).map(|(index, _)| index)
    }

    /// Whether the kernel executes blocks, has no turn, and no answer waits for it.
    pub fn is_free(&self, channel: u16) -> bool {
        let seat = self.seats.get(self.channels.index(channel));
        self.acting != Some(channel)
            && seat.is_some_and(|seat| seat.status == KernelStatus::Running && seat.wake.is_none())
    }

    /// The kernel gives its turn back.
    pub fn leave(&mut self, channel: u16) {
        if self.acting == Some(channel) {
            self.acting = None;
        }
    }

    /// The kernel waits until another one resumes it.
    pub fn block(&mut self, channel: u16) {
        self.rest(channel, KernelStatus::Blocked, BLOCKED);
        self.rouse();
    }

    /// The kernel is finished.
    pub fn done(&mut self, channel: u16) {
        self.leave(channel);
        self.rest(channel, KernelStatus::Done, DONE);
        self.rouse();
    }

    fn rest(&mut self, channel: u16, status: KernelStatus, bound: i64) {
        if let Some(seat) = self.seat(channel) {
            if seat.bound < BLOCKED {
                seat.since = seat.bound;
            }
            (seat.status, seat.bound) = (status, bound);
            self.effects.push(OrderEffect::Bound(channel, bound));
        }
    }

    /// Ends the wait of a blocked kernel.
    pub fn resume(&mut self, channel: u16, wake: Wake) {
        if self.moving.has(channel) && !matches!(wake, Wake::Stopped) {
            self.moved.push((channel, wake));
            return;
        }
        if let Some(seat) = self.seat(channel) {
            let t = match &wake {
                Wake::Released { tag, .. }
                | Wake::Alarm { tag, .. }
                | Wake::Started { tag, .. }
                | Wake::Roused { tag, .. } => tag.t,
                // Its actions at its end have their place in the order too.
                Wake::Turn | Wake::Over | Wake::Stopped if seat.status == KernelStatus::Blocked => seat.since,
                Wake::Turn | Wake::Over | Wake::Stopped => seat.bound,
            };
            (seat.status, seat.bound) = (KernelStatus::Running, t);
            self.effects.push(OrderEffect::Bound(channel, t));
            self.wake(channel, wake);
        }
    }

    fn wake(&mut self, channel: u16, wake: Wake) {
        let tag = match &wake {
            Wake::Released { tag, .. }
            | Wake::Alarm { tag, .. }
            | Wake::Started { tag, .. }
            | Wake::Roused { tag, .. } => Some(*tag),
            Wake::Turn | Wake::Over | Wake::Stopped => None,
        };
        if let Some(seat) = self.seat(channel) {
            seat.wake = Some(wake);
            self.effects.push(OrderEffect::Woken(channel, tag));
        }
    }

    /// Stops the job at `tag`: nothing after it happens. All waits end.
    pub fn stop(&mut self, tag: Tag) {
        if self.stop.is_some_and(|stop| stop <= tag) {
            return;
        }
        self.stop = Some(tag);
        self.effects.push(OrderEffect::Stop(tag));
        self.napping = ChannelSet::default();
        for index in 0..self.seats.len() {
            let (Some(seat), Some(&channel)) = (self.seats.get_mut(index), self.channels.numbers().get(index)) else {
                break;
            };
            let after = match seat.status {
                KernelStatus::Parked(other) => other > tag,
                KernelStatus::Blocked => true,
                KernelStatus::Running | KernelStatus::Away(_) | KernelStatus::Done => false,
            };
            if after {
                seat.arriving = None;
                seat.nap = None;
                self.resume(channel, Wake::Stopped);
            }
        }
    }

    /// Lets these kernels continue, except for the one that acts; the number of the sync point.
    pub fn release(&mut self, released: Released, but: Option<u16>) -> u64 {
        let Released { channels, t, micro, by, short } = released;
        self.shared.met(channels.with(by));
        if let Some(races) = &mut self.races {
            races.release(channels, by);
        }
        self.sync_points += 1;
        let part = |(seat, channel): (&Seat, &u16)| seat.status == KernelStatus::Done || channels.has(*channel);
        let all = self.seats.iter().zip(self.channels.numbers()).all(part);
        let sync_point = self.sync_points;
        for channel in channels.iter().filter(|&channel| Some(channel) != but) {
            self.resume(channel, Wake::Released { tag: Tag { t, micro, channel }, sync_point, by, all, short });
        }
        sync_point
    }

    fn release_all(&mut self, released: Vec<Released>) {
        for one in released {
            self.release(one, None);
        }
    }

    /// A channel does something for others, which may continue by that.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn act(&mut self, tag: Tag, act: WaitOp) -> Result<(), String> {
        self.act_with(tag, act, None)
    }

    /// The same; values go with a signal.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn act_with(&mut self, tag: Tag, act: WaitOp, letter: Option<Letter>) -> Result<(), String> {
        let released = self.waits.act_with(tag, act, letter)?;
        if let Some(races) = &mut self.races {
            races.act(tag.channel, act);
        }
        self.release_all(released);
        Ok(())
    }

    /// The program of a channel ends; others may have waited for that.
    pub fn finish(&mut self, tag: Tag, finish: Finish) {
        self.waits.finish(tag.channel, finish);
        if let Some(races) = &mut self.races {
            races.finish(tag.channel);
        }
        let released = self.waits.settle(tag);
        self.release_all(released);
    }

    /// Ends the wait at once if no channel is missing, without a release.
    pub fn pass(&mut self, waiting: &WaitingChannel) -> bool {
        let passes = self.waits.pass(waiting);
        if let Some(races) = self.races.as_mut().filter(|_| passes) {
            races.pass(waiting.tag.channel, &waiting.wait);
        }
        passes
    }

    /// Executes a plain arrival in place of its kernel; `false`: the arrival is not plain.
    fn arrive_for(&mut self, waiting: WaitingChannel) -> bool {
        let Some(arrived) = self.waits.arrive_plainly(waiting) else { return false };
        let channel = waiting.tag.channel;
        if let Some(races) = &mut self.races {
            races.arrive(channel, &waiting.wait);
        }
        self.block(channel);
        match arrived.arrival {
            ArrivalOutcome::Released(released) => {
                self.release(released, None);
            }
            ArrivalOutcome::Blocked | ArrivalOutcome::Mismatch { .. } | ArrivalOutcome::Illegal { .. } => {
                self.effects.push(OrderEffect::Blocked(channel));
            }
        }
        self.release_all(arrived.others);
        true
    }

    /// Ends all waits when nothing can happen any more.
    fn end_hopeless(&mut self) {
        if !self.seats.iter().all(|seat| matches!(seat.status, KernelStatus::Blocked | KernelStatus::Done)) {
            return;
        }
        for index in 0..self.seats.len() {
            let blocked = self.seats.get(index).is_some_and(|seat| seat.status == KernelStatus::Blocked);
            if let Some(&channel) = self.channels.numbers().get(index).filter(|_| blocked) {
                self.resume(channel, Wake::Over);
            }
        }
    }
}
