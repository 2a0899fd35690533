//! The fixed facts of a job before it runs: names, channels, axes and source files.
//!
//! Results need it to turn numbers in events into names and text. Invariant: the same job gives the same `Info`,
//! so results can be made again at any time from the stored log and the stored job.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

pub use crate::MachineUnit;
use crate::event::DiagnosticOrigin;
use crate::{FileId, Letters, Text};

/// How the names of files begin that are stored with the machine.
pub const STORED: &str = "//ICAMFS/";

/// Most characters of a block in results.
pub const BLOCK_TEXT: usize = 200;

/// Description of a prepared job.
#[derive(Debug)]
pub struct Info {
    /// Machine name as in its definition.
    pub machine: String,
    /// Machine number and revision, for the listing header.
    pub machine_number: u32,
    /// Revision.
    pub machine_revision: u32,
    /// When the definition was made, as it says itself; empty when it does not.
    pub machine_created: String,
    /// File of the definition: folder and name.
    pub machine_file: String,
    /// The user's parameters of the job, empty without any.
    pub parameters: String,
    /// `mm` or `inch`: the unit of lengths in events.
    pub unit: MachineUnit,
    /// Letters of the trace that the job asks for.
    pub trace: Letters,
    /// Memory that the results of a channel may take.
    pub room: ResultBudget,
    /// Channels in ascending number, master not included.
    pub channels: Vec<JobChannel>,
    /// All files the job may read: programs first, in order, then the others by name.
    pub files: Vec<JobFile>,
}

/// Bytes of memory that the results and the events of one channel may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResultBudget {
    /// The toolpath.
    pub path: u64,
    /// The bars of the timeline.
    pub bars: u64,
    /// Events that wait for other channels.
    pub waiting: u64,
}

/// A channel as results need it.
#[derive(Debug, Clone)]
pub struct JobChannel {
    /// Channel number, from 1.
    pub number: u16,
    /// Name in the machine definition (`UPPER`).
    pub name: String,
    /// Program given to it (`file` or `file#2102`), empty when it has none.
    pub program: String,
    /// First line and last line of that program in its file (1-based, inclusive), for progress in percent.
    pub lines: (u32, u32),
    /// File of that program.
    pub file: FileId,
    /// Axes in channel order.
    pub axes: Vec<JobAxis>,
    /// Its tools work from below the turning axis.
    pub lower: bool,
    /// Its program uses inches until it selects a unit.
    pub inch: bool,
    /// The words that select a unit: `G20/G21`; empty if there are none.
    pub unit_words: String,
}

/// An axis as results need it.
#[derive(Debug, Clone)]
pub struct JobAxis {
    /// Name, mostly one letter.
    pub name: String,
    /// `true`: degrees; `false`: machine length unit.
    pub rotary: bool,
    /// Values are diameters.
    pub diameter: bool,
}

/// A file of the job; its text is loaded when first needed.
#[derive(Debug)]
pub struct JobFile {
    /// Path as the job names it.
    pub name: String,
    /// It is stored with the machine: its blocks are shown only to clients that ask for them.
    pub stored: bool,
    /// It is stored with the machine and shipped with this project: reports name the block that called it instead.
    pub resident: bool,
    /// Text and line index once loaded.
    pub text: OnceLock<Option<Arc<Text>>>,
    /// Stretches that belong to channels or are programs by name, in order; empty when the file is one text.
    pub sections: Vec<FileSection>,
}

/// A stretch of a file with a name of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileSection {
    /// Channel that it belongs to; 0: to all.
    pub channel: u16,
    /// Its name in the file (`$1`, `G13`, `PART_1`).
    pub name: Box<str>,
    /// First line and last line (1-based, inclusive).
    pub lines: (u32, u32),
}

/// A text without blanks around it, at most `most` characters, the rest as `...`.
pub fn cut(text: &str, most: usize) -> String {
    let text = text.trim();
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
}

impl Info {
    /// Text of a line without its end of line; empty when the file or line does not exist.
    #[must_use]
    pub fn line_text(&self, file: FileId, line: u32) -> Cow<'_, str> {
        self.text(file).map_or(Cow::Borrowed(""), |text| String::from_utf8_lossy(text.line(line)))
    }

    /// Text of a block as results show it: without blanks around it, at most `most` characters, the rest as `...`.
    #[must_use]
    pub fn block_text(&self, file: FileId, line: u32, most: usize) -> Cow<'_, str> {
        let text = match self.line_text(file, line) {
            Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
            Cow::Owned(text) => Cow::Owned(text.trim().to_owned()),
        };
        if text.len() <= most || text.chars().count() <= most {
            return text;
        }
        text.chars().take(most.saturating_sub(3)).chain("...".chars()).collect()
    }

    /// The loaded text of a file.
    #[must_use]
    pub fn text(&self, file: FileId) -> Option<&Text> {
        self.files.get(usize::from(file)).and_then(|f| f.text.get()).and_then(|text| text.as_deref())
    }

    /// Name of a file, `-` when unknown.
    #[must_use]
    pub fn file_name(&self, file: FileId) -> &str {
        self.files.get(usize::from(file)).map_or("-", |f| f.name.as_str())
    }

    /// Name of the file of a line, with that of its section (`part.nc#$2`) if it has several.
    #[must_use]
    pub fn place_name(&self, file: FileId, line: u32) -> Cow<'_, str> {
        let name = self.file_name(file);
        let sections = self.files.get(usize::from(file)).map_or(&[][..], |file| &file.sections);
        let within = sections.iter().find(|section| (section.lines.0..=section.lines.1).contains(&line));
        within.map_or(Cow::Borrowed(name), |section| Cow::Owned(format!("{name}#{}", section.name)))
    }

    /// Whether a file is stored with the machine.
    #[must_use]
    pub fn is_stored(&self, file: FileId) -> bool {
        self.files.get(usize::from(file)).is_some_and(|f| f.stored)
    }

    /// Whether the project ships the file; the file then counts as part of the machine, not as a program of the user.
    #[must_use]
    pub fn is_resident(&self, file: FileId) -> bool {
        self.files.get(usize::from(file)).is_some_and(|f| f.resident)
    }

    /// A block of a resident program as the origin of a diagnostic: the program by its name in calls.
    #[must_use]
    pub fn origin(&self, file: FileId, line: u32) -> DiagnosticOrigin {
        let path = self.file_name(file);
        let name = path.rsplit('/').next().unwrap_or(path).split('.').next().unwrap_or_default();
        let statement = self.block_text(file, line, BLOCK_TEXT);
        DiagnosticOrigin {
            name: name.to_ascii_uppercase().into(),
            file: path.into(),
            line,
            statement: (*statement).into(),
        }
    }

    /// Channel by number.
    #[must_use]
    pub fn channel(&self, number: u16) -> Option<&JobChannel> {
        self.channels.iter().find(|c| c.number == number)
    }

    /// Place of a channel in [`Info::channels`]; `None` for the master and unknown numbers.
    #[must_use]
    pub fn channel_index(&self, number: u16) -> Option<usize> {
        // Channels count from 1 without gaps on most machines.
        let index = usize::from(number).wrapping_sub(1);
        match self.channels.get(index) {
            Some(channel) if channel.number == number => Some(index),
            _ => self.channels.iter().position(|c| c.number == number),
        }
    }
}
