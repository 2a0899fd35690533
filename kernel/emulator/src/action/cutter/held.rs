//! Effects that are held back with a waiting move, and their release after that move.
//!
//! While a move waits, the clock stays at the start of the move and advances by later events (dwells, functions). When
//! the move has been made, all events held back are shifted by its time.

use crate::act::Act;
use crate::state::cutter::Waiting;
use counterpoint_event::event::Event;

impl Act<'_, '_> {
    /// Releases held events up to (not including) the event with this number; they come `late` ns later.
    pub(super) fn put_back_events(&mut self, events: &mut std::vec::IntoIter<Event>, count: usize, late: i64) {
        for mut event in events.by_ref().take(count) {
            event.t_ns = event.t_ns.saturating_add(late);
            if late > 0 {
                event.micro = 0;
            }
            self.channel_mut().emitter.push(event);
        }
    }

    /// Goes to the time and block of a waiting move.
    pub(super) fn go_to(&mut self, waiting: &Waiting, late: i64) {
        self.channel_mut().at.clock = waiting.clock.saturating_add(late);
        self.channel_mut().at.micro = if late > 0 { 0 } else { waiting.micro };
        self.channel_mut().at.go_to(waiting.place);
        self.channel_mut().text.edited.clone_from(&waiting.text);
        self.channel_mut().block.flags.exact_stop = waiting.exact;
    }
}
