//! Loops whose ends carry a number: the start that belongs to each end.
//!
//! *Invariant:* the innermost open loop with the number of an end belongs to it, those inside are over; each start is
//! looked at once.

/// Loops that have begun, by number.
#[derive(Debug)]
pub struct OpenLoops<P> {
    open: Vec<(u8, P)>,
    /// Number of open loops with each number; numbers without one are not searched for.
    waiting: [u32; 256],
}

impl<P> Default for OpenLoops<P> {
    fn default() -> Self {
        Self { open: Vec::new(), waiting: [0; 256] }
    }
}

impl<P> OpenLoops<P> {
    /// A loop begins at a place.
    pub fn begin(&mut self, number: u8, place: P) {
        self.open.push((number, place));
        if let Some(count) = self.waiting.get_mut(usize::from(number)) {
            *count += 1;
        }
    }

    /// The place where the loop begins that ends here; none if no loop with this number is open.
    pub fn end(&mut self, number: u8) -> Option<P> {
        self.waiting.get(usize::from(number)).filter(|count| **count > 0)?;
        while let Some((other, place)) = self.open.pop() {
            if let Some(count) = self.waiting.get_mut(usize::from(other)) {
                *count -= 1;
            }
            if other == number {
                return Some(place);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::OpenLoops;

    #[test]
    fn an_end_has_the_innermost_begin_of_its_number() {
        let mut loops = OpenLoops::default();
        for (number, place) in [(1, 'a'), (2, 'b'), (1, 'c'), (3, 'd')] {
            loops.begin(number, place);
        }
        assert_eq!(loops.end(4), None);
        assert_eq!(loops.end(1), Some('c'));
        assert_eq!(loops.end(3), None, "it was inside of the loop that has ended");
        assert_eq!((loops.end(2), loops.end(1), loops.end(1)), (Some('b'), Some('a'), None));
    }
}
