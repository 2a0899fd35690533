//! Service `ResultsService`: stored results from their files, others made from the log.

use std::io::{self, Cursor, Read, Write};
use std::sync::Arc;

use bytes::Bytes;
use counterpoint_kernel::control::StopSignal;
use counterpoint_kernel::event::Text;
use counterpoint_kernel::files::JobFiles as _;
use counterpoint_kernel::job::RunEnd;
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::listing::Crlf;
use counterpoint_proto::v1;
use counterpoint_proto::v1::results_server::Results as Service;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status};

use super::door::enter;
use super::stream::{ChunkResponse, making, stream};
use super::{ResultsService, job, page};
use crate::JobRecord;
use crate::access::Caller;
use crate::jobs::turns::OwnTurn;
use crate::jobs::{Core, JobSandbox, worker};
use crate::ledger::record::JobState;
use crate::log::damage::gone;
use crate::log::kept::StoredLog;
use crate::log::reader::Gone;
use crate::reason::Refusal;
use crate::results::{ListingForm, ResultSource, StoredResult};

macro_rules! chunks {
    ($($type:ident),*) => { $(
        impl ChunkResponse for v1::$type {
            fn chunk(data: Bytes) -> Self {
                Self { data }
            }
        }
    )* };
}

chunks!(
    GetTraceResponse,
    GetListingResponse,
    GetTimelineResponse,
    GetToolpathResponse,
    GetSummaryResponse,
    GetEventsResponse,
    GetFileResponse
);

type Answer<T> = Result<Response<ReceiverStream<Result<T, Status>>>, Status>;

#[tonic::async_trait]
impl Service for ResultsService {
    type GetListingStream = ReceiverStream<Result<v1::GetListingResponse, Status>>;

    async fn get_listing(&self, request: Request<v1::GetListingRequest>) -> Answer<v1::GetListingResponse> {
        let (caller, request) = enter(request)?;
        let (ended, turn) = LoggedJob::load(&self.0, &caller, request.job_id).await?;
        let channel = if request.channel == 0 && !request.log { 0 } else { ended.channel(request.channel)? };
        let form = match request {
            v1::GetListingRequest { console: true, .. } => ListingForm::Console,
            v1::GetListingRequest { log: true, .. } => ListingForm::Log,
            _ => ListingForm::Listing,
        };
        Ok(stream(turn, move |out, gone| match request.crlf {
            true => ended.listing((channel, form), &mut Crlf(out), gone),
            false => ended.listing((channel, form), out, gone),
        }))
    }

    type GetTraceStream = ReceiverStream<Result<v1::GetTraceResponse, Status>>;

    async fn get_trace(&self, request: Request<v1::GetTraceRequest>) -> Answer<v1::GetTraceResponse> {
        let (caller, request) = enter(request)?;
        let (ended, turn) = LoggedJob::load(&self.0, &caller, request.job_id).await?;
        let channel = ended.channel(request.channel)?;
        Ok(stream(turn, move |out, gone| Ok(ended.source(gone).trace(channel, out)?)))
    }

    type GetTimelineStream = ReceiverStream<Result<v1::GetTimelineResponse, Status>>;

    async fn get_timeline(&self, request: Request<v1::GetTimelineRequest>) -> Answer<v1::GetTimelineResponse> {
        let (caller, request) = enter(request)?;
        let document = match format(request.format)? {
            v1::DrawingFormat::Json => StoredResult::TimelineJson,
            _ => StoredResult::TimelineSvg,
        };
        document_of(&self.0, &caller, request.job_id, document).await
    }

    type GetToolpathStream = ReceiverStream<Result<v1::GetToolpathResponse, Status>>;

    async fn get_toolpath(&self, request: Request<v1::GetToolpathRequest>) -> Answer<v1::GetToolpathResponse> {
        let (caller, request) = enter(request)?;
        if !self.0.options.embedded.toolpath {
            return Err(Refusal::NoResults(request.job_id).into());
        }
        let document = match format(request.format)? {
            v1::DrawingFormat::Json => StoredResult::ToolpathJson,
            _ => StoredResult::ToolpathSvg,
        };
        document_of(&self.0, &caller, request.job_id, document).await
    }

    type GetSummaryStream = ReceiverStream<Result<v1::GetSummaryResponse, Status>>;

    async fn get_summary(&self, request: Request<v1::GetSummaryRequest>) -> Answer<v1::GetSummaryResponse> {
        let (caller, request) = enter(request)?;
        document_of(&self.0, &caller, request.job_id, StoredResult::Summary).await
    }

    type GetEventsStream = ReceiverStream<Result<v1::GetEventsResponse, Status>>;

    async fn get_events(&self, request: Request<v1::GetEventsRequest>) -> Answer<v1::GetEventsResponse> {
        let (caller, request) = enter(request)?;
        let (ended, turn) = LoggedJob::load(&self.0, &caller, request.job_id).await?;
        Ok(stream(turn, move |out, gone| Ok(ended.source(gone).jsonl(out)?)))
    }

    async fn list_files(
        &self,
        request: Request<v1::ListFilesRequest>,
    ) -> Result<Response<v1::ListFilesResponse>, Status> {
        let (caller, request) = enter(request)?;
        let (mut files, _) = written(&self.0, &caller, request.job_id).await?;
        files.sort();
        let known = |file: &(String, String)| file.0 == request.page_token;
        if !request.page_token.is_empty() && !files.iter().any(known) {
            return Err(Refusal::field("page_token", "is not a next_page_token of this call").into());
        }
        let file =
            |(path, text): &(String, String)| Ok(v1::WrittenFile { path: path.clone(), size: text.len() as u64 });
        let size = (request.page_size, 10_000);
        let (files, next_page_token) = page(&files, size, &request.page_token, |file| &file.0, file)?;
        Ok(Response::new(v1::ListFilesResponse { files, next_page_token }))
    }

    type GetFileStream = ReceiverStream<Result<v1::GetFileResponse, Status>>;

    async fn get_file(&self, request: Request<v1::GetFileRequest>) -> Answer<v1::GetFileResponse> {
        let (caller, v1::GetFileRequest { job_id, path }) = enter(request)?;
        let (files, turn) = written(&self.0, &caller, job_id).await?;
        let file = files.into_iter().find(|(name, _)| *name == path);
        let (_, text) = file.ok_or(Refusal::UnknownFile(path))?;
        Ok(stream(turn, move |out, _| Ok(out.write_all(text.as_bytes())?)))
    }
}

/// A format that this server knows.
fn format(number: i32) -> Result<v1::DrawingFormat, Refusal> {
    v1::DrawingFormat::try_from(number).map_err(|_| Refusal::field("format", format!("{number} is not a format")))
}

/// Files written by the macros of an ended job.
async fn written(core: &Arc<Core>, caller: &Caller, id: String) -> Result<(Vec<(String, String)>, OwnTurn), Refusal> {
    let turn = core.streams.renders.turn(caller.tenant()).await;
    let (core, caller) = (core.clone(), caller.clone());
    making(turn, move |_| {
        let record = ended(&core, &caller, &id)?;
        let kept = match core.logs.open(&record.id, StoredResult::Files.file()) {
            Err(error) if error.kind() == io::ErrorKind::InvalidData => return Err(lost_files(&id)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            other => {
                let mut text = Vec::new();
                other?.read_to_end(&mut text)?;
                Some(text)
            }
        };
        let live = || core.live(&id).and_then(|live| live.finished()?.document(StoredResult::Files));
        let text = match kept.or_else(live) {
            Some(text) => text,
            None if record.runs.has_files => {
                return Err(lost_files(&id));
            }
            None => return Ok(Vec::new()),
        };
        serde_json::from_slice(&text).map_err(|error| Refusal::Storage(error.to_string()))
    })
    .await
}

fn lost_files(id: &str) -> Refusal {
    Refusal::DataLoss(format!(
        "the files that the macros of job '{id}' have written are damaged or gone; submit the job again, it writes them \
         again"
    ))
}

/// A stored result, or a job from whose log the result is made.
enum ResultLookup {
    Kept(Box<dyn Read + Send>),
    Job(Box<LoggedJob>),
}

async fn document_of<T: ChunkResponse>(
    core: &Arc<Core>,
    caller: &Caller,
    id: String,
    document: StoredResult,
) -> Answer<T> {
    let turn = core.streams.renders.turn(caller.tenant()).await;
    let (core, caller, job) = (core.clone(), caller.clone(), id.clone());
    let find = move |_: &Gone| {
        let record = ended(&core, &caller, &id)?;
        if let Ok(file) = core.logs.open(&record.id, document.file()) {
            return Ok(ResultLookup::Kept(file));
        }
        let live = core.live(&id).and_then(|live| live.finished()?.document(document));
        match live {
            Some(text) => Ok(ResultLookup::Kept(Box::new(Cursor::new(text)))),
            None => LoggedJob::of(core, record).map(Box::new).map(ResultLookup::Job),
        }
    };
    let found = making(turn, find).await.map_err(|refusal| refusal.of_job(&job))?;
    let (ended, turn) = match found {
        (ResultLookup::Kept(mut kept), turn) => {
            return Ok(stream(turn, move |out, _| Ok(io::copy(&mut kept, out).map(drop)?)));
        }
        (ResultLookup::Job(ended), turn) => (ended, turn),
    };
    let (text, turn) = making(turn, move |gone| Ok(ended.source(gone).document(document)?)).await?;
    Ok(stream(turn, move |out, _| Ok(out.write_all(&text)?)))
}

/// A job that has ended with results. All other data in its folder is from a run that did not reach its end.
fn ended(core: &Core, caller: &Caller, id: &str) -> Result<JobRecord, Refusal> {
    let record = job(core, caller, id)?;
    if !record.state.ended() {
        return Err(Refusal::JobNotEnded(id.to_owned()));
    }
    if record.log_digest.is_empty() { Err(Refusal::NoResults(id.to_owned())) } else { Ok(record) }
}

/// An ended job with its description and sources.
struct LoggedJob {
    core: Arc<Core>,
    record: JobRecord,
    info: Arc<Info>,
    log: StoredLog,
}

impl LoggedJob {
    /// Loads a job when it is the tenant's turn to make results.
    async fn load(core: &Arc<Core>, caller: &Caller, id: String) -> Result<(Self, OwnTurn), Refusal> {
        let turn = core.streams.renders.turn(caller.tenant()).await;
        let (core, caller, job) = (core.clone(), caller.clone(), id.clone());
        let loaded = making(turn, move |_| {
            let record = ended(&core, &caller, &id)?;
            Self::of(core, record)
        });
        loaded.await.map_err(|refusal| refusal.of_job(&job))
    }

    /// A job that has ended with results.
    fn of(core: Arc<Core>, record: JobRecord) -> Result<Self, Refusal> {
        let id = &record.id;
        let Some(log) = core.kept_log(id)? else {
            let lost = record.events > 0 && core.options.embedded.log;
            return Err(if lost { gone(id).into() } else { Refusal::NoResults(id.clone()) });
        };
        let mut work = core.work(id)?;
        let sandbox = JobSandbox::new(core.blobs.of(&record.tenant), std::mem::take(&mut work.files));
        let info = match core.live(id).and_then(|live| live.run().map(|run| run.info.clone())) {
            Some(info) => info,
            None => match worker::prepare(&core, &record, work, &sandbox, &StopSignal::default())? {
                Ok(prepared) => prepared.info().clone(),
                Err(_) => {
                    sandbox.trouble()?;
                    return Err(Refusal::NoResults(id.clone()));
                }
            },
        };
        load_texts(&info, &sandbox);
        Ok(Self { core, record, info, log })
    }

    fn source(&self, gone: &Gone) -> ResultSource<'_> {
        let limit = self.record.runs.limit.as_str();
        let cancelled = self.record.state == JobState::Cancelled || !limit.is_empty();
        let outcome = RunEnd { events: self.record.events, cancelled, sink_failed: false };
        ResultSource { info: &self.info, outcome, log: &self.log, limit, gone: gone.clone() }
    }

    fn channel(&self, number: u32) -> Result<u16, Refusal> {
        let channel = u16::try_from(number).ok().filter(|&number| self.info.channel(number).is_some());
        channel.ok_or(Refusal::UnknownChannel(number))
    }

    fn listing(&self, (channel, form): (u16, ListingForm), out: &mut dyn Write, gone: &Gone) -> Result<(), Refusal> {
        let known = self.core.live(&self.record.id).and_then(|live| live.finished().cloned());
        let finished = match known {
            Some(finished) => finished,
            None => Arc::new(self.source(gone).fold()?),
        };
        Ok(self.source(gone).listing(&finished, channel, form, out)?)
    }
}

/// Loads the texts that results quote and that the run did not load.
fn load_texts(info: &Info, files: &JobSandbox) {
    for file in &info.files {
        let load = || files.read(&file.name).ok().map(|bytes| Arc::new(Text::new(bytes, || false)));
        file.text.get_or_init(load);
    }
}
