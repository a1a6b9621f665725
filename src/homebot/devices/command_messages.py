"""Services and messages of the control layer: commands, and their outcomes."""

from dataclasses import fields
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, ConfigDict, Field

from homebot.devices.device import KeyValue
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue, ShortText, Value
from homebot.messages.message import LocalServiceType, Message, ServiceAnswer, ServiceType, UInt8

if TYPE_CHECKING:
    from collections.abc import Iterable

    from homebot.devices.outcomes import Outcome


@lru_cache(maxsize=1)
def _words() -> tuple[str, ...]:
    from homebot.devices.outcomes import OUTCOMES  # noqa: PLC0415 - a start without a command needs none

    return tuple(OUTCOMES)


def _known(word: str) -> str:
    if word not in (words := _words()):
        raise ValueError(f"must be one of {', '.join(words)}, got {word[:40]!r}")
    return word


def _add_words(schema: dict[str, object], *more: str) -> None:
    schema["enum"] = [*more, *_words()]


OutcomeKind: TypeAlias = Annotated[str, AfterValidator(_known), Field(json_schema_extra=_add_words)]
"""The word of an outcome, see :data:`homebot.devices.outcomes.OUTCOMES`."""

_WorstKind: TypeAlias = Annotated[
    str,
    AfterValidator(lambda word: word and _known(word)),
    Field(json_schema_extra=lambda schema: _add_words(schema, "")),
]

MAX_SETTINGS = 20
"""Settings of one command."""

MAX_TRANSITION_S = 86_400.0

_MAX_SCOPES = 100


class Setting(Message):
    """One capability and its desired value.

    Attributes:
        value: The value, in the unit of the vocabulary.
    """

    capability: ShortText
    value: Value

    @staticmethod
    @lru_cache(maxsize=256, typed=True)
    def of(capability: str, plain: PlainValue) -> "Setting":
        """Return the setting of *capability* to *plain*; cached, because values recur in reports and repetitions."""
        return Setting(capability=capability, value=Value.of(plain))


class CommandRequest(Message):
    """A command to one part of a device: one or more settings, which are sent in this order.

    Attributes:
        part: The id of the part; empty for the only one that takes all settings, not counting configuration parts.
        settings: The desired values, each capability once.
        transition: Seconds that the change takes, if the device supports that.
        code: The code that an alarm or a lock requires; a secret that no text about the command shows.
        issuer: The issuer of the command: the name of the node, or ``client:NAME`` for a client of the door.
        scope: The rights of a client of the door, by its token: ``read``, ``act: all``, ``act: light in hall``; empty
            if it has no token. The door sets it, overwriting the client's. It is ignored for a node: the rights of apps
            are in the configuration.
        ask_first: Whether a person must agree first, as to commands of clients with the right ``ask``.
        override: Whether a person's command outranks leases of the part, as a hand does; it does not for a robot.
        batch: A name that the issuer gives to the commands that it gives at once, of which those to exactly the members
            of a group may share one message; empty for a command by itself. See :func:`homebot.devices.batch.as_batch`.
        batch_size: The number of commands in the batch.
        cause: The id of its cause, such as a report; empty for a person's command.
        trigger: The cause with its facts, as far as the issuer knows them.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    device: ShortText
    part: ShortText = ""
    settings: Annotated[tuple[Setting, ...], Field(min_length=1, max_length=MAX_SETTINGS)]
    transition: float = 0.0
    code: Annotated[str, Field(repr=False, max_length=255)] = ""
    issuer: str
    scope: Annotated[tuple[str, ...], Field(max_length=_MAX_SCOPES)] = ()
    ask_first: bool = False
    override: bool = False
    batch: ShortText = ""
    batch_size: int = 0
    cause: ShortText = ""
    trigger: Trigger = NO_TRIGGER


class CommandResult(Message):
    """Outcome of a command, for other programs, the journal and recordings.

    Attributes:
        outcome: The kind of outcome; fields below that do not belong to it are empty.
        text: The outcome as text for people.
        reported: ``confirmed``: the values that the device reported.
        latency: ``confirmed``: seconds from sending to the evidence; ``reverted``: seconds after it obeyed;
            ``no_answer``: seconds waited.
        evidence: ``confirmed``: 1 sent, 2 acknowledged, 3 reported, 4 witnessed.
        saw: ``contradicted``: the reported value.
        witness: ``confirmed`` and ``contradicted``: the name of the second device that observed it; empty if none did.
        by: ``superseded``: the id of the newer command.
        policy: ``refused``: the policy, or ``gateway`` or ``device``.
        reason: ``refused``, and ``no_answer`` if it was not sent: the reason; ``reverted``: ``device``, ``person``,
            or ``unknown`` if it may be either; ``gone``: the missing thing.
        is_unacknowledged: ``no_answer``: whether it was sent but its network has not acknowledged it, so it may arrive
            later.
        warning: Why a person had better look, although the policies let the command pass; the end of the text.
    """

    command_id: str
    outcome: OutcomeKind
    text: str
    reported: tuple[Setting, ...] = ()
    latency: float = 0.0
    evidence: Annotated[UInt8, Field(le=4)] = 0
    saw: str = ""
    witness: str = ""
    by: str = ""
    policy: str = ""
    reason: str = ""
    is_unacknowledged: bool = False
    warning: str = ""

    @staticmethod
    def answer_type() -> "type[Outcome]":
        """Return the type that this message represents."""
        from homebot.devices.outcomes import Outcome  # noqa: PLC0415 - a start without a command needs none

        return Outcome

    @classmethod
    def of(cls, outcome: "Outcome") -> "CommandResult":
        """Return the message that carries *outcome*."""
        facts = {outcome.wire.get(field.name, field.name): getattr(outcome, field.name) for field in fields(outcome)}
        facts["reported"] = tuple([Setting.of(*pair) for pair in outcome.reported.items()])
        return cls(outcome=outcome.kind, text=outcome.text, **facts)

    def to_outcome(self) -> "Outcome":
        """Return the outcome that this message carries."""
        from homebot.devices.outcomes import OUTCOMES, Evidence  # noqa: PLC0415 - a start without a command needs none

        kind = OUTCOMES[self.outcome]
        facts = {field.name: getattr(self, kind.wire.get(field.name, field.name)) for field in fields(kind)}
        facts["reported"] = {setting.capability: setting.value.plain() for setting in self.reported}
        if "evidence" in facts:
            facts["evidence"] = Evidence(self.evidence)
        return kind(**facts)


class CommandEvent(Message):
    """News about a command after its outcome: the device went back.

    Attributes:
        result: The outcome that replaces the first one.
    """

    key_field: ClassVar[str | None] = "result.command_id"

    device: str
    part: str
    issuer: str
    result: CommandResult


PerformCommand: "ServiceType[CommandRequest, Outcome]" = LocalServiceType(
    "homebot/srv/PerformCommand", CommandRequest, CommandResult
)


class CommandDevicesRequest(Message):
    """A command in words to one device, or to all devices that fit a query.

    Attributes:
        target: The id or a name of a device, ``ID#PART`` for one of its parts, or a query such as ``light in hall``.
        command: A word that the devices take: ``on``, ``off``, ``open``, ``close``, ``stop``, ``lock``, ``unlock``,
            ``press``, an option such as ``cleaning``, a number, ``level 40``; ``set`` if only *values* count.
        values: Values by capability, as text, for example ``level`` and ``40``, or ``color_temperature`` and ``2700``.
        transition: Seconds that the change takes, if a device supports that.
        code: The code that an alarm or a lock requires; a secret.
        issuer: The issuer of the command; the door sets it for its clients.
        scope: As for :class:`CommandRequest`.
        ask_first: Whether a person must agree first.
        override: As for :class:`CommandRequest`.
        unless_asks: Whether to do nothing if a part always asks: ``asks`` of the answer says why, and the client asks
            the person at it, and sends it again without.
        cause: The id of its cause; may be empty.
        trigger: What led to it; only homebot's own nodes can say so.
    """

    model_config = ConfigDict(hide_input_in_errors=True)

    target: str
    command: str = "set"
    values: Annotated[tuple[KeyValue, ...], Field(max_length=MAX_SETTINGS)] = ()
    transition: Annotated[float, Field(ge=0.0, le=MAX_TRANSITION_S)] = 0.0
    code: Annotated[str, Field(repr=False, max_length=255)] = ""
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=_MAX_SCOPES)] = ()
    ask_first: bool = False
    override: bool = False
    unless_asks: bool = False
    cause: str = ""
    trigger: Trigger = NO_TRIGGER


class CommandedPart(Message):
    """One part that was commanded, and its outcome.

    Attributes:
        name: The device's name for people, with that of the part if it has several.
    """

    device: str
    name: str
    part: str
    result: CommandResult


class CommandDevicesResponse(ServiceAnswer):
    """The outcomes of a command in words; a success if at least one part was commanded, and all obeyed.

    The message is the reason why nothing was commanded, or the name and text of the worst outcome.

    Attributes:
        outcome: The worst outcome; empty if nothing was commanded.
        results: Each commanded part, sorted by device.
        asks: The parts for which a person must agree first, as ``unless_asks`` wanted, each with the reason.
    """

    outcome: _WorstKind = ""
    results: tuple[CommandedPart, ...] = ()
    asks: tuple[KeyValue, ...] = ()

    @classmethod
    def of(cls, commanded: "Iterable[tuple[CommandedPart, Outcome]]") -> "CommandDevicesResponse":
        """Return the response for these parts, at least one, with their outcomes."""
        from homebot.devices.outcomes import worst  # noqa: PLC0415 - a start without a command needs none

        parts, outcomes = zip(*sorted(commanded, key=lambda pair: (pair[0].device, pair[0].part)), strict=True)
        worst_one = parts[outcomes.index(worst(outcomes))]
        is_done = all(outcome.succeeded for outcome in outcomes)
        return cls(
            success=is_done,
            message="" if is_done else f"{worst_one.name}: {worst_one.result.text}",
            outcome=worst_one.result.outcome,
            results=parts,
        )


CommandDevices = ServiceType("homebot/srv/CommandDevices", CommandDevicesRequest, CommandDevicesResponse)


class SendTextRequest(Message):
    """A raw text for a device.

    Attributes:
        issuer: The sender: the name of the node, or ``client:NAME`` for a client of the door.
        scope: As for :class:`CommandRequest`.
    """

    device: ShortText
    payload: str
    issuer: str
    scope: Annotated[tuple[str, ...], Field(max_length=_MAX_SCOPES)] = ()
    trigger: Trigger = NO_TRIGGER


class SendTextResponse(ServiceAnswer):
    """The result; a success does not prove that the device obeyed.

    Attributes:
        problem: ``refused`` by a policy, a lease or the gateway; ``unreachable`` if the gateway is now.
        others: The names of other parts that would have accepted the text but did not get it.
    """

    problem: Literal["", "refused", "unreachable"] = ""
    others: tuple[str, ...] = ()
    command_id: str = ""

    @classmethod
    def of(cls, outcome: "Outcome") -> "SendTextResponse":
        """Return the response for a text that was not sent: *outcome* is that of a rehearsal, or why not."""
        if outcome.succeeded:
            return cls(success=True, command_id=outcome.command_id)
        result = CommandResult.of(outcome)
        message = f"{result.reason} ({result.policy})" if result.policy else result.reason or result.text
        problem: Literal["refused", "unreachable"] = "unreachable" if result.outcome == "no_answer" else "refused"
        return cls(success=False, message=message, problem=problem, command_id=outcome.command_id)


SendText = ServiceType("homebot/srv/SendText", SendTextRequest, SendTextResponse)
