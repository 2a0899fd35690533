//! Axes of two channels that are coupled: the actions of both channels when they meet at the code, and the limits of a
//! coupled axis.
//!
//! Facts: Fanuc synchronous, composite and superimposed control; the alarms are those of its alarm list. Decisions: the
//! commanded distance of each axis reaches the other channel where both meet, at the codes and at other barriers; a
//! channel sees its slave in the position of that moment. *Invariant:* coupled channels exchange data through shared
//! operations before and after a barrier of both, so the data depend on simulated time alone.

use counterpoint_channel::coupled_axes::{
    axis_place, coupled_position, hold_followers, limits_changed, log_coupling, put_axis, uncouple,
};
use counterpoint_channel::coupling::{Coupling, Parking, slots};
use counterpoint_event::event::Primitive;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_sync::shared::{Coupled, CoupledPosition};
use counterpoint_sync::wait::Wait;
use counterpoint_waits::coupling::{CoupledAxis, CoupledPair, CouplingKind};

use super::Kernel;

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
        let moved = uncouple(&mut self.channel, &pair, theirs.by);
        let stood = axis_place(&self.channel, slot);
        let sign = pair.sign(machine);
        let mut coupling =
            Coupling { pair, slot, slave: own == pair.slave, parking, stood, from: stood, meetings, own: None };
        if pair.kind == CouplingKind::Composite {
            coupling.from = if machine.sync.composite_places { sign * theirs.place } else { stood };
            put_axis(&mut self.channel, slot, coupling.from);
            let moves = (theirs.place, coupling.from, sign);
            let layout = &mut self.channel.state.place.layout;
            let moving = layout.axes[slot].moving(&machine.axes[other.axis], moves);
            coupling.own = Some((std::mem::replace(&mut layout.axes[slot], moving), moves));
            limits_changed(&mut self.channel.state.place);
        }
        self.channel.state.others.couplings.push(coupling);
        hold_followers(&mut self.channel);
        log_coupling(&mut self.channel, &pair, "", moved);
        Ok(())
    }

    /// Ends a coupling of this channel together with the other channel.
    pub fn end_coupling(&mut self, pair: CoupledPair) -> Acted {
        self.flush_lookahead()?;
        let theirs = self.meet_at(&pair, Meeting::Off, pair.wait(true))?;
        let moved = uncouple(&mut self.channel, &pair, theirs.by);
        log_coupling(&mut self.channel, &pair, " off", moved);
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
        let stand = coupled_position(&self.channel, pair, own);
        let key = key(own, other, meeting);
        self.shared(|order| order.shared.coupled.insert(key, stand)).map(|_| ())
    }

    /// Takes over the data of the other channel of a pair.
    pub(super) fn hear(&mut self, pair: &CoupledPair, meeting: Meeting) -> Result<CoupledPosition, Halt> {
        let Some((own, other)) = pair.of(self.channel.at.channel) else { return Ok(CoupledPosition::default()) };
        let key = key(other, own, meeting);
        self.shared(|order| order.shared.coupled.get(&key).copied().unwrap_or_default())
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
            if let Some(moved) = moved.and_then(|(slot, place)| put_axis(&mut self.channel, slot, place)) {
                log_coupling(&mut self.channel, pair, "", Some(moved));
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
