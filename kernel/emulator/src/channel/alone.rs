//! Synchronous control commanded by one channel alone: it takes effect in the other channel at the next barrier of
//! both.
//!
//! Facts: Fanuc programs command G51.4 and G50.4 in one path, between waiting codes of both. *Invariant:* the news that
//! a channel receives depends only on the order of shared operations, and so on simulated time.

use counterpoint_channel::coupled_axes::{
    CoupledAxisMove, begin_coupling, coupled_position, end_own, log_coupling, put_axis, uncouple,
};
use counterpoint_channel::coupling::Parking;
use counterpoint_fault::{Acted, Halt};
use counterpoint_sync::shared::OneSidedCoupling;
use counterpoint_waits::coupling;
use counterpoint_waits::coupling::{CoupledPair, CouplingKind};

use super::Kernel;
use super::coupling::Meeting;
use super::coupling::key as coupling_key;

impl Kernel<'_> {
    /// Couples an axis of this channel with an axis of another channel and notifies that channel. For a coupled pair,
    /// changes parking.
    pub fn couple_alone(&mut self, pair: CoupledPair, parking: Parking) -> Acted {
        self.flush_lookahead()?;
        end_own(&mut self.channel, &pair);
        self.say(&pair, parking, true)?;
        begin_coupling(&mut self.channel, pair, parking);
        self.tell(&pair, Meeting::Between)?;
        self.forget_theirs(&pair)?;
        log_coupling(&mut self.channel, &pair, "", None);
        Ok(())
    }

    /// Ends a coupling that this channel has commanded.
    pub fn end_alone(&mut self, pair: CoupledPair) -> Acted {
        self.flush_lookahead()?;
        self.say(&pair, Parking::Neither, false)?;
        let moved = end_own(&mut self.channel, &pair);
        log_coupling(&mut self.channel, &pair, " off", moved);
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
            stand: coupled_position(&self.channel, pair, own),
        };
        self.shared(|order| order.shared.alone.push(alone))
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
            let moved = uncouple(&mut self.channel, &pair, alone.stand.by);
            if !alone.on {
                log_coupling(&mut self.channel, &pair, " off", moved);
                continue;
            }
            begin_coupling(&mut self.channel, pair, Parking::of(alone.parking).unwrap_or_default());
            let moved = self.follow_since(&pair)?.or(moved);
            log_coupling(&mut self.channel, &pair, "", moved);
        }
        self.channel.check_stop()
    }

    /// A slave is where its master has brought it since the coupling was commanded.
    fn follow_since(&mut self, pair: &CoupledPair) -> Result<Option<CoupledAxisMove>, Halt> {
        let coupled = self.channel.state.others.couplings.iter().find(|coupling| coupling.pair == *pair);
        let follows = coupled.filter(|coupling| coupling.follows() && coupling.parking != Parking::Slave);
        let Some((slot, stood)) = follows.map(|coupling| (coupling.slot, coupling.stood)) else { return Ok(None) };
        let by = pair.sign(self.channel.env.machine) * self.hear(pair, Meeting::Between)?.by;
        Ok(put_axis(&mut self.channel, slot, stood + by))
    }
}
