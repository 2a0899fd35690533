"""Results of ended jobs."""

import itertools
import json
from typing import Any, Dict, Iterable, Iterator, List

import grpc

from .calls import Calls, Patience
from .timeline import Timeline
from .v1 import results_pb2


class Results(Calls):
    """Results."""

    def summary(self, job: str) -> Dict[str, Any]:
        """summary.json."""
        return dict(json.loads(self._whole(self._results.GetSummary, results_pb2.GetSummaryRequest(job_id=job))))

    def listing(self, job: str, channel: int = 0, log: bool = False, console: bool = False) -> str:
        """Listing of a channel; 0: of all channels. log: the log file of a channel instead. console: the console."""
        request = results_pb2.GetListingRequest(job_id=job, channel=channel, log=log, console=console)
        return self._text(self._whole(self._results.GetListing, request))

    def trace(self, job: str, channel: int = 1) -> str:
        """Trace of a channel; its lines depend on JobOptions.trace."""
        request = results_pb2.GetTraceRequest(job_id=job, channel=channel)
        return self._text(self._whole(self._results.GetTrace, request))

    def timeline(self, job: str) -> Timeline:
        """Bars of the channels over simulated time."""
        return Timeline.of(json.loads(self._timeline(job, results_pb2.DRAWING_FORMAT_JSON)))

    def timeline_svg(self, job: str) -> str:
        """The drawing of the timeline by the server."""
        return self._timeline(job, results_pb2.DRAWING_FORMAT_SVG).decode()

    def toolpath(self, job: str) -> Dict[str, Any]:
        """toolpath.json: the moves of each channel."""
        return dict(json.loads(self._toolpath(job, results_pb2.DRAWING_FORMAT_JSON)))

    def toolpath_svg(self, job: str) -> str:
        """The drawing of the toolpath."""
        return self._toolpath(job, results_pb2.DRAWING_FORMAT_SVG).decode()

    def event_log(self, job: str) -> Iterator[Dict[str, Any]]:
        """The whole ordered log, one object for each event, as in events.jsonl."""
        request, given, patience = results_pb2.GetEventsRequest(job_id=job), 0, Patience(self._patience)
        while True:
            try:
                chunks = self._results.GetEvents(request, metadata=self._metadata)
                # The log of an ended job does not change: another try skips the lines that were given.
                for line in itertools.islice(_lines(chunk.data for chunk in chunks), given, None):
                    patience.succeeded()
                    given += 1
                    yield json.loads(line)
                return
            except grpc.RpcError as error:
                self._pause(error, patience)

    def files(self, job: str) -> List[results_pb2.WrittenFile]:
        """Files that the macros of the machine have written: path and size, bytes."""
        return list(self._call(self._results.ListFiles, results_pb2.ListFilesRequest(job_id=job)).files)

    def file(self, job: str, path: str) -> bytes:
        """Content of a written file."""
        return self._whole(self._results.GetFile, results_pb2.GetFileRequest(job_id=job, path=path))

    def _timeline(self, job: str, form: "results_pb2.DrawingFormat.ValueType") -> bytes:
        request = results_pb2.GetTimelineRequest(job_id=job, format=form)
        return self._whole(self._results.GetTimeline, request)

    def _toolpath(self, job: str, form: "results_pb2.DrawingFormat.ValueType") -> bytes:
        request = results_pb2.GetToolpathRequest(job_id=job, format=form)
        return self._whole(self._results.GetToolpath, request)

    @staticmethod
    def _text(data: bytes) -> str:
        # Programs may contain bytes of other code pages.
        return data.decode(errors="replace")


def _lines(chunks: Iterable[bytes]) -> Iterator[bytes]:
    """Lines of a text that arrives in chunks."""
    rest = b""
    for chunk in chunks:
        *whole, rest = (rest + chunk).split(b"\n")
        yield from whole
    if rest:
        yield rest
