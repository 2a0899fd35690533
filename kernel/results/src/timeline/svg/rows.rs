//! The row of one channel.
//!
//! Bars narrower than a pixel are drawn together, in the colour of the work that took most of the time. Few bars are
//! drawn one by one with a hint for the mouse, many as one path for each kind.

use counterpoint_event::FileId;
use std::fmt::Write as _;

use super::layout::PlotLayout;
use super::scale::{TimeScale, time_text};
use super::tools;
use super::{BAR, INK, KINDS, LEFT, RED, SOFT, WIDTH, style};
use crate::summary::ChannelState;
use crate::svg::{escape, fit, hundredths, px, text};
use crate::timeline::bars::ActivityBar;
use crate::timeline::{ChannelTimeline, Timeline};
use counterpoint_event::event::WorkClass;

/// Bars of a row that still get a hint each.
const FEW: usize = 300;

/// Height of the strip below a wait during which another channel moved an axis.
const CARRIED: f64 = 8.0;

/// Tools named in a hint.
const TOOLS: usize = 4;

/// Draws the row with this index; `whole`: its time is beside its name.
pub(super) fn draw(
    out: &mut String,
    timeline: &Timeline,
    channel: &ChannelTimeline,
    (layout, index): (&PlotLayout, usize),
    whole: bool,
) {
    let (top, scale) = (layout.row_top(index), &layout.scale);
    let name = format!("{} {}", channel.channel, channel.name);
    text(out, (16.0, top + 14.0), 14, "start", INK, &fit(&name, 14, LEFT - 24.0));
    let waits = channel.wait_ns as f64 / channel.end_ns.max(1) as f64 * 100.0;
    let note = match channel.state {
        ChannelState::NotStarted => "no program".to_owned(),
        _ => format!("{}, waits {waits:.0} %", time_text(channel.end_ns, 100_000_000)),
    };
    if whole {
        text(out, (16.0, top + 28.0), 11, "start", SOFT, &fit(&note, 11, LEFT - 13.0));
    }
    let runs = runs(&channel.bars, scale);
    if runs.len() <= FEW {
        runs.iter().for_each(|run| single(out, run, channel, top, scale));
    } else {
        many(out, &runs, top, scale);
    }
    carried(out, &runs, top, scale);
    if whole || scale.sees(channel.end_ns, channel.end_ns) {
        ending(out, timeline, channel, top, scale);
    }
}

/// Bars drawn as one.
struct BarRun {
    kind: WorkClass,
    t_ns: i64,
    end_ns: i64,
    /// File of the first block, and the lines in that file.
    file: FileId,
    lines: (u32, u32),
    label: Option<String>,
    /// The axis that another channel moved meanwhile.
    carried: Option<String>,
}

fn runs(bars: &[ActivityBar], scale: &TimeScale) -> Vec<BarRun> {
    let mut runs: Vec<BarRun> = Vec::new();
    let mut small: Vec<&ActivityBar> = Vec::new();
    let wide = |from: i64, to: i64| scale.x(to) - scale.x(from) >= 1.0;
    for bar in bars.iter().filter(|bar| scale.sees(bar.t_ns, bar.end_ns())) {
        if wide(bar.t_ns, bar.end_ns()) {
            flush(&mut small, &mut runs);
            add(&mut runs, run(bar.kind, &[bar]));
            continue;
        }
        if small.first().is_some_and(|first| wide(first.t_ns, bar.end_ns()) || bar.t_ns < first.t_ns) {
            flush(&mut small, &mut runs);
        }
        small.push(bar);
    }
    flush(&mut small, &mut runs);
    runs
}

fn flush(small: &mut Vec<&ActivityBar>, runs: &mut Vec<BarRun>) {
    let time = |kind: WorkClass| small.iter().filter(|b| b.kind == kind).map(|b| b.dur_ns).sum::<i64>();
    let most = KINDS.iter().map(|(kind, ..)| *kind).max_by_key(|kind| time(*kind));
    if let (Some(kind), false) = (most, small.is_empty()) {
        add(runs, run(kind, small));
    }
    small.clear();
}

fn run(kind: WorkClass, bars: &[&ActivityBar]) -> BarRun {
    let (first, last) = (bars.first(), bars.last());
    let ending = bars.iter().take_while(|bar| first.is_some_and(|first| bar.file == first.file)).last();
    BarRun {
        kind,
        t_ns: first.map_or(0, |b| b.t_ns),
        end_ns: last.map_or(0, |b| b.end_ns()),
        file: first.map_or(0, |bar| bar.file),
        lines: first.map_or((0, 0), |b| (b.line, ending.map_or(b.end_line, |last| last.end_line))),
        label: first.filter(|_| bars.len() == 1).and_then(|b| b.label.as_deref()).map(str::to_owned),
        carried: first
            .filter(|_| bars.len() == 1)
            .and_then(|b| b.carried.as_deref())
            .map(|axes| axes.text().to_owned()),
    }
}

/// Runs of work that touch and are of one kind become one.
fn add(runs: &mut Vec<BarRun>, next: BarRun) {
    match runs.last_mut() {
        Some(last)
            if last.kind == next.kind && last.end_ns == next.t_ns && last.file == next.file && next.label.is_none() =>
        {
            (last.end_ns, last.lines.1) = (next.end_ns, next.lines.1);
        }
        _ => runs.push(next),
    }
}

fn single(out: &mut String, run: &BarRun, channel: &ChannelTimeline, top: f64, scale: &TimeScale) {
    let (name, color) = style(run.kind);
    let (from, to) = scale.within(run.t_ns, run.end_ns);
    let (x, width) = (scale.x(from), (scale.x(to) - scale.x(from)).max(0.5));
    let mut hint = name.to_owned();
    if let Some(label) = &run.label {
        let _ = write!(hint, " {label}");
    }
    let _ = write!(hint, ", {}, ", time_text(run.end_ns - run.t_ns, 1_000_000));
    let own = channel.program.split('#').next().unwrap_or_default();
    let file = channel.file_name(run.file, run.lines.0);
    if file != own && !file.is_empty() {
        let _ = write!(hint, "{file} ");
    }
    let _ = match run.lines {
        (first, last) if first == last => write!(hint, "line {first}"),
        (first, last) => write!(hint, "lines {first} to {last}"),
    };
    let first = channel.tools.partition_point(|span| span.end_ns <= run.t_ns);
    let during = channel.tools.iter().skip(first).take_while(|span| span.t_ns < run.end_ns);
    for span in during.take(TOOLS) {
        let _ = write!(hint, ", {}", tools::name(span));
    }
    let _ = writeln!(
        out,
        r#"<rect x="{x:.2}" y="{top:.0}" width="{width:.2}" height="{BAR:.0}" fill="{color}"><title>{}</title></rect>"#,
        escape(&hint)
    );
}

/// Below the bars of waits during which another channel moved an axis of this one.
fn carried(out: &mut String, runs: &[BarRun], top: f64, scale: &TimeScale) {
    let (_, color) = style(WorkClass::Feed);
    for run in runs {
        let Some(axes) = &run.carried else { continue };
        let (from, to) = scale.within(run.t_ns, run.end_ns);
        let (x, width) = (scale.x(from), (scale.x(to) - scale.x(from)).max(0.5));
        let y = top + BAR - CARRIED;
        let _ = writeln!(
            out,
            r#"<rect x="{x:.2}" y="{y:.0}" width="{width:.2}" height="{CARRIED:.0}" fill="{color}"><title>{}</title></rect>"#,
            escape(&format!("moves {axes} meanwhile"))
        );
    }
}

fn many(out: &mut String, runs: &[BarRun], top: f64, scale: &TimeScale) {
    for (kind, _, color) in KINDS {
        let mut started = false;
        for run in runs.iter().filter(|r| r.kind == kind) {
            if !started {
                let _ = write!(out, r#"<path fill="{color}" d=""#);
                started = true;
            }
            let (from, to) = scale.within(run.t_ns, run.end_ns);
            let (x, width) = (px(scale.x(from)), px(scale.x(to)) - px(scale.x(from)));
            out.push('M');
            hundredths(out, x, true);
            let _ = write!(out, " {top:.0}h");
            hundredths(out, width.max(50), true);
            let _ = write!(out, "v{BAR:.0}h");
            hundredths(out, -width.max(50), true);
            out.push('z');
        }
        if started {
            out.push_str("\"/>\n");
        }
    }
}

/// The word and mark after the last bar of a channel that did not end well.
fn ending(out: &mut String, timeline: &Timeline, channel: &ChannelTimeline, top: f64, scale: &TimeScale) {
    let (x, middle) = (scale.x(channel.end_ns), top + BAR / 2.0 + 4.5);
    match channel.state {
        ChannelState::Blocked => {
            let key = wait_at_end(timeline, channel.channel);
            let (tip, bottom) = (WIDTH - 24.0, top + BAR);
            let _ = writeln!(
                out,
                r#"<path fill="{RED}" d="M{x:.1} {top:.0}H{:.1}L{tip:.1} {:.1}L{:.1} {bottom:.0}H{x:.1}z"/>"#,
                tip - 10.0,
                top + BAR / 2.0,
                tip - 10.0
            );
            let label = fit(&format!("waits at {key}"), 12, tip - 16.0 - x);
            text(out, (x + 6.0, middle), 12, "start", "#ffffff", &label);
        }
        ChannelState::Alarmed => {
            let _ = writeln!(out, r#"<rect x="{x:.1}" y="{top:.0}" width="3" height="{BAR:.0}" fill="{RED}"/>"#);
            // The bar of an alarm for a wait that does not match is labelled with the waiting code.
            let key = wait_at_end(timeline, channel.channel);
            let label = if key.is_empty() { "alarm".to_owned() } else { format!("alarm at {key}") };
            text(out, (x + 8.0, middle), 12, "start", RED, &fit(&label, 12, WIDTH - 16.0 - x));
        }
        ChannelState::Stopped => text(out, (x + 6.0, middle), 12, "start", SOFT, "stopped"),
        ChannelState::Ended | ChannelState::NotStarted => {}
    }
}

/// Code of the wait that a channel has not left.
fn wait_at_end(timeline: &Timeline, channel: u16) -> &str {
    let left = timeline.waits.iter().rev().take_while(|wait| wait.release_ns.is_none());
    let mut own = left.filter(|wait| wait.arrivals.iter().any(|arrival| arrival.channel == channel));
    own.next().map_or("", |wait| &*wait.key)
}
