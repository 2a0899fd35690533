//! The reports of tools, and tools that a program calls by names that no table has.
//!
//! *Invariant:* a name keeps its number to the end of the run, whichever component of a composite machine reads it.

use counterpoint_event::event::ToolData;
use rustc_hash::FxHashMap;

/// Names and reports of tools.
#[derive(Debug, Default)]
pub struct ToolRecords {
    /// Tools that the program calls by names.
    pub called: NamedTools,
    /// The last report about each tool.
    pub reported: FxHashMap<u32, ToolData>,
}

/// Most names of each kind; the numbers of further names are not kept.
const MOST: usize = 1000;

/// Names of tools with numbers.
#[derive(Debug, Default)]
pub struct NamedTools {
    /// Names that got numbers, in their order.
    numbered: Vec<String>,
    /// Names by which tools were called, by number.
    names: Vec<(u32, String)>,
}

impl NamedTools {
    /// The number of a name; a new name gets the next one from `first` on, or none after `MOST` names.
    pub fn number(&mut self, name: &str, first: u32) -> Option<u32> {
        if let Some(number) = self.known(name, first) {
            return Some(number);
        }
        if self.numbered.len() >= MOST {
            return None;
        }
        self.numbered.push(name.to_owned());
        first.checked_add(self.numbered.len() as u32 - 1)
    }

    /// The number of a name that has got one.
    #[must_use]
    pub fn known(&self, name: &str, first: u32) -> Option<u32> {
        let at = self.numbered.iter().position(|known| known.eq_ignore_ascii_case(name))?;
        first.checked_add(at as u32)
    }

    /// A tool is called by a name.
    pub fn name(&mut self, number: u32, name: &str) {
        let has_room = self.names.len() < MOST;
        match self.names.iter_mut().find(|(known, _)| *known == number) {
            Some((_, known)) if known == name => {}
            Some((_, known)) => name.clone_into(known),
            None if has_room => self.names.push((number, name.to_owned())),
            None => {}
        }
    }

    /// The name by which a tool was called last.
    pub fn name_of(&self, number: u32) -> Option<&str> {
        self.names.iter().find(|(known, _)| *known == number).map(|(_, name)| name.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, NamedTools};

    #[test]
    fn names_beyond_the_most_share_no_number() {
        let mut called = NamedTools::default();
        for at in 0..MOST {
            assert_eq!(called.number(&format!("T{at}"), 501), Some(501 + at as u32));
        }
        assert_eq!(called.number("ANOTHER", 501), None);
        assert_eq!(called.number("t7", 501), Some(508));
        assert_eq!((called.known("t7", 501), called.known("ANOTHER", 501)), (Some(508), None));
    }
}
