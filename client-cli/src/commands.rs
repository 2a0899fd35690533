//! All commands but `run` and `submit`.

use counterpoint_client::Update;
use counterpoint_proto::v1;
use counterpoint_proto::v1::event::Kind;

use crate::arguments::{Command, Follow, JobArgs, Jobs, ResultArgs, State};
use crate::attend::{Attendant, Next};
use crate::client::Client;
use crate::error::Error;
use crate::outcome::ended;
use crate::progress::Progress;
use crate::text::{table, time};
use crate::{completions, load, machines, macros, results, run, say};

/// Executes a command and returns the exit code.
pub(crate) async fn dispatch(command: Command) -> Result<u8, Error> {
    match command {
        Command::Run(arguments) => run::run(arguments).await,
        Command::Submit(arguments) => run::submit(arguments).await,
        Command::Watch(arguments) => watch(arguments).await,
        Command::Attend(arguments) => attend(arguments).await,
        Command::Wait(arguments) => wait(arguments).await,
        Command::Jobs(arguments) => jobs(arguments).await,
        Command::Cancel(arguments) => cancel(arguments).await,
        Command::Delete(arguments) => delete(arguments).await,
        Command::Result(arguments) => result(arguments).await,
        Command::Load(arguments) => load::load(arguments).await,
        Command::Machine(arguments) => machines::dispatch(arguments).await,
        Command::Macro(command) => macros::dispatch(&command),
        Command::Explain { what } => macros::explain(&what),
        Command::Completions { shell } => {
            say::data(completions::script(shell).as_bytes())?;
            Ok(0)
        }
    }
}

/// Follows a job, reconnecting if necessary; prints diagnostics and waits to standard output.
async fn watch(Follow { of: arguments, strict }: Follow) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let mut progress = Progress::new(arguments.quiet);
    let mut watch = client.watch(&arguments.job, v1::WatchLevel::Diagnostics);
    loop {
        match watch.next().await? {
            Update::Events(batch) => {
                for line in batch.events.iter().filter_map(line) {
                    say::data(line.as_bytes())?;
                }
            }
            Update::Progress(now) => progress.show(&now),
            Update::Ended(status) => {
                progress.clear();
                return Ok(ended(&status, strict));
            }
            Update::Description(_) => {}
        }
    }
}

/// An event as a line; `None` for events that are not printed.
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
    Ok(ended(&client.wait(&arguments.job).await?, strict))
}

async fn jobs(arguments: Jobs) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let state = |state: &State| match state {
        State::Queued => v1::JobState::Queued.into(),
        State::Running => v1::JobState::Running.into(),
        State::Succeeded => v1::JobState::Succeeded.into(),
        State::Failed => v1::JobState::Failed.into(),
        State::Cancelled => v1::JobState::Cancelled.into(),
    };
    let states: Vec<i32> = arguments.state.iter().map(state).collect();
    let mut request = v1::ListJobsRequest { states, page_size: 500, page_token: String::new() };
    let mut rows = Vec::new();
    loop {
        let page = client.jobs().list_jobs(request.clone()).await?.into_inner();
        rows.extend(page.jobs);
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    if arguments.json {
        let lines: String = rows.iter().map(|job| format!("{}\n", as_json(job))).collect();
        say::data(lines.as_bytes())?;
        return Ok(0);
    }
    let mut lines = vec![["job", "state", "machine", "cycle time", "programs"].map(str::to_owned).to_vec()];
    lines.extend(rows.iter().map(|job| {
        let programs = job.programs.iter().map(|p| p.path.as_str()).collect::<Vec<_>>().join(" ");
        let state = job.state().as_str_name().trim_start_matches("JOB_STATE_").to_owned();
        vec![job.job_id.clone(), state, job.machine.clone(), time(job.makespan_ns), programs]
    }));
    say::data(table(&lines, 3).as_bytes())?;
    Ok(0)
}

fn as_json(job: &v1::JobStatus) -> serde_json::Value {
    serde_json::json!({
        "job": job.job_id,
        "request_id": job.request_id,
        "state": job.state().as_str_name().trim_start_matches("JOB_STATE_"),
        "machine": job.machine,
        "programs": job.programs.iter().map(|p| p.path.as_str()).collect::<Vec<_>>(),
        "makespan_ns": job.makespan_ns,
        "events": job.events,
        "highest_severity": job.highest_severity,
        "verdict": job.verdict,
        "error": job.error,
        "log_digest": job.log_digest,
    })
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
