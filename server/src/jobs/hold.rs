//! Pause and resume: jobs that are held back.
//!
//! A pause stops the run in progress and gives its worker to others; the next run begins at the start and gives the
//! same events, so watches continue at their cursors. Nothing of a paused job stays on a worker or in memory but its
//! record. Invariant: a job is held back exactly if its record says so; the ledger agrees when the call is answered.

use std::sync::Arc;

use super::Core;
use crate::ledger::record::JobRecord;
use crate::reason::Refusal;

impl Core {
    /// Holds a job back: durable first, then in memory. A job that has ended stays as it is.
    pub(crate) async fn pause(self: &Arc<Self>, id: &str) -> Result<JobRecord, Refusal> {
        let Some(live) = self.live(id) else { return self.job(id) };
        let _holding = live.holding.lock().await;
        self.ledger.flag_paused(id.to_owned(), true).await?;
        let record = live.change(|record| record.paused |= !record.state.ended() && !record.cancel);
        if record.paused && !self.hold(&live) {
            live.interrupt();
        }
        self.changed(&live);
        Ok(live.record())
    }

    /// Lets a paused job wait for a worker again.
    pub(crate) async fn resume(self: &Arc<Self>, id: &str) -> Result<JobRecord, Refusal> {
        let Some(live) = self.live(id) else { return self.job(id) };
        let _holding = live.holding.lock().await;
        self.ledger.flag_paused(id.to_owned(), false).await?;
        live.change(|record| record.paused = false);
        self.release(&live);
        self.changed(&live);
        Ok(live.record())
    }
}
