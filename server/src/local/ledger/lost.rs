//! A ledger that cannot be used beside jobs or blobs, and the ways out.

use super::salvage::Saved;
use crate::local::named::{is_of_host, named};
use crate::local::store::DataFolder;
use crate::reason::Refusal;

/// Refuses a missing or empty ledger beside jobs or blobs.
pub(crate) fn not_lost(store: &DataFolder) -> Result<(), Refusal> {
    let ledger = store.ledger();
    let length = match std::fs::metadata(&ledger) {
        Err(error) if is_of_host(&error) => return Err(named(&ledger, error).into()),
        found => found.map(|meta| meta.len()).ok(),
    };
    if store.durable() && length.unwrap_or(0) == 0 && store.in_use() {
        let what = if length.is_some() { "is empty" } else { "is missing" };
        return Err(refused(store, &format!("{what} although there are jobs or blobs"), "no row of it is left; "));
    }
    Ok(())
}

/// A damaged ledger, of which a repair saves some rows.
pub(crate) fn lost(store: &DataFolder, what: &str) -> Refusal {
    let save = format!("save all that is whole (counterpointd doctor --repair --data '{}'), ", store.root().display());
    refused(store, what, &save)
}

/// A ledger with damaged pages: recommends a repair only if it would save rows. Returns a problem of the host
/// unchanged.
pub(crate) fn damaged_by(store: &DataFolder, why: Refusal) -> Refusal {
    let Refusal::DataLoss(why) = why else { return why };
    let what = format!("is damaged ({why})");
    if Saved::read(store).is_ok() { lost(store, &what) } else { lost_for_good(store, &what) }
}

/// A ledger that cannot be opened although its pages are intact: a repair saves nothing. Returns a problem of the host
/// unchanged.
pub(crate) fn unopened_by(store: &DataFolder, why: Refusal) -> Refusal {
    match why {
        Refusal::DataLoss(why) => refused(store, &format!("cannot be opened ({why})"), ""),
        trouble => trouble,
    }
}

/// A ledger of which nothing can be saved.
pub(crate) fn lost_for_good(store: &DataFolder, what: &str) -> Refusal {
    refused(store, what, "no row of it is whole; ")
}

fn refused(store: &DataFolder, what: &str, save: &str) -> Refusal {
    let root = store.root().display();
    Refusal::DataLoss(format!(
        "{} {what}: {save}restore it from a backup, or set the folder aside and start with an empty one: mv '{root}' \
         '{root}.lost'",
        store.ledger().display()
    ))
}
