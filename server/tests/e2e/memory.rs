//! Memory of jobs that wait and of lists of them, in a server in a separate process, over encrypted connections.

use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint};

use crate::descriptors::Process;
use crate::killed::resident;
use crate::support::digest;
use crate::tls::Authority;

/// Jobs before the measurement, which fill what the server keeps in any case, and jobs that are measured.
const FIRST: usize = 16;
const MORE: usize = 40;
/// Lists at the same time.
const LISTS: usize = 6;
const MIB: u64 = 1 << 20;

const PROGRAM: &str = "O1\nG4 P9\nM30\n";

/// 3.9 MB of answers to dialogs.
fn answers() -> Vec<v1::DialogAnswer> {
    let text = v1::DialogValue { value: Some(v1::dialog_value::Value::Text("x".repeat(9_700))) };
    let answer = v1::DialogAnswer { dialog: "D".into(), values: [("V".to_owned(), text)].into(), ..Default::default() };
    vec![answer; 400]
}

/// The memory of a server with waiting jobs and several lists of them does not depend on the size of their requests.
#[tokio::test(flavor = "multi_thread")]
async fn waiting_jobs_and_lists_of_them_take_no_memory_for_their_answers() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new();
    authority.serve(folder.path());
    let file = |name| folder.path().join(name).display().to_string();
    let (certificate, key) = (file("cert.pem"), file("key.pem"));
    let server = Process::start_with(folder.path(), &["--workers", "1", "--tls-cert", &certificate, "--tls-key", &key]);
    let endpoint = Endpoint::from_shared(format!("https://{}", server.address)).unwrap();
    let tls = ClientTlsConfig::new().ca_certificate(Certificate::from_pem(&authority.pem)).domain_name("localhost");
    let channel = endpoint.tls_config(tls).unwrap().connect().await.unwrap();
    let name = digest(PROGRAM.as_bytes());
    let upload = v1::UploadRequest { digest: name.clone(), data: PROGRAM.as_bytes().into(), size: None };
    BlobsClient::new(channel.clone()).upload(tokio_stream::iter([upload])).await.unwrap();
    let request = |number: usize, options| v1::SubmitJobRequest {
        request_id: number.to_string(),
        machine: "fanuc-mill".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: name.clone() }],
        options: Some(options),
        ..Default::default()
    };
    let mut jobs = JobsClient::new(channel.clone());
    // It stops before its first block and keeps the only worker.
    let stepped = v1::JobOptions { stepped: true, ..Default::default() };
    jobs.submit_job(request(0, stepped)).await.unwrap();
    let mut submit = async |number| {
        let request = request(number, v1::JobOptions { answers: answers(), ..Default::default() });
        jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
    };
    let mut job = String::new();
    for number in 1..FIRST {
        job = submit(number).await;
    }
    assert!(list(channel.clone()).await.len() >= FIRST);
    let before = resident(server.child.id());
    for number in FIRST..FIRST + MORE {
        submit(number).await;
    }
    let waiting = resident(server.child.id()).saturating_sub(before);
    let lists: Vec<_> = (0..LISTS).map(|_| tokio::spawn(list(channel.clone()))).collect();
    let mut most = 0;
    while !lists.iter().all(tokio::task::JoinHandle::is_finished) {
        most = most.max(resident(server.child.id()).saturating_sub(before));
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    for list in lists {
        assert_eq!(list.await.unwrap().len(), FIRST + MORE);
    }
    println!("{MORE} waiting jobs: {} MiB; {LISTS} lists: {} MiB", waiting / MIB, most / MIB);
    assert!(waiting < 40 * MIB, "{} MiB for {MORE} waiting jobs", waiting / MIB);
    assert!(most < 40 * MIB, "{} MiB while {LISTS} lists are read", most / MIB);
    let got = JobsClient::new(channel).max_decoding_message_size(8 << 20);
    let got = { got }.get_job(v1::GetJobRequest { job_id: job }).await.unwrap().into_inner();
    assert_eq!(got.options.unwrap().answers, answers(), "a request is returned as it was sent");
}

/// All jobs, in pages.
async fn list(channel: Channel) -> Vec<v1::JobStatus> {
    let mut jobs = JobsClient::new(channel);
    let (mut found, mut page_token) = (Vec::new(), String::new());
    loop {
        let request = v1::ListJobsRequest { page_token, page_size: 500, ..Default::default() };
        let page = jobs.list_jobs(request).await.unwrap().into_inner();
        found.extend(page.jobs);
        page_token = page.next_page_token;
        if page_token.is_empty() {
            return found;
        }
    }
}
