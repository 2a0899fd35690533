//! The threads and coroutines of a job's kernels, brought into the order of their shared operations.
//!
//! [`Order`] decides which operation may happen next. The coordinator puts it behind one lock; running kernels publish
//! their progress without taking the lock, and waiting kernels are put to sleep and woken. Invariants: an order is
//! changed under the lock only; `need` of a running kernel is at most the time of any parked tag that the kernel may
//! still act before.

mod lifecycle;
mod permits;
mod processor;
#[cfg(all(test, feature = "shuttle"))]
mod schedules;
mod sleep;
pub mod switch;
pub mod turn;
pub mod wait_method;

use crossbeam_channel::Sender;

use crate::channels::Channels;
use crate::locks;
use crate::locks::atomic::Ordering::{Acquire, Relaxed, Release, SeqCst};
use crate::locks::atomic::{AtomicBool, AtomicI64, AtomicU32, AtomicU64};
use crate::locks::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError, spin_loop};
use crate::merge::MergerMessage;
use crate::order::{BLOCKED, Order, OrderEffect};
use crate::shared::SharedState;
use crate::sink::WrittenFiles;
use crate::tag::Tag;
use crate::waits::JobWaits;

/// Tries for the lock before the thread is parked.
const LOCK_TRIES: u32 = 100;

/// Where a job stops that is aborted: before everything.
const ABORT: Tag = Tag { t: i64::MIN, micro: 0, channel: 0 };

/// The job was stopped; the kernel has to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

/// The state of a kernel that other threads see without the lock.
#[repr(align(128))]
struct Slot {
    /// The kernel does nothing before this time.
    bound: AtomicI64,
    /// A parked kernel wants to hear when the bound passes this time.
    need: AtomicI64,
    /// Counts wake-ups; a kernel spins on it before it sleeps.
    signal: AtomicU32,
    /// Its thread sleeps, or is about to; changed under the lock.
    asleep: AtomicBool,
    condvar: Condvar,
    /// The processor it ran on when it last began or ended to wait.
    processor: AtomicU32,
}

/// Everything under the lock.
struct CoordinatorState {
    order: Order,
    /// By kernel: all its events are sent, and it sends none until it is woken.
    flushed: Vec<bool>,
    /// By kernel: the merger knows that its stream is blocked.
    stream_blocked: Vec<bool>,
    permits: usize,
    /// Kernels that wait for a permit, with their bound.
    queue: Vec<(i64, u16)>,
    /// To the merger, if there is one.
    messages: Option<Sender<MergerMessage>>,
}

/// The coordinator of the kernels of one job: the order of their shared operations.
pub struct Coordinator {
    channels: Channels,
    slots: Box<[Slot]>,
    inner: Mutex<CoordinatorState>,
    /// Time of the stop, read by running kernels once per block.
    stop_t: AtomicI64,
    /// Counts when a resume begins to change a bound and when it has.
    resumes: AtomicU64,
    /// Kernels waiting for a permit.
    waiting_permits: AtomicU32,
    /// There is only one kernel: its bound is not read.
    single: AtomicBool,
    /// Fewer permits than kernels.
    limited: bool,
    /// All kernels share the thread of the master.
    one_thread: bool,
    spin: u32,
    /// Future waits that sleep at once, because other programs also want the processors. This changes how a kernel
    /// waits, never the result.
    crowded: AtomicU32,
    /// How many they are the next time; more each time, fewer again when the processors are free.
    crowded_waits: AtomicU32,
}

type Guard<'a> = MutexGuard<'a, CoordinatorState>;

impl CoordinatorState {
    fn send(&self, message: MergerMessage) {
        if let Some(messages) = &self.messages {
            let _ = messages.send(message);
        }
    }
}

/// Cores that this process may use. Asking the system reads files of its control group, so it is asked once.
fn cores() -> usize {
    static CORES: std::sync::OnceLock<usize> = std::sync::OnceLock::new();
    *CORES.get_or_init(|| std::thread::available_parallelism().map_or(1, usize::from))
}

impl Coordinator {
    /// For these channels, of which `threads` may run at once (0 = all).
    pub fn new(
        channels: Channels,
        threads: usize,
        shared: SharedState,
        waits: JobWaits,
        messages: Option<Sender<MergerMessage>>,
    ) -> Self {
        let kernels = channels.count();
        let permits = if threads == 0 { kernels } else { threads.min(kernels) };
        let one_thread = permits <= 1 || cores() == 1;
        // On one thread a kernel runs until it has to wait, so no kernel needs a permit.
        let permits = if one_thread { kernels } else { permits };
        let spin = match () {
            () if one_thread => 0,
            () if permits < kernels || kernels > cores() => sleep::FEW_TURNS,
            () => sleep::TURNS,
        };
        let slot = || Slot {
            bound: AtomicI64::new(0),
            need: AtomicI64::new(i64::MAX),
            signal: AtomicU32::new(0),
            asleep: AtomicBool::new(false),
            condvar: Condvar::new(),
            processor: AtomicU32::new(processor::UNKNOWN),
        };
        Self {
            slots: (0..kernels).map(|_| slot()).collect(),
            inner: Mutex::new(CoordinatorState {
                order: Order::new(channels.clone(), shared, waits),
                flushed: vec![false; kernels],
                stream_blocked: vec![false; kernels],
                permits,
                queue: Vec::new(),
                messages,
            }),
            channels,
            stop_t: AtomicI64::new(i64::MAX),
            resumes: AtomicU64::new(0),
            waiting_permits: AtomicU32::new(0),
            single: AtomicBool::new(false),
            limited: permits < kernels,
            one_thread,
            spin,
            crowded: AtomicU32::new(0),
            crowded_waits: AtomicU32::new(sleep::CROWDED_WAITS),
        }
    }

    /// Only one kernel is going to run.
    pub fn set_single(&self) {
        self.single.store(true, Relaxed);
    }

    /// Whether only one kernel runs.
    pub fn is_single(&self) -> bool {
        self.single.load(Relaxed)
    }

    /// Whether all kernels run on the thread of the master, each until it has to wait.
    pub fn on_one_thread(&self) -> bool {
        self.one_thread
    }

    fn slot(&self, channel: u16) -> Option<&Slot> {
        self.slots.get(self.channels.index(channel))
    }

    /// The lock; a poisoned one is taken over, since every change under it is complete.
    fn lock(&self) -> Guard<'_> {
        // Work under the lock is short: trying for a moment is cheaper than letting the system park a thread.
        for _ in 0..self.spin.min(LOCK_TRIES) {
            match self.inner.try_lock() {
                Ok(guard) => return guard,
                Err(TryLockError::Poisoned(poisoned)) => return poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => spin_loop(),
            }
        }
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The kernel will do nothing before `t`. Returns `false` when the job was stopped before that.
    #[inline(always)]
    pub fn publish(&self, channel: u16, t: i64) -> bool {
        if self.single.load(Relaxed) { t <= self.stop_t.load(Relaxed) } else { self.publish_to_others(channel, t) }
    }

    fn publish_to_others(&self, channel: u16, t: i64) -> bool {
        if let Some(slot) = self.slot(channel) {
            // A kernel that asks at this very moment may see the previous time, and is answered with the next block.
            slot.bound.store(t, Release);
            if t > slot.need.load(Acquire) {
                let mut inner = self.lock();
                slot.need.store(i64::MAX, SeqCst);
                self.settle(&mut inner);
            }
        }
        t <= self.stop_t.load(SeqCst)
    }

    /// No other kernel will act before this time, nor has stopped the job before it; the largest time when all other
    /// kernels have ended. A kernel that is blocked is resumed by this kernel or by one that is not blocked, so the
    /// bound is the least of their times.
    pub fn floor(&self, channel: u16) -> i64 {
        let least = || {
            let others = self.slots.iter().zip(self.channels.numbers()).filter(|(_, other)| **other != channel);
            let (mut least, mut blocked) = (i64::MAX, false);
            for (slot, _) in others {
                match slot.bound.load(SeqCst) {
                    BLOCKED => blocked = true,
                    bound => least = least.min(bound),
                }
            }
            let least = if blocked { least.min(self.bound(channel)) } else { least };
            // A kernel that has stopped the job is done: the stop is looked at after its bound.
            least.min(self.stop_t.load(SeqCst))
        };
        // Between two looks at the bounds a blocked kernel may have continued after the one that resumed it.
        let before = self.resumes.load(SeqCst);
        let floor = least();
        if before.is_multiple_of(2) && self.resumes.load(SeqCst) == before {
            return floor;
        }
        let _inner = self.lock();
        least()
    }

    /// No event of a kernel comes before this time any more, ns.
    pub fn bound(&self, channel: u16) -> i64 {
        self.slot(channel).map_or(i64::MAX, |slot| slot.bound.load(SeqCst))
    }

    /// Whether no other kernel that has something to do is further behind than this one at its clock.
    pub fn is_furthest_behind(&self, channel: u16, clock: i64) -> bool {
        let others = self.channels.numbers().iter().zip(&self.slots).filter(|(other, _)| **other != channel);
        others.map(|(other, slot)| (slot.bound.load(SeqCst), *other)).all(|other| other > (clock, channel))
    }

    /// The files that macros have written, when no kernel runs any more.
    pub fn written(&self) -> WrittenFiles {
        self.lock().order.shared.files.take()
    }

    /// Nothing after this tag belongs to the log. The log of a job that is aborted ends where its kernels do.
    pub fn stop_tag(&self) -> Tag {
        self.lock().order.stopped().filter(|tag| *tag != ABORT).unwrap_or(Tag::END)
    }

    /// The order and its state while no kernel needs its turn for them: before the first and after the last kernel has
    /// run, or for operations in any order.
    pub fn unordered<R>(&self, operation: impl FnOnce(&mut Order) -> R) -> R {
        let mut inner = self.lock();
        let result = operation(&mut inner.order);
        self.apply(&mut inner);
        result
    }

    /// Lets the order take its next steps.
    fn settle(&self, inner: &mut CoordinatorState) {
        // A kernel that this turn resumed has its bound back before bounds are read, or others would act before it.
        self.apply(inner);
        inner.order.hear(self.slots.iter().map(|slot| slot.bound.load(SeqCst)));
        let waiting = inner.order.settle();
        self.apply(inner);
        let Some(tag) = waiting else { return };
        // A kernel that passes the tag at this very moment sees the need with its next block, or settles when it waits
        // or ends.
        for slot in inner.order.earlier(tag).filter_map(|index| self.slots.get(index)) {
            if self.one_thread {
                slot.need.store(tag.t.min(slot.need.load(Relaxed)), Relaxed);
            } else {
                slot.need.fetch_min(tag.t, SeqCst);
            }
        }
    }

    /// Executes the decisions of the order.
    fn apply(&self, inner: &mut CoordinatorState) {
        let mut effects = inner.order.effects();
        if effects.is_empty() {
            return inner.order.recycle(effects);
        }
        self.set_bounds(&effects);
        for effect in effects.drain(..) {
            match effect {
                OrderEffect::Bound(..) => {}
                OrderEffect::Blocked(channel) => self.stream_blocked(inner, channel),
                OrderEffect::Woken(channel, tag) => {
                    let index = self.channels.index(channel);
                    if let Some(flushed) = inner.flushed.get_mut(index) {
                        *flushed = false;
                    }
                    let blocked = inner.stream_blocked.get_mut(index).is_some_and(std::mem::take);
                    if let Some(tag) = tag.filter(|_| blocked) {
                        inner.send(MergerMessage::Resumed(channel, tag));
                    }
                    self.signal(channel);
                }
                OrderEffect::Stop(tag) => {
                    self.stop_t.fetch_min(tag.t, SeqCst);
                    // When a job is aborted, the log ends where its kernels do.
                    if tag != ABORT {
                        inner.send(MergerMessage::StopAt(tag));
                    }
                }
            }
        }
        inner.order.recycle(effects);
    }

    /// Sets the bounds of kernels that continue before the bounds of kernels that block or end. Otherwise a kernel that
    /// looks at this very moment would see no kernel that can still act.
    fn set_bounds(&self, effects: &[OrderEffect]) {
        let bound =
            |effect: &OrderEffect| if let OrderEffect::Bound(channel, t) = *effect { Some((channel, t)) } else { None };
        if self.one_thread {
            // No kernel looks in the meantime.
            effects.iter().filter_map(bound).for_each(|(channel, t)| self.set_bound(channel, t));
            return;
        }
        for (channel, t) in effects.iter().filter_map(bound).filter(|(_, t)| *t < BLOCKED) {
            self.set_bound(channel, t);
        }
        for (at, (channel, t)) in effects.iter().enumerate().filter_map(|(at, effect)| Some((at, bound(effect)?))) {
            let mut later = effects.iter().skip(at + 1).filter_map(bound);
            if t >= BLOCKED && !later.any(|(other, _)| other == channel) {
                self.set_bound(channel, t);
            }
        }
    }

    fn set_bound(&self, channel: u16, t: i64) {
        let Some(slot) = self.slot(channel) else { return };
        if self.one_thread {
            if slot.bound.load(Relaxed) == BLOCKED {
                slot.need.store(i64::MAX, Relaxed);
            }
            slot.bound.store(t, Relaxed);
        } else if slot.bound.load(SeqCst) == BLOCKED {
            self.resumes.fetch_add(1, SeqCst);
            slot.bound.store(t, SeqCst);
            self.resumes.fetch_add(1, SeqCst);
            slot.need.store(i64::MAX, SeqCst);
        } else {
            slot.bound.store(t, SeqCst);
        }
    }

    /// The kernel is blocked: the merger hears of it once all events up to here are sent.
    fn stream_blocked(&self, inner: &mut CoordinatorState, channel: u16) {
        let index = self.channels.index(channel);
        if inner.flushed.get(index) == Some(&true) {
            inner.send(MergerMessage::Blocked(channel));
            if let Some(blocked) = inner.stream_blocked.get_mut(index) {
                *blocked = true;
            }
        }
    }
}

#[cfg(all(test, not(feature = "shuttle")))]
mod tests {
    use super::*;
    use crate::testing::waits;

    #[test]
    fn nobody_seems_later_than_who_can_resume_a_blocked_one() {
        let core = Coordinator::new(Channels::new(1..=3), 0, SharedState::default(), waits(3), None);
        assert!(core.publish(1, 1000) && core.publish(3, 40));
        core.unordered(|order| order.block(2));
        // Channel 3 can resume channel 2 at 40, and channel 2 can stop the job then.
        assert_eq!((core.floor(1), core.floor(3), core.floor(2)), (40, 40, 40));
        assert!(core.publish(3, 2000));
        assert_eq!((core.floor(1), core.floor(3)), (1000, 1000));
        core.done(1, |_| ());
        assert_eq!(core.floor(3), 2000);
    }

    #[test]
    fn whoever_is_resumed_has_a_bound_before_who_resumed_it_has_none() {
        let core = Coordinator::new(Channels::new(1..=2), 0, SharedState::default(), waits(2), None);
        assert!(core.publish(1, 50));
        core.unordered(|order| order.block(2));
        core.set_bounds(&[OrderEffect::Bound(1, BLOCKED), OrderEffect::Bound(1, 60), OrderEffect::Bound(2, 60)]);
        assert_eq!((core.bound(1), core.bound(2)), (60, 60));
        core.set_bounds(&[OrderEffect::Bound(2, 70), OrderEffect::Bound(2, BLOCKED)]);
        assert_eq!(core.bound(2), BLOCKED);
    }
}
