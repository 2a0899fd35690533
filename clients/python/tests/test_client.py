"""Against the server at COUNTERPOINT_TEST_SERVER."""

import contextlib
import datetime
import io
import os
import pathlib
import pickle
import tempfile
import time
import unittest
import uuid
import xml.dom.minidom
from typing import Any, Callable, List

import grpc

from counterpoint import Client, Event, JobFailed, JobOptions, JobStatus, Progress, Refused, UnknownMachine
from counterpoint import cause_name, draw, first_error, limit_name, operator_wait, print_progress, state_name
from counterpoint import worker_wait
from counterpoint.v1 import blobs_pb2, blobs_pb2_grpc, jobs_pb2, machines_pb2, machines_pb2_grpc

EXAMPLES = pathlib.Path(__file__).resolve().parents[3] / "examples" / "two-turret"
PART = b"O1\nG0 X1.\nM30\n"
WRITER = b"""
extends = "fanuc-mill"
[ce]
name = "writer"
[macros]
tool = "tool.mac"
"""
ENDLESS = b"O1\nG1 X1. F100\nN1 G4 P9\nGOTO 1\nM30\n"


class Against(unittest.TestCase):
    def setUp(self) -> None:
        self.client = Client(f"http://{os.environ['COUNTERPOINT_TEST_SERVER']}", token="")
        self.addCleanup(self.client.close)

    def endless(self, **settings: Any) -> str:
        """Submits a job that runs until the end of the test."""
        job = self.client.submit("fanuc-mill", {"a.nc": ENDLESS}, **settings)
        other = Client(f"http://{os.environ['COUNTERPOINT_TEST_SERVER']}", token="")

        def end() -> None:
            with other, contextlib.suppress(Refused):
                other.cancel(job)

        self.addCleanup(end)
        return job

    def test_a_job_is_watched_read_and_drawn(self) -> None:
        seen: List[List[Progress]] = []
        events: List[Event] = []
        job = self.client.submit("fanuc-2path-lathe", [EXAMPLES / "upper.nc", EXAMPLES / "lower.nc"])
        status = self.client.watch(job, progress=seen.append, event=events.append)
        summary = self.client.summary(job)
        self.assertEqual((summary["state"], summary["makespan_ns"]), ("SUCCEEDED", status.makespan_ns))
        self.assertTrue(any(event.kind == "wait" for event in events), events)
        self.assertEqual([event.number for event in events], sorted({event.number for event in events}))
        timeline = self.client.timeline(job)
        self.assertEqual(len(timeline.channels), 2)
        self.assertAlmostEqual(timeline.makespan_s, status.makespan_ns / 1e9)
        for channel, expected in zip(timeline.channels, summary["channels"]):
            self.assertAlmostEqual(channel.seconds("feed"), expected["feed_ns"] / 1e9, places=3)
        drawing = xml.dom.minidom.parseString(draw(timeline))
        self.assertGreater(len(drawing.getElementsByTagName("rect")), 10)
        whole, upper, lower = (self.client.listing(job, number) for number in (0, 1, 2))
        self.assertIn("O1001", whole)
        log, console = self.client.listing(job, 1, log=True), self.client.listing(job, console=True)
        self.assertEqual(len({whole, upper, lower, log, console}), 5, "five different texts")
        self.client.delete(job)

    def test_a_request_id_is_accepted_once_and_what_cannot_run_is_an_error(self) -> None:
        programs = {"a.nc": PART}
        first = self.client.submit("fanuc-mill", programs, request_id="once")
        self.assertEqual(self.client.submit("fanuc-mill", programs, request_id="once"), first)
        job = self.client.submit("fanuc-2path-lathe", {"b.nc": PART, "c.nc": PART, "d.nc": PART})
        follows: List[Callable[[str], JobStatus]] = [self.client.watch, self.client.wait]
        for follow in follows:
            with self.assertRaises(JobFailed) as raised:
                follow(job)
            status = raised.exception.status
            self.assertEqual((status and status.job_id, status and status.error), (job, str(raised.exception)))
            self.assertEqual(pickle.loads(pickle.dumps(raised.exception)).status, status)

    def test_a_watch_of_a_job_that_is_paused_and_cancelled_ends_with_the_job(self) -> None:
        job = self.endless()
        cursor, state = 0, None
        for message in self.client.events(job):
            if message.WhichOneof("content") == "batch" and not cursor:
                cursor = message.batch.last_seq
                self.assertTrue(self.client.pause(job).paused)
                while state_name(self.client.status(job)) == "RUNNING":
                    time.sleep(0.01)
                self.assertTrue(self.client.cancel(job).cancel_requested)
            elif message.WhichOneof("content") == "ended":
                state = message.ended.state
        self.assertEqual(state, jobs_pb2.JOB_STATE_CANCELLED)
        self.assertEqual(list(self.client.events(job, after=cursor))[-1].ended.state, state)

    def test_an_unknown_machine_names_the_machines(self) -> None:
        with self.assertRaisesRegex(UnknownMachine, "no machine 'fanuc-mil': the server has .*fanuc-mill, .*okuma-mill"):
            self.client.submit("fanuc-mil", {"a.nc": PART})

    def test_a_file_serves_several_channels_and_names_are_unique(self) -> None:
        program = EXAMPLES / "upper.nc"
        job = self.client.submit("fanuc-2path-lathe", [program, program])
        self.client.watch(job)
        self.assertEqual(len(self.client.timeline(job).channels), 2)
        with tempfile.TemporaryDirectory() as folder:
            other = pathlib.Path(folder) / "upper.nc"
            other.write_bytes(b"O1\nM30\n")
            with self.assertRaisesRegex(ValueError, "upper.nc"):
                self.client.submit("fanuc-2path-lathe", [program, other])

    def test_a_job_is_submitted_with_subprograms_labels_priority_deadline_and_options(self) -> None:
        main = b"O1\nG90 G94 F100\nM98 P2\nM30\n"
        before = datetime.datetime.now(datetime.timezone.utc)
        deadline = before + datetime.timedelta(hours=1)
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "O0002.nc").write_bytes(b"O2\nG1 X5.\nM99\n")
            job = self.client.submit(
                "fanuc-mill",
                {"a.nc": main},
                JobOptions(trace="A", no_cache=True),
                files=[folder],
                labels={"part": "17"},
                priority="high",
                deadline=deadline,
            )
        status = self.client.wait(job)
        self.assertEqual((state_name(status), dict(status.labels)), ("SUCCEEDED", {"part": "17"}))
        self.assertEqual(status.priority, jobs_pb2.JOB_PRIORITY_HIGH)
        self.assertEqual(status.deadline_ms, int(deadline.timestamp() * 1000))
        self.assertEqual([one.job_id for one in self.client.jobs(labels={"part": "17"}, since=before)], [job])
        self.assertIn("M98 P2", self.client.trace(job))
        moves = self.client.toolpath(job)["channels"][0]["segments"]
        self.assertTrue(any(move["file"] == "O0002.nc" for move in moves), moves)
        for drawing in [self.client.toolpath_svg(job), self.client.timeline_svg(job)]:
            self.assertTrue(drawing.startswith("<svg"), drawing[:80])
        self.assertEqual(len(list(self.client.event_log(job))), status.events)

    def test_an_equal_job_is_reused_and_a_rerun_is_not(self) -> None:
        programs = {"a.nc": PART + uuid.uuid4().bytes.hex().encode()}
        first = self.client.submit("fanuc-mill", programs, labels={"lot": "1"})
        self.assertEqual(self.client.wait(first).reused_from, "")
        self.assertEqual(self.client.wait(self.client.submit("fanuc-mill", programs)).reused_from, first)
        apart = self.client.submit("fanuc-mill", programs, JobOptions(no_cache=True))
        self.assertEqual(self.client.wait(apart).reused_from, "")
        again = self.client.wait(self.client.rerun(first, priority="low"))
        self.assertEqual((again.rerun_of, again.reused_from), (first, ""))
        self.assertEqual((dict(again.labels), again.priority), ({"lot": "1"}, jobs_pb2.JOB_PRIORITY_LOW))

    def test_a_job_is_paused_resumed_cancelled_and_deleted(self) -> None:
        labels = {"test": str(uuid.uuid4())}
        job = self.endless(labels=labels)
        self.assertTrue(self.client.pause(job).paused)
        with self.assertRaisesRegex(TimeoutError, job):
            self.client.wait(job, timeout=0.01)
        self.assertEqual([one.job_id for one in self.client.jobs(["paused"], labels=labels)], [job])
        self.assertFalse(self.client.resume(job).paused)
        with self.assertRaises(Refused) as raised:
            self.client.summary(job)
        self.assertEqual(raised.exception.reason, "JOB_NOT_ENDED")
        self.client.cancel(job)
        self.assertEqual(state_name(self.client.wait(job)), "CANCELLED")
        self.client.delete(job)
        self.assertEqual(list(self.client.jobs(labels=labels)), [])

    def test_a_deadline_ends_a_job_with_its_limit(self) -> None:
        job = self.endless(deadline=datetime.timedelta(seconds=0.1))
        status = self.client.wait(job)
        self.assertEqual((state_name(status), cause_name(status), limit_name(status)), ("FAILED", "LIMIT", "DEADLINE"))

    def test_a_job_that_waits_for_an_operator_says_so_and_is_answered(self) -> None:
        job = self.client.submit("tern-bar-lathe", {"a.nc": b"M30\n"}, JobOptions(attended=True, no_cache=True))
        other = Client(f"http://{os.environ['COUNTERPOINT_TEST_SERVER']}", token="")
        questions = other.questions(job)
        question = next(questions)
        self.assertEqual((question.dialog.name, question.channel), ("Set-up", 1))
        wait = r"waits for an operator until \d{4}-\d\d-\d\d \d\d:\d\d:\d\d UTC"
        with self.assertRaisesRegex(TimeoutError, f"job {job} has not ended within 0.3 s: it {wait}$"):
            self.client.wait(job, timeout=0.3)
        self.assertRegex(operator_wait(self.client.status(job)), f"^{wait}$")
        shown: List[Progress] = []

        def progress(channels: List[Progress]) -> None:
            if not shown and channels[0].operator_wait:
                shown.extend(channels)
                with contextlib.redirect_stderr(io.StringIO()) as printed:
                    print_progress(channels)
                self.assertRegex(printed.getvalue(), wait)
                with self.assertRaises(Refused) as raised:
                    other.answer(job, question, "Start", {"NONE": 1})
                self.assertEqual(raised.exception.reason, "INVALID_REQUEST")
                self.assertTrue(other.answer(job, question, "Start", {"PERCENT": 90, "FACEOFF": -0.5}))
                self.assertFalse(other.answer(job, question), "it is closed")

        self.assertEqual(state_name(self.client.watch(job, progress=progress)), "SUCCEEDED")
        self.assertTrue(shown)
        self.assertEqual(list(questions), [])
        self.assertIn("set-up: Start, feed 90 %, face off by -.5", self.client.listing(job, console=True))
        declined = self.client.submit("tern-bar-lathe", {"a.nc": b"M30\n"}, JobOptions(attended=True, no_cache=True))
        self.assertTrue(self.client.decline(declined, next(self.client.questions(declined))))
        self.assertIn("the operator declined the dialog 'Set-up'", first_error(self.client.wait(declined)))
        other.close()

    def test_a_failed_job_names_its_first_error(self) -> None:
        status = self.client.watch(self.client.submit("fanuc-mill", {"part.nc": b"O1\nG0 X[1/0]\nM30\n"}))
        self.assertEqual(state_name(status), "FAILED")
        self.assertRegex(first_error(status), "^part.nc:2: 2900061 division by zero")
        status = self.client.watch(self.client.submit("fanuc-mill", {"part.nc": PART}))
        self.assertEqual((state_name(status), first_error(status)), ("SUCCEEDED", ""))

    def test_jobs_are_listed_over_pages_in_both_orders(self) -> None:
        labels = {"many": str(uuid.uuid4())}
        jobs = [self.client.submit("fanuc-mill", {"a.nc": PART}, labels=labels) for _ in range(51)]
        self.assertEqual([one.job_id for one in self.client.jobs(labels=labels)], jobs)
        newest = self.client.jobs(labels=labels, newest_first=True)
        self.assertEqual(next(newest).job_id, jobs[-1])

    def test_times_of_jobs_count_back_from_now_and_one_state_may_be_named(self) -> None:
        labels = {"recent": str(uuid.uuid4())}
        job = self.client.submit("fanuc-mill", {"a.nc": PART}, labels=labels)
        self.client.wait(job)
        day = datetime.timedelta(hours=24)
        for since in [day, -day]:
            self.assertEqual([one.job_id for one in self.client.jobs("succeeded", labels=labels, since=since)], [job])
        self.assertEqual(list(self.client.jobs(labels=labels, until=day)), [])

    def test_a_queued_job_names_its_wait_for_a_worker(self) -> None:
        self.assertEqual(worker_wait(jobs_pb2.JobStatus()), "")
        held = jobs_pb2.JobStatus(worker_wait=jobs_pb2.WorkerWait(workers=2, waiting_for_client=1))
        text = "waits for a worker: jobs of its tenant use all 2; 1 of them wait for a client"
        self.assertEqual(worker_wait(held), text)
        held.worker_wait.tenant_running = True
        self.assertIn("use all 2 of its quota tenant_running", worker_wait(held))

    def test_arguments_that_cannot_be_used_are_named(self) -> None:
        wrong: Any = {"x.nc": "O1"}
        with self.assertRaisesRegex(TypeError, "the content of x.nc is text: give bytes"):
            self.client.submit("fanuc-mill", wrong)
        with self.assertRaisesRegex(ValueError, "^'x.nc' is empty: a program needs at least one block$"):
            self.client.submit("fanuc-mill", {"x.nc": b" \r\n"})
        seconds: Any = 30
        with self.assertRaisesRegex(TypeError, "deadline 30 is not a datetime or timedelta"):
            self.client.submit("fanuc-mill", {"a.nc": PART}, deadline=seconds)
        with self.assertRaisesRegex(TypeError, "since 30 is not a datetime or timedelta"):
            next(self.client.jobs(since=seconds))
        past = datetime.datetime.now(datetime.timezone.utc) - datetime.timedelta(seconds=1)
        with self.assertRaisesRegex(ValueError, "has passed"):
            self.client.submit("fanuc-mill", {"a.nc": PART}, deadline=past)
        repeated = self.client.submit("fanuc-mill", {"a.nc": PART}, request_id=str(uuid.uuid4()), deadline=past)
        self.assertEqual(limit_name(self.client.wait(repeated)), "DEADLINE", "a repeated call keeps its deadline")

    def test_files_of_macros_are_listed_and_read(self) -> None:
        self.put_machine("writer", WRITER, b"OUTPUT\nOPEN/20,'lists/tools.txt'\nWRITE/20,'T!(*)',$P3\n")
        job = self.client.submit("writer", {"a.nc": b"O1\nG90 G94 F100\nT3 M6\nG1 X1.\nM30\n"})
        self.client.wait(job)
        self.assertEqual([file.path for file in self.client.files(job)], ["lists/tools.txt"])
        self.assertEqual(self.client.file(job, "lists/tools.txt").split(), [b"T3"])
        with self.assertRaises(Refused) as raised:
            self.client.file(job, "absent.txt")
        self.assertEqual(raised.exception.reason, "UNKNOWN_FILE")

    def put_machine(self, name: str, definition: bytes, macro: bytes) -> None:
        channel = grpc.insecure_channel(os.environ["COUNTERPOINT_TEST_SERVER"])
        self.addCleanup(channel.close)
        request = machines_pb2.PutMachineRequest(name=name)
        for path, data in [(f"{name}/machine.toml", definition), (f"{name}/tool.mac", macro)]:
            answer = blobs_pb2_grpc.BlobsStub(channel).PutBlob(blobs_pb2.PutBlobRequest(data=data))
            request.files.add(path=path, digest=answer.digest)
        machines_pb2_grpc.MachinesStub(channel).PutMachine(request)

    def test_a_refusal_names_the_fields_that_are_wrong(self) -> None:
        with self.assertRaises(Refused) as raised:
            self.client.submit("fanuc-mill", {"a.nc": PART}, labels={"UPPER": "x"})
        refusal = raised.exception
        self.assertEqual((refusal.reason, refusal.code.name), ("INVALID_REQUEST", "INVALID_ARGUMENT"))
        self.assertEqual([field.field for field in refusal.fields], ['labels["UPPER"]'])
        with self.assertRaises(Refused) as raised:
            self.client.status("absent")
        self.assertEqual((raised.exception.reason, raised.exception.message), ("UNKNOWN_JOB", "no job 'absent'"))


if __name__ == "__main__":
    unittest.main()
