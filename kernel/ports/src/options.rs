//! The options of a job: switches of the operator's panel and its limits.

use serde::{Deserialize, Serialize};

use crate::dialog::answers::DialogAnswer;

/// Options of one job.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JobOptions {
    /// Optional-skip levels (1–9) that are switched on; 0 = that of a mark without a digit.
    pub opskip: Vec<u8>,
    /// Optional stop (M1) acts as a stop.
    pub opstop: bool,
    /// Channels that pass every meeting point without waiting.
    pub ignore_waits: Vec<u16>,
    /// How many kernels may run at the same time; 0 = one per channel. 1 is the sequential mode. The log is the
    /// same for every value.
    pub threads: u16,
    /// Letters of the trace (`IEWCAMHSXZ` or `all`), empty = none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub trace: String,
    /// Parameters for the macros of the machine (`$UPARAM`), one line; empty = none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub parameters: String,
    /// Answers to the dialogs of the machine; without one a dialog fails.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<DialogAnswer>,
    /// Whether an operator attends the job: dialogs without an answer are put to the operator.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub attended: bool,
    /// Whether the job is stepped through: it stops before its first block.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub stepped: bool,
    /// Nothing is executed: the programs are only judged by their waits, calls and jumps.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lint: bool,
    /// Reaction when two channels access one shared variable in an order that only timing decides.
    #[serde(skip_serializing_if = "RacePolicy::is_off")]
    pub races: RacePolicy,
    /// Numbers of warnings and messages that are not reported; alarms and errors stay.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings_off: Vec<u32>,
    /// Numbers of warnings and messages that are reported even if the machine switches them off.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings_on: Vec<u32>,
    /// How moves are timed.
    #[serde(rename = "time", skip_serializing_if = "MoveTiming::is_usual")]
    pub timing: MoveTiming,
    /// Limits.
    pub limits: JobLimits,
}

/// How moves at feed are timed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeModel {
    /// As the machine makes them: acceleration, corners and look-ahead, where the machine gives them.
    #[default]
    Full,
    /// Length by feed: speeds change at once unless a block asks for an exact stop.
    Simple,
}

/// How moves are timed, and whether the log has their laws of motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "TimingForm", into = "TimingForm")]
pub struct MoveTiming {
    /// How moves at feed are timed.
    pub model: TimeModel,
    /// Whether the log has the law of each motion.
    pub law: bool,
}

impl MoveTiming {
    /// Length divided by feed, without laws.
    pub const SIMPLE: Self = Self { model: TimeModel::Simple, law: false };

    /// Whether it is the usual one.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// The stored form: a word, unless laws are recorded.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum TimingForm {
    Model(TimeModel),
    WithLaw { model: TimeModel, law: bool },
}

impl From<TimingForm> for MoveTiming {
    fn from(form: TimingForm) -> Self {
        match form {
            TimingForm::Model(model) => Self { model, law: false },
            TimingForm::WithLaw { model, law } => Self { model, law },
        }
    }
}

impl From<MoveTiming> for TimingForm {
    fn from(MoveTiming { model, law }: MoveTiming) -> Self {
        if law { Self::WithLaw { model, law } } else { Self::Model(model) }
    }
}

/// The consequences of two accesses to a shared variable that nothing puts in order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RacePolicy {
    /// No check.
    #[default]
    Off,
    /// A warning.
    Warn,
    /// An alarm that stops the channel.
    Alarm,
}

impl RacePolicy {
    /// Whether races are not checked.
    #[must_use]
    pub fn is_off(&self) -> bool {
        *self == Self::Off
    }
}

/// Limits of one job. Reaching one ends the run with a verdict of kind `LIMIT`; a request beyond [`JobLimits::MOST`]
/// counts as that maximum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JobLimits {
    /// Simulated time, ns.
    pub simulated_ns: i64,
    /// Blocks per channel.
    pub blocks: u64,
    /// Consecutive blocks of one channel that take no time.
    pub zero_time_blocks: u64,
    /// Events of one channel.
    pub events: u64,
    /// Length of one block in bytes.
    pub block_length: usize,
    /// Subprogram nesting.
    pub nesting: u16,
    /// Diagnostics kept per channel; more are counted, not logged.
    pub diagnostics: u32,
    /// Bytes of memory for variables, texts, files and results of the job.
    pub memory: u64,
    /// Steps of macros per channel.
    pub macro_steps: u64,
}

impl JobLimits {
    /// The most that a job may ask for.
    pub const MOST: JobLimits = JobLimits {
        simulated_ns: 366 * 24 * 3600 * 1_000_000_000,
        blocks: 10_000_000_000,
        zero_time_blocks: 1_000_000_000,
        events: 100_000_000_000,
        block_length: 1 << 20,
        nesting: 1000,
        diagnostics: 10_000,
        memory: 16 << 30,
        macro_steps: 1_000_000_000_000_000,
    };

    /// These limits, none beyond [`MOST`](Self::MOST).
    #[must_use]
    pub fn capped(&self) -> JobLimits {
        let most = &Self::MOST;
        JobLimits {
            simulated_ns: self.simulated_ns.min(most.simulated_ns),
            blocks: self.blocks.min(most.blocks),
            zero_time_blocks: self.zero_time_blocks.min(most.zero_time_blocks),
            events: self.events.min(most.events),
            block_length: self.block_length.min(most.block_length),
            nesting: self.nesting.min(most.nesting),
            diagnostics: self.diagnostics.min(most.diagnostics),
            memory: self.memory.min(most.memory),
            macro_steps: self.macro_steps.min(most.macro_steps),
        }
    }
}

impl Default for JobLimits {
    fn default() -> Self {
        Self {
            simulated_ns: 24 * 3600 * 1_000_000_000,
            blocks: 10_000_000,
            zero_time_blocks: 1_000_000,
            events: 40_000_000,
            block_length: 8192,
            nesting: 32,
            diagnostics: 1000,
            memory: 256 << 20,
            macro_steps: 20_000_000_000,
        }
    }
}
