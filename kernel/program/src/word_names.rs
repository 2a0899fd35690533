//! Names of the machine's words and codes, found without a search through all rows.
//!
//! *Invariant:* a name finds the row that comes first in the tables of the machine; letter case is ignored.

use counterpoint_machine::Machine;
use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_machine::rows::CodeForm;
use rustc_hash::{FxHashMap, FxHashSet};

/// Longest name that is converted to lower case without an allocation.
const SHORT: usize = 32;

/// The names of a machine, in lower case.
#[derive(Debug, Default)]
pub struct WordNames {
    /// Texts before numbers, without a final `=`: the register, and whether this is the incremental form.
    registers: FxHashMap<Box<[u8]>, (RegisterId, bool)>,
    /// Names of registers, and texts before their numbers.
    spelled: FxHashSet<Box<[u8]>>,
    /// Literal texts of codes.
    texts: FxHashMap<Box<[u8]>, CodeRowId>,
}

impl WordNames {
    /// The names of a machine.
    pub fn new(machine: &Machine) -> Self {
        let mut names = Self::default();
        let small = |text: &str| text.to_ascii_lowercase().into_bytes().into_boxed_slice();
        for (id, register) in machine.registers.entries() {
            let forms = [(register.second.as_deref(), true), (Some(register.before.as_str()), false)];
            for (text, incremental) in forms.into_iter().filter_map(|(text, incremental)| Some((text?, incremental))) {
                names.spelled.insert(small(text));
                let bare = text.strip_suffix('=').unwrap_or(text);
                names.registers.entry(small(bare)).or_insert((id, incremental));
            }
            names.spelled.insert(small(&register.name));
        }
        for &row in &machine.tables.texts {
            if let CodeForm::Text(text) = &machine.codes[row].form {
                names.texts.entry(small(text)).or_insert(row);
            }
        }
        names
    }

    /// Register of a name, with or without a final `=`, and whether the name is its incremental form.
    pub fn register(&self, name: &str) -> Option<(RegisterId, bool)> {
        in_small_letters(name, |name| self.registers.get(name).copied())
    }

    /// Whether words may begin with this text.
    pub fn is_register(&self, name: &str) -> bool {
        in_small_letters(name, |name| self.spelled.contains(name))
    }

    /// Whether a literal text begins with this text.
    pub fn begins_text(&self, text: &str) -> bool {
        in_small_letters(text, |text| self.texts.keys().any(|known| known.starts_with(text)))
    }

    /// Whether the rest of a literal text, or of the text before the numbers of a register, after this text is `wanted`.
    pub fn continues(&self, text: &str, wanted: impl Fn(&[u8]) -> bool) -> bool {
        let is_wanted = |name: &[u8], text: &[u8]| name.strip_prefix(text).is_some_and(&wanted);
        in_small_letters(text, |text| {
            self.texts.keys().any(|name| is_wanted(name, text)) || self.spelled.iter().any(|name| is_wanted(name, text))
        })
    }

    /// Row of a literal text.
    pub fn text(&self, text: &str) -> Option<CodeRowId> {
        in_small_letters(text, |text| self.texts.get(text).copied())
    }
}

fn in_small_letters<R>(name: &str, look: impl FnOnce(&[u8]) -> R) -> R {
    let mut buffer = [0; SHORT];
    match buffer.get_mut(..name.len()) {
        Some(small) => {
            small.copy_from_slice(name.as_bytes());
            small.make_ascii_lowercase();
            look(small)
        }
        None => look(name.to_ascii_lowercase().as_bytes()),
    }
}
