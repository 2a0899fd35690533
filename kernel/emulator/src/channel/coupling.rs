//! Axes of two channels that are coupled: the actions of both channels when they meet at the code, and the limits of a
//! coupled axis.
//!
//! Facts: Fanuc synchronous, composite and superimposed control; the alarms are those of its alarm list. Decisions: the
//! commanded distance of each axis reaches the other channel where both meet, at the codes and at other barriers; a
//! channel sees its slave in the position of that moment. *Invariant:* coupled channels exchange data through shared
//! operations before and after a barrier of both, so the data depend on simulated time alone.

use counterpoint_event::event::Kind as Logged;
use counterpoint_event::event::{CarriedMove, Position, Primitive};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_sync::shared::{Coupled, CoupledPosition};
use counterpoint_sync::wait::Wait;
use counterpoint_waits::coupling::{CoupledAxis, CoupledPair, CouplingKind};

use super::Kernel;
use counterpoint_channel::ChannelMemory;
use counterpoint_channel::channel_axis::TravelBounds;
use counterpoint_channel::coupling::{Coupling, Parking, slots};
use counterpoint_channel::position::MotionState;

/// Where two channels meet.
#[derive(Debug, Clone, Copy)]
pub(super) enum Meeting {
    /// At the code that couples, so often before.
    On(u8),
    /// At the code that ends it.
    Off,
    /// At another barrier.
    Between,
}

/// An axis that a coupling has moved to another position, and the previous position of its channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct CoupledAxisMove {
    slot: AxisSlot,
    from: Position,
}

impl Meeting {
    fn number(self) -> u8 {
        match self {
            Self::On(before) => before % 2,
            Self::Off => 2,
            Self::Between => 3,
        }
    }
}

impl Kernel<'_> {
    /// Couples an axis of this channel with one of another channel. The same synchronous pair again only changes the
    /// parked axes.
    pub fn couple(&mut self, pair: CoupledPair, parking: Parking) -> Acted {
        let Some((own, other)) = pair.of(self.channel.at.channel) else { return Ok(()) };
        let Some(slot) = self.channel.state.place.layout.axes.find(|axis| axis.machine == own.axis) else {
            return Ok(());
        };
        self.flush_lookahead()?;
        let machine = self.channel.env.machine;
        let before = self.channel.state.others.couplings.iter().find(|coupling| coupling.pair == pair);
        let meetings = before.map_or(0, |coupling| coupling.meetings.wrapping_add(1));
        let theirs = self.meet_at(&pair, Meeting::On(meetings), pair.wait(false))?;
        let moved = self.uncouple(&pair, theirs.by);
        let stood = self.place_of(slot);
        let sign = pair.sign(machine);
        let mut coupling =
            Coupling { pair, slot, slave: own == pair.slave, parking, stood, from: stood, meetings, own: None };
        if pair.kind == CouplingKind::Composite {
            coupling.from = if machine.sync.composite_places { sign * theirs.place } else { stood };
            self.put(slot, coupling.from);
            let moves = (theirs.place, coupling.from, sign);
            let layout = &mut self.channel.state.place.layout;
            let moving = layout.axes[slot].moving(&machine.axes[other.axis], moves);
            coupling.own = Some((std::mem::replace(&mut layout.axes[slot], moving), moves));
            limits_changed(&mut self.channel.state.place);
        }
        self.channel.state.others.couplings.push(coupling);
        self.hold_followers();
        self.log_coupling(&pair, "", moved);
        Ok(())
    }

    /// Ends a coupling of this channel together with the other channel.
    pub fn end_coupling(&mut self, pair: CoupledPair) -> Acted {
        self.flush_lookahead()?;
        let theirs = self.meet_at(&pair, Meeting::Off, pair.wait(true))?;
        let moved = self.uncouple(&pair, theirs.by);
        self.log_coupling(&pair, " off", moved);
        if moved.is_some() && self.channel.state.place.layout.bounds.limited {
            let position = self.channel.state.place.position;
            self.check_limits_of_axes(&position);
        }
        self.channel.check_stop()
    }

    /// Two channels wait for each other, and let each other know where their axes are.
    fn meet_at(&mut self, pair: &CoupledPair, meeting: Meeting, wait: Wait) -> Result<CoupledPosition, Halt> {
        self.tell(pair, meeting)?;
        self.wait_plainly(wait)?;
        self.hear(pair, meeting)
    }

    /// Lets the other channel of a pair know where the own axis is.
    pub(super) fn tell(&mut self, pair: &CoupledPair, meeting: Meeting) -> Acted {
        let Some((own, other)) = pair.of(self.channel.at.channel) else { return Ok(()) };
        let stand = self.stand_of(pair, own);
        let key = key(own, other, meeting);
        self.shared(|order| order.shared.coupled.insert(key, stand)).map(|_| ())
    }

    /// Takes over the data of the other channel of a pair.
    pub(super) fn hear(&mut self, pair: &CoupledPair, meeting: Meeting) -> Result<CoupledPosition, Halt> {
        let Some((own, other)) = pair.of(self.channel.at.channel) else { return Ok(CoupledPosition::default()) };
        let key = key(other, own, meeting);
        self.shared(|order| order.shared.coupled.get(&key).copied().unwrap_or_default())
    }

    /// Position of the own axis of a pair, and the distance commanded since the coupling.
    pub(super) fn stand_of(&self, pair: &CoupledPair, own: CoupledAxis) -> CoupledPosition {
        let layout = &self.channel.state.place.layout;
        let Some(slot) = layout.axes.find(|axis| axis.machine == own.axis) else { return CoupledPosition::default() };
        let place = self.place_of(slot);
        let coupled = self.channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
        CoupledPosition { place, by: coupled.map_or(0.0, |coupling| place - coupling.from) }
    }

    /// Ends a coupling here: the axis is where both channels have brought it. Returns the axis if that is another
    /// place.
    pub(super) fn uncouple(&mut self, pair: &CoupledPair, theirs: f64) -> Option<CoupledAxisMove> {
        let couplings = &mut self.channel.state.others.couplings;
        let at = couplings.iter().position(|coupling| coupling.pair == *pair)?;
        let coupling = couplings.remove(at);
        let slot = coupling.slot;
        if let Some((own, _)) = coupling.own {
            self.channel.state.place.layout.axes[slot] = own;
            limits_changed(&mut self.channel.state.place);
        }
        self.hold_followers();
        let by = pair.sign(self.channel.env.machine) * theirs;
        let place = match (pair.kind, coupling.slave, coupling.parking) {
            (CouplingKind::Composite, ..) => coupling.stood + by,
            (CouplingKind::Synchronous, true, Parking::Slave) | (CouplingKind::Synchronous, false, Parking::Master) => {
                coupling.stood
            }
            (CouplingKind::Synchronous, true, _) => coupling.stood + by,
            (CouplingKind::Superimposed, true, _) => self.place_of(slot) + by,
            (CouplingKind::Synchronous | CouplingKind::Superimposed, false, _) => return None,
        };
        self.put(slot, place)
    }

    /// Place of an axis in the machine frame, geometry units.
    pub(super) fn place_of(&self, slot: AxisSlot) -> f64 {
        let place = &self.channel.state.place;
        self.channel.state.place.machine_point(&place.position).at(slot) * place.layout.axes[slot].scale
    }

    /// Sets an axis to a position of the machine frame, geometry units. Returns it if the position has changed.
    pub(super) fn put(&mut self, slot: AxisSlot, place: f64) -> Option<CoupledAxisMove> {
        let from = self.channel.state.place.position;
        let mut machine = self.channel.state.place.machine_point(&self.channel.state.place.position);
        let (before, after) = (machine.at(slot), place / self.channel.state.place.layout.axes[slot].scale);
        if before == after {
            return None;
        }
        *machine.at_mut(slot) = after;
        self.channel.state.place.position = self.channel.state.place.way_of_machine(&machine);
        if let Some(cutter) = self.channel.state.place.cutter() {
            *cutter.contour.at_mut(slot) += after - before;
        }
        Some(CoupledAxisMove { slot, from })
    }

    /// Another component of a composite machine works: its axes are coupled as before.
    pub fn keep_couplings(&mut self) {
        let (machine, own_number) = (self.channel.env.machine, self.channel.at.channel);
        let ChannelMemory { place, others, .. } = &mut self.channel.state;
        for coupling in &mut others.couplings {
            let (slot, other) = (coupling.slot, coupling.pair.of(own_number).map(|(_, other)| other));
            if let Some(((own, moves), other)) = coupling.own.as_mut().zip(other) {
                let moving = place.layout.axes[slot].moving(&machine.axes[other.axis], *moves);
                *own = std::mem::replace(&mut place.layout.axes[slot], moving);
            }
        }
        limits_changed(&mut self.channel.state.place);
        self.hold_followers();
    }

    /// Words of axes that follow others are not commands.
    pub(super) fn hold_followers(&mut self) {
        let machine = self.channel.env.machine;
        let held = slots(&self.channel.state.others.couplings, Coupling::follows);
        let layout = &mut self.channel.state.place.layout;
        for (slot, axis) in
            layout.axes.entries().filter(|(_, axis)| machine.axes[axis.machine].coupling.number.is_some())
        {
            let registers = self.channel.tables.registers_of(axis.data);
            let leased = machine.axes[axis.machine].master.is_some();
            if held & slot.bit() != 0 {
                layout.bounds.foreign |= registers;
                layout.exchanged |= slot.bit();
            } else if !leased {
                layout.bounds.foreign &= !registers;
                layout.exchanged &= !slot.bit();
            }
        }
    }

    pub(super) fn log_coupling(&mut self, pair: &CoupledPair, what: &str, moved: Option<CoupledAxisMove>) {
        let machine = self.channel.env.machine;
        let (master, slave) = (&machine.axes[pair.master.axis].name, &machine.axes[pair.slave.axis].name);
        let position = &self.channel.state.place.position;
        let place = moved.map_or_else(String::new, |moved| {
            format!(" {}={}", self.channel.axis_name(moved.slot), wildcard_text(position.at(moved.slot)))
        });
        // Composite control changes the coordinates of the program; nothing has moved.
        let carried = moved.filter(|_| pair.kind != CouplingKind::Composite).map(|moved| CarriedMove {
            from: Box::new(moved.from),
            to: Box::new(*position),
            axes: format!("{slave} with {master}").into(),
        });
        let text = format!("{}{what} {master} {slave}{place}", pair.kind.name());
        self.channel.emit(0, Logged::coupling(text, carried));
    }
}

/// Other barriers, and moves.
impl Kernel<'_> {
    /// Waits at a barrier while axes are coupled: a follower is then where the other channel has brought it.
    #[cold]
    #[inline(never)]
    pub(super) fn wait_coupled(&mut self, wait: Wait) -> Acted {
        let both = |coupling: &&Coupling| {
            let ends = [coupling.pair.master, coupling.pair.slave];
            wait.primitive == Primitive::Barrier && ends.iter().all(|end| wait.parts.has(end.channel))
        };
        let met = self.channel.state.others.couplings.iter().filter(both);
        let met: Vec<(CoupledPair, bool)> = met.map(|coupling| (coupling.pair, coupling.follows())).collect();
        for (pair, follows) in &met {
            if !follows {
                self.tell(pair, Meeting::Between)?;
            }
        }
        self.wait_plainly(wait)?;
        for (pair, _) in met.iter().filter(|(_, follows)| *follows) {
            let by = pair.sign(self.channel.env.machine) * self.hear(pair, Meeting::Between)?.by;
            let coupled = self.channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
            let moves = coupled.filter(|coupling| coupling.parking != Parking::Slave);
            let moved = moves.map(|coupling| (coupling.slot, coupling.stood + by));
            if let Some(moved) = moved.and_then(|(slot, place)| self.put(slot, place)) {
                self.log_coupling(pair, "", Some(moved));
            }
        }
        Ok(())
    }

    /// The alarm for a word or a move of an axis that follows another one, if one of these does.
    pub(super) fn follower_moved(&mut self, moved: u8) -> Acted {
        if moved & slots(&self.channel.state.others.couplings, Coupling::follows) == 0 {
            return Ok(());
        }
        Err(self.refuse_coupled(moved, Coupling::follows, "PS0353 axis that follows another one is commanded"))
    }

    /// The alarm for a code that an axis to which moves are added cannot have, if one of these is such an axis.
    pub fn added_to(&mut self, moved: u8, alarm: &str) -> Acted {
        let added = |coupling: &Coupling| coupling.slave && coupling.pair.kind == CouplingKind::Superimposed;
        if moved & slots(&self.channel.state.others.couplings, added) == 0 {
            return Ok(());
        }
        Err(self.refuse_coupled(moved, added, alarm))
    }

    fn refuse_coupled(&mut self, moved: u8, which: impl Fn(&Coupling) -> bool, alarm: &str) -> Halt {
        let machine = self.channel.env.machine;
        let mut coupled = self.channel.state.others.couplings.iter();
        let found = coupled.find(|coupling| moved & coupling.slot.bit() != 0 && which(coupling)).map(|c| c.pair);
        let axes = found.map_or_else(String::new, |pair| {
            let (master, slave) = (&machine.axes[pair.master.axis].name, &machine.axes[pair.slave.axis].name);
            format!(": {slave} with master {master} of channel {}", pair.master.channel)
        });
        let text = format!("{alarm}{axes}, in '{}'; no part of the block acts", self.channel.block_text());
        self.alarm(&diag::COUPLED_AXIS, text)
    }
}

pub(super) fn key(axis: CoupledAxis, with: CoupledAxis, meeting: Meeting) -> Coupled {
    Coupled { axis: axis.axis.index() as u16, with: with.axis.index() as u16, at: meeting.number() }
}

fn limits_changed(place: &mut MotionState) {
    let stored = place.stored.as_deref().is_some_and(|area| area.on);
    let layout = &mut place.layout;
    layout.bounds.nearness = TravelBounds::nearness(&layout.axes);
    layout.bounds.limited = layout.axes.iter().any(|axis| axis.limits.is_some()) || stored;
}
