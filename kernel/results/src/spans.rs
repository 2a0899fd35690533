//! When which tool of a channel was in work, and on what.
//!
//! The operation is the comment of the block that loads the tool, or of a line of comment next to it: that is where
//! people and CAM systems write it; a tool with a name of its own goes by that. *Invariant:* spans of a channel ascend and
//! do not overlap; there are at most `MOST`.

use std::sync::Arc;

use serde::Serialize;

use crate::tools::Tool;
use counterpoint_event::event::{Event, FileId, Kind, ToolAction, ToolChange};
use counterpoint_event::info::{Info, cut};

/// Spans of a channel at most.
const MOST: usize = 10_000;

/// Characters of an operation at most.
const LONGEST: usize = 60;

/// A stretch of time with one tool.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Span {
    /// Tool as programmed.
    pub tool: u32,
    /// What it does, empty when nothing says so.
    pub operation: Arc<str>,
    /// When it was called for, ns.
    pub t_ns: i64,
    /// When the next one was, or the end of the channel, ns.
    pub end_ns: i64,
    /// File of the block that loads it.
    pub file: Arc<str>,
    /// Line of that block.
    pub line: u32,
}

/// Collects them.
#[derive(Debug, Default)]
pub struct Spans {
    /// Tool, time, file and line of each load.
    loads: Vec<(u32, i64, FileId, u32)>,
    /// When the first one came that is not listed.
    full: Option<i64>,
}

impl Spans {
    /// Any event that is neither block nor motion; gives the tool that it loads.
    pub fn event(&mut self, event: &Event) -> Option<u32> {
        let Kind::Tool(ToolChange { action: ToolAction::Load, tool, .. }) = event.kind else { return None };
        let again = self.loads.last().is_some_and(|(last, ..)| *last == tool);
        match self.loads.len() {
            _ if again => {}
            0..MOST => self.loads.push((tool, event.t_ns, event.file, event.line)),
            _ => self.full = self.full.or(Some(event.t_ns)),
        }
        Some(tool)
    }

    /// All of them up to the end of the channel.
    pub fn finish(self, info: &Info, tools: &[Tool], end_ns: i64) -> Vec<Span> {
        let end_ns = self.full.unwrap_or(end_ns).min(end_ns);
        let ends = self.loads.iter().skip(1).map(|(_, t_ns, ..)| *t_ns).chain([end_ns]);
        let span = |((tool, t_ns, file, line), end_ns): (&(u32, i64, FileId, u32), i64)| {
            let known = tools.iter().find(|row| row.tool == *tool).filter(|row| !row.name.is_empty());
            let operation = known.map_or_else(|| operation(info, *file, *line), |row| row.name.clone());
            let file = info.file_name(*file).into();
            Span { tool: *tool, operation: operation.into(), t_ns: *t_ns, end_ns: end_ns.max(*t_ns), file, line: *line }
        };
        self.loads.iter().zip(ends).filter(|((tool, ..), _)| *tool != 0).map(span).collect()
    }
}

/// The comment of a block, of the line after it, or of the two lines before it.
fn operation(info: &Info, file: FileId, line: u32) -> String {
    if line == 0 {
        return String::new();
    }
    let text = |line: u32| info.line_text(file, line).trim().to_owned();
    let alone = |text: String| comment(&text).filter(|_| text.starts_with(['(', ';']));
    let found = comment(&text(line))
        .or_else(|| alone(text(line.saturating_add(1))))
        .or_else(|| alone(text(line - 1)))
        .or_else(|| alone(text(line.saturating_sub(2))));
    cut(&found.unwrap_or_default(), LONGEST)
}

/// The text in brackets or after a semicolon.
fn comment(text: &str) -> Option<String> {
    let bracket = text.split_once('(').map(|(_, rest)| rest.split_once(')').map_or(rest, |(inside, _)| inside));
    let found = bracket.or_else(|| text.split_once(';').map(|(_, rest)| rest))?;
    let found = found.split_whitespace().collect::<Vec<_>>().join(" ");
    (!found.is_empty()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, lathe};

    fn load(line: u32, t_ns: i64, tool: u32) -> Event {
        at(1, line, t_ns, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool, offset: tool }))
    }

    #[test]
    fn a_span_lasts_to_the_next_tool_and_has_its_comment() {
        let info = lathe(&["O1 (PART)\nT0101 (OD  ROUGH)\nG0 X1.\n(DRILL D8)\nN2\nT0202\nT0303 ; BORE\nT0404\n;\n"]);
        let mut spans = Spans::default();
        for event in [load(2, 10, 1), load(3, 20, 1), load(6, 30, 2), load(7, 40, 3), load(8, 60, 0), load(8, 70, 4)] {
            spans.event(&event);
        }
        let tools = [Tool { tool: 3, name: "BORING BAR".into(), ..Tool::default() }];
        let spans = spans.finish(&info, &tools, 100);
        let shown: Vec<_> = spans.iter().map(|s| (s.tool, &*s.operation, s.t_ns, s.end_ns, s.line)).collect();
        let expected =
            [(1, "OD ROUGH", 10, 30, 2), (2, "DRILL D8", 30, 40, 6), (3, "BORING BAR", 40, 60, 7), (4, "", 70, 100, 8)];
        assert_eq!(shown, expected);
        assert_eq!(&*spans[0].file, "jobs/p1.nc");
    }

    #[test]
    fn a_program_that_changes_tools_for_ever_has_bounded_spans() {
        let mut spans = Spans::default();
        (0..30_000).for_each(|n| {
            spans.event(&load(1, i64::from(n), n % 2 + 1));
        });
        let spans = spans.finish(&lathe(&["x"]), &[], 1_000_000);
        assert_eq!((spans.len(), spans.last().map(|s| s.end_ns)), (MOST, Some(MOST as i64)));
    }
}
