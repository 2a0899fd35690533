//! Shared operations in tag order, waiting, and the end of everything.
//!
//! Each kernel publishes a lower bound of its future tags once per block. A kernel that wants a shared operation
//! parks until no running kernel can still come before its tag. Invariants: a shared operation runs under the lock
//! with the smallest tag of all that are still possible; a blocked kernel wakes only by a shared operation of
//! another one; `need` of a running kernel is at most the time of any parked tag it still stands before.

mod ends;
mod enter;
pub(crate) mod meet;
mod pair;
mod permits;
mod sleep;
pub(crate) mod switch;

use std::sync::atomic::{
    AtomicBool, AtomicI64, AtomicU32, AtomicU64,
    Ordering::{Acquire, Relaxed, Release, SeqCst},
};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crossbeam_channel::Sender;

use super::merge::Message;
use super::ranks::Ranks;
use super::shared::Shared;
use super::tag::Tag;
use super::waits::{Waiting, Waits};
use crate::job::WrittenFiles;

/// Where a kernel stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    /// Executing; its bound is in its slot.
    Running,
    /// Wants a shared operation.
    Parked(Tag),
    /// Stands at a meeting point.
    Blocked,
    /// Finished in whatever way.
    Done,
}

/// Why a kernel was woken from a wait.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Wake {
    /// The meeting took place; go on at this tag.
    Released {
        /// Where to go on.
        tag: Tag,
        /// Ordinal of the meeting.
        meeting: u64,
    },
    /// The control raised an alarm for this wait.
    Alarm {
        /// When.
        tag: Tag,
        /// Text of the alarm.
        text: String,
    },
    /// Everything has stopped; this wait will never end.
    Over,
    /// The job was stopped.
    Stopped,
}

/// Tries for the lock before the thread is parked.
const LOCK_TRIES: u32 = 100;
/// Bound of a kernel that stands at a meeting.
const STANDS: i64 = i64::MAX - 1;
/// Bound of a kernel that is done.
const DONE: i64 = i64::MAX;

/// The job was stopped; the kernel has to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stopped;

#[repr(align(128))]
struct Slot {
    /// The kernel does nothing before this time; [`STANDS`] or [`DONE`] when it does not run.
    bound: AtomicI64,
    need: AtomicI64,
    /// Counts wake-ups; a kernel spins on it before it sleeps.
    signal: AtomicU32,
    /// Its thread sleeps, or is about to; changed under the lock.
    asleep: AtomicBool,
    condvar: Condvar,
}

/// Everything under the lock.
pub(crate) struct Inner {
    ranks: Ranks,
    status: Vec<Status>,
    wakes: Vec<Option<Wake>>,
    /// Arrivals of parked kernels that anybody may carry out in their place.
    arriving: Vec<Option<Waiting>>,
    /// The merger has been told that the stream is blocked.
    told: Vec<bool>,
    pub(crate) shared: Shared,
    pub(crate) waits: Waits,
    /// A verdict has been given.
    pub(crate) judged: bool,
    stop: Option<Tag>,
    permits: usize,
    /// Kernels that wait for a permit, with their bound.
    queue: Vec<(i64, u16)>,
    /// To the merger, if there is one.
    messages: Option<Sender<Message>>,
}

/// The meeting place of the kernels of one job.
pub(crate) struct Coordinator {
    ranks: Ranks,
    slots: Box<[Slot]>,
    inner: Mutex<Inner>,
    /// Where the only two kernels of a job meet.
    pair: pair::Pair,
    /// Meetings so far, but for those of a pair since; changed under the lock.
    meetings: AtomicU64,
    /// Time from the last arrival to the release, ns.
    release_ns: i64,
    /// Time of the stop, read by running kernels once per block.
    stop_t: AtomicI64,
    /// Counts when a resume begins to change a bound and when it has.
    resumes: AtomicU64,
    /// Kernels waiting for a permit.
    waiting_permits: AtomicU32,
    /// One kernel is all there is: nobody looks at its bound.
    single: AtomicBool,
    /// Fewer permits than kernels.
    limited: bool,
    /// All kernels share the thread of the master.
    one_thread: bool,
    spin: u32,
    /// Waits to come that sleep at once, because other programs want the processors too. It says how to wait, never what
    /// comes out.
    crowded: AtomicU32,
}

/// Lock of a shared operation that may run now.
pub(crate) type Guard<'a> = MutexGuard<'a, Inner>;

impl Inner {
    fn status(&self, rank: u16) -> Status {
        self.status.get(self.ranks.index(rank)).copied().unwrap_or(Status::Done)
    }

    fn set(&mut self, rank: u16, status: Status) {
        if let Some(slot) = self.status.get_mut(self.ranks.index(rank)) {
            *slot = status;
        }
    }

    fn take_wake(&mut self, rank: u16) -> Option<Wake> {
        self.wakes.get_mut(self.ranks.index(rank)).and_then(Option::take)
    }

    fn tell(&self, message: Message) {
        if let Some(messages) = &self.messages {
            let _ = messages.send(message);
        }
    }

    /// No other kernel runs or is about to act.
    pub(crate) fn alone(&self, rank: u16) -> bool {
        self.status
            .iter()
            .zip(self.ranks.numbers())
            .all(|(s, &r)| r == rank || matches!(s, Status::Blocked | Status::Done))
    }

    /// Nothing runs, nothing is parked: whoever is blocked stays blocked.
    fn quiet(&self) -> bool {
        self.status.iter().all(|s| matches!(s, Status::Blocked | Status::Done))
    }
}

impl Coordinator {
    /// For these channels, of which `threads` may run at once (0 = all).
    pub(crate) fn new(
        ranks: Ranks,
        threads: usize,
        shared: Shared,
        waits: Waits,
        messages: Option<Sender<Message>>,
    ) -> Self {
        let (release_ns, kernels) = (waits.release_ns(), ranks.len());
        let permits = if threads == 0 { kernels } else { threads.min(kernels) };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let one_thread = permits <= 1 || cores == 1;
        // On one thread a kernel runs until it has to wait, so nobody needs a permit.
        let permits = if one_thread { kernels } else { permits };
        Self {
            ranks: ranks.clone(),
            slots: (0..kernels)
                .map(|_| Slot {
                    bound: AtomicI64::new(0),
                    need: AtomicI64::new(i64::MAX),
                    signal: AtomicU32::new(0),
                    asleep: AtomicBool::new(false),
                    condvar: Condvar::new(),
                })
                .collect(),
            inner: Mutex::new(Inner {
                ranks,
                status: vec![Status::Running; kernels],
                wakes: vec![None; kernels],
                arriving: vec![None; kernels],
                told: vec![false; kernels],
                shared,
                waits,
                judged: false,
                stop: None,
                permits,
                queue: Vec::new(),
                messages,
            }),
            pair: pair::Pair::default(),
            meetings: AtomicU64::new(0),
            release_ns,
            stop_t: AtomicI64::new(i64::MAX),
            resumes: AtomicU64::new(0),
            waiting_permits: AtomicU32::new(0),
            single: AtomicBool::new(false),
            limited: permits < kernels,
            one_thread,
            spin: if one_thread { 0 } else { 150 },
            crowded: AtomicU32::new(0),
        }
    }

    /// Only one kernel is going to run.
    pub(crate) fn set_single(&self) {
        self.single.store(true, Relaxed);
    }

    /// All kernels run on the thread of the master, each until it has to wait.
    pub(crate) fn on_one_thread(&self) -> bool {
        self.one_thread
    }

    /// Whether only one kernel runs.
    pub(crate) fn is_single(&self) -> bool {
        self.single.load(Relaxed)
    }

    fn slot(&self, rank: u16) -> Option<&Slot> {
        self.slots.get(self.ranks.index(rank))
    }

    /// The lock; a poisoned one is taken over, since every change under it is complete.
    pub(crate) fn lock(&self) -> Guard<'_> {
        // What is done under the lock is short: trying for a moment is cheaper than letting the system park a thread.
        for _ in 0..self.spin.min(LOCK_TRIES) {
            match self.inner.try_lock() {
                Ok(guard) => return guard,
                Err(std::sync::TryLockError::Poisoned(poisoned)) => return poisoned.into_inner(),
                Err(std::sync::TryLockError::WouldBlock) => std::hint::spin_loop(),
            }
        }
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The kernel will do nothing before `t`. Returns `false` when the job was stopped before that.
    #[inline]
    pub(crate) fn publish(&self, rank: u16, t: i64) -> bool {
        if self.single.load(Relaxed) {
            return t <= self.stop_t.load(Relaxed);
        }
        if let Some(slot) = self.slot(rank) {
            // Whoever asks at this very moment may see the time before this one, and is answered one block later.
            slot.bound.store(t, Release);
            if t > slot.need.load(Acquire) {
                let mut inner = self.lock();
                slot.need.store(i64::MAX, SeqCst);
                self.wake_parked(&mut inner);
            }
        }
        t <= self.stop_t.load(SeqCst)
    }

    /// Waits for the merger to give chunks back. Meanwhile a running kernel counts as parked at `tag`: it will do
    /// nothing before that, and whoever stands before it may go, which is what lets the merger move on. A kernel
    /// that is already blocked at a meeting holds nobody back and keeps its status.
    pub(crate) fn wait_credit<R>(&self, tag: Tag, wait: impl FnOnce() -> R) -> R {
        let running = {
            let mut inner = self.lock();
            let running = inner.status(tag.rank) == Status::Running;
            if running {
                inner.set(tag.rank, Status::Parked(tag));
            }
            if self.limited {
                self.release_permit(&mut inner);
            }
            self.wake_parked(&mut inner);
            running
        };
        let result = wait();
        let mut inner = self.acquire_permit(tag.rank, self.lock());
        if running {
            inner.set(tag.rank, Status::Running);
        }
        self.wake_parked(&mut inner);
        result
    }

    /// No other kernel will do anything before this time, nor has stopped the job before it; the largest time when
    /// all the others are done. A kernel that stands can only be let go by this one, so it holds at this one's time.
    pub(crate) fn floor(&self, rank: u16) -> i64 {
        let least = || {
            let others = self.slots.iter().zip(self.ranks.numbers()).filter(|(_, other)| **other != rank);
            let least = others.map(|(slot, _)| slot.bound.load(SeqCst)).min().unwrap_or(i64::MAX);
            let least = if least == STANDS { self.bound(rank) } else { least };
            // A kernel that has stopped the job is done: the stop is looked at after its bound.
            least.min(self.stop_t.load(SeqCst))
        };
        // Between two looks at the bounds a kernel that stood may have gone on behind the one that let it go.
        let before = self.resumes.load(SeqCst);
        let floor = least();
        if before.is_multiple_of(2) && self.resumes.load(SeqCst) == before {
            return floor;
        }
        let _inner = self.lock();
        least()
    }

    /// The files that macros have written, when no kernel runs any more.
    pub(crate) fn written(&self) -> WrittenFiles {
        self.lock().shared.files.take()
    }

    /// Nothing after this tag belongs to the log.
    pub(crate) fn stop_tag(&self) -> Tag {
        self.lock().stop.unwrap_or(Tag::END)
    }

    pub(crate) fn bound(&self, rank: u16) -> i64 {
        self.slot(rank).map_or(i64::MAX, |s| s.bound.load(SeqCst))
    }

    /// No other kernel can still act before `tag`.
    fn eligible(&self, inner: &Inner, tag: Tag) -> bool {
        inner.status.iter().zip(&self.slots).zip(self.ranks.numbers()).all(|((status, slot), rank)| {
            *rank == tag.rank
                || match status {
                    Status::Running => slot.bound.load(SeqCst) > tag.t,
                    Status::Parked(other) => *other > tag,
                    Status::Blocked | Status::Done => true,
                }
        })
    }

    /// Asks every running kernel that still stands before `tag` to report when it has passed it.
    fn ask(&self, inner: &Inner, tag: Tag) {
        for ((status, slot), rank) in inner.status.iter().zip(&self.slots).zip(self.ranks.numbers()) {
            if *rank != tag.rank && *status == Status::Running && slot.bound.load(SeqCst) <= tag.t {
                slot.need.fetch_min(tag.t, SeqCst);
            }
        }
    }

    /// Wakes the kernel with the smallest parked tag if it may go; else makes sure it will hear of it. What it came
    /// for is carried out in its place if that is a plain arrival.
    fn wake_parked(&self, inner: &mut Inner) {
        loop {
            let parked =
                inner.status.iter().filter_map(|s| if let Status::Parked(tag) = s { Some(*tag) } else { None });
            let Some(tag) = parked.min() else { return };
            self.ask(inner, tag);
            if !self.eligible(inner, tag) {
                return;
            }
            if inner.stop.is_some() || !self.arrive_for(inner, tag) {
                self.signal(tag.rank);
                return;
            }
        }
    }

    /// Ends a shared operation: tells parked kernels that this one goes on.
    pub(crate) fn leave(&self, inner: &mut Inner) {
        self.wake_parked(inner);
    }
}
