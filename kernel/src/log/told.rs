//! What channels tell each other and people: the few events that results need in the order of the whole log.
//!
//! Invariant: kept whole; everything else is read off each channel alone ([`super::lane`]).

use std::sync::Arc;

use crate::log::event::{Diagnostic, Event, FileId, Kind, Release, Verdict, Wait};
use crate::log::info::{BLOCK_TEXT, Info};

/// One such event.
#[derive(Debug)]
pub(crate) struct Told {
    pub(crate) t_ns: i64,
    pub(crate) micro: u32,
    pub(crate) channel: u16,
    pub(crate) file: FileId,
    pub(crate) line: u32,
    pub(crate) what: What,
}

/// Its content.
#[derive(Debug)]
pub(crate) enum What {
    /// With the name of the file and the text of the block.
    Wait(Arc<Wait>, Place),
    Release(Release),
    Diagnostic(Box<Diagnostic>),
    Verdict(Box<Verdict>),
}

/// Name of a file and text of a block in it.
pub(crate) type Place = (Arc<str>, Arc<str>);

/// The latest places of a channel's waits: loops wait at the same lines again and again.
#[derive(Debug, Default)]
pub(crate) struct Places {
    name: Option<(FileId, Arc<str>)>,
    /// By the lower bits of the line.
    blocks: Vec<Option<(FileId, u32, Arc<str>)>>,
}

impl Places {
    const LINES: usize = 64;

    fn at(&mut self, info: &Info, file: FileId, line: u32) -> Place {
        let name = match &self.name {
            Some((known, name)) if *known == file => name.clone(),
            _ => self.name.insert((file, info.file_name(file).into())).1.clone(),
        };
        self.blocks.resize(Self::LINES, None);
        let block = match self.blocks.get_mut(line as usize % Self::LINES) {
            Some(Some((f, l, block))) if (*f, *l) == (file, line) => block.clone(),
            Some(slot) => slot.insert((file, line, info.block_text(file, line, BLOCK_TEXT).into())).2.clone(),
            None => "".into(),
        };
        (name, block)
    }
}

impl Told {
    /// `None` for events that only their channel is concerned with.
    pub(crate) fn of(event: &Event, info: &Info, places: &mut Places) -> Option<Self> {
        let what = match &event.kind {
            Kind::Wait(wait) => What::Wait(wait.clone(), places.at(info, event.file, event.line)),
            Kind::Release(release) => What::Release(release.clone()),
            Kind::Diagnostic(diagnostic) => What::Diagnostic(diagnostic.clone()),
            Kind::Verdict(verdict) => What::Verdict(verdict.clone()),
            _ => return None,
        };
        let Event { t_ns, micro, channel, file, line, .. } = *event;
        Some(Self { t_ns, micro, channel, file, line, what })
    }

    /// The event it was.
    pub(crate) fn event(&self) -> Event {
        let Self { t_ns, micro, channel, file, line, .. } = *self;
        let kind = match &self.what {
            What::Wait(wait, _) => Kind::Wait(wait.clone()),
            What::Release(release) => Kind::Release(release.clone()),
            What::Diagnostic(diagnostic) => Kind::Diagnostic(diagnostic.clone()),
            What::Verdict(verdict) => Kind::Verdict(verdict.clone()),
        };
        Event { t_ns, micro, dur_ns: 0, channel, file, line, kind }
    }
}
