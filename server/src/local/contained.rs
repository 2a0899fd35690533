//! Panics of the database on a damaged file end here, as errors, without a line on standard error.
//!
//! *Invariant:* objects of the database that outlive the work are made and dropped outside of it, or each in a
//! `contained` of its own, so that none is dropped while its panic is under way.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use crate::reason::Refusal;

thread_local! {
    /// Works of this thread whose panics are not shown.
    static QUIET: Cell<u32> = const { Cell::new(0) };
}

/// Has panics of contained work not shown; those of other threads and other work are shown as before.
fn install() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let shown = take_hook();
        set_hook(Box::new(move |panic| {
            if QUIET.try_with(Cell::get).unwrap_or(0) == 0 {
                shown(panic);
            }
        }));
    });
}

/// The refusal of a call that has met damage.
pub(crate) fn damaged() -> Refusal {
    let text = "the ledger is damaged: stop the server, save all that is whole with `counterpointd doctor --repair`, \
                or restore a backup";
    Refusal::DataLoss(text.to_owned())
}

/// Does work on the database.
///
/// # Errors
/// When it panics, because a page of the file is damaged.
pub(crate) fn contained<T>(work: impl FnOnce() -> T) -> Result<T, Refusal> {
    install();
    QUIET.with(|quiet| quiet.set(quiet.get() + 1));
    let done = catch_unwind(AssertUnwindSafe(work));
    QUIET.with(|quiet| quiet.set(quiet.get().saturating_sub(1)));
    done.map_err(|_| damaged())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_and_later_work_is_done() {
        let text = contained(|| panic!("page")).map(|()| String::new()).unwrap_err().to_string();
        assert!(text.contains("doctor --repair"), "{text}");
        assert_eq!(contained(|| contained(|| 7)), Ok(Ok(7)));
        assert!(contained(|| contained(|| panic!("inner"))).unwrap().is_err());
        assert_eq!(QUIET.with(Cell::get), 0);
    }
}
