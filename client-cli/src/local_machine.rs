//! A machine that this program reads itself: a shipped one, or a folder with the families beside it.
//!
//! *Invariant:* an unknown machine name is refused as in the other commands.

use std::path::Path;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::machine::package::{self, Overlay};
use counterpoint_kernel::machine::{Machine, WrittenDefinition, definition, load};

use crate::error::Error;
use crate::pack::PackedFiles;
use crate::{known, machine_folder, say};

/// The files of a machine.
pub(crate) struct LocalMachine {
    /// Name of its folder.
    pub(crate) name: String,
    pub(crate) files: Overlay<MemoryFiles, MemoryFiles>,
}

impl LocalMachine {
    /// A shipped machine by name, or a folder with `machine.toml`.
    pub(crate) fn open(machine: &str) -> Result<Self, Error> {
        let mut own = MemoryFiles::default();
        let name = if machine_folder::is_folder(machine) {
            let (name, PackedFiles(files)) = machine_folder::machine(Path::new(machine))?;
            for (path, blob) in files {
                own.insert(path, blob.content());
            }
            name
        } else {
            known::machine(machine, true)?;
            machine.to_owned()
        };
        Ok(Self { name, files: Overlay::over_shipped(own) })
    }

    /// A shipped machine.
    pub(crate) fn shipped(name: &str) -> Self {
        Self { name: name.to_owned(), files: Overlay::over_shipped(MemoryFiles::default()) }
    }

    /// The machine as the kernel uses it.
    pub(crate) fn load(&self) -> Result<Machine, Error> {
        let loaded = load(&self.files, &self.name);
        loaded.machine.ok_or_else(|| self.unusable(&loaded.findings))
    }

    /// The definition as written, including its families.
    pub(crate) fn definition(&self) -> Result<WrittenDefinition, Error> {
        definition(&self.files, &self.name).map_err(|findings| self.unusable(&findings))
    }

    /// The definition of the family that the machine extends; none if it extends none.
    pub(crate) fn family(&self, own: &WrittenDefinition) -> Result<Option<WrittenDefinition>, Error> {
        let Some(family) = own.chain.get(1) else { return Ok(None) };
        definition(&self.files, family).map(Some).map_err(|findings| self.unusable(&findings))
    }

    /// The definition in a folder beside the machine, or that of a shipped machine.
    pub(crate) fn beside(&self, folder: &str) -> Result<WrittenDefinition, Error> {
        definition(&self.files, folder).map_err(|findings| self.unusable(&findings))
    }

    fn unusable(&self, findings: &[Finding]) -> Error {
        findings.iter().for_each(|finding| say::status_line(format_args!("{finding}")));
        Error::Usage(format!("machine '{}' cannot be used", self.name))
    }
}

/// Every shipped machine with its name.
pub(crate) fn all_shipped() -> impl Iterator<Item = (String, Machine)> {
    package::shipped_names().into_iter().filter_map(|name| {
        let machine = LocalMachine::shipped(&name).load().ok()?;
        Some((name, machine))
    })
}
