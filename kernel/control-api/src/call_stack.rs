//! The programs that run: the main program, those it has called, and parts of programs that are called.
//!
//! A called program has variables of its own; a part of a program, as a label of Heidenhain or a repetition of Siemens,
//! uses those of its program. *Invariant:* the level of the main program remains when others return.

/// Levels that were set aside.
#[derive(Debug, Clone)]
pub struct Aside<T>(Vec<CallStackEntry<T>>);

/// Local data of each running program and part.
#[derive(Debug, Clone, Default)]
pub struct CallStack<T> {
    main: T,
    called: Vec<CallStackEntry<T>>,
}

#[derive(Debug, Clone)]
struct CallStackEntry<T> {
    level: T,
    /// A part of the program below it.
    part: bool,
}

impl<T> CallStack<T> {
    /// With the level of the main program.
    pub fn new(main: T) -> Self {
        Self { main, called: Vec::new() }
    }

    /// A program is called.
    pub fn enter(&mut self, level: T) {
        self.called.push(CallStackEntry { level, part: false });
    }

    /// A part of the program that runs is called.
    pub fn enter_part(&mut self, level: T) {
        self.called.push(CallStackEntry { level, part: true });
    }

    /// The innermost programs and parts are as if they did not run: a part of one that has called them is called next.
    pub fn set_aside(&mut self, count: usize) -> Aside<T> {
        Aside(self.called.split_off(self.called.len().saturating_sub(count)))
    }

    /// Restores programs that were set aside, above those that run now.
    pub fn bring_back(&mut self, aside: Aside<T>) {
        self.called.extend(aside.0);
    }

    /// A program or part has returned; none if it is the main program.
    pub fn leave(&mut self) -> Option<T> {
        self.called.pop().map(|called| called.level)
    }

    /// Level of the program or part that runs.
    #[inline]
    pub fn here(&self) -> &T {
        self.called.last().map_or(&self.main, |called| &called.level)
    }

    /// The same, to be changed.
    #[inline]
    pub fn here_mut(&mut self) -> &mut T {
        self.called.last_mut().map_or(&mut self.main, |called| &mut called.level)
    }

    /// Level of the called program or part that runs; none in the main program.
    pub fn called_mut(&mut self) -> Option<&mut T> {
        self.called.last_mut().map(|called| &mut called.level)
    }

    /// Whether a part of a program runs.
    pub fn in_part(&self) -> bool {
        self.called.last().is_some_and(|called| called.part)
    }

    /// Programs and parts that were called and run.
    pub fn depth(&self) -> usize {
        self.called.len()
    }

    /// Depth of the running program, regardless of its part.
    pub fn program_depth(&self) -> usize {
        self.called.iter().rposition(|called| !called.part).map_or(0, |at| at + 1)
    }

    /// Level of the running program.
    pub fn program(&self) -> &T {
        self.at(self.program_depth()).unwrap_or(&self.main)
    }

    /// The same, to be changed.
    pub fn program_mut(&mut self) -> &mut T {
        let depth = self.program_depth();
        let called = depth.checked_sub(1).and_then(|at| self.called.get_mut(at));
        called.map_or(&mut self.main, |called| &mut called.level)
    }

    /// Level by depth, 0 for the main program.
    pub fn at(&self, depth: usize) -> Option<&T> {
        match depth.checked_sub(1) {
            Some(at) => self.called.get(at).map(|called| &called.level),
            None => Some(&self.main),
        }
    }

    /// The same, to be changed.
    pub fn at_mut(&mut self, depth: usize) -> Option<&mut T> {
        match depth.checked_sub(1) {
            Some(at) => self.called.get_mut(at).map(|called| &mut called.level),
            None => Some(&mut self.main),
        }
    }

    /// All levels, that of the main program first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &T> {
        std::iter::once(&self.main).chain(self.called.iter().map(|called| &called.level))
    }
}

#[cfg(test)]
mod tests {
    use super::CallStack;

    #[test]
    fn the_main_program_remains() {
        let mut calls = CallStack::new(1);
        calls.enter(2);
        *calls.here_mut() += 1;
        assert_eq!((*calls.here(), calls.leave(), calls.leave()), (3, Some(3), None));
        assert_eq!(calls.called_mut(), None);
        assert_eq!((calls.depth(), *calls.here()), (0, 1));
    }

    #[test]
    fn levels_are_set_aside() {
        let mut calls = CallStack::new('m');
        calls.enter('a');
        calls.enter('b');
        let aside = calls.set_aside(1);
        calls.enter_part('p');
        assert_eq!((*calls.program(), calls.leave()), ('a', Some('p')));
        calls.bring_back(aside);
        assert_eq!(calls.iter().collect::<String>(), "mab");
    }

    #[test]
    fn a_part_uses_the_level_of_its_program() {
        let mut calls = CallStack::new('m');
        calls.enter_part('r');
        assert_eq!((*calls.program(), *calls.here(), calls.in_part()), ('m', 'r', true));
        calls.enter('s');
        calls.enter_part('t');
        calls.enter_part('u');
        assert_eq!((*calls.program(), calls.program_depth(), calls.depth()), ('s', 2, 4));
        *calls.program_mut() = 'S';
        assert_eq!((calls.at(0), calls.at(2), calls.at(5)), (Some(&'m'), Some(&'S'), None));
        assert_eq!(calls.iter().collect::<String>(), "mrStu");
    }
}
