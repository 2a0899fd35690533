//! Watching: cursors, levels, slow readers.

use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use tonic::{Code, Streaming};
use tonic_types::StatusExt;

use crate::support::*;

/// Everything a watch brings: events, and the state at its end.
async fn all(mut stream: Streaming<v1::WatchJobResponse>) -> (Vec<v1::Event>, v1::JobState) {
    let mut events = Vec::new();
    loop {
        match stream.message().await.unwrap().expect("a stream ends with the end of the job").content.unwrap() {
            Content::Batch(batch) => events.extend(batch.events),
            Content::Ended(status) => {
                assert!(stream.message().await.unwrap().is_none());
                return (events, status.state());
            }
            Content::Progress(_) | Content::Description(_) => {}
        }
    }
}

#[tokio::test]
async fn a_watch_resumes_behind_any_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 3000").await;
    let (events, state) = all(server.watch(&job, 0, v1::WatchLevel::Everything).await).await;
    assert_eq!(state, v1::JobState::Succeeded);
    assert_eq!(events.iter().map(|e| e.seq).collect::<Vec<_>>(), (1..=3000).collect::<Vec<_>>());
    for after in [1, 255, 256, 257, 1000, 2999, 3000] {
        let (rest, _) = all(server.watch(&job, after, v1::WatchLevel::Everything).await).await;
        assert_eq!(rest, events[after as usize..], "after {after}");
    }
    let mut beyond = server.watch(&job, 3001, v1::WatchLevel::Everything).await;
    let refused = loop {
        match beyond.message().await {
            Ok(message) => assert!(!matches!(message.unwrap().content, Some(Content::Batch(_)))),
            Err(status) => break status,
        }
    };
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::OutOfRange, "CURSOR_BEYOND_LOG"));
    server.stop().await;
}

#[tokio::test]
async fn levels_filter_and_keep_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 1000\nALARM").await;
    let (everything, state) = all(server.watch(&job, 0, v1::WatchLevel::Everything).await).await;
    assert_eq!(state, v1::JobState::Failed);
    let diagnostic = |e: &v1::Event| matches!(e.kind, Some(v1::event::Kind::Diagnostic(_)));
    let block = |e: &v1::Event| matches!(e.kind, Some(v1::event::Kind::Block(_)));
    let (seen, _) = all(server.watch(&job, 0, v1::WatchLevel::Diagnostics).await).await;
    assert_eq!(seen, everything.iter().filter(|e| diagnostic(e)).cloned().collect::<Vec<_>>());
    let (seen, _) = all(server.watch(&job, 500, v1::WatchLevel::Blocks).await).await;
    let wanted = everything.iter().filter(|e| e.seq > 500 && (diagnostic(e) || block(e)));
    assert_eq!(seen, wanted.cloned().collect::<Vec<_>>());
    let (seen, _) = all(server.watch(&job, 0, v1::WatchLevel::Progress).await).await;
    assert!(seen.is_empty());
    server.stop().await;
}

#[tokio::test]
async fn a_running_job_can_be_watched_before_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 10\nHANG\nEVENTS 5").await;
    let mut stream = server.watch(&job, 0, v1::WatchLevel::Blocks).await;
    let mut channels = 0;
    while channels == 0 {
        if let Some(Content::Progress(progress)) = stream.message().await.unwrap().unwrap().content {
            channels = progress.channels.len();
        }
    }
    assert_eq!(channels, 2);
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    let (_, state) = all(stream).await;
    assert_eq!(state, v1::JobState::Succeeded);
    server.stop().await;
}

/// A reader slower than the kernel must neither be cut off for flooding nor slow the job.
#[tokio::test]
async fn a_slow_watcher_gets_everything_and_slows_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 200000").await;
    let slow = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut paced = server.watch(&job, 0, v1::WatchLevel::Blocks).await;
    // Neither of them reads anything until the job has ended.
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    let mut last = 0;
    for read in 0.. {
        if read < 200 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        match paced.message().await.unwrap().unwrap().content.unwrap() {
            Content::Batch(batch) => {
                assert_eq!(batch.first_seq, last + 1);
                last = batch.last_seq;
            }
            Content::Ended(_) => break,
            _ => {}
        }
    }
    assert_eq!(all(slow).await.0.len(), 200_000);
    server.stop().await;
}

/// Unread small messages pile up until the job ends; the connection must survive them.
#[tokio::test]
async fn unread_progress_does_not_kill_the_connection() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "HANG").await;
    server.until(&job, v1::JobState::Running).await;
    let mut streams = Vec::new();
    for _ in 0..100 {
        streams.push(server.watch(&job, 0, v1::WatchLevel::Progress).await);
    }
    // As many have been sent to each of them as this one has got.
    let mut read = server.watch(&job, 0, v1::WatchLevel::Progress).await;
    let mut progress = 0;
    while progress < 5 {
        let message = tokio::time::timeout(Duration::from_secs(20), read.message()).await.expect("progress is sent");
        progress += u32::from(matches!(message.unwrap().unwrap().content, Some(Content::Progress(_))));
        server.status(&job).await;
    }
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    for stream in streams {
        assert_eq!(all(stream).await.1, v1::JobState::Succeeded);
    }
    server.stop().await;
}

/// Events read ahead for a stalled client are dropped; nothing is missing when it continues.
#[tokio::test]
async fn a_watcher_that_stood_still_gets_the_rest_once() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 100000").await;
    let mut still = Vec::new();
    for level in [v1::WatchLevel::Everything, v1::WatchLevel::Blocks] {
        still.push(server.watch(&job, 77, level).await);
    }
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    for mut stream in still {
        let mut last = 77;
        let mut pauses = 0;
        loop {
            match stream.message().await.unwrap().unwrap().content.unwrap() {
                Content::Batch(batch) => {
                    assert_eq!(batch.first_seq, last + 1);
                    last = batch.last_seq;
                    if pauses < 3 {
                        pauses += 1;
                        tokio::time::sleep(Duration::from_millis(250)).await;
                    }
                }
                Content::Ended(_) => break,
                _ => {}
            }
        }
        assert_eq!(last, 100_000);
    }
    server.stop().await;
}

#[tokio::test]
async fn a_sign_of_life_comes_at_the_interval_that_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "HANG").await;
    server.until(&job, v1::JobState::Running).await;
    let request = |heartbeat_ms| v1::WatchJobRequest {
        job_id: job.clone(),
        level: v1::WatchLevel::Progress.into(),
        heartbeat_ms,
        ..Default::default()
    };
    let begin = tokio::time::Instant::now();
    let mut often = server.jobs().watch_job(request(100)).await.unwrap().into_inner();
    let mut rarely = server.jobs().watch_job(request(60_000)).await.unwrap().into_inner();
    let mut signs = 0;
    while signs < 20 {
        signs += i32::from(matches!(often.message().await.unwrap().unwrap().content, Some(Content::Progress(_))));
    }
    assert!(begin.elapsed() >= Duration::from_millis(1900), "no more often than asked");
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    let mut messages = 0;
    while rarely.message().await.unwrap().is_some() {
        messages += 1;
    }
    assert!(messages < 10, "{messages}");
    for wrong in [99, 60_001] {
        let refused = server.jobs().watch_job(request(wrong)).await.unwrap_err();
        assert_eq!(refused.get_error_details().bad_request().unwrap().field_violations[0].field, "heartbeat_ms");
    }
    server.stop().await;
}
