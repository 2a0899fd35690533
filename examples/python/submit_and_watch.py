#!/usr/bin/env python3
"""Submit NC programs to a Counterpoint server, watch them live and save the summary.

usage: submit_and_watch.py [--server HOST:PORT] [--machine NAME] PROGRAM [PROGRAM ...]

The stubs are generated from the .proto files, see README.md.
"""

import argparse
import hashlib
import pathlib
import sys
import time
import uuid

import grpc

sys.path.insert(0, str(pathlib.Path(__file__).parent / "generated"))

from counterpoint.v1 import (  # noqa: E402
    blobs_pb2,
    blobs_pb2_grpc,
    jobs_pb2,
    jobs_pb2_grpc,
    results_pb2,
    results_pb2_grpc,
)

CHUNK = 1 << 20


def upload(channel, contents):
    """Uploads what the server does not have; contents by digest."""
    blobs = blobs_pb2_grpc.BlobsStub(channel)
    missing = blobs.FindMissing(blobs_pb2.FindMissingRequest(digests=list(contents))).digests
    for digest in missing:
        data = contents[digest]
        blobs.Upload(
            blobs_pb2.UploadRequest(digest=digest, data=data[at : at + CHUNK])
            for at in range(0, max(len(data), 1), CHUNK)
        )


def submit(channel, machine, programs):
    """Submits programs, left to right onto the channels; gives the job's id."""
    request = jobs_pb2.SubmitJobRequest(request_id=str(uuid.uuid4()), machine=machine)
    contents = {}
    for program in map(pathlib.Path, programs):
        data = program.read_bytes()
        digest = hashlib.sha256(data).hexdigest()
        contents[digest] = data
        request.programs.add(path=program.name)
        if program.name not in [file.path for file in request.files]:
            request.files.add(path=program.name, digest=digest)
    upload(channel, contents)
    # The request id makes the call safe to repeat: the same id gives the same job.
    for attempt in range(5):
        try:
            return jobs_pb2_grpc.JobsStub(channel).SubmitJob(request).status.job_id
        except grpc.RpcError as error:
            if error.code() not in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.RESOURCE_EXHAUSTED):
                raise
            time.sleep(2**attempt)
    raise SystemExit("the server does not take the job")


def watch(channel, job):
    """Prints progress and diagnostics to the end of the job, over broken connections too."""
    jobs = jobs_pb2_grpc.JobsStub(channel)
    cursor = 0
    for attempt in range(20):
        request = jobs_pb2.WatchJobRequest(
            job_id=job, after_seq=cursor, level=jobs_pb2.WATCH_LEVEL_DIAGNOSTICS
        )
        try:
            for message in jobs.WatchJob(request):
                content = message.WhichOneof("content")
                if content == "batch":
                    for event in message.batch.events:
                        if event.WhichOneof("kind") == "diagnostic":
                            d = event.diagnostic
                            print(f"channel {event.channel} line {event.line}: {d.number} {d.text}")
                    cursor = message.batch.last_seq
                elif content == "progress":
                    for c in message.progress.channels:
                        print(f"{c.name}: block {c.blocks}, {c.percent:.0f} %, {c.t_ns / 1e9:.3f} s", file=sys.stderr)
                elif content == "ended":
                    return message.ended
        except grpc.RpcError as error:
            if error.code() != grpc.StatusCode.UNAVAILABLE:
                raise
            time.sleep(min(0.1 * 2**attempt, 10))
    raise SystemExit("the server has gone")


def summary(channel, job):
    """summary.json of an ended job."""
    results = results_pb2_grpc.ResultsStub(channel)
    return b"".join(chunk.data for chunk in results.GetSummary(results_pb2.GetSummaryRequest(job_id=job)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--server", default="127.0.0.1:7878")
    parser.add_argument("--machine", default="fanuc-mill")
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args()
    with grpc.insecure_channel(arguments.server) as channel:
        job = submit(channel, arguments.machine, arguments.programs)
        print(f"job {job}", file=sys.stderr)
        status = watch(channel, job)
        state = jobs_pb2.JobState.Name(status.state).removeprefix("JOB_STATE_")
        print(f"{state} after {status.makespan_ns / 1e9:.3f} s of machine time, {status.events} events")
        if status.error:
            raise SystemExit(status.error)
        print(summary(channel, job).decode())
    return 0 if status.state == jobs_pb2.JOB_STATE_SUCCEEDED else 1


if __name__ == "__main__":
    sys.exit(main())
