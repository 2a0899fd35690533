"""Calls of a server.

Invariants: a call is repeated only if repeating it does not change its effect. No gRPC error leaves a call.
"""

import random
import time
from typing import Any, Callable, Iterable, NoReturn, Optional, TypeVar

import grpc

from .errors import Refused, Unreachable, refused
from .reach import why
from .settings import TOKEN, Settings
from .v1 import blobs_pb2_grpc, jobs_pb2_grpc, machines_pb2_grpc, operator_pb2_grpc, results_pb2_grpc

T = TypeVar("T")
#: Time for the answer to a call that ends at a given time, s.
ANSWER_S = 0.25


class Patience:
    """Pauses between successive failures, up to a total time."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._failures = 0
        self._since: Optional[float] = None

    def succeeded(self) -> None:
        """Ends a series of failures."""
        self._failures, self._since = 0, None

    def failed(self, least: Optional[float]) -> Optional[float]:
        """The pause before the next try, at least `least`, s; None at the end of patience."""
        now = time.monotonic()
        self._since = now if self._since is None else self._since
        left = self._since + self._limit - now
        if left <= 0:
            return None
        # From 0.1 s doubling to 10 s, half of it by chance: clients do not return all at once.
        pause = min(0.1 * float(1 << min(self._failures, 10)), 10.0) * random.uniform(0.5, 1.0)
        self._failures += 1
        return min(max(pause, least or 0.0), left)


class Calls:
    """A connection with the calls of each service."""

    def __init__(self, settings: Settings, patience: float, reach: float) -> None:
        self._settings = settings
        self._patience = patience
        self._metadata = settings.metadata
        options = [("grpc.keepalive_time_ms", 30_000), ("grpc.keepalive_timeout_ms", 10_000)]
        if settings.credentials is None:
            self._channel = grpc.insecure_channel(settings.target, options=options)
        else:
            self._channel = grpc.secure_channel(settings.target, settings.credentials, options=options)
        self._jobs = jobs_pb2_grpc.JobsStub(self._channel)
        self._blobs = blobs_pb2_grpc.BlobsStub(self._channel)
        self._results = results_pb2_grpc.ResultsStub(self._channel)
        self._machines = machines_pb2_grpc.MachinesStub(self._channel)
        self._operator = operator_pb2_grpc.OperatorStub(self._channel)
        try:
            grpc.channel_ready_future(self._channel).result(timeout=reach)
        except grpc.FutureTimeoutError:
            self._channel.close()
            cause = why(settings, reach) or f"the server at {settings.url} did not answer within {reach:g} s"
            raise Unreachable(cause) from None

    def close(self) -> None:
        """Closes the connection."""
        self._channel.close()

    def _once(self, call: Callable[..., T], request: Any) -> T:
        """Makes a call that must not be repeated."""
        try:
            return call(request, metadata=self._metadata)
        except grpc.RpcError as error:
            self._raise(error)

    def _call(self, call: Callable[..., T], request: Any) -> T:
        """Makes a call that may be repeated."""
        return self._again(lambda: call(request, metadata=self._metadata))

    def _call_until(self, call: Callable[..., T], request: Any, until: float) -> T:
        """Makes a call that may be repeated until a time of the monotonic clock. Raises TimeoutError at this time."""

        def once() -> T:
            # An answer that the server sends at this time still arrives.
            timeout = max(0.0, until - time.monotonic()) + ANSWER_S
            return call(request, metadata=self._metadata, timeout=timeout)

        try:
            return self._again(once, until)
        except Refused as refusal:
            if refusal.code == grpc.StatusCode.DEADLINE_EXCEEDED:
                raise TimeoutError from None
            raise

    def _whole(self, call: Callable[..., Iterable[Any]], request: Any) -> bytes:
        """Reads a stream of chunks."""
        return self._again(lambda: b"".join(chunk.data for chunk in call(request, metadata=self._metadata)))

    def _again(self, call: Callable[[], T], until: Optional[float] = None) -> T:
        patience = Patience(self._patience)
        while True:
            try:
                return call()
            except grpc.RpcError as error:
                self._pause(error, patience, until)

    def _pause(self, error: grpc.RpcError, patience: Patience, until: Optional[float] = None) -> None:
        """Waits before the next try; raises the error if it is not passing or patience ends.

        Raises TimeoutError at the time `until`.
        """
        if error.code() != grpc.StatusCode.UNAVAILABLE:
            self._raise(error)
        pause = patience.failed(refused(error).retry_after)
        if pause is None:
            self._raise(error)
        if until is not None and time.monotonic() + pause >= until:
            time.sleep(max(0.0, until - time.monotonic()))
            raise TimeoutError
        time.sleep(pause)

    def _raise(self, error: grpc.RpcError) -> NoReturn:
        refusal = refused(error)
        if not refusal.reason and refusal.code == grpc.StatusCode.UNAVAILABLE:
            cause = f"the connection to {self._settings.url} was lost: {refusal.message}"
            raise Unreachable(why(self._settings, 1.5) or cause) from error
        if refusal.reason == "UNAUTHENTICATED" and not self._settings.has_token:
            message = f"{refusal.message}: give token or set {TOKEN}"
            raise Refused(refusal.reason, refusal.code, message, refusal.retry_after) from error
        raise refusal from error
