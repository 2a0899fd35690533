//! What is fixed about a job, and its status, in wire form.

use counterpoint_kernel::log::info::{Info, Unit};
use counterpoint_proto::v1;

use crate::ledger::record::{Reason, Record, State};

/// The description that stands at the head of a log and of a watch.
pub(crate) fn description(info: &Info) -> v1::JobDescription {
    let unit = match info.unit {
        Unit::Mm => v1::LengthUnit::Mm,
        Unit::Inch => v1::LengthUnit::Inch,
    };
    let axis = |axis: &counterpoint_kernel::log::info::Axis| v1::AxisDescription {
        name: axis.name.clone(),
        rotary: axis.rotary,
        diameter: axis.diameter,
    };
    let channel = |channel: &counterpoint_kernel::log::info::Channel| v1::ChannelDescription {
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
pub(crate) fn state(state: State) -> v1::JobState {
    match state {
        State::Queued => v1::JobState::Queued,
        State::Running => v1::JobState::Running,
        State::Succeeded => v1::JobState::Succeeded,
        State::Failed => v1::JobState::Failed,
        State::Cancelled => v1::JobState::Cancelled,
    }
}

/// A finding on the wire.
pub(crate) fn finding(reason: Reason) -> v1::Finding {
    let Reason { error, file, line, column, text } = reason;
    v1::Finding { error, file, line, column, text }
}

/// The status of a job.
pub(crate) fn status(record: Record) -> v1::JobStatus {
    let program = |p: counterpoint_kernel::job::Program| v1::Program {
        path: p.file,
        number: p.number,
        channel: p.channel.map(u32::from),
    };
    v1::JobStatus {
        job_id: record.id,
        request_id: record.request_id,
        state: state(record.state).into(),
        machine: record.machine_name,
        programs: record.programs.into_iter().map(program).collect(),
        attempt: record.attempt,
        cancel_requested: record.cancel,
        submitted_ms: record.submitted_ms,
        started_ms: record.started_ms,
        ended_ms: record.ended_ms,
        events: record.events,
        makespan_ns: record.makespan_ns,
        highest_severity: u32::from(record.highest_severity),
        verdict: record.verdict,
        error: record.error,
        findings: record.findings.into_iter().map(finding).collect(),
        log_digest: record.log_digest,
        host_failures: record.host_failures,
        host_failure: record.host_failure,
    }
}
