"""Client of a Counterpoint server.

    with Client("127.0.0.1:7878") as client:
        job = client.submit("fanuc-mill", ["part.nc"])
        status = client.watch(job, progress=print_progress)
        timeline = client.timeline(job)
        pathlib.Path("timeline.svg").write_text(draw(timeline))

The modules in counterpoint.v1 are generated from the contract (generate.py).
"""

from .client import Client, Event, JobFailed, Progress, UnknownMachine, Unreachable, print_progress
from .timeline import Bar, Channel, Timeline, draw

__all__ = [
    "Bar",
    "Channel",
    "Client",
    "Event",
    "JobFailed",
    "Progress",
    "Timeline",
    "UnknownMachine",
    "Unreachable",
    "draw",
    "print_progress",
]
