//! The two tooling tables.
//!
//! Layout: reference listing-and-trace.md 7.1, rows in load order. Invariant: time counts for the tool in use when it
//! passes; a tool change counts for the new tool.

use std::io::{Result, Write};

use rustc_hash::FxHashMap;

use super::time::clock;
use crate::log::event::{Direction, Event, FeedUnit, Kind, Motion, MotionKind, Spindle, ToolAction};
use crate::log::work::Work;

/// Offsets listed per tool; a program with more of them has a mistake that the table need not show in full.
const MOST_OFFSETS: usize = 64;

/// Smallest and largest value seen.
#[derive(Debug, Default)]
struct Range(Option<(f64, f64)>);

impl Range {
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
struct Tool {
    number: u32,
    length_offsets: Vec<u32>,
    diameter_offsets: Vec<u32>,
    feed: Range,
    rpm: Range,
    feed_ns: i64,
    rapid_ns: i64,
    misc_ns: i64,
}

/// Collects the tools of a channel.
#[derive(Debug)]
pub(super) struct Tooling {
    tools: Vec<Tool>,
    rows: FxHashMap<u32, usize>,
    current: Option<usize>,
    spindle: Option<Spindle>,
    end_ns: i64,
}

impl Tooling {
    /// `end_ns`: when the channel ended; durations are cut there.
    pub(super) fn new(end_ns: i64) -> Self {
        Self { tools: Vec::new(), rows: FxHashMap::default(), current: None, spindle: None, end_ns }
    }

    /// Any event of the channel that is no motion.
    pub(super) fn event(&mut self, event: &Event) {
        match &event.kind {
            Kind::Tool { action: ToolAction::Select, .. } => {}
            Kind::Tool { tool, offset, .. } => self.load(*tool, *offset),
            Kind::Mode { text } => self.offset_mode(text),
            Kind::Spindle(spindle) => {
                let turns = matches!(spindle.direction, Direction::Clockwise | Direction::CounterClockwise);
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

    fn tool(&mut self) -> Option<&mut Tool> {
        self.current.and_then(|index| self.tools.get_mut(index))
    }

    fn load(&mut self, number: u32, offset: u32) {
        if number == 0 {
            return;
        }
        let index = *self.rows.entry(number).or_insert_with(|| {
            self.tools.push(Tool { number, ..Tool::default() });
            self.tools.len() - 1
        });
        self.current = Some(index);
        if let Some(tool) = self.tool() {
            note(&mut tool.length_offsets, offset);
        }
    }

    /// `comp length n=3`, `comp diam left n=3`.
    fn offset_mode(&mut self, text: &str) {
        let Some(number) = text.rsplit_once("n=").and_then(|(_, n)| n.parse().ok()) else { return };
        let Some(tool) = self.tool() else { return };
        if text.starts_with("comp length") {
            note(&mut tool.length_offsets, number);
        } else if text.starts_with("comp diam") {
            note(&mut tool.diameter_offsets, number);
        }
    }

    fn time(&mut self, event: &Event) {
        let Some(work) = Work::of(&event.kind) else { return };
        let ns = event.dur_ns.min(self.end_ns.saturating_sub(event.t_ns)).max(0);
        let Some(tool) = self.tool() else { return };
        match work {
            Work::Feed => tool.feed_ns += ns,
            Work::Rapid => tool.rapid_ns += ns,
            Work::Tool | Work::Dwell | Work::Misc => tool.misc_ns += ns,
            Work::Wait => {}
        }
    }

    pub(super) fn write(&self, out: &mut dyn Write) -> Result<()> {
        write!(out, "\nTOOLING SUMMARY:\n\n")?;
        writeln!(out, "     TOOL  NAME              DIAMETER    RADIUS  LENGTH-OFFSETS  DIAM-OFFSETS")?;
        for tool in &self.tools {
            let [length, diameter] = [&tool.length_offsets, &tool.diameter_offsets].map(|list| join(list));
            writeln!(out, "{:>9}  {:<16}{:>10}{:>10}{length:>16}{diameter:>14}", tool.number, "NA", "NA", "NA")?;
        }
        writeln!(out)?;
        writeln!(out, "     TOOL   MIN-FEED   MAX-FEED  MIN-RPM  MAX-RPM      FEED     RAPID      MISC     TOTAL")?;
        for tool in &self.tools {
            let ([low, high], [slow, fast]) = (tool.feed.texts(4), tool.rpm.texts(0));
            write!(out, "{:>9}{low:>11}{high:>11}{slow:>9}{fast:>9}", tool.number)?;
            let total = tool.feed_ns + tool.rapid_ns + tool.misc_ns;
            for ns in [tool.feed_ns, tool.rapid_ns, tool.misc_ns, total] {
                write!(out, "{:>10}", clock(ns))?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

fn note(list: &mut Vec<u32>, number: u32) {
    if number != 0 && list.len() < MOST_OFFSETS && !list.contains(&number) {
        list.push(number);
    }
}

fn join(list: &[u32]) -> String {
    if list.is_empty() {
        return "NA".to_owned();
    }
    list.iter().map(u32::to_string).collect::<Vec<_>>().join(",")
}
