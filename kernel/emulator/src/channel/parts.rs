//! The parts of a kernel outside its channel: its outputs, and the data from which it is made.

use super::components::PreparedComponent;
use super::plan::ExecutionPlan;
use counterpoint_channel::channel_context::RunEnvironment;
use counterpoint_channel::emitter::Emitter;
use counterpoint_ports::control::{ChannelProgress, JobControl};
use counterpoint_ports::step::Stepper;
use counterpoint_sync::coordinator::switch::Port;

/// The outputs of a kernel: to the other kernels, to the caller of the job, to the operator.
pub struct Ports<'a> {
    /// To the other kernels.
    pub coordinator: Port<'a>,
    /// To the caller of the job.
    pub control: &'a JobControl,
    /// Live progress of the channel.
    pub progress: &'a ChannelProgress,
    /// To the operator who steps through the job.
    pub stepper: Option<&'a dyn Stepper>,
}

/// Data with which a kernel is made.
pub struct Setup<'a> {
    /// The subject of the run.
    pub env: RunEnvironment<'a>,
    /// To the log.
    pub emitter: Emitter<'a>,
    /// The paths out.
    pub ports: Ports<'a>,
    /// The machine, prepared.
    pub plan: &'a ExecutionPlan,
    /// The components of a composite machine, prepared, as its list has them.
    pub components: &'a [PreparedComponent<'a>],
}
