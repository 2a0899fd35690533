"""Against the server at COUNTERPOINT_TEST_SERVER."""

import os
import pathlib
import tempfile
import unittest
import xml.dom.minidom

from counterpoint import Client, JobFailed, draw

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
