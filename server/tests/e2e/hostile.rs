//! All hostile cases at once against a server on the real emulator, as a process of its own: each case is answered by
//! name, the work of others is done, and the server stays small.

use counterpoint_proto::v1;
use counterpoint_proto::v1::JobLimit as Limit;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_proto::v1::machines_client::MachinesClient;
use counterpoint_proto::v1::results_client::ResultsClient;
use tokio::io::AsyncWriteExt as _;
use tokio::net::TcpStream;
use tonic::transport::{Channel, Endpoint};

use crate::descriptors::Process;
use crate::floods::{Flood, flood};
use crate::support::{digest, reason};

/// Most memory of the server.
const MEMORY: u64 = 1 << 30;

/// Maximum number of diagnostics that a job keeps, for any request.
const MOST_DIAGNOSTICS: usize = 10_000;

/// The most that a client can write into its limits.
fn most() -> v1::JobLimits {
    v1::JobLimits {
        simulated_ns: i64::MAX,
        blocks: u64::MAX,
        zero_time_blocks: 1 << 63,
        events: u64::MAX,
        block_length: u32::MAX,
        nesting: 1000,
        diagnostics: u32::MAX,
        memory: u64::MAX,
        macro_steps: u64::MAX,
        wall_ms: 1 << 63,
        max_job_bytes: u64::MAX,
    }
}

/// A caller of the server.
struct Caller(Channel);

impl Caller {
    fn jobs(&self) -> JobsClient<Channel> {
        JobsClient::new(self.0.clone())
    }

    fn machines(&self) -> MachinesClient<Channel> {
        MachinesClient::new(self.0.clone())
    }

    async fn upload(&self, content: &[u8]) -> String {
        let name = digest(content);
        let mut chunks: Vec<_> = content
            .chunks(1 << 20)
            .map(|data| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() })
            .collect();
        chunks.insert(0, v1::UploadRequest { digest: name.clone(), ..Default::default() });
        BlobsClient::new(self.0.clone()).upload(tokio_stream::iter(chunks)).await.unwrap();
        name
    }

    async fn submit(&self, name: &str, machine: &str, program: &[u8], limits: Option<v1::JobLimits>) -> String {
        let digest = self.upload(program).await;
        let request = v1::SubmitJobRequest {
            request_id: name.into(),
            machine: machine.into(),
            programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
            files: vec![v1::FileRef { path: "main.nc".into(), digest }],
            options: Some(v1::JobOptions { limits, ..Default::default() }),
            ..Default::default()
        };
        self.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
    }

    async fn wait(&self, job: &str) -> v1::JobStatus {
        loop {
            let request = v1::WaitJobRequest { job_id: job.into(), timeout_ms: 60_000 };
            let status = self.jobs().wait_job(request).await.unwrap().into_inner().status.unwrap();
            if status.ended_ms > 0 {
                return status;
            }
        }
    }

    async fn until_running(&self, job: &str) {
        for _ in 0..20_000 {
            let status = self.jobs().get_job(v1::GetJobRequest { job_id: job.into() }).await.unwrap().into_inner();
            let status = status.status.unwrap();
            assert_eq!(status.ended_ms, 0, "{status:?}");
            if status.state() == v1::JobState::Running {
                return;
            }
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
        panic!("{job} never ran");
    }

    /// End of the summary of a job: verdict and diagnostics, or the reason why there is none.
    async fn summary(&self, job: &str) -> String {
        let request = v1::GetSummaryRequest { job_id: job.into() };
        let mut chunks = match ResultsClient::new(self.0.clone()).get_summary(request).await {
            Ok(chunks) => chunks.into_inner(),
            Err(status) => return status.to_string(),
        };
        let mut text = Vec::new();
        while let Some(chunk) = chunks.message().await.unwrap() {
            text.extend_from_slice(&chunk.data);
        }
        let summary: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let diagnostics = summary["diagnostics"].as_array().unwrap();
        let first: Vec<_> = diagnostics.iter().take(3).map(|one| format!("{} {}", one["name"], one["text"])).collect();
        assert!(diagnostics.len() <= MOST_DIAGNOSTICS, "{} diagnostics are kept", diagnostics.len());
        format!("{} {first:?} of {}", summary["verdict"]["text"], diagnostics.len())
    }

    /// Puts a machine with a macro at each tool change.
    async fn put_machine(&self, name: &str, text: &str) {
        let toml = format!("extends = \"fanuc-mill\"\n[ce]\nname = \"{name}\"\n[macros]\ntool = \"t.mac\"\n");
        let mut files = Vec::new();
        for (path, content) in [("machine.toml", toml.as_str()), ("t.mac", text)] {
            let digest = self.upload(content.as_bytes()).await;
            files.push(v1::MachineFile { path: format!("{name}/{path}"), digest });
        }
        self.machines().put_machine(v1::PutMachineRequest { name: name.into(), files }).await.unwrap();
    }
}

/// Most memory that a process has had.
fn peak(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").trim().parse::<u64>().unwrap() * 1024
}

#[tokio::test(flavor = "multi_thread")]
async fn every_hostile_case_is_answered_by_name_and_the_server_stays_small() {
    const HOARD: &str = "DECLAR/OBJECT,SEQUENCE,HOARD\nT='0123456789'\nDO/I=1,12\nT=T//T\nENDOF/DO\n\
        DO/I=1,50\nHOARD+=T//'x'\nENDOF/DO\n";
    const SPIN: &str = "WHILE/1.EQ.1\nA=1\nENDOF/WHILE\n";
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--max-wall-ms", "60000", "--max-job-bytes", "8388608", "--workers", "2"];
    let server = Process::start_with(folder.path(), &arguments);
    let connect =
        async || Caller(Endpoint::from_shared(format!("http://{}", server.address)).unwrap().connect().await.unwrap());
    let client = connect().await;
    client.put_machine("hoard", HOARD).await;
    client.put_machine("spin", SPIN).await;

    // Case 5: one blob under many names.
    let blob = client.upload(&vec![b' '; 1 << 20]).await;
    let file = |n| v1::MachineFile { path: format!("many/{n}.tps"), digest: blob.clone() };
    let many = v1::CheckMachineRequest { name: "many".into(), files: (0..400).map(file).collect() };
    let refused = client.machines().check_machine(many).await.unwrap_err();
    assert_eq!(reason(&refused), "MACHINE_TOO_LARGE");

    // Cases 4 to 6: limits that no job may have.
    let line = [b"O1\n".as_slice(), &b"X1".repeat(8 << 20), b"\nM30\n"].concat();
    let mut jobs = Vec::new();
    for (name, machine, program, limit, named) in [
        ("endless", "fanuc-mill", b"O1\nN1 G4 P1\nGOTO 1\n".to_vec(), Limit::MaxJobBytes, ""),
        ("loop", "fanuc-mill", b"O1\nN1 #1=#1+1\nGOTO 1\n".to_vec(), Limit::MaxJobBytes, ""),
        ("diagnostics", "fanuc-mill", b"O1\nN1 G1 Q7\nGOTO 1\n".to_vec(), Limit::MaxJobBytes, "] of 10000"),
        ("hoard", "hoard", b"O1\nN1 T3 M06\nT4 M06\nGOTO 1\n".to_vec(), Limit::Memory, "HOARD"),
        ("spin", "spin", b"O1\nT3 M06\nM30\n".to_vec(), Limit::Unspecified, "macro-steps-limit"),
        ("line", "fanuc-mill", line.clone(), Limit::Unspecified, "block-too-long"),
    ] {
        jobs.push((name, client.submit(name, machine, &program, Some(most())).await, limit, named));
    }
    // The longest blocks that the server accepts, in a loop: an alarm would end the job before its cancel.
    let long = [b"O1\nN1 G4 P1 (".as_slice(), &b"X1".repeat((1 << 19) - 16), b")\nGOTO 1\n"].concat();
    let cancelled = client.submit("cancelled", "fanuc-mill", &long, Some(most())).await;

    // Case 8: connections that say nothing, begin to speak, or upload without end.
    let mut silent = Vec::new();
    for n in 0..300 {
        let mut stream = TcpStream::connect(&server.address).await.unwrap();
        if n % 3 == 0 {
            stream.write_all(b"PRI * HT").await.unwrap();
        }
        silent.push(stream);
    }
    let (hold, stalled) = tokio::sync::mpsc::channel(1);
    hold.send(v1::UploadRequest { digest: digest(b"never"), data: "n".into(), size: None }).await.unwrap();
    let mut blobs = BlobsClient::new(client.0.clone());
    let stalled = tokio::spawn(async move { blobs.upload(tokio_stream::wrappers::ReceiverStream::new(stalled)).await });

    // Floods of frames beside all that.
    let mut floods = tokio::task::JoinSet::new();
    for kind in Flood::ALL {
        let (address, job) = (server.address.clone(), jobs[0].1.clone());
        floods.spawn(async move { flood(&address, &job, kind).await });
    }

    // The work of another client is done in the meantime.
    let other = connect().await;
    let honest = other.submit("honest", "fanuc-mill", b"O1\nG21 G90 G94 F100\nG1 X1.\nM30\n", None).await;
    client.until_running(&cancelled).await;
    let cancel = v1::CancelJobRequest { job_id: cancelled.clone() };
    client.jobs().cancel_job(cancel).await.unwrap();
    floods.join_all().await;
    for (name, job, limit, named) in &jobs {
        let status = client.wait(job).await;
        let cause = if *limit == Limit::Unspecified { v1::JobCause::Program } else { v1::JobCause::Limit };
        let (expected, summary) = ((v1::JobState::Failed, cause, *limit), client.summary(job).await);
        assert_eq!((status.state(), status.cause(), status.limit()), expected, "{name}: {status:?} {summary}");
        assert!(summary.contains(named), "{name}: {summary}");
    }
    assert_eq!(client.wait(&cancelled).await.state(), v1::JobState::Cancelled);
    assert_eq!(other.wait(&honest).await.state(), v1::JobState::Succeeded);

    // Case 13: shipped machines cannot be replaced.
    let own = v1::PutMachineRequest { name: "fanuc-mill".into(), files: vec![file(1)] };
    assert_eq!(reason(&client.machines().put_machine(own).await.unwrap_err()), "MACHINE_SHIPPED");
    stalled.abort();
    drop((silent, hold));
    let peak = peak(server.child.id());
    println!("the server had {} MiB at most", peak >> 20);
    assert!(peak <= MEMORY, "{peak} bytes");
}
