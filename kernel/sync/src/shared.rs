//! Shared data of all channels of a job besides waits: common variables and spindles.

use rustc_hash::FxHashMap;

use crate::files::SharedFiles;
use crate::hoard::{Hoard, weight};
use crate::separate::Separate;
use crate::wait::ChannelSet;
use counterpoint_event::event::SpindleDirection;
use counterpoint_lang::value::MacroValue;
use counterpoint_motion::driven_speed::DrivenSpeed;
use counterpoint_motion::surface_speed::SurfaceSpeed;

/// Shared state; touched only inside shared operations.
#[derive(Debug, Clone, Default)]
pub struct SharedState {
    /// Common variables that have a value.
    pub variables: FxHashMap<u32, f64>,
    /// Variables with names that the pre-processors of all channels reach, those that have a value.
    pub named: FxHashMap<Box<str>, counterpoint_lang::value::MacroValue>,
    /// Global variables of macros, by index.
    pub globals: Vec<counterpoint_lang::value::MacroValue>,
    /// Memory of both.
    pub hoard: Hoard,
    /// Files that macros have written.
    pub files: SharedFiles,
    /// Spindles by index of the machine's list.
    pub spindles: Vec<SharedSpindle>,
    /// The chucks that hand parts over.
    pub chucks: Option<crate::chucks::ChuckPair>,
    /// Variables that each channel has of its own, as far as channels have ended.
    pub separate: Separate,
    /// Data that channels with coupled axes exchange when they meet.
    pub coupled: FxHashMap<Coupled, CoupledPosition>,
    /// Couplings that one channel has commanded alone, oldest first.
    pub alone: Vec<OneSidedCoupling>,
    /// Values of the part that may be in another unit were reported.
    pub part_data_reported: bool,
}

/// One meeting of one of two coupled axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Coupled {
    /// The axis that the values are about, by index of the machine's list.
    pub axis: u16,
    /// The axis that it is coupled with.
    pub with: u16,
    /// Which meeting it is. A value is read before the channels can come to the same one again.
    pub at: u8,
}

/// A coupling that only one channel commands: the other channel learns of it at their next barrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneSidedCoupling {
    /// Channel that commands it.
    pub by: u16,
    /// Number of the master axis.
    pub master: u16,
    /// Number of the slave axis.
    pub slave: u16,
    /// Which of both does not move, as the program says.
    pub parking: f64,
    /// It begins, or it ends.
    pub on: bool,
    /// Where the axis of that channel stood before.
    pub stand: CoupledPosition,
}

/// Position of an axis, and the moves that its channel has commanded since the axes were coupled; geometry units.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoupledPosition {
    /// Place in the machine frame.
    pub place: f64,
    /// Distance commanded.
    pub by: f64,
}

/// Commanded state of a spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleCommand {
    /// Direction of rotation.
    pub direction: SpindleDirection,
    /// Constant surface speed is on.
    pub css: bool,
    /// rev/min.
    pub rpm: f64,
    /// Surface speed as programmed (m/min or ft/min).
    pub surface: f64,
    /// Largest rev/min programmed.
    pub limit: f64,
    /// Smallest rev/min programmed.
    pub least: f64,
    /// Channel whose X drives constant surface speed.
    pub driver: u16,
    /// Radius at which the surface speed counts, 0 = at X.
    pub radius: f64,
    /// Angle of the oriented stop, degrees.
    pub angle: f64,
}

impl SpindleCommand {
    /// Smallest and largest speed of a spindle with this range, rev/min.
    #[must_use]
    pub fn bounds(&self, [min, max]: [f64; 2]) -> [f64; 2] {
        let max = max.min(self.limit);
        [min.max(self.least).min(max), max]
    }
}

impl Default for SpindleCommand {
    fn default() -> Self {
        Self {
            direction: SpindleDirection::Off,
            css: false,
            rpm: 0.0,
            surface: 0.0,
            limit: f64::INFINITY,
            least: 0.0,
            driver: 0,
            radius: 0.0,
            angle: 0.0,
        }
    }
}

/// A move that drives a spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivingMove {
    /// Its start and its end, ns.
    pub time: [i64; 2],
    /// Speed of the spindle during the move.
    pub driven: DrivenSpeed,
}

impl DrivingMove {
    /// Minutes from its start to a time.
    pub fn elapsed(&self, t: i64) -> f64 {
        (t - self.time[0]) as f64 / 60e9
    }
}

/// Speed changes of a spindle, to the extent that channels that time by its revolutions need them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpeedChanges {
    /// Times (ns) and channels of the last changes, in a ring.
    last: [(i64, u16); SpeedChanges::KEPT],
    /// Number of all changes.
    pub count: u64,
}

impl SpeedChanges {
    const KEPT: usize = 8;

    /// Records that a channel changes the speed at this time, on the basis of the changes known before.
    pub fn note(&mut self, t: i64, channel: u16) {
        if let Some(slot) = self.last.get_mut(self.count as usize % Self::KEPT) {
            *slot = (t, channel);
        }
        self.count += 1;
    }

    /// The first known change by another channel after the first `known` changes and before a time: when, and by which.
    pub fn of_others(&self, channel: u16, known: u64, before: i64) -> Option<(i64, u16)> {
        let first = known.max(self.count.saturating_sub(Self::KEPT as u64));
        let mut later = (first..self.count).filter_map(|at| self.last.get(at as usize % Self::KEPT));
        later.find(|(t, by)| *by != channel && *t < before).copied()
    }

    /// The last change: when, and by which channel.
    pub fn newest(&self) -> Option<(i64, u16)> {
        let last = self.count.checked_sub(1)?;
        self.last.get(last as usize % Self::KEPT).copied()
    }
}

/// How a spindle follows another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleCoupling {
    /// Leading spindle, by index of the machine's list.
    pub leader: usize,
    /// Revolutions of the follower per revolution of the leader; negative: in the opposite direction.
    pub ratio: f64,
    /// Angle between the spindles, degrees, if they turn in phase.
    pub phase: Option<f64>,
    /// The follower turned in the other direction when the coupling began, and keeps it.
    pub mirrored: bool,
}

/// A spindle with its last writer.
#[derive(Debug, Clone, Copy, Default)]
pub struct SharedSpindle {
    /// The last command.
    pub command: SpindleCommand,
    /// Speed now, rev/min: under constant surface speed by the X of the channel that commands it.
    pub now: f64,
    /// The last move that drove the spindle; `now` is the speed at its end.
    pub course: Option<DrivingMove>,
    /// Changes of its speed.
    pub changes: SpeedChanges,
    /// Channel that wrote last and not yet met the others since; 0 = none.
    pub writer: u16,
    /// Channels that have met the writer since its write.
    pub ordered: ChannelSet,
    /// The coupling in which the spindle follows another spindle.
    pub coupling: Option<SpindleCoupling>,
    /// Largest speed that the spindles coupled with it allow, rev/min.
    pub ceiling: Option<f64>,
    /// Time at which the spindle reaches the speed of its last command, ns, on machines that know chucks.
    pub settled: i64,
}

impl SharedSpindle {
    /// Records a write by a channel. Returns the channel of the previous write if no meeting orders that write before
    /// this one, otherwise 0.
    pub fn written(&mut self, channel: u16) -> u16 {
        let other = self.writer != 0 && self.writer != channel && !self.ordered.has(channel);
        let conflict = if other { self.writer } else { 0 };
        self.writer = channel;
        self.ordered = ChannelSet::default().with(channel);
        conflict
    }

    /// Changes the command, at a time and by a channel. If that changes the speed, the spindle then keeps the speed `was`
    /// until its driver moves. `range`: smallest and largest speed of the spindle itself, rev/min. Returns whether that
    /// changes anything.
    pub fn change(
        &mut self,
        change: impl Fn(&mut SpindleCommand),
        (was, range): (f64, [f64; 2]),
        (t, channel): (i64, u16),
    ) -> bool {
        let old = self.command;
        change(&mut self.command);
        if self.command == old {
            return false;
        }
        if self.keeps_speed(&old, was, range, t) {
            return true;
        }
        if self.course.take().is_some() || old.driver == channel && self.command.driver != channel {
            self.now = was;
        }
        self.changes.note(t, channel);
        true
    }

    /// Whether a change of the limits from those of the old command leaves the speed as it is.
    fn keeps_speed(&self, old: &SpindleCommand, was: f64, range: [f64; 2], t: i64) -> bool {
        let new = &self.command;
        if (SpindleCommand { limit: new.limit, least: new.least, ..*old }) != *new {
            return false;
        }
        let [before, after] = [old, new].map(|command| command.bounds(range));
        let clamp = |[min, max]: [f64; 2], rpm: f64| rpm.min(max).max(min);
        if !new.css {
            return clamp(before, new.rpm) == clamp(after, new.rpm);
        }
        match self.course.filter(|course| t < course.time[1]) {
            Some(DrivingMove { driven: DrivenSpeed { speed, radii: [from, to], .. }, .. }) => {
                let nearest = if from * to <= 0.0 { 0.0 } else { from };
                let rpm = |[min, max]: [f64; 2], radius| SurfaceSpeed { min, max, ..speed }.rpm(radius);
                [from, to, nearest].iter().all(|radius| rpm(before, *radius) == rpm(after, *radius))
            }
            // At a limit the speed without it is not known.
            None => {
                clamp(after, was) == was
                    && (was > before[0] || after[0] >= before[0])
                    && (was < before[1] || after[1] <= before[1])
            }
        }
    }
}

impl SharedState {
    /// A sync point orders all earlier commands of its participants before all later ones.
    pub fn met(&mut self, channels: ChannelSet) {
        for spindle in &mut self.spindles {
            if channels.has(spindle.writer) {
                spindle.ordered = ChannelSet(spindle.ordered.0 | channels.0);
            }
        }
    }
}

impl SharedState {
    /// A global variable that all kernels share.
    pub fn global(&mut self, index: usize, access: &mut dyn FnMut(&mut MacroValue)) {
        if self.globals.len() <= index {
            self.globals.resize(index + 1, MacroValue::Unset);
        }
        if let Some(value) = self.globals.get_mut(index) {
            access(value);
        }
    }

    /// Counts a change of the data that all kernels share; true if they have become too large.
    pub fn grown(&mut self, bytes: usize, limit: u64) -> bool {
        let Self { hoard, globals, named, files, .. } = self;
        let bytes_of_files = files.bytes() as u64;
        hoard.grown(bytes, limit.saturating_sub(bytes_of_files), || {
            let names: usize = named.keys().map(|name| name.len() + 60).sum();
            weight(globals.iter().chain(named.values())) + names as u64
        })
    }
}
