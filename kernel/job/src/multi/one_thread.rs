//! All kernels of a job on the thread of its master, in turns.
//!
//! A kernel runs until it has to wait for another kernel; then the kernel that is furthest behind in simulated time
//! continues. So a wait costs a change of stacks, regardless of the load of the processors, and a job never needs more
//! than one of them. Invariant: one kernel runs at a time, and a kernel that waits for a signal does not run before it
//! has the signal.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use corosensei::stack::DefaultStack;
use corosensei::{CoroutineResult, ScopedCoroutine, ScopedCoroutineRef, Yielder};

use super::coordinator::Coordinator;
use super::coordinator::wait_method::{WaitMethod, YieldReason};
use super::merge::{Feeder, Returned};
use super::stream::EventStream;
use super::{Assembly, Feeds, KernelStart};
use crate::step::{Director, KernelCandidate};
use counterpoint_emulator::channel::carried::Lived;
use counterpoint_emulator::channel::step::common;

/// Bytes of the stack of a kernel without macros, those of a thread of its own.
const STACK: usize = 2 << 20;

/// Result of a kernel that has ended.
type End = std::thread::Result<Lived>;

/// A kernel in turns.
struct KernelCoroutine<'s> {
    channel: u16,
    coroutine: ScopedCoroutineRef<'s, (), YieldReason, End, DefaultStack>,
    /// Why it does not run; nothing before its first turn.
    pause: Option<YieldReason>,
    /// Chunks that the merger has given back, if there is a log.
    returned: Option<Returned>,
}

impl KernelCoroutine<'_> {
    /// Whether it waits for a chunk that has not come back.
    fn is_far_ahead(&self) -> bool {
        self.pause == Some(YieldReason::Chunk) && !self.returned.as_ref().is_some_and(Returned::any)
    }
}

/// A kernel that has not begun.
type Begin<'k> = (u16, Option<Returned>, ScopedCoroutine<'k, (), YieldReason, End, DefaultStack>);

/// Starts all kernels, each within the scope of those before it, and runs them to their end.
fn scoped<'k>(
    mut rest: impl Iterator<Item = Begin<'k>>,
    turns: Vec<KernelCoroutine<'_>>,
    scheduler: &mut Scheduler<'_>,
) -> Vec<End> {
    match rest.next() {
        Some((channel, returned, coroutine)) => coroutine.scope(|coroutine| {
            // The earlier kernels live longer than this one.
            let mut turns = turns;
            turns.push(KernelCoroutine { channel, coroutine, pause: None, returned });
            scoped(rest, turns, scheduler)
        }),
        None => scheduler.take_turns(turns),
    }
}

/// Gives the thread to one kernel after the other.
struct Scheduler<'s> {
    coordinator: &'s Coordinator,
    /// Chooses the next kernel in a job with stepping; and the names of GLOBALs.
    director: Option<(&'s Director<'s>, &'s [String])>,
    /// The work whenever no kernel runs.
    between: &'s mut dyn FnMut(),
}

impl Scheduler<'_> {
    /// Runs the kernels until all have ended.
    fn take_turns(&mut self, mut turns: Vec<KernelCoroutine<'_>>) -> Vec<End> {
        let mut ends = Vec::new();
        while let Some(next) = self.next_turn(&turns) {
            let Some(turn) = turns.get_mut(next) else { break };
            match turn.coroutine.resume(()) {
                CoroutineResult::Yield(pause) => turn.pause = Some(pause),
                CoroutineResult::Return(end) => {
                    ends.push(end);
                    turns.swap_remove(next);
                }
            }
            (self.between)();
        }
        ends
    }

    /// The next kernel: of those with work the one that is furthest behind, or the kernel that the operator selects. A
    /// kernel whose chunks have not come back is last: the others let the merger advance. `None`: all have ended.
    fn next_turn(&self, turns: &[KernelCoroutine<'_>]) -> Option<usize> {
        let coordinator = self.coordinator;
        let ready =
            |turn: &KernelCoroutine<'_>| turn.pause != Some(YieldReason::Sleep) || !coordinator.sleeps(turn.channel);
        if let Some((director, globals)) = self.director {
            let candidate = |turn: &KernelCoroutine<'_>| KernelCandidate {
                channel: turn.channel,
                ready: ready(turn),
                far_ahead: turn.is_far_ahead(),
                bound: coordinator.bound(turn.channel),
            };
            let candidates: Vec<_> = turns.iter().map(candidate).collect();
            let mut common = || coordinator.unordered(|order| common(&order.shared, globals));
            if let Some(next) = director.next(&candidates, &mut common) {
                return Some(next);
            }
        }
        let order = |turn: &KernelCoroutine<'_>| (turn.is_far_ahead(), coordinator.bound(turn.channel), turn.channel);
        let next = |turns: &[KernelCoroutine<'_>]| {
            let able = turns.iter().enumerate().filter(|(_, turn)| ready(turn));
            able.min_by_key(|(_, turn)| order(turn)).map(|(at, _)| at)
        };
        next(turns).or_else(|| {
            // All remaining kernels sleep, which must not happen: stop the job instead of hanging.
            (!turns.is_empty()).then(|| coordinator.abort());
            next(turns)
        })
    }
}

impl<'a> Assembly<'a> {
    /// Runs the kernels in turns; `between` is called whenever none of them runs.
    pub(super) fn in_turns(self, work: Vec<(KernelStart<'_>, Feeds<'_>)>, mut between: impl FnMut()) -> Vec<Lived> {
        let mut coroutines = Vec::new();
        for (start, feeds) in work {
            let number = start.channel.number;
            let stack = if self.job.has_macros() { counterpoint_channel::macros::STACK } else { STACK };
            let Ok(stack) = DefaultStack::new(stack) else {
                // The operating system refuses the memory: the job cannot be run and counts as cancelled.
                self.control.cancel();
                self.coordinator.done(number, |_| ());
                continue;
            };
            let returned = feeds.1.as_ref().map(Feeder::returned);
            // The initial data of a coroutine must be small.
            let begin = Box::new((start, feeds));
            let body = move |yielder: &Yielder<(), YieldReason>, ()| {
                let life = catch_unwind(AssertUnwindSafe(|| {
                    let (start, (backlog, feeder)) = *begin;
                    let (kernel, at, reset) =
                        self.started(start, EventStream::new(backlog, feeder), WaitMethod::Coroutine(yielder));
                    kernel.live(at, reset)
                }));
                if life.is_err() {
                    self.coordinator.abort();
                    self.coordinator.done(number, |_| ());
                }
                life
            };
            coroutines.push((number, returned, ScopedCoroutine::with_stack(stack, body)));
        }
        let mut lived = Vec::new();
        let mut panic = None;
        let globals = self.job.macros().map_or(&[][..], |program| &program.globals);
        let director = self.director.map(|director| (director, globals));
        let mut scheduler = Scheduler { coordinator: self.coordinator, director, between: &mut between };
        for end in scoped(coroutines.into_iter(), Vec::new(), &mut scheduler) {
            match end {
                Ok(one) => lived.push(one),
                Err(payload) => panic = Some(payload),
            }
        }
        // A mistake of this program: the job's owner gets it, after all kernels have ended.
        if let Some(payload) = panic {
            resume_unwind(payload);
        }
        lived.sort_by_key(|one| one.channel);
        lived
    }
}
