//! Waits that a channel has met.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use counterpoint_event::event::Wait;
use counterpoint_sync::waits::Spec;

/// Waits that a kernel has met, so that one met again costs nothing.
#[derive(Debug, Default)]
pub(crate) struct KnownWaits(FxHashMap<Spec, Arc<Wait>>);

impl KnownWaits {
    /// Beyond this many, all are forgotten.
    const MOST: usize = 1000;

    /// The wait of a specification, made at its first arrival.
    pub(crate) fn wait(&mut self, spec: &Spec) -> Arc<Wait> {
        if let Some(wait) = self.0.get(spec) {
            return wait.clone();
        }
        if self.0.len() >= Self::MOST {
            self.0.clear();
        }
        let (key, mark, participants) = (spec.text().into(), spec.mark().into(), spec.parts.iter().collect());
        let wait = Arc::new(Wait { key, primitive: spec.primitive, participants, mark });
        self.0.insert(spec.clone(), wait.clone());
        wait
    }
}
