//! The components of a composite machine, as a kernel has them.
//!
//! *Invariant:* a channel works with one component at a time. The macros of the other components stay as they were
//! left; the memory of the machine itself (positions, tools, offsets, spindles) belongs to the channel. Variables of
//! programs and interpreters belong to the pre-processors of the channel: components with the same pre-processor share
//! them. Facts: reference control-emulator.md 8.3.

use std::sync::Arc;

use counterpoint_control_api::LoopStack;
use counterpoint_lang::compile::MacroProgram;
use counterpoint_machine::Machine;
use counterpoint_machine::preprocessor::Preprocessor;

use super::dialect_state::DialectState;
use super::plan::ExecutionPlan;
use counterpoint_channel::macros::runtime::Runtime;

/// A component, prepared.
#[derive(Clone, Copy)]
pub struct PreparedComponent<'a> {
    /// The minor word by which macros name it.
    pub designator: &'a str,
    /// Its name in messages.
    pub name: &'a str,
    /// Channels that it may work in.
    pub channels: &'a [u16],
    /// Its definition.
    pub machine: &'a Machine,
    /// The definition, prepared.
    pub plan: &'a ExecutionPlan,
    /// Its macros as kernels run them.
    pub macros: Option<&'a Arc<MacroProgram>>,
}

/// Which component a channel works with.
#[derive(Default)]
pub struct ComponentSelection {
    /// Place of the active one; none on a machine that is not a composite.
    pub now: Option<usize>,
    /// Place of the previous component.
    pub before: Option<usize>,
    /// Place of the component that a macro has requested.
    pub wanted: Option<usize>,
    /// Macros of components that have worked here, by place.
    pub kept: Vec<(usize, Box<Runtime>)>,
    /// Pre-processors that have worked here and do not now.
    pub dialects: Vec<Resting>,
}

/// A pre-processor that has worked here.
pub struct Resting {
    /// Which.
    pub of: Preprocessor,
    /// Its variables and its interpreter.
    pub dialect: DialectState,
    /// Loops that its programs were in.
    pub loops: LoopStack,
    /// Subprograms that ran then, each with whether it has variables of its own.
    pub levels: Vec<bool>,
}

/// The components of the machine, and the active one.
#[derive(Default)]
pub struct Components<'a> {
    /// The components of the machine.
    pub all: &'a [PreparedComponent<'a>],
    /// The active component, and the components that have worked here.
    pub turns: ComponentSelection,
}

impl<'a> Components<'a> {
    /// All of the machine, with the first component of a channel active.
    pub(crate) fn of(all: &'a [PreparedComponent<'a>], channel: u16) -> Self {
        let now = all.iter().position(|component| component.channels.contains(&channel));
        Self { all, turns: ComponentSelection { now, ..ComponentSelection::default() } }
    }

    /// Whether the machine is a composite.
    pub fn is_composite(&self) -> bool {
        !self.all.is_empty()
    }

    /// The active one; none on a machine that is not a composite, and in its master.
    pub fn current(&self) -> Option<&'a PreparedComponent<'a>> {
        self.turns.now.and_then(|now| self.all.get(now))
    }

    /// The previous component.
    pub fn previous(&self) -> Option<&'a PreparedComponent<'a>> {
        self.turns.before.and_then(|before| self.all.get(before))
    }

    /// Place of the component that a designator names in a channel.
    pub fn named(&self, designator: &str, channel: u16) -> Option<usize> {
        let is = |one: &PreparedComponent<'_>| {
            one.designator.eq_ignore_ascii_case(designator) && one.channels.contains(&channel)
        };
        self.all.iter().position(is)
    }
}
