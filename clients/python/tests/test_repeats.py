"""Calls that a server answers with UNAVAILABLE, against a server in this process."""

import os
import pickle
import threading
import time
import unittest
from concurrent import futures
from typing import Iterator, List
from unittest import mock

import grpc
from google.protobuf import any_pb2

from counterpoint import Client, Refused, Unreachable, refusal_pb2
from counterpoint.calls import Patience
from counterpoint.v1 import blobs_pb2, blobs_pb2_grpc, event_pb2, jobs_pb2, jobs_pb2_grpc
from counterpoint.v1 import machines_pb2, machines_pb2_grpc, results_pb2, results_pb2_grpc

Context = grpc.ServicerContext


def refuse(context: Context, reason: str, code: grpc.StatusCode, seconds: int = 0) -> None:
    """Refuses a call as a server of Counterpoint does."""
    info = refusal_pb2.ErrorInfo(reason=reason, domain="counterpoint", metadata={"cursor": "7"})
    retry = refusal_pb2.RetryInfo()
    retry.retry_delay.seconds = seconds
    status = refusal_pb2.Status(message="not now")
    for name, detail in [("ErrorInfo", info), ("RetryInfo", retry)]:
        url = f"type.googleapis.com/google.rpc.{name}"
        status.details.append(any_pb2.Any(type_url=url, value=detail.SerializeToString()))
    context.set_trailing_metadata((("grpc-status-details-bin", status.SerializeToString()),))
    context.abort(code, "not now")


class Server(
    jobs_pb2_grpc.JobsServicer,
    blobs_pb2_grpc.BlobsServicer,
    results_pb2_grpc.ResultsServicer,
    machines_pb2_grpc.MachinesServicer,
):
    """Refuses the first calls with UNAVAILABLE."""

    def __init__(self) -> None:
        self.refusals = 0
        self.requests: List[str] = []
        self.cursors: List[int] = []
        self.released = threading.Event()

    def FindMissing(
        self, request: blobs_pb2.FindMissingRequest, context: Context
    ) -> blobs_pb2.FindMissingResponse:
        return blobs_pb2.FindMissingResponse()

    def SubmitJob(self, request: jobs_pb2.SubmitJobRequest, context: Context) -> jobs_pb2.SubmitJobResponse:
        self.requests.append(request.request_id)
        self.refuse(context)
        return jobs_pb2.SubmitJobResponse(status=jobs_pb2.JobStatus(job_id="job"))

    def DeleteJob(self, request: jobs_pb2.DeleteJobRequest, context: Context) -> jobs_pb2.DeleteJobResponse:
        self.requests.append(request.job_id)
        self.refuse(context)
        return jobs_pb2.DeleteJobResponse()

    def GetJob(self, request: jobs_pb2.GetJobRequest, context: Context) -> jobs_pb2.GetJobResponse:
        refuse(context, "QUEUE_FULL", grpc.StatusCode.RESOURCE_EXHAUSTED, seconds=3)
        return jobs_pb2.GetJobResponse()

    def WatchJob(
        self, request: jobs_pb2.WatchJobRequest, context: Context
    ) -> Iterator[jobs_pb2.WatchJobResponse]:
        self.cursors.append(request.after_seq)
        events = [event_pb2.Event(seq=seq) for seq in (1, 2, 3) if seq >= request.after_seq]
        yield jobs_pb2.WatchJobResponse(batch=event_pb2.EventBatch(events=events, last_seq=3))
        self.refuse(context)
        yield jobs_pb2.WatchJobResponse(ended=jobs_pb2.JobStatus(state=jobs_pb2.JOB_STATE_SUCCEEDED))

    def GetEvents(
        self, request: results_pb2.GetEventsRequest, context: Context
    ) -> Iterator[results_pb2.GetEventsResponse]:
        yield results_pb2.GetEventsResponse(data=b'{"seq": 1}\n{"seq":')
        yield results_pb2.GetEventsResponse(data=b' 2}\n')
        self.refuse(context)
        yield results_pb2.GetEventsResponse(data=b'{"seq": 3}\n{"seq": 4}')

    def WaitJob(self, request: jobs_pb2.WaitJobRequest, context: Context) -> jobs_pb2.WaitJobResponse:
        self.requests.append(request.job_id)
        self.refuse(context)
        self.released.wait(60)
        return jobs_pb2.WaitJobResponse()

    def ListMachines(
        self, request: machines_pb2.ListMachinesRequest, context: Context
    ) -> machines_pb2.ListMachinesResponse:
        at = int(request.page_token or 0)
        machines = [machines_pb2.MachineSummary(name=f"m{at}")]
        return machines_pb2.ListMachinesResponse(machines=machines, next_page_token="" if at == 2 else str(at + 1))

    def refuse(self, context: Context) -> None:
        if self.refusals:
            self.refusals -= 1
            refuse(context, "DRAINING", grpc.StatusCode.UNAVAILABLE)


class Repeats(unittest.TestCase):
    def setUp(self) -> None:
        # The other calls of the services answer UNIMPLEMENTED.
        self.service = Server()  # type: ignore[abstract]
        self.server = grpc.server(futures.ThreadPoolExecutor(4))
        jobs_pb2_grpc.add_JobsServicer_to_server(self.service, self.server)
        blobs_pb2_grpc.add_BlobsServicer_to_server(self.service, self.server)
        results_pb2_grpc.add_ResultsServicer_to_server(self.service, self.server)
        machines_pb2_grpc.add_MachinesServicer_to_server(self.service, self.server)
        self.addCleanup(self.service.released.set)
        self.address = f"127.0.0.1:{self.server.add_insecure_port('127.0.0.1:0')}"
        self.server.start()
        self.addCleanup(self.server.stop, None)

    def client(self, patience: float) -> Client:
        client = Client(f"http://{self.address}", token="", patience=patience, reach=10)
        self.addCleanup(client.close)
        return client

    def test_a_submit_is_repeated_with_its_request_id(self) -> None:
        self.service.refusals = 2
        self.assertEqual(self.client(60).submit("fanuc-mill", {"a.nc": b"O1\nM30\n"}), "job")
        self.assertEqual((len(self.service.requests), len(set(self.service.requests))), (3, 1))

    def test_a_delete_is_not_repeated(self) -> None:
        self.service.refusals = 1
        with self.assertRaises(Refused):
            self.client(60).delete("job")
        self.assertEqual(self.service.requests, ["job"])

    def test_the_refusal_is_raised_at_the_end_of_patience(self) -> None:
        self.service.refusals = 1000
        with self.assertRaises(Refused) as raised:
            self.client(0).submit("fanuc-mill", {"a.nc": b"O1\nM30\n"})
        refusal = raised.exception
        self.assertEqual((refusal.reason, refusal.code), ("DRAINING", grpc.StatusCode.UNAVAILABLE))
        self.assertEqual((refusal.message, refusal.details), ("not now", {"cursor": "7"}))
        self.assertEqual(str(refusal), "not now (DRAINING)")
        copy = pickle.loads(pickle.dumps(refusal))
        self.assertEqual((str(copy), copy.code, copy.details), (str(refusal), refusal.code, refusal.details))

    def test_a_refusal_has_the_time_to_wait(self) -> None:
        with self.assertRaises(Refused) as raised:
            self.client(60).status("job")
        self.assertEqual((raised.exception.reason, raised.exception.retry_after), ("QUEUE_FULL", 3.0))

    def test_a_server_that_has_gone_is_unreachable(self) -> None:
        client = self.client(0)
        self.server.stop(None).wait()
        with self.assertRaisesRegex(Unreachable, f"no server answers at http://{self.address} .*: check the address"):
            client.status("job")

    def test_a_wait_ends_at_its_timeout_whatever_the_server_does(self) -> None:
        client = self.client(60)
        with self.assertRaisesRegex(TimeoutError, "job job has not ended within 0.5 s"):
            client.wait("job", timeout=0.5)
        self.assertEqual(len(self.service.requests), 1, "the server does not answer")
        self.service.refusals = 10_000
        with self.assertRaises(TimeoutError):
            client.wait("job", timeout=0.5)
        self.service.released.set()
        self.server.stop(None).wait()
        with self.assertRaises(TimeoutError):
            client.wait("job", timeout=0.5)

    def test_patience_covers_the_last_pause(self) -> None:
        patience = Patience(0.2)
        pauses = 0.0
        while (pause := patience.failed(10.0)) is not None:
            pauses += pause
            time.sleep(pause)
        self.assertAlmostEqual(pauses, 0.2, places=3)
        self.assertIsNone(patience.failed(None))

    def test_machines_are_listed_over_pages(self) -> None:
        self.assertEqual(self.client(60).machines(), ["m0", "m1", "m2"])

    def test_a_proxy_without_an_answer_is_named(self) -> None:
        with mock.patch.dict(os.environ, {"http_proxy": "http://127.0.0.1:9", "no_proxy": ""}):
            with self.assertRaisesRegex(Unreachable, "not through the proxy of http_proxy: add 127.0.0.1 to no_proxy"):
                Client(f"http://{self.address}", token="", reach=0.5)

    def test_a_broken_watch_continues_at_its_cursor_without_an_event_twice(self) -> None:
        self.service.refusals = 1
        messages = list(self.client(60).events("job"))
        self.assertEqual(self.service.cursors, [0, 3])
        self.assertEqual([event.seq for message in messages for event in message.batch.events], [1, 2, 3])
        self.assertEqual(messages[-1].ended.state, jobs_pb2.JOB_STATE_SUCCEEDED)

    def test_a_broken_event_log_continues_after_the_last_event(self) -> None:
        self.service.refusals = 1
        self.assertEqual([event["seq"] for event in self.client(60).event_log("job")], [1, 2, 3, 4])


if __name__ == "__main__":
    unittest.main()
