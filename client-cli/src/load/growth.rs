//! Whether the server grows under a load that stays the same.
//!
//! *Invariant:* a figure that goes up and down has no growth: medians of the first and of the last third of the
//! measured time are compared, so neither a single peak nor the phase of a sawtooth decides.

use serde::Serialize;

use super::measure::Second;
use super::process::Sample;

/// Fewer samples say nothing about growth.
const FEWEST: usize = 30;

/// A figure of the server: its name, its value in a sample, and the growth that is noise in any case.
type Figure = (&'static str, fn(&Sample) -> Option<f64>, f64);

const FIGURES: [Figure; 4] = [
    ("growth of memory", |sample| Some(sample.rss as f64), (4 << 20) as f64),
    ("growth of descriptors", |sample| Some(sample.descriptors as f64), 4.0),
    ("growth of threads", |sample| Some(sample.threads as f64), 4.0),
    ("growth of the data folder", |sample| sample.folder.map(|bytes| bytes as f64), (4 << 20) as f64),
];

/// How a figure changed from the first third of the measured time to the last.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Growth {
    /// Name of the figure.
    pub(super) what: &'static str,
    /// Median of the first third, bytes or a count.
    pub(super) first: f64,
    /// Median of the last third.
    pub(super) last: f64,
    /// Growth in per cent of the first; 0 where it is no more than noise.
    pub(super) percent: f64,
    /// Growth in an hour, in the unit of the figure: from the middle of the first third to that of the last.
    pub(super) per_hour: f64,
}

/// Growth of each figure; none of those that were not measured often enough.
pub(super) fn growth(seconds: &[Second]) -> Vec<Growth> {
    FIGURES.iter().filter_map(|figure| of(seconds, figure)).collect()
}

fn of(seconds: &[Second], (what, value, noise): &Figure) -> Option<Growth> {
    let measured = seconds.iter().filter(|second| !second.warm_up);
    let points: Vec<(f64, f64)> =
        measured.filter_map(|second| Some((second.at_s, value(second.process.as_ref()?)?))).collect();
    if points.len() < FEWEST {
        return None;
    }
    let third = points.len() / 3;
    let (early, late) = (points.get(..third)?, points.get(points.len() - third..)?);
    let (first, last) = (median(early.iter().map(|point| point.1))?, median(late.iter().map(|point| point.1))?);
    let apart_s = median(late.iter().map(|point| point.0))? - median(early.iter().map(|point| point.0))?;
    let grown = last - first;
    let percent = if grown.abs() <= *noise { 0.0 } else { grown * 100.0 / first.max(1.0) };
    Some(Growth { what, first, last, percent, per_hour: grown * 3600.0 / apart_s.max(1.0) })
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Memory in MiB, second by second, after ten seconds of warm-up.
    fn memory(of: impl Fn(u32) -> f64, seconds: u32) -> Option<Growth> {
        let second = |n: u32| {
            let rss = (of(n) * f64::from(1 << 20)) as u64;
            let process = Sample { cores: 1.0, rss, descriptors: 20, threads: 8, folder: None };
            Second { at_s: f64::from(n), warm_up: n < 10, process: Some(process), ..Second::default() }
        };
        growth(&(0..seconds).map(second).collect::<Vec<_>>())
            .into_iter()
            .find(|growth| growth.what == "growth of memory")
    }

    #[test]
    fn noise_a_peak_and_a_sawtooth_are_no_growth() {
        let noisy = memory(|n| 100.0 + f64::from(n * 7919 % 13) / 4.0, 600).unwrap();
        assert_eq!(noisy.percent, 0.0, "{noisy:?}");
        let peak = memory(|n| if n == 590 { 900.0 } else { 100.0 }, 600).unwrap();
        assert_eq!((peak.percent, peak.per_hour), (0.0, 0.0));
        let sawtooth = memory(|n| 100.0 + f64::from(n % 40), 600).unwrap();
        assert_eq!(sawtooth.percent, 0.0, "{sawtooth:?}");
        let warm_up = memory(|n| if n < 10 { 10.0 } else { 100.0 }, 600).unwrap();
        assert_eq!(warm_up.percent, 0.0, "what happens before the measured time does not count");
    }

    #[test]
    fn slow_growth_is_seen_under_noise_and_given_by_the_hour() {
        let leak = memory(|n| 100.0 + f64::from(n) * 0.05 + f64::from(n * 7919 % 13) / 4.0, 600).unwrap();
        assert!((15.0..25.0).contains(&leak.percent), "{leak:?}");
        let mib_per_hour = leak.per_hour / f64::from(1 << 20);
        assert!((160.0..200.0).contains(&mib_per_hour), "0.05 MiB a second are 180 MiB an hour: {mib_per_hour}");
    }

    #[test]
    fn what_was_measured_a_few_times_says_nothing() {
        assert_eq!(memory(f64::from, 39), None);
        assert!(memory(f64::from, 41).is_some());
        let folder = growth(&[]).into_iter().find(|growth| growth.what == "growth of the data folder");
        assert_eq!(folder, None);
    }
}
