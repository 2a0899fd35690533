//! Dialogs over time: questions that no client answers, and questions of repeated runs.

use std::sync::atomic::Ordering;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_questions_response::Content as Heard;
use counterpoint_server::options::{Options, System};
use tonic::Streaming;

use crate::support::*;

/// A bound for messages that arrive in any case.
const PATIENCE: Duration = Duration::from_secs(60);

async fn attended(server: &Server, machine: &str, program: &str) -> String {
    let mut request = server.request("attended", program).await;
    request.machine = machine.into();
    request.options = Some(v1::JobOptions { attended: true, ..Default::default() });
    server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
}

async fn questions(server: &Server, job: &str) -> Streaming<v1::WatchQuestionsResponse> {
    let watch = v1::WatchQuestionsRequest { job_id: job.into() };
    server.operator().watch_questions(watch).await.unwrap().into_inner()
}

/// The next question: its id and the name of its dialog.
async fn question(heard: &mut Streaming<v1::WatchQuestionsResponse>) -> (u64, String) {
    loop {
        let message = tokio::time::timeout(PATIENCE, heard.message()).await.expect("in time");
        match message.unwrap().expect("not the end").content.unwrap() {
            Heard::Question(question) => return (question.id, question.dialog.unwrap().name),
            Heard::Closed(_) => {}
            Heard::Ended(status) => panic!("{status:?}"),
        }
    }
}

async fn answer(server: &Server, job: &str, question_id: u64, button: &str) {
    let answer = Some(v1::DialogAnswer { button: button.into(), ..Default::default() });
    let answer = v1::AnswerQuestionRequest { job_id: job.into(), question_id, answer };
    assert!(server.operator().answer_question(answer).await.unwrap().into_inner().accepted);
}

/// Texts of the diagnostics and messages of a job that ends.
async fn said(server: &Server, job: &str) -> Vec<String> {
    let text = |event: v1::Event| match event.kind {
        Some(v1::event::Kind::Diagnostic(diagnostic)) => Some(diagnostic.text),
        Some(v1::event::Kind::Message(message)) => Some(message.text),
        _ => None,
    };
    server.events(job, 0).await.into_iter().filter_map(text).collect()
}

/// A question that was not answered in time stays unanswered in the repeated run, and each answer belongs to its own
/// question, whether the server or a pause has stopped the first run.
#[tokio::test(flavor = "multi_thread")]
async fn a_repeated_run_asks_no_question_again_that_nobody_answered_in_time() {
    for paused in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let patient = |operator_wait_s| {
            let system = System { operator_wait_s, ..System::default() };
            Options { system, ..options(folder.path()) }
        };
        let mut server = Server::start(patient(3)).await;
        let job = attended(&server, "fanuc-2path-lathe", "ASK One\nASK Two\nHANG\nASK Three").await;
        let mut heard = questions(&server, &job).await;
        assert_eq!(question(&mut heard).await, (1, "One".into()), "it waits in vain");
        assert_eq!(question(&mut heard).await, (2, "Two".into()));
        answer(&server, &job, 2, "No").await;
        while server.script.asked.load(Ordering::SeqCst) < 2 {
            tokio::task::yield_now().await;
        }
        if paused {
            server.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
            server.until(&job, v1::JobState::Queued).await;
            server.script.hang.store(false, Ordering::SeqCst);
            server.jobs().resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
        } else {
            server.stop().await;
            server = Server::start(patient(3600)).await;
            server.script.hang.store(false, Ordering::SeqCst);
        }
        let mut heard = questions(&server, &job).await;
        assert_eq!(question(&mut heard).await, (3, "Three".into()), "paused: {paused}");
        answer(&server, &job, 3, "Yes").await;
        assert_eq!(said(&server, &job).await, ["One: -", "Two: No", "Three: Yes"], "paused: {paused}");
        server.stop().await;
    }
}
