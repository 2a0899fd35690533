//! Spans of jobs for a collector of traces, by OTLP over gRPC; part of the server if it is built with the feature
//! `otlp`.
//!
//! *Invariant:* no job waits for the collector: a span that it does not take in time is dropped and counted.

#[cfg(feature = "otlp")]
mod export;

use crate::ledger::record::JobRecord;

/// Where spans go.
#[derive(Debug, Default)]
pub(crate) struct JobSpans {
    #[cfg(feature = "otlp")]
    exporter: Option<export::Exporter>,
}

impl JobSpans {
    /// Sends spans to the collector at this address (`http://HOST:4317`); empty = none.
    #[cfg(feature = "otlp")]
    pub(crate) fn to(endpoint: &str) -> Result<Self, String> {
        let exporter = if endpoint.is_empty() { None } else { Some(export::Exporter::start(endpoint)?) };
        Ok(Self { exporter })
    }

    /// Without the feature there is no address to send them to.
    #[cfg(not(feature = "otlp"))]
    pub(crate) fn to(endpoint: &str) -> Result<Self, String> {
        if endpoint.is_empty() {
            return Ok(Self::default());
        }
        Err(format!(
            "'{endpoint}' as otlp: this server was built without the feature otlp: build it with --features otlp"
        ))
    }

    /// Sends the spans of a job that has ended.
    pub(crate) fn ended(&self, record: &JobRecord) {
        #[cfg(feature = "otlp")]
        if let Some(exporter) = &self.exporter {
            exporter.ended(record);
        }
        #[cfg(not(feature = "otlp"))]
        let _ = record;
    }

    /// Sends the remaining spans, for a moment at most.
    pub(crate) fn close(&self) {
        #[cfg(feature = "otlp")]
        if let Some(exporter) = &self.exporter {
            exporter.close();
        }
    }
}
