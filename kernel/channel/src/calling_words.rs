//! Words that call a macro program by themselves.

use counterpoint_control_api::MacroCall;
use counterpoint_machine::Machine;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::model::WordCall;

/// Kind of a word that calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WordKind {
    /// A G word.
    G,
    /// A word of another register.
    Other,
}

/// Which word has called.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CallingWord {
    /// Kind of the word.
    pub kind: WordKind,
    /// Common variable that gets the value of the word.
    pub variable: Option<u32>,
    /// Its value.
    pub value: f64,
}

/// A macro that a word of the block calls.
#[derive(Debug)]
pub struct CodeMacro {
    /// Register of the word.
    pub register: RegisterId,
    /// Number of the program.
    pub program: u32,
    /// Kind of the call.
    pub how: MacroCall,
    /// The word itself.
    pub by: CallingWord,
}

/// The words of a machine.
#[derive(Debug)]
pub struct CodeCalls {
    /// Their registers, bit by register.
    pub registers: u128,
    rows: Vec<WordCall>,
}

impl CodeCalls {
    /// The calling words of a machine, none on a machine without any.
    pub fn new(machine: &Machine) -> Option<Box<Self>> {
        let rows = machine.subprograms.calls.clone();
        let registers = rows.iter().fold(0, |bits, row| bits | row.register.bit());
        (!rows.is_empty()).then(|| Box::new(Self { registers, rows }))
    }

    /// The row of a word that calls, and the number of its program.
    pub fn find(&self, register: RegisterId, value: f64) -> Option<(&WordCall, u32)> {
        if self.registers & register.bit() == 0 {
            return None;
        }
        self.rows.iter().find_map(|row| Some((row, row.program_of(register, value)?)))
    }
}
