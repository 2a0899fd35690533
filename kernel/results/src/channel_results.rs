//! Results of the events of one channel: its fingerprint, times, bars and path.
//!
//! *Invariant:* they need nothing of other channels, so each kernel may make its own on its own thread.

use std::sync::Arc;

use crate::coordinates::UnitsRead;
use crate::digest::Digest;
use crate::reported::Reported;
use crate::spans::ToolSpanCollector;
use crate::summary::tally::TimeTally;
use crate::sync_points::WaitStay;
use crate::timeline::bars::Bars;
use crate::toolpath::Track;
use crate::tools::ToolCollector;
use counterpoint_event::event::{Event, FileId, Kind, MotionKind, Phase, WorkClass};
use counterpoint_event::info::{self, Info};

/// One channel of the results in the making.
#[derive(Debug)]
pub struct ChannelResults {
    /// Number of the channel.
    pub number: u16,
    info: Arc<Info>,
    pub(super) digest: Digest,
    pub(super) tally: TimeTally,
    pub(super) bars: Bars,
    /// Its path, if it may be requested.
    pub(super) track: Option<Track>,
    /// The wait that blocks it.
    pub(super) wait: Option<WaitStay>,
    /// Stays that have ended.
    pub(super) stays: Vec<WaitStay>,
    /// Diagnostics and verdicts that came while they were made on their own.
    pub(super) reported: Vec<Reported>,
    /// Start of the latest event.
    pub(super) last_ns: i64,
    /// Its tools.
    pub(super) tools: ToolCollector,
    /// When they were active.
    pub(super) spans: ToolSpanCollector,
    /// File that the kernel started with, when it is not the one given to it by the job.
    pub(super) program: Option<FileId>,
    /// The units in which its coordinates were read.
    pub(super) units: UnitsRead,
}

impl ChannelResults {
    pub(super) fn new(info: &Arc<Info>, channel: &info::JobChannel) -> Self {
        Self {
            number: channel.number,
            info: info.clone(),
            digest: Digest::new(),
            tally: TimeTally::default(),
            bars: Bars::new(info.room.bars),
            track: Some(Track::new(info, channel)),
            wait: None,
            stays: Vec::new(),
            reported: Vec::new(),
            last_ns: 0,
            tools: ToolCollector::default(),
            spans: ToolSpanCollector::default(),
            program: None,
            units: UnitsRead::new(channel),
        }
    }

    /// Whether the end of the channel's program has been seen.
    pub fn ended(&self) -> bool {
        self.tally.ended()
    }

    /// The next events of the channel's own stream; those of the master in it are put aside.
    pub fn take(&mut self, events: &[Event]) {
        for event in events {
            match event.kind {
                Kind::Block(_) | Kind::Motion(_) | Kind::Call(_) | Kind::Return(_) => {}
                _ => self.reported.extend(Reported::of(event)),
            }
            if event.channel == self.number {
                self.event(event);
            }
        }
    }

    /// The next event of the channel.
    #[inline]
    pub(super) fn event(&mut self, event: &Event) {
        self.digest.event(event);
        self.last_ns = self.last_ns.max(event.t_ns);
        match &event.kind {
            Kind::Block(block) => {
                self.units.block(block.unit_named);
                self.tally.block(block.number, event.caller.is_some());
            }
            Kind::Motion(motion) => {
                let work = if motion.kind == MotionKind::Rapid { WorkClass::Rapid } else { WorkClass::Feed };
                self.work(work, event);
                if !event.caller.is_some() {
                    self.units.moves();
                }
                if let Some(track) = &mut self.track {
                    let place = event.user_place();
                    track.motion(motion, (place.file, place.line));
                }
            }
            Kind::Call(_) | Kind::Return(_) => {}
            _ => self.other(event),
        }
    }

    #[inline]
    fn work(&mut self, work: WorkClass, event: &Event) {
        if event.dur_ns > 0 {
            self.tally.work(work, event);
            self.bars.push(work, event.t_ns, event.dur_ns, event.user_place());
        }
    }

    fn other(&mut self, event: &Event) {
        let place = event.user_place();
        match &event.kind {
            Kind::Wait(wait) => self.wait = Some(WaitStay::new(wait, event.t_ns, (place.file, place.line))),
            Kind::Release(release) => {
                let stay = self.wait.take().unwrap_or_else(|| WaitStay::unseen(release, (place.file, place.line)));
                self.tally.add(WorkClass::Wait, event.t_ns.saturating_sub(release.since_ns));
                self.bars.wait(release.since_ns, event.t_ns, &stay);
                self.stays.push(stay.ended(release, event.t_ns));
            }
            Kind::Lifecycle(phase) => {
                let own = self.info.channel(self.number).filter(|c| !c.program.is_empty()).map(|c| c.file);
                if *phase == Phase::ProgramStart && own != Some(event.file) && !self.tally.has_run() {
                    self.program = Some(event.file);
                }
                if *phase == Phase::ProgramStart {
                    self.units.start();
                }
                self.tally.life(*phase, event.t_ns);
            }
            kind => {
                if let Kind::Mode(mode) = kind
                    && let Some(carried) = &mode.carried
                {
                    self.bars.carried(event.t_ns, &carried.axes);
                    if let Some(track) = &mut self.track {
                        track.carried(carried, (place.file, place.line));
                    }
                }
                if let Kind::Mode(mode) = kind
                    && let inch = mode.text == "units inch"
                    && (inch || mode.text == "units mm")
                {
                    self.units.select(inch, (place.file, place.line));
                    if let Some(track) = &mut self.track {
                        track.unit(inch);
                    }
                }
                self.tools.event(kind, || self.tally.times());
                if let (Some(tool), Some(track)) = (self.spans.event(event), &mut self.track) {
                    track.tool(tool);
                }
                if let Some(work) = kind.work() {
                    self.work(work, event);
                }
            }
        }
    }
}
