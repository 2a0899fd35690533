//! The log of the running server on standard error, as text or as JSON.
//!
//! Invariants: both forms have the same lines with the same fields and spans, filtered by `COUNTERPOINT_LOG`. In JSON
//! every line is one object, including the report of a panic and the reason why the server ends. A line that cannot
//! be written is dropped and ends no thread.

use std::fmt::Display;
use std::io::{IsTerminal as _, stderr};

use serde::{Deserialize, Serialize};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

use crate::output::{self, Lossy};

/// Form of the log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// Lines for people to read, with colours on a terminal
    #[default]
    Text,
    /// One JSON object per line
    Json,
}

/// The variable that selects the lines.
const FILTER: &str = "COUNTERPOINT_LOG";

/// The filter that the variable names, `info` by default. A word alone must be a level: a target that does not exist
/// would select no lines.
fn filter(text: &str) -> Result<EnvFilter, String> {
    let refused = |error: &dyn Display| {
        format!(
            "{FILTER} is '{text}': {error}; expected a level (off, error, warn, info, debug, trace), target=level or \
             [span]=level, with commas between them"
        )
    };
    let parts: Vec<&str> = text.split(',').map(str::trim).filter(|part| !part.is_empty()).collect();
    let is_level = |part: &str| part.contains(['=', '[']) || part.parse::<LevelFilter>().is_ok();
    match parts.iter().find(|part| !is_level(part)) {
        Some(word) => Err(refused(&format_args!("'{word}' is not a level"))),
        None if parts.is_empty() => Ok(EnvFilter::new("info")),
        None => EnvFilter::try_new(parts.join(",")).map_err(|error| refused(&error)),
    }
}

/// Starts the log of this process.
///
/// # Errors
/// `COUNTERPOINT_LOG` is not a filter.
pub fn start(format: LogFormat) -> Result<(), String> {
    let filter = filter(&std::env::var_os(FILTER).unwrap_or_default().to_string_lossy())?;
    let lines = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(format == LogFormat::Text && stderr().is_terminal())
        .with_writer(|| Lossy(stderr()))
        .log_internal_errors(false);
    match format {
        LogFormat::Text => lines.init(),
        LogFormat::Json => {
            lines.json().with_current_span(false).init();
            std::panic::set_hook(Box::new(|panic| tracing::error!(%panic, "a thread has panicked")));
        }
    }
    Ok(())
}

/// Reports why the running server ends.
pub fn end(format: LogFormat, reason: &dyn Display) {
    if format == LogFormat::Json && tracing::enabled!(tracing::Level::ERROR) {
        tracing::error!(%reason, "the server ends");
    } else {
        output::failure(format_args!("counterpointd: {reason}"));
    }
}
