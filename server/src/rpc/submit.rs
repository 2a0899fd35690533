//! Turns a submit into a record, or says which field is wrong.
//!
//! Invariant: a record that passes names an existing machine, only clean paths, and only blobs that are there.

use std::collections::BTreeMap;
use std::sync::Arc;

use counterpoint_kernel::diag;
use counterpoint_kernel::dialog::answers::{DialogAnswer, DialogValue};
use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::machine::similar;
use counterpoint_kernel::options::{JobLimits, JobOptions, MoveTiming, RacePolicy, TimeModel};
use counterpoint_proto::v1;
use prost::Message as _;

use super::blocking;
use super::door::some_entries;
use super::guess::{GuessSearch, guessed};
use crate::access::Caller;
use crate::blobs::digest;
use crate::jobs::Core;
use crate::jobs::admission::known_by_content;
use crate::ledger::NewJob;
use crate::ledger::record::{CONTENT, JobAttributes, JobRecord, JobWork, Priority, Runs, now_ms};
use crate::machines::{MachineRecord, is_shipped, shipped};
use crate::memory::MemoryReservation;
use crate::reason::Refusal;

/// A request that has been checked.
pub(super) enum CheckedRequest {
    New(Box<NewJob>),
    /// A repeat of the request for this job, which could no longer be accepted as a new one.
    Known(Box<JobRecord>),
}

/// Checks a request and makes the record of a new job.
pub(super) async fn check(
    core: &Arc<Core>,
    caller: &Caller,
    request: v1::SubmitJobRequest,
) -> Result<CheckedRequest, Refusal> {
    let turn = match request.machine.is_empty() {
        true => Some(core.streams.lookups.turn(&caller.identity.key()).await),
        false => None,
    };
    let search = GuessSearch::default();
    let (core, tenant, stop) = (core.clone(), caller.tenant().to_owned(), search.stop());
    blocking(move || {
        // The thread holds the turn, because it may continue after its client has disconnected.
        let _turn = turn;
        let (content, request_id) = (content_of(&request), request.request_id.clone());
        match record(&core, &tenant, content.clone(), request, &stop) {
            Ok(job) => Ok(CheckedRequest::New(job)),
            Err(refusal) => known(&core, &tenant, &request_id, &content, refusal),
        }
    })
    .await
}

/// The job of a repeated request that was refused, for example because its machine has been deleted.
fn known(
    core: &Core,
    tenant: &str,
    request_id: &str,
    content: &str,
    refusal: Refusal,
) -> Result<CheckedRequest, Refusal> {
    known_by_content(core, tenant, request_id, content)?.map(CheckedRequest::Known).ok_or(refusal)
}

fn record(
    core: &Core,
    tenant: &str,
    content: String,
    request: v1::SubmitJobRequest,
    stop: &dyn Fn() -> bool,
) -> Result<Box<NewJob>, Refusal> {
    let files = files(core, &request.files)?;
    let programs = programs(core, &request.programs, &files)?;
    let files: Vec<_> = files.into_iter().collect();
    let sent = request.options.unwrap_or_default();
    let own = sent.limits.unwrap_or_default();
    let asked = JobAttributes {
        labels: request.labels,
        priority: priority(request.priority)?.unwrap_or_default(),
        deadline_ms: deadline(request.deadline_ms)?,
        rerun_of: String::new(),
        guess: String::new(),
        no_cache: sent.no_cache,
        limits: asked_limits(&own)?,
    };
    let options = options(sent)?;
    core.blobs.of(tenant).require(&mut files.iter().map(|(_, digest)| digest))?;
    let (machine_name, guess) = match request.machine {
        named if !named.is_empty() => (named, String::new()),
        _ => guessed(core, tenant, &programs, &files, stop)?,
    };
    let asked = JobAttributes { guess, ..asked };
    let machine = machine(core, tenant, &machine_name)?;
    let work = limited(core, &asked, JobWork { machine, files, options, answers: Vec::new(), late: Vec::new() });
    // The ledger gives the job its name when it accepts it.
    let record = JobRecord {
        content,
        tenant: tenant.to_owned(),
        request_id: request.request_id,
        machine_name,
        programs,
        asked,
        runs: Runs { wall_ms: own.wall_ms, max_job_bytes: own.max_job_bytes, ..Runs::default() },
        submitted_ms: now_ms(),
        ..JobRecord::queued(&work)
    };
    Ok(Box::new(NewJob { record, work }))
}

/// Takes memory for a request for a job. One that repeats an earlier one is only answered, so it can have memory of
/// answers.
pub(super) async fn memory(
    core: &Arc<Core>,
    tenant: &str,
    request_id: &str,
    bytes: u64,
) -> Result<MemoryReservation, Refusal> {
    let full = match core.memory().take(bytes) {
        Err(full @ Refusal::MemoryFull(_)) => full,
        other => return other,
    };
    let (asked, tenant, request_id) = (core.clone(), tenant.to_owned(), request_id.to_owned());
    match blocking(move || asked.ledger.by_request(&tenant, &request_id)).await? {
        Some(_) => core.memory().take_for_answer(bytes),
        None => Err(full),
    }
}

/// Checks a request to run a job again, and makes the record of the new job.
pub(super) async fn check_rerun(
    core: &Arc<Core>,
    caller: &Caller,
    earlier: Result<JobRecord, Refusal>,
    request: v1::RerunJobRequest,
) -> Result<CheckedRequest, Refusal> {
    let (core, tenant) = (core.clone(), caller.tenant().to_owned());
    blocking(move || {
        let (content, request_id) = (content_of_rerun(&request), request.request_id.clone());
        match earlier.and_then(|earlier| rerun(&core, earlier, content.clone(), request)) {
            Ok(job) => Ok(CheckedRequest::New(job)),
            Err(refusal) => known(&core, &tenant, &request_id, &content, refusal),
        }
    })
    .await
}

/// Digest of a request to run a job again, without the request id and the deadline.
fn content_of_rerun(request: &v1::RerunJobRequest) -> String {
    let sent = v1::RerunJobRequest { request_id: String::new(), deadline_ms: 0, ..request.clone() };
    format!("{CONTENT}{}", digest(&sent.encode_to_vec()))
}

fn rerun(
    core: &Core,
    earlier: JobRecord,
    content: String,
    mut request: v1::RerunJobRequest,
) -> Result<Box<NewJob>, Refusal> {
    let work = core.work(&earlier.id)?;
    let request_id = std::mem::take(&mut request.request_id);
    // An early row has the limits that counted then instead of those that were requested.
    let early = || Some(work.options.limits.clone()).filter(|_| !earlier.content.starts_with(CONTENT));
    let asked = JobAttributes {
        labels: if request.labels.is_empty() { earlier.asked.labels } else { request.labels },
        priority: priority(request.priority)?.unwrap_or(earlier.asked.priority),
        deadline_ms: deadline(request.deadline_ms)?,
        rerun_of: earlier.id,
        guess: earlier.asked.guess,
        no_cache: earlier.asked.no_cache,
        limits: earlier.asked.limits.clone().or_else(early),
    };
    let runs = Runs { wall_ms: earlier.runs.wall_ms, max_job_bytes: earlier.runs.max_job_bytes, ..Runs::default() };
    let work = limited(core, &asked, JobWork { answers: Vec::new(), late: Vec::new(), ..work });
    let record = JobRecord {
        content,
        tenant: earlier.tenant,
        request_id,
        machine_name: earlier.machine_name,
        programs: earlier.programs,
        asked,
        runs,
        submitted_ms: now_ms(),
        ..JobRecord::queued(&work)
    };
    Ok(Box::new(NewJob { record, work }))
}

/// The work with the limits that count: those asked for, or the defaults, within the maxima of the server.
fn limited(core: &Core, asked: &JobAttributes, mut work: JobWork) -> JobWork {
    let asked = asked.limits.as_ref().map_or_else(JobLimits::default, or_default);
    work.options.limits = core.options.maxima.capped(&asked);
    work
}

/// A priority from the wire; none = not given.
fn priority(number: i32) -> Result<Option<Priority>, Refusal> {
    match v1::JobPriority::try_from(number) {
        Ok(v1::JobPriority::Unspecified) => Ok(None),
        Ok(v1::JobPriority::Low) => Ok(Some(Priority::Low)),
        Ok(v1::JobPriority::Normal) => Ok(Some(Priority::Normal)),
        Ok(v1::JobPriority::High) => Ok(Some(Priority::High)),
        Err(_) => Err(Refusal::field("priority", format!("{number} is not a priority"))),
    }
}

fn deadline(ms: i64) -> Result<i64, Refusal> {
    if ms < 0 { Err(Refusal::field("deadline_ms", "must not be negative")) } else { Ok(ms) }
}

fn files(core: &Core, files: &[v1::FileRef]) -> Result<BTreeMap<String, String>, Refusal> {
    // Without files, the programs are refused.
    if !files.is_empty() {
        some_entries("files", files.len(), core.options.maxima.max_files, "max_files")?;
    }
    let mut found = BTreeMap::new();
    for (i, file) in files.iter().enumerate() {
        let field = format!("files[{i}]");
        if found.insert(file.path.clone(), file.digest.clone()).is_some() {
            return Err(Refusal::field(format!("{field}.path"), "is there twice"));
        }
    }
    Ok(found)
}

fn programs(
    core: &Core,
    programs: &[v1::Program],
    files: &BTreeMap<String, String>,
) -> Result<Vec<ProgramSelection>, Refusal> {
    some_entries("programs", programs.len(), core.options.maxima.max_programs, "max_programs")?;
    let one = |(i, program): (usize, &v1::Program)| {
        if !files.contains_key(&program.path) {
            return Err(Refusal::field(format!("programs[{i}].path"), "is not among the files of the job"));
        }
        let channel = program.channel.map(|c| small(&format!("programs[{i}].channel"), u64::from(c), 1, 9999));
        let section = program.section.clone();
        Ok(ProgramSelection {
            file: program.path.clone(),
            number: program.number,
            section,
            channel: channel.transpose()?,
        })
    };
    programs.iter().enumerate().map(one).collect()
}

/// A number between limits.
pub(super) fn small<T: TryFrom<u64>>(field: &str, value: u64, min: u64, max: u64) -> Result<T, Refusal> {
    let refuse = || Refusal::field(field, format!("must be {min} to {max}"));
    if !(min..=max).contains(&value) {
        return Err(refuse());
    }
    T::try_from(value).map_err(|_| refuse())
}

/// Options except for the limits.
fn options(options: v1::JobOptions) -> Result<JobOptions, Refusal> {
    let opskip = options.opskip.iter().map(|&level| small("options.opskip", u64::from(level), 0, 9));
    let [warnings_off, warnings_on] = warnings(options.warnings_off, options.warnings_on)?;
    let ignore = options.ignore_waits.iter().map(|&c| small("options.ignore_waits", u64::from(c), 1, 9999));
    Ok(JobOptions {
        opskip: opskip.collect::<Result<_, _>>()?,
        opstop: options.opstop,
        ignore_waits: ignore.collect::<Result<_, _>>()?,
        trace: options.trace,
        answers: options.answers.into_iter().map(answer).collect(),
        attended: options.attended,
        stepped: options.stepped,
        lint: options.lint,
        parameters: options.parameters,
        races: match v1::RaceCheck::try_from(options.races) {
            Ok(v1::RaceCheck::Unspecified) => RacePolicy::Off,
            Ok(v1::RaceCheck::Warn) => RacePolicy::Warn,
            Ok(v1::RaceCheck::Alarm) => RacePolicy::Alarm,
            Err(_) => return Err(Refusal::field("options.races", "is not a value of RaceCheck")),
        },
        timing: MoveTiming {
            model: match v1::TimeModel::try_from(options.time) {
                Ok(v1::TimeModel::Unspecified) => TimeModel::Full,
                Ok(v1::TimeModel::Simple) => TimeModel::Simple,
                Err(_) => return Err(Refusal::field("options.time", "is not a value of TimeModel")),
            },
            law: options.law,
        },
        threads: small("options.threads", u64::from(options.threads), 0, 1024)?,
        warnings_off,
        warnings_on,
        limits: JobLimits::default(),
    })
}

/// Warnings that are switched off and on; the numbers of errors are refused. Numbers that a machine defines are not
/// known here.
fn warnings(off: Vec<u32>, on: Vec<u32>) -> Result<[Vec<u32>; 2], Refusal> {
    let is_error = |number: &u32| diag::severity(*number).is_some_and(|severity| severity >= 8);
    for (field, numbers) in [("options.warnings_off", &off), ("options.warnings_on", &on)] {
        if let Some(number) = numbers.iter().find(|number| is_error(number)) {
            return Err(Refusal::field(field, format!("{number} is an error, which a job cannot switch")));
        }
    }
    if let Some(number) = off.iter().find(|number| on.contains(number)) {
        return Err(Refusal::field("options.warnings_off", format!("{number} is also in warnings_on")));
    }
    Ok([off, on])
}

/// An answer from the wire.
pub(super) fn answer(answer: v1::DialogAnswer) -> DialogAnswer {
    use v1::dialog_value::Value as Wire;
    let value = |value: v1::DialogValue| match value.value {
        Some(Wire::Flag(flag)) => DialogValue::Flag(flag),
        Some(Wire::Number(number)) => DialogValue::Number(number),
        Some(Wire::Text(text)) => DialogValue::Text(text),
        None => DialogValue::Text(String::new()),
    };
    DialogAnswer {
        dialog: answer.dialog,
        button: Some(answer.button).filter(|button| !button.is_empty()),
        values: answer.values.into_iter().map(|(name, v)| (name, value(v))).collect(),
    }
}

/// Limits that were requested, 0 = not given; none when none was given.
fn asked_limits(asked: &v1::JobLimits) -> Result<Option<JobLimits>, Refusal> {
    if asked.simulated_ns < 0 {
        return Err(Refusal::field("options.limits.simulated_ns", "must not be negative"));
    }
    let own = v1::JobLimits { wall_ms: 0, max_job_bytes: 0, ..*asked };
    let limits = JobLimits {
        simulated_ns: asked.simulated_ns,
        blocks: asked.blocks,
        zero_time_blocks: asked.zero_time_blocks,
        events: asked.events,
        block_length: asked.block_length as usize,
        nesting: u16::try_from(asked.nesting).unwrap_or(u16::MAX),
        diagnostics: asked.diagnostics,
        memory: asked.memory,
        macro_steps: asked.macro_steps,
    };
    Ok((own != v1::JobLimits::default()).then_some(limits))
}

/// Limits with the defaults for those that were not given.
fn or_default(asked: &JobLimits) -> JobLimits {
    fn or<T: Default + PartialEq>(value: T, default: T) -> T {
        if value == T::default() { default } else { value }
    }
    let default = JobLimits::default();
    JobLimits {
        simulated_ns: or(asked.simulated_ns, default.simulated_ns),
        blocks: or(asked.blocks, default.blocks),
        zero_time_blocks: or(asked.zero_time_blocks, default.zero_time_blocks),
        events: or(asked.events, default.events),
        block_length: or(asked.block_length, default.block_length),
        nesting: or(asked.nesting, default.nesting),
        diagnostics: or(asked.diagnostics, default.diagnostics),
        memory: or(asked.memory, default.memory),
        macro_steps: or(asked.macro_steps, default.macro_steps),
    }
    .capped()
}

/// The machine that a name means to a tenant, pinned to its revision.
pub(super) fn machine(core: &Core, tenant: &str, name: &str) -> Result<MachineRecord, Refusal> {
    // A ledger written by an older server may hold a machine under the name of a shipped one.
    if core.reserved(name) {
        return Ok(MachineRecord::shipped(name));
    }
    if let Some(definition) = core.ledger.machine(tenant, name)? {
        return Ok(definition);
    }
    if is_shipped(name) {
        return Ok(MachineRecord::shipped(name));
    }
    Err(unknown_machine(core, tenant, name)?)
}

/// Most machines that a refusal suggests.
const SUGGESTED: usize = 3;

/// The refusal of an unknown machine, with similar names.
pub(super) fn unknown_machine(core: &Core, tenant: &str, name: &str) -> Result<Refusal, Refusal> {
    let own = core.ledger.machines(tenant)?;
    let shipped = shipped().iter().map(String::as_str);
    let mut names: Vec<&str> = own.iter().map(|definition| definition.name.as_str()).chain(shipped).collect();
    names.sort_unstable();
    names.dedup();
    let near = similar(name.split('@').next().unwrap_or(name), &names, SUGGESTED);
    Ok(Refusal::UnknownMachine { name: name.to_owned(), near: near.into_iter().map(str::to_owned).collect() })
}

/// Digest of a client's request, without the request id and the deadline: a deadline that a client computes from a
/// duration differs when the request is repeated. It does not cover any settings of the server, and a field that the
/// client does not know counts as empty. So the same request has the same digest in every version.
fn content_of(request: &v1::SubmitJobRequest) -> String {
    let mut sent = v1::SubmitJobRequest { request_id: String::new(), deadline_ms: 0, ..request.clone() };
    sent.files.sort_by(|a, b| a.path.cmp(&b.path));
    if sent.priority == v1::JobPriority::Normal as i32 {
        sent.priority = 0;
    }
    let mut options = sent.options.take().unwrap_or_default();
    options.limits = options.limits.filter(|limits| *limits != v1::JobLimits::default());
    sent.options = Some(options).filter(|options| *options != v1::JobOptions::default());
    format!("{CONTENT}{}", digest(&sent.encode_to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_warnings_are_switched_and_only_one_way() {
        let asked = |off: &[u32], on: &[u32]| {
            let wire = v1::JobOptions { warnings_off: off.to_vec(), warnings_on: on.to_vec(), ..Default::default() };
            options(wire).map(|options| (options.warnings_off, options.warnings_on)).ok()
        };
        assert_eq!(asked(&[2_900_680], &[2_900_682]), Some((vec![2_900_680], vec![2_900_682])));
        assert_eq!(asked(&[77], &[]), Some((vec![77], Vec::new())), "a number of the machine's own");
        assert_eq!(asked(&[2_900_320], &[]), None, "an error");
        assert_eq!(asked(&[2_900_680], &[2_900_680]), None);
    }

    #[test]
    fn the_digest_of_a_content_covers_what_was_sent_and_nothing_else() {
        let file = |path: &str| v1::FileRef { path: path.into(), digest: "d".into() };
        let request = v1::SubmitJobRequest {
            request_id: "r".into(),
            machine: "m".into(),
            files: vec![file("a"), file("b")],
            ..Default::default()
        };
        let same = [
            v1::SubmitJobRequest { request_id: "s".into(), ..request.clone() },
            v1::SubmitJobRequest { files: vec![file("b"), file("a")], ..request.clone() },
            v1::SubmitJobRequest { priority: v1::JobPriority::Normal.into(), ..request.clone() },
            v1::SubmitJobRequest { deadline_ms: 1, ..request.clone() },
            v1::SubmitJobRequest {
                options: Some(v1::JobOptions { limits: Some(v1::JobLimits::default()), ..Default::default() }),
                ..request.clone()
            },
        ];
        for other in same {
            assert_eq!(content_of(&other), content_of(&request), "{other:?}");
        }
        let blocks = v1::JobLimits { blocks: JobLimits::default().blocks, ..Default::default() };
        let different = [
            v1::SubmitJobRequest { labels: [("k".to_owned(), "v".to_owned())].into(), ..request.clone() },
            v1::SubmitJobRequest { priority: v1::JobPriority::High.into(), ..request.clone() },
            // A default may change: asking for it is not the same as leaving it to the server.
            v1::SubmitJobRequest {
                options: Some(v1::JobOptions { limits: Some(blocks), ..Default::default() }),
                ..request.clone()
            },
        ];
        for other in different {
            assert_ne!(content_of(&other), content_of(&request), "{other:?}");
        }
        // It must never change: ledgers hold it.
        assert_eq!(content_of(&request), "2:76f703040c740938b71112af4cca35c46ac088d608840e68485a61409f2931b7");
    }
}
