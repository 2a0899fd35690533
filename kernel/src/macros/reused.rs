//! Values handed to macros again and again without allocating.
//!
//! Invariant: a value that somebody still holds is never changed. A macro's frame keeps what it got until its next call,
//! so of two values that take turns one is always free.

use std::sync::Arc;

/// Two values that take turns.
#[derive(Debug, Default)]
pub(crate) struct Reused<T> {
    next: Arc<T>,
    last: Arc<T>,
}

impl<T: Default> Reused<T> {
    /// Fills a free value and hands it out.
    pub(crate) fn with(&mut self, fill: impl FnOnce(&mut T)) -> Arc<T> {
        std::mem::swap(&mut self.next, &mut self.last);
        match Arc::get_mut(&mut self.last) {
            Some(free) => fill(free),
            None => {
                let mut fresh = T::default();
                fill(&mut fresh);
                self.last = Arc::new(fresh);
            }
        }
        Arc::clone(&self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::Reused;

    #[test]
    fn what_is_held_stays_as_it_is() {
        let mut reused: Reused<String> = Reused::default();
        let mut set = |text: &str| {
            reused.with(|s| {
                s.clear();
                s.push_str(text);
            })
        };
        let held: Vec<_> = ["a", "b", "c", "d"].map(&mut set).into();
        let texts: Vec<&str> = held.iter().map(|text| text.as_str()).collect();
        assert_eq!(texts, ["a", "b", "c", "d"]);
    }
}
