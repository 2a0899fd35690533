//! The report of a load as one HTML file.
//!
//! *Invariant:* nothing is loaded from elsewhere and nothing is executed: plots are drawings inside the file.

use std::fmt::Write as _;

use super::growth::Growth;
use super::measure::{JobPhase, Second};
use super::plot::{Plot, PlotScale, Series, escaped};
use super::report::{LoadReport, ProcessUsage, SHARES};

const STYLE: &str = "\
body{font:15px/1.45 system-ui,sans-serif;color:#1b1f24;background:#fff;max-width:1080px;margin:2em auto;padding:0 1em}
h1{font-size:1.5em;margin:0 0 .2em}h2{font-size:1.1em;margin:1.6em 0 .4em}
table{border-collapse:collapse}td,th{padding:.25em .8em;border-bottom:1px solid #d8dee4;text-align:right}
td:first-child,th:first-child{text-align:left}.figures{display:flex;flex-wrap:wrap;gap:1em;margin:1em 0}
.figures div{border:1px solid #d8dee4;border-radius:6px;padding:.5em 1em}.figures b{display:block;font-size:1.4em}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(480px,1fr));gap:1em}.plots svg{width:100%;height:auto}
.kept{color:#116329}.missed{color:#a40e26;font-weight:600}";

/// The whole page.
pub(super) fn page(report: &LoadReport) -> String {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Load: {0}</title><style>{STYLE}</style>\
         </head><body>\n<h1>Load: {0}</h1>\n<p>{1} against {2}, measured for {3:.1} s</p>\n",
        escaped(&report.mix),
        escaped(&report.pace),
        escaped(&report.server),
        report.measured_s
    );
    figures(&mut out, report);
    times(&mut out, report);
    counts(&mut out, report);
    out += "<h2>Over time</h2>\n<div class=\"plots\">\n";
    for plot in plots(report) {
        out += &plot.svg();
        out.push('\n');
    }
    out + "</div>\n</body></html>\n"
}

fn figures(out: &mut String, report: &LoadReport) {
    let mut figure = |value: String, what: &str| {
        let _ = write!(out, "<div><b>{value}</b>{what}</div>");
    };
    let errors: u64 = report.errors.values().sum();
    figure(format!("{:.1}", report.submits_per_s), "submits/s");
    figure(format!("{:.1}", report.ends_per_s), "ends/s");
    figure(format!("{:.0}", report.events_per_s), "events/s");
    figure(errors.to_string(), "errors");
    if let Some(ProcessUsage { cores_mean, rss_max, .. }) = report.process {
        figure(format!("{cores_mean:.2}"), "cores of the server");
        figure((rss_max >> 20).to_string(), "MiB of the server at most");
    }
    *out = out.replacen("<div><b>", "<div class=\"figures\"><div><b>", 1) + "</div>\n";
}

fn times(out: &mut String, report: &LoadReport) {
    *out += "<h2>Times, ms</h2>\n<table><tr><th></th><th>count</th><th>mean</th>";
    SHARES.iter().for_each(|(name, _)| *out += &format!("<th>{name}</th>"));
    *out += "<th>max</th></tr>\n";
    for (name, times) in JobPhase::ALL.into_iter().filter_map(|s| report.times_ms.get_key_value(s.name())) {
        let _ =
            write!(out, "<tr><td>{}</td><td>{}</td><td>{:.2}</td>", name.replace('_', " "), times.count, times.mean);
        for ms in SHARES.iter().filter_map(|(name, _)| times.shares.get(name)) {
            let _ = write!(out, "<td>{ms:.2}</td>");
        }
        let _ = writeln!(out, "<td>{:.2}</td></tr>", times.max);
    }
    *out += "</table>\n";
}

fn counts(out: &mut String, report: &LoadReport) {
    let mut table = |title: &str, rows: Vec<(String, String)>| {
        if rows.is_empty() {
            return;
        }
        let _ = writeln!(out, "<h2>{title}</h2>\n<table>");
        for (name, value) in rows {
            let _ = writeln!(out, "<tr><td>{}</td><td>{value}</td></tr>", escaped(&name));
        }
        *out += "</table>\n";
    };
    let rows = |counts: &std::collections::BTreeMap<String, u64>| {
        counts.iter().map(|(name, count)| (name.clone(), count.to_string())).collect()
    };
    table("Accepted jobs", rows(&report.jobs));
    table("Errors", rows(&report.errors));
    let threshold = |threshold: &super::thresholds::Threshold| {
        let word = if threshold.kept { "kept" } else { "missed" };
        (threshold.to_string(), format!("<span class=\"{word}\">{word}</span>"))
    };
    let growth = |growth: &Growth| (growth.what.to_owned(), format!("{:+.1} %", growth.percent));
    table("Growth from the first third of the time to the last", report.growth.iter().map(growth).collect());
    table("Thresholds", report.thresholds.iter().map(threshold).collect());
}

/// Most points of a line.
const POINTS: usize = 600;

/// Points of a figure over time; seconds without it are left out, and of many seconds each point is the mean of some.
fn over_time(report: &LoadReport, of: impl Fn(&Second) -> Option<f64>) -> Vec<(f64, f64)> {
    let points: Vec<_> = report.seconds.iter().filter_map(|second| Some((second.at_s, of(second)?))).collect();
    let some = points.chunks(points.len().div_ceil(POINTS).max(1)).map(|some| {
        let count = some.len() as f64;
        (some.iter().map(|point| point.0).sum::<f64>() / count, some.iter().map(|point| point.1).sum::<f64>() / count)
    });
    some.collect()
}

fn plots(report: &LoadReport) -> Vec<Plot> {
    let series = |name: &str, of: &dyn Fn(&Second) -> Option<f64>| Series::new(name, over_time(report, of));
    let plot = |title: &str, y: &str, scale, series| Plot {
        title: title.to_owned(),
        x: "seconds".to_owned(),
        y: y.to_owned(),
        scale,
        shaded: report.warm_up_s,
        nines: false,
        series,
    };
    let curves = JobPhase::ALL.into_iter().filter_map(|stretch| {
        let times = report.times_ms.get(stretch.name())?;
        Some(Series::new(&stretch.name().replace('_', " "), times.curve.clone()))
    });
    let mut plots = vec![
        plot(
            "Jobs",
            "jobs/s",
            PlotScale::Linear,
            vec![
                series("submitted", &|s| Some(s.submitted as f64)),
                series("ended", &|s| Some(s.ended as f64)),
                series("errors", &|s| Some(s.errors as f64)),
            ],
        ),
        plot("Events", "events/s", PlotScale::Linear, vec![series("events", &|s| Some(s.events as f64))]),
        plot(
            "Times",
            "ms",
            PlotScale::Log,
            vec![
                series("submit p50", &|s| s.submit_p50_ms),
                series("submit p99", &|s| s.submit_p99_ms),
                series("end p50", &|s| s.end_p50_ms),
                series("end p99", &|s| s.end_p99_ms),
            ],
        ),
        Plot {
            title: "Times by share of jobs".to_owned(),
            x: "per cent of jobs that are no slower".to_owned(),
            y: "ms".to_owned(),
            scale: PlotScale::Log,
            shaded: 0.0,
            nines: true,
            series: curves.collect(),
        },
        plot("Jobs under way", "jobs", PlotScale::Linear, vec![series("open", &|s| Some(s.open as f64))]),
    ];
    if report.process.is_some() {
        let mib = |s: &Second| s.process.map(|process| process.rss as f64 / f64::from(1 << 20));
        plots.push(plot(
            "Processors of the server",
            "cores",
            PlotScale::Linear,
            vec![series("cores", &|s| Some(s.process?.cores))],
        ));
        plots.push(plot("Memory of the server", "MiB", PlotScale::Linear, vec![series("memory", &mib)]));
        plots.push(plot(
            "Descriptors and threads of the server",
            "",
            PlotScale::Linear,
            vec![
                series("descriptors", &|s| Some(s.process?.descriptors as f64)),
                series("threads", &|s| Some(s.process?.threads as f64)),
            ],
        ));
        let folder = |s: &Second| s.process?.folder.map(|bytes| bytes as f64 / f64::from(1 << 20));
        plots.push(plot("Data folder of the server", "MiB", PlotScale::Linear, vec![series("data", &folder)]));
    }
    plots
}
