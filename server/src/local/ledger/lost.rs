//! A ledger that cannot be used beside jobs or blobs, and the ways out.

use crate::local::named::{is_of_host, named};
use crate::local::store::Store;
use crate::reason::Refusal;

/// Refuses a missing or empty ledger beside jobs or blobs.
pub(crate) fn not_lost(store: &Store) -> Result<(), Refusal> {
    let ledger = store.ledger();
    let length = match std::fs::metadata(&ledger) {
        Err(error) if is_of_host(&error) => return Err(named(&ledger, error).into()),
        found => found.map(|meta| meta.len()).ok(),
    };
    if store.durable() && length.unwrap_or(0) == 0 && store.in_use() {
        let what = if length.is_some() { "is empty" } else { "is missing" };
        return Err(lost(store, &format!("{what} although there are jobs or blobs")));
    }
    Ok(())
}

/// A ledger that cannot be used, with the way out.
pub(crate) fn lost(store: &Store, what: &str) -> Refusal {
    let save = format!("save all that is whole (counterpointd doctor --repair --data '{}'), ", store.root().display());
    refused(store, what, &save)
}

/// A ledger that cannot be used because of this: damage has a way out, trouble of the host is not damage.
pub(crate) fn lost_by(store: &Store, what: &str, why: Refusal) -> Refusal {
    match why {
        Refusal::DataLoss(why) => lost(store, &format!("{what} ({why})")),
        trouble => trouble,
    }
}

/// A ledger of which nothing can be saved.
pub(crate) fn lost_for_good(store: &Store, what: &str) -> Refusal {
    refused(store, what, "no row of it is whole; ")
}

fn refused(store: &Store, what: &str, save: &str) -> Refusal {
    let root = store.root().display();
    Refusal::DataLoss(format!(
        "{} {what}: {save}restore it from a backup, or set the folder aside and start with an empty one: mv '{root}' \
         '{root}.lost'",
        store.ledger().display()
    ))
}
