#!/usr/bin/env python3
"""Submit NC programs to a Counterpoint server, watch them live, print the summary and draw the timeline."""

import argparse
import pathlib
import sys

from counterpoint import Client, Event, JobFailed, UnknownMachine, Unreachable, draw, print_progress


def show(event: Event) -> None:
    print(f"{event.simulated_s:.3f} s, channel {event.channel}, line {event.line}: {event.kind} {event.text}")


def main() -> int:
    try:
        return run()
    except (OSError, UnknownMachine, ValueError) as error:
        print(error, file=sys.stderr)
        return 3 if isinstance(error, Unreachable) else 2


def run() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", default="127.0.0.1:7878", metavar="HOST:PORT")
    parser.add_argument("--machine", default="fanuc-mill", metavar="NAME")
    parser.add_argument("--timeline", type=pathlib.Path, metavar="FILE", help="draw the channels over time into this SVG file")
    parser.add_argument("programs", nargs="+", metavar="PROGRAM", help="left to right onto the channels")
    arguments = parser.parse_args()
    with Client(arguments.server) as client:
        job = client.submit(arguments.machine, arguments.programs)
        print(f"job {job}", file=sys.stderr)
        try:
            client.watch(job, progress=print_progress, event=show)
        except JobFailed as failure:
            print(failure, file=sys.stderr)
            return 2
        summary = client.summary(job)
        print(f"{summary['state']} after {summary['makespan_ns'] / 1e9:.3f} s of machine time")
        if arguments.timeline:
            arguments.timeline.write_text(draw(client.timeline(job)))
    return 0 if summary["state"] == "SUCCEEDED" else 1


if __name__ == "__main__":
    sys.exit(main())
