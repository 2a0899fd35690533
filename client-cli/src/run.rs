//! `run` and `submit`: pack, upload, submit; `run` then watches and reports.

use std::cell::{Cell, RefCell};
use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::path::Path;

use counterpoint_client::{Blob, Update};
use counterpoint_proto::v1;

use crate::arguments::{ExitCodes, Inputs, OutputFormat, RaceCheck, ResultKind, RunArgs, Submit, Timing};
use crate::attend::{AttendEvent, Attendant};
use crate::client::{RequestedResults, ServerSession, SubmittedJob};
use crate::codes::{self, FailureStage};
use crate::error::Error;
use crate::json_summary::with_remedies;
use crate::local_machine::LocalMachine;
use crate::numbered::Computed;
use crate::outcome::{exit_code, not_run};
use crate::output_folder::{OutputFolder, drawn_timeline};
use crate::problems::say_errors;
use crate::progress::ProgressDisplay;
use crate::report::report;
use crate::say::{self, DIM, styled};
use crate::settings::{self, MachineSetting};
use crate::step::{Interrupt, StepClient};
use crate::summary::ReportSummary;
use crate::{changed_machine, guess, jobs, known, machine_folder, machines, pack, results};

/// Runs programs on a server in this process.
pub(crate) async fn run(arguments: RunArgs) -> Result<u8, Error> {
    let (severity, strict) = (arguments.exit_code == ExitCodes::Severity, arguments.strict);
    match carry_out(arguments).await {
        Ok((status, _)) if severity => Ok(codes::of_job(&status)),
        Ok((status, plain)) => Ok(plain.unwrap_or_else(|| exit_code(&status, strict))),
        Err((_, error @ Error::Closed)) => Err(error),
        Err((stage, error)) if severity => {
            say::error(&error);
            Ok(codes::of_error(stage, &error))
        }
        Err((_, error)) => Err(error),
    }
}

/// Runs the job; returns how it ended, and the plain exit code if it could not be run.
async fn carry_out(arguments: RunArgs) -> Result<(v1::JobStatus, Option<u8>), (FailureStage, Error)> {
    let at = |stage: FailureStage| move |error: Error| (stage, error);
    if arguments.inputs.operator.step && (arguments.inputs.operator.attend || arguments.json || arguments.quiet) {
        let text = "--step reads standard input and writes stops to standard output: it goes without --attend, --json and --quiet";
        return Err((FailureStage::Programs, Error::Usage(text.to_owned())));
    }
    if arguments.inputs.timing.law && arguments.out.is_none() {
        let text = "--law records laws in the events, which are written to a folder: add --out DIR";
        return Err((FailureStage::Programs, Error::Usage(text.to_owned())));
    }
    let piped = pack::reads_standard_input(&arguments.inputs.programs);
    if piped && (arguments.inputs.operator.step || arguments.inputs.operator.attend) {
        let text = "--step and --attend read standard input, which is a program here (-): give the program as a file";
        return Err((FailureStage::Programs, Error::Usage(text.to_owned())));
    }
    let pack = pack::job(&arguments.inputs).map_err(at(FailureStage::Programs))?;
    let draws = !arguments.no_timeline && !arguments.quiet && !arguments.json;
    let embedded =
        ServerSession::embed(asked(&arguments), arguments.allow_system, arguments.inputs.operator.step).await;
    let client = embedded.map_err(at(FailureStage::Submission))?;
    let name = machine(&client, &arguments.inputs, &pack, arguments.quiet).await.map_err(at(FailureStage::Machine))?;
    let first = pack.programs.first().map(|p| p.path.clone()).unwrap_or_default();
    let request = v1::SubmitJobRequest { request_id: counterpoint_client::request_id(), ..Default::default() };
    let stepped = arguments.inputs.operator.step;
    let person = !stepped && !piped && std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    let attended = arguments.inputs.operator.attend || person && !arguments.quiet && !arguments.json;
    let job =
        submit_pack(&client, &arguments.inputs, pack, name, Submission { request, attended, ..Submission::default() })
            .await;
    let job = job.map_err(at(FailureStage::Submission))?.job;
    let status =
        follow(&client, &job, (arguments.quiet, attended, stepped)).await.map_err(at(FailureStage::Submission))?;
    if let Some(code) = not_run(&status) {
        return Ok((status, Some(code)));
    }
    show(&arguments, &client, &job, (&first, draws)).await.map_err(at(FailureStage::Results))?;
    Ok((status, None))
}

/// The results requested after the run.
fn asked(arguments: &RunArgs) -> RequestedResults {
    let wanted = |what| arguments.out.is_some() && arguments.wants(what);
    let trace = wanted(ResultKind::Trace) && !arguments.inputs.trace.is_empty();
    let read = [ResultKind::Listing, ResultKind::Events, ResultKind::Log, ResultKind::Console];
    RequestedResults { log: trace || read.into_iter().any(wanted), toolpath: wanted(ResultKind::Toolpath) }
}

/// Writes the results of an ended job into the folder and prints the report.
async fn show(
    arguments: &RunArgs,
    client: &ServerSession,
    job: &str,
    (first, draws): (&str, bool),
) -> Result<(), Error> {
    let text = results::whole(client, job, ResultKind::Summary, 0, OutputFormat::Json.into()).await?;
    let summary: ReportSummary = serde_json::from_slice(&text)
        .map_err(|error| Error::Connection(format!("cannot read the summary: {error}")))?;
    if let Some(folder) = &arguments.out {
        let traced = !arguments.inputs.trace.is_empty();
        let wanted = |what| arguments.wants(what) && (what != ResultKind::Trace || traced);
        let heading = String::new();
        let target = OutputFolder { folder, program: first, heading, wanted: &wanted, crlf: arguments.crlf };
        target.write(client, job, (&summary, &text), arguments.quiet).await?;
    }
    if arguments.json {
        say::verdict(&with_remedies(&text))?;
    } else if arguments.quiet {
        say_errors(summary, arguments.strict);
    } else {
        let mut out = report(&summary, arguments.verbose);
        files_report(&mut out, &client.files(job).await?, arguments.out.is_some());
        if draws {
            out.push_str(&drawn_timeline(client, job, width()).await?);
        }
        say::verdict(out.as_bytes())?;
    }
    Ok(())
}

/// Lists the files that macros have written.
fn files_report(out: &mut String, files: &[v1::WrittenFile], kept: bool) {
    if files.is_empty() {
        return;
    }
    let hint = if kept { "" } else { " (use --out DIR to keep them)" };
    let _ = writeln!(out, "\nfiles written{hint}");
    for v1::WrittenFile { path, size } in files {
        let _ = writeln!(out, "  {path}, {size} bytes");
    }
}

/// Submits programs to a server.
pub(crate) async fn submit(arguments: Submit) -> Result<u8, Error> {
    jobs::check_deadline(&arguments.request)?;
    if arguments.each {
        return submit_each(arguments).await;
    }
    let pack = pack::job(&arguments.inputs)?;
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let name = machine(&client, &arguments.inputs, &pack, false).await?;
    let submission = submission(&arguments, jobs::request(&arguments.request));
    let job = submit_pack(&client, &arguments.inputs, pack, name, submission).await?;
    jobs::say_id(&job, arguments.json)?;
    Ok(0)
}

/// Submits one of several programs. While the server has no room for the job, the program waits.
async fn submit_next(
    client: &ServerSession,
    arguments: &Submit,
    request: v1::SubmitJobRequest,
    program: &str,
) -> Result<SubmittedJob, Error> {
    let inputs = &arguments.inputs;
    let mut pack = pack::job(inputs)?;
    let name = machine(client, inputs, &pack, false).await?;
    let mut waits = false;
    loop {
        let submission = submission(arguments, request.clone());
        let error = match submit_pack(client, inputs, pack, name.clone(), submission).await {
            Err(error) => error,
            done => return done,
        };
        let Some(pause) = error.until_room().filter(|_| !arguments.no_wait) else { return Err(error) };
        if !waits {
            say::status_line(styled(DIM, format!("{program} waits: {error}")));
            waits = true;
        }
        tokio::time::sleep(pause).await;
        pack = pack::job(inputs)?;
    }
}

/// How the programs of `submit` are submitted.
fn submission(arguments: &Submit, request: v1::SubmitJobRequest) -> Submission {
    let (attended, no_cache) = (arguments.inputs.operator.attend, arguments.no_cache);
    Submission { request, attended, no_cache, ..Submission::default() }
}

/// Submits each program as a job. A program that cannot be submitted is reported, and the others are submitted; the exit
/// code is the highest. Without a connection nothing else can be submitted.
async fn submit_each(mut arguments: Submit) -> Result<u8, Error> {
    let (mut submitted, all) = (0, arguments.inputs.programs.len());
    let done = submit_all(&mut arguments, &mut submitted).await;
    if submitted < all {
        say::status_line(format!("{submitted} of {all} submitted"));
    }
    done
}

async fn submit_all(arguments: &mut Submit, count: &mut usize) -> Result<u8, Error> {
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let id = jobs::request(&arguments.request).request_id;
    let mut code = 0;
    for (number, program) in (1..).zip(std::mem::take(&mut arguments.inputs.programs)) {
        // The ids are the same when the command is repeated with its id.
        let request =
            v1::SubmitJobRequest { request_id: format!("{id}-{number}"), ..jobs::request(&arguments.request) };
        arguments.inputs.programs = vec![program.clone()];
        let done = submit_next(&client, arguments, request, &program).await;
        *count += usize::from(done.is_ok());
        match done {
            Ok(submitted) if arguments.json => {
                jobs::say_notes(&submitted);
                let SubmittedJob { job, duplicate, .. } = submitted;
                let mut line = serde_json::json!({ "job": job, "program": program });
                if let (true, Some(fields)) = (duplicate, line.as_object_mut()) {
                    fields.insert("duplicate".to_owned(), true.into());
                }
                say::data(format!("{line}\n").as_bytes())?;
            }
            Ok(submitted) => jobs::say_id(&submitted, false)?,
            Err(error @ Error::Connection(_)) => return Err(error),
            Err(error) => {
                say::status_line(format!("{program}: not submitted"));
                say::error(&error);
                code = code.max(error.code());
                if arguments.json {
                    let reason = error.reason();
                    let object =
                        serde_json::json!({ "program": program, "error": error.to_string(), "reason": reason });
                    say::data(format!("{object}\n").as_bytes())?;
                }
            }
        }
    }
    Ok(code)
}

/// The machine to run on; one of a folder, or one with other data, is uploaded first.
pub(crate) async fn machine(
    client: &ServerSession,
    inputs: &Inputs,
    pack: &pack::Pack,
    quiet: bool,
) -> Result<String, Error> {
    let Some(machine) = &inputs.on.machine else {
        let guess = guess::machine(pack, settings::waits(&inputs.on.set).as_ref())?;
        if !quiet {
            let unit = guess::unit(&guess.machine, pack, &inputs.on.set).map(|unit| format!("; {unit}"));
            let text = format!(
                "machine {}, guessed from {}; use --machine to choose another{}",
                guess.machine,
                guess.why,
                unit.unwrap_or_default()
            );
            say::status_line(styled(DIM, text));
        }
        return changed(client, &guess.machine, inputs, quiet).await;
    };
    match machine_folder::is_folder(machine) {
        false => known::machine(machine, client.is_embedded())?,
        true if !quiet && !machine.contains(['/', '\\']) && !client.is_embedded() => say::status_line(styled(
            DIM,
            format!("machine from the folder '{machine}' here; it takes precedence over a machine of this name"),
        )),
        true => {}
    }
    changed(client, machine, inputs, quiet).await
}

/// The machine itself, or, with settings or a table of tools, a revision of it that has them.
async fn changed(client: &ServerSession, machine: &str, inputs: &Inputs, quiet: bool) -> Result<String, Error> {
    let folder = machine_folder::is_folder(machine);
    // Settings of warnings are options of the job.
    let of_machine = |setting: &&MachineSetting| !matches!(setting, MachineSetting::Warning(..));
    let set: Vec<MachineSetting> = inputs.on.set.iter().filter(of_machine).cloned().collect();
    let (name, files) = match (set.as_slice(), folder) {
        ([], false) => (machine.to_owned(), pack::PackedFiles::default()),
        ([], true) => machine_folder::machine(Path::new(machine))?,
        (set, _) => changed_machine::machine(machine, set)?,
    };
    match &inputs.on.tools {
        None if files.0.is_empty() => Ok(name),
        None => machines::put_files(client, name, files, None).await,
        Some(path) => {
            let (name, files, tools) = changed_machine::with_tools(&name, files, path)?;
            if let Some(note) = tools.note.as_deref().filter(|_| !quiet) {
                say::status_line(styled(DIM, note));
            }
            machines::put_files(client, name, files, Some(&tools)).await
        }
    }
}

/// How a job is submitted.
#[derive(Default)]
pub(crate) struct Submission {
    pub(crate) request: v1::SubmitJobRequest,
    /// Whether an operator answers its dialogs.
    pub(crate) attended: bool,
    /// It is judged without being run.
    pub(crate) lint: bool,
    /// It runs even if the results of an equal job are there.
    pub(crate) no_cache: bool,
}

pub(crate) async fn submit_pack(
    client: &ServerSession,
    inputs: &Inputs,
    pack: pack::Pack,
    machine: String,
    Submission { request, attended, lint, no_cache }: Submission,
) -> Result<SubmittedJob, Error> {
    let answers = inputs.answers.as_deref().map(crate::answers::read).transpose()?.unwrap_or_default();
    // Every machine accepts one program, so the machine of a job with one program is not checked.
    let several = pack.programs.len() > 1 && !client.is_embedded();
    if let Some(machine) = inputs.on.machine.as_deref().filter(|_| several) {
        check_channels(machine, pack.programs.len())?;
    }
    let (count, computed) = (pack.files.0.len(), pack.computed);
    client.upload(&pack.files.blobs()).await.map_err(|error| too_large(error, &pack.files))?;
    let file = |(path, blob): (String, Blob)| v1::FileRef { path, digest: blob.digest().to_owned() };
    let request = v1::SubmitJobRequest {
        machine,
        programs: pack.programs,
        files: pack.files.0.into_iter().map(file).collect(),
        options: Some(v1::JobOptions {
            opskip: inputs.switches.opskip.0.clone(),
            opstop: inputs.switches.opstop,
            trace: inputs.trace.clone(),
            parameters: inputs.param.clone(),
            answers,
            attended,
            stepped: inputs.operator.step,
            ignore_waits: inputs.ignore_waits.clone(),
            threads: inputs.threads,
            races: match inputs.races {
                RaceCheck::Off => v1::RaceCheck::Unspecified,
                RaceCheck::Warn => v1::RaceCheck::Warn,
                RaceCheck::Alarm => v1::RaceCheck::Alarm,
            } as i32,
            time: match inputs.timing.time {
                Timing::Full => v1::TimeModel::Unspecified,
                Timing::Simple => v1::TimeModel::Simple,
            } as i32,
            limits: limits(inputs),
            lint,
            law: inputs.timing.law,
            warnings_off: settings::warnings(&inputs.on.set, false),
            warnings_on: settings::warnings(&inputs.on.set, true),
            no_cache,
        }),
        ..request
    };
    client.submit(request).await.map_err(|error| too_many(error, count, computed))
}

/// Refuses more programs than the machine has channels, if the machine is known here.
fn check_channels(machine: &str, programs: usize) -> Result<(), Error> {
    // Without an own definition the server decides.
    let Ok(known) = LocalMachine::open(machine).and_then(|local| local.load()) else { return Ok(()) };
    let channels = known.channels.len();
    if programs > channels.max(1) {
        let plural = if channels == 1 { "" } else { "s" };
        return Err(Error::Usage(format!(
            "machine {machine} has {channels} channel{plural}, but the job has {programs} programs: name at most one for \
             each channel, or submit each program as a job of its own with --each"
        )));
    }
    Ok(())
}

/// Names the largest file in the refusal of a blob that is too large.
fn too_large(error: Error, files: &pack::PackedFiles) -> Error {
    let largest = files.0.iter().max_by_key(|(_, blob)| blob.content().len());
    match largest {
        Some((name, blob)) if error.reason().as_deref() == Some("BLOB_TOO_LARGE") => {
            Error::Usage(format!("'{name}' has {} bytes: {error}", blob.content().len()))
        }
        _ => error,
    }
}

/// Explains the number of files in the refusal of a server that does not accept that many.
fn too_many(error: Error, count: usize, computed: Option<Computed>) -> Error {
    let (true, Some(Computed { file, line, files })) = (error.is_about("files"), computed) else { return error };
    Error::Usage(format!(
        "the job has {count} files, more than the server accepts: {files} of them, named O and digits, were added \
         because line {line} of '{file}' computes the number of the program that it calls; name the files that it \
         calls with --with, and add --no-neighbours"
    ))
}

/// Follows a job to its end; the first interrupt cancels the job, the second ends the command. One that is stepped
/// through and runs is paused instead.
pub(crate) async fn follow(
    client: &ServerSession,
    job: &str,
    (quiet, attended, stepped): (bool, bool, bool),
) -> Result<v1::JobStatus, Error> {
    let mut watch = client.watch(job, v1::WatchLevel::Progress);
    let progress = RefCell::new(ProgressDisplay::new(quiet || stepped));
    let asking = Cell::new(false);
    let attendant = if attended { Some(Attendant::start(client, job).await?) } else { None };
    let interrupt = Interrupt::default();
    let stepper = if stepped { Some(StepClient::start(client, job).await?) } else { None };
    let mut stepping = std::pin::pin!(step(stepper, &interrupt));
    let mut attending = std::pin::pin!(attend(attendant, &progress, &asking));
    let mut interrupts = 0;
    loop {
        tokio::select! {
            // Ends with an error only: the watch reports the end of the job.
            Err(error) = &mut attending => return Err(error),
            Err(error) = &mut stepping => return Err(error),
            update = watch.next() => match update? {
                Update::Progress(_) if asking.get() => {}
                Update::Progress(now) => progress.borrow_mut().show(&now),
                Update::Ended(status) => {
                    progress.borrow_mut().clear();
                    return Ok(*status);
                }
                Update::Description(_) | Update::Events(_) => {}
            },
            signal = tokio::signal::ctrl_c(), if interrupts < 2 => {
                if signal.is_ok() && interrupt.pause() {
                    continue;
                }
                interrupts += 1;
                if signal.is_err() || interrupts == 2 {
                    return Err(Error::Connection("interrupted".to_owned()));
                }
                client.jobs().cancel_job(v1::CancelJobRequest { job_id: job.to_owned() }).await?;
            }
        }
    }
}

/// Executes the commands of the operator who steps through the job; the watch reports its end.
async fn step(stepper: Option<StepClient>, interrupt: &Interrupt) -> Result<std::convert::Infallible, Error> {
    if let Some(stepper) = stepper {
        stepper.drive(interrupt).await?;
    }
    std::future::pending().await
}

/// Answers all questions; hides the progress bars while a question is open.
async fn attend(
    attendant: Option<Attendant>,
    progress: &RefCell<ProgressDisplay>,
    asking: &Cell<bool>,
) -> Result<std::convert::Infallible, Error> {
    let Some(mut attendant) = attendant else { return std::future::pending().await };
    loop {
        let AttendEvent::Question(question) = attendant.next().await? else { return std::future::pending().await };
        asking.set(true);
        progress.borrow_mut().clear();
        attendant.answer(question).await?;
        asking.set(false);
    }
}

/// Limits given on the command line; zero leaves a limit to the server.
fn limits(inputs: &Inputs) -> Option<v1::JobLimits> {
    let limits = v1::JobLimits {
        simulated_ns: inputs.max_time.map_or(0, |seconds| (seconds * 1e9) as i64),
        blocks: inputs.max_blocks.unwrap_or(0),
        memory: inputs.max_memory.map_or(0, |mebibytes| mebibytes.saturating_mul(1 << 20)),
        ..v1::JobLimits::default()
    };
    (limits != v1::JobLimits::default()).then_some(limits)
}
/// Columns of the terminal.
pub(crate) fn width() -> usize {
    let columns = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let (_, terminal) = console::Term::stdout().size_checked().unwrap_or((0, 100));
    columns.unwrap_or(usize::from(terminal))
}
