//! Everything compiled so far, and under which rules.
//!
//! *Invariant:* an index of a macro, of a function or of a variable keeps its meaning when sources are added.

use crate::bytecode::{CompiledMacro, SharedVariable};
use crate::source::MacroSource;
use crate::value::ValueType;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Which names must be declared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeclarationStrictness {
    /// None.
    #[default]
    Off,
    /// GLOBAL and OBJECT in the declaration macro only.
    Partial,
    /// Locals too.
    Full,
}

/// Where a macro will run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MacroRole {
    /// Where every command is possible, but under strong declaration nothing shared is declared.
    #[default]
    Any,
    /// File of functions and declarations that goes with the declaration macro: everything is possible.
    Library,
    /// Declaration macro.
    Declaration,
    /// Data macro: no OUTPUT.
    Data,
    /// Startup or shutdown macro: no OUTPUT.
    Startup,
}

/// How to compile.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompileOptions {
    /// Strong declaration.
    pub strong: DeclarationStrictness,
    /// Warn of variables that are read and never assigned.
    pub uninitialised: bool,
    /// Put trace instructions into the code.
    pub trace: bool,
    /// Kind of macro.
    pub place: MacroRole,
    /// Declared GLOBAL variables belong to the object, because the macros are those of a component.
    pub globals_are_objects: bool,
}

/// A user function as its callers see it.
#[derive(Clone, Debug)]
pub(crate) struct FunctionSymbol {
    pub(crate) index: u16,
    pub(crate) parameters: Vec<Option<ValueType>>,
    pub(crate) result: Option<ValueType>,
}

/// A shared variable as its users see it.
#[derive(Clone, Debug)]
pub(crate) struct SharedSymbol {
    pub(crate) shared: SharedVariable,
    pub(crate) kind: Option<ValueType>,
    pub(crate) indices: usize,
    pub(crate) channel: bool,
}

/// Everything compiled so far; grows when sources are added.
#[derive(Clone, Debug, Default)]
pub struct MacroProgram {
    /// Code by index; empty for macros with errors.
    pub macros: Vec<Arc<CompiledMacro>>,
    /// Number of variables in the object's store.
    pub objects: u32,
    /// Names of the global variables by index; the first hundred are `%G00` to `%G99`.
    pub globals: Vec<String>,
    pub(crate) functions: FxHashMap<String, FunctionSymbol>,
    pub(crate) shared: FxHashMap<String, SharedSymbol>,
    /// Files that were included, by the requested name.
    pub(crate) included: Vec<(String, Option<Arc<MacroSource>>)>,
    /// Its source files, in order, without included files.
    pub(crate) sources: Vec<(Arc<MacroSource>, CompileOptions)>,
}

impl MacroProgram {
    /// A program without macros.
    #[must_use]
    pub fn new() -> MacroProgram {
        MacroProgram { globals: (0..100).map(|number| format!("%G{number:02}")).collect(), ..MacroProgram::default() }
    }

    /// Name of a variable of the object's store.
    #[must_use]
    pub fn object_name(&self, index: u32) -> &str {
        let named = |symbol: &SharedSymbol| symbol.shared == SharedVariable::Object(index);
        self.shared.iter().find(|(_, symbol)| named(symbol)).map_or("", |(name, _)| name)
    }

    /// Index of a user function.
    #[must_use]
    pub fn function(&self, name: &str) -> Option<u16> {
        self.functions.get(name).map(|symbol| symbol.index)
    }

    /// A single GLOBAL or OBJECT variable that was declared, with its type.
    #[must_use]
    pub fn shared_variable(&self, name: &str) -> Option<(SharedVariable, Option<ValueType>)> {
        let symbol = self.shared.get(name).filter(|symbol| symbol.indices == 0 && !symbol.channel)?;
        Some((symbol.shared, symbol.kind))
    }

    /// User functions with their indices, by name.
    #[must_use]
    pub fn functions(&self) -> Vec<(&str, u16)> {
        let mut list: Vec<_> = self.functions.iter().map(|(name, symbol)| (name.as_str(), symbol.index)).collect();
        list.sort_unstable();
        list
    }
}
