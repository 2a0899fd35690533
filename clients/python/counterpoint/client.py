"""Submits jobs, follows them over broken connections, reads results."""

import hashlib
import json
import pathlib
import random
import sys
import time
import uuid
from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple, TypeVar, Union

import grpc

from .timeline import Timeline
from .v1 import blobs_pb2, blobs_pb2_grpc, event_pb2, jobs_pb2, jobs_pb2_grpc
from .v1 import machines_pb2, machines_pb2_grpc, results_pb2, results_pb2_grpc

CHUNK = 64 * 1024
#: Longest time without a message on a watch, s.
HEARTBEAT_S = 5.0


class Progress(NamedTuple):
    """How far a channel is."""

    channel: str
    state: str
    blocks: int
    percent: float
    simulated_s: float
    waiting_for: str


class Event(NamedTuple):
    """What happened, for people: a diagnostic, a message, a wait."""

    number: int
    simulated_s: float
    channel: int
    line: int
    kind: str
    text: str


class JobFailed(Exception):
    """A job that could not be run at all."""


class Unreachable(ConnectionError):
    """No server answers at the address."""


class UnknownMachine(LookupError):
    """A machine that the server does not have; the text names those that it has."""


T = TypeVar("T")
Show = Callable[[List[Progress]], None]
Programs = Union[Sequence[Union[str, pathlib.Path]], Mapping[str, bytes]]


def print_progress(channels: Sequence[Progress]) -> None:
    """Shows progress on standard error: on a terminal one line that is overwritten."""
    parts = [f"{c.channel} {c.percent:3.0f} % block {c.blocks} {c.simulated_s:.1f} s {c.waiting_for or c.state}" for c in channels]
    terminal = sys.stderr.isatty()
    print(("\r\x1b[K" if terminal else "") + " | ".join(parts), end="" if terminal else "\n", file=sys.stderr, flush=True)


class Client:
    """A connection to a server.

    address: HOST:PORT. token: sent with every call. credentials: for a server with TLS
    (grpc.ssl_channel_credentials). patience: seconds after which a call that always fails gives up. reach: seconds
    within which the server must answer for the first time; afterwards patience applies. Raises Unreachable if no
    server answers at the address.
    """

    def __init__(
        self,
        address: str = "127.0.0.1:7878",
        token: Optional[str] = None,
        credentials: Optional[grpc.ChannelCredentials] = None,
        patience: float = 60.0,
        reach: float = 1.5,
    ) -> None:
        options = [("grpc.keepalive_time_ms", 30_000), ("grpc.keepalive_timeout_ms", 10_000)]
        if credentials is None:
            self._channel = grpc.insecure_channel(address, options=options)
        else:
            self._channel = grpc.secure_channel(address, credentials, options=options)
        self._metadata: Tuple[Tuple[str, str], ...] = (("authorization", f"Bearer {token}"),) if token else ()
        self._patience = patience
        self._jobs = jobs_pb2_grpc.JobsStub(self._channel)
        self._blobs = blobs_pb2_grpc.BlobsStub(self._channel)
        self._results = results_pb2_grpc.ResultsStub(self._channel)
        self._machines = machines_pb2_grpc.MachinesStub(self._channel)
        self._reach(address, credentials is not None, reach)

    def _reach(self, address: str, secure: bool, reach: float) -> None:
        """Waits for the first connection."""
        try:
            grpc.channel_ready_future(self._channel).result(timeout=reach)
        except grpc.FutureTimeoutError:
            self._channel.close()
            kind = "server with TLS" if secure else "server without TLS"
            raise Unreachable(f"no {kind} answers at {address}: check the address, or start counterpointd") from None

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connection."""
        self._channel.close()

    def submit(
        self,
        machine: str,
        programs: Programs,
        options: Optional[jobs_pb2.JobOptions] = None,
        request_id: Optional[str] = None,
    ) -> str:
        """Submits programs, left to right onto the channels; returns the id of the job.

        programs: paths, or contents by name; a path may be given for several channels. Raises ValueError if two
        files of one name differ, and UnknownMachine. When this returns, the job is on the disk of the server. The request is repeated
        with its id after a lost connection, so the job is accepted once.
        """
        named = _named(programs)
        request = jobs_pb2.SubmitJobRequest(request_id=request_id or str(uuid.uuid4()), machine=machine, options=options)
        contents: Dict[str, bytes] = {}
        digests: Dict[str, str] = {}
        for name, data in named:
            digest = hashlib.sha256(data).hexdigest()
            if digests.setdefault(name, digest) != digest:
                raise ValueError(f"two programs are named {name} and differ: rename one of them")
            contents[digest] = data
            request.programs.add(path=name)
        for name, digest in digests.items():
            request.files.add(path=name, digest=digest)
        self._upload(contents)
        try:
            answer = self._again(lambda: self._jobs.SubmitJob(request, metadata=self._metadata))
        except grpc.RpcError as error:
            if error.code() == grpc.StatusCode.NOT_FOUND and error.details() == f"no machine '{machine}'":
                raise UnknownMachine(f"no machine '{machine}': the server has {', '.join(self.machines())}") from None
            raise
        return str(answer.status.job_id)

    def machines(self) -> List[str]:
        """Names of the machines of the server."""
        request = machines_pb2.ListMachinesRequest()
        answer = self._again(lambda: self._machines.ListMachines(request, metadata=self._metadata))
        return [machine.name for machine in answer.machines]

    def _upload(self, contents: Mapping[str, bytes]) -> None:
        question = blobs_pb2.FindMissingRequest(digests=list(contents))
        for digest in self._again(lambda: self._blobs.FindMissing(question, metadata=self._metadata)).digests:
            data = contents[digest]

            def chunks(digest: str = digest, data: bytes = data) -> Iterator[blobs_pb2.UploadRequest]:
                yield blobs_pb2.UploadRequest(digest=digest, data=data[:CHUNK], size=len(data))
                for at in range(CHUNK, len(data), CHUNK):
                    yield blobs_pb2.UploadRequest(data=data[at : at + CHUNK])

            self._again(lambda: self._blobs.Upload(chunks(), metadata=self._metadata))

    def events(
        self, job: str, after: int = 0, level: "jobs_pb2.WatchLevel.ValueType" = jobs_pb2.WATCH_LEVEL_DIAGNOSTICS
    ) -> Iterator[jobs_pb2.WatchJobResponse]:
        """Messages of a watch, over broken connections: every event once and in order, the end last."""
        cursor, failures, since = after, 0, None
        while True:
            request = jobs_pb2.WatchJobRequest(
                job_id=job, after_seq=cursor, level=level, heartbeat_ms=int(HEARTBEAT_S * 1000)
            )
            try:
                for message in self._jobs.WatchJob(request, metadata=self._metadata):
                    failures, since = 0, None
                    content = message.WhichOneof("content")
                    if content == "batch":
                        fresh = [event for event in message.batch.events if event.seq > cursor]
                        cursor = max(cursor, message.batch.last_seq)
                        del message.batch.events[:]
                        message.batch.events.extend(fresh)
                    elif content == "progress":
                        cursor = max(cursor, message.progress.position)
                    yield message
                    if content == "ended":
                        return
            except grpc.RpcError as error:
                since = since or time.monotonic()
                if error.code() != grpc.StatusCode.UNAVAILABLE or time.monotonic() - since > self._patience:
                    raise
                time.sleep(_pause(failures))
                failures += 1

    def watch(
        self, job: str, progress: Optional[Show] = None, event: Optional[Callable[[Event], None]] = None
    ) -> jobs_pb2.JobStatus:
        """Follows a job to its end; calls progress and event with what arrives."""
        for message in self.events(job):
            content = message.WhichOneof("content")
            if content == "progress" and progress and message.progress.channels:
                progress([_progress(channel) for channel in message.progress.channels])
            elif content == "batch" and event:
                for one in filter(None, map(_event, message.batch.events)):
                    event(one)
            elif content == "ended":
                if message.ended.error:
                    raise JobFailed(message.ended.error)
                return message.ended
        raise JobFailed("the server ended the watch before the job ended")

    def summary(self, job: str) -> Dict[str, Any]:
        """summary.json of an ended job."""
        return dict(json.loads(self._whole(self._results.GetSummary, results_pb2.GetSummaryRequest(job_id=job))))

    def listing(self, job: str, channel: int = 0) -> str:
        """Listing of a channel, of all for 0."""
        request = results_pb2.GetListingRequest(job_id=job, channel=channel)
        return self._whole(self._results.GetListing, request).decode()

    def timeline(self, job: str) -> Timeline:
        """Bars of the channels over simulated time."""
        request = results_pb2.GetTimelineRequest(job_id=job, format=results_pb2.DRAWING_FORMAT_JSON)
        return Timeline.of(json.loads(self._whole(self._results.GetTimeline, request)))

    def delete(self, job: str) -> None:
        """Removes an ended job with its results."""
        self._jobs.DeleteJob(jobs_pb2.DeleteJobRequest(job_id=job), metadata=self._metadata)

    def _whole(self, call: Callable[..., Iterable[Any]], request: Any) -> bytes:
        return bytes(self._again(lambda: b"".join(chunk.data for chunk in call(request, metadata=self._metadata))))

    def _again(self, call: Callable[[], T]) -> T:
        failures, since = 0, time.monotonic()
        while True:
            try:
                return call()
            except grpc.RpcError as error:
                if error.code() != grpc.StatusCode.UNAVAILABLE or time.monotonic() - since > self._patience:
                    raise
                time.sleep(_pause(failures))
                failures += 1


def _named(programs: Programs) -> List[Tuple[str, bytes]]:
    if isinstance(programs, Mapping):
        return list(programs.items())
    paths = [pathlib.Path(path) for path in programs]
    return [(path.name, path.read_bytes()) for path in paths]


def _pause(failures: int) -> float:
    """From 0.1 s doubling to 10 s, half of it by chance."""
    return min(0.1 * float(1 << min(failures, 10)), 10.0) * random.uniform(0.5, 1.0)


def _progress(channel: jobs_pb2.ChannelProgress) -> Progress:
    state = jobs_pb2.ChannelState.Name(channel.state).replace("CHANNEL_STATE_", "").replace("_", " ").lower()
    return Progress(channel.name, state, channel.blocks, channel.percent, channel.t_ns / 1e9, channel.waiting_for)


def _event(event: event_pb2.Event) -> Optional[Event]:
    kind = event.WhichOneof("kind")
    if kind is None:
        return None
    body = getattr(event, kind)
    text = getattr(body, "text", "") or getattr(body, "key", "")
    line = event.caller_line or event.line
    return Event(event.seq, event.t_ns / 1e9, event.channel, line, kind, text) if text else None
