//! The functions above the kernel that its plan calls: actions, hooks of macros, the check without a run.
//!
//! *Invariant:* nothing in this crate knows them; the job that makes a plan names them once.

use counterpoint_fault::Halt;

use super::Kernel;
use super::actions::ActionTable;
use super::hook_points::HookPoints;

/// Tables of functions, as a plan takes them.
#[derive(Clone, Copy)]
pub struct PlanTables {
    /// The built-in actions.
    pub actions: &'static ActionTable,
    /// Hooks of a machine with macros.
    pub hooks: Option<&'static HookPoints>,
    /// Follows a program without executing it.
    pub lint: fn(&mut Kernel<'_>) -> Halt,
}
