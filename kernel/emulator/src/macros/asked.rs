//! External requests of the macros of a kernel.

use counterpoint_lang::host::AbsentFn;
use rustc_hash::FxHashMap;

/// External requests of the macros of a kernel.
#[derive(Debug, Default)]
pub(crate) struct ExternalRequests {
    /// How often each dialog was shown, by name.
    pub(crate) dialogs: FxHashMap<String, usize>,
    /// Functions that have been reported as not available.
    pub(crate) absent: Vec<AbsentFn>,
}
