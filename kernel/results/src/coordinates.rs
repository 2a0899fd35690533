//! The units in which the coordinates of a job were read.
//!
//! *Invariant:* only moves of the user's blocks count; moves of a tool change before the first code of a unit have no
//! coordinates of the program.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use counterpoint_event::event::FileId;
use counterpoint_event::info::{self, Info, MachineUnit};

/// Most changes of the unit that are listed for a channel.
const MAX_CHANGES: usize = 8;

/// The units of a job in the summary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CoordinateUnits {
    /// For people: `coordinates read in mm, from line 7 in inch`.
    pub text: String,
    /// Channels that have moved, ascending.
    pub channels: Vec<ChannelUnits>,
}

/// The units of a channel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelUnits {
    /// Its number.
    pub channel: u16,
    /// Whether the program had selected a unit by its first move; otherwise the initial unit of the machine applies.
    pub selected: bool,
    /// The unit of the first move, then every change.
    pub units: Vec<UnitFrom>,
}

/// A unit and the block that selects it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct UnitFrom {
    /// `mm` or `inch`.
    pub unit: String,
    /// File of the block, empty for the unit of the first move.
    pub file: String,
    /// Line of the block, 0 for the unit of the first move.
    pub line: u32,
}

/// The units of a channel while its events are read.
#[derive(Debug, Clone)]
pub struct UnitsRead {
    /// Its programs use inches until they select a unit.
    begins: bool,
    /// Coordinates are read in inches now.
    inch: bool,
    /// The block that selected this unit.
    since: (FileId, u32),
    /// A code has selected a unit.
    selected: bool,
    /// A code had selected a unit by the first move.
    selected_first: bool,
    /// The first move belongs to the current block.
    fresh: bool,
    /// Whether the latest move was read in inches; none before the first.
    last: Option<bool>,
    /// The unit of the first move, then every change.
    units: Vec<(bool, (FileId, u32))>,
}

impl UnitsRead {
    /// For a channel that has not moved yet.
    pub fn new(channel: &info::JobChannel) -> Self {
        Self {
            begins: channel.inch,
            inch: channel.inch,
            since: (0, 0),
            selected: false,
            selected_first: false,
            fresh: false,
            last: None,
            units: Vec::new(),
        }
    }

    /// The program starts, with the unit of the machine.
    pub fn start(&mut self) {
        (self.inch, self.selected) = (self.begins, false);
    }

    /// A block starts; `unit_named`: the block before has selected a unit.
    #[inline(always)]
    pub fn block(&mut self, unit_named: bool) {
        if unit_named || self.fresh {
            self.close_block(unit_named);
        }
    }

    #[cold]
    fn close_block(&mut self, unit_named: bool) {
        self.selected |= unit_named;
        self.selected_first |= unit_named && self.fresh;
        self.fresh = false;
    }

    /// A code has changed the unit.
    pub fn select(&mut self, inch: bool, place: (FileId, u32)) {
        (self.inch, self.since, self.selected) = (inch, place, true);
    }

    /// A move of the user's block.
    #[inline(always)]
    pub fn moves(&mut self) {
        if self.last != Some(self.inch) {
            self.note();
        }
    }

    #[cold]
    fn note(&mut self) {
        if self.last.is_none() {
            (self.fresh, self.selected_first) = (true, self.selected);
        }
        let place = if self.last.is_none() { (0, 0) } else { self.since };
        self.last = Some(self.inch);
        if self.units.len() <= MAX_CHANGES {
            self.units.push((self.inch, place));
        }
    }
}

/// The units of all channels; none if nothing has moved. `codes`: the words of units of each channel.
pub fn of<'c>(
    info: &Info,
    channels: impl Iterator<Item = (&'c info::JobChannel, UnitsRead)>,
) -> Option<CoordinateUnits> {
    let name = |inch: bool| if inch { MachineUnit::Inch } else { MachineUnit::Mm }.name();
    let mut texts: Vec<(u16, String)> = Vec::new();
    let mut all = Vec::new();
    for (channel, read) in channels {
        let Some(&(first, _)) = read.units.first() else { continue };
        let mut text = String::new();
        if !read.selected {
            let words = &channel.unit_words;
            let _ = if words.is_empty() { Ok(()) } else { write!(text, "no {words}: ") };
        }
        let _ = write!(text, "coordinates read in {}", name(first));
        if !read.selected_first {
            let _ = write!(text, ", the unit in which machine {} begins", info.machine);
        }
        let from = |&(inch, (file, line)): &(bool, (FileId, u32))| UnitFrom {
            unit: name(inch).to_owned(),
            file: if line == 0 { String::new() } else { info.place_name(file, line).into_owned() },
            line,
        };
        for &(inch, (file, line)) in read.units.iter().skip(1) {
            let _ = if file == channel.file {
                write!(text, ", from line {line} in {}", name(inch))
            } else {
                write!(text, ", from {}:{line} in {}", info.place_name(file, line), name(inch))
            };
        }
        if read.units.len() > MAX_CHANGES {
            text.push_str(", and so on");
        }
        texts.push((channel.number, text));
        let units = read.units.iter().map(from).collect();
        all.push(ChannelUnits { channel: channel.number, selected: read.selected_first, units });
    }
    let (_, first) = texts.first()?;
    let text = if texts.iter().all(|(_, text)| text == first) {
        first.clone()
    } else {
        texts.iter().map(|(channel, text)| format!("channel {channel}: {text}")).collect::<Vec<_>>().join("; ")
    };
    Some(CoordinateUnits { text, channels: all })
}
