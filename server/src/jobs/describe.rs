//! The fixed facts of a job, and its status, in wire form.

use counterpoint_kernel::dialog::answers::{DialogAnswer, DialogValue};
use counterpoint_kernel::log::info::{Info, MachineUnit};
use counterpoint_kernel::options::{JobLimits, JobOptions, RacePolicy, TimeModel};
use counterpoint_proto::v1;

use crate::ledger::first_error::FirstError;
use crate::ledger::record::{CONTENT, Cause, JobRecord, JobState, JobWork, Priority, ReachedLimit, Reason};
use crate::reason::without_paths;

/// The description that is at the head of a log and of a watch.
pub(crate) fn description(info: &Info) -> v1::JobDescription {
    let unit = match info.unit {
        MachineUnit::Mm => v1::LengthUnit::Mm,
        MachineUnit::Inch => v1::LengthUnit::Inch,
    };
    let axis = |axis: &counterpoint_kernel::log::info::JobAxis| v1::AxisDescription {
        name: axis.name.clone(),
        rotary: axis.rotary,
        diameter: axis.diameter,
    };
    let channel = |channel: &counterpoint_kernel::log::info::JobChannel| v1::ChannelDescription {
        number: u32::from(channel.number),
        name: channel.name.clone(),
        program: channel.program.clone(),
        first_line: channel.lines.0,
        last_line: channel.lines.1,
        axes: channel.axes.iter().map(axis).collect(),
    };
    v1::JobDescription {
        machine: info.machine.clone(),
        unit: unit.into(),
        channels: info.channels.iter().map(channel).collect(),
        files: info.files.iter().map(|f| f.name.clone()).collect(),
    }
}

/// A state on the wire.
pub(crate) fn state(state: JobState) -> v1::JobState {
    match state {
        JobState::Queued => v1::JobState::Queued,
        JobState::Running => v1::JobState::Running,
        JobState::Succeeded => v1::JobState::Succeeded,
        JobState::Failed => v1::JobState::Failed,
        JobState::Cancelled => v1::JobState::Cancelled,
    }
}

/// A finding on the wire.
pub(crate) fn finding(reason: Reason) -> v1::Finding {
    let Reason { error, file, line, column, text } = reason;
    v1::Finding { error, file, line, column, text }
}

/// The status of a job.
pub(crate) fn status(record: JobRecord) -> v1::JobStatus {
    let program = |p: counterpoint_kernel::job::ProgramSelection| v1::Program {
        path: p.file,
        number: p.number,
        section: p.section,
        channel: p.channel.map(u32::from),
    };
    v1::JobStatus {
        job_id: record.id,
        request_id: record.request_id,
        state: state(record.state).into(),
        machine: record.machine_name,
        programs: record.programs.into_iter().map(program).collect(),
        attempt: record.runs.attempt,
        cancel_requested: record.cancel,
        submitted_ms: record.submitted_ms,
        started_ms: record.runs.started_ms,
        ended_ms: record.ended_ms,
        events: record.events,
        makespan_ns: record.makespan_ns,
        highest_severity: u32::from(record.highest_severity),
        verdict: record.verdict,
        error: without_paths(&record.error).into_owned(),
        findings: record.findings.into_iter().map(finding).collect(),
        log_digest: record.log_digest,
        host_failures: record.runs.host_failures,
        host_failure: without_paths(&record.runs.host_failure).into_owned(),
        labels: record.asked.labels,
        priority: match record.asked.priority {
            Priority::High => v1::JobPriority::High,
            Priority::Normal => v1::JobPriority::Normal,
            Priority::Low => v1::JobPriority::Low,
        }
        .into(),
        deadline_ms: record.asked.deadline_ms,
        tenant: record.tenant,
        cause: match record.runs.cause {
            None => v1::JobCause::Unspecified,
            Some(Cause::Program) => v1::JobCause::Program,
            Some(Cause::Machine) => v1::JobCause::Machine,
            Some(Cause::Limit) => v1::JobCause::Limit,
            Some(Cause::Host) => v1::JobCause::Host,
        }
        .into(),
        rerun_of: record.asked.rerun_of,
        machine_guess: record.asked.guess,
        reused_from: record.reuse.from,
        reused_ended_ms: record.reuse.ended_ms,
        suspect: record.runs.suspect,
        paused: record.paused,
        limit: limit(record.runs.reached).into(),
        cpu_us: record.runs.cpu_us,
        first_error: record.first_error.map(error),
        // Only calls that return the current state fill these fields.
        waits_for_suspect: false,
        waits_for_job: String::new(),
        operator_wait: None,
        worker_wait: None,
        // Only lists fill this field.
        short_id: String::new(),
    }
}

fn error(error: FirstError) -> v1::JobError {
    let FirstError { number, text, file, line, channel } = error;
    v1::JobError { number, text: without_paths(&text).into_owned(), file, line, channel: channel.into() }
}

fn limit(reached: Option<ReachedLimit>) -> v1::JobLimit {
    match reached {
        None => v1::JobLimit::Unspecified,
        Some(ReachedLimit::WallMs) => v1::JobLimit::WallMs,
        Some(ReachedLimit::MaxJobBytes) => v1::JobLimit::MaxJobBytes,
        Some(ReachedLimit::Deadline) => v1::JobLimit::Deadline,
        Some(ReachedLimit::SimulatedNs) => v1::JobLimit::SimulatedNs,
        Some(ReachedLimit::Blocks) => v1::JobLimit::Blocks,
        Some(ReachedLimit::ZeroTimeBlocks) => v1::JobLimit::ZeroTimeBlocks,
        Some(ReachedLimit::Events) => v1::JobLimit::Events,
        Some(ReachedLimit::Memory) => v1::JobLimit::Memory,
        Some(ReachedLimit::MacroSteps) => v1::JobLimit::MacroSteps,
    }
}

/// The options of a job as they were submitted.
pub(crate) fn options(record: &JobRecord, work: &JobWork) -> v1::JobOptions {
    let JobOptions {
        opskip,
        opstop,
        ignore_waits,
        threads,
        trace,
        parameters,
        answers,
        attended,
        stepped,
        lint,
        races,
        warnings_off,
        warnings_on,
        timing,
        limits,
    } = work.options.clone();
    // Early rows have the limits that count instead of those that were requested.
    let early = || Some(limits).filter(|_| !record.content.starts_with(CONTENT));
    let limits = record.asked.limits.clone().or_else(early);
    let own = (record.runs.wall_ms, record.runs.max_job_bytes);
    let none = JobLimits {
        simulated_ns: 0,
        blocks: 0,
        zero_time_blocks: 0,
        events: 0,
        block_length: 0,
        nesting: 0,
        diagnostics: 0,
        memory: 0,
        macro_steps: 0,
    };
    let limits = limits.or_else(|| (own != (0, 0)).then_some(none)).map(|limits| v1::JobLimits {
        simulated_ns: limits.simulated_ns,
        blocks: limits.blocks,
        zero_time_blocks: limits.zero_time_blocks,
        events: limits.events,
        block_length: u32::try_from(limits.block_length).unwrap_or(u32::MAX),
        nesting: u32::from(limits.nesting),
        diagnostics: limits.diagnostics,
        memory: limits.memory,
        macro_steps: limits.macro_steps,
        wall_ms: own.0,
        max_job_bytes: own.1,
    });
    v1::JobOptions {
        opskip: opskip.into_iter().map(u32::from).collect(),
        opstop,
        ignore_waits: ignore_waits.into_iter().map(u32::from).collect(),
        threads: u32::from(threads),
        limits,
        trace,
        answers: answers.into_iter().map(answer).collect(),
        attended,
        stepped,
        lint,
        law: timing.law,
        parameters,
        races: match races {
            RacePolicy::Off => v1::RaceCheck::Unspecified,
            RacePolicy::Warn => v1::RaceCheck::Warn,
            RacePolicy::Alarm => v1::RaceCheck::Alarm,
        } as i32,
        time: match timing.model {
            TimeModel::Full => v1::TimeModel::Unspecified,
            TimeModel::Simple => v1::TimeModel::Simple,
        } as i32,
        warnings_off,
        warnings_on,
        no_cache: record.asked.no_cache,
    }
}

fn answer(answer: DialogAnswer) -> v1::DialogAnswer {
    use v1::dialog_value::Value as Wire;
    let value = |value| match value {
        DialogValue::Flag(flag) => Wire::Flag(flag),
        DialogValue::Number(number) => Wire::Number(number),
        DialogValue::Text(text) => Wire::Text(text),
    };
    let values = answer.values.into_iter();
    v1::DialogAnswer {
        dialog: answer.dialog,
        button: answer.button.unwrap_or_default(),
        values: values.map(|(name, own)| (name, v1::DialogValue { value: Some(value(own)) })).collect(),
    }
}
