//! Files stored with a machine.
//!
//! Invariant: a stored file is never written.

use counterpoint_ports::files::Bytes;

/// A file stored with the machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredFile {
    /// Path below `//ICAMFS/`.
    pub path: String,
    /// Content.
    pub content: Bytes,
    /// The project ships this file with this content; it counts as part of the machine, not as a program of the user.
    pub resident: bool,
}

impl StoredFile {
    /// Beginning of the paths of stored files.
    pub const ROOT: &str = counterpoint_event::info::STORED;

    /// The stored file of a path `//ICAMFS/…` or of a path inside; letter case does not matter.
    #[must_use]
    pub fn find<'f>(files: &'f [Self], path: &str) -> Option<&'f Bytes> {
        let root = path.get(..Self::ROOT.len()).is_some_and(|start| start.eq_ignore_ascii_case(Self::ROOT));
        let inside = if root { path.get(Self::ROOT.len()..)? } else { path };
        files.iter().find(|file| file.path.eq_ignore_ascii_case(inside)).map(|file| &file.content)
    }
}
