//! The program files of a job by their numbers.
//!
//! Invariant: a file is loaded once, by whichever kernel needs it first; the text that results show is the same one.

use std::sync::{Arc, OnceLock};

use counterpoint_event::{FileId, Text};

use super::source::ProgramSource;

/// A file, when it has been loaded; none if it cannot be.
type Slot = OnceLock<Option<Arc<ProgramSource>>>;

/// The files of a job; each is loaded when it is first needed, once for each reader: where components of a composite
/// machine have different pre-processors, each of them finds other programs in a text.
#[derive(Debug)]
pub struct Sources(Vec<Vec<Slot>>);

impl Sources {
    /// No files yet, for this many readers.
    pub(super) fn new(readers: usize) -> Self {
        Self(vec![Vec::new(); readers.max(1)])
    }

    /// Adds a file, as a reader reads it if that is known already.
    pub(super) fn push(&mut self, mut source: impl FnMut(usize) -> Option<Option<Arc<ProgramSource>>>) {
        for (reader, slots) in self.0.iter_mut().enumerate() {
            slots.push(source(reader).map_or_else(OnceLock::new, OnceLock::from));
        }
    }

    /// A file, if the first reader has loaded it.
    #[must_use]
    pub fn get(&self, file: FileId) -> Option<&Arc<ProgramSource>> {
        self.read_by(0, file)
    }

    /// A file, if a reader has loaded it.
    #[must_use]
    pub fn read_by(&self, reader: usize, file: FileId) -> Option<&Arc<ProgramSource>> {
        self.slots(reader).get(usize::from(file))?.get()?.as_ref()
    }

    /// The files as a channel sees them, by a reader.
    #[must_use]
    pub fn seen_by(&self, channel: u16, reader: usize) -> SeenSources<'_> {
        SeenSources { all: self, slots: self.slots(reader), channel }
    }

    fn slots(&self, reader: usize) -> &[Slot] {
        self.0.get(reader).map_or(&[], Vec::as_slice)
    }
}

/// The files of a job as one channel sees them: without the stretches of other channels.
#[derive(Debug, Clone, Copy)]
pub struct SeenSources<'a> {
    all: &'a Sources,
    /// As the active pre-processor reads them.
    slots: &'a [Slot],
    channel: u16,
}

impl<'a> SeenSources<'a> {
    /// A file, if it has been loaded.
    #[inline(always)]
    #[must_use]
    pub fn get(self, file: FileId) -> Option<&'a ProgramSource> {
        Some(self.slot(file)?.as_ref()?.seen_by(self.channel))
    }

    /// The same files by another reader.
    #[must_use]
    pub fn by(self, reader: usize) -> Self {
        self.all.seen_by(self.channel, reader)
    }

    #[inline(always)]
    fn slot(self, file: FileId) -> Option<&'a Option<Arc<ProgramSource>>> {
        self.slots.get(usize::from(file))?.get()
    }

    /// The same, to be kept.
    #[must_use]
    pub fn shared(self, file: FileId) -> Option<Arc<ProgramSource>> {
        self.slot(file)?.as_ref().map(|source| Arc::clone(source.seen_by(self.channel)))
    }

    /// A file with the stretches of all channels, if it has been loaded.
    #[must_use]
    pub fn whole(self, file: FileId) -> Option<&'a Arc<ProgramSource>> {
        self.slot(file)?.as_ref()
    }

    /// Whether an attempt was made to load a file.
    #[must_use]
    pub fn is_known(self, file: FileId) -> bool {
        self.slot(file).is_some()
    }

    /// Keeps a file that has been loaded, or that cannot be; whichever kernel was first wins. `text` is where results
    /// find its text.
    pub fn put(self, file: FileId, source: Option<Arc<ProgramSource>>, text: &OnceLock<Option<Arc<Text>>>) {
        if let Some(slot) = self.slots.get(usize::from(file)) {
            let kept = slot.get_or_init(|| source);
            let _ = text.set(kept.as_ref().map(|source| Arc::clone(source.text())));
        }
    }
}
