//! Data that are compiled once per job and shared by its kernels.

use std::sync::Arc;

use super::Kernel;
use super::actions::{Action, ActionTable};
use super::hook_points::HookPoints;
use super::plan_tables::PlanTables;
use counterpoint_channel::block_tables::BlockTables;
use counterpoint_event::event::Motion;
use counterpoint_fault::Acted;
use counterpoint_fault::Halt;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::index::{CodeRowId, IdTable};
use counterpoint_machine::rows::CodeRow;

/// Compiled form of the machine for the block loop.
pub struct ExecutionPlan {
    /// Where the macros of the machine take part; none on a machine without macros.
    pub hooks: Option<&'static HookPoints>,
    /// Follows a program without executing it.
    pub(crate) lint: fn(&mut Kernel<'_>) -> Halt,
    /// Data that depend only on the machine and the job.
    pub tables: Arc<BlockTables>,
    /// Action of each code row.
    pub action_of_row: IdTable<CodeRowId, Option<&'static dyn Action>>,
    /// Further requests to the actions.
    pub actions: &'static ActionTable,
    /// Treatment of motions that are not simply made: the macros of the machine see them, or they are recorded.
    pub(crate) motion: Option<fn(&mut Kernel<'_>, f64, &Motion) -> Acted>,
    /// The plan by which contour blocks are read; none on machines without cycles that read them.
    pub(crate) reading: Option<Box<ExecutionPlan>>,
}

impl ExecutionPlan {
    /// The plan for a machine, with the block skip levels that are on and the functions that the kernel calls.
    pub fn new(machine: &Machine, opskip: &[u8], tables: PlanTables) -> Self {
        let blocks = BlockTables::new(machine, counterpoint_controls::of(machine), opskip);
        Self::with_tables(machine, Arc::new(blocks), tables)
    }

    fn with_tables(machine: &Machine, tables: Arc<BlockTables>, functions: PlanTables) -> Self {
        let PlanTables { actions, hooks, lint } = functions;
        let reads =
            |row: &CodeRow| row.enable && (matches!(row.id.kind(), CodeKind::Turning(_)) || row.id == codes::POCKET);
        let reads_contours = || counterpoint_controls::of(machine).reads_contours() || machine.codes.iter().any(reads);
        let reading = actions.reading.filter(|_| reads_contours());
        let reading = reading.map(|actions| {
            let functions = PlanTables { actions, hooks: None, lint };
            Box::new(Self::with_tables(machine, Arc::clone(&tables), functions))
        });
        Self {
            hooks,
            lint,
            tables,
            action_of_row: machine.codes.map(|_, row| (actions.of)(row.id)),
            actions,
            motion: hooks.map(|hooks| hooks.motion).or(actions.record),
            reading,
        }
    }
}
