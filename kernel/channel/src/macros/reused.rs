//! Values handed to macros again and again without allocating.
//!
//! *Invariant:* a value that is still referenced is never changed. A macro's frame keeps its arguments until its next
//! call, so of two values that take turns one is always free.

use std::sync::Arc;

use counterpoint_lang::value::{Elements, MacroValue};

/// A pointer that several may hold, as texts and sequences have it.
pub trait SharedPointer: Clone + Default {
    /// Its target.
    type Content: Default;
    /// A pointer to new content.
    fn new(content: Self::Content) -> Self;
    /// The content, if this is its only reference.
    fn own(&mut self) -> Option<&mut Self::Content>;
}

impl SharedPointer for Arc<String> {
    type Content = String;
    fn new(content: String) -> Self {
        Arc::new(content)
    }
    fn own(&mut self) -> Option<&mut String> {
        Arc::get_mut(self)
    }
}

impl SharedPointer for Elements {
    type Content = Vec<MacroValue>;
    fn new(content: Vec<MacroValue>) -> Self {
        Elements::new(content)
    }
    fn own(&mut self) -> Option<&mut Vec<MacroValue>> {
        Elements::get_mut(self)
    }
}

/// Two values that take turns.
#[derive(Debug, Default)]
pub struct Reused<P> {
    next: P,
    last: P,
}

impl<P: SharedPointer> Reused<P> {
    /// Fills a free value and hands it out.
    pub fn with(&mut self, fill: impl FnOnce(&mut P::Content)) -> P {
        std::mem::swap(&mut self.next, &mut self.last);
        match self.last.own() {
            Some(free) => fill(free),
            None => {
                let mut fresh = P::Content::default();
                fill(&mut fresh);
                self.last = P::new(fresh);
            }
        }
        self.last.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::Reused;

    #[test]
    fn what_is_held_stays_as_it_is() {
        let mut reused: Reused<Arc<String>> = Reused::default();
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
