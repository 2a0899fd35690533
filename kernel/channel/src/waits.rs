//! Waits that a channel has met.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use counterpoint_event::event::WaitArrival;
use counterpoint_sync::wait::{self, WaitRules};

/// Waits that a kernel has met, so that one met again costs nothing.
#[derive(Debug)]
pub struct KnownWaits {
    /// How the machine writes its waits.
    pub rules: WaitRules,
    known: FxHashMap<wait::Wait, Arc<WaitArrival>>,
    /// Whether the dependence of waits on the order of arrival has been reported.
    pub order_noted: bool,
}

impl KnownWaits {
    /// Beyond this many, all are forgotten.
    const MOST: usize = 1000;

    /// None so far.
    pub fn new(rules: WaitRules) -> Self {
        Self { rules, known: FxHashMap::default(), order_noted: false }
    }

    /// The wait as it is logged, made at its first arrival.
    pub fn wait(&mut self, wait: &wait::Wait) -> Arc<WaitArrival> {
        if let Some(known) = self.known.get(wait) {
            return known.clone();
        }
        if self.known.len() >= Self::MOST {
            self.known.clear();
        }
        let (key, participants) = (self.rules.text(wait).into(), wait.parts.iter().collect());
        let mark = self.rules.mark(wait).into();
        let acts = self.rules.acts(wait);
        let logged = Arc::new(WaitArrival { key, primitive: wait.primitive, participants, mark, acts });
        self.known.insert(*wait, logged.clone());
        logged
    }
}
