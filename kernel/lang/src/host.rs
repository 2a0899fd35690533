//! What a macro asks the outside, at compile time and at run time.
//!
//! Invariant: the language reaches nothing but through these traits; calls carry indices of tables given once, never
//! names. [`Test`] is the double used by tests and by `macro run`.

mod double;
mod folder;
mod functions;

pub use double::{Answer, Domain, Outside, Stream, Test};
pub use folder::{FAILED, FORBIDDEN, Facts, Folder, INVALID, NOT_FOUND, Shelf, stored};
pub use functions::HostFn;
pub(crate) use functions::ROWS;

use crate::diag::{Diagnostic, Number};
use crate::fault::{Fault, Outcome};
use crate::format::Registers;
use crate::source::Source;
use crate::state::{Scale, State};
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

/// What the compiler must know of the outside.
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

/// A command for the host.
#[derive(Debug)]
pub enum Command<'a> {
    /// MATCH/ON, OFF
    Match(bool),
    /// OUTPUT, with the arguments of the macro as they are now: number and value.
    Output(&'a [(u8, Value)]),
    /// EXEC of a block; the flag is NOW.
    ExecBlock(bool, &'a str),
    /// EXEC of identifiers and values; the flag is NOW.
    ExecItems(bool, &'a [Value]),
    /// TAPERD
    TapeRead,
    /// TAPEWT
    TapeWrite,
    /// SEARCH
    Search(i64),
    /// SAVMODAL
    SaveModal,
    /// RSTMODAL
    RestoreModal,
    /// LPRINT/ON, OFF
    Listing(bool),
    /// LPRINT/n
    Skip(i64),
    /// PPRINT
    Print(&'a str),
    /// SYSTEM; the answer is the status
    System(&'a str),
}

/// A macro as the trace names it.
#[derive(Clone, Copy, Debug)]
pub struct Macro<'a> {
    /// Its name.
    pub name: &'a str,
    /// It is a user function.
    pub is_function: bool,
}

/// A step of the macro trace. Its text is the line in the documented layout, without what only a control knows.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// A macro begins.
    Entering(Macro<'a>),
    /// A statement is about to be executed, in standard style.
    Statement(Macro<'a>, &'a str),
    /// A macro is left; the name of the one that goes on, none for the outermost.
    Leaving(Macro<'a>, Option<&'a str>),
}

impl std::fmt::Display for Step<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Step::Entering(code) => write!(f, " Macro:* Entering {}", code.name),
            Step::Statement(_, text) => write!(f, " Macro:  {text}"),
            Step::Leaving(code, outer) => {
                write!(f, " Macro:* Leaving {}, Returning to {}", code.name, outer.unwrap_or("regular processing"))
            }
        }
    }
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

/// What a running macro asks of the outside.
pub trait Host: Registers {
    /// Reads a system variable.
    ///
    /// # Errors
    /// The variable is not available here, or an index is out of range.
    fn read_system(&mut self, index: u32, indices: &[i64]) -> Outcome<Value>;

    /// Writes a system variable.
    ///
    /// # Errors
    /// The variable is not available here, or the value is out of its range.
    fn write_system(&mut self, index: u32, indices: &[i64], value: Value) -> Outcome<()>;

    /// Lets `access` read or change a global variable, which grows by so many bytes at most.
    fn global(&mut self, index: u32, growth: usize, access: &mut dyn FnMut(&mut Value));

    /// Adds what the host keeps of the values of macros.
    fn held(&self, scale: &mut Scale) {
        let _ = scale;
    }

    /// The run is to end; asked now and then while macros run.
    fn stopped(&self) -> bool {
        false
    }

    /// Place of a global variable that nobody else reaches while this macro runs; none if there may be others, who are
    /// kept away by [`global`](Self::global). Between two calls of the host it is always the same place.
    fn own_global(&mut self, index: u32) -> Option<&mut Value> {
        let _ = index;
        None
    }

    /// Carries out a command; the answer is a status for `$ERRNO`.
    ///
    /// # Errors
    /// The command is not available here, or failed.
    fn command(&mut self, state: &mut State, command: Command<'_>) -> Outcome<i32>;

    /// Computes a function that needs a control.
    ///
    /// # Errors
    /// The function is not available here, or its arguments are impossible.
    fn function(&mut self, state: &mut State, function: HostFn, arguments: &[Value]) -> Outcome<Value> {
        let _ = (state, arguments);
        Err(Fault::new(Number::NO_HOST, format!("{} needs a machine, and there is none here", function.name())))
    }

    /// Reports a diagnostic of a running macro.
    /// The state is that of the running macro, so that a host may run another one first.
    fn report(&mut self, state: &mut State, diagnostic: Diagnostic);

    /// Severity and text of a diagnostic of the host's tables, for `ERROR/number`.
    fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        let _ = number;
        None
    }

    /// Takes one step of the macro trace.
    fn trace(&mut self, step: Step<'_>);

    /// Tells whether a macro may open a file of this name: 0, else the status for `$ERRNO`.
    fn may_open(&mut self, state: &mut State, path: &str) -> i32 {
        let _ = (state, path);
        0
    }

    /// Tells whether a file of this name could be written: 0, else the status for `$ERRNO`.
    fn may_write(&mut self, path: &str) -> i32 {
        let _ = path;
        0
    }

    /// Text of a file, none if it cannot be read.
    fn read_file(&mut self, path: &str) -> Option<String>;

    /// Replaces a file; false if it cannot be written.
    fn write_file(&mut self, path: &str, text: &str) -> bool;

    /// One line from the console.
    fn read_console(&mut self) -> Option<String> {
        None
    }

    /// One line to the console.
    fn write_console(&mut self, line: &str) {
        let _ = line;
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
