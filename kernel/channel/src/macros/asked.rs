//! External requests of the macros of a kernel.

use counterpoint_lang::host::AbsentFn;
use rustc_hash::FxHashMap;

/// External requests of the macros of a kernel.
#[derive(Debug, Default)]
pub struct ExternalRequests {
    /// How often each dialog was shown, by name.
    pub dialogs: FxHashMap<String, usize>,
    /// Functions that have been reported as not available.
    pub absent: Vec<AbsentFn>,
}
