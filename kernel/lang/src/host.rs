//! Requests of a macro to the outside, at compile time and at run time.
//!
//! *Invariant:* the language reaches the outside only through these traits; calls carry indices of tables given once,
//! never names. The requests of a running macro are one trait for each concern: [`Variables`], [`Blocks`], [`Files`],
//! [`Dialog`].

mod blocks;
mod dialog;
mod files;
mod folder;
mod functions;
mod variables;

pub use blocks::{Blocks, Command};
pub use dialog::{Dialog, Macro, Step};
pub use files::Files;
pub use folder::{FAILED, FORBIDDEN, Facts, Folder, INVALID, NOT_FOUND, Shelf, stored};
pub use functions::{AbsentFn, FileFn, HostFn, Need};
pub use variables::Variables;

pub(crate) use functions::ROWS;

use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::source::Source;
use crate::state::State;
use crate::value::{Kind, Value};

/// A system variable of the host's table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SystemVariable {
    /// Name with its dollar sign, upper case.
    pub name: String,
    /// Type, none if it may vary.
    pub kind: Option<Kind>,
    /// May be assigned.
    pub writable: bool,
    /// Number of indices it takes; 0 for a single value.
    pub indices: u8,
}

/// The external facts for the compiler.
pub trait Environment {
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
    fn include(&mut self, name: &str, from: &str) -> Option<Source>;
}

/// `$FMACSTA`: numbers of macros with their states before the change. `switch` gives the state of a macro before it is
/// switched, none for an unknown number.
pub fn macro_states(arguments: &[Value], mut switch: impl FnMut(f64, Option<bool>) -> Option<bool>) -> Value {
    let single;
    let numbers = match arguments.first() {
        Some(Value::Sequence(all)) => all.as_slice(),
        Some(one) => {
            single = [one.clone()];
            &single
        }
        None => &[],
    };
    let on = arguments.get(1).and_then(Value::as_logical);
    let mut states = Vec::new();
    for number in numbers.iter().filter(|value| matches!(value, Value::Real(_))).filter_map(Value::as_real) {
        if let Some(before) = switch(number, on) {
            states.extend([Value::Real(number), Value::Logical(before)]);
        }
    }
    Value::sequence(states)
}

/// The requests of a running macro to the outside.
pub trait Host: Variables + Blocks + Files + Dialog {
    /// Computes a function that needs a control.
    ///
    /// # Errors
    /// The function is not available here, or its arguments are impossible.
    fn function(&mut self, state: &mut State, function: HostFn, arguments: &[Value]) -> Outcome<Value> {
        let _ = (state, arguments);
        Err(Fault::new(Number::NO_HOST, format!("{} needs a machine, and there is none here", function.name())))
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
