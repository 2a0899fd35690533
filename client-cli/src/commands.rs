//! All commands but `run` and `submit`.

use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::event::Kind;
use counterpoint_proto::v1::watch_job_response::Content;
use tonic::Code;

use crate::arguments::{Command, Follow, JobArgs, ResultArgs, Watch};
use crate::attend::{Attendant, Next};
use crate::client::Client;
use crate::error::Error;
use crate::outcome::ended;
use crate::progress::Progress;
use crate::text::time;
use crate::{completions, jobs, machines, macros, results, run, say};

/// How often a broken watch is resumed.
pub(crate) const RETRIES: u32 = 8;

/// Carries out a command; gives the exit code.
pub(crate) async fn dispatch(command: Command) -> Result<u8, Error> {
    match command {
        Command::Run(arguments) => run::run(arguments).await,
        Command::Submit(arguments) => run::submit(arguments).await,
        Command::Watch(Watch { job: Some(job), remote, quiet, strict, .. }) => {
            watch(Follow { of: JobArgs { job, remote, quiet }, strict }).await
        }
        Command::Watch(arguments) => jobs::watch(arguments).await,
        Command::Attend(arguments) => attend(arguments).await,
        Command::Wait(arguments) => wait(arguments).await,
        Command::Jobs(arguments) => jobs::list(arguments).await,
        Command::Rerun(arguments) => jobs::rerun(arguments).await,
        Command::Cancel(arguments) => cancel(arguments).await,
        Command::Delete(arguments) => delete(arguments).await,
        Command::Result(arguments) => result(arguments).await,
        Command::Machine(arguments) => machines::dispatch(arguments).await,
        Command::Macro(command) => macros::dispatch(&command),
        Command::Explain { what } => macros::explain(&what),
        Command::Completions { shell } => {
            say::data(completions::script(shell).as_bytes())?;
            Ok(0)
        }
    }
}

/// Follows a job, over broken connections too: diagnostics and waits on standard output.
async fn watch(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let mut progress = Progress::new(arguments.quiet);
    let (mut cursor, mut failures) = (0, 0);
    // A connection that breaks is resumed; a server that never answered is a mistake of the command line.
    drop(Client::connect(&arguments.remote.server).await?);
    loop {
        match watch_once(&arguments, &mut cursor, &mut progress, &mut failures).await {
            Ok(status) => {
                progress.clear();
                return Ok(ended(&status, strict));
            }
            Err(Error::Refused(status)) if status.code() != Code::Unavailable && status.code() != Code::Unknown => {
                return Err(Error::Refused(status));
            }
            Err(Error::Closed) => return Err(Error::Closed),
            Err(error) if failures >= RETRIES => return Err(error),
            Err(_) => {
                failures += 1;
                tokio::time::sleep(Duration::from_millis(100 << failures.min(6))).await;
            }
        }
    }
}

async fn watch_once(
    arguments: &JobArgs,
    cursor: &mut u64,
    progress: &mut Progress,
    failures: &mut u32,
) -> Result<v1::JobStatus, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let level = v1::WatchLevel::Diagnostics.into();
    let request = v1::WatchJobRequest { job_id: arguments.job.clone(), after_seq: *cursor, level, heartbeat_ms: 0 };
    let mut stream = client.jobs().watch_job(request).await?.into_inner();
    while let Some(message) = stream.message().await? {
        *failures = 0;
        match message.content {
            Some(Content::Batch(batch)) => {
                for line in batch.events.iter().filter_map(line) {
                    say::data(line.as_bytes())?;
                }
                *cursor = batch.last_seq;
            }
            Some(Content::Progress(now)) => progress.show(&now),
            Some(Content::Ended(status)) => return Ok(status),
            Some(Content::Description(_)) | None => {}
        }
    }
    Err(Error::Connection("the server ended the stream".to_owned()))
}

/// An event as a line, when it is for people.
fn line(event: &v1::Event) -> Option<String> {
    let text = match event.kind.as_ref()? {
        Kind::Diagnostic(d) => {
            let origin = d.origin.as_ref().map(|o| format!(" ({}:{})", o.file, o.line)).unwrap_or_default();
            format!("{} {} {}{origin}", d.number, d.severity, d.text)
        }
        Kind::Verdict(v) => format!("verdict {}", v.text),
        Kind::Message(m) => format!("message {}", m.text),
        Kind::Wait(w) => format!("waits for {}", w.key),
        Kind::Release(r) => format!("continues after {}, waited {}", r.key, time(event.t_ns - r.since_ns)),
        Kind::Lifecycle(l) => l.phase().as_str_name().trim_start_matches("PHASE_").to_lowercase(),
        _ => return None,
    };
    let channel = if event.channel > 0 { format!(" channel {}", event.channel) } else { String::new() };
    let line = if event.line > 0 { format!(" line {}", event.line) } else { String::new() };
    Some(format!("{}{channel}{line}: {text}\n", time(event.t_ns)))
}

/// Answers the questions of a job until it ends.
async fn attend(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let mut attendant = Attendant::start(&client, &arguments.job).await?;
    loop {
        match attendant.next().await? {
            Next::Question(question) => attendant.answer(question).await?,
            Next::Ended(status) => return Ok(ended(&status, strict)),
        }
    }
}

async fn wait(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    loop {
        let request = v1::WaitJobRequest { job_id: arguments.job.clone(), timeout_ms: 60_000 };
        let status = client.jobs().wait_job(request).await?.into_inner().status.unwrap_or_default();
        if status.ended_ms != 0 {
            return Ok(ended(&status, strict));
        }
    }
}

async fn cancel(arguments: JobArgs) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    client.jobs().cancel_job(v1::CancelJobRequest { job_id: arguments.job }).await?;
    Ok(0)
}

async fn delete(arguments: JobArgs) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    client.jobs().delete_job(v1::DeleteJobRequest { job_id: arguments.job }).await?;
    Ok(0)
}

async fn result(arguments: ResultArgs) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let ResultArgs { job, what, channel, format, crlf, .. } = &arguments;
    let form = results::Form { format: *format, crlf: *crlf };
    match &arguments.output {
        Some(path) => results::file(&client, job, *what, *channel, form, path).await?,
        None => results::each(&client, job, *what, *channel, form, &mut say::data).await?,
    }
    Ok(0)
}
