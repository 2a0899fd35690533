//! What the main program and each program it has called have of their own.
//!
//! *Invariant:* there is always a level: that of the main program remains when others return.

/// Values by level of calls.
#[derive(Debug, Clone, Default)]
pub struct Levels<T> {
    main: T,
    called: Vec<T>,
}

impl<T> Levels<T> {
    /// With those of the main program.
    pub fn new(main: T) -> Self {
        Self { main, called: Vec::new() }
    }

    /// A program is called.
    pub fn enter(&mut self, level: T) {
        self.called.push(level);
    }

    /// A program has returned; none if it is the main program.
    pub fn leave(&mut self) -> Option<T> {
        self.called.pop()
    }

    /// Of the program that runs.
    pub fn here(&self) -> &T {
        self.called.last().unwrap_or(&self.main)
    }

    /// The same, to be changed.
    pub fn here_mut(&mut self) -> &mut T {
        self.called.last_mut().unwrap_or(&mut self.main)
    }

    /// Of the called program that runs; none in the main program.
    pub fn called_mut(&mut self) -> Option<&mut T> {
        self.called.last_mut()
    }

    /// Programs that were called and run.
    pub fn depth(&self) -> usize {
        self.called.len()
    }

    /// All of them, that of the main program first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &T> {
        std::iter::once(&self.main).chain(&self.called)
    }
}

#[cfg(test)]
mod tests {
    use super::Levels;

    #[test]
    fn the_main_program_remains() {
        let mut levels = Levels::new(1);
        levels.enter(2);
        *levels.here_mut() += 1;
        assert_eq!((*levels.here(), levels.leave(), levels.leave()), (3, Some(3), None));
        assert_eq!(levels.called_mut(), None);
        assert_eq!((levels.depth(), *levels.here()), (0, 1));
    }
}
