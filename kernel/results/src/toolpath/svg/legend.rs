//! Colours of the tools, and the legend that names them.

use std::fmt::Write as _;

use super::colors::colors;
use super::holes;
use super::sight::sights;
use super::{KINDS, LEFT, RIGHT, SOFT};
use crate::svg::{fit, text, width};
use crate::toolpath::store::{RecordedPath, Stroke};
use crate::toolpath::{ChannelToolpath, Toolpath};

/// Name of the marks of holes.
const HOLE: &str = "hole";
/// Rows of the legend at most.
const ROWS: usize = 5;
/// Height of a row, px.
const ROW: f64 = 18.0;
/// Width of a name at most, px.
const NAME: f64 = 260.0;

/// An entry with its place.
struct LegendEntry {
    name: String,
    color: String,
    style: &'static str,
    at: (f64, f64),
}

/// Colours by channel and tool.
pub(super) struct Palette {
    tools: Vec<(usize, u32, String)>,
    entries: Vec<LegendEntry>,
    rows: usize,
}

impl Palette {
    pub(super) fn new(toolpath: &Toolpath) -> Self {
        let mut tools = Vec::new();
        let mut names = Vec::new();
        let several = toolpath.channels.len() > 1;
        let count = toolpath.channels.iter().map(|channel| channel.tools.len()).sum();
        let mut colors = colors(count).into_iter();
        for (index, channel) in toolpath.channels.iter().enumerate() {
            for (tool, name) in &channel.tools {
                // Moves before the first tool of a channel that has tools.
                if *tool == 0 && channel.tools.len() > 1 {
                    tools.push((index, 0, SOFT.to_owned()));
                    if cuts(&channel.path) {
                        names.push((label(channel, "no tool", "", several), SOFT.to_owned()));
                    }
                    continue;
                }
                let color = colors.next().unwrap_or_else(|| SOFT.to_owned());
                tools.push((index, *tool, color.clone()));
                let number = if *tool == 0 { String::new() } else { format!("T{tool}") };
                names.push((label(channel, &number, name, several || *tool == 0), color));
            }
        }
        let mut palette = Self { tools, entries: Vec::new(), rows: 0 };
        palette.place(names, toolpath);
        palette
    }

    /// Finds a place for every entry, kinds of moves first.
    fn place(&mut self, names: Vec<(String, String)>, toolpath: &Toolpath) {
        // The first move starts a path; a further start is a change of frame.
        let used = |stroke: Stroke| {
            let skipped = usize::from(stroke == Stroke::Start);
            toolpath.channels.iter().any(|c| c.path.moves.iter().skip(skipped).any(|m| m.stroke() == stroke))
        };
        let kinds = KINDS.into_iter().filter(|(stroke, ..)| used(*stroke));
        let holes = sights(toolpath).iter().any(|sight| {
            sight.shows_holes && super::paths(toolpath, sight.source).any(|(path, _)| holes::has_any(path))
        });
        let hole = holes.then_some((Stroke::Start, HOLE, ""));
        let kinds = kinds.chain(hole).map(|(_, name, style)| (name.to_owned(), SOFT.to_owned(), style));
        let count = names.len();
        let names = names.into_iter().map(|(name, color)| (fit(&name, 12, NAME), color, r#"stroke-width="4""#));
        let (mut x, mut row) = (LEFT, 0);
        for (index, (name, color, style)) in kinds.chain(names).enumerate() {
            let wide = 32.0 + width(&name, 12) + 20.0;
            if x + wide > RIGHT {
                (x, row) = (LEFT, row + 1);
            }
            // The last row keeps room for how many are left.
            let last = row + 1 == ROWS && x + wide > RIGHT - 120.0;
            let left = count.saturating_sub(index.saturating_sub(self.kinds()));
            if last && left > 1 {
                let name = format!("and {left} more tools");
                let at = (x, row as f64 * ROW);
                self.entries.push(LegendEntry { name, color: SOFT.to_owned(), style: r#"stroke-width="0""#, at });
                break;
            }
            self.entries.push(LegendEntry { name, color, style, at: (x, row as f64 * ROW) });
            x += wide;
        }
        self.rows = row + 1;
    }

    /// Entries that are kinds of moves.
    fn kinds(&self) -> usize {
        self.entries.iter().filter(|e| e.name == HOLE || KINDS.iter().any(|(_, name, _)| *name == e.name)).count()
    }

    /// Height of all rows but the first, px.
    pub(super) fn height(&self) -> f64 {
        self.rows.saturating_sub(1) as f64 * ROW
    }

    /// Colour of a tool of a channel, by its index.
    pub(super) fn color(&self, channel: usize, tool: u32) -> &str {
        self.tools.iter().find(|(c, t, _)| (*c, *t) == (channel, tool)).map_or(SOFT, |(_, _, color)| color)
    }

    pub(super) fn draw(&self, out: &mut String) {
        for LegendEntry { name, color, style, at: (x, y) } in &self.entries {
            let middle = 46.0 + y;
            let _ = if name == HOLE {
                writeln!(
                    out,
                    r#"<path fill="none" stroke="{color}" d="M{:.1} {middle:.1}h7m-3.5-3.5v7m-3.5-3.5a3.5 3.5 0 0 1 7 0a3.5 3.5 0 0 1-7 0"/>"#,
                    x + 9.5
                )
            } else if style.starts_with("stroke=") {
                writeln!(out, r#"<path {style} d="M{x:.0} {middle:.0}h26"/>"#)
            } else {
                writeln!(out, r#"<path stroke="{color}" {style} d="M{x:.0} {middle:.0}h26"/>"#)
            };
            text(out, (x + 32.0, 50.0 + y), 12, "start", SOFT, name);
        }
    }
}

fn cuts(path: &RecordedPath) -> bool {
    let unequipped = path.sections().take_while(|(mark, _)| mark.tool == 0);
    unequipped.flat_map(|(_, moves)| moves).any(|step| matches!(step.stroke(), Stroke::Feed | Stroke::Thread))
}

/// `1 UPPER T3 GROOVE (not to its end)`, as far as it is needed.
fn label(channel: &ChannelToolpath, tool: &str, name: &str, with_channel: bool) -> String {
    let cut = if channel.path.truncated { "(not to its end)" } else { "" };
    let number = channel.channel.to_string();
    let whole = [
        if with_channel { number.as_str() } else { "" },
        if with_channel { &channel.name } else { "" },
        tool,
        name,
        cut,
    ];
    whole.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}
