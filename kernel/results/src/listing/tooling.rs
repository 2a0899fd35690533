//! The two tooling tables.
//!
//! Layout: reference listing-and-trace.md 7.1, rows as the summary has them. *Invariant:* time counts for the tool in
//! use when it passes; a tool change counts for the new tool.

use std::io::{Result, Write};

use rustc_hash::FxHashMap;

use super::time::clock;
use crate::summary::ToolSummary;
use counterpoint_event::event::WorkClass;
use counterpoint_event::event::{
    Event, FeedUnit, Kind, Motion, MotionKind, SpindleChange, SpindleDirection, ToolAction, ToolChange,
};

/// Smallest and largest value seen.
#[derive(Debug, Default)]
struct ValueRange(Option<(f64, f64)>);

impl ValueRange {
    fn add(&mut self, value: f64) {
        if value.is_finite() && value > 0.0 {
            let (low, high) = self.0.unwrap_or((value, value));
            self.0 = Some((low.min(value), high.max(value)));
        }
    }

    fn texts(&self, decimals: usize) -> [String; 2] {
        let (low, high) = self.0.unzip();
        [low, high].map(|v| v.map_or_else(|| "NA".to_owned(), |v| format!("{v:.decimals$}")))
    }
}

#[derive(Debug, Default)]
struct ToolUsage {
    feed: ValueRange,
    rpm: ValueRange,
    feed_ns: i64,
    rapid_ns: i64,
    misc_ns: i64,
}

/// Collects the tools of a channel.
#[derive(Debug)]
pub(super) struct Tooling {
    tools: FxHashMap<u32, ToolUsage>,
    current: u32,
    spindle: Option<SpindleChange>,
    end_ns: i64,
}

impl Tooling {
    /// `end_ns`: when the channel ended; durations are cut there.
    pub(super) fn new(end_ns: i64) -> Self {
        Self { tools: FxHashMap::default(), current: 0, spindle: None, end_ns }
    }

    /// Takes any event of the channel except motions.
    pub(super) fn event(&mut self, event: &Event) {
        match &event.kind {
            Kind::Tool(ToolChange { action: ToolAction::Select, .. }) => {}
            Kind::Tool(ToolChange { tool, .. }) if *tool != 0 => self.current = *tool,
            Kind::Spindle(spindle) => {
                let turns =
                    matches!(spindle.direction, SpindleDirection::Clockwise | SpindleDirection::CounterClockwise);
                self.spindle = turns.then_some(*spindle);
            }
            _ => {}
        }
        self.time(event);
    }

    /// A motion of the channel.
    pub(super) fn motion(&mut self, event: &Event, motion: &Motion) {
        self.time(event);
        let spindle = self.spindle;
        let Some(tool) = self.tool() else { return };
        if motion.kind == MotionKind::Rapid {
            return;
        }
        if motion.kind != MotionKind::Thread && motion.feed_unit != FeedUnit::InverseTime {
            tool.feed.add(motion.feed);
        }
        match spindle {
            Some(spindle) if !spindle.css => tool.rpm.add(spindle.speed.min(spindle.limit)),
            Some(_) if motion.feed_unit == FeedUnit::PerRevolution && motion.feed > 0.0 => {
                tool.rpm.add(motion.length / motion.feed / (event.dur_ns as f64 / 60e9));
            }
            _ => {}
        }
    }

    fn tool(&mut self) -> Option<&mut ToolUsage> {
        (self.current != 0).then(|| self.tools.entry(self.current).or_default())
    }

    fn time(&mut self, event: &Event) {
        let Some(work) = event.kind.work() else { return };
        let ns = event.dur_ns.min(self.end_ns.saturating_sub(event.t_ns)).max(0);
        let Some(tool) = self.tool() else { return };
        match work {
            WorkClass::Feed => tool.feed_ns += ns,
            WorkClass::Rapid => tool.rapid_ns += ns,
            WorkClass::Tool | WorkClass::Dwell | WorkClass::Misc => tool.misc_ns += ns,
            WorkClass::Wait => {}
        }
    }

    /// Both tables, with the rows of the summary.
    pub(super) fn write(&self, tools: &[ToolSummary], out: &mut dyn Write) -> Result<()> {
        write!(out, "\nTOOLING SUMMARY:\n\n")?;
        writeln!(out, "     TOOL  NAME              DIAMETER    RADIUS  LENGTH-OFFSETS  DIAM-OFFSETS")?;
        for tool in tools {
            let [length, diameter] = [&tool.length_offsets, &tool.diameter_offsets].map(|list| join(list));
            let [wide, corner] = [tool.diameter, tool.radius].map(size);
            let name = if tool.name.is_empty() { "NA" } else { &tool.name };
            let name: String = name.chars().take(NAME).collect();
            writeln!(out, "{:>9}  {name:<NAME$}{wide:>10}{corner:>10}{length:>16}{diameter:>14}", tool.tool)?;
        }
        writeln!(out)?;
        writeln!(out, "     TOOL   MIN-FEED   MAX-FEED  MIN-RPM  MAX-RPM      FEED     RAPID      MISC     TOTAL")?;
        let unused = ToolUsage::default();
        for ToolSummary { tool: number, .. } in tools {
            let tool = self.tools.get(number).unwrap_or(&unused);
            let ([low, high], [slow, fast]) = (tool.feed.texts(4), tool.rpm.texts(0));
            write!(out, "{number:>9}{low:>11}{high:>11}{slow:>9}{fast:>9}")?;
            let total = tool.feed_ns + tool.rapid_ns + tool.misc_ns;
            for ns in [tool.feed_ns, tool.rapid_ns, tool.misc_ns, total] {
                write!(out, "{:>10}", clock(ns))?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

/// Characters of a name; the summary has the whole of it.
const NAME: usize = 16;

fn size(value: Option<f64>) -> String {
    value.map_or_else(|| "NA".to_owned(), |value| format!("{value:.4}"))
}

fn join(list: &[u32]) -> String {
    if list.is_empty() {
        return "NA".to_owned();
    }
    list.iter().map(u32::to_string).collect::<Vec<_>>().join(",")
}
