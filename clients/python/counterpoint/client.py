"""The client: submits jobs, finds them and controls them."""

import time
import uuid
from typing import Iterable, Iterator, List, Mapping, Optional, Union

import grpc

from .dialogs import Dialogs
from .errors import Refused, UnknownMachine
from .files import Files, Pack
from .results import Results
from .settings import StrPath, resolve
from .v1 import blobs_pb2, jobs_pb2, machines_pb2
from .watching import Watching, ended
from .words import When, ago, deadline_ms, milliseconds, operator_wait, worker_wait
from .words import priority as priority_of, states as states_of

CHUNK = 64 * 1024
#: Digests in one question.
ASK = 10_000
#: Longest wait of one call, s.
WAIT_S = 60.0


class Client(Watching, Dialogs, Results):
    """A connection to a server.

    address: HOST:PORT, http://HOST:PORT or https://HOST:PORT; otherwise COUNTERPOINT_SERVER, otherwise
    http://127.0.0.1:7878. HOST:PORT means https if an argument, COUNTERPOINT_CA or COUNTERPOINT_CLIENT_CERT names a
    certificate. token: sent with every call; otherwise COUNTERPOINT_TOKEN. ca: PEM file of the authorities that may
    sign the server's certificate; otherwise COUNTERPOINT_CA, otherwise the authorities of the system. certificate, key:
    PEM files that identify the client; otherwise COUNTERPOINT_CLIENT_CERT and COUNTERPOINT_CLIENT_KEY. credentials:
    replace ca, certificate and key. patience: seconds after which a call that always fails gives up. reach: seconds
    within which the server must answer for the first time.

    Raises ValueError or OSError if a setting cannot be used, and Unreachable if no server answers at the address. Every
    call raises Refused if the server refuses it, and Unreachable at the end of patience.
    """

    def __init__(
        self,
        address: Optional[str] = None,
        token: Optional[str] = None,
        credentials: Optional[grpc.ChannelCredentials] = None,
        patience: float = 60.0,
        reach: float = 1.5,
        *,
        ca: Optional[StrPath] = None,
        certificate: Optional[StrPath] = None,
        key: Optional[StrPath] = None,
    ) -> None:
        super().__init__(resolve(address, token, ca, certificate, key, credentials), patience, reach)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def submit(
        self,
        machine: str,
        programs: Files,
        options: Optional[jobs_pb2.JobOptions] = None,
        request_id: Optional[str] = None,
        *,
        files: Files = (),
        labels: Optional[Mapping[str, str]] = None,
        priority: Optional[str] = None,
        deadline: Optional[When] = None,
    ) -> str:
        """Submits programs, left to right onto the channels; returns the id of the job.

        machine: its name; the server guesses the machine if it is empty. programs: paths, or contents by name; a path
        may be given for several channels. files: further files that the programs call, as paths or contents by name; a
        folder adds all its files. labels: to find the job by. priority: low, normal or high. deadline: a job that has
        not ended by then fails with the cause LIMIT.

        When this returns, the job is on the disk of the server. The request is repeated with its id after a lost
        connection, so the job is accepted once. To repeat a submit yourself with a request_id, give the deadline as a
        datetime. Raises ValueError if a program is empty, two files of one name differ or the deadline has passed,
        UnknownMachine, and Refused.
        """
        pack = Pack()
        names = pack.programs(programs)
        pack.others(files)
        request = jobs_pb2.SubmitJobRequest(
            request_id=request_id or str(uuid.uuid4()),
            machine=machine,
            programs=[jobs_pb2.Program(path=name) for name in names],
            files=[jobs_pb2.FileRef(path=name, digest=digest) for name, digest in pack.digests.items()],
            options=options,
            labels=labels,
            priority=priority_of(priority),
            deadline_ms=deadline_ms(deadline, repeated=request_id is not None),
        )
        self._upload(pack.contents)
        try:
            return self._call(self._jobs.SubmitJob, request).status.job_id
        except Refused as refusal:
            if refusal.reason == "UNKNOWN_MACHINE":
                # The rest of the message names a command for a shell.
                missing = refusal.message.split(";")[0]
                message = f"{missing}: the server has {', '.join(self.machines())}"
                raise UnknownMachine(refusal.reason, refusal.code, message) from None
            raise

    def rerun(
        self,
        job: str,
        request_id: Optional[str] = None,
        *,
        labels: Optional[Mapping[str, str]] = None,
        priority: Optional[str] = None,
        deadline: Optional[When] = None,
    ) -> str:
        """Submits a job again with the same files, options and machine revision; returns the id of the new job.

        labels, priority: default to those of the earlier job. deadline: none by default.
        """
        request = jobs_pb2.RerunJobRequest(
            job_id=job,
            request_id=request_id or str(uuid.uuid4()),
            labels=labels,
            priority=priority_of(priority),
            deadline_ms=deadline_ms(deadline, repeated=request_id is not None),
        )
        return self._call(self._jobs.RerunJob, request).status.job_id

    def status(self, job: str) -> jobs_pb2.JobStatus:
        """The current status of a job."""
        return self._call(self._jobs.GetJob, jobs_pb2.GetJobRequest(job_id=job)).status

    def wait(self, job: str, timeout: Optional[float] = None) -> jobs_pb2.JobStatus:
        """Waits for the end of a job, without events; returns its status.

        timeout: maximum wait, s, even if the server cannot be reached; then raises TimeoutError; its text says
        if the job waits for an operator or a worker. Raises JobFailed if the job could not be run.
        """
        if timeout is not None:
            try:
                return ended(self._wait_until(job, time.monotonic() + timeout))
            except TimeoutError as error:
                wait = f": it {error}" if str(error) else ""
                raise TimeoutError(f"job {job} has not ended within {timeout:g} s{wait}") from None
        while True:
            request = jobs_pb2.WaitJobRequest(job_id=job, timeout_ms=int(WAIT_S * 1000))
            status = self._call(self._jobs.WaitJob, request).status
            if status.ended_ms:
                return ended(status)

    def _wait_until(self, job: str, until: float) -> jobs_pb2.JobStatus:
        while True:
            left = min(WAIT_S, until - time.monotonic())
            request = jobs_pb2.WaitJobRequest(job_id=job, timeout_ms=max(1, int(left * 1000)))
            status = self._call_until(self._jobs.WaitJob, request, until).status
            if status.ended_ms:
                return status
            if time.monotonic() >= until:
                raise TimeoutError(operator_wait(status) or worker_wait(status))

    def jobs(
        self,
        states: Union[str, Iterable[str]] = (),
        *,
        machine: str = "",
        labels: Optional[Mapping[str, str]] = None,
        since: Optional[When] = None,
        until: Optional[When] = None,
        newest_first: bool = False,
    ) -> Iterator[jobs_pb2.JobStatus]:
        """Jobs in order of acceptance; pages are read as needed.

        states: queued, running, succeeded, failed, cancelled, paused; none = all. labels: all must match. since, until:
        time of acceptance; timedelta(hours=24) is 24 hours ago.
        """
        filtered = jobs_pb2.JobFilter(
            states=states_of(states),
            machine=machine,
            labels=labels,
            from_ms=milliseconds(ago("since", since)),
            until_ms=milliseconds(ago("until", until)),
        )
        request = jobs_pb2.ListJobsRequest(filter=filtered, newest_first=newest_first)
        while True:
            page = self._call(self._jobs.ListJobs, request)
            yield from page.jobs
            if not page.next_page_token:
                return
            request.page_token = page.next_page_token

    def cancel(self, job: str) -> jobs_pb2.JobStatus:
        """Asks a job to stop. The state changes when the run has stopped: call wait."""
        return self._call(self._jobs.CancelJob, jobs_pb2.CancelJobRequest(job_id=job)).status

    def pause(self, job: str) -> jobs_pb2.JobStatus:
        """Holds a job back until resume; a run in progress is stopped."""
        return self._call(self._jobs.PauseJob, jobs_pb2.PauseJobRequest(job_id=job)).status

    def resume(self, job: str) -> jobs_pb2.JobStatus:
        """Lets a paused job run again, from its start."""
        return self._call(self._jobs.ResumeJob, jobs_pb2.ResumeJobRequest(job_id=job)).status

    def delete(self, job: str) -> None:
        """Removes an ended job with its results. Not repeated after a lost connection."""
        self._once(self._jobs.DeleteJob, jobs_pb2.DeleteJobRequest(job_id=job))

    def machines(self) -> List[str]:
        """Names of the machines of the server."""
        names: List[str] = []
        request = machines_pb2.ListMachinesRequest()
        while True:
            page = self._call(self._machines.ListMachines, request)
            names += [machine.name for machine in page.machines]
            if not page.next_page_token:
                return names
            request.page_token = page.next_page_token

    def _upload(self, contents: Mapping[str, bytes]) -> None:
        """Uploads the contents that the server does not have."""
        digests = list(contents)
        for at in range(0, len(digests), ASK):
            question = blobs_pb2.FindMissingRequest(digests=digests[at : at + ASK])
            for digest in self._call(self._blobs.FindMissing, question).digests:
                self._again(lambda: self._blobs.Upload(_chunks(digest, contents[digest]), metadata=self._metadata))


def _chunks(digest: str, data: bytes) -> Iterator[blobs_pb2.UploadRequest]:
    yield blobs_pb2.UploadRequest(digest=digest, data=data[:CHUNK], size=len(data))
    for at in range(CHUNK, len(data), CHUNK):
        yield blobs_pb2.UploadRequest(data=data[at : at + CHUNK])
