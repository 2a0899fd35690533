"""Against the server at COUNTERPOINT_TEST_SERVER."""

import os
import pathlib
import socket
import tempfile
import time
import unittest
import xml.dom.minidom

from counterpoint import Client, JobFailed, UnknownMachine, Unreachable, draw
from counterpoint.v1 import jobs_pb2

EXAMPLES = pathlib.Path(__file__).resolve().parents[3] / "examples" / "two-turret"


class Against(unittest.TestCase):
    def setUp(self) -> None:
        self.client = Client(os.environ["COUNTERPOINT_TEST_SERVER"])
        self.addCleanup(self.client.close)

    def test_a_job_is_watched_read_and_drawn(self) -> None:
        seen, events = [], []
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
        self.assertIn("O1001", self.client.listing(job))
        self.client.delete(job)

    def test_a_request_id_is_accepted_once_and_what_cannot_run_is_an_error(self) -> None:
        programs = {"a.nc": b"O1\nG0 X1.\nM30\n"}
        first = self.client.submit("fanuc-mill", programs, request_id="once")
        self.assertEqual(self.client.submit("fanuc-mill", programs, request_id="once"), first)
        with self.assertRaises(JobFailed):
            self.client.watch(self.client.submit("fanuc-2path-lathe", {"b.nc": b"", "c.nc": b"", "d.nc": b""}))

    def test_a_watch_of_a_job_that_is_paused_and_cancelled_ends_with_the_job(self) -> None:
        job = self.client.submit("fanuc-mill", {"a.nc": b"O1\nG1 X1. F100\nN1 G4 P9\nGOTO 1\nM30\n"})
        cursor, state = 0, None
        for message in self.client.events(job):
            if message.WhichOneof("content") == "batch" and not cursor:
                cursor = message.batch.last_seq
                self.client._jobs.PauseJob(jobs_pb2.PauseJobRequest(job_id=job))
                while self.status(job) == jobs_pb2.JOB_STATE_RUNNING:
                    time.sleep(0.01)
                self.client._jobs.CancelJob(jobs_pb2.CancelJobRequest(job_id=job))
            elif message.WhichOneof("content") == "ended":
                state = message.ended.state
        self.assertEqual(state, jobs_pb2.JOB_STATE_CANCELLED)
        self.assertEqual(list(self.client.events(job, after=cursor))[-1].ended.state, state)

    def status(self, job: str) -> int:
        return self.client._jobs.GetJob(jobs_pb2.GetJobRequest(job_id=job)).status.state

    def test_a_wrong_port_fails_at_once_with_a_sentence(self) -> None:
        with socket.socket() as closed:
            closed.bind(("127.0.0.1", 0))
            address = f"127.0.0.1:{closed.getsockname()[1]}"
            begin = time.monotonic()
            with self.assertRaisesRegex(Unreachable, f"no server without TLS answers at {address}"):
                Client(address)
            self.assertLess(time.monotonic() - begin, 2)

    def test_an_unknown_machine_names_the_machines(self) -> None:
        with self.assertRaisesRegex(UnknownMachine, "no machine 'fanuc-mil': the server has .*fanuc-mill, .*okuma-mill"):
            self.client.submit("fanuc-mil", {"a.nc": b"O1\nM30\n"})

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


if __name__ == "__main__":
    unittest.main()
