//! Threads of a server with many jobs, as a process of its own.

use std::collections::BTreeSet;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use tonic::transport::Endpoint;

use crate::descriptors::Process;
use crate::support::digest;

const JOBS: usize = 1000;

/// Ends of jobs that are stored at a time, which need no core.
const STORING: usize = 64;

/// Two channels that meet.
const PROGRAMS: [(&str, &str); 2] = [
    ("c1.nc", "%\nO1\nG0 X50. Z5.\nM101\nG1 Z-20. F0.2\nG1 Z-40.\nM102\nG0 X60.\nM30\n%\n"),
    ("c2.nc", "%\nO2\nG0 X50. Z5.\nM101\nG1 Z-20. F0.3\nM102\nG1 Z-40.\nG0 X60.\nM30\n%\n"),
];

/// Set in the flags of a thread from the moment at which it ends (`PF_EXITING` of Linux): a thread that joins it
/// continues before it leaves the table of processes.
const EXITING: u64 = 4;

/// Threads of a server that run jobs.
#[derive(Default)]
struct Threads {
    /// Those of single kernels.
    kernels: BTreeSet<String>,
    /// Those of kernels, and those that run a job, judge it or store its end.
    all: BTreeSet<String>,
}

impl Threads {
    fn of(process: u32) -> Self {
        let mut threads = Self::default();
        for task in std::fs::read_dir(format!("/proc/{process}/task")).unwrap() {
            // A thread may end meanwhile.
            let Ok(stat) = std::fs::read_to_string(task.unwrap().path().join("stat")) else { continue };
            let (head, tail) = stat.rsplit_once(')').unwrap();
            let (number, name) = head.split_once(" (").unwrap();
            let fields: Vec<&str> = tail.split_whitespace().collect();
            let exiting = fields[6].parse::<u64>().unwrap() & EXITING != 0;
            let kernel = name.starts_with("kernel-");
            if kernel && !exiting {
                threads.kernels.insert(number.to_owned());
            }
            if (kernel || name.starts_with("job")) && !exiting {
                threads.all.insert(number.to_owned());
            }
        }
        threads
    }

    /// Those that two looks have seen. Threads are looked at one after the other, so one look may see two that never
    /// lived together; those that a second look sees again were all there when the first one ended.
    fn and(&self, later: &Self) -> Self {
        let both = |a: &BTreeSet<String>, b: &BTreeSet<String>| a.intersection(b).cloned().collect();
        Self { kernels: both(&self.kernels, &later.kernels), all: both(&self.all, &later.all) }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_thousand_jobs_of_two_channels_need_no_more_threads_than_there_are_places() {
    let folder = tempfile::tempdir().unwrap();
    let server = Process::start(folder.path());
    let channel = Endpoint::from_shared(format!("http://{}", server.address)).unwrap().connect().await.unwrap();
    let (mut blobs, mut jobs) = (BlobsClient::new(channel.clone()), JobsClient::new(channel));
    let mut files = Vec::new();
    for (path, text) in PROGRAMS {
        let name = digest(text.as_bytes());
        let upload = v1::UploadRequest { digest: name.clone(), data: text.into(), size: None };
        blobs.upload(tokio_stream::iter([upload])).await.unwrap();
        files.push(v1::FileRef { path: path.into(), digest: name });
    }
    let cores = std::thread::available_parallelism().unwrap().get();
    let (mut kernels, mut all, mut last) = (0, 0, String::new());
    let mut look = || {
        let first = Threads::of(server.child.id());
        let threads = first.and(&Threads::of(server.child.id()));
        (kernels, all) = (threads.kernels.len().max(kernels), threads.all.len().max(all));
    };
    for number in 0..JOBS {
        let programs = PROGRAMS.map(|(path, _)| v1::Program { path: path.into(), ..Default::default() });
        let request = v1::SubmitJobRequest {
            request_id: number.to_string(),
            machine: "fanuc-2path-lathe".into(),
            programs: programs.into(),
            files: files.clone(),
            ..Default::default()
        };
        last = jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
        look();
    }
    loop {
        let request = v1::GetJobRequest { job_id: last.clone() };
        let status = jobs.get_job(request).await.unwrap().into_inner().status.unwrap();
        look();
        if status.ended_ms > 0 {
            assert!(status.events > 0, "{status:?}");
            break;
        }
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    println!("at most {kernels} threads of kernels, {all} threads of jobs, {cores} cores");
    assert!(kernels <= cores, "{kernels} threads of kernels: only a job that is alone has more than one");
    // A place for each core and those whose end is being stored, each of which may be on its way to the next job.
    assert!(all <= 2 * (cores + STORING), "{all} threads of jobs");
}
