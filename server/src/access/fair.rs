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
    callers: Mutex<HashMap<Arc<Identity>, IdentityCalls>>,
    others_work: OnceLock<OthersWork>,
}

impl Debug for Fair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fair").finish_non_exhaustive()
    }
}

/// Calls of an identity.
#[derive(Debug)]
struct IdentityCalls {
    /// Short calls in hand.
    active: usize,
    waiting: VecDeque<oneshot::Sender<CallTurn>>,
    /// When it called last.
    at: Instant,
    /// Whether jobs of other tenants wait or run, and until when that is believed.
    others_work: Option<(bool, Instant)>,
}

impl IdentityCalls {
    fn idle(&self) -> bool {
        self.active == 0 && self.waiting.is_empty()
    }
}

/// A short call in hand, until it is dropped.
#[derive(Debug)]
pub(crate) struct CallTurn(IdentityHandle);

/// A call that lasts: its identity counts as calling while its data flow.
#[derive(Debug, Clone)]
pub(crate) struct LongCall {
    part: Arc<IdentityHandle>,
    /// When the identity was counted last.
    at: Arc<Mutex<Instant>>,
}

struct IdentityHandle {
    all: Arc<All>,
    identity: Arc<Identity>,
}

impl Debug for IdentityHandle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("IdentityHandle").field(&self.identity).finish()
    }
}

type Callers = HashMap<Arc<Identity>, IdentityCalls>;

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
fn called<'a>(callers: &'a mut Callers, identity: &Arc<Identity>, now: Instant) -> &'a mut IdentityCalls {
    let new = || IdentityCalls { active: 0, waiting: VecDeque::new(), at: now, others_work: None };
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
    fn ask(&self, identity: &Arc<Identity>, now: Instant) -> Result<CallTurn, oneshot::Receiver<CallTurn>> {
        let mut callers = self.0.lock();
        let may = self.0.may(&mut callers, identity, now);
        let own = called(&mut callers, identity, now);
        if may {
            own.active += 1;
            return Ok(CallTurn(IdentityHandle { all: self.0.clone(), identity: identity.clone() }));
        }
        let (send, receive) = oneshot::channel();
        own.waiting.push_back(send);
        Err(receive)
    }

    /// Waits for the turn of a short call, and says so with `waits`. `None` never comes up: a call that waits has
    /// others of its identity in hand before it.
    pub(crate) async fn turn(&self, identity: &Arc<Identity>, waits: impl FnOnce()) -> Option<CallTurn> {
        match self.ask(identity, Instant::now()) {
            Ok(turn) => Some(turn),
            Err(comes) => {
                waits();
                comes.await.ok()
            }
        }
    }

    /// Counts a call that lasts, whose request has come.
    pub(crate) fn stay(&self, identity: &Arc<Identity>) -> LongCall {
        let now = Instant::now();
        called(&mut self.0.lock(), identity, now);
        let part = Arc::new(IdentityHandle { all: self.0.clone(), identity: identity.clone() });
        LongCall { part, at: Arc::new(Mutex::new(now)) }
    }
}

impl LongCall {
    /// Data of the call flow. A heartbeat has few bytes and is no work.
    pub(crate) fn flows(&self, bytes: usize, now: Instant) {
        let mut at = self.at.lock().unwrap_or_else(PoisonError::into_inner);
        if bytes > HEARTBEAT && now.saturating_duration_since(*at) >= LINGER / 4 {
            *at = now;
            called(&mut self.part.all.lock(), &self.part.identity, now);
        }
    }
}

impl Drop for CallTurn {
    fn drop(&mut self) {
        let IdentityHandle { all, identity } = &self.0;
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
            let turn = CallTurn(IdentityHandle { all: all.clone(), identity: identity.clone() });
            unwanted.extend(next.send(turn).err());
        }
        // Turns that came too late are given back without the lock.
        drop(callers);
        drop(unwanted);
    }
}

#[cfg(test)]
mod tests;
