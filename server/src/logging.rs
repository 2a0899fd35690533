//! The log of the running server on standard error, as text or as JSON.
//!
//! Invariants: both forms have the same lines with the same fields and spans, filtered by `COUNTERPOINT_LOG`. In JSON
//! every line is one object, including the report of a panic and the reason why the server ends. A line that cannot
//! be written is dropped and ends no thread.

use std::fmt::Display;
use std::io::{IsTerminal as _, stderr};

use serde::{Deserialize, Serialize};
use tracing_subscriber::EnvFilter;

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

/// Starts the log of this process.
///
/// # Errors
/// `COUNTERPOINT_LOG` is not a filter.
pub fn start(format: LogFormat) -> Result<(), String> {
    let text = std::env::var_os(FILTER).unwrap_or_default().to_string_lossy().into_owned();
    let filter = EnvFilter::try_new(if text.is_empty() { "info" } else { &text }).map_err(|error| {
        format!(
            "{FILTER} is '{text}': {error}; expected a level (error, warn, info, debug, trace) or target=level pairs"
        )
    })?;
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
