//! Synchronous control commanded by one channel alone: it takes effect in the other channel at the next barrier of
//! both.
//!
//! Facts: Fanuc programs command G51.4 and G50.4 in one path, between waiting codes of both. *Invariant:* the news that
//! a channel receives depends only on the order of shared operations, and so on simulated time.

use counterpoint_fault::{Acted, Halt};
use counterpoint_sync::shared::OneSidedCoupling;

use super::Kernel;
use super::coupling::{CoupledAxisMove, Meeting, key as coupling_key};
use counterpoint_channel::coupling::{Coupling, Parking};
use counterpoint_waits::coupling::{self, CoupledPair, CouplingKind};

impl Kernel<'_> {
    /// Whether the program of this channel alone has the code of synchronous control.
    pub fn couples_alone(&mut self) -> bool {
        self.words_of_couplings() == [true, false]
    }

    /// Whether only programs of other channels have the code.
    pub(super) fn hears_of_couplings(&mut self) -> bool {
        let machine = self.channel.env.machine;
        machine.axes.iter().any(|axis| axis.coupling.number.is_some()) && self.words_of_couplings() == [false, true]
    }

    /// Whether the program of this channel, and programs of other channels, have the code.
    fn words_of_couplings(&mut self) -> [bool; 2] {
        if let Some(words) = self.channel.state.others.alone.words {
            return words;
        }
        let Some(main) = self.flow.frames.first().map(|frame| (frame.file, frame.range)) else { return [false; 2] };
        let env = &self.channel.env;
        let words = coupling::words(env.machine, (env.info, env.sources), main);
        self.channel.state.others.alone.words = Some(words);
        words
    }

    /// Couples an axis of this channel with an axis of another channel and notifies that channel. For a coupled pair,
    /// changes parking.
    pub fn couple_alone(&mut self, pair: CoupledPair, parking: Parking) -> Acted {
        self.flush_lookahead()?;
        self.end_own(&pair);
        self.say(&pair, parking, true)?;
        self.begin_coupling(pair, parking);
        self.tell(&pair, Meeting::Between)?;
        self.forget_theirs(&pair)?;
        self.log_coupling(&pair, "", None);
        Ok(())
    }

    /// Ends a coupling that this channel has commanded.
    pub fn end_alone(&mut self, pair: CoupledPair) -> Acted {
        self.flush_lookahead()?;
        self.say(&pair, Parking::Neither, false)?;
        let moved = self.end_own(&pair);
        self.log_coupling(&pair, " off", moved);
        self.channel.check_stop()
    }

    /// The other channel has moved nothing since.
    fn forget_theirs(&mut self, pair: &CoupledPair) -> Acted {
        let Some((own, other)) = pair.of(self.channel.at.channel) else { return Ok(()) };
        let key = coupling_key(other, own, Meeting::Between);
        self.shared(|order| order.shared.coupled.remove(&key)).map(|_| ())
    }

    /// Notifies the other channel.
    fn say(&mut self, pair: &CoupledPair, parking: Parking, on: bool) -> Acted {
        let Some((own, _)) = pair.of(self.channel.at.channel) else { return Ok(()) };
        let alone = OneSidedCoupling {
            by: own.channel,
            master: pair.master.number,
            slave: pair.slave.number,
            parking: parking.number(),
            on,
            stand: self.stand_of(pair, own),
        };
        self.shared(|order| order.shared.alone.push(alone))
    }

    /// The coupling begins for the axis of this channel.
    fn begin_coupling(&mut self, pair: CoupledPair, parking: Parking) {
        let Some((own, _)) = pair.of(self.channel.at.channel) else { return };
        let Some(slot) = self.channel.state.place.layout.axes.find(|axis| axis.machine == own.axis) else { return };
        let stood = self.place_of(slot);
        let slave = own == pair.slave;
        let coupling = Coupling { pair, slot, slave, parking, stood, from: stood, meetings: 0, own: None };
        self.channel.state.others.couplings.push(coupling);
        self.hold_followers();
    }

    /// Ends a coupling that this channel has commanded: a slave is where its master had brought it at the last barrier.
    fn end_own(&mut self, pair: &CoupledPair) -> Option<CoupledAxisMove> {
        let sign = pair.sign(self.channel.env.machine);
        let coupled = self.channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
        let theirs = coupled.map_or(0.0, |coupling| sign * (self.place_of(coupling.slot) - coupling.stood));
        self.uncouple(pair, theirs)
    }

    /// Applies the couplings that only another channel has commanded.
    #[cold]
    #[inline(never)]
    pub(super) fn learn_couplings(&mut self) -> Acted {
        let known = self.channel.state.others.alone.learned;
        let news =
            self.shared(|order| order.shared.alone.get(known..).map_or_else(Vec::new, <[OneSidedCoupling]>::to_vec))?;
        self.channel.state.others.alone.learned += news.len();
        let (machine, own) = (self.channel.env.machine, self.channel.at.channel);
        for alone in news.iter().filter(|alone| alone.by != own) {
            let end = |letter, number: u16| coupling::end(machine, letter, Some(f64::from(number)));
            let ends = end('P', alone.master).and_then(|master| Ok((master, end('Q', alone.slave)?)));
            let Ok((master, slave)) = ends else { continue };
            let pair = CoupledPair { kind: CouplingKind::Synchronous, master, slave };
            if pair.of(own).is_none() {
                continue;
            }
            self.flush_lookahead()?;
            let moved = self.uncouple(&pair, alone.stand.by);
            if !alone.on {
                self.log_coupling(&pair, " off", moved);
                continue;
            }
            self.begin_coupling(pair, Parking::of(alone.parking).unwrap_or_default());
            let moved = self.follow_since(&pair)?.or(moved);
            self.log_coupling(&pair, "", moved);
        }
        self.channel.check_stop()
    }

    /// A slave is where its master has brought it since the coupling was commanded.
    fn follow_since(&mut self, pair: &CoupledPair) -> Result<Option<CoupledAxisMove>, Halt> {
        let coupled = self.channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
        let follows = coupled.filter(|coupling| coupling.follows() && coupling.parking != Parking::Slave);
        let Some((slot, stood)) = follows.map(|coupling| (coupling.slot, coupling.stood)) else { return Ok(None) };
        let by = pair.sign(self.channel.env.machine) * self.hear(pair, Meeting::Between)?.by;
        Ok(self.put(slot, stood + by))
    }
}
