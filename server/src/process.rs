//! What the process takes of its host, and which build it is.
//!
//! Invariant: where the system does not tell (other systems than Linux), a gauge stays 0.

use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;

/// The gauges.
#[derive(Debug, Default)]
pub(crate) struct ProcessMetrics {
    pub(crate) build: Family<[(&'static str, &'static str); 1], Gauge>,
    pub(crate) resident_bytes: Gauge,
    pub(crate) open_descriptors: Gauge,
    pub(crate) connections: Gauge,
    pub(crate) clock_ahead_s: Gauge,
}

impl ProcessMetrics {
    /// The gauges of this build.
    pub(crate) fn new() -> Self {
        let process = Self::default();
        process.build.get_or_create(&[("version", env!("CARGO_PKG_VERSION"))]).set(1);
        process
    }

    /// Sets the gauges of the process, with the number of its connections.
    pub(crate) fn observe(&self, connections: usize) {
        self.connections.set(i64::try_from(connections).unwrap_or(i64::MAX));
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kilobytes = kilobytes.and_then(|text| text.trim().trim_end_matches(" kB").parse::<i64>().ok());
        self.resident_bytes.set(kilobytes.unwrap_or(0).saturating_mul(1024));
        let open = std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count);
        self.open_descriptors.set(i64::try_from(open).unwrap_or(i64::MAX));
    }
}
