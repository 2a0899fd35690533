"""Client of a Counterpoint server.

    with Client("127.0.0.1:7878") as client:
        job = client.submit("fanuc-mill", ["part.nc"])
        status = client.watch(job, progress=print_progress)
        timeline = client.timeline(job)
        pathlib.Path("timeline.svg").write_text(draw(timeline))

The modules in counterpoint.v1 are generated from the contract (generate.py).
"""

from .client import Client
from .errors import FieldError, JobFailed, Refused, UnknownMachine, Unreachable
from .timeline import Bar, Channel, Timeline, draw
from .v1.jobs_pb2 import JobLimits, JobOptions, JobStatus
from .watching import Event, Progress, print_progress
from .words import cause_name, first_error, limit_name, operator_wait, state_name, worker_wait

__all__ = [
    "Bar",
    "Channel",
    "Client",
    "Event",
    "FieldError",
    "JobFailed",
    "JobLimits",
    "JobOptions",
    "JobStatus",
    "Progress",
    "Refused",
    "Timeline",
    "UnknownMachine",
    "Unreachable",
    "cause_name",
    "draw",
    "first_error",
    "limit_name",
    "operator_wait",
    "print_progress",
    "state_name",
    "worker_wait",
]
