//! Stepping through a job: the commands of its operator, and the answers.
//!
//! Two sides: a [`Console`] is the source of commands (a terminal, a stream of the server); a kernel asks a [`Stepper`]
//! before a block, at a wait and after a write. Invariant: neither changes the next action of a kernel, only its time;
//! a reset is the only command that changes the log.

use std::sync::Arc;
use std::time::Duration;

use crate::dialog::answers::DialogValue;
use crate::state::ChannelActivity;
use counterpoint_event::event::WaitArrival;
use counterpoint_event::{FileId, Position, SourcePlace};

/// The commands of the operator.
#[derive(Debug, Clone, PartialEq)]
pub enum StepCommand {
    /// Runs a number of blocks.
    Step {
        /// Of which channels.
        whom: Whom,
        /// Number of blocks of each channel; with [`StepCalls::Out`], number of calls to leave.
        blocks: u32,
        /// How the step treats calls.
        calls: StepCalls,
    },
    /// Runs until a breakpoint or the end.
    Continue,
    /// Stops before the next block.
    Pause,
    /// Sets a breakpoint.
    Add(Breakpoint),
    /// Deletes a breakpoint by its number; 0 = all.
    Remove(u32),
    /// Feed hold: the channel starts no further block; 0 = all.
    Hold(u16),
    /// Ends a feed hold; 0 = all.
    Resume(u16),
    /// Resets a channel: its program ends before its next block.
    Reset(u16),
    /// Tells where everything is.
    Show,
    /// The operator leaves: the job runs to its end.
    Detach,
}

impl StepCommand {
    /// Whether the job runs on by it, so that the answer is the next stop.
    #[must_use]
    pub fn runs(&self) -> bool {
        matches!(self, Self::Step { .. } | Self::Continue)
    }
}

/// Channels that a step is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whom {
    /// The one that is furthest behind in simulated time.
    Next,
    /// This one; others run only as far as it needs them.
    One(u16),
    /// Each of them.
    All,
}

/// How a step treats calls of subprograms, macros and program parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StepCalls {
    /// Blocks of called programs count, too.
    #[default]
    Into,
    /// A call is one block.
    Over,
    /// Runs to the next block after the return.
    Out,
}

/// A place at which a run stops.
#[derive(Debug, Clone, PartialEq)]
pub struct Breakpoint {
    /// Its number, from 1; 0 before it is set.
    pub id: u32,
    /// Where.
    pub spot: BreakLocation,
    /// It stops at every `count`-th hit; 0 and 1: at every one.
    pub count: u32,
    /// It is deleted when it stops the run.
    pub once: bool,
}

/// Where a breakpoint is.
#[derive(Debug, Clone, PartialEq)]
pub enum BreakLocation {
    /// Where a channel comes to a wait, by its text (`M101 P12`), word (`M101`) or mark (`101`); empty = any wait.
    Wait(String),
    /// After a channel has written a variable that channels share (`#500`, or a name).
    Write(String),
    /// Before a block of a file, by path or by the end of it; empty = any file.
    Line {
        /// File.
        file: String,
        /// Line, from 1.
        line: u32,
    },
    /// Before the first block that begins at this time or later, ns.
    Time(i64),
}

/// Answers to the operator. Every command has one answer; that of a command that runs is the next stop.
#[derive(Debug, Clone, PartialEq)]
pub enum StepReply {
    /// The run has stopped.
    Stopped(StepReport),
    /// Where everything is.
    State(StepReport),
    /// A breakpoint is set, with its number.
    Added(Breakpoint),
    /// The command is not possible, and why.
    Refused(String),
}

/// Where everything is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StepReport {
    /// Why the run is paused, for a person.
    pub reason: String,
    /// The channel that the reason is about; 0 = none.
    pub channel: u16,
    /// All channels, ascending.
    pub channels: Vec<ChannelReport>,
    /// Variables that channels share and that have a value, by name.
    pub variables: Vec<(String, DialogValue)>,
    /// Breakpoints.
    pub breakpoints: Vec<Breakpoint>,
}

/// Where a channel is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChannelReport {
    /// Its number.
    pub channel: u16,
    /// Its effect.
    pub state: ChannelActivity,
    /// File of its block.
    pub file: String,
    /// Line of its block; 0 = it has not come to one yet.
    pub line: u32,
    /// Text of the block.
    pub block: String,
    /// Simulated time, ns.
    pub t_ns: i64,
    /// Its wait.
    pub wait: Option<Arc<WaitArrival>>,
    /// Feed hold.
    pub held: bool,
    /// The block is in progress; otherwise it is the next one.
    pub in_block: bool,
    /// Programmed positions by axis, in the work frame.
    pub positions: Vec<(String, f64)>,
    /// Variables of its own that have a value, those of the running program first, as of the beginning of the block.
    pub variables: Vec<(String, DialogValue)>,
    /// Words that the control remembers, by address.
    pub words: Vec<(char, f64)>,
}

/// Information that a kernel gives about itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KernelSnapshot {
    /// Its channel.
    pub channel: u16,
    /// File of the block.
    pub file: FileId,
    /// Line of the block.
    pub line: u32,
    /// Number of calls around the block; 0 in the main program.
    pub level: u32,
    /// Simulated time, ns.
    pub t_ns: i64,
    /// Programmed position.
    pub position: Position,
    /// Numbered variables of its own that have a value.
    pub variables: Vec<(u32, f64)>,
    /// Words that the control remembers, by address; those other than 0.
    pub words: Vec<(char, f64)>,
}

/// An event that a kernel has reached within a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepEvent<'e> {
    /// It comes to a wait.
    Wait(&'e WaitArrival, u32),
    /// It has written a shared variable: its name, and the value if it is a number.
    Write(&'e str, Option<f64>),
}

/// Whether a kernel executes its next block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Go {
    /// It does.
    On,
    /// Its program ends here.
    Reset,
}

/// Shared data, on request.
pub type Common<'c> = dyn FnMut() -> Vec<(String, DialogValue)> + 'c;

/// Requests of the kernels of a job with stepping.
pub trait Stepper: Sync {
    /// A kernel is before a block; `true`: it begins the block at once without giving the run away, since nothing stops
    /// the run there. `first`: no other kernel is further behind. Variables are requested if they may be others than
    /// the last time.
    fn stands(&self, place: &KernelSnapshot, first: bool, variables: (u64, &dyn Fn() -> Vec<(u32, f64)>)) -> bool;

    /// Whether a breakpoint is before this block of a resident program; steps go over all others.
    fn breaks_at(&self, place: SourcePlace) -> bool;

    /// Whether something within a block may stop the run.
    fn listens(&self) -> bool;

    /// A kernel has come to something within its block; `true`: the run stops here.
    fn comes_to(&self, event: StepEvent<'_>, seen: &mut dyn FnMut() -> KernelSnapshot) -> bool;

    /// For the only kernel of a job: waits until it may continue.
    fn hold_alone(&self, channel: u16, common: &mut Common<'_>);

    /// A kernel continues with its block.
    fn goes(&self, channel: u16) -> Go;
}

/// Input from a console.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// A command.
    Command(StepCommand),
    /// Nothing yet.
    Nothing,
    /// No more commands will come: the job runs to its end.
    Gone,
}

/// Where the commands for a job come from.
pub trait Console: Send + Sync {
    /// Whether a command is there, or no more commands will come. Cheap, since it is tested before every block.
    fn has_news(&self) -> bool;

    /// The next command, if one is there.
    fn poll(&self) -> Heard;

    /// The next command. Waits for it at most so long; the caller checks the end of the job in between.
    fn wait(&self, at_most: Duration) -> Heard;

    /// Tells the operator something.
    fn say(&self, said: StepReply);
}
