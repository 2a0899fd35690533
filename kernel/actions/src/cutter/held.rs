//! Effects that are held back with a waiting move, and their release after that move.
//!
//! While a move waits, the clock stays at the start of the move and advances by later events (dwells, functions). When
//! the move has been made, all events held back are shifted by its time. *Invariant:* none of them comes before the last
//! microstep of the move, even if the move took no time because an alarm ended it.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::cutter::WaitingMove;
use counterpoint_event::event::Event;

use crate::context::ActionContext;

/// Shift of the effects that are held back behind the moves made so far.
#[derive(Clone, Copy, Default)]
pub(crate) struct HeldShift {
    /// Time of these moves, ns.
    late: i64,
    /// Time and microstep at which the last of them ended.
    end: (i64, u32),
}

impl HeldShift {
    /// Adds a move that began at this time and ended at this time and microstep.
    pub(crate) fn add(&mut self, begin: i64, end: (i64, u32)) {
        self.late = self.late.saturating_add(end.0.saturating_sub(begin));
        self.end = end;
    }

    /// Time and microstep of an effect that was to come at this time and microstep.
    pub(crate) fn of(self, (t, micro): (i64, u32)) -> (i64, u32) {
        let (t, micro) = (t.saturating_add(self.late), if self.late > 0 { 0 } else { micro });
        (t, if t == self.end.0 { micro.max(self.end.1) } else { micro })
    }
}

/// Releases all held events at their times, without the move before them.
pub(crate) fn release_held(act: &mut ActionContext<'_, '_>) {
    let mut events = act.channel_mut().emitter.release().into_iter();
    put_back_events(act.channel_mut(), &mut events, usize::MAX, HeldShift::default());
}

/// Releases held events up to (not including) the event with this number.
pub(crate) fn put_back_events(
    channel: &mut ChannelContext<'_>,
    events: &mut std::vec::IntoIter<Event>,
    count: usize,
    shift: HeldShift,
) {
    for mut event in events.by_ref().take(count) {
        (event.t_ns, event.micro) = shift.of((event.t_ns, event.micro));
        channel.emitter.push(event);
    }
}

/// Goes to the time and block of a waiting move.
pub(crate) fn go_to(channel: &mut ChannelContext<'_>, waiting: &WaitingMove, shift: HeldShift) {
    let at = &mut channel.at;
    (at.clock, at.micro) = shift.of((waiting.clock, waiting.micro));
    channel.at.go_to(waiting.place);
    channel.text.edited.clone_from(&waiting.text);
    channel.block.flags.exact_stop = waiting.exact;
}
