//! Answers of an operator that the server refuses.

use std::collections::BTreeMap;

use counterpoint_proto::v1;
use counterpoint_proto::v1::dialog_value::Value;
use counterpoint_server::options::{Quotas, ServerOptions};
use tonic_types::StatusExt as _;

use crate::support::*;

/// An attended job, and the id of its first question.
async fn asking(server: &Server, script: &str) -> (String, u64) {
    let mut request = server.request("asking", script).await;
    request.options = Some(v1::JobOptions { attended: true, ..Default::default() });
    let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    let watch = v1::WatchQuestionsRequest { job_id: job.clone() };
    let mut heard = server.operator().watch_questions(watch).await.unwrap().into_inner();
    match heard.message().await.unwrap().unwrap().content.unwrap() {
        v1::watch_questions_response::Content::Question(question) => (job, question.id),
        other => panic!("{other:?}"),
    }
}

fn answer(values: &[(&str, Value)]) -> v1::DialogAnswer {
    let wire = |value: &Value| v1::DialogValue { value: Some(value.clone()) };
    let values: BTreeMap<String, v1::DialogValue> =
        values.iter().map(|(name, value)| ((*name).to_owned(), wire(value))).collect();
    v1::DialogAnswer { dialog: "Form".into(), button: "OK".into(), values }
}

async fn give(server: &Server, job: &str, question: u64, answer: v1::DialogAnswer) -> Result<bool, tonic::Status> {
    let request = v1::AnswerQuestionRequest { job_id: job.into(), question_id: question, answer: Some(answer) };
    server.operator().answer_question(request).await.map(|accepted| accepted.into_inner().accepted)
}

/// The field and the rule of a refusal.
fn violation(refused: &tonic::Status) -> (String, String) {
    assert_eq!(reason(refused), "INVALID_REQUEST", "{refused:?}");
    let violation = refused.get_error_details().bad_request().unwrap().field_violations[0].clone();
    (violation.field, violation.description)
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_that_its_dialog_cannot_take_is_refused_by_name_and_the_question_stays_open() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let (job, question) = asking(&server, "FORM Form").await;
    let text = |text: &str| Value::Text(text.to_owned());
    for (variable, value, rule) in [
        ("NAME", text("123456"), "must have at most 5 characters"),
        ("NAME", Value::Number(5.0), "must be a text"),
        ("NAME", Value::Flag(true), "must be a text"),
        ("COUNT", text("many"), "must be a number"),
        ("CLAMP", text("maybe"), "must be true or false"),
        ("OTHER", Value::Number(1.0), "the dialog 'Form' has no such field"),
    ] {
        let refused = give(&server, &job, question, answer(&[(variable, value)])).await.unwrap_err();
        let (field, description) = violation(&refused);
        assert_eq!(field, "answer.values", "{variable}");
        assert!(description.contains(&format!("'{variable}'")) && description.contains(rule), "{description}");
    }
    let notes = ["A", "B", "C", "D", "E"].map(|name| (name, text(&"x".repeat(60_000))));
    let (_, description) = violation(&give(&server, &job, question, answer(&notes)).await.unwrap_err());
    assert!(description.contains("at most 262144 bytes together; they have 300000"), "{description}");
    // Letter case of variables is ignored, and an empty text means no value. The question also lists DEPTH.
    let values = [("name", text("12345")), ("COUNT", text("")), ("CLAMP", Value::Flag(true)), ("DEPTH", text("x"))];
    assert!(give(&server, &job, question, answer(&values)).await.unwrap());
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

/// An operator who mistypes keeps the stream: the question comes again with the reason.
#[tokio::test(flavor = "multi_thread")]
async fn a_refused_answer_asks_again_in_the_stream_of_its_operator() {
    use v1::attend_request::Content as Say;
    use v1::attend_response::Content as Heard;
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let (job, question) = asking(&server, "FORM Form").await;
    let (say, requests) = tokio::sync::mpsc::channel(8);
    let said = async |content| say.send(v1::AttendRequest { content: Some(content) }).await.unwrap();
    said(Say::JobId(job.clone())).await;
    let requests = tokio_stream::wrappers::ReceiverStream::new(requests);
    let mut heard = server.operator().attend(requests).await.unwrap().into_inner();
    let mut hear = async || {
        let message = tokio::time::timeout(std::time::Duration::from_secs(20), heard.message());
        message.await.expect("in time").unwrap().expect("the stream goes on").content.unwrap()
    };
    let give = async |answer| {
        said(Say::Answer(v1::QuestionAnswer { question_id: question, answer })).await;
    };
    assert!(matches!(hear().await, Heard::Question(asked) if asked.problem.is_empty()));
    let wrong = answer(&[("OTHER", Value::Text("x".to_owned()))]);
    for (given, rule) in [(Some(wrong), "the dialog 'Form' has no such field"), (None, "is missing")] {
        give(given).await;
        let Heard::Question(asked) = hear().await else { panic!("the question comes again") };
        assert_eq!(asked.id, question);
        assert!(asked.problem.contains(rule), "{}", asked.problem);
        assert!(asked.dialog.is_some());
    }
    give(Some(answer(&[("NAME", Value::Text("12345".to_owned()))]))).await;
    assert_eq!(hear().await, Heard::Closed(question));
    assert!(matches!(hear().await, Heard::Ended(status) if status.state() == v1::JobState::Succeeded));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_count_against_the_quotas_when_they_arrive() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_bytes: 150_000, ..Quotas::default() };
    let server = Server::start(ServerOptions { quotas, ..options(folder.path()) }).await;
    let long = || answer(&[("NOTE", Value::Text("x".repeat(60_000)))]);
    let (job, first) = asking(&server, "FORM Form\nFORM Form\nFORM Form").await;
    for question in [first, first + 1] {
        while !give(&server, &job, question, long()).await.unwrap() {
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
    }
    let refused = loop {
        match give(&server, &job, first + 2, long()).await {
            Err(refused) => break refused,
            Ok(accepted) => assert!(!accepted, "more than the quota is stored"),
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    };
    assert_eq!(reason(&refused), "QUOTA_EXCEEDED", "{refused:?}");
    assert!(give(&server, &job, first + 2, answer(&[])).await.unwrap(), "a small answer has room");
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_answers_of_a_job_have_at_most_4_mib() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let (job, first) = asking(&server, &"FORM Form\n".repeat(18)).await;
    let notes = ["NOTE", "NOTE2", "NOTE3", "NOTE4"].map(|name| (name, Value::Text("x".repeat(60_000))));
    let mut taken = 0;
    let refused = loop {
        match give(&server, &job, first + taken, answer(&notes)).await {
            Ok(true) => taken += 1,
            Ok(false) => tokio::time::sleep(std::time::Duration::from_millis(5)).await,
            Err(refused) => break refused,
        }
        assert!(taken < 18, "more than 4 MiB are stored");
    };
    assert_eq!((taken, violation(&refused).0.as_str()), (17, "answer.values"));
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    server.wait(&job).await;
    server.stop().await;
}

/// A paused job has no run that could count them.
#[tokio::test(flavor = "multi_thread")]
async fn answers_of_a_paused_job_count_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_bytes: 100_000, ..Quotas::default() };
    let options = ServerOptions { quotas, ..options(folder.path()) };
    let server = Server::start(options.clone()).await;
    let (job, first) = asking(&server, "FORM Form\nFORM Form").await;
    assert!(give(&server, &job, first, answer(&[("NOTE", Value::Text("x".repeat(60_000)))])).await.unwrap());
    server.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
    server.until(&job, v1::JobState::Queued).await;
    let refused = |upload: Result<(String, u64), tonic::Status>| {
        let refused = upload.unwrap_err();
        assert_eq!(reason(&refused), "QUOTA_EXCEEDED", "{refused:?}");
        assert!(refused.message().contains("of uploads and answers in progress"), "{}", refused.message());
    };
    refused(server.try_upload(&[b'y'; 60_000]).await);
    server.stop().await;
    let server = Server::start(options).await;
    refused(server.try_upload(&[b'y'; 60_000]).await);
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    server.wait(&job).await;
    server.stop().await;
}
