//! Periods of use of the tools of a channel, and their work.
//!
//! The operation is the comment of the block that loads the tool, or of a line of comment next to it: that is where
//! people and CAM systems write it. A tool with a name goes by that: its name in the machine's table, otherwise the
//! name by which the block calls it. *Invariant:* spans of a channel ascend and do not overlap; there are at most
//! `MOST`.

use std::sync::Arc;

use serde::Serialize;

use crate::tools::ToolSummary;
use counterpoint_event::event::{Event, FileId, Kind, ToolAction, ToolChange};
use counterpoint_event::info::{Info, cut};

/// Spans of a channel at most.
const MOST: usize = 10_000;

/// Characters of an operation at most.
const LONGEST: usize = 60;

/// A stretch of time with one tool.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ToolSpan {
    /// Tool as programmed.
    pub tool: u32,
    /// Its effect; empty if unknown.
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
pub struct ToolSpanCollector {
    /// Tool, time, file and line of each load.
    loads: Vec<(u32, i64, FileId, u32)>,
    /// When the first one came that is not listed.
    full: Option<i64>,
}

impl ToolSpanCollector {
    /// Any event that is neither block nor motion; returns the tool that it loads.
    pub fn event(&mut self, event: &Event) -> Option<u32> {
        let Kind::Tool(ToolChange { action: ToolAction::Load, tool, .. }) = event.kind else { return None };
        let place = event.user_place();
        let again = self.loads.last().is_some_and(|(last, ..)| *last == tool);
        match self.loads.len() {
            _ if again => {}
            0..MOST => self.loads.push((tool, event.t_ns, place.file, place.line)),
            _ => self.full = self.full.or(Some(event.t_ns)),
        }
        Some(tool)
    }

    /// All of them up to the end of the channel.
    pub fn finish(self, info: &Info, tools: &[ToolSummary], end_ns: i64) -> Vec<ToolSpan> {
        let end_ns = self.full.unwrap_or(end_ns).min(end_ns);
        let ends = self.loads.iter().skip(1).map(|(_, t_ns, ..)| *t_ns).chain([end_ns]);
        let span = |((tool, t_ns, file, line), end_ns): (&(u32, i64, FileId, u32), i64)| {
            let known = tools.iter().find(|row| row.tool == *tool).filter(|row| !row.name.is_empty());
            let operation = known.map_or_else(|| operation(info, *file, *line), |row| row.name.clone());
            let file = info.file_name(*file).into();
            ToolSpan {
                tool: *tool,
                operation: operation.into(),
                t_ns: *t_ns,
                end_ns: end_ns.max(*t_ns),
                file,
                line: *line,
            }
        };
        self.loads.iter().zip(ends).filter(|((tool, ..), _)| *tool != 0).map(span).collect()
    }
}

/// The name of the tool in its block; the comment of the block, of the line after it, or of the two lines before it.
fn operation(info: &Info, file: FileId, line: u32) -> String {
    if line == 0 {
        return String::new();
    }
    let text = |line: u32| info.line_text(file, line).trim().to_owned();
    let alone = |text: String| comment(&text).filter(|_| text.starts_with(['(', ';']));
    let block = text(line);
    let found = called_name(&block)
        .or_else(|| comment(&block))
        .or_else(|| alone(text(line.saturating_add(1))))
        .or_else(|| alone(text(line - 1)))
        .or_else(|| alone(text(line.saturating_sub(2))));
    cut(&found.unwrap_or_default(), LONGEST)
}

/// The name in `T="DRILL 8"` or `TOOL CALL "DRILL 8"`.
fn called_name(text: &str) -> Option<String> {
    let (before, rest) = text.split_once('"')?;
    let before = before.trim_end().to_ascii_uppercase();
    let word = before.strip_suffix('=').unwrap_or(&before).trim_end();
    let word = word.rsplit(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
    let calls = before.ends_with("TOOL CALL") || word.trim_end_matches(|c: char| c.is_ascii_digit()) == "T";
    let (name, _) = rest.split_once('"')?;
    (calls && !name.trim().is_empty()).then(|| name.trim().to_owned())
}

/// The text in brackets or after a semicolon, whichever comes first.
fn comment(text: &str) -> Option<String> {
    let before = |at: usize| text.get(..at).unwrap_or_default();
    let (at, mark) = text.match_indices(['(', ';']).find(|(at, mark)| *mark == ";" || !ends_with_name(before(*at)))?;
    let rest = text.get(at + 1..)?;
    let found = if mark == "(" { rest.split_once(')').map_or(rest, |(inside, _)| inside) } else { rest };
    let found = found.split_whitespace().collect::<Vec<_>>().join(" ");
    (!found.is_empty()).then_some(found)
}

/// Whether a text ends with a name of several letters, whose brackets enclose arguments: `CYCLE81(`, not `T01(`.
fn ends_with_name(text: &str) -> bool {
    let word = text.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next().unwrap_or_default();
    word.chars().take(2).filter(char::is_ascii_alphabetic).count() == 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_names_and_comments_of_their_blocks() {
        let cases = [
            ("T0101(OD ROUGH)", "OD ROUGH"),
            ("T1 M6 ; FACE (50 MM)", "FACE (50 MM)"),
            ("T1 M6 (FACE; ROUGH)", "FACE; ROUGH"),
            ("T=\"FINISH 35\" D1 ; AFTER", "FINISH 35"),
            ("T2 = \"DRILL\" M6", "DRILL"),
            ("TOOL CALL \"MILL D20\" Z S2000 ; ROUGH", "MILL D20"),
            ("T3 M6 MSG(\"change\")", ""),
            ("T3 MSG(\"change\") ; BORE", "BORE"),
            ("TC(1) T4 (TAP)", "TAP"),
        ];
        for (line, expected) in cases {
            let info = lathe(&[&format!("O1\nG0 X1.\nG0 X2.\n{line}\nG0 X3.\n")]);
            assert_eq!(operation(&info, 0, 4), expected, "{line}");
        }
        let info = lathe(&["; WAITM(98,1,2) STANDS IN BOTH\nT1\n"]);
        assert_eq!(operation(&info, 0, 2), "WAITM(98,1,2) STANDS IN BOTH");
    }
    use crate::testing::{at, lathe};

    fn load(line: u32, t_ns: i64, tool: u32) -> Event {
        at(1, line, t_ns, 0, Kind::Tool(ToolChange { action: ToolAction::Load, tool, offset: tool }))
    }

    #[test]
    fn a_span_lasts_to_the_next_tool_and_has_its_comment() {
        let info = lathe(&["O1 (PART)\nT0101 (OD  ROUGH)\nG0 X1.\n(DRILL D8)\nN2\nT0202\nT0303 ; BORE\nT0404\n;\n"]);
        let mut spans = ToolSpanCollector::default();
        for event in [load(2, 10, 1), load(3, 20, 1), load(6, 30, 2), load(7, 40, 3), load(8, 60, 0), load(8, 70, 4)] {
            spans.event(&event);
        }
        let tools = [ToolSummary { tool: 3, name: "BORING BAR".into(), ..ToolSummary::default() }];
        let spans = spans.finish(&info, &tools, 100);
        let shown: Vec<_> = spans.iter().map(|s| (s.tool, &*s.operation, s.t_ns, s.end_ns, s.line)).collect();
        let expected =
            [(1, "OD ROUGH", 10, 30, 2), (2, "DRILL D8", 30, 40, 6), (3, "BORING BAR", 40, 60, 7), (4, "", 70, 100, 8)];
        assert_eq!(shown, expected);
        assert_eq!(&*spans[0].file, "jobs/p1.nc");
    }

    #[test]
    fn a_program_that_changes_tools_for_ever_has_bounded_spans() {
        let mut spans = ToolSpanCollector::default();
        (0..30_000).for_each(|n| {
            spans.event(&load(1, i64::from(n), n % 2 + 1));
        });
        let spans = spans.finish(&lathe(&["x"]), &[], 1_000_000);
        assert_eq!((spans.len(), spans.last().map(|s| s.end_ns)), (MOST, Some(MOST as i64)));
    }
}
