//! What a job consists of.

use std::sync::Arc;

use counterpoint_machine::Machine;
use counterpoint_ports::options::Options;

/// A program given to a channel.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Program {
    /// File in the job's files.
    pub file: String,
    /// O-number inside the file; none = the file's first (or next free) main program.
    pub number: Option<u32>,
    /// Channel number; none = left to right.
    pub channel: Option<u16>,
}

/// Everything a job consists of.
#[derive(Debug, Clone)]
pub struct Spec {
    /// The checked machine.
    pub machine: Arc<Machine>,
    /// Programs, left to right.
    pub programs: Vec<Program>,
    /// Options.
    pub options: Options,
}
