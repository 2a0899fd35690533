//! What the server can be told: flags over environment over configuration file over defaults.
//!
//! Invariant: every option exists in all three forms under one name (`queue` = `--queue` = `COUNTERPOINT_QUEUE`),
//! and [`Options::to_toml`] prints a file that gives the same options again.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use counterpoint_kernel::options::Limits;
use serde::{Deserialize, Serialize};

const MOST: Limits = Limits::MOST;

/// Options of a server.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Address to listen on; port 0 = any free port.
    pub listen: SocketAddr,
    /// Folder of ledger, blobs, logs and results.
    pub data: PathBuf,
    /// Jobs that run at the same time; 0 = one per processor core.
    pub workers: usize,
    /// Jobs that may wait in the queue.
    pub queue: usize,
    /// Runs begun before a job that takes the server down with it is given up.
    pub attempts: u32,
    /// Seconds that running jobs get to end after a stop signal.
    pub grace_s: u64,
    /// Seconds that a dialog of an attended job waits for the operator before it fails.
    pub operator_wait_s: u64,
    /// Macros may start commands of the operating system (`SYSTEM`), with the rights of the server.
    pub allow_system: bool,
    /// Seconds after which such a command is ended.
    pub system_wait_s: u64,
    /// Largest blob, bytes.
    pub max_blob_bytes: u64,
    /// Most files of one job or machine.
    pub max_files: usize,
    /// Most programs of one job.
    pub max_programs: usize,
    /// Free bytes on the disk of the data folder below which no run starts and no job or upload is accepted.
    pub min_free_bytes: u64,
    /// Most time of one run by the clock, ms; also the default of a job.
    pub max_wall_ms: u64,
    /// Most bytes of a log, and of the files that macros of a job have written; also the default of a job.
    pub max_job_bytes: u64,
    /// Most simulated time of a job, ns.
    pub max_simulated_ns: i64,
    /// Most blocks of a channel.
    pub max_blocks: u64,
    /// Most consecutive blocks of a channel that take no time.
    pub max_zero_time_blocks: u64,
    /// Most events of a channel.
    pub max_events: u64,
    /// Longest block, bytes.
    pub max_block_length: usize,
    /// Deepest nesting of subprograms.
    pub max_nesting: u16,
    /// Most diagnostics kept of a channel.
    pub max_diagnostics: u32,
    /// Most memory for variables, texts, files and results of a job, bytes.
    pub max_memory: u64,
    /// Most steps of macros of a channel.
    pub max_macro_steps: u64,
    /// Most bytes of all files of a machine.
    pub max_machine_bytes: u64,
    /// Seconds that a new connection gets to begin to speak HTTP/2.
    pub preface_s: u64,
    /// Seconds after which a connection without calls is closed.
    pub idle_s: u64,
    /// Seconds that an upload may stand still.
    pub upload_stall_s: u64,
    /// Most connections; fewer if the process may not have that many descriptors.
    pub max_connections: usize,
    /// Most connections of one address.
    pub max_connections_per_address: usize,
    /// Most uploads at the same time.
    pub max_uploads: usize,
    /// Most uploads of one connection at the same time.
    pub max_uploads_per_connection: usize,
    /// Nothing survives: no fsync, ledger in memory. For a server that lives as long as one command.
    #[serde(skip)]
    pub ephemeral: bool,
    /// Keep the event log of a job. Without it there are no listings, events and event watches; only a server that
    /// knows that nobody will ask (a command that runs one job) leaves it away.
    #[serde(skip, default = "yes")]
    pub log: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 7878)),
            data: PathBuf::from("counterpoint-data"),
            workers: 0,
            queue: 1000,
            attempts: 3,
            grace_s: 30,
            operator_wait_s: 600,
            allow_system: false,
            system_wait_s: 60,
            max_blob_bytes: 256 << 20,
            max_files: 1000,
            max_programs: 64,
            min_free_bytes: 256 << 20,
            max_wall_ms: 3_600_000,
            max_job_bytes: 4 << 30,
            max_simulated_ns: MOST.simulated_ns,
            max_blocks: MOST.blocks,
            max_zero_time_blocks: MOST.zero_time_blocks,
            max_events: MOST.events,
            max_block_length: MOST.block_length,
            max_nesting: MOST.nesting,
            max_diagnostics: MOST.diagnostics,
            max_memory: 1 << 30,
            max_macro_steps: MOST.macro_steps,
            max_machine_bytes: 64 << 20,
            preface_s: 10,
            idle_s: 300,
            upload_stall_s: 30,
            max_connections: 4096,
            max_connections_per_address: 1024,
            max_uploads: 256,
            max_uploads_per_connection: 32,
            ephemeral: false,
            log: true,
        }
    }
}

fn yes() -> bool {
    true
}

/// Why options cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The configuration file cannot be read.
    #[error("cannot read '{path}': {error}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        error: std::io::Error,
    },
    /// It is not what it should be.
    #[error("{path}: {error}")]
    Parse {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: Box<toml::de::Error>,
    },
}

impl Options {
    /// Options of a configuration file.
    ///
    /// # Errors
    /// When the file cannot be read, is no TOML or has unknown keys.
    pub fn from_file(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|error| Error::Read { path: path.to_owned(), error })?;
        toml::from_str(&text).map_err(|error| Error::Parse { path: path.to_owned(), error: Box::new(error) })
    }

    /// The options as a configuration file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// For a server inside one command: loopback, free port, nothing kept.
    #[must_use]
    pub fn ephemeral(data: PathBuf) -> Self {
        let own = Self { max_wall_ms: u64::MAX, max_job_bytes: u64::MAX, max_memory: MOST.memory, ..Self::default() };
        Self { listen: SocketAddr::from(([127, 0, 0, 1], 0)), data, ephemeral: true, grace_s: 0, ..own }
    }

    /// Limits, none beyond the maxima of this server.
    pub(crate) fn capped(&self, limits: &Limits) -> Limits {
        Limits {
            simulated_ns: limits.simulated_ns.min(self.max_simulated_ns),
            blocks: limits.blocks.min(self.max_blocks),
            zero_time_blocks: limits.zero_time_blocks.min(self.max_zero_time_blocks),
            events: limits.events.min(self.max_events),
            block_length: limits.block_length.min(self.max_block_length),
            nesting: limits.nesting.min(self.max_nesting),
            diagnostics: limits.diagnostics.min(self.max_diagnostics),
            memory: limits.memory.min(self.max_memory),
            macro_steps: limits.macro_steps.min(self.max_macro_steps),
        }
        .capped()
    }

    /// Jobs at the same time, resolved.
    pub(crate) fn slots(&self) -> usize {
        match self.workers {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            n => n,
        }
    }
}

/// Flags and environment; what is absent is taken from the file or the defaults.
#[derive(Debug, Default, clap::Args)]
pub struct Flags {
    /// Address to listen on; port 0 = any free port
    #[arg(long, env = "COUNTERPOINT_LISTEN", value_name = "ADDRESS")]
    pub listen: Option<SocketAddr>,
    /// Folder of ledger, blobs, logs and results
    #[arg(long, env = "COUNTERPOINT_DATA", value_name = "FOLDER")]
    pub data: Option<PathBuf>,
    /// Jobs that run at the same time; 0 = one per processor core
    #[arg(long, env = "COUNTERPOINT_WORKERS", value_name = "N")]
    pub workers: Option<usize>,
    /// Jobs that may wait in the queue
    #[arg(long, env = "COUNTERPOINT_QUEUE", value_name = "N")]
    pub queue: Option<usize>,
    /// Runs begun before a job that takes the server down with it is given up
    #[arg(long, env = "COUNTERPOINT_ATTEMPTS", value_name = "N")]
    pub attempts: Option<u32>,
    /// Seconds that running jobs get to end after a stop signal
    #[arg(long, env = "COUNTERPOINT_GRACE_S", value_name = "SECONDS")]
    pub grace_s: Option<u64>,
    /// Seconds that a dialog of an attended job waits for the operator before it fails
    #[arg(long, env = "COUNTERPOINT_OPERATOR_WAIT_S", value_name = "SECONDS")]
    pub operator_wait_s: Option<u64>,
    /// Macros may start commands of the operating system, with the rights of the server: only where all machine
    /// definitions are trusted
    #[arg(long, env = "COUNTERPOINT_ALLOW_SYSTEM", value_name = "BOOL", num_args = 0..=1, default_missing_value = "true")]
    pub allow_system: Option<bool>,
    /// Seconds after which such a command is ended
    #[arg(long, env = "COUNTERPOINT_SYSTEM_WAIT_S", value_name = "SECONDS")]
    pub system_wait_s: Option<u64>,
    /// Largest blob, bytes
    #[arg(long, env = "COUNTERPOINT_MAX_BLOB_BYTES", value_name = "BYTES")]
    pub max_blob_bytes: Option<u64>,
    /// Most files of one job or machine
    #[arg(long, env = "COUNTERPOINT_MAX_FILES", value_name = "N")]
    pub max_files: Option<usize>,
    /// Most programs of one job
    #[arg(long, env = "COUNTERPOINT_MAX_PROGRAMS", value_name = "N")]
    pub max_programs: Option<usize>,
    /// Free disk space below which no run starts and no job or upload is accepted, bytes
    #[arg(long, env = "COUNTERPOINT_MIN_FREE_BYTES", value_name = "BYTES")]
    pub min_free_bytes: Option<u64>,
    /// Most time of one run by the clock, ms; also the default of a job
    #[arg(long, env = "COUNTERPOINT_MAX_WALL_MS", value_name = "MS")]
    pub max_wall_ms: Option<u64>,
    /// Most bytes of a log, and of the files that macros of a job have written; also the default of a job
    #[arg(long, env = "COUNTERPOINT_MAX_JOB_BYTES", value_name = "BYTES")]
    pub max_job_bytes: Option<u64>,
    /// Most simulated time of a job, ns
    #[arg(long, env = "COUNTERPOINT_MAX_SIMULATED_NS", value_name = "NS")]
    pub max_simulated_ns: Option<i64>,
    /// Most blocks of a channel
    #[arg(long, env = "COUNTERPOINT_MAX_BLOCKS", value_name = "N")]
    pub max_blocks: Option<u64>,
    /// Most consecutive blocks of a channel that take no time
    #[arg(long, env = "COUNTERPOINT_MAX_ZERO_TIME_BLOCKS", value_name = "N")]
    pub max_zero_time_blocks: Option<u64>,
    /// Most events of a channel
    #[arg(long, env = "COUNTERPOINT_MAX_EVENTS", value_name = "N")]
    pub max_events: Option<u64>,
    /// Longest block, bytes
    #[arg(long, env = "COUNTERPOINT_MAX_BLOCK_LENGTH", value_name = "BYTES")]
    pub max_block_length: Option<usize>,
    /// Deepest nesting of subprograms
    #[arg(long, env = "COUNTERPOINT_MAX_NESTING", value_name = "N")]
    pub max_nesting: Option<u16>,
    /// Most diagnostics kept of a channel
    #[arg(long, env = "COUNTERPOINT_MAX_DIAGNOSTICS", value_name = "N")]
    pub max_diagnostics: Option<u32>,
    /// Most memory for variables, texts, files and results of a job, bytes
    #[arg(long, env = "COUNTERPOINT_MAX_MEMORY", value_name = "BYTES")]
    pub max_memory: Option<u64>,
    /// Most steps of macros of a channel
    #[arg(long, env = "COUNTERPOINT_MAX_MACRO_STEPS", value_name = "N")]
    pub max_macro_steps: Option<u64>,
    /// Most bytes of all files of a machine
    #[arg(long, env = "COUNTERPOINT_MAX_MACHINE_BYTES", value_name = "BYTES")]
    pub max_machine_bytes: Option<u64>,
    /// Seconds that a new connection gets to begin to speak HTTP/2
    #[arg(long, env = "COUNTERPOINT_PREFACE_S", value_name = "SECONDS")]
    pub preface_s: Option<u64>,
    /// Seconds after which a connection without calls is closed
    #[arg(long, env = "COUNTERPOINT_IDLE_S", value_name = "SECONDS")]
    pub idle_s: Option<u64>,
    /// Seconds that an upload may stand still
    #[arg(long, env = "COUNTERPOINT_UPLOAD_STALL_S", value_name = "SECONDS")]
    pub upload_stall_s: Option<u64>,
    /// Most connections; fewer if the process may not have that many descriptors
    #[arg(long, env = "COUNTERPOINT_MAX_CONNECTIONS", value_name = "N")]
    pub max_connections: Option<usize>,
    /// Most connections of one address
    #[arg(long, env = "COUNTERPOINT_MAX_CONNECTIONS_PER_ADDRESS", value_name = "N")]
    pub max_connections_per_address: Option<usize>,
    /// Most uploads at the same time
    #[arg(long, env = "COUNTERPOINT_MAX_UPLOADS", value_name = "N")]
    pub max_uploads: Option<usize>,
    /// Most uploads of one connection at the same time
    #[arg(long, env = "COUNTERPOINT_MAX_UPLOADS_PER_CONNECTION", value_name = "N")]
    pub max_uploads_per_connection: Option<usize>,
}

impl Flags {
    /// Lays the flags over options.
    #[must_use]
    pub fn over(self, mut options: Options) -> Options {
        fn set<T>(target: &mut T, value: Option<T>) {
            if let Some(value) = value {
                *target = value;
            }
        }
        set(&mut options.listen, self.listen);
        set(&mut options.data, self.data);
        set(&mut options.workers, self.workers);
        set(&mut options.queue, self.queue);
        set(&mut options.attempts, self.attempts);
        set(&mut options.grace_s, self.grace_s);
        set(&mut options.operator_wait_s, self.operator_wait_s);
        set(&mut options.allow_system, self.allow_system);
        set(&mut options.system_wait_s, self.system_wait_s);
        set(&mut options.max_blob_bytes, self.max_blob_bytes);
        set(&mut options.max_files, self.max_files);
        set(&mut options.max_programs, self.max_programs);
        set(&mut options.min_free_bytes, self.min_free_bytes);
        set(&mut options.max_wall_ms, self.max_wall_ms);
        set(&mut options.max_job_bytes, self.max_job_bytes);
        set(&mut options.max_simulated_ns, self.max_simulated_ns);
        set(&mut options.max_blocks, self.max_blocks);
        set(&mut options.max_zero_time_blocks, self.max_zero_time_blocks);
        set(&mut options.max_events, self.max_events);
        set(&mut options.max_block_length, self.max_block_length);
        set(&mut options.max_nesting, self.max_nesting);
        set(&mut options.max_diagnostics, self.max_diagnostics);
        set(&mut options.max_memory, self.max_memory);
        set(&mut options.max_macro_steps, self.max_macro_steps);
        set(&mut options.max_machine_bytes, self.max_machine_bytes);
        set(&mut options.preface_s, self.preface_s);
        set(&mut options.idle_s, self.idle_s);
        set(&mut options.upload_stall_s, self.upload_stall_s);
        set(&mut options.max_connections, self.max_connections);
        set(&mut options.max_connections_per_address, self.max_connections_per_address);
        set(&mut options.max_uploads, self.max_uploads);
        set(&mut options.max_uploads_per_connection, self.max_uploads_per_connection);
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_options_read_back_the_same() {
        let options = Options { queue: 7, ..Options::default() };
        let back: Options = toml::from_str(&options.to_toml()).unwrap();
        assert_eq!(Options { ephemeral: false, ..back }, options);
    }

    #[test]
    fn flags_win_and_unknown_keys_are_refused() {
        let flags = Flags { queue: Some(9), ..Flags::default() };
        assert_eq!(flags.over(Options::default()).queue, 9);
        assert!(toml::from_str::<Options>("quue = 3").is_err());
    }
}
