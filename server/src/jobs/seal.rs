//! Changes of a record at the end of a run, and the log and files that become durable before it.

use std::sync::Arc;

use super::Core;
use super::live::LiveJob;
use crate::ledger::record::JobRecord;
use crate::log::writer::LogDestination;
use crate::reason::Refusal;

/// Change of a record at the end of a run.
pub(super) type Change = Box<dyn FnOnce(&mut JobRecord)>;

/// Makes the log and the files of a job durable.
pub(super) fn seal(
    core: &Arc<Core>,
    live: &LiveJob,
    place: Option<Box<dyn LogDestination>>,
    has_files: bool,
) -> Result<(), Refusal> {
    if place.is_some() || has_files {
        // The rest is waiting for the disk.
        core.leave(live);
        core.pump();
        place.map_or(Ok(()), |place| place.seal())?;
        core.logs.sync(&live.id)?;
    }
    Ok(())
}

/// Bytes of a log from which on results are stored; those of a smaller one are made from it on request.
pub(super) const RESULTS_FROM: u64 = 1 << 20;
