//! Effects that are held back with a waiting move, and their release after that move.
//!
//! While a move waits, the clock stays at the start of the move and advances by later events (dwells, functions). When
//! the move has been made, all events held back are shifted by its time.

use crate::act::Act;
use crate::state::cutter::{Held, Waiting};
use counterpoint_event::event::Event;

impl Act<'_, '_> {
    /// Holds events back from here on.
    pub(super) fn buffer_events(&mut self) {
        if self.channel().held.is_none() {
            self.channel_mut().held = Some(Held { events: Vec::new(), since: self.channel().at.tag() });
            self.hold_back();
        }
    }

    /// Events held back so far.
    pub(super) fn buffered_events(&self) -> usize {
        self.channel().held.as_ref().map_or(0, |held| held.events.len())
    }

    /// Ends holding events back; the caller puts them where they belong.
    pub(super) fn release_events(&mut self) -> Vec<Event> {
        let events = self.channel_mut().held.take().map(|held| held.events).unwrap_or_default();
        self.hold_back();
        events
    }

    /// Releases held events up to (not including) the event with this number; they come `late` ns later.
    pub(super) fn put_back_events(&mut self, events: &mut std::vec::IntoIter<Event>, count: usize, late: i64) {
        for mut event in events.by_ref().take(count) {
            event.t_ns = event.t_ns.saturating_add(late);
            if late > 0 {
                event.micro = 0;
            }
            self.push_event(event);
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
