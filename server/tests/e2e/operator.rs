//! Dialogs and the operators of a job.

use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_proto::v1::attend_request::Content as Say;
use counterpoint_proto::v1::attend_response::Content;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Code, Status, Streaming};

use crate::support::*;

/// One who attends.
struct Person {
    say: mpsc::Sender<v1::AttendRequest>,
    heard: Streaming<v1::AttendResponse>,
}

impl Person {
    async fn come(server: &Server, first: Say) -> Result<Self, Status> {
        let (say, requests) = mpsc::channel(8);
        say.send(v1::AttendRequest { content: Some(first) }).await.unwrap();
        let heard = server.operator().attend(ReceiverStream::new(requests)).await?.into_inner();
        Ok(Self { say, heard })
    }

    async fn attend(server: &Server, job: &str) -> Self {
        Self::come(server, Say::JobId(job.into())).await.unwrap()
    }

    async fn hear(&mut self) -> Content {
        let message = tokio::time::timeout(std::time::Duration::from_secs(20), self.heard.message());
        message.await.expect("in time").unwrap().expect("not the end").content.unwrap()
    }

    /// The next question: its number and the name of its dialog.
    async fn question(&mut self) -> (u64, String) {
        match self.hear().await {
            Content::Question(question) => (question.id, question.dialog.unwrap().name),
            other => panic!("{other:?}"),
        }
    }

    async fn answer(&self, id: u64, button: &str) {
        let answer = v1::DialogAnswer { button: button.into(), ..Default::default() };
        let answer = v1::QuestionAnswer { question_id: id, answer: Some(answer) };
        self.say.send(v1::AttendRequest { content: Some(Say::Answer(answer)) }).await.unwrap();
    }
}

async fn attended(server: &Server, script: &str) -> String {
    let mut request = server.request("attended", script).await;
    request.options = Some(v1::JobOptions { attended: true, ..Default::default() });
    server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
}

/// Texts of all diagnostics of a job.
async fn said(server: &Server, job: &str) -> Vec<String> {
    let mut watch = server.watch(job, 0, v1::WatchLevel::Diagnostics).await;
    let mut texts = Vec::new();
    while let Some(message) = watch.message().await.unwrap() {
        if let Some(v1::watch_job_response::Content::Batch(batch)) = message.content {
            texts.extend(batch.events.into_iter().filter_map(|event| match event.kind {
                Some(v1::event::Kind::Diagnostic(diagnostic)) => Some(diagnostic.text),
                _ => None,
            }));
        }
    }
    texts
}

#[tokio::test(flavor = "multi_thread")]
async fn the_first_answer_counts_and_all_hear_of_it() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let job = attended(&server, "ASK Clamp\nASK Turn").await;
    let (mut one, mut other) = (Person::attend(&server, &job).await, Person::attend(&server, &job).await);
    let (id, dialog) = one.question().await;
    assert_eq!((id, dialog.as_str()), (1, "Clamp"));
    assert_eq!(other.question().await, (1, "Clamp".into()));
    one.answer(1, "OK").await;
    assert_eq!(one.hear().await, Content::Closed(1));
    assert_eq!(other.hear().await, Content::Closed(1));
    other.answer(1, "Cancel").await; // Too late: nothing comes of it.
    assert_eq!(other.question().await, (2, "Turn".into()));
    other.say.send(v1::AttendRequest { content: Some(Say::Declined(2)) }).await.unwrap();
    assert_eq!(other.hear().await, Content::Closed(2));
    let Content::Ended(status) = other.hear().await else { panic!("the job must have ended") };
    assert_eq!(status.state(), v1::JobState::Succeeded);
    assert_eq!(said(&server, &job).await, ["Clamp: OK", "Turn: -"]);
    let mut late = Person::attend(&server, &job).await;
    assert!(matches!(late.hear().await, Content::Ended(_)));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_attended_is_refused() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let job = server.submit("background", "ASK Clamp").await;
    let refusals = [
        (Say::JobId(job.clone()), "NOT_ATTENDED", Code::FailedPrecondition),
        (Say::JobId("nothing".into()), "UNKNOWN_JOB", Code::NotFound),
        (Say::Declined(1), "INVALID_REQUEST", Code::InvalidArgument),
    ];
    for (first, expected, code) in refusals {
        let status = Person::come(&server, first).await.err().unwrap();
        assert_eq!((reason(&status).as_str(), status.code()), (expected, code));
    }
    server.wait(&job).await;
    assert_eq!(said(&server, &job).await, ["Clamp: -"], "it is not asked and does not wait");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_asks_no_more() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let job = attended(&server, "ASK Clamp\nASK Turn").await;
    let mut one = Person::attend(&server, &job).await;
    assert_eq!(one.question().await.0, 1);
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    assert_eq!(one.hear().await, Content::Closed(1));
    let Content::Ended(status) = one.hear().await else { panic!("the job must have ended") };
    assert_eq!(status.state(), v1::JobState::Cancelled);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_is_run_again_has_its_answers() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let job = attended(&server, "ASK Clamp\nHANG\nASK Turn").await;
    let mut one = Person::attend(&server, &job).await;
    let (id, _) = one.question().await;
    one.answer(id, "OK").await;
    assert_eq!(one.hear().await, Content::Closed(1));
    // The question is closed when the answer is taken; it is in the ledger once the kernel has it.
    while server.script.asked.load(Ordering::SeqCst) == 0 {
        tokio::task::yield_now().await;
    }
    server.stop().await;
    let server = Server::start(options(data.path())).await;
    server.script.hang.store(false, Ordering::SeqCst);
    let mut one = Person::attend(&server, &job).await;
    let (id, dialog) = one.question().await;
    assert_eq!(dialog, "Turn", "the first one is answered from the ledger");
    one.answer(id, "Leave").await;
    server.wait(&job).await;
    assert_eq!(said(&server, &job).await, ["Clamp: OK", "Turn: Leave"]);
    server.stop().await;
}

/// The job is at its second question: nothing comes after the event that would take it along.
#[tokio::test]
async fn an_event_that_comes_alone_reaches_its_watcher() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = attended(&server, "ASK first\nASK second").await;
    let mut person = Person::attend(&server, &job).await;
    let (first, _) = person.question().await;
    let mut watch = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    person.answer(first, "Go").await;
    let event = async {
        loop {
            let content = watch.message().await.unwrap().expect("the job goes on").content;
            if let Some(v1::watch_job_response::Content::Batch(batch)) = content {
                return batch;
            }
        }
    };
    let batch = tokio::time::timeout(std::time::Duration::from_secs(20), event).await.expect("in time");
    assert_eq!((batch.first_seq, batch.last_seq), (1, 1));
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job }).await.unwrap();
    server.stop().await;
}

/// As a browser attends: one stream from the server, and calls with one message.
#[tokio::test(flavor = "multi_thread")]
async fn questions_are_watched_and_answered_without_a_stream_of_the_client() {
    use v1::watch_questions_response::Content;
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let job = attended(&server, "ASK Clamp\nASK Turn").await;
    let watch = |job_id: &str| v1::WatchQuestionsRequest { job_id: job_id.into() };
    let mut heard = server.operator().watch_questions(watch(&job)).await.unwrap().into_inner();
    let mut other = Person::attend(&server, &job).await;
    assert_eq!(other.question().await.0, 1);
    let mut hear = async || {
        let message = tokio::time::timeout(std::time::Duration::from_secs(20), heard.message());
        message.await.expect("in time").unwrap().expect("not the end").content.unwrap()
    };
    let Content::Question(question) = hear().await else { panic!("a question comes first") };
    assert_eq!((question.id, question.dialog.unwrap().name.as_str()), (1, "Clamp"));
    let say = async |question_id, answer| {
        let answer = v1::AnswerQuestionRequest { job_id: job.clone(), question_id, answer };
        server.operator().answer_question(answer).await.unwrap().into_inner().accepted
    };
    let press = |button: &str| Some(v1::DialogAnswer { button: button.into(), ..Default::default() });
    assert!(!say(7, press("OK")).await, "no such question");
    assert!(say(1, press("OK")).await);
    assert!(!say(1, press("Cancel")).await, "the first answer counts");
    assert_eq!(hear().await, Content::Closed(1));
    let Content::Question(question) = hear().await else { panic!("the second question") };
    assert_eq!(question.id, 2);
    assert!(say(2, None).await);
    assert_eq!(hear().await, Content::Closed(2));
    let Content::Ended(status) = hear().await else { panic!("the job must have ended") };
    assert_eq!(status.state(), v1::JobState::Succeeded);
    assert_eq!(said(&server, &job).await, ["Clamp: OK", "Turn: -"]);
    assert!(!say(2, press("OK")).await, "the job has ended");
    let mut late = server.operator().watch_questions(watch(&job)).await.unwrap().into_inner();
    assert!(matches!(late.message().await.unwrap().unwrap().content, Some(Content::Ended(_))));
    let background = server.submit("background", "EVENTS 1").await;
    let refused = server.operator().watch_questions(watch(&background)).await.unwrap_err();
    assert_eq!(reason(&refused), "NOT_ATTENDED");
    let answer = v1::AnswerQuestionRequest { job_id: background, question_id: 1, answer: None };
    assert_eq!(reason(&server.operator().answer_question(answer).await.unwrap_err()), "NOT_ATTENDED");
    server.stop().await;
}
