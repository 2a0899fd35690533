//! `summary.json` as far as the report needs it.

use serde::Deserialize;

/// summary.json as far as the report needs it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Summary {
    pub(crate) state: String,
    pub(crate) unit: String,
    pub(crate) coordinates: Option<Coordinates>,
    pub(crate) highest_severity: u32,
    pub(crate) makespan_ns: i64,
    pub(crate) channels: Vec<Channel>,
    pub(crate) waits: Vec<Wait>,
    pub(crate) verdict: Option<Verdict>,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// The units in which coordinates were read.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Coordinates {
    pub(crate) text: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Channel {
    pub(crate) channel: u32,
    pub(crate) name: String,
    pub(crate) program: String,
    pub(crate) state: String,
    pub(crate) blocks: u64,
    pub(crate) end_ns: i64,
    pub(crate) feed_ns: i64,
    pub(crate) rapid_ns: i64,
    pub(crate) misc_ns: i64,
    pub(crate) wait_ns: i64,
    pub(crate) tools: Vec<Tool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Tool {
    pub(crate) tool: u32,
    pub(crate) name: String,
    pub(crate) diameter: Option<f64>,
    pub(crate) radius: Option<f64>,
    pub(crate) length_offsets: Vec<u32>,
    pub(crate) diameter_offsets: Vec<u32>,
    pub(crate) operation: String,
    pub(crate) times: ToolTimes,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(default)]
pub(crate) struct ToolTimes {
    pub(crate) feed_ns: i64,
    pub(crate) rapid_ns: i64,
    pub(crate) misc_ns: i64,
    pub(crate) wait_ns: i64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Wait {
    pub(crate) key: String,
    pub(crate) release_ns: Option<i64>,
    pub(crate) arrivals: Vec<Arrival>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Arrival {
    pub(crate) channel: u32,
    pub(crate) t_ns: i64,
    pub(crate) line: u32,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Verdict {
    pub(crate) kind: String,
    pub(crate) text: String,
    pub(crate) members: Vec<Member>,
}

/// A channel in the verdict.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Member {
    pub(crate) channel: u32,
    pub(crate) file: String,
    pub(crate) line: u32,
    pub(crate) block: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Diagnostic {
    pub(crate) number: u32,
    pub(crate) severity: u32,
    pub(crate) channel: u32,
    pub(crate) file: String,
    pub(crate) line: u32,
    pub(crate) block: String,
    pub(crate) text: String,
    pub(crate) origin: Option<Origin>,
}

/// The statement of a macro that raised a diagnostic.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Origin {
    pub(crate) file: String,
    pub(crate) line: u32,
}

impl Summary {
    /// Stopped before its end on request.
    pub(crate) fn cancelled(&self) -> bool {
        self.state == "CANCELLED"
    }
}
