"""Words for the numbers of the contract."""

import datetime
from typing import Iterable, List, Optional, TypeVar, Union

from .v1 import jobs_pb2

T = TypeVar("T")
#: A time, or a time from now.
When = Union[datetime.datetime, datetime.timedelta]


def state_name(status: jobs_pb2.JobStatus) -> str:
    """The state of a job: QUEUED, RUNNING, SUCCEEDED, FAILED or CANCELLED."""
    return jobs_pb2.JobState.Name(status.state).replace("JOB_STATE_", "")


def cause_name(status: jobs_pb2.JobStatus) -> str:
    """The reason for the failure of a job: PROGRAM, MACHINE, LIMIT or HOST; empty if it has not failed."""
    return jobs_pb2.JobCause.Name(status.cause).replace("JOB_CAUSE_", "").replace("UNSPECIFIED", "")


def limit_name(status: jobs_pb2.JobStatus) -> str:
    """The limit that stopped a job, for example WALL_MS or DEADLINE; empty if no limit stopped it."""
    return jobs_pb2.JobLimit.Name(status.limit).replace("JOB_LIMIT_", "").replace("UNSPECIFIED", "")


def first_error(status: jobs_pb2.JobStatus) -> str:
    """The first error of a failed job with its place, for example `part.nc:3: 2900061 division by zero`, or empty."""
    if not status.HasField("first_error"):
        return ""
    error = status.first_error
    place = ":".join(filter(None, [error.file, str(error.line) if error.line else ""]))
    number = f"{error.number} " if error.number else ""
    return f"{place}: {number}{error.text}" if place else f"{number}{error.text}"


def operator_wait(of: Union[jobs_pb2.JobStatus, jobs_pb2.Progress]) -> str:
    """The wait of a running job for an operator or a step command, and its end; empty if the job does not wait."""
    if not of.HasField("operator_wait"):
        return ""
    wait = of.operator_wait
    client = "a step command" if wait.action == jobs_pb2.OPERATOR_ACTION_COMMAND else "an operator"
    if not wait.until_ms:
        return f"waits for {client}"
    until = datetime.datetime.fromtimestamp(wait.until_ms // 1000, datetime.timezone.utc)
    return f"waits for {client} until {until:%Y-%m-%d %H:%M:%S} UTC"


def worker_wait(status: jobs_pb2.JobStatus) -> str:
    """The wait of a queued job for a worker that jobs of its tenant hold; empty if the job does not wait for one."""
    if not status.HasField("worker_wait"):
        return ""
    wait = status.worker_wait
    held = f"waits for a worker: jobs of its tenant use all {wait.workers}"
    quota = " of its quota tenant_running" if wait.tenant_running else ""
    return f"{held}{quota}; {wait.waiting_for_client} of them wait for a client"


def states(names: Union[str, Iterable[str]]) -> List["jobs_pb2.JobState.ValueType"]:
    """States by name, in any letter case; one name is a list of one."""
    names = [names] if isinstance(names, str) else names
    known = {name.replace("JOB_STATE_", ""): value for name, value in jobs_pb2.JobState.items() if value}
    return [known[_word("state", name, known)] for name in names]


def priority(name: Optional[str]) -> "jobs_pb2.JobPriority.ValueType":
    """A priority by name, in any letter case; UNSPECIFIED for None."""
    if name is None:
        return jobs_pb2.JOB_PRIORITY_UNSPECIFIED
    known = {name.replace("JOB_PRIORITY_", ""): value for name, value in jobs_pb2.JobPriority.items() if value}
    return known[_word("priority", name, known)]


def milliseconds(when: Optional[When]) -> int:
    """Milliseconds since 1970-01-01 UTC; 0 for None."""
    if when is None:
        return 0
    if isinstance(when, datetime.timedelta):
        when = datetime.datetime.now(datetime.timezone.utc) + when
    return int(when.timestamp() * 1000)


def ago(name: str, when: Optional[When]) -> Optional[When]:
    """A time in the past: a timedelta counts back from now, regardless of its sign."""
    return -abs(_time(name, when)) if isinstance(when, datetime.timedelta) else _time(name, when)


def deadline_ms(deadline: Optional[When], repeated: bool) -> int:
    """A deadline as in `milliseconds`. A past deadline is an error unless the call repeats an earlier call."""
    now = datetime.datetime.now(datetime.timezone.utc)
    ms = milliseconds(_time("deadline", deadline))
    if deadline is not None and not repeated and ms <= milliseconds(now):
        raise ValueError(f"the deadline {deadline} has passed: the job would not run")
    return ms


def _time(name: str, when: T) -> T:
    if when is not None and not isinstance(when, (datetime.datetime, datetime.timedelta)):
        raise TypeError(f"{name} {when!r} is not a datetime or timedelta: for example timedelta(minutes=30)")
    return when


def _word(kind: str, name: str, known: Iterable[str]) -> str:
    if name.upper() not in known:
        raise ValueError(f"'{name}' is not a {kind}: expected {', '.join(known).lower()}")
    return name.upper()
