//! The shared data that an access goes to.

use counterpoint_sync::races::RaceVariable;

/// The target of an access to shared data.
#[derive(Debug, Clone, Copy)]
pub enum SharedTarget<'n> {
    /// A numbered common variable.
    Common(u32),
    /// A variable with a name.
    Named(&'n str),
    /// A GLOBAL variable of macros, by index.
    Global(u32),
    /// A spindle; conflicts of its commands are reported by a rule of their own (`spindle-conflict`).
    Spindle,
    /// A file; lines of several channels in one file are an ordered log, so they are not judged.
    File,
}

impl SharedTarget<'_> {
    /// Whether it leads to this variable.
    pub fn leads_to(self, variable: &RaceVariable) -> bool {
        match (self, variable) {
            (Self::Named(name), RaceVariable::Named(known)) => *name == **known,
            (Self::Common(index), RaceVariable::Common(known)) | (Self::Global(index), RaceVariable::Global(known)) => {
                index == *known
            }
            _ => false,
        }
    }

    /// The variable of programs that it leads to.
    pub fn variable(self) -> Option<RaceVariable> {
        match self {
            Self::Common(index) => Some(RaceVariable::Common(index)),
            // Not a variable of programs: data of pre-processors about a definition, which the first definition makes
            // for all.
            Self::Named(name) if name.contains(' ') => None,
            Self::Named(name) => Some(RaceVariable::Named(name.into())),
            Self::Global(index) => Some(RaceVariable::Global(index)),
            Self::Spindle | Self::File => None,
        }
    }
}
