//! The parts of a job.

use std::sync::Arc;

use counterpoint_machine::Machine;
use counterpoint_ports::options::JobOptions;

/// A program given to a channel.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct ProgramSelection {
    /// File in the job's files.
    pub file: String,
    /// O-number inside the file; none = the file's first (or next free) main program.
    pub number: Option<u32>,
    /// Name of a program or of a channel's section inside the file (`PART_1`, `$2`, `G14`); none = by number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub section: Option<String>,
    /// Channel number; none = left to right.
    pub channel: Option<u16>,
}

/// Everything a job consists of.
#[derive(Debug, Clone)]
pub struct Spec {
    /// The checked machine.
    pub machine: Arc<Machine>,
    /// Programs, left to right.
    pub programs: Vec<ProgramSelection>,
    /// Options.
    pub options: JobOptions,
}
