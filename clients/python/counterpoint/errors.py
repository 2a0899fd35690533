"""Errors of the client.

Invariant: no gRPC error leaves the package. A call ends with a result, Refused, or Unreachable.
"""

from typing import Dict, List, NamedTuple, Optional

import grpc

from . import refusal_pb2
from .v1 import jobs_pb2

#: Trailer with the details of a refusal.
DETAILS = "grpc-status-details-bin"


class FieldError(NamedTuple):
    """An invalid field of a request, or a place in a file."""

    field: str
    text: str


class Refused(Exception):
    """The server refused a call.

    reason: a word of the table "Refusals" in docs/api.md, for example QUEUE_FULL; empty if the answer does not come
    from a Counterpoint server. code: the gRPC code. message: cause and remedy. retry_after: seconds after which the
    server suggests another try, or None. fields: the fields that are wrong. details: further data of the reason, for
    example limit of QUOTA_EXCEEDED.
    """

    def __init__(
        self,
        reason: str,
        code: grpc.StatusCode,
        message: str,
        retry_after: Optional[float] = None,
        fields: Optional[List[FieldError]] = None,
        details: Optional[Dict[str, str]] = None,
    ) -> None:
        # All arguments, so that the exception can be sent to another process.
        super().__init__(reason, code, message, retry_after, fields, details)
        self.reason = reason
        self.code = code
        self.message = message
        self.retry_after = retry_after
        self.fields = fields or []
        self.details = details or {}

    def __str__(self) -> str:
        return f"{self.message} ({self.reason or self.code.name})"


class UnknownMachine(Refused, LookupError):
    """The server does not have the machine; the message names the machines of the server."""


class Unreachable(ConnectionError):
    """No server answers at the address, or the connection is refused, for example because of a certificate."""


class JobFailed(Exception):
    """The job could not be run at all. status: its status with findings; None if unknown."""

    def __init__(self, text: str, status: Optional[jobs_pb2.JobStatus] = None) -> None:
        super().__init__(text)
        self.status = status


def refused(error: grpc.RpcError) -> Refused:
    """The refusal in a gRPC error."""
    details = _details(error)
    info = refusal_pb2.ErrorInfo.FromString(details.get("ErrorInfo", b""))
    violations = refusal_pb2.BadRequest.FromString(details.get("BadRequest", b"")).field_violations
    retry_after = None
    if "RetryInfo" in details:
        delay = refusal_pb2.RetryInfo.FromString(details["RetryInfo"]).retry_delay
        retry_after = delay.seconds + delay.nanos / 1e9
    fields = [FieldError(one.field, one.description) for one in violations]
    return Refused(info.reason, error.code(), error.details() or "", retry_after, fields, dict(info.metadata))


def _details(error: grpc.RpcError) -> Dict[str, bytes]:
    """Details by the name of their message in google.rpc."""
    for item in error.trailing_metadata() or ():
        if item.key == DETAILS and isinstance(item.value, bytes):
            parts = refusal_pb2.Status.FromString(item.value).details
            return {part.type_url.rpartition("/google.rpc.")[2]: part.value for part in parts}
    return {}
