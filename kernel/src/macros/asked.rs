//! What the macros of a kernel have asked the outside for.

use counterpoint_lang::host::HostFn;
use rustc_hash::FxHashMap;

/// What the macros of a kernel have asked the outside for.
#[derive(Debug, Default)]
pub(crate) struct Asked {
    /// How often each dialog was shown, by name.
    pub(crate) dialogs: FxHashMap<String, usize>,
    /// Functions of which it has been told that there is nothing here for them.
    pub(crate) without: Vec<HostFn>,
}
