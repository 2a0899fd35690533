//! The facts of a machine for the compiler of macros: variables, identifiers with the machine's own, files to include.
//!
//! Invariant: the number of an identifier is its place in the machine's tables plus one, built-in names first; a named
//! file never lies outside the machines folder and the files stored with the machine.

use std::sync::OnceLock;

use counterpoint_lang::host::{CompileEnvironment, SystemVariable};
use counterpoint_lang::source::MacroSource;

use super::{identifiers, system};
use crate::ident::{CodeId, DataId, Name};
use crate::index::IdTable;
use crate::stored::StoredFile;
use counterpoint_ports::files::JobFiles;

/// The facts of one machine for the compiler.
pub struct MachineEnvironment<'a> {
    /// Names of all codes.
    pub codes: &'a IdTable<CodeId, Name>,
    /// Names of all data.
    pub data: &'a IdTable<DataId, Name>,
    /// Files that may be included, none while a program runs.
    pub files: Option<&'a dyn JobFiles>,
    /// Files stored with the machine, which may be included as `//ICAMFS/…`.
    pub stored: &'a [StoredFile],
}

fn symbols() -> &'static [SystemVariable] {
    static SYMBOLS: OnceLock<Vec<SystemVariable>> = OnceLock::new();
    SYMBOLS.get_or_init(|| system::table().iter().map(system::ControlVariable::symbol).collect())
}

fn own(names: &[Name], name: &str) -> Option<u32> {
    let at = names.iter().position(|own| own == name)?;
    u32::try_from(at + 1).ok()
}

impl CompileEnvironment for MachineEnvironment<'_> {
    fn system(&self) -> &[SystemVariable] {
        symbols()
    }

    fn code(&self, name: &str) -> Option<u32> {
        identifiers::code(name).or_else(|| own(self.codes.as_slice(), name))
    }

    fn register(&self, name: &str) -> Option<u32> {
        identifiers::register(name).or_else(|| own(self.data.as_slice(), name))
    }

    fn identifiers(&self) -> Vec<String> {
        self.codes.iter().chain(self.data).map(ToString::to_string).collect()
    }

    fn foreign(&self, name: &str) -> Option<&'static str> {
        system::product_of(name)
    }

    fn include(&mut self, name: &str, from: &str) -> Option<MacroSource> {
        if name.get(..StoredFile::ROOT.len()).is_some_and(|root| root.eq_ignore_ascii_case(StoredFile::ROOT)) {
            let bytes = StoredFile::find(self.stored, name)?;
            return Some(MacroSource::from_bytes(name, bytes));
        }
        let path = beside(from, name)?;
        let bytes = self.files?.read(&path).ok()?;
        Some(MacroSource::from_bytes(path, &bytes))
    }
}

/// Path of a file named by another one, both relative to the machines folder; none if it leads anywhere else.
#[must_use]
pub fn beside(from: &str, name: &str) -> Option<String> {
    let parts = || name.split('/');
    if name.contains(['\\', ':', '\0']) || parts().any(|part| part.is_empty() || part == ".." || part == ".") {
        return None;
    }
    let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
    Some(if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") })
}

#[cfg(test)]
mod tests {
    use super::beside;

    #[test]
    fn files_stay_in_their_folder() {
        assert_eq!(beside("mill/machine.toml", "m/a.mac").as_deref(), Some("mill/m/a.mac"));
        for name in ["../x", "/etc/passwd", "a/../../b", "", "a//b", "c:\\x", "./a", "a\\b"] {
            assert_eq!(beside("mill/machine.toml", name), None, "{name}");
        }
    }
}
