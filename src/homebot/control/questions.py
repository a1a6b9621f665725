"""Questions: a command of a client that must ask waits until a person with the right to give it says yes."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, final

import anyio

from homebot.control.command import IssuedCommand
from homebot.control.journal.journal import CommandJournal
from homebot.control.policies.facts import Verdict
from homebot.control.policies.rights import must_ask
from homebot.control.policy_engine import PolicyEngine
from homebot.devices.client_rights import ASK
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import GET_QUESTIONS, OPEN_QUESTIONS
from homebot.devices.outcomes import Gone, NoAnswer, Outcome, Refused
from homebot.devices.question_messages import (
    AnswerQuestion,
    AnswerQuestionRequest,
    AnswerQuestionResponse,
    GetQuestions,
    OpenQuestion,
    OpenQuestions,
)
from homebot.devices.wording.journal_words import issuer_text, settings_text
from homebot.errors import ServiceError
from homebot.graph import Node, Publisher, qos_profile_latched
from homebot.messages import Time
from homebot.support.bounded_map import BoundedMap
from homebot.support.printable import printable

ASKED: Final = "control.asked"

_MAX_WAIT_S: Final = 60.0
"""Seconds until an open question is refused, and for which a no holds for the same command."""

_MAX_OPEN, _MAX_OPEN_OF_CLIENT = 20, 5
"""The limits of open questions, and of those of one client."""

_MAX_DENIED: Final = 100

_NOBODY: Final = f"nobody answered within {_MAX_WAIT_S:.0f} s"


@dataclass(slots=True, eq=False)
class _Asked:
    command: IssuedCommand
    message: OpenQuestion
    by: str = ""
    yes: bool = False
    answered: anyio.Event = field(default_factory=anyio.Event)


@final
class Questions:
    """The open questions, and their answers."""

    def __init__(self, node: Node, lookup: DeviceLookup, policies: PolicyEngine, journal: CommandJournal) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._policies = policies
        self._journal = journal
        self._open: dict[str, _Asked] = {}
        self._ends: BoundedMap[str, str] = BoundedMap(_MAX_DENIED)  # for late answers
        self._denied: BoundedMap[tuple[object, ...], tuple[str, float]] = BoundedMap(_MAX_DENIED)

    def must_ask(self, command: IssuedCommand) -> bool:
        """Return whether a person must agree to *command*, or to the same for a member of the group that it is for."""
        if must_ask(command):
            return True
        return any(must_ask(replace(command, device=device, part=part)) for device, part in command.members)

    async def ask_and_update(self, command: IssuedCommand) -> IssuedCommand | Outcome:
        """As :meth:`ask`, but return *command* for the device as it is by then, instead of None."""
        refused = await self.ask(command)
        if refused is not None or command.text is not None:
            return refused or command
        try:
            device = await self._lookup.device(command.device.id)
        except ServiceError as exc:
            return NoAnswer(0.0, str(exc), command_id=command.id)
        part = None if device is None else device.part(command.part.id)
        if device is None or part is None:
            return Gone(command_id=command.id)
        return replace(command, device=device, part=part, issued_at=self._clock.now())

    async def ask(self, command: IssuedCommand) -> Refused | None:
        """Ask people whether *command* may be sent; return its refusal, or None if one agrees within a minute."""
        text = (
            f"{issuer_text(command.issuer)} wants: {printable(command.label, 100)} → {settings_text(command.public())}"
        )
        key = (command.issuer, command.place, text)
        if problem := self._why_not_asked(command.issuer, key):
            return Refused(ASK, problem, command_id=command.id)
        until = Time.from_seconds(self._clock.now() + _MAX_WAIT_S)
        message = OpenQuestion(
            question=command.id, text=printable(text, 300), device=command.device.id, issuer=command.issuer, until=until
        )
        question = self._open[command.id] = _Asked(command, message)
        self._node.log.info(
            ASKED, message=f"{message.text}? answer: homebot answer {command.id} yes", command=command.id
        )
        self._publish()
        end = _NOBODY
        try:
            with anyio.move_on_after(_MAX_WAIT_S):
                await question.answered.wait()
        except anyio.get_cancelled_exc_class():
            end = f"{issuer_text(command.issuer)} asks no more"
            raise
        finally:
            if command.id in self._open:
                self._close(command.id, end)
        if question.yes:
            self._journal.record_verdict(command, Verdict(ASK, allowed=True, reason=f"{question.by} said yes"))
            return None
        if question.by:
            self._denied[key] = question.by, self._clock.monotonic() + _MAX_WAIT_S
        nobody = f"{_NOBODY}: a person does on the page, or with `homebot answer`"
        return Refused(ASK, f"{question.by} said no" if question.by else nobody, command_id=command.id)

    def serve(self, name: str) -> None:
        """Create the service *name*: to list the questions, or to answer one."""
        if name == GET_QUESTIONS:
            self._node.create_service(GetQuestions, name, lambda _: self.listed())
        else:
            self._node.create_service(AnswerQuestion, name, self.answer)

    def answer(self, request: AnswerQuestionRequest) -> AnswerQuestionResponse:
        """Answer an open question, once, unless who answers may not give the command without asking."""
        question = self._open.get(request.question)
        if question is None:
            end = self._ends.get(request.question)
            unknown = "there is no such question now; `homebot answer` lists those that are open"
            problem = unknown if end is None else f"the question is over: {end}"
        else:
            problem = self._why_not_answered(question.command, request)
            if not problem:
                question.by, question.yes = request.issuer, request.yes
                question.answered.set()
                self._close(request.question, f"{request.issuer} said {'yes' if request.yes else 'no'}")
        return AnswerQuestionResponse(success=not problem, message=problem)

    def listed(self) -> OpenQuestions:
        """Return the open questions."""
        return OpenQuestions(questions=tuple(question.message for question in self._open.values()))

    def _why_not_asked(self, issuer: str, key: tuple[object, ...]) -> str:
        by, until = self._denied.get(key, ("", 0.0))
        if by and self._clock.monotonic() < until:
            return f"{by} said no a moment ago"
        own = sum(question.command.issuer == issuer for question in self._open.values())
        is_full = own >= _MAX_OPEN_OF_CLIENT or len(self._open) >= _MAX_OPEN
        return f"{len(self._open)} questions wait for an answer already" if is_full else ""

    def _why_not_answered(self, command: IssuedCommand, request: AnswerQuestionRequest) -> str:
        answering = replace(command, issuer=request.issuer, scope=request.scope)
        if not answering.is_client:
            return "only a person answers, through the door"
        if request.issuer == command.issuer:
            return f"{request.issuer} asks, so another answers: use the owner's token, and give programs their own"
        if must_ask(answering):
            return f"{request.issuer} must ask itself"
        return self._policies.client_refusal(answering)

    def _close(self, question: str, end: str) -> None:
        del self._open[question]
        self._ends[question] = end
        self._publish()

    def _publish(self) -> None:
        self._publisher.publish(self.listed())

    @cached_property
    def _publisher(self) -> Publisher[OpenQuestions]:
        return self._node.create_publisher(OpenQuestions, OPEN_QUESTIONS, qos_profile_latched)
