#!/usr/bin/env python3
"""Submit NC programs to a Counterpoint server, watch them live, print the summary and draw the timeline."""

import argparse
import os
import pathlib
import sys
from typing import Tuple

# gRPC reads this when it is imported: Unreachable has the cause of a failure, so its own log is not needed.
os.environ.setdefault("GRPC_VERBOSITY", "NONE")

from counterpoint import Client, Event, JobFailed, JobOptions, Refused, UnknownMachine  # noqa: E402
from counterpoint import Unreachable, draw, first_error, print_progress  # noqa: E402


def show(event: Event) -> None:
    print(f"{event.simulated_s:.3f} s, channel {event.channel}, line {event.line}: {event.kind} {event.text}")


def label(text: str) -> Tuple[str, str]:
    key, _, value = text.partition("=")
    return key, value


def main() -> int:
    try:
        return run()
    except (OSError, Refused, ValueError) as error:
        print(error, file=sys.stderr)
        return 3 if isinstance(error, (Refused, Unreachable)) and not isinstance(error, UnknownMachine) else 2


def run() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__,
        epilog="COUNTERPOINT_TOKEN has the token, COUNTERPOINT_CA the PEM file of the authorities for https.",
    )
    parser.add_argument("--server", metavar="URL", help="http(s)://HOST:PORT [env: COUNTERPOINT_SERVER]")
    parser.add_argument("--machine", default="", metavar="NAME", help="guessed from the programs by default")
    parser.add_argument("--with", dest="files", action="append", default=[], metavar="FILE|DIR", help="add subprograms")
    parser.add_argument("--label", type=label, action="append", default=[], metavar="KEY=VALUE", help="label the job")
    parser.add_argument("--no-cache", action="store_true", help="run the job even if results of an equal job exist")
    parser.add_argument("--timeline", type=pathlib.Path, metavar="FILE", help="draw the channels over time as SVG")
    parser.add_argument("programs", nargs="+", metavar="PROGRAM", help="left to right onto the channels")
    arguments = parser.parse_args()
    with Client(arguments.server) as client:
        options = JobOptions(no_cache=arguments.no_cache)
        programs, labels = arguments.programs, dict(arguments.label)
        job = client.submit(arguments.machine, programs, options, files=arguments.files, labels=labels)
        print(f"job {job}", file=sys.stderr)
        try:
            status = client.watch(job, progress=print_progress, event=show)
        except JobFailed as failure:
            print(failure, file=sys.stderr)
            return 2
        if status.reused_from:
            print(f"not run: results of the equal job {status.reused_from}", file=sys.stderr)
        if first_error(status):
            print(f"first error: {first_error(status)}", file=sys.stderr)
        summary = client.summary(job)
        print(f"{summary['state']} after {(summary['makespan_ns'] + 500_000) // 1_000_000 / 1e3:.3f} s of machine time")
        if arguments.timeline:
            arguments.timeline.write_text(draw(client.timeline(job)))
    return 0 if summary["state"] == "SUCCEEDED" else 1


if __name__ == "__main__":
    sys.exit(main())
