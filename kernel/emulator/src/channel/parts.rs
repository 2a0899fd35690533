//! The parts of a kernel beside its channel: the paths out of it, and its pre-processor.

use super::components::Component;
use super::emit::Emitter;
use super::left_words::LeftWords;
use super::plan::Plan;
use super::variables::ChannelVariables;
use crate::state::channel::Environment;
use counterpoint_dialect::{self, Dialect, Interpreter, MadeBlocks};
use counterpoint_machine::Machine;
use counterpoint_ports::control::{Control, Progress};
use counterpoint_ports::step::Stepper;
use counterpoint_sync::coordinator::switch::Port;

/// The outputs of a kernel: to the other kernels, to the caller of the job, to the log.
pub struct Ports<'a> {
    /// To the other kernels.
    pub coordinator: Port<'a>,
    /// To the caller of the job.
    pub control: &'a Control,
    /// Live progress of the channel.
    pub progress: &'a Progress,
    /// To the log.
    pub emitter: Emitter<'a>,
    /// To the operator who steps through the job.
    pub stepper: Option<&'a dyn Stepper>,
}

/// The dialect of a channel.
pub(crate) struct DialectState {
    /// Which dialect.
    pub(crate) kind: &'static dyn Dialect,
    /// Numbered variables.
    pub(crate) variables: ChannelVariables,
    /// Interpreter of statements other than plain words; it is `None` while it runs.
    pub(crate) interpreter: Option<Box<dyn Interpreter>>,
    /// Programs that the interpreter has read are out of date; the interpreter is notified when it is put back.
    pub(crate) is_stale: bool,
    /// Blocks of the cycle that is executed; only their memory is kept from one to the next.
    pub(crate) cycle_blocks: MadeBlocks,
    /// Words that the interpreter leaves.
    pub(crate) left: LeftWords,
}

impl DialectState {
    /// The dialect of a machine, with its interpreter if it `executes`.
    pub(crate) fn new(machine: &Machine, executes: bool) -> Self {
        let kind = counterpoint_dialect::of(machine);
        Self {
            kind,
            variables: ChannelVariables::new(&machine.variables),
            interpreter: if executes { kind.interpreter(machine) } else { None },
            is_stale: false,
            cycle_blocks: MadeBlocks::default(),
            left: LeftWords::default(),
        }
    }
}

/// Data with which a kernel is made.
pub struct Setup<'a> {
    /// The subject of the run.
    pub env: Environment<'a>,
    /// The paths out.
    pub ports: Ports<'a>,
    /// The machine, prepared.
    pub plan: &'a Plan,
    /// The components of a composite machine, prepared, as its list has them.
    pub components: &'a [Component<'a>],
}
