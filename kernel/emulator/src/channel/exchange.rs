//! Axes that channels exchange: requested, taken, released, and the channel that may move them.
//!
//! Facts: reference channel-synchronisation.md 1.4, 1.9, scenario M11. Decisions: a word of an axis that the channel
//! does not hold is an alarm and no part of its block acts, unless the machine asks for the axis by itself; a channel
//! that gets an axis finds it where the last holder has moved it; the end of a program gives nothing back. *Invariant:*
//! only the coordinator knows the holder of an axis, and every word and move of such an axis asks there.

use counterpoint_event::event::{Kind, Motion, MotionKind};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::index::{AxisId, AxisSlot, BySlot};
use counterpoint_sync::LastAxisMove;
use counterpoint_sync::wait::{Wait, WaitOp};

use super::Kernel;
use counterpoint_channel::position::MotionState;
use counterpoint_waits::Meaning;
use counterpoint_waits::leases::{self, Leased, of_axis};

impl Kernel<'_> {
    /// A statement about an axis or a spindle that channels exchange; some pass it on to another channel.
    pub(crate) fn exchange(&mut self, statement: &str, name: &str, to: Option<i64>) -> Acted {
        self.flush_lookahead()?;
        let channel = self.channel.at.channel;
        let (leased, meaning) = match leases::by_name(self.channel.env.machine, (statement, name), channel, to) {
            Ok(found) => found,
            Err(reason) => {
                let text = format!("{reason}, in '{}'", self.channel.block_text());
                return Err(self.alarm(&diag::STATEMENT_ARGUMENTS, text));
            }
        };
        let alone = self.channel.env.options.ignore_waits.contains(&channel);
        match (leased, meaning) {
            // No other channel can have it.
            (Leased::Own, _) => return Ok(()),
            (_, Meaning::Wait(wait)) if alone => self.take_lease(wait)?,
            (_, Meaning::Wait(wait)) => self.wait(wait)?,
            (_, Meaning::Act(WaitOp::Take(_), wait)) => self.take_lease(wait)?,
            (_, Meaning::Act(act, wait)) => return self.let_continue(act, wait),
        }
        if let Leased::Axis(axis) = leased { self.find_moved(axis) } else { Ok(()) }
    }

    /// Words of axes that channels exchange: the channel holds them, or gets them now.
    pub(super) fn check_exchanged(&mut self, slots: u8) -> Acted {
        self.follower_moved(slots)?;
        let axes: Vec<(AxisSlot, AxisId)> =
            self.channel.state.place.layout.axes.entries().map(|(slot, axis)| (slot, axis.machine)).collect();
        let channel = self.channel.at.channel;
        for (_, axis) in axes.into_iter().filter(|(slot, _)| slots & slot.bit() != 0) {
            let (holder, _) = self.shared(|order| order.waits.lease(of_axis(axis)))?;
            if holder != Some(channel) {
                let machine = self.channel.env.machine;
                match leases::automatic(machine, axis, channel).filter(|_| machine.sync.asks_for_axes) {
                    Some(wait) if self.channel.env.options.ignore_waits.contains(&channel) => self.take_lease(wait)?,
                    Some(wait) => self.wait(wait)?,
                    None => return Err(self.not_held(axis, holder)),
                }
            }
            self.find_moved(axis)?;
        }
        Ok(())
    }

    /// The channel moves axes that channels exchange.
    #[cold]
    #[inline(never)]
    pub(super) fn exchanged_move(&mut self, seconds: f64, motion: &Motion) -> Acted {
        let slots = self.channel.state.place.layout.exchanged;
        let channel = self.channel.at.channel;
        let end_ns = self.channel.at.clock + counterpoint_channel::at::nanoseconds(seconds);
        let to = self.channel.state.place.machine_point(&motion.to);
        let in_exchange = |slot: &AxisSlot| slots & slot.bit() != 0;
        for slot in self.channel.state.place.layout.axes.ids().filter(in_exchange).collect::<Vec<_>>() {
            if !moves(motion, slot) {
                continue;
            }
            self.follower_moved(slot.bit())?;
            let axis = self.channel.state.place.layout.axes[slot].machine;
            let moved = LastAxisMove { to: to.at(slot), end_ns, by: channel };
            if let Err(holder) = self.shared(|order| order.waits.moves(channel, of_axis(axis), moved))? {
                return Err(self.not_held(axis, holder));
            }
        }
        Ok(())
    }

    fn not_held(&mut self, axis: AxisId, holder: Option<u16>) -> Halt {
        let (channel, name) = (self.channel.at.channel, &self.channel.env.machine.axes[axis].name);
        let whose =
            holder.map_or_else(|| "no channel holds it".to_owned(), |holder| format!("channel {holder} holds it"));
        let text = format!(
            "axis {name} is not in channel {channel} now, {whose}, in '{}'; no part of the block acts",
            self.channel.block_text()
        );
        self.alarm(&diag::AXIS_NOT_HELD, text)
    }

    /// Takes a resource that another channel holds, after a move in progress there.
    fn take_lease(&mut self, wait: Wait) -> Acted {
        let tag = self.channel.tag();
        let taken = self.shared(|order| order.take(tag, wait.key))?;
        let after = taken.map_err(|reason| super::wait::impossible(self, &reason))?;
        self.flow.pass.effects = true;
        match after {
            Some(after) => super::wait::wait_until(self, wait, after),
            None => {
                let text = self.channel.reports.waits.rules.text(&wait);
                self.channel.emit(0, Kind::mode(format!("sync mark={text} take")));
                Ok(())
            }
        }
    }

    /// The axis is where another channel has moved it.
    fn find_moved(&mut self, axis: AxisId) -> Acted {
        let (_, moved) = self.shared(|order| order.waits.lease(of_axis(axis)))?;
        let channel = self.channel.at.channel;
        let slot = self.channel.state.place.layout.axes.find(|own| own.machine == axis);
        if let Some((moved, slot)) = moved.filter(|moved| moved.by != channel).zip(slot) {
            let place = self.channel.state.place.position;
            let mut machine = self.channel.state.place.machine_point(&place);
            *machine.at_mut(slot) = moved.to;
            self.channel.state.place.position = self.channel.state.place.point_of_machine(&machine);
        }
        Ok(())
    }
}

/// Whether the axis takes part in the move.
fn moves(motion: &Motion, slot: AxisSlot) -> bool {
    let round = matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw);
    round && motion.plane_axes.map(usize::from).contains(&slot.index()) || motion.from.at(slot) != motion.to.at(slot)
}

/// Whether a move concerns an axis that channels exchange.
#[cold]
#[inline(never)]
pub(super) fn moves_exchanged(place: &MotionState, motion: &Motion) -> bool {
    let layout = &place.layout;
    layout.axes.ids().any(|slot| layout.exchanged & slot.bit() != 0 && moves(motion, slot))
}
