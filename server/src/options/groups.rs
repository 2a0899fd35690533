//! Groups of options, each with its flags.

use std::path::PathBuf;

use counterpoint_kernel::options::JobLimits;
use serde::{Deserialize, Serialize};

use super::any_path;

const MOST: JobLimits = JobLimits::MOST;

/// A group: options with defaults, and flags that are laid over them.
macro_rules! group {
    ($(#[$doc:meta])* $name:ident, $flags:ident { $($(#[$text:meta])* $option:ident: $type:ty = $default:expr, $env:literal, $value:literal $([$($more:tt)*])?;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(default)]
        pub struct $name {
            $($(#[$text])* pub $option: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($option: $default,)* }
            }
        }

        $(#[$doc])*
        #[derive(Debug, Default, clap::Args)]
        pub struct $flags {
            $($(#[$text])* #[arg(long, env = $env, value_name = $value $(, $($more)*)?)] pub $option: Option<$type>,)*
        }

        impl $flags {
            pub(super) fn over(self, options: &mut $name) {
                $(if let Some(value) = self.$option {
                    options.$option = value;
                })*
            }
        }
    };
}

group! {
    /// The maxima of every request, and of all together.
    Maxima, MaximaFlags {
        /// Maximum size of a blob, bytes
        max_blob_bytes: u64 = 256 << 20, "COUNTERPOINT_MAX_BLOB_BYTES", "BYTES";
        /// Maximum number of files of one job or machine
        max_files: usize = 1000, "COUNTERPOINT_MAX_FILES", "N";
        /// Maximum number of programs of one job
        max_programs: usize = 64, "COUNTERPOINT_MAX_PROGRAMS", "N";
        /// Maximum wall-clock running time of one run, ms; also the default of a job
        max_wall_ms: u64 = 3_600_000, "COUNTERPOINT_MAX_WALL_MS", "MS";
        /// Maximum size in bytes, each, of the log of a job, the files that its macros have written, and the answers to
        /// its questions; also the default of a job
        max_job_bytes: u64 = 4 << 30, "COUNTERPOINT_MAX_JOB_BYTES", "BYTES";
        /// Maximum simulated time of a job, ns
        max_simulated_ns: i64 = MOST.simulated_ns, "COUNTERPOINT_MAX_SIMULATED_NS", "NS";
        /// Maximum blocks of a channel
        max_blocks: u64 = MOST.blocks, "COUNTERPOINT_MAX_BLOCKS", "N";
        /// Maximum consecutive blocks of a channel that take no time
        max_zero_time_blocks: u64 = MOST.zero_time_blocks, "COUNTERPOINT_MAX_ZERO_TIME_BLOCKS", "N";
        /// Maximum events of a channel
        max_events: u64 = MOST.events, "COUNTERPOINT_MAX_EVENTS", "N";
        /// Maximum length of a block, bytes
        max_block_length: usize = MOST.block_length, "COUNTERPOINT_MAX_BLOCK_LENGTH", "BYTES";
        /// Maximum nesting depth of subprograms
        max_nesting: u16 = MOST.nesting, "COUNTERPOINT_MAX_NESTING", "N";
        /// Maximum diagnostics kept per channel
        max_diagnostics: u32 = MOST.diagnostics, "COUNTERPOINT_MAX_DIAGNOSTICS", "N";
        /// Maximum memory for variables, texts, files and results of a job, bytes
        max_memory: u64 = 256 << 20, "COUNTERPOINT_MAX_MEMORY", "BYTES";
        /// Maximum memory of jobs that have not ended, submits in progress and answers not yet sent, bytes;
        /// 0 = no limit
        memory_bytes: u64 = 512 << 20, "COUNTERPOINT_MEMORY_BYTES", "BYTES";
        /// Number of server crashes while a job runs alone after which the job fails (error `poison`); beside other jobs,
        /// three times this number
        attempts: u32 = 3, "COUNTERPOINT_ATTEMPTS", "N";
        /// Maximum macro steps of a channel
        max_macro_steps: u64 = MOST.macro_steps, "COUNTERPOINT_MAX_MACRO_STEPS", "N";
        /// Maximum size of all files of a machine, bytes
        max_machine_bytes: u64 = 64 << 20, "COUNTERPOINT_MAX_MACHINE_BYTES", "BYTES";
    }
}

group! {
    /// Patience with connections, and how many there may be.
    Connections, ConnectionsFlags {
        /// Seconds within which a new connection must start HTTP/2
        preface_s: u64 = 10, "COUNTERPOINT_PREFACE_S", "SECONDS";
        /// Seconds after which a connection without calls is closed
        idle_s: u64 = 300, "COUNTERPOINT_IDLE_S", "SECONDS";
        /// Seconds for which an upload or the request of another call may stall
        upload_stall_s: u64 = 30, "COUNTERPOINT_UPLOAD_STALL_S", "SECONDS";
        /// Maximum connections; fewer if the process may not have that many descriptors
        max_connections: usize = 4096, "COUNTERPOINT_MAX_CONNECTIONS", "N";
        /// Maximum connections of one address
        max_connections_per_address: usize = 1024, "COUNTERPOINT_MAX_CONNECTIONS_PER_ADDRESS", "N";
        /// Maximum simultaneous uploads
        max_uploads: usize = 256, "COUNTERPOINT_MAX_UPLOADS", "N";
        /// Maximum simultaneous uploads of one connection
        max_uploads_per_connection: usize = 32, "COUNTERPOINT_MAX_UPLOADS_PER_CONNECTION", "N";
        /// Address for monitoring (/metrics, /livez and /readyz over HTTP, without identities); empty = none
        metrics: String = String::new(), "COUNTERPOINT_METRICS", "ADDRESS";
        /// Collector that receives a span of each job by OTLP over gRPC, such as http://127.0.0.1:4317; empty = none;
        /// needs a server built with the feature otlp
        otlp: String = String::new(), "COUNTERPOINT_OTLP", "URL";
    }
}

group! {
    /// The quotas of one tenant; 0 = no limit.
    Quotas, QuotasFlags {
        /// Maximum waiting jobs of one tenant; 0 = no limit
        tenant_queued: usize = 0, "COUNTERPOINT_TENANT_QUEUED", "N";
        /// Maximum jobs of one tenant that run at the same time, its other jobs wait; 0 = no limit
        tenant_running: usize = 0, "COUNTERPOINT_TENANT_RUNNING", "N";
        /// Maximum storage of one tenant, bytes: uploaded files, machines, answers to the questions of jobs, and
        /// requests, logs, files and results of ended jobs; 0 = no limit
        tenant_bytes: u64 = 0, "COUNTERPOINT_TENANT_BYTES", "BYTES";
        /// Maximum simultaneous uploads of one tenant; 0 = no limit
        tenant_uploads: usize = 0, "COUNTERPOINT_TENANT_UPLOADS", "N";
        /// Processor time, seconds, that jobs of one tenant may use in a day (UTC); after that no more jobs are
        /// accepted; 0 = no limit
        tenant_cpu_s: u64 = 0, "COUNTERPOINT_TENANT_CPU_S", "SECONDS";
    }
}

group! {
    /// Retention of unneeded blobs and ended jobs.
    Retention, RetentionFlags {
        /// Free bytes in the ledger file at which it is compacted, if they are at least half of the file; 0 = only on
        /// command
        compact_bytes: u64 = 0, "COUNTERPOINT_COMPACT_BYTES", "BYTES";
        /// Seconds for which an unneeded blob is kept after its last upload or request with `FindMissing`
        blob_grace_s: u64 = 86_400, "COUNTERPOINT_BLOB_GRACE_S", "SECONDS";
        /// Give a job the results of an equal job of its tenant, if that is kept, instead of a run
        result_cache: bool = true, "COUNTERPOINT_RESULT_CACHE", "BOOL" [num_args = 0..=1, default_missing_value = "true"];
        /// Seconds for which an ended job is kept; 0 = no limit
        keep_s: u64 = 0, "COUNTERPOINT_KEEP_S", "SECONDS";
        /// Maximum ended jobs that are kept; 0 = no limit
        keep_jobs: u64 = 0, "COUNTERPOINT_KEEP_JOBS", "N";
        /// Maximum size of the kept logs, files and results of ended jobs, bytes; 0 = no limit
        keep_bytes: u64 = 0, "COUNTERPOINT_KEEP_BYTES", "BYTES";
        /// Maximum ended jobs of one tenant that are kept; 0 = no limit
        tenant_keep_jobs: u64 = 0, "COUNTERPOINT_TENANT_KEEP_JOBS", "N";
        /// Maximum size of the kept logs, files and results of the ended jobs of one tenant, bytes; 0 = no limit
        tenant_keep_bytes: u64 = 0, "COUNTERPOINT_TENANT_KEEP_BYTES", "BYTES";
    }
}

group! {
    /// Permitted callers.
    Guard, GuardFlags {
        /// File of tokens, keys and certificates with their tenants and roles; empty = every caller may do everything
        access: PathBuf = PathBuf::new(), "COUNTERPOINT_ACCESS", "FILE.toml" [value_parser = any_path()];
        /// Certificates of the server, PEM, its own first; empty = connections are not encrypted
        tls_cert: PathBuf = PathBuf::new(), "COUNTERPOINT_TLS_CERT", "FILE.pem" [value_parser = any_path()];
        /// Key of the first certificate, PEM
        tls_key: PathBuf = PathBuf::new(), "COUNTERPOINT_TLS_KEY", "FILE.pem" [value_parser = any_path()];
        /// Certificates of the authorities for clients, PEM: clients without a certificate are refused; empty = none
        tls_client_ca: PathBuf = PathBuf::new(), "COUNTERPOINT_TLS_CLIENT_CA", "FILE.pem" [value_parser = any_path()];
        /// Listen on addresses other than loopback without encryption or without identities
        insecure: bool = false, "COUNTERPOINT_INSECURE", "BOOL" [num_args = 0..=1, default_missing_value = "true"];
        /// Offer the contract to clients (gRPC reflection)
        reflection: bool = true, "COUNTERPOINT_REFLECTION", "BOOL" [num_args = 0..=1, default_missing_value = "true"];
        /// Also speak gRPC-Web, over HTTP/1.1 and HTTP/2
        grpc_web: bool = false, "COUNTERPOINT_GRPC_WEB", "BOOL" [num_args = 0..=1, default_missing_value = "true"];
        /// Origins whose pages may call with gRPC-Web, separated by commas; * = all; empty = pages of this server only
        grpc_web_origins: String = String::new(), "COUNTERPOINT_GRPC_WEB_ORIGINS", "ORIGINS";
        /// Maximum calls of one identity per second, further calls wait; 0 = no limit
        max_calls_per_s: u32 = 0, "COUNTERPOINT_MAX_CALLS_PER_S", "N";
        /// Maximum calls without a known identity that are answered per second for one address; 0 = no limit
        max_refused_per_s: u32 = 20, "COUNTERPOINT_MAX_REFUSED_PER_S", "N";
        /// File for the audit log; empty = none
        audit: PathBuf = PathBuf::new(), "COUNTERPOINT_AUDIT", "FILE" [value_parser = any_path()];
    }
}

group! {
    /// External waits of macros: commands of the operating system (`SYSTEM`) and the operator.
    System, SystemFlags {
        /// Allow macros of shipped machines, and of machines uploaded by an administrator, to start commands of the
        /// operating system with the rights of the server
        allow_system: bool = false, "COUNTERPOINT_ALLOW_SYSTEM", "BOOL" [num_args = 0..=1, default_missing_value = "true"];
        /// Seconds after which a command of the operating system is killed
        system_wait_s: u64 = 60, "COUNTERPOINT_SYSTEM_WAIT_S", "SECONDS";
        /// Seconds that a dialog of an attended job waits for the operator before it fails, and that a stepped job
        /// stays paused without a command before it continues
        operator_wait_s: u64 = 600, "COUNTERPOINT_OPERATOR_WAIT_S", "SECONDS";
    }
}

impl Maxima {
    /// Limits, none beyond the maxima of this server.
    pub(crate) fn capped(&self, limits: &JobLimits) -> JobLimits {
        JobLimits {
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
}
