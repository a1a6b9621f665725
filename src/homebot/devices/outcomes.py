"""Outcomes of commands: the result of a command, with the evidence for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import IntEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

if TYPE_CHECKING:
    from homebot.devices.device import Device
    from homebot.devices.value import PlainValue

NO_CONTROL = "the control layer is not running; it is restarted by itself, see `homebot doctor`"
"""Reason of a command without an answer."""


class Evidence(IntEnum):
    """Strength of the evidence that a device obeyed; higher is better.

    ``SENT``: it is assumed to be done, as in a dry run. ``ACKNOWLEDGED``: the network or a bridge accepted it; the
    report of a bridge that does not wait for the device is no better. ``REPORTED``: the device reported the new value.
    ``WITNESSED``: a second, independent device measured the effect.
    """

    SENT = 1
    ACKNOWLEDGED = 2
    REPORTED = 3
    WITNESSED = 4

    @property
    def text(self) -> str:
        """The grade as one word, for example ``reported``."""
        return self._name_.lower()  # `name` would cost another function call per command


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a command; exactly one of the classes below.

    Attributes:
        kind: Its word on the wire and in the journal.
        wire: The field of `CommandResult` that carries an attribute, if the two have different names.
        succeeded: Whether the device is as commanded; if not, ``homebot do`` exits with 1.
        is_failure: Whether the log warns of it, and the page shows it in red.
        may_obey_later: Whether the device may have obeyed, or may yet: the wanted value is then a late answer.
        is_final: Whether repeating the command would have the same outcome, for example during a hold.
        judges_device: Whether it shows how well the device obeys; a refusal, for example, is about the command.
        explains_reports: Whether earlier reports were changes made by the command.
        command_id: The id of the command in the journal.
        reported: The values that the device reported as commanded, by capability; not compared.
        warning: Why a person had better look, although the policies let the command pass, or which step of the device
            was nearest; not compared.
    """

    kind: ClassVar[str]
    wire: ClassVar[Mapping[str, str]] = MappingProxyType({})
    succeeded: ClassVar[bool] = False
    is_failure: ClassVar[bool] = True
    may_obey_later: ClassVar[bool] = False
    is_final: ClassVar[bool] = False
    judges_device: ClassVar[bool] = False
    explains_reports: ClassVar[bool] = False
    _was_sent: ClassVar[bool] = True
    _words: ClassVar[str]  # the format of `text`, with fields of the outcome

    _: KW_ONLY
    command_id: str = ""
    reported: Mapping[str, PlainValue] = field(default_factory=dict, compare=False, repr=False)
    warning: str = field(default="", compare=False, repr=False)

    @property
    def text(self) -> str:
        """The outcome as a clause for people, without the name of the device, and the warning."""
        return f"{self._clause()}; {self.warning}" if self.warning else self._clause()

    def _clause(self) -> str:
        return self._words.format(self)

    @property
    def was_sent(self) -> bool:
        """True if it was decided by the answer of the device, or its silence, rather than before sending."""
        return self._was_sent


@dataclass(frozen=True, slots=True)
class Confirmed(Outcome):
    """The device obeyed; with the evidence ``ACKNOWLEDGED`` only its network accepted the command.

    Attributes:
        latency: Seconds from sending to the evidence.
        evidence: The evidence for it.
        witness: The name of the device that observed it; empty if none did.
    """

    kind: ClassVar[str] = "confirmed"
    succeeded: ClassVar[bool] = True
    is_failure: ClassVar[bool] = False
    judges_device: ClassVar[bool] = True
    explains_reports: ClassVar[bool] = True
    latency: float
    evidence: Evidence
    witness: str = ""

    def _clause(self) -> str:
        if self.evidence is Evidence.SENT:
            return "not sent, and assumed to be done"
        by = f" by {self.witness}" if self.witness else ""
        verb = "accepted by the network after" if self.evidence is Evidence.ACKNOWLEDGED else "confirmed after"
        return f"{verb} {_seconds_text(self.latency)} s ({self.evidence.text}{by})"


@dataclass(frozen=True, slots=True)
class AlreadySo(Outcome):
    """The device had already reported the value, and nothing contradicted it.

    If that was in the last minute, nothing was sent, except to stop or to open a latch.
    """

    kind: ClassVar[str] = "already_so"
    _words: ClassVar[str] = "it was so already"
    succeeded: ClassVar[bool] = True
    is_failure: ClassVar[bool] = False
    _was_sent: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Contradicted(Outcome):
    """The device reports something else, or a witness observed that nothing happened.

    Attributes:
        saw: The report, as text, for example ``on_off is on``, or the observation of a witness.
        witness: The name of the device that observed it; empty if the commanded device itself reports it.
    """

    kind: ClassVar[str] = "contradicted"
    may_obey_later: ClassVar[bool] = True
    judges_device: ClassVar[bool] = True
    _words: ClassVar[str] = "contradicted: {0.saw}"
    saw: str
    witness: str = ""


@dataclass(frozen=True, slots=True)
class Reverted(Outcome):
    """The device obeyed, but reported another value soon after, without another command.

    Attributes:
        after: Seconds after it obeyed.
        cause: ``device`` if it does so after each command, ``person`` if it never does, else ``unknown``.
    """

    kind: ClassVar[str] = "reverted"
    wire: ClassVar[Mapping[str, str]] = MappingProxyType({"after": "latency", "cause": "reason"})
    judges_device: ClassVar[bool] = True
    after: float
    cause: str = "unknown"

    def _clause(self) -> str:
        return f"changed back after {_seconds_text(self.after)} s, {cause_text(self.cause)}"


def cause_text(cause: str) -> str:
    """Return the cause of a change that no command explains, or of an undoing, in words."""
    words = {"device": "by itself", "person": "by hand", "program": "by another program"}
    return words.get(cause, "by hand or by itself")


@dataclass(frozen=True, slots=True)
class NoAnswer(Outcome):
    """The device reported nothing since the command was last sent, or since it began to move.

    Attributes:
        waited: Seconds.
        reason: Why it could not be sent, as text; empty if it was sent.
        is_unacknowledged: Whether it was sent but not acknowledged by its network, so it may arrive later.
    """

    kind: ClassVar[str] = "no_answer"
    may_obey_later: ClassVar[bool] = True
    wire: ClassVar[Mapping[str, str]] = MappingProxyType({"waited": "latency"})
    judges_device: ClassVar[bool] = True
    waited: float
    reason: str = ""
    is_unacknowledged: bool = False

    @property
    def was_sent(self) -> bool:
        """As for :class:`Outcome`."""
        return not self.reason

    def _clause(self) -> str:
        if self.reason:
            return f"not sent: {self.reason}"
        later = "; its network has not acknowledged it, and may still deliver it" if self.is_unacknowledged else ""
        return f"no answer within {_seconds_text(self.waited)} s{later}"


@dataclass(frozen=True, slots=True)
class Superseded(Outcome):
    """A newer command to the same part replaced it.

    Attributes:
        by: The id of the newer command.
    """

    kind: ClassVar[str] = "superseded"
    is_failure: ClassVar[bool] = False
    explains_reports: ClassVar[bool] = True
    _words: ClassVar[str] = "superseded by command {0.by}"
    by: str


@dataclass(frozen=True, slots=True)
class Refused(Outcome):
    """A policy, a lease, the gateway or the device refused it.

    Attributes:
        policy: The name of the policy that refused, or ``gateway`` or ``device``.
    """

    kind: ClassVar[str] = "refused"
    is_final: ClassVar[bool] = True
    _was_sent: ClassVar[bool] = False
    _words: ClassVar[str] = "refused ({0.policy}): {0.reason}"
    policy: str
    reason: str


@dataclass(frozen=True, slots=True)
class Gone(Outcome):
    """The device or its part was removed, before or during the wait.

    Attributes:
        reason: The missing thing, as text; empty if it existed before.
    """

    kind: ClassVar[str] = "gone"
    is_final: ClassVar[bool] = True
    _was_sent: ClassVar[bool] = False
    reason: str = ""

    def _clause(self) -> str:
        return self.reason or "the device was removed"


# A new outcome needs a class, its place here, and an import in `homebot`: messages, journal, replays, all clients and
# the reference read the rest from the class.
_BEST_FIRST: Final = (AlreadySo, Confirmed, Superseded, Reverted, Contradicted, NoAnswer, Refused, Gone)

OUTCOMES: Final[Mapping[str, type[Outcome]]] = MappingProxyType({outcome.kind: outcome for outcome in _BEST_FIRST})
"""All outcomes by kind, best first."""


def has_succeeded(kind: str) -> bool:
    """Return whether the outcome *kind* is a success; False for one of a newer homebot."""
    return kind in OUTCOMES and OUTCOMES[kind].succeeded


def worst(outcomes: tuple[Outcome, ...]) -> Outcome:
    """Return the worst of *outcomes*, at least one; of two confirmed ones, the one with weaker evidence."""
    return max(outcomes, key=_badness)


def _badness(outcome: Outcome) -> tuple[int, int]:
    evidence = outcome.evidence if isinstance(outcome, Confirmed) else 0
    return _BEST_FIRST.index(type(outcome)), -evidence


def _seconds_text(seconds: float) -> str:
    """Return *seconds* with two significant digits, or all digits before the point."""
    if 0 < seconds < 0.001:
        return "less than 0.001"
    return f"{seconds:.2g}" if seconds < 10 else f"{seconds:.0f}"


def no_such_part(device_id: str, part_id: str, device: Device | None, command_id: str = "") -> Gone:
    """Return the outcome of a command to a *device* that is None or has no such part."""
    if device is None:
        text = f"there is no device with the id {device_id}"
    else:
        known = ", ".join(part.id for part in device.parts if part.id) or "one part without an id"
        problem = f"{device_id} has no part {part_id}" if part_id else f"no single part of {device_id} takes that"
        text = f"{problem}; it has {known}"
    return Gone(text, command_id=command_id)
