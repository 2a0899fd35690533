//! The bars of one channel.
//!
//! *Invariant:* never more than twice [`MOST`] bars in memory, [`MOST`] at the end; less when the memory of the job has
//! no room for them. Beyond that the shortest neighbours become one bar, of the kind that took the largest part of it.

use std::sync::Arc;

use serde::Serialize;

use crate::sync_points::WaitStay;
use counterpoint_event::event::WorkClass;
use counterpoint_event::{FileId, SourcePlace};

/// Bars a channel has at most.
pub const MOST: usize = 20_000;

/// Bars that are looked at to find the grain.
const SAMPLES: usize = 2000;

/// A stretch of time spent on one thing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ActivityBar {
    /// The kind of work of the time.
    pub kind: WorkClass,
    /// Start, ns.
    pub t_ns: i64,
    /// Duration, ns.
    pub dur_ns: i64,
    /// File of its blocks in the user's programs; of joined bars that of the first one.
    #[serde(skip)]
    pub file: FileId,
    /// Lowest line of its blocks in that file.
    pub line: u32,
    /// Highest line of its blocks in that file; a loop or a jump back can run the lines in another order.
    pub end_line: u32,
    /// Mark of a wait.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<Arc<str>>,
    /// The axis that another channel moved meanwhile: `Z2 with Z1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried: Option<Box<CarriedAxes>>,
    /// Time of the kind, when shorter ones of other kinds are inside.
    #[serde(skip)]
    pub(super) own_ns: i64,
}

/// Names of axes that another channel moves. Few bars have them, so the name is kept outside the bar.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct CarriedAxes(Box<str>);

impl CarriedAxes {
    /// The text: the own axis and its master.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl ActivityBar {
    /// End, ns.
    #[must_use]
    pub fn end_ns(&self) -> i64 {
        self.t_ns.saturating_add(self.dur_ns)
    }

    /// Work at one place.
    fn new(kind: WorkClass, (t_ns, dur_ns): (i64, i64), place: SourcePlace) -> Self {
        let SourcePlace { file, line } = place;
        Self { kind, t_ns, dur_ns, file, line, end_line: line, label: None, carried: None, own_ns: dur_ns }
    }

    /// Extends the bar by the same kind of work in the same file.
    #[inline]
    fn extend(&mut self, dur_ns: i64, line: u32) {
        self.dur_ns += dur_ns;
        self.own_ns += dur_ns;
        (self.line, self.end_line) = (self.line.min(line), self.end_line.max(line));
    }

    fn absorb(&mut self, next: &mut Self) {
        self.dur_ns = next.end_ns() - self.t_ns;
        if next.file == self.file {
            (self.line, self.end_line) = (self.line.min(next.line), self.end_line.max(next.end_line));
        }
        if next.kind == self.kind {
            self.own_ns += next.own_ns;
        } else if next.own_ns > self.own_ns {
            (self.kind, self.own_ns) = (next.kind, next.own_ns);
            self.label = next.label.take();
            self.carried = next.carried.take();
        }
    }
}

/// Collects bars.
#[derive(Debug)]
pub struct Bars {
    bars: Vec<ActivityBar>,
    /// At the end.
    most: usize,
    /// Bars shorter than this are joined with the next one.
    grain_ns: i64,
}

impl Bars {
    /// No bar yet; all of them may take this many bytes.
    pub fn new(room: u64) -> Self {
        let most = usize::try_from(room / (2 * size_of::<ActivityBar>() as u64)).unwrap_or(MOST).min(MOST);
        Self { bars: Vec::new(), most, grain_ns: 0 }
    }

    /// A stretch of work that follows all others.
    #[inline]
    pub fn push(&mut self, kind: WorkClass, t_ns: i64, dur_ns: i64, place: SourcePlace) {
        if let Some(last) = self.bars.last_mut()
            && last.kind == kind
            && last.file == place.file
            && kind != WorkClass::Wait
            && last.end_ns() == t_ns
        {
            last.extend(dur_ns, place.line);
            return;
        }
        self.push_other(ActivityBar::new(kind, (t_ns, dur_ns), place));
    }

    /// Adds work of another kind or in another file than the last bar.
    fn push_other(&mut self, mut bar: ActivityBar) {
        if let Some(last) = self.bars.last_mut()
            && last.dur_ns < self.grain_ns
            && bar.kind != WorkClass::Wait
            && last.kind != WorkClass::Wait
            && last.end_ns() == bar.t_ns
        {
            last.absorb(&mut bar);
            return;
        }
        self.add(bar);
    }

    /// A wait that is over.
    pub fn wait(&mut self, since_ns: i64, t_ns: i64, stay: &WaitStay) {
        let dur_ns = t_ns.saturating_sub(since_ns);
        if dur_ns > 0 {
            let bar = ActivityBar::new(WorkClass::Wait, (since_ns, dur_ns), SourcePlace::new(stay.file, stay.line));
            self.add(ActivityBar { label: Some(stay.key()), ..bar });
        }
    }

    /// An axis has been moved by another channel during the wait that ended just now, if it took time.
    pub fn carried(&mut self, t_ns: i64, axes: &str) {
        if let Some(last) = self.bars.last_mut()
            && last.kind == WorkClass::Wait
            && last.end_ns() == t_ns
        {
            last.carried = Some(Box::new(CarriedAxes(axes.into())));
        }
    }

    fn add(&mut self, bar: ActivityBar) {
        self.bars.push(bar);
        if self.bars.len() >= 2 * self.most {
            self.thin();
        }
    }

    /// Bars up to the end of the channel.
    pub fn finish(mut self, end_ns: i64) -> Vec<ActivityBar> {
        self.thin();
        while let Some(last) = self.bars.last_mut()
            && last.end_ns() > end_ns
        {
            last.dur_ns = end_ns - last.t_ns;
            if last.dur_ns > 0 {
                break;
            }
            self.bars.pop();
        }
        self.bars
    }

    fn thin(&mut self) {
        while self.bars.len() > self.most {
            // A sample finds short bars, and is quick: other kernels wait meanwhile.
            let step = self.bars.len().div_ceil(SAMPLES);
            let mut durations: Vec<i64> = self.bars.iter().step_by(step).map(|b| b.dur_ns).collect();
            let middle = durations.len() / 2;
            let (_, median, _) = durations.select_nth_unstable(middle);
            self.grain_ns = self.grain_ns.saturating_mul(2).max(median.saturating_add(1));
            let grain = self.grain_ns;
            self.bars.dedup_by(|next, last| {
                let joins = last.dur_ns < grain;
                if joins {
                    last.absorb(next);
                }
                joins
            });
        }
    }
}
