//! Dialogs over time: questions that no client answers, questions of repeated runs, and events before a question.

use std::sync::atomic::Ordering;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_proto::v1::watch_questions_response::Content as Heard;
use counterpoint_server::options::{ServerOptions, System};
use tonic::Streaming;

use crate::support::*;

/// Maximum time for messages that arrive in any case.
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
            ServerOptions { system, ..options(folder.path()) }
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
        assert_eq!(said(&server, &job).await, ["One: late", "Two: No", "Three: Yes"], "paused: {paused}");
        server.stop().await;
    }
}

/// The message to a late client reports that the time was over, not that another client was first.
#[tokio::test(flavor = "multi_thread")]
async fn a_question_that_expires_is_closed_as_such_and_an_answered_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let system = System { operator_wait_s: 1, ..System::default() };
    let server = Server::start(ServerOptions { system, ..options(folder.path()) }).await;
    let job = attended(&server, "fanuc-2path-lathe", "ASK One\nASK Two\nHANG").await;
    let mut heard = questions(&server, &job).await;
    let mut closed = Vec::new();
    while closed.len() < 2 {
        let message = tokio::time::timeout(PATIENCE, heard.message()).await.expect("in time").unwrap().unwrap();
        match message.content.unwrap() {
            Heard::Question(question) if question.id == 2 => answer(&server, &job, 2, "OK").await,
            Heard::Question(question) => assert!(!message.expired, "{question:?}"),
            Heard::Closed(id) => closed.push((id, message.expired)),
            Heard::Ended(status) => panic!("{status:?}"),
        }
    }
    assert_eq!(closed, [(1, true), (2, false)]);
    server.stop().await;
}

/// A later deadline alone does not help a job that waits for an answer.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_waits_for_an_answer_at_its_deadline_names_the_dialog() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut request = server.request("late", "ASK Clamp").await;
    request.options = Some(v1::JobOptions { attended: true, ..Default::default() });
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
    request.deadline_ms = i64::try_from(now.as_millis()).unwrap() + 700;
    let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    let status = server.wait(&job).await;
    assert_eq!(status.limit(), v1::JobLimit::Deadline, "{status:?}");
    let text = format!("{} {}", status.error, status.verdict);
    assert!(text.contains("no client had answered the dialog 'Clamp'") && !text.contains("priority"), "{text}");
    server.stop().await;
}

/// A server on the real emulator, with a machine whose tool change asks the operator after a message.
async fn asking_machine(options: ServerOptions) -> Server {
    const MACHINE: &str = "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n[macros]\ntool = \"t.mac\"\n\
        [[dialogs]]\nname = \"ask\"\ntitle = \"Ask\"\n[[dialogs.buttons]]\nlabel = \"OK\"\ntype = \"ok\"\n";
    const TOOL: &str = "OUTPUT\nIF/$P1.EQ.2\nPPRINT/'before !(*)',$P3\nBUTTON=$FDIALOG('ask')\n\
        PPRINT/'after !(*) !(*)',$P3,BUTTON\nENDOF/IF\n";
    let service = counterpoint_server::service::build(options).await.unwrap();
    let handle = service.handle();
    let task = tokio::spawn(async { service.run(std::future::pending()).await.unwrap() });
    let connection = tonic::transport::Channel::from_shared(handle.url()).unwrap().connect().await.unwrap();
    let server = Server { handle, task, script: Script::default(), connection };
    let mut files = Vec::new();
    for (path, text) in [("own/machine.toml", MACHINE), ("own/t.mac", TOOL)] {
        files.push(v1::MachineFile { path: path.into(), digest: server.upload(text.as_bytes()).await });
    }
    server.machines().put_machine(v1::PutMachineRequest { name: "own".into(), files }).await.unwrap();
    server
}

/// Reads a watch until it has delivered a message of the program.
async fn until_message(watch: &mut Streaming<v1::WatchJobResponse>, text: &str) {
    let told = |event: &v1::Event| matches!(&event.kind, Some(v1::event::Kind::Message(m)) if m.text.contains(text));
    let read = async {
        loop {
            let content = watch.message().await.unwrap().expect("the job waits").content.unwrap();
            if matches!(&content, Content::Batch(batch) if batch.events.iter().any(told)) {
                return;
            }
        }
    };
    tokio::time::timeout(PATIENCE, read).await.unwrap_or_else(|_| panic!("no event with '{text}'"));
}

/// The events of a job up to a question are delivered while the question is open.
#[tokio::test(flavor = "multi_thread")]
async fn events_before_a_question_are_delivered_while_the_question_is_open() {
    let folder = tempfile::tempdir().unwrap();
    let server = asking_machine(options(folder.path())).await;
    let program = format!("O1\nG90 G94 F100 S500 M3\n{}T3 M6\nG1 X1.\nT4 M6\nM30\n", "G1 X1.\nX0.\n".repeat(300));
    let job = attended(&server, "own", &program).await;
    let mut watch = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut heard = questions(&server, &job).await;
    for (tool, id) in [("3", 1), ("4", 2)] {
        assert_eq!(question(&mut heard).await.0, id);
        until_message(&mut watch, &format!("before {tool}")).await;
        answer(&server, &job, id, "OK").await;
    }
    assert_eq!(said(&server, &job).await, ["before 3", "after 3 OK", "before 4", "after 4 OK"]);
    // Delivering the events early changes none of them.
    let mut request = server.request("prepared", &program).await;
    let answer = v1::DialogAnswer { dialog: "ask".into(), button: "OK".into(), ..Default::default() };
    request.options = Some(v1::JobOptions { answers: vec![answer], ..Default::default() });
    request.machine = "own".into();
    let prepared = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    assert_eq!(server.events(&prepared, 0).await, server.events(&job, 0).await);
    server.stop().await;
}

/// A dialog without an answer names the cause: an operator who declined, or one who did not answer in time.
#[tokio::test(flavor = "multi_thread")]
async fn a_dialog_that_was_declined_or_expired_is_reported_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let system = System { operator_wait_s: 1, ..System::default() };
    let server = asking_machine(ServerOptions { system, ..options(folder.path()) }).await;
    let job = attended(&server, "own", "O1\nG90 G94 F100 S500 M3\nT3 M6\nT4 M6\nM30\n").await;
    let mut heard = questions(&server, &job).await;
    assert_eq!(question(&mut heard).await.0, 1);
    let decline = v1::AnswerQuestionRequest { job_id: job.clone(), question_id: 1, answer: None };
    assert!(server.operator().answer_question(decline).await.unwrap().into_inner().accepted);
    let said: Vec<_> = server.events(&job, 0).await.into_iter().filter_map(|event| event.kind).collect();
    let diagnostics = said.iter().filter_map(|kind| match kind {
        v1::event::Kind::Diagnostic(diagnostic) if diagnostic.number == 2_910_073 => Some(diagnostic.text.as_str()),
        _ => None,
    });
    let texts: Vec<&str> = diagnostics.map(|text| text.lines().next().unwrap()).collect();
    let expected = ["the operator declined the dialog 'ask'", "no operator answered the dialog 'ask' in time"];
    assert_eq!(texts, expected);
    server.stop().await;
}

/// A pause closes an open question. This is not a dialog without an answer, so the log of the run does not report it,
/// and the repeated run asks again.
#[tokio::test(flavor = "multi_thread")]
async fn a_question_that_a_pause_closes_leaves_no_event() {
    let folder = tempfile::tempdir().unwrap();
    let server = asking_machine(options(folder.path())).await;
    let job = attended(&server, "own", "O1\nG90 G94 F100 S500 M3\nT3 M6\nG1 X1.\nM30\n").await;
    let mut watch = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut heard = questions(&server, &job).await;
    for _ in 0..2 {
        assert_eq!(question(&mut heard).await, (1, "ask".into()));
        server.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
        server.until(&job, v1::JobState::Queued).await;
        server.jobs().resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
    }
    assert_eq!(question(&mut heard).await, (1, "ask".into()));
    answer(&server, &job, 1, "OK").await;
    let mut seen = Vec::new();
    while let Some(message) = watch.message().await.unwrap() {
        match message.content.unwrap() {
            Content::Batch(batch) => seen.extend(batch.events),
            Content::Ended(_) => break,
            _ => {}
        }
    }
    assert_eq!(seen, server.events(&job, 0).await, "the watch has the events of the job");
    assert_eq!(said(&server, &job).await, ["before 3", "after 3 OK"]);
    server.stop().await;
}
