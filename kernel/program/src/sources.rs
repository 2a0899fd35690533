//! The program files of a job by their numbers.
//!
//! Invariant: a file is loaded once, by whichever kernel needs it first; the text that results show is the same one.

use std::sync::{Arc, OnceLock};

use counterpoint_event::{FileId, Text};

use super::source::Source;

/// The files of a job; each is loaded when it is first needed.
#[derive(Debug, Default)]
pub struct Sources(Vec<OnceLock<Option<Arc<Source>>>>);

impl Sources {
    /// Adds a file, with its text if that is known already.
    pub(super) fn push(&mut self, source: Option<Option<Arc<Source>>>) {
        self.0.push(source.map_or_else(OnceLock::new, OnceLock::from));
    }

    /// A file, if it has been loaded.
    #[must_use]
    pub fn get(&self, file: FileId) -> Option<&Arc<Source>> {
        self.slot(file)?.as_ref()
    }

    /// The files as a channel sees them.
    #[must_use]
    pub fn seen_by(&self, channel: u16) -> SeenSources<'_> {
        SeenSources { all: self, channel }
    }

    fn put(&self, file: FileId, source: Option<Arc<Source>>, text: &OnceLock<Option<Arc<Text>>>) {
        if let Some(slot) = self.0.get(usize::from(file)) {
            let kept = slot.get_or_init(|| source);
            let _ = text.set(kept.as_ref().map(|source| Arc::clone(source.text())));
        }
    }

    fn slot(&self, file: FileId) -> Option<&Option<Arc<Source>>> {
        self.0.get(usize::from(file))?.get()
    }
}

/// The files of a job as one channel sees them: without the stretches of other channels.
#[derive(Debug, Clone, Copy)]
pub struct SeenSources<'a> {
    all: &'a Sources,
    channel: u16,
}

impl<'a> SeenSources<'a> {
    /// A file, if it has been loaded.
    #[inline(always)]
    #[must_use]
    pub fn get(self, file: FileId) -> Option<&'a Source> {
        Some(self.all.get(file)?.seen_by(self.channel))
    }

    /// The same, to be kept.
    #[must_use]
    pub fn shared(self, file: FileId) -> Option<Arc<Source>> {
        self.all.get(file).map(|source| Arc::clone(source.seen_by(self.channel)))
    }

    /// A file with the stretches of all channels, if it has been loaded.
    #[must_use]
    pub fn whole(self, file: FileId) -> Option<&'a Arc<Source>> {
        self.all.get(file)
    }

    /// An attempt was made to load a file.
    #[must_use]
    pub fn is_known(self, file: FileId) -> bool {
        self.all.slot(file).is_some()
    }

    /// Keeps a file that has been loaded, or that cannot be; whichever kernel was first wins. `text` is where results
    /// find its text.
    pub fn put(self, file: FileId, source: Option<Arc<Source>>, text: &OnceLock<Option<Arc<Text>>>) {
        self.all.put(file, source, text);
    }
}
