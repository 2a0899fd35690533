"""Dialogs of jobs that were submitted with JobOptions(attended=True).

Invariant: each open question is yielded once, over broken connections, unless the server asks it again.
"""

from typing import Iterator, Mapping, Optional, Set, Union

import grpc

from .calls import Calls, Patience
from .v1 import jobs_pb2, operator_pb2

#: A value of a field of a dialog.
Value = Union[bool, float, str]


class Dialogs(Calls):
    """Questions and answers."""

    def questions(self, job: str) -> Iterator[operator_pb2.Question]:
        """The open questions of a job, and those to come; ends with the job.

        Raises Refused with the reason NOT_ATTENDED if the job was not submitted with JobOptions(attended=True).
        """
        shown: Set[int] = set()
        patience = Patience(self._patience)
        while True:
            request = operator_pb2.WatchQuestionsRequest(job_id=job)
            try:
                for message in self._operator.WatchQuestions(request, metadata=self._metadata):
                    patience.succeeded()
                    content = message.WhichOneof("content")
                    if content == "question" and message.question.id not in shown:
                        shown.add(message.question.id)
                        yield message.question
                    elif content == "closed":
                        shown.discard(message.closed)
                    elif content == "ended":
                        return
            except grpc.RpcError as error:
                self._pause(error, patience)

    def answer(
        self,
        job: str,
        question: operator_pb2.Question,
        button: str = "",
        values: Optional[Mapping[str, Value]] = None,
    ) -> bool:
        """Answers a question: presses a button, after it has entered values.

        button: its label; empty = the button that accepts the values. values: by macro variable (DialogField.variable); a field without a value keeps its initial
        value. Returns False if the question is closed: another client was first, its time was over, or the job has
        ended. Raises Refused if the dialog does not accept the answer; the question then stays open. Not repeated after
        a lost connection.
        """
        answer = jobs_pb2.DialogAnswer(button=button)
        for variable, value in (values or {}).items():
            answer.values[variable].CopyFrom(_value(value))
        return self._settle(operator_pb2.AnswerQuestionRequest(job_id=job, question_id=question.id, answer=answer))

    def decline(self, job: str, question: operator_pb2.Question) -> bool:
        """Declines a question, so that its dialog fails. Returns False if the question is closed."""
        return self._settle(operator_pb2.AnswerQuestionRequest(job_id=job, question_id=question.id))

    def _settle(self, request: operator_pb2.AnswerQuestionRequest) -> bool:
        return bool(self._once(self._operator.AnswerQuestion, request).accepted)


def _value(value: Value) -> jobs_pb2.DialogValue:
    # bool is a subclass of int.
    if isinstance(value, bool):
        return jobs_pb2.DialogValue(flag=value)
    if isinstance(value, str):
        return jobs_pb2.DialogValue(text=value)
    return jobs_pb2.DialogValue(number=value)
