//! Machine definitions: the behaviour of a control, as data.
//!
//! Facts: reference control-emulator.md 1 and channel-synchronisation.md 1; the file form is this project's own
//! and documented in docs/machine-definition.md. Invariant: a [`Machine`] that exists has been checked; the block
//! loop never meets a contradiction in it.

mod diagnostics;
pub mod finding;
pub mod habits;
pub mod ident;
pub mod index;
pub mod length_units;
mod load;
pub mod macros;
pub mod model;
pub mod number;
pub mod package;
pub mod preprocessor;
pub mod refusals;
pub mod rows;
pub mod show;
pub mod stored;
pub mod system_variables;
pub mod tables;
mod toml;

pub use counterpoint_signs as signs;
pub use load::{
    DefinedComponent, DefinitionKey, DefinitionRow, Loaded, WrittenDefinition, candidates, definition,
    is_section_of_composites, load, without_key,
};
pub use model::Machine;
pub use toml::suggest::similar;
