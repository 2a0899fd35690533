//! Plans of machines, kept for the next jobs.
//!
//! A plan holds the data that the kernels derive from a machine before their first block. Jobs of one machine share it,
//! so that a server does this work once per machine and not once per job.
//!
//! *Invariant:* a plan serves only the very machine and the switches that it was made for; a machine without another
//! owner is forgotten.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use counterpoint_emulator::channel::plan::ExecutionPlan;
use counterpoint_emulator::channel::plan_tables::PlanTables;
use counterpoint_machine::Machine;

/// Most plans that are kept.
const MOST: usize = 16;

/// Plans of the machines of earlier jobs; those used last, at most 16.
#[derive(Default)]
pub struct Plans {
    /// The last one was used last.
    kept: Mutex<Vec<CachedPlan>>,
}

struct CachedPlan {
    machine: Weak<Machine>,
    opskip: Vec<u8>,
    hooks: bool,
    plan: Arc<ExecutionPlan>,
}

impl std::fmt::Debug for Plans {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Plans").finish_non_exhaustive()
    }
}

impl CachedPlan {
    fn is_for(&self, wanted: &PlanRequest<'_>) -> bool {
        // A weak reference keeps its place from being used again, so the same place is the same machine.
        std::ptr::eq(self.machine.as_ptr(), Arc::as_ptr(wanted.machine))
            && self.opskip == wanted.opskip
            && self.hooks == wanted.hooks
    }
}

/// The parts of a plan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlanRequest<'a> {
    pub(crate) machine: &'a Arc<Machine>,
    /// Levels of block skip that are on.
    pub(crate) opskip: &'a [u8],
    /// Macros of the machine take part.
    pub(crate) hooks: bool,
}

impl PlanRequest<'_> {
    /// Makes the plan.
    pub(crate) fn plan(&self) -> ExecutionPlan {
        let tables = PlanTables {
            actions: &counterpoint_actions::ACTIONS,
            hooks: self.hooks.then_some(&counterpoint_macro_host::hooks::POINTS),
            lint: counterpoint_lint::walk,
        };
        ExecutionPlan::new(self.machine, self.opskip, tables)
    }
}

impl Plans {
    /// The plan that is wanted, made now or earlier.
    pub(crate) fn of(&self, wanted: &PlanRequest<'_>) -> Arc<ExecutionPlan> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().rposition(|kept| kept.is_for(wanted)) {
            let found = kept.remove(at);
            let plan = Arc::clone(&found.plan);
            kept.push(found);
            return plan;
        }
        drop(kept);
        let plan = Arc::new(wanted.plan());
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|kept| kept.machine.strong_count() > 0 && !kept.is_for(wanted));
        if kept.len() >= MOST {
            kept.remove(0);
        }
        kept.push(CachedPlan {
            machine: Arc::downgrade(wanted.machine),
            opskip: wanted.opskip.to_vec(),
            hooks: wanted.hooks,
            plan: Arc::clone(&plan),
        });
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_machine::{load, package};

    fn machine() -> Arc<Machine> {
        Arc::new(load(&package::shipped(), "fanuc-mill").machine.expect("a shipped machine"))
    }

    fn wanted<'a>(machine: &'a Arc<Machine>, opskip: &'a [u8]) -> PlanRequest<'a> {
        PlanRequest { machine, opskip, hooks: false }
    }

    #[test]
    fn jobs_of_a_machine_share_its_plan_and_others_do_not() {
        let (plans, machine) = (Plans::default(), machine());
        let first = plans.of(&wanted(&machine, &[]));
        assert!(Arc::ptr_eq(&first, &plans.of(&wanted(&machine, &[]))));
        assert!(!Arc::ptr_eq(&first, &plans.of(&wanted(&machine, &[1]))));
        assert!(!Arc::ptr_eq(&first, &plans.of(&wanted(&self::machine(), &[]))));
        assert!(Arc::ptr_eq(&first, &plans.of(&wanted(&machine, &[]))));
    }

    #[test]
    fn a_machine_that_is_gone_is_forgotten_and_few_plans_are_kept() {
        let plans = Plans::default();
        plans.of(&wanted(&machine(), &[]));
        let machine = machine();
        plans.of(&wanted(&machine, &[]));
        assert_eq!(plans.kept.lock().expect("a lock").len(), 1);
        for level in 0..MOST as u8 + 4 {
            plans.of(&wanted(&machine, &[level % 9 + 1, level / 9 + 1]));
        }
        assert_eq!(plans.kept.lock().expect("a lock").len(), MOST);
    }
}
