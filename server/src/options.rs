//! Settings of the server: flags over environment over configuration file over defaults.
//!
//! Invariant: every option exists in all three forms under one name (`queue` = `--queue` = `COUNTERPOINT_QUEUE`),
//! except for the tables of single tenants and of webhooks, which only a file has; and [`ServerOptions::to_toml`] prints a
//! file that gives the same options again.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use counterpoint_kernel::options::JobLimits;
use serde::{Deserialize, Serialize};

use crate::logging::LogFormat;
use crate::tenant;

mod groups;
mod printed;
mod tenants;
mod webhooks;

pub use groups::{Connections, ConnectionsFlags, Guard, GuardFlags, Maxima, MaximaFlags};
pub use groups::{Quotas, QuotasFlags, Retention, RetentionFlags, System, SystemFlags};
pub use tenants::Tenant;
pub use webhooks::Webhook;

/// Options of a server.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ServerOptions {
    /// Address to listen on; port 0 = any free port.
    pub listen: SocketAddr,
    /// Data folder, with ledger, blobs, logs and results.
    pub data: PathBuf,
    /// Jobs that run at the same time; 0 = one per processor core.
    pub workers: usize,
    /// Maximum number of jobs that wait in the queue.
    pub queue: usize,
    /// Seconds that running jobs have to end after a stop signal.
    pub grace_s: u64,
    /// Free bytes on the disk of the data folder below which no run starts and no job or upload is accepted.
    pub min_free_bytes: u64,
    /// Format of the log on standard error.
    pub log_format: LogFormat,
    /// Permitted callers.
    #[serde(flatten)]
    pub guard: Guard,
    /// Commands of the operating system, and the operator.
    #[serde(flatten)]
    pub system: System,
    /// The maxima of every request, and of all together.
    #[serde(flatten)]
    pub maxima: Maxima,
    /// The quotas of one tenant.
    #[serde(flatten)]
    pub quotas: Quotas,
    /// Patience with connections, and how many there may be.
    #[serde(flatten)]
    pub connections: Connections,
    /// How long things are kept.
    #[serde(flatten)]
    pub retention: Retention,
    /// The tables that only a file has.
    #[serde(flatten)]
    pub tables: OptionTables,
    /// How it lives inside of a command.
    #[serde(skip)]
    pub embedded: Embedded,
}

/// Tables by name; no flag sets these.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct OptionTables {
    /// Different quotas and retention of single tenants.
    pub tenants: BTreeMap<String, Tenant>,
    /// Targets that are notified when jobs end.
    pub webhooks: BTreeMap<String, Webhook>,
}

/// How a server lives inside of a command; no file and no flag sets this.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Embedded {
    /// Nothing survives: no fsync, ledger in memory. For a server that lives as long as one command.
    pub ephemeral: bool,
    /// Keep the toolpath of a job. Disable it only if no client will request a toolpath.
    pub toolpath: bool,
    /// Keep the event log of a job. Without it there are no listings, events and event watches. Disable it only if no
    /// client will request them, as in a command that runs one job.
    pub log: bool,
}

impl Default for Embedded {
    fn default() -> Self {
        Self { ephemeral: false, toolpath: true, log: true }
    }
}

impl Default for ServerOptions {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 7878)),
            data: PathBuf::from("counterpoint-data"),
            workers: 0,
            queue: 1000,
            grace_s: 30,
            min_free_bytes: 256 << 20,
            log_format: LogFormat::default(),
            guard: Guard::default(),
            system: System::default(),
            maxima: Maxima::default(),
            quotas: Quotas::default(),
            connections: Connections::default(),
            retention: Retention::default(),
            tables: OptionTables::default(),
            embedded: Embedded::default(),
        }
    }
}

/// Why options cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum OptionsError {
    /// The configuration file cannot be read.
    #[error("cannot read '{path}': {error}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        error: std::io::Error,
    },
    /// The content is not valid.
    #[error("{path}: {error}")]
    Parse {
        /// The file.
        path: PathBuf,
        /// The error.
        error: Box<toml::de::Error>,
    },
    /// The value of an option cannot be used.
    #[error("option {option}: {error}")]
    Value {
        /// The option.
        option: String,
        /// The error.
        error: &'static str,
    },
}

/// Reads a path that may be empty, unlike the paths of clap.
#[must_use]
pub fn any_path() -> impl clap::builder::TypedValueParser<Value = PathBuf> {
    use clap::builder::TypedValueParser as _;
    clap::builder::OsStringValueParser::new().map(PathBuf::from)
}

impl ServerOptions {
    /// Options of a configuration file.
    ///
    /// # Errors
    /// When the file cannot be read, is no TOML or has unknown keys.
    pub fn from_file(path: &Path) -> Result<Self, OptionsError> {
        let text =
            std::fs::read_to_string(path).map_err(|error| OptionsError::Read { path: path.to_owned(), error })?;
        Self::parse(&text).map_err(|error| OptionsError::Parse { path: path.to_owned(), error: Box::new(error) })
    }

    /// Options of a text; a name that no option has is an error.
    fn parse(text: &str) -> Result<Self, toml::de::Error> {
        let known: toml::Table = toml::from_str(&Self::default().to_toml())?;
        let given: toml::Table = toml::from_str(text)?;
        match given.keys().find(|name| !known.contains_key(*name)) {
            Some(name) => Err(serde::de::Error::custom(format!("there is no option '{name}'"))),
            None => {
                check_tables::<Tenant>(&given, &known, "tenants")?;
                check_names(&given)?;
                check_tables::<Webhook>(&given, &known, "webhooks")?;
                toml::from_str(text)
            }
        }
    }

    /// Checks that every value can be used by a server and written to a configuration file.
    ///
    /// # Errors
    /// The first option whose value fails the check.
    pub fn checked(self) -> Result<Self, OptionsError> {
        if self.data.as_os_str().as_encoded_bytes().contains(&0) {
            return Err(OptionsError::Value { option: "data".to_owned(), error: "the path contains a NUL character" });
        }
        let text = self.to_toml();
        let values = text.lines().filter_map(|line| line.split_once(" = "));
        let numbers = values.filter_map(|(option, value)| Some((option, value.parse::<u64>().ok()?)));
        match numbers.into_iter().find(|(_, number)| i64::try_from(*number).is_err()) {
            Some((option, _)) => Err(OptionsError::Value {
                option: option.to_owned(),
                error: "the largest number is 9223372036854775807",
            }),
            None => Ok(self),
        }
    }

    /// The options as a configuration file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Names of the options that differ in another file; tables of tenants are not compared.
    #[must_use]
    pub fn names_of_other_changes(&self, other: &Self) -> Vec<String> {
        let table = |options: &Self| toml::Table::try_from(options).unwrap_or_default();
        let (own, other) = (table(self), table(other));
        let changed = own.iter().filter(|(name, value)| *name != "tenants" && other.get(*name) != Some(*value));
        changed.map(|(name, _)| name.clone()).collect()
    }

    /// For a server inside one command: loopback, free port, nothing kept.
    #[must_use]
    pub fn ephemeral(data: PathBuf) -> Self {
        let maxima = Maxima {
            max_wall_ms: u64::MAX,
            max_job_bytes: u64::MAX,
            max_memory: JobLimits::MOST.memory,
            ..Maxima::default()
        };
        let own = Self { maxima, ..Self::default() };
        let embedded = Embedded { ephemeral: true, ..Embedded::default() };
        Self { listen: SocketAddr::from(([127, 0, 0, 1], 0)), data, embedded, grace_s: 0, ..own }
    }

    /// Jobs at the same time, resolved.
    pub(crate) fn slots(&self) -> usize {
        match self.workers {
            0 => crate::cpu::cores(),
            n => n,
        }
    }
}

/// Reads each table of a kind alone, so that an error names the table, or the option that is below the table.
fn check_tables<T: serde::de::DeserializeOwned>(
    given: &toml::Table,
    known: &toml::Table,
    kind: &str,
) -> Result<(), toml::de::Error> {
    let above = |option: &str, table: &str| {
        serde::de::Error::custom(format!("option '{option}' is below the line [{table}]: move it above all tables"))
    };
    for (name, table) in given.get(kind).and_then(toml::Value::as_table).into_iter().flatten() {
        if !table.is_table() && known.contains_key(name) {
            return Err(above(name, kind));
        }
        let Err(error) = table.clone().try_into::<T>() else { continue };
        let (error, table) = (error.to_string(), format!("{kind}.{name}"));
        return Err(match known.keys().find(|option| error.contains(&format!("unknown field `{option}`"))) {
            Some(option) => above(option, &table),
            None => serde::de::Error::custom(format!("[{table}]: {}", error.trim())),
        });
    }
    Ok(())
}

/// Refuses a table `[tenants.NAME]` if no tenant can have the name.
fn check_names(given: &toml::Table) -> Result<(), toml::de::Error> {
    let names = given.get("tenants").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::keys);
    match names.into_iter().find(|name| !tenant::is_tenant(name)) {
        Some(name) => Err(serde::de::Error::custom(format!(
            "[tenants.{name}]: '{name}' is not the name of a tenant: expected {}",
            tenant::RULE
        ))),
        None => Ok(()),
    }
}

/// Flags and environment; options absent here come from the file or the defaults.
#[derive(Debug, Default, clap::Args)]
pub struct ServerFlags {
    /// Address to listen on; port 0 = any free port
    #[arg(long, env = "COUNTERPOINT_LISTEN", value_name = "ADDRESS")]
    pub listen: Option<SocketAddr>,
    /// Data folder, with ledger, blobs, logs and results
    #[arg(long, env = "COUNTERPOINT_DATA", value_name = "FOLDER")]
    pub data: Option<PathBuf>,
    /// Jobs that run at the same time; 0 = one per processor core
    #[arg(long, env = "COUNTERPOINT_WORKERS", value_name = "N")]
    pub workers: Option<usize>,
    /// Maximum number of jobs that wait in the queue
    #[arg(long, env = "COUNTERPOINT_QUEUE", value_name = "N")]
    pub queue: Option<usize>,
    /// Seconds that running jobs have to end after a stop signal
    #[arg(long, env = "COUNTERPOINT_GRACE_S", value_name = "SECONDS")]
    pub grace_s: Option<u64>,
    /// Free disk space below which no run starts and no job or upload is accepted, bytes
    #[arg(long, env = "COUNTERPOINT_MIN_FREE_BYTES", value_name = "BYTES")]
    pub min_free_bytes: Option<u64>,
    /// Format of the log on standard error: text or json
    #[arg(long, env = "COUNTERPOINT_LOG_FORMAT", value_enum, value_name = "FORMAT")]
    pub log_format: Option<LogFormat>,
    /// Guard
    #[command(flatten)]
    pub guard: GuardFlags,
    /// System
    #[command(flatten)]
    pub system: SystemFlags,
    /// Maxima
    #[command(flatten)]
    pub maxima: MaximaFlags,
    /// Quotas
    #[command(flatten)]
    pub quotas: QuotasFlags,
    /// Connections
    #[command(flatten)]
    pub connections: ConnectionsFlags,
    /// Retention
    #[command(flatten)]
    pub retention: RetentionFlags,
}

impl ServerFlags {
    /// Lays the flags over options.
    #[must_use]
    pub fn over(self, mut options: ServerOptions) -> ServerOptions {
        fn set<T>(target: &mut T, value: Option<T>) {
            if let Some(value) = value {
                *target = value;
            }
        }
        set(&mut options.listen, self.listen);
        set(&mut options.data, self.data);
        set(&mut options.workers, self.workers);
        set(&mut options.queue, self.queue);
        set(&mut options.grace_s, self.grace_s);
        set(&mut options.min_free_bytes, self.min_free_bytes);
        set(&mut options.log_format, self.log_format);
        self.guard.over(&mut options.guard);
        self.system.over(&mut options.system);
        self.maxima.over(&mut options.maxima);
        self.quotas.over(&mut options.quotas);
        self.connections.over(&mut options.connections);
        self.retention.over(&mut options.retention);
        options
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_options_read_back_the_same() {
        let options = ServerOptions { queue: 7, ..ServerOptions::default() };
        let back = ServerOptions::parse(&options.to_toml()).unwrap();
        assert_eq!(back, options);
    }

    #[test]
    fn changes_that_need_a_restart_are_named() {
        let of = |text: &str| ServerOptions::parse(text).unwrap();
        let before = of("queue = 3\n[tenants.a]\nqueued = 1\n");
        let none: [&str; 0] = [];
        assert_eq!(before.names_of_other_changes(&of("queue = 3\n[tenants.a]\nqueued = 2\n")), none);
        let hook = "[webhooks.a]\nurl = \"https://a\"\nsecret_file = \"b\"\ntenants = [\"*\"]\n";
        assert_eq!(
            before.names_of_other_changes(&of(&format!("access = \"x\"\n{hook}"))),
            ["access", "queue", "webhooks"]
        );
    }

    #[test]
    fn flags_win_and_unknown_keys_are_refused() {
        let flags = ServerFlags { queue: Some(9), ..ServerFlags::default() };
        assert_eq!(flags.over(ServerOptions::default()).queue, 9);
        assert!(ServerOptions::parse("quue = 3").is_err());
    }

    #[test]
    fn a_tenant_of_its_own_has_what_its_table_says_and_the_rest_as_all() {
        let text = "tenant_queued = 5\ntenant_cpu_s = 60\n[tenants.cell]\nqueued = 9\ncpu_s = 0\nkeep_jobs = 3\n";
        let options = ServerOptions::parse(text).unwrap();
        let (cell, other) = (options.tables.tenants["cell"].quotas(&options.quotas), &options.quotas);
        assert_eq!((cell.tenant_queued, cell.tenant_cpu_s, cell.tenant_running), (9, 0, 0));
        assert_eq!((other.tenant_queued, other.tenant_cpu_s), (5, 60));
        assert_eq!(ServerOptions::parse(&options.to_toml()).unwrap(), options);
        let name = ServerOptions::parse("[tenants.A]\nqueued = 9\n").unwrap_err().to_string();
        assert!(name.contains("'A' is not the name of a tenant") && name.contains("a-z 0-9"), "{name}");
        let unknown = ServerOptions::parse("[tenants.cell]\nqueues = 9\n").unwrap_err().to_string();
        assert!(unknown.contains("queues") && unknown.contains("queued"), "{unknown}");
        for (text, place) in
            [("[webhooks]\naccess = \"a\"\n", "[webhooks]"), ("[tenants.a]\nqueue = 1\n", "[tenants.a]")]
        {
            let error = ServerOptions::parse(text).unwrap_err().to_string();
            assert!(error.contains(place) && error.contains("move it above all tables"), "{error}");
        }
        let hook =
            ServerOptions::parse("queue = 3\n[webhooks.mes]\nurl = \"https://mes.example\"\n").unwrap_err().to_string();
        assert!(hook.contains("[webhooks.mes]") && hook.contains("secret_file"), "{hook}");
    }
}
