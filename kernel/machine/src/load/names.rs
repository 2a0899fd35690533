//! Names that rows refer to: identifiers of codes and data, built in or custom, and registers.
//!
//! Invariant: a custom identifier exists only because a row says `custom = true` (or it is one of the two names that
//! mean "swallow"), so that a misspelt built-in name is always found. Facts: reference control-emulator.md 1.2, 1.3.

use crate::ident::{self, CodeId, DataId, Name};
use crate::index::{Id, IdTable, RegisterId};
use crate::rows::Register;
use crate::toml::check::FindingCollector;
use crate::toml::node::DefinitionPlace;
use crate::toml::section::TableReader;
use crate::toml::suggest::did_you_mean;

/// The code that swallows its word.
const CODE_IGNORE: &str = "CODE_IGNORE";

/// The data that swallows its word.
const REG_IGNORE: &str = "REG_IGNORE";

/// The names known so far.
pub(super) struct NameRegistry<'a> {
    pub(super) check: &'a FindingCollector,
    pub(super) registers: IdTable<RegisterId, Register>,
    pub(super) codes: IdTable<CodeId, Name>,
    pub(super) data: IdTable<DataId, Name>,
}

impl NameRegistry<'_> {
    /// Identifier of a code row (`id`, `custom`), and whether it means "swallow".
    pub(super) fn code_of_row(&mut self, row: &mut TableReader<'_>) -> Option<(CodeId, bool)> {
        let custom = row.flag("custom").unwrap_or(false);
        row.require("id", "an identifier, CODE_…");
        let name = row.text("id")?;
        if let Some(id) = ident::code(name) {
            if custom {
                row.error("custom", format!("{} is built in; `custom` is for names of your own", name.escape_debug()));
            }
            return Some((id, false));
        }
        let name = name.to_ascii_uppercase();
        if custom || name == CODE_IGNORE {
            let id = custom_id(&mut self.codes, row, &name, "CODE_")?;
            return Some((id, name == CODE_IGNORE));
        }
        let near = did_you_mean(&name, ident::codes::TABLE.iter().map(|facts| facts.name));
        let hint = "a name of your own needs `custom = true`";
        row.error("id", format!("unknown code identifier \"{}\"{near} ({hint})", name.escape_debug()));
        None
    }

    /// Identifier of a data row, likewise.
    pub(super) fn data_of_row(&mut self, row: &mut TableReader<'_>) -> Option<(DataId, bool)> {
        let custom = row.flag("custom").unwrap_or(false);
        row.require("id", "an identifier, REG_…");
        let name = row.text("id")?;
        if let Some(id) = ident::data(name) {
            if custom {
                row.error("custom", format!("{} is built in; `custom` is for names of your own", name.escape_debug()));
            }
            return Some((id, false));
        }
        let name = name.to_ascii_uppercase();
        if custom || name == REG_IGNORE {
            let id = custom_id(&mut self.data, row, &name, "REG_")?;
            return Some((id, name == REG_IGNORE));
        }
        let near = did_you_mean(&name, ident::data::TABLE.iter().map(|facts| facts.name));
        let hint = "a name of your own needs `custom = true`";
        row.error("id", format!("unknown data identifier \"{}\"{near} ({hint})", name.escape_debug()));
        None
    }

    /// A code named elsewhere than in its row.
    pub(super) fn code(&self, name: &str, place: &DefinitionPlace) -> Option<CodeId> {
        let upper = name.to_ascii_uppercase();
        let id = ident::code(name).or_else(|| self.codes.find(|known| *known == upper));
        if id.is_none() {
            let near = did_you_mean(name, self.codes.iter().map(AsRef::as_ref));
            self.check.error(place, format!("unknown code identifier \"{}\"{near}", name.escape_debug()));
        }
        id
    }

    /// A data identifier named elsewhere than in its row.
    pub(super) fn data(&self, name: &str, place: &DefinitionPlace) -> Option<DataId> {
        let upper = name.to_ascii_uppercase();
        let id = ident::data(name).or_else(|| self.data.find(|known| *known == upper));
        if id.is_none() {
            let near = did_you_mean(name, self.data.iter().map(AsRef::as_ref));
            self.check.error(place, format!("unknown data identifier \"{}\"{near}", name.escape_debug()));
        }
        id
    }

    /// A register by its first name.
    pub(super) fn register(&self, name: &str, place: &DefinitionPlace) -> Option<RegisterId> {
        let id = self.registers.find(|register| register.name == name);
        if id.is_none() {
            self.unknown_register(name, place);
        }
        id
    }

    /// Says that there is no such register.
    pub(super) fn unknown_register(&self, name: &str, place: &DefinitionPlace) {
        let name = name.escape_debug().to_string();
        let second = self.registers.iter().find(|register| register.second.as_deref() == Some(&name));
        let text = match second {
            Some(register) => format!("\"{name}\" is the second name of register {}; say \"{0}\"", register.name),
            None => {
                let near = did_you_mean(&name, self.registers.iter().map(|register| register.name.as_str()));
                format!("no register has the name \"{name}\"{near}")
            }
        };
        self.check.missing(place, text);
    }
}

/// Identifier of a custom name, new or known.
fn custom_id<I: Id>(names: &mut IdTable<I, Name>, row: &TableReader<'_>, name: &str, prefix: &str) -> Option<I> {
    let rest = name.strip_prefix(prefix).unwrap_or_default();
    let plain = rest.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if rest.is_empty() || !plain || name.len() > 64 {
        let expected = format!("{prefix} and up to {} letters, digits or _", 64 - prefix.len());
        row.error("id", format!("a custom name must be {expected}, not \"{}\"", name.escape_debug()));
        return None;
    }
    names.find(|known| known == name).or_else(|| names.push(name.to_owned().into()))
}
