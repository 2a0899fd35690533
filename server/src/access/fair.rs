//! Turns of identities: beside others, an identity has only a few short calls in hand; the rest of them waits.
//!
//! A caller alone has no limit. Beside others it would precede them in every queue of the server, first of all in the
//! commits of the ledger: the calls of others would wait for as many of its calls as it has callers. An identity may
//! have as many calls in progress as the least demanding of the others, so two that are equally busy do not limit each
//! other. A call that lasts counts while its data flow: one that waits for a job or a client takes no processor time and
//! no turn. *Invariants:* an identity with fewer than [`FEW`] calls in progress never waits, regardless of others; one
//! that waits has calls in progress, so its turn comes; a call that is abandoned leaves its place to the next.

use std::collections::{HashMap, VecDeque};
use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;

use super::Identity;

/// Short calls that an identity may have in hand in any case.
const FEW: usize = 4;
/// Time for which an identity counts as calling after its last call.
const LINGER: Duration = Duration::from_millis(250);

/// Most bytes of a message that says only that the server is alive.
const HEARTBEAT: usize = 1024;

/// Between two looks at the jobs of others, whose lock is a busy one.
const LOOK: Duration = Duration::from_millis(20);

/// The caller.
#[derive(Default)]
pub(crate) struct Fair(Arc<All>);

/// Whether jobs of other tenants than this one wait or run.
pub(crate) type OthersWork = Box<dyn Fn(&str) -> bool + Send + Sync>;

#[derive(Default)]
struct All {
    callers: Mutex<HashMap<Arc<Identity>, Own>>,
    others_work: OnceLock<OthersWork>,
}

impl Debug for Fair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fair").finish_non_exhaustive()
    }
}

/// Calls of an identity.
#[derive(Debug)]
struct Own {
    /// Short calls in hand.
    active: usize,
    waiting: VecDeque<oneshot::Sender<Turn>>,
    /// When it called last.
    at: Instant,
    /// Whether jobs of other tenants wait or run, and until when that is believed.
    others_work: Option<(bool, Instant)>,
}

impl Own {
    fn idle(&self) -> bool {
        self.active == 0 && self.waiting.is_empty()
    }
}

/// A short call in hand, until it is dropped.
#[derive(Debug)]
pub(crate) struct Turn(Part);

/// A call that lasts: its identity counts as calling while its data flow.
#[derive(Debug, Clone)]
pub(crate) struct Stay {
    part: Arc<Part>,
    /// When the identity was counted last.
    at: Arc<Mutex<Instant>>,
}

struct Part {
    all: Arc<All>,
    identity: Arc<Identity>,
}

impl Debug for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Part").field(&self.identity).finish()
    }
}

type Callers = HashMap<Arc<Identity>, Own>;

/// Most short calls that an identity may have in hand now.
fn most(callers: &mut Callers, identity: &Arc<Identity>, now: Instant) -> usize {
    callers.retain(|_, own| !own.idle() || now.saturating_duration_since(own.at) < LINGER);
    let others = callers.iter().filter(|(other, _)| *other != identity);
    others.map(|(_, own)| own.active + own.waiting.len()).min().map_or(usize::MAX, |least| least.max(FEW))
}

impl All {
    fn lock(&self) -> MutexGuard<'_, Callers> {
        self.callers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether an identity may take another short call in hand.
    fn may(&self, callers: &mut Callers, identity: &Arc<Identity>, now: Instant) -> bool {
        let active = callers.get(identity).map_or(0, |own| own.active);
        active < FEW || active < most(callers, identity, now) && !self.others_work(callers, identity, now)
    }

    /// Whether jobs of other tenants wait or run, or did a moment ago.
    fn others_work(&self, callers: &mut Callers, identity: &Arc<Identity>, now: Instant) -> bool {
        let Some(others_work) = self.others_work.get() else { return false };
        let Some(own) = callers.get_mut(identity) else { return false };
        match own.others_work {
            Some((work, until)) if now < until => work,
            _ => {
                let work = others_work(&identity.tenant);
                own.others_work = Some((work, now + LOOK));
                work
            }
        }
    }
}

/// The entry of an identity that calls now.
fn called<'a>(callers: &'a mut Callers, identity: &Arc<Identity>, now: Instant) -> &'a mut Own {
    let new = || Own { active: 0, waiting: VecDeque::new(), at: now, others_work: None };
    let own = callers.entry(identity.clone()).or_insert_with(new);
    own.at = now;
    own
}

impl Fair {
    /// Lets the jobs of others count, too.
    pub(crate) fn mind(&self, others_work: OthersWork) {
        let _ = self.0.others_work.set(others_work);
    }

    /// The turn of a short call, or where it comes.
    fn ask(&self, identity: &Arc<Identity>, now: Instant) -> Result<Turn, oneshot::Receiver<Turn>> {
        let mut callers = self.0.lock();
        let may = self.0.may(&mut callers, identity, now);
        let own = called(&mut callers, identity, now);
        if may {
            own.active += 1;
            return Ok(Turn(Part { all: self.0.clone(), identity: identity.clone() }));
        }
        let (send, receive) = oneshot::channel();
        own.waiting.push_back(send);
        Err(receive)
    }

    /// Waits for the turn of a short call, and says so with `waits`. `None` never comes up: a call that waits has
    /// others of its identity in hand before it.
    pub(crate) async fn turn(&self, identity: &Arc<Identity>, waits: impl FnOnce()) -> Option<Turn> {
        match self.ask(identity, Instant::now()) {
            Ok(turn) => Some(turn),
            Err(comes) => {
                waits();
                comes.await.ok()
            }
        }
    }

    /// Counts a call that lasts, whose request has come.
    pub(crate) fn stay(&self, identity: &Arc<Identity>) -> Stay {
        let now = Instant::now();
        called(&mut self.0.lock(), identity, now);
        let part = Arc::new(Part { all: self.0.clone(), identity: identity.clone() });
        Stay { part, at: Arc::new(Mutex::new(now)) }
    }
}

impl Stay {
    /// Data of the call flow. A heartbeat has few bytes and is no work.
    pub(crate) fn flows(&self, bytes: usize, now: Instant) {
        let mut at = self.at.lock().unwrap_or_else(PoisonError::into_inner);
        if bytes > HEARTBEAT && now.saturating_duration_since(*at) >= LINGER / 4 {
            *at = now;
            called(&mut self.part.all.lock(), &self.part.identity, now);
        }
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        let Part { all, identity } = &self.0;
        let mut unwanted = Vec::new();
        let mut callers = all.lock();
        let now = Instant::now();
        if let Some(own) = callers.get_mut(identity) {
            own.active = own.active.saturating_sub(1);
        }
        while callers.get(identity).is_some_and(|own| !own.waiting.is_empty()) && all.may(&mut callers, identity, now) {
            let Some(own) = callers.get_mut(identity) else { break };
            let Some(next) = own.waiting.pop_front().filter(|next| !next.is_closed()) else { continue };
            own.active += 1;
            let turn = Turn(Part { all: all.clone(), identity: identity.clone() });
            unwanted.extend(next.send(turn).err());
        }
        // Turns that came too late are given back without the lock.
        drop(callers);
        drop(unwanted);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Role;
    use super::*;

    fn identity(name: &str) -> Arc<Identity> {
        Arc::new(Identity { name: name.into(), tenant: format!("of {name}"), role: Role::Submit })
    }

    fn in_hand(fair: &Fair, identity: &Arc<Identity>, calls: usize) -> (Vec<Turn>, Vec<oneshot::Receiver<Turn>>) {
        let (mut turns, mut waiting) = (Vec::new(), Vec::new());
        for _ in 0..calls {
            match fair.ask(identity, Instant::now()) {
                Ok(turn) => turns.push(turn),
                Err(comes) => waiting.push(comes),
            }
        }
        (turns, waiting)
    }

    #[test]
    fn alone_nobody_waits_and_beside_another_a_flood_has_a_few_calls_in_hand() {
        let (fair, noisy, quiet) = (Fair::default(), identity("noisy"), identity("quiet"));
        let (turns, waiting) = in_hand(&fair, &noisy, 64);
        assert_eq!((turns.len(), waiting.len()), (64, 0));
        let own = fair.ask(&quiet, Instant::now()).expect("it has no call in hand");
        let (more, mut waiting) = in_hand(&fair, &noisy, 10);
        assert_eq!((more.len(), waiting.len()), (0, 10));
        // Those in hand end; one by one the others follow, never more than a few at once.
        drop(turns);
        let mut first: Vec<Turn> = waiting.iter_mut().filter_map(|comes| comes.try_recv().ok()).collect();
        assert_eq!(first.len(), FEW);
        first.pop();
        waiting.drain(..FEW);
        assert!(waiting[0].try_recv().is_ok(), "in the order in which they came");
        drop(own);
    }

    #[test]
    fn two_that_are_equally_busy_do_not_limit_each_other_and_a_third_limits_both() {
        let (fair, one, other) = (Fair::default(), identity("one"), identity("other"));
        let (_first, _) = in_hand(&fair, &one, 20);
        let (second, _) = in_hand(&fair, &other, 30);
        assert_eq!(second.len(), 20);
        let third = fair.ask(&identity("third"), Instant::now());
        let (more, waiting) = in_hand(&fair, &one, 1);
        assert_eq!((more.len(), waiting.len()), (0, 1));
        drop(third);
    }

    #[test]
    fn calls_that_are_given_up_leave_their_place_to_the_next() {
        let (fair, noisy) = (Fair::default(), identity("noisy"));
        let _quiet = fair.ask(&identity("quiet"), Instant::now());
        let (mut turns, mut waiting) = in_hand(&fair, &noisy, FEW + 3);
        drop(waiting.drain(..2));
        turns.pop();
        assert!(waiting[0].try_recv().is_ok());
        // A turn that comes while its call is given up is not lost.
        let (_, late) = in_hand(&fair, &noisy, 2);
        drop((turns, late));
        let (again, _) = in_hand(&fair, &noisy, FEW + 1);
        assert_eq!(again.len(), FEW);
        drop(again);
        assert_eq!(fair.0.lock().get(&noisy).unwrap().active, 0);
    }

    #[test]
    fn a_call_that_lasts_counts_while_its_data_flow() {
        let (fair, noisy, quiet) = (Fair::default(), identity("noisy"), identity("quiet"));
        let stay = fair.stay(&quiet);
        let may = |at| {
            let turns: Vec<_> = (0..FEW + 3).map_while(|_| fair.ask(&noisy, at).ok()).collect();
            turns.len()
        };
        let mut now = Instant::now();
        assert_eq!(may(now), FEW, "it has just come");
        now += LINGER;
        assert_eq!(may(now), FEW + 3, "it waits");
        stay.flows(HEARTBEAT, now);
        assert_eq!(may(now), FEW + 3, "a heartbeat");
        stay.flows(HEARTBEAT + 1, now);
        assert_eq!(may(now), FEW, "events");
        assert_eq!(may(now + LINGER), FEW + 3, "it waits again");
    }

    #[test]
    fn jobs_of_others_count_and_those_who_have_left_do_not() {
        let (fair, noisy, quiet) = (Fair::default(), identity("noisy"), identity("quiet"));
        drop(fair.ask(&quiet, Instant::now()));
        let later = Instant::now() + LINGER;
        let alone: Vec<_> = (0..10).map(|_| fair.ask(&noisy, later)).collect();
        assert!(alone.iter().all(Result::is_ok));
        drop(alone);
        fair.mind(Box::new(|tenant| tenant != "of quiet"));
        let (turns, _) = in_hand(&fair, &noisy, 10);
        assert_eq!(turns.len(), FEW, "a job of the other tenant runs");
    }
}
