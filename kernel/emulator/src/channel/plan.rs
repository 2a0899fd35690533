//! Data that are compiled once per job and shared by its kernels.

use std::sync::Arc;

use super::Kernel;
use super::actions::{Action, ActionTable};
use super::hook_points::HookPoints;
use super::plan_tables::PlanTables;
use counterpoint_channel::calling_words::CodeCalls;
use counterpoint_event::event::Motion;
use counterpoint_fault::Acted;
use counterpoint_fault::Halt;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{CodeId, DataId, codes};
use counterpoint_machine::index::{CodeRowId, IdTable};
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::data_plan::{DataPlan, DataSource};
use counterpoint_program::registers::{BlockRules, Edits, ScannedRegisters, rows_of_code};
use counterpoint_program::scan::LineScanner;
use counterpoint_program::word_names::WordNames;

/// Compiled form of the machine for the block loop.
pub struct ExecutionPlan {
    /// Where the macros of the machine take part; none on a machine without macros.
    pub hooks: Option<&'static HookPoints>,
    /// Follows a program without executing it.
    pub(crate) lint: fn(&mut Kernel<'_>) -> Halt,
    /// Splits lines into words.
    pub scanner: LineScanner,
    /// For text left by the pre-processor of another control, which has treated the marks of block skip.
    pub unmarked: Option<Arc<LineScanner>>,
    /// Action of each code row.
    pub action_of_row: IdTable<CodeRowId, Option<&'static dyn Action>>,
    /// Further requests to the actions.
    pub actions: &'static ActionTable,
    /// Words that call programs; `None` when the machine has none.
    pub(crate) code_calls: Option<Box<CodeCalls>>,
    /// First enabled row of each code.
    pub(crate) rows_of_code: IdTable<CodeId, Option<CodeRowId>>,
    /// Registers by their use.
    pub registers: ScannedRegisters,
    /// Names of words and codes.
    pub(crate) names: WordNames,
    /// Sources of data.
    pub data: DataPlan,
    /// Changes of the text of blocks.
    pub edits: Edits,
    /// The effect of its blocks beyond their words.
    pub rules: BlockRules,
    /// Treatment of motions that are not simply made: the macros of the machine see them, or they are recorded.
    pub(crate) motion: Option<fn(&mut Kernel<'_>, f64, &Motion) -> Acted>,
    /// The plan by which contour blocks are read; none on machines without cycles that read them.
    pub(crate) reading: Option<Box<ExecutionPlan>>,
}

impl ExecutionPlan {
    /// Where the values of an identifier come from.
    pub fn sources_of(&self, id: DataId) -> &[DataSource] {
        &self.data.sources[id]
    }

    /// Registers that can supply an identifier, bit by register.
    pub fn registers_of(&self, id: DataId) -> u128 {
        self.data.registers_of[id]
    }

    /// The plan for a machine, with the block skip levels that are on and the functions that the kernel calls.
    pub fn new(machine: &Machine, opskip: &[u8], tables: PlanTables) -> Self {
        let PlanTables { actions, hooks, lint } = tables;
        let reads =
            |row: &CodeRow| row.enable && (matches!(row.id.kind(), CodeKind::Turning(_)) || row.id == codes::POCKET);
        let dialect = counterpoint_controls::of(machine);
        let reading = actions.reading.filter(|_| dialect.reads_contours() || machine.codes.iter().any(reads));
        let registers = ScannedRegisters::new(machine);
        let syntax = dialect.syntax();
        Self {
            hooks,
            lint,
            unmarked: syntax.needs_interpreter.map(|_| Arc::new(LineScanner::without_marks(machine, syntax))),
            scanner: LineScanner::new(machine, syntax, opskip),
            action_of_row: machine.codes.map(|_, row| (actions.of)(row.id)),
            actions,
            code_calls: CodeCalls::new(machine),
            rows_of_code: rows_of_code(machine),
            rules: BlockRules::new(machine, registers.g, dialect.lead_is_feed()),
            names: WordNames::new(machine),
            registers,
            data: DataPlan::new(machine),
            edits: Edits::new(machine, syntax),
            motion: hooks.map(|hooks| hooks.motion).or(actions.record),
            reading: reading
                .map(|actions| Box::new(Self::new(machine, opskip, PlanTables { actions, hooks: None, lint }))),
        }
    }
}
