//! Requests of a macro to the outside, at compile time and at run time.
//!
//! *Invariant:* the language reaches the outside only through these traits; calls carry indices of tables given once,
//! never names. The requests of a running macro are one trait for each concern: [`VariableHost`], [`CommandHost`], [`FileHost`],
//! [`ConsoleHost`].

mod blocks;
mod dialog;
mod files;
mod folder;
mod functions;
mod variables;

pub use blocks::{CommandHost, HostCommand};
pub use dialog::{ConsoleHost, TraceStep, TracedMacro};
pub use files::FileHost;
pub use folder::{FAILED, FORBIDDEN, FileFacts, INVALID, MacroFolder, NOT_FOUND, Shelf, stored};
pub use functions::{AbsentFn, FileFn, HostFn, Need};
pub use variables::VariableHost;

pub(crate) use functions::ROWS;

use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::source::MacroSource;
use crate::state::MacroState;
use crate::value::{MacroValue, ValueType};

/// A system variable of the host's table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SystemVariable {
    /// Name with its dollar sign, upper case.
    pub name: String,
    /// Type, none if it may vary.
    pub kind: Option<ValueType>,
    /// May be assigned.
    pub writable: bool,
    /// Number of indices it takes; 0 for a single value.
    pub indices: u8,
}

/// The external facts for the compiler.
pub trait CompileEnvironment {
    /// The system variables; the position is the index used at run time.
    fn system(&self) -> &[SystemVariable];
    /// Index of a code identifier, 0 for `CODE_NONE`.
    fn code(&self, name: &str) -> Option<u32>;
    /// Index of a data identifier, 0 for `REG_NONE`.
    fn register(&self, name: &str) -> Option<u32>;
    /// All code and data identifiers, for near misses.
    fn identifiers(&self) -> Vec<String>;
    /// Product that has a system variable of this name when the control has none.
    fn foreign(&self, name: &str) -> Option<&'static str> {
        let _ = name;
        None
    }
    /// Text of a file of functions named by a file.
    fn include(&mut self, name: &str, from: &str) -> Option<MacroSource>;
}

/// `$FMACSTA`: numbers of macros with their states before the change. `switch` gives the state of a macro before it is
/// switched, none for an unknown number.
pub fn macro_states(arguments: &[MacroValue], mut switch: impl FnMut(f64, Option<bool>) -> Option<bool>) -> MacroValue {
    let single;
    let numbers = match arguments.first() {
        Some(MacroValue::Sequence(all)) => all.as_slice(),
        Some(one) => {
            single = [one.clone()];
            &single
        }
        None => &[],
    };
    let on = arguments.get(1).and_then(MacroValue::as_logical);
    let mut states = Vec::new();
    for number in numbers.iter().filter(|value| matches!(value, MacroValue::Real(_))).filter_map(MacroValue::as_real) {
        if let Some(before) = switch(number, on) {
            states.extend([MacroValue::Real(number), MacroValue::Logical(before)]);
        }
    }
    MacroValue::sequence(states)
}

/// The requests of a running macro to the outside.
pub trait MacroHost: VariableHost + CommandHost + FileHost + ConsoleHost {
    /// Computes a function that needs a control.
    ///
    /// # Errors
    /// The function is not available here, or its arguments are impossible.
    fn function(&mut self, state: &mut MacroState, function: HostFn, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let _ = (state, arguments);
        Err(MacroFault::new(
            DiagnosticNumber::NO_HOST,
            format!("{} needs a machine, and there is none here", function.name()),
        ))
    }

    /// Whether the run is to end; asked now and then while macros run.
    fn stopped(&self) -> bool {
        false
    }

    /// Now, in seconds since 1970-01-01 00:00 and the offset of the local zone in seconds with its name.
    fn now(&self) -> (f64, i32, String) {
        (0.0, 0, "UTC".to_owned())
    }

    /// Value of an environment variable or of a `block.symbol` of the definition file.
    fn setting(&self, definition: bool, name: &str) -> Option<String> {
        let _ = (definition, name);
        None
    }
}
