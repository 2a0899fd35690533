//! Floods of HTTP/2 frames: each ends with GOAWAY or is read no further, and others are served meanwhile.

use std::time::Duration;

use counterpoint_proto::v1;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};

use crate::support::*;

const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
/// Types of frames, RFC 9113 section 6.
const DATA: u8 = 0;
const HEADERS: u8 = 1;
const RST_STREAM: u8 = 3;
const SETTINGS: u8 = 4;
const PING: u8 = 6;
const GOAWAY: u8 = 7;
const CONTINUATION: u8 = 9;
const END_HEADERS: u8 = 4;
/// The code with which a peer that asks for too much is sent away.
const ENHANCE_YOUR_CALM: u32 = 11;
/// A server that has not ended a flood by then does not end it.
const PATIENCE: Duration = Duration::from_secs(20);
/// A server that reads nothing for so long reads no more.
const STALL: Duration = Duration::from_secs(1);
/// Far more than the buffers of a connection hold, bytes.
const MOST: usize = 256 << 20;

/// A kind of flood.
#[derive(Debug, Clone, Copy)]
pub enum Flood {
    /// Streams that are opened and reset at once.
    RapidReset,
    /// Headers that never end.
    Continuation,
    /// Empty frames of data on a stream whose call reads no more.
    EmptyData,
    /// Frames with a byte on such a stream.
    TinyData,
    /// Pings with unread answers.
    Pings,
    /// Settings with unread acknowledgements.
    Settings,
}

impl Flood {
    pub const ALL: [Self; 6] =
        [Self::RapidReset, Self::Continuation, Self::EmptyData, Self::TinyData, Self::Pings, Self::Settings];
}

pub fn frame(kind: u8, flags: u8, stream: u32, payload: &[u8]) -> Vec<u8> {
    let length = u32::try_from(payload.len()).unwrap().to_be_bytes();
    let mut frame = length[1..].to_vec();
    frame.extend([kind, flags]);
    frame.extend(stream.to_be_bytes());
    frame.extend(payload);
    frame
}

/// A header block without compression: literals that are not indexed, RFC 7541 section 6.2.2.
fn block(path: &str) -> Vec<u8> {
    let mut out = Vec::new();
    for (name, value) in [
        (":method", "POST"),
        (":scheme", "http"),
        (":path", path),
        (":authority", "x"),
        ("content-type", "application/grpc"),
        ("te", "trailers"),
    ] {
        out.push(0);
        for text in [name, value] {
            out.push(u8::try_from(text.len()).unwrap());
            out.extend(text.as_bytes());
        }
    }
    out
}

/// A message of gRPC with its head.
fn message(message: &impl prost::Message) -> Vec<u8> {
    let content = message.encode_to_vec();
    let mut out = vec![0];
    out.extend(u32::try_from(content.len()).unwrap().to_be_bytes());
    out.extend(content);
    out
}

/// Result of a flood.
#[derive(Debug, PartialEq, Eq)]
pub enum Answer {
    /// The server has sent GOAWAY with this code.
    Away(u32),
    /// The server has closed the connection.
    Closed,
    /// The server has read no more for [`STALL`].
    Unread,
}

/// Writes frames until the server lets go or reads no more.
async fn pour(mut to: OwnedWriteHalf, job: String, flood: Flood) -> Answer {
    let mut out = PREFACE.to_vec();
    out.extend(frame(SETTINGS, 0, 0, &[]));
    let watch = "/counterpoint.v1.Jobs/WatchJob";
    match flood {
        Flood::EmptyData | Flood::TinyData => {
            let request = v1::WatchJobRequest { job_id: job, ..Default::default() };
            out.extend(frame(HEADERS, END_HEADERS, 1, &block(watch)));
            out.extend(frame(DATA, 0, 1, &message(&request)));
        }
        Flood::Continuation => out.extend(frame(HEADERS, 0, 1, &block(watch))),
        Flood::RapidReset | Flood::Pings | Flood::Settings => {}
    }
    let (block, mut stream, mut poured) = (block(watch), 1_u32, 0);
    loop {
        for _ in 0..100 {
            match flood {
                Flood::RapidReset => {
                    out.extend(frame(HEADERS, END_HEADERS, stream, &block));
                    out.extend(frame(RST_STREAM, 0, stream, &8_u32.to_be_bytes()));
                    stream += 2;
                }
                Flood::Continuation => out.extend(frame(CONTINUATION, 0, 1, b"\0\x01x\x01y")),
                Flood::EmptyData => out.extend(frame(DATA, 0, 1, &[])),
                Flood::TinyData => out.extend(frame(DATA, 0, 1, &[0])),
                Flood::Pings => out.extend(frame(PING, 0, 0, &[7; 8])),
                Flood::Settings => out.extend(frame(SETTINGS, 0, 0, &[])),
            }
        }
        match tokio::time::timeout(STALL, to.write_all(&out)).await {
            Ok(Ok(())) => poured += out.len(),
            Ok(Err(_)) => return Answer::Closed,
            Err(_) => return Answer::Unread,
        }
        assert!(poured <= MOST, "the server reads {flood:?} without an end");
        out.clear();
    }
}

/// Reads frames up to a GOAWAY with an error; none if the server has just closed.
async fn away(mut from: OwnedReadHalf) -> Option<u32> {
    loop {
        let mut head = [0; 9];
        from.read_exact(&mut head).await.ok()?;
        let length = u32::from_be_bytes([0, head[0], head[1], head[2]]);
        let mut payload = vec![0; usize::try_from(length).unwrap()];
        from.read_exact(&mut payload).await.ok()?;
        if head[3] == GOAWAY {
            let code = u32::from_be_bytes(payload[4..8].try_into().unwrap());
            if code != 0 {
                return Some(code);
            }
        }
    }
}

/// Floods a server with a job that is running, until it answers.
pub async fn flood(address: &str, job: &str, flood: Flood) -> Answer {
    let (from, to) = TcpStream::connect(address).await.unwrap().into_split();
    let poured = tokio::spawn(pour(to, job.to_owned(), flood));
    let answer = match flood {
        // A client that does not read the answers is not read from either: that holds no more than the buffers of a
        // connection.
        Flood::Pings | Flood::Settings => {
            let answer = poured.await.unwrap();
            drop(from);
            return answer;
        }
        _ => tokio::time::timeout(PATIENCE, away(from)).await.unwrap_or_else(|_| panic!("{flood:?} does not end")),
    };
    poured.abort();
    answer.map_or(Answer::Closed, Answer::Away)
}

#[tokio::test(flavor = "multi_thread")]
async fn floods_of_frames_are_sent_away_and_others_are_served() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let running = server.submit("running", "EVENTS 3\nHANG").await;
    server.until(&running, v1::JobState::Running).await;
    let address = server.handle.address().to_string();
    for kind in Flood::ALL {
        let expected = match kind {
            Flood::Pings | Flood::Settings => Answer::Unread,
            _ => Answer::Away(ENHANCE_YOUR_CALM),
        };
        assert_eq!(flood(&address, &running, kind).await, expected, "{kind:?}");
    }
    let mut floods = tokio::task::JoinSet::new();
    for kind in Flood::ALL {
        let (address, running) = (address.clone(), running.clone());
        floods.spawn(async move { flood(&address, &running, kind).await });
    }
    for number in 0..5 {
        let job = server.submit(&format!("r-{number}"), "EVENTS 3").await;
        assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    }
    floods.join_all().await;
    assert_eq!(server.status(&running).await.state(), v1::JobState::Running);
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    server.stop().await;
}
