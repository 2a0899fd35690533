//! The parts of a kernel beside its channel: the ways out of it, and its pre-processor.

use super::emit::Emitter;
use super::plan::Plan;
use super::variables::ChannelVariables;
use crate::control::{Control, Progress};
use crate::dialect::Interpreter;
use crate::multi::coordinator::switch::Port;
use crate::state::channel::Environment;

/// The ways out of a kernel: to the other kernels, to whoever started the job, to the log.
pub(crate) struct Ports<'a> {
    pub(crate) coordinator: Port<'a>,
    pub(crate) control: &'a Control,
    pub(crate) progress: &'a Progress,
    pub(crate) emitter: Emitter<'a>,
}

/// Pre-processor of a channel.
#[derive(Default)]
pub(crate) struct DialectState {
    /// Variables of the custom macros.
    pub(crate) variables: ChannelVariables,
    /// Interpreter of another control than the one whose variables are above.
    pub(crate) interpreter: Option<Box<dyn Interpreter>>,
}

/// What a kernel is given when it is made.
pub(crate) struct Setup<'a> {
    pub(crate) env: Environment<'a>,
    pub(crate) ports: Ports<'a>,
    pub(crate) plan: &'a Plan,
}
