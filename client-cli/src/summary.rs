//! `summary.json` as far as the report needs it.

use serde::Deserialize;

/// summary.json as far as the report needs it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportSummary {
    pub(crate) state: String,
    pub(crate) unit: String,
    pub(crate) coordinates: Option<ReportCoordinates>,
    pub(crate) highest_severity: u32,
    pub(crate) makespan_ns: i64,
    pub(crate) channels: Vec<ReportChannel>,
    pub(crate) waits: Vec<ReportWait>,
    pub(crate) verdict: Option<ReportVerdict>,
    pub(crate) diagnostics: Vec<ReportDiagnostic>,
}

/// The units in which coordinates were read.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportCoordinates {
    pub(crate) text: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportChannel {
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
    pub(crate) tools: Vec<ReportTool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportTool {
    pub(crate) tool: u32,
    pub(crate) name: String,
    pub(crate) diameter: Option<f64>,
    pub(crate) radius: Option<f64>,
    pub(crate) length_offsets: Vec<u32>,
    pub(crate) diameter_offsets: Vec<u32>,
    pub(crate) operation: String,
    pub(crate) times: ReportToolTimes,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(default)]
pub(crate) struct ReportToolTimes {
    pub(crate) feed_ns: i64,
    pub(crate) rapid_ns: i64,
    pub(crate) misc_ns: i64,
    pub(crate) wait_ns: i64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportWait {
    pub(crate) key: String,
    pub(crate) release_ns: Option<i64>,
    pub(crate) arrivals: Vec<ReportArrival>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportArrival {
    pub(crate) channel: u32,
    pub(crate) t_ns: i64,
    pub(crate) line: u32,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportVerdict {
    pub(crate) kind: String,
    pub(crate) text: String,
    pub(crate) members: Vec<ReportMember>,
}

/// A channel in the verdict.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportMember {
    pub(crate) channel: u32,
    pub(crate) file: String,
    pub(crate) line: u32,
    pub(crate) block: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportDiagnostic {
    pub(crate) number: u32,
    pub(crate) severity: u32,
    pub(crate) channel: u32,
    pub(crate) file: String,
    pub(crate) line: u32,
    pub(crate) block: String,
    pub(crate) text: String,
    pub(crate) origin: Option<ReportOrigin>,
}

/// The statement of a macro that raised a diagnostic.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ReportOrigin {
    pub(crate) file: String,
    pub(crate) line: u32,
}

impl ReportSummary {
    /// Stopped before its end on request.
    pub(crate) fn cancelled(&self) -> bool {
        self.state == "CANCELLED"
    }
}
