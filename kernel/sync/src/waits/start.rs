//! Starts by one side: a head lets the other one go on and does not wait itself.
//!
//! Invariant: each start ends one wait of the other head, in order of simulated time; one that comes early is kept. Facts:
//! reference channel-synchronisation.md 1.0 (names only, the reading is ours), 1.1 (signal).

use super::{Set, Spec, Style, Waiting, Waits, after};
use crate::tag::Tag;
use counterpoint_event::event::Primitive;

impl Spec {
    /// The wait of `heads` for a start by one of them.
    pub fn start(by: u16, heads: Set) -> Self {
        let (primitive, named, parts) = (Primitive::Signal, Set::default(), heads);
        Self { primitive, letter: 'S', number: u32::from(by), named, parts, style: Style::NoList }
    }
}

impl Waits {
    /// The head of this tag starts the other one: where that goes on, if it stands.
    pub fn start(&mut self, tag: Tag, heads: Set) -> Option<Tag> {
        let spec = Spec::start(tag.rank, heads);
        let standing = self.waiting.iter().flatten().find(|waiting| waiting.spec == spec).map(|w| w.tag.rank);
        match standing {
            Some(rank) => {
                self.leave(rank);
                let (t, micro) = after(tag.t, tag.micro, self.release_ns);
                Some(Tag { t, micro, rank })
            }
            None => {
                if let Some(kept) = self.starts.get_mut(self.ranks.index(tag.rank)) {
                    *kept = kept.saturating_add(1);
                }
                None
            }
        }
    }

    /// Uses up a start that a head has given already.
    pub fn started(&mut self, by: u16) -> bool {
        match self.starts.get_mut(self.ranks.index(by)) {
            Some(kept) if *kept > 0 => {
                *kept -= 1;
                true
            }
            _ => false,
        }
    }

    /// A channel stands until the other head starts it.
    pub fn stand(&mut self, waiting: Waiting) {
        if let Some(slot) = self.waiting.get_mut(self.ranks.index(waiting.tag.rank)) {
            *slot = Some(waiting);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranks::Ranks;

    fn start(by: u16) -> Spec {
        Spec::start(by, Set::up_to(2))
    }

    fn tag(rank: u16, t: i64) -> Tag {
        Tag { t, micro: 3, rank }
    }

    #[test]
    fn each_start_ends_one_wait() {
        let mut waits = Waits::new(Ranks::new(1..=2), 0);
        let stands = || Waiting { spec: start(1), tag: tag(2, 5), file: 0, line: 1 };
        assert_eq!(waits.start(tag(1, 1), Set::up_to(2)), None);
        assert!(waits.started(1) && !waits.started(1) && !waits.started(2) && !waits.started(9));
        waits.stand(stands());
        assert!(waits.missing(2) == Set::default().with(1) && waits.hopeful(2) && waits.dead() == Set::default());
        assert_eq!(waits.start(tag(2, 6), Set::up_to(2)), None, "a start of its own is not waited for");
        assert_eq!(waits.start(tag(1, 7), Set::up_to(2)), Some(Tag { t: 7, micro: 4, rank: 2 }));
        assert_eq!(waits.missing(2), Set::default());
    }

    #[test]
    fn a_wait_for_a_start_is_no_mismatch() {
        let barrier = Spec { primitive: Primitive::Barrier, ..start(1) };
        assert_eq!(barrier.mismatch(&Spec { letter: 'M', ..start(1) }), None);
        assert!(!barrier.matches(&start(1)));
        assert_eq!(start(2).text(), "START2");
    }
}
