"""Watches of a job, over broken connections."""

import sys
from typing import Callable, Iterator, List, NamedTuple, Optional, Sequence

import grpc

from .calls import Calls, Patience
from .errors import JobFailed
from .v1 import event_pb2, jobs_pb2
from .words import operator_wait

#: Maximum time without a message on a watch, s.
HEARTBEAT_S = 5.0


class Progress(NamedTuple):
    """Progress of a channel. operator_wait: the wait of the whole job for an operator, in words; empty = none."""

    channel: str
    state: str
    blocks: int
    percent: float
    simulated_s: float
    waiting_for: str
    operator_wait: str = ""


class Event(NamedTuple):
    """An event for people: a diagnostic, a message, a wait."""

    number: int
    simulated_s: float
    channel: int
    line: int
    kind: str
    text: str


Show = Callable[[List[Progress]], None]


def print_progress(channels: Sequence[Progress]) -> None:
    """Shows progress on standard error; on a terminal it overwrites one line."""
    parts = [
        f"{c.channel} {c.percent:3.0f} % block {c.blocks} {c.simulated_s:.1f} s {c.waiting_for or c.state}"
        for c in channels
    ]
    parts += [wait for wait in {c.operator_wait for c in channels} if wait]
    terminal = sys.stderr.isatty()
    head, end = ("\r\x1b[K", "") if terminal else ("", "\n")
    print(head + " | ".join(parts), end=end, file=sys.stderr, flush=True)


class Watching(Calls):
    """Watches."""

    def events(
        self, job: str, after: int = 0, level: "jobs_pb2.WatchLevel.ValueType" = jobs_pb2.WATCH_LEVEL_DIAGNOSTICS
    ) -> Iterator[jobs_pb2.WatchJobResponse]:
        """Messages of a watch, over broken connections: every event once and in order, the end last."""
        cursor, patience = after, Patience(self._patience)
        while True:
            request = jobs_pb2.WatchJobRequest(
                job_id=job, after_seq=cursor, level=level, heartbeat_ms=int(HEARTBEAT_S * 1000)
            )
            try:
                for message in self._jobs.WatchJob(request, metadata=self._metadata):
                    patience.succeeded()
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
                self._pause(error, patience)

    def watch(
        self, job: str, progress: Optional[Show] = None, event: Optional[Callable[[Event], None]] = None
    ) -> jobs_pb2.JobStatus:
        """Follows a job to its end; calls progress and event for each arriving message. Raises JobFailed."""
        for message in self.events(job):
            content = message.WhichOneof("content")
            if content == "progress" and progress and message.progress.channels:
                wait = operator_wait(message.progress)
                progress([_progress(channel, wait) for channel in message.progress.channels])
            elif content == "batch" and event:
                for one in filter(None, map(_event, message.batch.events)):
                    event(one)
            elif content == "ended":
                return ended(message.ended)
        raise JobFailed("the server ended the watch before the job ended")


def ended(status: jobs_pb2.JobStatus) -> jobs_pb2.JobStatus:
    """The status of an ended job. Raises JobFailed if the job could not be run."""
    if status.error:
        raise JobFailed(status.error, status)
    return status


def _progress(channel: jobs_pb2.ChannelProgress, wait: str) -> Progress:
    state = jobs_pb2.ChannelState.Name(channel.state).replace("CHANNEL_STATE_", "").replace("_", " ").lower()
    time_s = channel.t_ns / 1e9
    return Progress(channel.name, state, channel.blocks, channel.percent, time_s, channel.waiting_for, wait)


def _event(event: event_pb2.Event) -> Optional[Event]:
    kind = event.WhichOneof("kind")
    if kind is None:
        return None
    body = getattr(event, kind)
    text = getattr(body, "text", "") or getattr(body, "key", "")
    line = event.caller_line or event.line
    return Event(event.seq, event.t_ns / 1e9, event.channel, line, kind, text) if text else None
