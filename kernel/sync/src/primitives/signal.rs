//! Signal: each wait uses up one signal of each sender that it names, or one that any channel sent to everybody.
//!
//! *Invariant:* a signal that comes before its wait is kept; each receiver gets its own. Facts: reference
//! channel-synchronisation.md 1.0 (starts by one head), 1.7.

use std::collections::BTreeMap;

use super::MOST;
use crate::wait::{Key, Missing, Set, Wait};

/// Sender of a signal to everybody.
const ANYBODY: u16 = 0;

/// By mark, receiver and sender: signals that nobody has waited for yet.
#[derive(Debug, Clone, Default)]
pub(super) struct Signals(BTreeMap<(Key, u16, u16), u32>);

/// Any sender will do.
fn takes_any(wait: &Wait) -> bool {
    wait.need != 0
}

impl Signals {
    /// Sends one to each of these channels.
    pub(super) fn send(&mut self, channel: u16, key: Key, to: Set, broadcast: bool) -> Result<(), String> {
        let sender = if broadcast { ANYBODY } else { channel };
        for receiver in to.without(channel).iter() {
            if self.0.len() >= MOST && !self.0.contains_key(&(key, receiver, sender)) {
                return Err(format!("more than {MOST} different signals wait to be used"));
            }
            let kept = self.0.entry((key, receiver, sender)).or_default();
            *kept = kept.saturating_add(1);
        }
        Ok(())
    }

    /// Senders whose signal has not come.
    pub(super) fn missing(&self, channel: u16, wait: &Wait) -> Missing {
        let others = wait.parts.without(channel);
        let has = |sender: u16| self.0.contains_key(&(wait.key, channel, sender));
        if takes_any(wait) {
            return if has(ANYBODY) { Missing::default() } else { Missing::any(others) };
        }
        Missing::all(others.iter().filter(|&sender| !has(sender)).collect())
    }

    pub(super) fn depart(&mut self, channel: u16, wait: &Wait) {
        let any = takes_any(wait).then_some(ANYBODY);
        let named = wait.parts.without(channel).iter().filter(|_| !takes_any(wait));
        for sender in any.into_iter().chain(named) {
            let place = (wait.key, channel, sender);
            match self.0.get_mut(&place) {
                Some(kept) if *kept > 1 => *kept -= 1,
                _ => {
                    self.0.remove(&place);
                }
            }
        }
    }
}
