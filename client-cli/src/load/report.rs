//! The report of a load, as text and as JSON.

use std::collections::BTreeMap;

use serde::Serialize;

use super::drive::ArrivalSchedule;
use super::growth::Growth;
use super::measure::{JobPhase, Measured, Second};
use super::thresholds::Threshold;
use crate::text;

/// Shares that are reported.
pub(super) const SHARES: [(&str, f64); 5] =
    [("p50", 0.5), ("p90", 0.9), ("p99", 0.99), ("p99.9", 0.999), ("p99.99", 0.9999)];

/// Times of a stretch, ms.
#[derive(Debug, Serialize)]
pub(super) struct PhaseTimes {
    pub(super) count: u64,
    pub(super) mean: f64,
    pub(super) max: f64,
    #[serde(flatten)]
    pub(super) shares: BTreeMap<&'static str, f64>,
    /// Shares from 0 to nearly 1 for the plot, with their times.
    #[serde(skip)]
    pub(super) curve: Vec<(f64, f64)>,
}

/// The server's process.
#[derive(Debug, Serialize)]
pub(super) struct ProcessUsage {
    pub(super) cores_mean: f64,
    pub(super) cores_max: f64,
    pub(super) rss_max: u64,
    pub(super) descriptors_max: u64,
    pub(super) threads_max: u64,
    /// Bytes of the data folder at the end.
    pub(super) folder: Option<u64>,
}

/// The report.
#[derive(Debug, Serialize)]
pub(super) struct LoadReport {
    pub(super) mix: String,
    pub(super) server: String,
    pub(super) pace: String,
    /// Time before that, s.
    pub(super) warm_up_s: f64,
    /// Measured time, s.
    pub(super) measured_s: f64,
    pub(super) submits_per_s: f64,
    pub(super) ends_per_s: f64,
    pub(super) events_per_s: f64,
    /// Accepted jobs by kind.
    pub(super) jobs: BTreeMap<String, u64>,
    pub(super) errors: BTreeMap<String, u64>,
    /// Times by stretch, ms.
    pub(super) times_ms: BTreeMap<&'static str, PhaseTimes>,
    /// Of the server, if it is on this machine.
    pub(super) process: Option<ProcessUsage>,
    pub(super) thresholds: Vec<Threshold>,
    /// How the server grew while it was measured.
    pub(super) growth: Vec<Growth>,
    pub(super) seconds: Vec<Second>,
}

impl LoadReport {
    pub(super) fn new(
        mix: String,
        server: &str,
        pace: ArrivalSchedule,
        measured: &Measured,
        (thresholds, growth): (Vec<Threshold>, Vec<Growth>),
    ) -> Self {
        let seconds = measured.seconds_measured();
        let rate = |count: u64| count as f64 / seconds;
        let times = JobPhase::ALL.into_iter().filter_map(|stretch| Some((stretch.name(), times(measured, stretch)?)));
        Self {
            mix,
            server: server.to_owned(),
            pace: pace.to_string(),
            warm_up_s: measured.warm_up_s(),
            measured_s: seconds,
            submits_per_s: rate(measured.counts.submitted),
            ends_per_s: rate(measured.counts.ended),
            events_per_s: rate(measured.counts.events),
            jobs: measured.kinds.clone(),
            errors: measured.errors.clone(),
            times_ms: times.collect(),
            process: used(&measured.seconds),
            thresholds,
            growth,
            seconds: measured.seconds.clone(),
        }
    }

    pub(super) fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    pub(super) fn text(&self) -> String {
        let mut out = format!(
            "{} at {}, {:.1} s: {:.1} submits/s, {:.1} ends/s, {:.0} events/s\n",
            self.mix, self.pace, self.measured_s, self.submits_per_s, self.ends_per_s, self.events_per_s
        );
        let mut rows = vec![["ms", "count", "mean"].map(str::to_owned).to_vec()];
        if let Some(head) = rows.first_mut() {
            head.extend(SHARES.iter().map(|(name, _)| (*name).to_owned()));
            head.push("max".to_owned());
        }
        for (name, times) in JobPhase::ALL.into_iter().filter_map(|s| self.times_ms.get_key_value(s.name())) {
            let mut row = vec![name.replace('_', " "), times.count.to_string(), format!("{:.2}", times.mean)];
            row.extend(SHARES.iter().filter_map(|(name, _)| times.shares.get(name)).map(|ms| format!("{ms:.2}")));
            row.push(format!("{:.2}", times.max));
            rows.push(row);
        }
        out += &text::table(&rows, 1);
        if let Some(used) = &self.process {
            let ProcessUsage { cores_mean, cores_max, rss_max, descriptors_max, threads_max, folder } = used;
            out += &format!(
                "server: {cores_mean:.2} cores (most {cores_max:.2}), {} MiB, {descriptors_max} descriptors, {threads_max} \
                 threads at most",
                rss_max >> 20
            );
            out += &folder.map_or_else(String::new, |bytes| format!(", {} MiB of data at the end", bytes >> 20));
            out.push('\n');
        }
        for Growth { what, percent, .. } in self.growth.iter().filter(|growth| growth.percent != 0.0) {
            out += &format!("{what}: {percent:+.1} % from the first third of the time to the last\n");
        }
        match self.errors.is_empty() {
            true => out += "no errors\n",
            false => self.errors.iter().for_each(|(reason, count)| out += &format!("error {reason}: {count}\n")),
        }
        out
    }
}

fn times(measured: &Measured, stretch: JobPhase) -> Option<PhaseTimes> {
    let times = measured.times(stretch)?;
    let shares = SHARES.iter().filter_map(|(name, share)| Some((*name, times.ms(*share)?))).collect();
    // Ten points for each digit of the share that is left: 0.5, … 0.9, … 0.99, …
    let most = (times.count().max(1) as f64).log10();
    let at = (0..).map(|n| f64::from(n) / 10.0).take_while(|digits| *digits <= most.min(6.0));
    let curve = at.filter_map(|digits| Some((digits, times.ms(1.0 - 10_f64.powf(-digits))?))).collect();
    Some(PhaseTimes { count: times.count(), mean: times.mean_ms()?, max: times.max_ms()?, shares, curve })
}

fn used(seconds: &[Second]) -> Option<ProcessUsage> {
    let measured: Vec<_> = seconds.iter().filter(|s| !s.warm_up).filter_map(|second| second.process).collect();
    let count = measured.len();
    (count > 0).then(|| ProcessUsage {
        cores_mean: measured.iter().map(|sample| sample.cores).sum::<f64>() / count as f64,
        cores_max: measured.iter().map(|sample| sample.cores).fold(0.0, f64::max),
        rss_max: measured.iter().map(|sample| sample.rss).max().unwrap_or(0),
        descriptors_max: measured.iter().map(|sample| sample.descriptors).max().unwrap_or(0),
        threads_max: measured.iter().map(|sample| sample.threads).max().unwrap_or(0),
        folder: measured.last().and_then(|sample| sample.folder),
    })
}
