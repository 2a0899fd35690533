//! A watch over connections that break and servers that go away: every event once and in order.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use counterpoint_client::{Blob, Client, ClientSettings, Error, JobUpdate, ResultDocument, Update, request_id, v1};
use counterpoint_server::options::ServerOptions;
use counterpoint_server::service::{self, Handle};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

struct Server {
    handle: Handle,
    task: tokio::task::JoinHandle<()>,
}

impl Server {
    async fn start(data: &Path) -> Self {
        let listen = "127.0.0.1:0".parse().unwrap();
        let options =
            ServerOptions { listen, data: data.to_owned(), grace_s: 0, workers: 1, ..ServerOptions::default() };
        let service = service::build(options).await.unwrap();
        let handle = service.handle();
        let task = tokio::spawn(async { service.run(std::future::pending()).await.unwrap() });
        Self { handle, task }
    }

    async fn stop(self) {
        self.handle.stop();
        self.task.await.unwrap();
    }
}

/// Passes connections on to a server and breaks the first ones after these many bytes of answers.
async fn proxy(to: watch::Receiver<SocketAddr>, cuts: &'static [usize]) -> (SocketAddr, Arc<AtomicUsize>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let connections = Arc::new(AtomicUsize::new(0));
    let counted = connections.clone();
    tokio::spawn(async move {
        while let Ok((mut near, _)) = listener.accept().await {
            let number = counted.fetch_add(1, Ordering::SeqCst);
            let target = *to.borrow();
            tokio::spawn(async move {
                let mut far = TcpStream::connect(target).await?;
                let mut left = cuts.get(number).copied().unwrap_or(usize::MAX);
                let (mut up, mut down) = (vec![0; 16 << 10], vec![0; 16 << 10]);
                loop {
                    tokio::select! {
                        n = near.read(&mut up) => match n? {
                            0 => return Ok(()),
                            n => far.write_all(&up[..n]).await?,
                        },
                        n = far.read(&mut down) => match n? {
                            0 => return Ok(()),
                            n if n > left => return Ok::<(), std::io::Error>(()),
                            n => {
                                left -= n;
                                near.write_all(&down[..n]).await?;
                            }
                        },
                    }
                }
            });
        }
    });
    (address, connections)
}

fn program(blocks: usize) -> String {
    let mut text = "%\nO1\nG90 G94 F500\n".to_owned();
    for n in 0..blocks {
        text += &format!("N{n} G1 X{}. Y{}.\n", n % 90, n % 70);
    }
    text + "M30\n%\n"
}

async fn submit(client: &Client, text: String) -> String {
    let blob = Blob::new(text.into_bytes());
    client.upload(std::slice::from_ref(&blob)).await.unwrap();
    let request = v1::SubmitJobRequest {
        request_id: request_id(),
        machine: "fanuc-mill".into(),
        programs: vec![v1::Program { path: "part.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "part.nc".into(), digest: blob.digest().into() }],
        ..Default::default()
    };
    client.submit(request).await.unwrap().job_id
}

/// Numbers of all events, how often the job was described, and how it ended.
async fn follow(mut watch: counterpoint_client::Watch) -> (Vec<u64>, usize, v1::JobStatus, u64) {
    let (mut numbers, mut described) = (Vec::new(), 0);
    loop {
        match watch.next().await.unwrap() {
            Update::Description(_) => described += 1,
            Update::Events(batch) => {
                numbers.extend(batch.events.iter().map(|event| event.seq));
                assert_eq!(watch.cursor(), batch.last_seq);
            }
            Update::Progress(_) => {}
            Update::Ended(status) => return (numbers, described, *status, watch.reconnects()),
        }
    }
}

#[tokio::test]
async fn every_event_comes_once_over_connections_that_break() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path()).await;
    let direct = Client::connect(&ClientSettings::new(server.handle.url())).await.unwrap();
    let job = submit(&direct, program(5000)).await;
    direct.wait(&job).await.unwrap();
    let (_to, target) = watch::channel(server.handle.address());
    // The last two cuts are inside of large answers, the others before or after the first batches.
    let (address, connections) = proxy(target, &[300, 2_000, 40_000, 60_000, 150_000]).await;
    let settings = ClientSettings::new(format!("http://{address}"));
    let client = Client::connect(&settings).await.unwrap();
    let (numbers, described, status, reconnects) = follow(client.watch(&job, v1::WatchLevel::Everything)).await;
    let expected: Vec<u64> = (1..=status.events).collect();
    assert!(numbers == expected, "{} of {} events", numbers.len(), expected.len());
    assert_eq!((described, status.state()), (1, v1::JobState::Succeeded));
    assert!(reconnects >= 3, "{reconnects}");
    assert!(connections.load(Ordering::SeqCst) > 3);
    // From a cursor on, at another level: later events follow.
    let (numbers, ..) = follow(client.watch(&job, v1::WatchLevel::Blocks).after(400)).await;
    assert!(numbers.first().is_some_and(|first| *first > 400) && numbers.is_sorted());
    let whole = client.document(&job, &ResultDocument::Events).await.unwrap().whole().await.unwrap();
    assert_eq!(whole.iter().filter(|byte| **byte == b'\n').count() as u64, status.events);
    server.stop().await;
}

#[tokio::test]
async fn a_watch_outlives_a_restart_of_the_server_and_a_submit_is_accepted_once() {
    let folder = tempfile::tempdir().unwrap();
    let first = Server::start(folder.path()).await;
    let (to, target) = watch::channel(first.handle.address());
    let (address, _) = proxy(target, &[]).await;
    let client = Client::connect(&ClientSettings::new(format!("http://{address}"))).await.unwrap();
    let job = submit(&client, program(60_000)).await;
    let mut watch = client.watch(&job, v1::WatchLevel::Everything).heartbeat(Duration::from_millis(100));
    let mut seen = 0;
    while seen == 0 {
        if let Update::Events(batch) = watch.next().await.unwrap() {
            seen = batch.last_seq;
        }
    }
    first.stop().await;
    let second = Server::start(folder.path()).await;
    to.send_replace(second.handle.address());
    let (numbers, described, status, reconnects) = follow(watch).await;
    assert_eq!((numbers.first(), described), (Some(&(seen + 1)), 0));
    assert!(numbers.len() as u64 == status.events - seen && numbers.is_sorted(), "{status:?}");
    assert!(reconnects > 0);
    let jobs = client.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
    assert_eq!(jobs.len(), 1);
    second.stop().await;
}

/// Passes connections on to a server and delivers the end of each stream (HEADERS with END_STREAM, RFC 9113 section
/// 6.2) after the data before it.
async fn late_ends(to: SocketAddr) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move {
        while let Ok((near, _)) = listener.accept().await {
            let (mut from_near, mut to_near) = near.into_split();
            let (mut from_far, mut to_far) = TcpStream::connect(to).await?.into_split();
            tokio::spawn(async move { tokio::io::copy(&mut from_near, &mut to_far).await });
            tokio::spawn(async move {
                loop {
                    let mut frame = vec![0; 9];
                    from_far.read_exact(&mut frame).await?;
                    let length = u32::from_be_bytes([0, frame[0], frame[1], frame[2]]);
                    frame.resize(9 + usize::try_from(length).unwrap(), 0);
                    from_far.read_exact(&mut frame[9..]).await?;
                    if frame[3] == 1 && frame[4] & 1 == 1 {
                        tokio::time::sleep(Duration::from_millis(2)).await;
                    }
                    to_near.write_all(&frame).await?;
                }
                #[allow(unreachable_code)]
                std::io::Result::Ok(())
            });
        }
        std::io::Result::Ok(())
    });
    address
}

#[tokio::test(flavor = "multi_thread")]
async fn a_connection_outlives_many_watches_that_end() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path()).await;
    let address = late_ends(server.handle.address()).await;
    let client = Client::connect(&ClientSettings::new(format!("http://{address}"))).await.unwrap();
    let job = submit(&client, program(3)).await;
    client.wait(&job).await.unwrap();
    let mut callers = tokio::task::JoinSet::new();
    for _ in 0..64 {
        let (client, job) = (client.clone(), job.clone());
        callers.spawn(async move {
            for _ in 0..60 {
                let (.., status, reconnects) = follow(client.watch(&job, v1::WatchLevel::Everything)).await;
                assert_eq!((status.state(), reconnects), (v1::JobState::Succeeded, 0));
            }
        });
    }
    while let Some(done) = callers.join_next().await {
        done.unwrap();
    }
    server.stop().await;
}

#[tokio::test]
async fn patience_ends_and_refusals_are_not_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path()).await;
    let settings = ClientSettings::new(server.handle.url()).with_patience(Duration::from_millis(300));
    let client = Client::connect(&settings).await.unwrap();
    let unknown = client.watch("none", v1::WatchLevel::Progress).next().await.unwrap_err();
    assert_eq!(unknown.reason().as_deref(), Some("UNKNOWN_JOB"));
    let server_url = server.handle.url();
    server.stop().await;
    let lost = client.wait("none").await.unwrap_err();
    assert!(lost.is_passing() && matches!(lost, Error::Unreachable { .. }), "{lost}");
    assert!(lost.to_string().contains(&server_url), "{lost}");
    assert!(matches!(Client::connect(&settings).await, Err(Error::Unreachable { .. })));
}

/// A client that lists the jobs after `Anew` misses no end: each job that ends after that is delivered.
#[tokio::test]
async fn a_watch_with_a_cursor_that_is_too_old_is_open_again_before_its_client_hears_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path()).await;
    let client = Client::connect(&ClientSettings::new(server.handle.url())).await.unwrap();
    let mut watch = client.watch_jobs(v1::JobFilter::default()).after(1);
    let next = async |watch: &mut counterpoint_client::WatchJobs| {
        tokio::time::timeout(Duration::from_secs(20), watch.next()).await.expect("an update comes").unwrap()
    };
    assert_eq!(next(&mut watch).await, JobUpdate::Anew);
    let job = submit(&client, program(3)).await;
    client.wait(&job).await.unwrap();
    loop {
        match next(&mut watch).await {
            JobUpdate::Job(status) if status.job_id == job && status.ended_ms > 0 => break,
            JobUpdate::Job(_) => {}
            other => panic!("{other:?}"),
        }
    }
    server.stop().await;
}
