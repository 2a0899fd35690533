//! Spindles of a channel: the active one, and those that it can activate.
//!
//! *Invariant:* a spindle that several channels command has no state of its own here but a copy.

use super::at::nanoseconds;
use super::channel_context::ChannelContext;
use super::fixed_stops::FixedStops;
use super::modal::group;
use counterpoint_motion::law::SpindleRotation;
use counterpoint_motion::surface_speed::SurfaceSpeed;

use counterpoint_event::info::MachineUnit;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{IdTable, SpindleId};
use counterpoint_machine::model::{Channel as MachineChannel, Machine};
use counterpoint_sync::shared::{DrivingMove, SpindleCommand};

/// Spindle of the channel: its own state, or a copy of the shared one.
#[derive(Debug, Clone, Copy, Default)]
pub struct SpindleState {
    /// The active spindle, `None` = channel without spindle.
    pub id: Option<SpindleId>,
    /// Other channels command it too, or it can be coupled with another spindle.
    pub shared: bool,
    /// Last known command.
    pub command: SpindleCommand,
    /// Current speed while another channel drives the spindle, after `course`.
    pub now: f64,
    /// The last known move that drove the spindle.
    pub course: Option<DrivingMove>,
    /// Number of known speed changes.
    pub changes: u64,
    /// The last of them: when, and by which channel.
    pub changed: Option<(i64, u16)>,
    /// The last time that was computed with the speed known then.
    pub assumed: Option<AssumedSpeed>,
    /// Largest speed that the spindles coupled with it allow, rev/min.
    pub ceiling: Option<f64>,
}

/// A move or a dwell by revolutions of a spindle that other channels also drive.
#[derive(Debug, Clone, Copy)]
pub struct AssumedSpeed {
    /// Line of its program.
    pub line: u32,
    /// Its start and its end, ns.
    pub time: [i64; 2],
    /// Number of speed changes known then.
    pub changes: u64,
}

impl SpindleState {
    /// Smallest and largest speed of the spindle itself, rev/min.
    pub fn range(&self, machine: &Machine) -> [f64; 2] {
        let ceiling = self.ceiling.unwrap_or(f64::INFINITY);
        match self.id.map(|id| &machine.spindles[id]) {
            Some(spindle) if spindle.max > 0.0 => [spindle.min, spindle.max.min(ceiling)],
            Some(spindle) => [spindle.min, ceiling],
            None => [0.0, f64::INFINITY],
        }
    }

    /// Whether another channel can see a command for the spindle.
    pub fn is_seen(&self, machine: &Machine) -> bool {
        self.shared && machine.channels.len() > 1
    }

    /// Speed of a command under constant surface speed, within the limits of the spindle and of the program.
    pub fn surface_speed(&self, machine: &Machine, secondary: bool, command: &SpindleCommand) -> SurfaceSpeed {
        let [min, max] = command.bounds(self.range(machine));
        let factor = match (machine.unit, secondary) {
            (MachineUnit::Mm, false) | (MachineUnit::Inch, true) => 1000.0,
            (MachineUnit::Mm, true) | (MachineUnit::Inch, false) => 12.0,
        };
        let to_machine = match (machine.unit, secondary) {
            (MachineUnit::Mm, true) => 25.4,
            (MachineUnit::Inch, true) => 1.0 / 25.4,
            _ => 1.0,
        };
        SurfaceSpeed { surface: command.surface * factor * to_machine, max, min }
    }

    /// The rotation at this time, ns, while another channel drives the spindle.
    pub fn driven(&self, now: i64) -> Option<SpindleRotation> {
        match self.course.filter(|course| now < course.time[1]) {
            Some(course) => Some(SpindleRotation::Driven(course.driven, course.elapsed(now))),
            None => (self.now > 0.0).then_some(SpindleRotation::Fixed(self.now)),
        }
    }

    /// Records that a move or dwell of a line, from `begin` ns on, was timed with the spindle speed known now.
    pub fn assume(&mut self, line: u32, begin: i64, seconds: f64) {
        let time = [begin, begin.saturating_add(nanoseconds(seconds))];
        self.assumed = Some(AssumedSpeed { line, time, changes: self.changes });
    }

    /// The number of speed changes known when the last time was computed with a speed, and the begin and the end of
    /// that time, once it is over at `now`, ns.
    pub fn ended_assumption(&self, now: i64) -> Option<(u64, [i64; 2])> {
        let assumed = self.assumed.filter(|assumed| assumed.time[0] < now)?;
        Some((assumed.changes, [assumed.time[0], assumed.time[1].min(now)]))
    }
}

/// Spindles of one channel, and their current uses.
#[derive(Debug)]
pub struct Spindles {
    /// The main spindle.
    pub front: Option<SpindleId>,
    /// The sub-spindle.
    pub rear: Option<SpindleId>,
    /// The spindle of live tools.
    pub mill: Option<SpindleId>,
    /// Commands of spindles that are not active.
    pub kept: IdTable<SpindleId, SpindleCommand>,
    /// Milling mode.
    pub milling: bool,
    /// Number in the code of the spindle that the channel started last, 0 = codes without a number.
    pub started: u16,
    /// The same of the last one that is not a spindle of live tools.
    pub turned: u16,
    /// Line of a block whose spindle code has not acted yet, and whether its speed is a surface speed.
    pub mode_of_block: Option<(u32, bool)>,
    /// Head that drives constant surface speed, when a code has set it.
    pub driver: Option<u16>,
    /// A speed that waits for the next spindle code.
    pub waiting: Option<f64>,
    /// The machine knows the chucks of two spindles.
    pub chucks: bool,
    /// Moves against a stop, for example of the sub-spindle against the part.
    pub fixed_stops: FixedStops,
}

impl Spindles {
    /// The spindles of a channel, at rest.
    pub fn new(machine: &Machine, channel: &MachineChannel) -> Self {
        Self {
            front: channel.spindle,
            rear: channel.rear,
            mill: channel.milling,
            kept: machine.spindles.map(|_, _| SpindleCommand::default()),
            milling: false,
            started: 0,
            turned: 0,
            mode_of_block: None,
            driver: None,
            waiting: None,
            chucks: machine.chucks().is_some(),
            fixed_stops: FixedStops::default(),
        }
    }
}

/// Whether the machine commands this spindle by codes of its number.
fn has_codes(machine: &Machine, number: u16) -> bool {
    machine.codes.iter().any(|row| {
        row.enable && matches!(row.id.kind(), CodeKind::Spindle { number: of, .. } if of == number && of > 0)
    })
}

/// Whether more than one channel can command the spindle, or spindles of the machine can turn together.
pub fn is_shared(machine: &Machine, id: SpindleId) -> bool {
    let uses = |channel: &&MachineChannel| [channel.spindle, channel.rear, channel.milling].contains(&Some(id));
    let users = machine.channels.iter().filter(uses).count();
    let named = machine.data.iter().any(|row| row.id == data::COUPLE_SPINDLE_FOLLOWER && row.enable);
    let pairs = named || machine.spindles.entries().any(|(_, spindle)| spindle.follows.is_some());
    users > 1 || pairs || machine.channels.len() > 1 && has_codes(machine, machine.spindles[id].number)
}

/// `spindle 1 (MAIN) is stopped`, with the other channel if that stopped it.
pub fn stopped(channel: &ChannelContext<'_>) -> String {
    let (state, own) = (&channel.state.spindle, channel.at.channel);
    let Some(id) = state.id else { return "channel without a spindle".to_owned() };
    let spindle = &channel.env.machine.spindles[id];
    let by = state.changed.filter(|(_, other)| state.shared && *other != own);
    let by = by.map_or_else(String::new, |(t, other)| format!(" by channel {other} at {:.3} s", t as f64 / 1e9));
    format!("spindle {} ({}) is stopped{by}", spindle.number, spindle.name)
}

impl ChannelContext<'_> {
    /// The spindle of codes without a number: not a milling one that has codes of its own.
    pub fn plain_spindle(&self) -> Option<SpindleId> {
        let spindles = &self.state.others.spindles;
        let mill = spindles.mill.filter(|_| spindles.milling && self.milling_code() == 0);
        mill.or_else(|| self.turning_spindle())
    }

    /// The spindle that turns the part.
    pub fn turning_spindle(&self) -> Option<SpindleId> {
        let spindles = &self.state.others.spindles;
        let rear = spindles.rear.filter(|_| self.state.modal.code(group::SPINDLES) == Some(codes::SPINDLE_REAR));
        rear.or(spindles.front)
    }

    /// The active spindle.
    pub fn working_spindle(&self) -> Option<SpindleId> {
        let spindles = &self.state.others.spindles;
        spindles.mill.filter(|_| spindles.milling).or_else(|| self.turning_spindle())
    }

    /// Number of a spindle in the codes of the machine, 0 for none.
    pub fn number_in_codes(&self, id: Option<SpindleId>) -> u16 {
        let number = id.map_or(0, |id| self.env.machine.spindles[id].number);
        if has_codes(self.env.machine, number) { number } else { 0 }
    }

    /// `$STID`
    pub fn turning_code(&self) -> u16 {
        self.number_in_codes(self.turning_spindle())
    }

    /// `$SMID`
    pub fn milling_code(&self) -> u16 {
        self.number_in_codes(self.state.others.spindles.mill)
    }

    /// Activates the spindle that the codes select.
    pub fn follow_spindle(&mut self) {
        let wanted = self.working_spindle();
        self.select_spindle(wanted);
    }

    /// Puts a spindle into work.
    pub fn select_spindle(&mut self, id: Option<SpindleId>) {
        if id == self.state.spindle.id {
            return;
        }
        let old = self.state.spindle;
        let kept = &mut self.state.others.spindles.kept;
        if let Some(old_id) = old.id.filter(|_| !old.shared) {
            kept[old_id] = old.command;
        }
        let command = id.map_or_else(SpindleCommand::default, |id| kept[id]);
        let shared = id.is_some_and(|id| is_shared(self.env.machine, id));
        self.state.spindle = SpindleState { id, shared, command, ..SpindleState::default() };
    }
}

/// Whether the code of a spindle is that of live tools: the spindle is neither the main nor the sub-spindle of the
/// channel.
pub fn is_tool_spindle(channel: &ChannelContext<'_>, number: u16) -> bool {
    let id = match number {
        0 => channel.plain_spindle(),
        _ => channel.env.machine.spindles.find(|spindle| spindle.number == number),
    };
    let spindles = &channel.state.others.spindles;
    id.is_some() && id != spindles.front && id != spindles.rear
}
