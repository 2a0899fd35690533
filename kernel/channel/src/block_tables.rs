//! Data that the blocks of a channel need and that depend only on the machine and the job.
//!
//! *Invariant:* made once per job; the kernels of a job share them, and no run changes them.

use std::sync::Arc;

use counterpoint_control_api::Dialect;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_machine::index::{CodeRowId, IdTable};
use counterpoint_program::data_plan::{DataPlan, DataSource};
use counterpoint_program::registers::{BlockRules, Edits, ScannedRegisters, rows_of_code};
use counterpoint_program::scan::LineScanner;
use counterpoint_program::word_names::WordNames;

use crate::calling_words::CodeCalls;

/// Machine data that blocks need.
pub struct BlockTables {
    /// Splits lines into words.
    pub scanner: LineScanner,
    /// For text left by the pre-processor of another control, which has treated the marks of block skip.
    pub unmarked: Option<Arc<LineScanner>>,
    /// Words that call programs; `None` when the machine has none.
    pub code_calls: Option<Box<CodeCalls>>,
    /// First enabled row of each code.
    pub rows_of_code: IdTable<CodeId, Option<CodeRowId>>,
    /// Registers by their use.
    pub registers: ScannedRegisters,
    /// Names of words and codes.
    pub names: WordNames,
    /// Sources of data.
    pub data: DataPlan,
    /// Changes of the text of blocks.
    pub edits: Edits,
    /// The effect of its blocks beyond their words.
    pub rules: BlockRules,
}

impl BlockTables {
    /// The tables of a machine with its dialect and the active block skip levels.
    pub fn new(machine: &Machine, dialect: &dyn Dialect, opskip: &[u8]) -> Self {
        let registers = ScannedRegisters::new(machine);
        let syntax = dialect.syntax();
        Self {
            unmarked: syntax.needs_interpreter.map(|_| Arc::new(LineScanner::without_marks(machine, syntax))),
            scanner: LineScanner::new(machine, syntax, opskip),
            code_calls: CodeCalls::new(machine),
            rows_of_code: rows_of_code(machine),
            rules: BlockRules::new(machine, registers.g, dialect.lead_is_feed()),
            names: WordNames::new(machine),
            registers,
            data: DataPlan::new(machine),
            edits: Edits::new(machine, syntax),
        }
    }

    /// Where the values of an identifier come from.
    pub fn sources_of(&self, id: DataId) -> &[DataSource] {
        &self.data.sources[id]
    }

    /// Registers that can supply an identifier, bit by register.
    pub fn registers_of(&self, id: DataId) -> u128 {
        self.data.registers_of[id]
    }
}
