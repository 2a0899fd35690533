//! Jobs that a client steps through, and their behaviour when it leaves.

use counterpoint_proto::v1;
use counterpoint_proto::v1::debug_command::What;
use counterpoint_proto::v1::debug_request::Content as Say;
use counterpoint_proto::v1::debug_response::Content;
use counterpoint_server::options::{ServerOptions, System};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Code, Status, Streaming};

use crate::support::*;

/// One who steps through a job.
struct Person {
    say: mpsc::Sender<v1::DebugRequest>,
    heard: Streaming<v1::DebugResponse>,
}

impl Person {
    async fn come(server: &Server, first: Say) -> Result<Self, Status> {
        let (say, requests) = mpsc::channel(64);
        say.send(v1::DebugRequest { content: Some(first) }).await.unwrap();
        let heard = server.operator().debug(ReceiverStream::new(requests)).await?.into_inner();
        Ok(Self { say, heard })
    }

    async fn step(server: &Server, job: &str) -> Self {
        Self::come(server, Say::JobId(job.into())).await.unwrap()
    }

    async fn hear(&mut self) -> Content {
        let message = tokio::time::timeout(std::time::Duration::from_secs(20), self.heard.message());
        message.await.expect("in time").unwrap().expect("not the end").content.unwrap()
    }

    async fn stop(&mut self) -> String {
        match self.hear().await {
            Content::Stopped(state) => state.reason,
            other => panic!("{other:?}"),
        }
    }

    async fn ended(&mut self) -> v1::JobState {
        match self.hear().await {
            Content::Ended(status) => status.state(),
            other => panic!("{other:?}"),
        }
    }

    async fn command(&self, what: What) {
        let command = v1::DebugCommand { what: Some(what) };
        self.say.send(v1::DebugRequest { content: Some(Say::Command(command)) }).await.unwrap();
    }

    async fn act(&self, action: v1::DebugAction) {
        self.command(What::Action(action.into())).await;
    }
}

fn patient(data: &std::path::Path, seconds: u64) -> ServerOptions {
    let options = options(data);
    ServerOptions { system: System { operator_wait_s: seconds, ..System::default() }, ..options }
}

async fn stepped(server: &Server, name: &str, script: &str) -> String {
    let mut request = server.request(name, script).await;
    request.options = Some(v1::JobOptions { stepped: true, ..Default::default() });
    server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
}

#[tokio::test(flavor = "multi_thread")]
async fn each_command_has_an_answer_and_the_end_is_told() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(patient(data.path(), 600)).await;
    let job = stepped(&server, "steps", "STEP a\nEVENTS 3\nSTEP b").await;
    let mut person = Person::step(&server, &job).await;
    assert_eq!(person.stop().await, "a");
    person.act(v1::DebugAction::Show).await;
    person.command(What::Hold(1)).await;
    for _ in 0..2 {
        assert!(matches!(person.hear().await, Content::State(state) if state.reason == "a"));
    }
    let other = Person::come(&server, Say::JobId(job.clone())).await.err().unwrap();
    assert_eq!((reason(&other).as_str(), other.code()), ("STEPPED_ALREADY", Code::FailedPrecondition));
    person.command(What::Step(v1::DebugStep { channel: 1, ..Default::default() })).await;
    assert_eq!(person.stop().await, "b");
    person.act(v1::DebugAction::Continue).await;
    assert_eq!(person.ended().await, v1::JobState::Succeeded);
    let mut late = Person::step(&server, &job).await;
    assert_eq!(late.ended().await, v1::JobState::Succeeded);
    server.stop().await;
}

/// A script may send all commands at once: the answer to each comes before the end of the stream.
#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_ends_its_side_hears_the_answers_to_its_commands() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(patient(data.path(), 600)).await;
    for run in 0..20 {
        let job = stepped(&server, &format!("steps-{run}"), "STEP a\nSTEP b\nSTEP c\nEVENTS 3").await;
        let mut person = Person::step(&server, &job).await;
        for _ in 0..3 {
            person.act(v1::DebugAction::Show).await;
        }
        person.command(What::Step(v1::DebugStep::default())).await;
        let (say, _) = mpsc::channel(1);
        drop(std::mem::replace(&mut person.say, say));
        let mut heard = Vec::new();
        while let Some(message) = person.heard.message().await.unwrap() {
            heard.push(match message.content.unwrap() {
                Content::Stopped(state) => state.reason,
                Content::State(state) => format!("at {}", state.reason),
                other => panic!("{other:?}"),
            });
        }
        assert_eq!(heard, ["a", "at a", "at a", "at a", "b"], "run {run}");
        server.jobs().cancel_job(v1::CancelJobRequest { job_id: job }).await.unwrap();
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn another_client_takes_over_and_a_detached_job_runs_to_its_end() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(patient(data.path(), 600)).await;
    let job = stepped(&server, "steps", "STEP a\nSTEP b\nEVENTS 3").await;
    let mut person = Person::step(&server, &job).await;
    assert_eq!(person.stop().await, "a");
    drop(person);
    let mut next = loop {
        // The server hears a moment later that the first one has gone.
        match Person::come(&server, Say::JobId(job.clone())).await {
            Ok(next) => break next,
            Err(status) => assert_eq!(reason(&status), "STEPPED_ALREADY"),
        }
        tokio::task::yield_now().await;
    };
    assert_eq!(next.stop().await, "a", "it learns where the run stands");
    next.act(v1::DebugAction::Continue).await;
    assert_eq!(next.stop().await, "b");
    next.act(v1::DebugAction::Detach).await;
    assert_eq!(next.ended().await, v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_nobody_steps_through_runs_when_the_patience_is_over() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(patient(data.path(), 0)).await;
    let job = stepped(&server, "steps", "STEP a\nSTEP b\nEVENTS 3").await;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancel_and_a_limit_by_the_clock_end_a_run_that_stands() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(patient(data.path(), 600)).await;
    let job = stepped(&server, "cancelled", "STEP a").await;
    let mut person = Person::step(&server, &job).await;
    assert_eq!(person.stop().await, "a");
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    assert_eq!(person.ended().await, v1::JobState::Cancelled);
    let mut request = server.request("late", "STEP a").await;
    let limits = Some(v1::JobLimits { wall_ms: 50, ..Default::default() });
    request.options = Some(v1::JobOptions { stepped: true, limits, ..Default::default() });
    let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Failed);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_wrong_is_refused_and_the_run_stands() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(patient(data.path(), 600)).await;
    let plain = server.submit("plain", "EVENTS 1").await;
    let job = stepped(&server, "steps", "STEP a").await;
    let firsts = [
        (Say::JobId(plain), "NOT_STEPPED", Code::FailedPrecondition),
        (Say::JobId("nothing".into()), "UNKNOWN_JOB", Code::NotFound),
        (Say::Command(v1::DebugCommand::default()), "INVALID_REQUEST", Code::InvalidArgument),
    ];
    for (first, expected, code) in firsts {
        let status = Person::come(&server, first).await.err().unwrap();
        assert_eq!((reason(&status).as_str(), status.code()), (expected, code));
    }
    let breakpoint = |at| What::Add(v1::Breakpoint { at, ..Default::default() });
    let wrong = [
        What::Action(99),
        What::Hold(10_000),
        What::Step(v1::DebugStep { channel: 1, all: true, blocks: 1, ..Default::default() }),
        breakpoint(None),
        breakpoint(Some(v1::breakpoint::At::Wait("M".repeat(1001)))),
    ];
    for what in wrong {
        let mut person = loop {
            match Person::come(&server, Say::JobId(job.clone())).await {
                Ok(person) => break person,
                Err(status) => assert_eq!(reason(&status), "STEPPED_ALREADY"),
            }
            tokio::task::yield_now().await;
        };
        assert_eq!(person.stop().await, "a");
        person.command(what.clone()).await;
        let status = person.heard.message().await.err().unwrap_or_else(|| panic!("{what:?}"));
        assert_eq!((reason(&status).as_str(), status.code()), ("INVALID_REQUEST", Code::InvalidArgument));
    }
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job }).await.unwrap();
    server.stop().await;
}
