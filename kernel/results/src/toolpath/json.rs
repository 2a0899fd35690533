//! The path as JSON segments, written straight from the moves.

use serde::ser::{Serialize, SerializeSeq, SerializeStruct, Serializer};

use super::store::{Curve, PathMove, RecordedPath, Stroke};
use super::{ChannelToolpath, ToolpathView};

impl Serialize for ChannelToolpath {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Channel", 8)?;
        out.serialize_field("channel", &self.channel)?;
        out.serialize_field("name", &self.name)?;
        out.serialize_field("side", if self.lower { "lower" } else { "upper" })?;
        let tool = |(tool, name): &(u32, String)| ToolpathTool { tool: *tool, name: name.clone() };
        out.serialize_field("tools", &self.tools.iter().map(tool).collect::<Vec<_>>())?;
        out.serialize_field("truncated", &self.path.truncated)?;
        out.serialize_field("segments", &ToolpathSegments { channel: self, path: &self.path, view: self.view })?;
        if let Some(face) = &self.face {
            out.serialize_field("face", &ToolpathSegments { channel: self, path: face, view: ToolpathView::Xyz })?;
        }
        if let Some(stop) = &self.stop {
            out.serialize_field("stop", stop)?;
        }
        out.end()
    }
}

#[derive(serde::Serialize)]
struct ToolpathTool {
    tool: u32,
    name: String,
}

struct ToolpathSegments<'a> {
    channel: &'a ChannelToolpath,
    path: &'a RecordedPath,
    view: ToolpathView,
}

impl Serialize for ToolpathSegments<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (path, view) = (self.path, self.view);
        let mut out = serializer.serialize_seq(None)?;
        let mut from = [0.0; 3];
        for (mark, moves) in path.sections() {
            let file = self.channel.info.file_name(mark.file);
            let mut rest = moves;
            while let [first, tail @ ..] = rest {
                if first.stroke() == Stroke::Start {
                    (from, rest) = (first.to(), tail);
                    continue;
                }
                let straight = |m: &PathMove| m.stroke() == first.stroke() && path.curve(m).is_none();
                let count = match path.curve(first) {
                    Some(_) => 1,
                    None => rest.iter().position(|m| !straight(m)).unwrap_or(rest.len()),
                };
                let (run, tail) = rest.split_at(count);
                let tool = mark.tool;
                out.serialize_element(&Segment { from, run, curve: path.curve(first), view, tool, file })?;
                from = run.last().map_or(from, PathMove::to);
                rest = tail;
            }
        }
        out.end()
    }
}

struct Segment<'a> {
    from: [f64; 3],
    run: &'a [PathMove],
    curve: Option<&'a Curve>,
    view: ToolpathView,
    tool: u32,
    file: &'a str,
}

impl Serialize for Segment<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_struct("Segment", 8)?;
        let kind = match (self.curve, self.run.first().map(PathMove::stroke)) {
            (Some(curve), _) if curve.angle < 0.0 => "arc_cw",
            (Some(_), _) => "arc_ccw",
            (None, Some(Stroke::Rapid)) => "rapid",
            (None, Some(Stroke::Thread)) => "thread",
            (None, _) => "feed",
        };
        out.serialize_field("kind", kind)?;
        out.serialize_field("points", &Points { from: self.from, run: self.run, view: self.view })?;
        if let Some(curve) = self.curve {
            let letter = |c: u8| self.view.letters().get(usize::from(c)).copied().unwrap_or('?');
            out.serialize_field("plane", &curve.plane.map(letter).iter().collect::<String>())?;
            out.serialize_field("center", &curve.center.map(rounded))?;
            out.serialize_field("turns", &curve.turns)?;
        }
        out.serialize_field("tool", &self.tool)?;
        out.serialize_field("file", self.file)?;
        out.serialize_field("lines", &MoveLines(self.run))?;
        out.end()
    }
}

/// The line of each move.
struct MoveLines<'a>(&'a [PathMove]);

impl Serialize for MoveLines<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(|step| step.line))
    }
}

struct Points<'a> {
    from: [f64; 3],
    run: &'a [PathMove],
    view: ToolpathView,
}

impl Serialize for Points<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_seq(None)?;
        for point in std::iter::once(self.from).chain(self.run.iter().map(PathMove::to)) {
            for value in point.iter().take(self.view.letters().len()) {
                out.serialize_element(&rounded(*value))?;
            }
        }
        out.end()
    }
}

/// Ten-thousandths, no minus zero.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}
