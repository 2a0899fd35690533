//! Names of codes and data.

use std::cell::RefCell;

/// Gives the name of the tables for one that may be spelled otherwise.
pub type Spelling = fn(&str) -> Option<&'static str>;

/// The identifiers that exist: those of a list, or any that are requested.
#[derive(Debug, Default)]
pub(crate) struct Identifiers {
    names: RefCell<Vec<String>>,
    spelling: Option<Spelling>,
}

impl Identifiers {
    pub(crate) fn only(&mut self, names: impl IntoIterator<Item = String>, spelling: Spelling) {
        self.spelling = Some(spelling);
        self.names.borrow_mut().extend(names);
    }

    pub(crate) fn all(&self) -> Vec<String> {
        self.names.borrow().clone()
    }

    /// Index of a name, which is added if it is new.
    pub(crate) fn index(&self, name: &str) -> u32 {
        let mut all = self.names.borrow_mut();
        let at = all.iter().position(|other| other == name).unwrap_or_else(|| {
            all.push(name.to_owned());
            all.len() - 1
        });
        u32::try_from(at + 1).unwrap_or(0)
    }

    pub(crate) fn find(&self, name: &str) -> Option<u32> {
        let Some(spelling) = self.spelling else { return Some(self.index(name)) };
        let name = spelling(name)?;
        let at = self.names.borrow().iter().position(|other| other == name)?;
        u32::try_from(at + 1).ok()
    }

    pub(crate) fn name(&self, index: u32, none: &str) -> String {
        let at = (index as usize).checked_sub(1);
        at.and_then(|at| self.names.borrow().get(at).cloned()).unwrap_or_else(|| none.to_owned())
    }
}
