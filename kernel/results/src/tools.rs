//! The tools of one channel: the data of each, and the offsets it was used with.
//!
//! Facts: reference listing-and-trace.md 7.1. *Invariant:* rows are in the order of the first loads unless the channel
//! has given another one; motions and blocks are ignored.

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use counterpoint_event::event::{Kind, OffsetKind, OffsetSelection, ToolAction, ToolChange, ToolData};

/// Offsets listed per tool; a program with more of them has a mistake that the table need not show in full.
const MOST_OFFSETS: usize = 64;

/// Tools listed per channel.
const MOST_TOOLS: usize = 10_000;

/// A tool in the summary.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ToolSummary {
    /// Number as programmed.
    pub tool: u32,
    /// Name, empty without one.
    pub name: String,
    /// Diameter, none if it is not known.
    pub diameter: Option<f64>,
    /// Corner radius, likewise.
    pub radius: Option<f64>,
    /// Length, likewise.
    pub length: Option<f64>,
    /// Numbers of the length offsets it was used with, in that order.
    pub length_offsets: Vec<u32>,
    /// Numbers of the diameter offsets.
    pub diameter_offsets: Vec<u32>,
    /// The comment of the program where the tool is loaded, empty without one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub operation: String,
    /// Time spent with it.
    #[serde(default)]
    pub times: ToolTimes,
}

/// Time spent with a tool, from the block that loads it to the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct ToolTimes {
    /// Feed moves, ns.
    pub feed_ns: i64,
    /// Rapid moves, ns.
    pub rapid_ns: i64,
    /// Tool change, dwells and functions, ns.
    pub misc_ns: i64,
    /// Waiting for other channels, ns.
    pub wait_ns: i64,
}

impl ToolTimes {
    fn add_since(&mut self, since: Self, now: Self) {
        self.feed_ns += now.feed_ns - since.feed_ns;
        self.rapid_ns += now.rapid_ns - since.rapid_ns;
        self.misc_ns += now.misc_ns - since.misc_ns;
        self.wait_ns += now.wait_ns - since.wait_ns;
    }
}

/// Collects the tools of a channel.
#[derive(Debug, Default)]
pub struct ToolCollector {
    rows: Vec<ToolSummary>,
    by_number: FxHashMap<u32, usize>,
    current: Option<usize>,
    /// Times of the channel when the active tool was loaded.
    since: ToolTimes,
    data: FxHashMap<u32, Box<ToolData>>,
}

impl ToolCollector {
    /// Any event of the channel that is neither block nor motion, with the times of the channel before it.
    pub(crate) fn event(&mut self, kind: &Kind, times: impl Fn() -> ToolTimes) {
        match kind {
            Kind::Tool(ToolChange { action: ToolAction::Select, .. }) => {}
            Kind::Tool(load) => {
                self.count(times());
                self.load(load.tool, load.offset);
            }
            Kind::Mode(mode) => self.offset(mode.offset),
            Kind::ToolData(data) => {
                self.data.insert(data.tool, data.clone());
            }
            _ => {}
        }
    }

    /// Adds the time since the last load to the active tool.
    fn count(&mut self, now: ToolTimes) {
        if let Some(row) = self.current.and_then(|row| self.rows.get_mut(row)) {
            row.times.add_since(self.since, now);
        }
        self.since = now;
    }

    fn load(&mut self, tool: u32, offset: u32) {
        if tool == 0 {
            self.current = None;
            return;
        }
        self.current = match self.by_number.get(&tool) {
            Some(row) => Some(*row),
            None if self.rows.len() < MOST_TOOLS => {
                self.rows.push(ToolSummary { tool, ..ToolSummary::default() });
                self.by_number.insert(tool, self.rows.len() - 1);
                Some(self.rows.len() - 1)
            }
            None => None,
        };
        if let Some(row) = self.current.and_then(|row| self.rows.get_mut(row)) {
            note(&mut row.length_offsets, offset);
        }
    }

    /// Records an offset that is used with the active tool.
    fn offset(&mut self, offset: Option<OffsetSelection>) {
        let row = self.current.and_then(|row| self.rows.get_mut(row));
        let (Some(OffsetSelection { kind, number }), Some(row)) = (offset, row) else { return };
        let list = match kind {
            OffsetKind::Length => &mut row.length_offsets,
            OffsetKind::Diameter => &mut row.diameter_offsets,
        };
        note(list, number);
    }

    /// The channel has ended, with these times.
    pub(crate) fn finish(mut self, times: ToolTimes) -> Vec<ToolSummary> {
        self.count(times);
        let Self { mut rows, data, .. } = self;
        for row in &mut rows {
            if let Some(data) = data.get(&row.tool) {
                row.name = data.name.to_string();
                (row.diameter, row.radius, row.length) = (data.diameter, data.radius, data.length);
            }
        }
        // Rows without a place keep their order after all others.
        rows.sort_by_key(|row| data.get(&row.tool).map_or(0, |data| data.place).wrapping_sub(1));
        rows
    }
}

fn note(list: &mut Vec<u32>, number: u32) {
    if number != 0 && list.len() < MOST_OFFSETS && !list.contains(&number) {
        list.push(number);
    }
}
