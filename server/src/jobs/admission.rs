//! Whether a job can be accepted now.
//!
//! *Invariant:* a submit that repeats an earlier one is answered even when no job can be accepted.

use std::pin::Pin;
use std::sync::Arc;

use tokio::sync::futures::Notified;

use super::Core;
use super::lock::lock;
use crate::ledger::NewJob;
use crate::ledger::record::JobRecord;
use crate::reason::Refusal;

/// Why a submit has no place in the queue.
struct NoPlace {
    refusal: Refusal,
    /// Submits in progress hold the last places. They release these places if they repeat earlier submits.
    reserved: bool,
}

impl From<Refusal> for NoPlace {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, reserved: false }
    }
}

/// A place in the queue for a job of a tenant, if a job can be accepted now. If only submits in progress hold the last
/// places, waits for them.
pub(super) async fn place(core: &Arc<Core>, tenant: &str) -> Result<impl Drop + Send + use<>, Refusal> {
    let mut released: Option<Pin<Box<Notified<'_>>>> = None;
    loop {
        match free_place(core, tenant) {
            Ok(place) => return Ok(place),
            Err(NoPlace { refusal, reserved: false }) => return Err(refusal),
            Err(_) => {}
        }
        match released.take() {
            Some(released) => released.await,
            // Subscribe before the second look, so that no released place is missed.
            None => {
                released.insert(Box::pin(core.board.released.notified())).as_mut().enable();
            }
        }
    }
}

fn free_place(core: &Arc<Core>, tenant: &str) -> Result<impl Drop + Send + use<>, NoPlace> {
    if !*core.ledger.writable().borrow() {
        return Err(Refusal::unwritable_ledger().into());
    }
    core.room()?;
    core.within_quotas(tenant)?;
    core.reserve(tenant)
}

/// Whether a tenant may let another job wait, in a queue for `most` jobs of which `all` wait, `own` of them of the
/// tenant. A full queue still has a tenth of its places for each tenant, but in all no more than as many again: one
/// tenant cannot fill it for the others.
fn has_place(most: usize, all: usize, own: usize) -> bool {
    all < most || own < all && own < (most / 10).max(1) && all < most.saturating_mul(2)
}

impl Core {
    /// A place in the queue for a submit in progress, released when dropped.
    fn reserve(self: &Arc<Self>, tenant: &str) -> Result<impl Drop + Send + use<>, NoPlace> {
        struct QueueReservation(Arc<Core>, String);
        impl Drop for QueueReservation {
            fn drop(&mut self) {
                let mut queue = lock(&self.0.board.queue);
                let left = queue.reserved.get_mut(&self.1).map(|own| {
                    *own -= 1;
                    *own
                });
                if left == Some(0) {
                    queue.reserved.remove(&self.1);
                }
                drop(queue);
                self.0.board.released.notify_waiters();
            }
        }
        if self.drain.begun() {
            return Err(Refusal::Draining { cursor: 0 }.into());
        }
        let most = self.quotas_of(tenant).tenant_queued;
        let mut queue = lock(&self.board.queue);
        let waiting = queue.jobs.waiting_of(tenant);
        let own = waiting + queue.reserved.get(tenant).copied().unwrap_or(0);
        if most > 0 && own >= most {
            let text = format!("{waiting} jobs wait: submit again after some of them have started, or cancel some");
            let refusal = Refusal::quota(tenant, "tenant_queued", most as u64, text);
            return Err(NoPlace { refusal, reserved: waiting < most });
        }
        let free = self.options.slots().saturating_sub(queue.jobs.workers());
        let (places, listed) = (self.options.queue + free, queue.jobs.len());
        if !has_place(places, listed + queue.reserved.values().sum::<usize>(), own) {
            let refusal = Refusal::QueueFull(self.options.queue);
            return Err(NoPlace { refusal, reserved: has_place(places, listed, waiting) });
        }
        *queue.reserved.entry(tenant.to_owned()).or_default() += 1;
        Ok(QueueReservation(self.clone(), tenant.to_owned()))
    }
}

/// The answer to a submit that repeats an earlier one.
pub(super) fn known(core: &Core, job: &NewJob) -> Result<Option<(Box<JobRecord>, bool)>, Refusal> {
    let NewJob { record, work } = job;
    let Some(known) = core.ledger.by_request(&record.tenant, &record.request_id)? else { return Ok(None) };
    let same = match known.asks_the_same(record) {
        Some(same) => same,
        None => known.asks_the_same_work(&core.work(&known.id)?, record, work),
    };
    if !same {
        return Err(Refusal::RequestIdReused(record.request_id.clone()));
    }
    repeat(core, known).map(Some)
}

/// The job of a repeated request that can no longer be checked, for example because its machine has been deleted.
/// `content` is the digest of the request. `None` if no job has this content.
pub(crate) fn known_by_content(
    core: &Core,
    tenant: &str,
    request_id: &str,
    content: &str,
) -> Result<Option<Box<JobRecord>>, Refusal> {
    match core.ledger.by_request(tenant, request_id)?.filter(|known| known.content == content) {
        Some(known) => Ok(Some(repeat(core, known)?.0)),
        None => Ok(None),
    }
}

fn repeat(core: &Core, known: JobRecord) -> Result<(Box<JobRecord>, bool), Refusal> {
    core.answered(&known)?;
    Ok((Box::new(core.current(known)), true))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_queue_has_places_for_tenants_that_have_few() {
        assert!(has_place(10, 9, 9) && !has_place(10, 10, 10), "a tenant alone may fill it");
        assert!(has_place(10, 10, 0) && has_place(10, 19, 0) && !has_place(10, 20, 0));
        assert!(!has_place(10, 11, 1), "a tenth of the places is one");
        assert!(has_place(100, 100, 9) && !has_place(100, 110, 10));
        assert!(!has_place(0, 0, 0));
    }
}
