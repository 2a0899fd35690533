//! All commands but `run` and `submit`.

use std::path::Path;

use counterpoint_client::Update;
use counterpoint_proto::v1;

use crate::arguments::{CliCommand, Follow, JobArgs, OutputFormat, ResultArgs, ResultKind, WaitArgs, WatchArgs};
use crate::attend::{AttendEvent, Attendant};
use crate::client::ServerSession;
use crate::error::Error;
use crate::event_line::event_line;
use crate::job_status::{held, json_line, waits};
use crate::many::JobAction;
use crate::outcome::{ended, ended_by_name};
use crate::output_folder::{OutputFolder, drawn_timeline};
use crate::progress::ProgressDisplay;
use crate::report::report;
use crate::step::{Interrupt, StepClient};
use crate::summary::ReportSummary;
use crate::watch_all::watch_all;
use crate::{
    admin, analyse, calibrate, completions, draft, explain, instant, job_names, jobs, lint, load, machines, macros,
    man, many, results, run, say, status,
};

/// Executes a command and returns the exit code.
pub(crate) async fn dispatch(command: CliCommand) -> Result<u8, Error> {
    match command {
        CliCommand::Run(arguments) => run::run(arguments).await,
        CliCommand::Calibrate(arguments) => calibrate::calibrate(&arguments),
        CliCommand::Lint(arguments) => lint::lint(arguments).await,
        CliCommand::Submit(arguments) => run::submit(arguments).await,
        CliCommand::Watch(WatchArgs { job: Some(job), remote, quiet, strict, .. }) => {
            watch(Follow { of: JobArgs { job, remote, quiet }, strict }).await
        }
        CliCommand::Watch(arguments) => watch_all(arguments).await,
        CliCommand::Attend(arguments) => attend(arguments).await,
        CliCommand::Step(arguments) => step(arguments).await,
        CliCommand::Wait(arguments) => wait(arguments).await,
        CliCommand::Jobs(arguments) => jobs::list(arguments).await,
        CliCommand::Status(arguments) => status::status(arguments).await,
        CliCommand::Rerun(arguments) => jobs::rerun(arguments).await,
        CliCommand::Cancel(arguments) => many::act(JobAction::Cancel, arguments).await,
        CliCommand::Pause(arguments) => pause(arguments).await,
        CliCommand::Resume(arguments) => resume(arguments).await,
        CliCommand::Delete(arguments) => many::act(JobAction::Delete, arguments).await,
        CliCommand::Analyse(arguments) => analyse::analyse(arguments).await,
        CliCommand::At(arguments) => instant::at(arguments).await,
        CliCommand::Where(arguments) => instant::times(arguments).await,
        CliCommand::Result(arguments) => result(arguments).await,
        CliCommand::Admin(command) => admin::dispatch(command).await,
        CliCommand::Load(arguments) => load::load(arguments).await,
        CliCommand::Machine(arguments) => machines::dispatch(arguments).await,
        CliCommand::Macro(command) => macros::dispatch(&command),
        CliCommand::Explain(arguments) => explain::explain(&arguments),
        CliCommand::Man { folder: Some(folder) } => man::write(&folder),
        CliCommand::Man { folder: None } => man::print(),
        CliCommand::Completions { shell } => {
            say::data(completions::script(shell).as_bytes())?;
            Ok(0)
        }
    }
}

/// A client of the server of a job, and the whole id of the job.
async fn connected(arguments: &JobArgs) -> Result<(ServerSession, String), Error> {
    let client = ServerSession::connect_as(&arguments.remote.server, arguments.quiet).await?;
    let job = job_names::whole(&client, &arguments.job).await?;
    Ok((client, job))
}

/// Follows a job, reconnecting if necessary; prints diagnostics and waits to standard output.
async fn watch(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let (client, job) = connected(&arguments).await?;
    let mut progress = ProgressDisplay::new(arguments.quiet);
    let mut watch = client.watch(&job, v1::WatchLevel::Diagnostics);
    let (mut files, mut said) = (Vec::new(), None);
    let now = client.jobs().get_job(v1::GetJobRequest { job_id: job.clone() }).await?.into_inner().status;
    if let Some(reason) = now.as_ref().and_then(waits) {
        progress.note(&reason);
    }
    loop {
        match watch.next().await.map_err(|error| Error::from(error).of_job(&job))? {
            Update::Events(batch) => {
                for line in batch.events.iter().filter_map(|event| event_line(event, &files)) {
                    say::data(line.as_bytes())?;
                }
            }
            Update::Progress(now) => {
                progress.show(&now);
                let held = held(&job, now.operator_wait.as_ref(), now.paused);
                if held != said {
                    held.iter().for_each(|held| progress.note(held));
                    said = held;
                }
            }
            Update::Ended(status) => {
                progress.clear();
                return Ok(ended(&status, strict));
            }
            Update::Description(description) => files = description.files,
        }
    }
}

/// Answers the questions of a job until it ends.
async fn attend(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let (client, job) = connected(&arguments).await?;
    let mut attendant = Attendant::start(&client, &job).await?;
    loop {
        match attendant.next().await? {
            AttendEvent::Question(question) => attendant.answer(question).await?,
            AttendEvent::Ended(status) => return Ok(ended(&status, strict)),
        }
    }
}

/// Steps through a job until it ends; an interrupt pauses a running job, and ends the command if it stands.
async fn step(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let (client, job) = connected(&arguments).await?;
    let (stepper, interrupt) = (StepClient::start(&client, &job).await?, Interrupt::default());
    let mut driven = std::pin::pin!(stepper.drive(&interrupt));
    loop {
        tokio::select! {
            status = &mut driven => return Ok(ended(&status?, strict)),
            _ = tokio::signal::ctrl_c() => if !interrupt.pause() {
                return Err(Error::Connection("interrupted".to_owned()));
            },
        }
    }
}

/// Waits for jobs, one after another; returns the highest exit code.
async fn wait(arguments: WaitArgs) -> Result<u8, Error> {
    let client = ServerSession::connect_as(&arguments.remote.server, arguments.quiet).await?;
    let WaitArgs { quiet, strict, json, .. } = arguments;
    let mut code = 0;
    for job in &jobs::to_wait_for(&client, &arguments).await? {
        let mut said = None;
        let say_held = |status: &v1::JobStatus| {
            let queued = waits(status);
            let kind = (status.paused, status.operator_wait.map(|wait| wait.action), queued.clone());
            if !quiet && said.as_ref() != Some(&kind) {
                let held = held(job, status.operator_wait.as_ref(), status.paused).or(queued);
                held.iter().for_each(|held| say::status_line(format!("{job}  {held}")));
                said = Some(kind);
            }
        };
        let status = client.wait(job, say_held).await.map_err(|error| error.of_job(job))?;
        if json {
            say::verdict(json_line(&status).as_bytes())?;
        }
        code = code.max(ended_by_name(&status, strict, quiet));
    }
    Ok(code)
}

async fn pause(arguments: JobArgs) -> Result<u8, Error> {
    let (client, job_id) = connected(&arguments).await?;
    jobs::say_ended(&client, &job_id).await?;
    client.jobs().pause_job(v1::PauseJobRequest { job_id }).await?;
    Ok(0)
}

async fn resume(arguments: JobArgs) -> Result<u8, Error> {
    let (client, job_id) = connected(&arguments).await?;
    jobs::say_ended(&client, &job_id).await?;
    client.jobs().resume_job(v1::ResumeJobRequest { job_id }).await?;
    Ok(0)
}

/// The summary of a job, as it came and as far as reports need it.
async fn summary(client: &ServerSession, job: &str) -> Result<(Vec<u8>, ReportSummary), Error> {
    let text = results::whole(client, job, ResultKind::Summary, 0, OutputFormat::Json.into()).await?;
    let summary = serde_json::from_slice(&text)
        .map_err(|error| Error::Connection(format!("cannot read the summary: {error}")))?;
    Ok((text, summary))
}

/// The line about a job at the start of its report.
async fn heading(client: &ServerSession, job: &str) -> Result<String, Error> {
    let request = v1::GetJobRequest { job_id: job.to_owned() };
    let status = client.jobs().get_job(request).await?.into_inner().status.unwrap_or_default();
    Ok(status::heading(&status))
}

/// The report that `run` prints.
async fn reported(client: &ServerSession, job: &str) -> Result<String, Error> {
    let summary = match summary(client, job).await {
        Ok((_, summary)) => summary,
        Err(error) => return Err(without_results(client, job, error).await),
    };
    Ok(heading(client, job).await? + &report(&summary, false) + &drawn_timeline(client, job, run::width()).await?)
}

/// Adds to a refusal the reason why the job has no results.
async fn without_results(client: &ServerSession, job: &str, error: Error) -> Error {
    if error.reason().as_deref() != Some("NO_RESULTS") {
        return error;
    }
    let request = v1::GetJobRequest { job_id: job.to_owned() };
    let Ok(answer) = client.jobs().get_job(request).await else { return error };
    let status = answer.into_inner().status.unwrap_or_default();
    match [status.error, status.verdict].into_iter().find(|reason| !reason.is_empty()) {
        Some(reason) => Error::Usage(format!("{error}: {reason}")),
        None => error,
    }
}

/// Writes all results into a folder, as `run --out` does, and the report.
async fn all(client: &ServerSession, job: &str, folder: &Path, crlf: bool) -> Result<(), Error> {
    let (text, summary) = summary(client, job).await?;
    let program = summary.channels.iter().map(|channel| channel.program.as_str()).find(|name| !name.is_empty());
    let file = program.unwrap_or("job").split('#').next().unwrap_or("job");
    let wanted = |what| what != ResultKind::Trace;
    let heading = heading(client, job).await?;
    let target = OutputFolder { folder, program: file, heading, wanted: &wanted, crlf };
    target.write(client, job, (&summary, &text), false).await
}

/// Whether a job was submitted with a trace.
async fn is_traced(client: &ServerSession, job: &str) -> Result<bool, Error> {
    let request = v1::GetJobRequest { job_id: job.to_owned() };
    let options = client.jobs().get_job(request).await?.into_inner().options.unwrap_or_default();
    Ok(!options.trace.is_empty())
}

async fn result(arguments: ResultArgs) -> Result<u8, Error> {
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let ResultArgs { what, channel, format, crlf, .. } = &arguments;
    let job = &job_names::whole(&client, &arguments.job).await?;
    let form = results::ResultFormat { format: *format, crlf: *crlf };
    if *what == ResultKind::Trace && !is_traced(&client, job).await? {
        say::status_line("the job was submitted without --trace: this is the listing");
    }
    match (what, &arguments.output) {
        (ResultKind::Report, output) => {
            let text = reported(&client, job).await?;
            match output {
                Some(path) => draft::write(path, say::plain(&text).as_bytes())?,
                None => say::data(text.as_bytes())?,
            }
        }
        (ResultKind::All, Some(folder)) => all(&client, job, folder, *crlf).await?,
        (ResultKind::All, None) => {
            return Err(Error::Usage("name the folder for all results with --output DIR".to_owned()));
        }
        (_, Some(path)) => results::file(&client, job, *what, *channel, form, path).await?,
        (_, None) => results::each(&client, job, *what, *channel, form, &mut say::data).await?,
    }
    Ok(0)
}
