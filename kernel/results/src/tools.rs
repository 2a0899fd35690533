//! The tools of one channel: what is known about each, and the offsets it was used with.
//!
//! Facts: reference listing-and-trace.md 7.1. *Invariant:* rows are in the order of the first loads unless the channel
//! has given another one; motions and blocks are ignored.

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use counterpoint_event::event::{Kind, OffsetKind, ToolAction, ToolChange, ToolData, ToolOffset};

/// Offsets listed per tool; a program with more of them has a mistake that the table need not show in full.
const MOST_OFFSETS: usize = 64;

/// Tools listed per channel.
const MOST_TOOLS: usize = 10_000;

/// A tool in the summary.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Tool {
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
}

/// Collects the tools of a channel.
#[derive(Debug, Default)]
pub struct Tools {
    rows: Vec<Tool>,
    by_number: FxHashMap<u32, usize>,
    current: Option<usize>,
    data: FxHashMap<u32, Box<ToolData>>,
}

impl Tools {
    /// Any event of the channel that is neither block nor motion.
    pub fn event(&mut self, kind: &Kind) {
        match kind {
            Kind::Tool(ToolChange { action: ToolAction::Select, .. }) => {}
            Kind::Tool(load) => self.load(load.tool, load.offset),
            Kind::Mode(mode) => self.offset(mode.offset),
            Kind::ToolData(data) => {
                self.data.insert(data.tool, data.clone());
            }
            _ => {}
        }
    }

    fn load(&mut self, tool: u32, offset: u32) {
        if tool == 0 {
            return;
        }
        self.current = match self.by_number.get(&tool) {
            Some(row) => Some(*row),
            None if self.rows.len() < MOST_TOOLS => {
                self.rows.push(Tool { tool, ..Tool::default() });
                self.by_number.insert(tool, self.rows.len() - 1);
                Some(self.rows.len() - 1)
            }
            None => None,
        };
        if let Some(row) = self.current.and_then(|row| self.rows.get_mut(row)) {
            note(&mut row.length_offsets, offset);
        }
    }

    /// An offset is used with the tool in work.
    fn offset(&mut self, offset: Option<ToolOffset>) {
        let row = self.current.and_then(|row| self.rows.get_mut(row));
        let (Some(ToolOffset { kind, number }), Some(row)) = (offset, row) else { return };
        let list = match kind {
            OffsetKind::Length => &mut row.length_offsets,
            OffsetKind::Diameter => &mut row.diameter_offsets,
        };
        note(list, number);
    }

    /// The channel has ended.
    pub fn finish(self) -> Vec<Tool> {
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
