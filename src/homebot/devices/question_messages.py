"""Questions to people before a command of a client with the right ``ask`` is sent, and their answers."""

from typing import Annotated

from pydantic import Field

from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class OpenQuestion(Message):
    """A question that waits for an answer.

    Attributes:
        question: Its id, which is that of the command in the journal.
        text: What is asked, for people; names in it come from outside.
        device: The id of the device.
        issuer: Who asks, as ``client:NAME``.
        until: When it is refused unless a person has answered.
    """

    question: str
    text: str
    device: str
    issuer: str
    until: Time


class GetQuestionsRequest(Message):
    """Request for the open questions."""


class OpenQuestions(Message):
    """All open questions, the oldest first; published at each change."""

    questions: tuple[OpenQuestion, ...] = ()


class AnswerQuestionRequest(Message):
    """A person's answer.

    Attributes:
        yes: Whether the command may be sent.
        issuer: Who answers, as ``client:NAME``; the door sets it.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
    """

    question: ShortText
    yes: bool
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()


class AnswerQuestionResponse(ServiceAnswer):
    """A success if the answer counts; else the message says why it does not."""


GetQuestions = ServiceType("homebot/srv/GetQuestions", GetQuestionsRequest, OpenQuestions)
AnswerQuestion = ServiceType("homebot/srv/AnswerQuestion", AnswerQuestionRequest, AnswerQuestionResponse)
