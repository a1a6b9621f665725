"""Outcomes of commands: the result of a command, and how well it is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import IntEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

__all__ = [
    "NO_CONTROL",
    "OUTCOMES",
    "AlreadySo",
    "Confirmed",
    "Contradicted",
    "Evidence",
    "Gone",
    "NoAnswer",
    "Outcome",
    "Refused",
    "Reverted",
    "Superseded",
    "has_succeeded",
    "worst",
]


NO_CONTROL = "the control layer is not running; it is restarted by itself, see `homebot doctor`"
"""Reason of a command without an answer."""


class Evidence(IntEnum):
    """Grade of the knowledge that a device obeyed; the higher the better.

    ``SENT``: it is taken for done, as in a dry run. ``ACKNOWLEDGED``: the network or a bridge accepted it; the report
    of a bridge that does not wait for the device is no better. ``REPORTED``: the device reported the new value.
    ``WITNESSED``: a second, independent device measured the effect.
    """

    SENT = 1
    ACKNOWLEDGED = 2
    REPORTED = 3
    WITNESSED = 4

    @property
    def text(self) -> str:
        """The grade as one word, for example ``reported``."""
        return self._name_.lower()  # `name` is a function call more, for each command


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a command; exactly one of the classes below.

    Attributes:
        kind: Its word on the wire and in the journal.
        wire: The field of `CommandResult` that carries an attribute, where the two have different names.
        succeeded: Whether the device is as it was told to be; one that is not makes ``homebot do`` exit with 1.
        is_failure: Whether the log warns of it, and the page shows it in red.
        may_obey_later: Whether the device may have obeyed, or may yet: the wanted value is then a late answer.
        is_final: Whether the same command would end so again, for example in the block of a hold.
        judges_device: Whether it tells how well the device obeys; a refusal, for example, is about the command.
        explains_reports: Whether the reports before it were changes by the command.
        command_id: The id of the command, under which the journal has its story.
        reported: The values that the device reported as they were commanded, by capability; not compared.
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
    _words: ClassVar[str]  # of `text`, with fields of the outcome

    _: KW_ONLY
    command_id: str = ""
    reported: Mapping[str, PlainValue] = field(default_factory=dict, compare=False, repr=False)

    @property
    def text(self) -> str:
        """The outcome as a clause for people, without the device."""
        return self._words.format(self)

    @property
    def was_sent(self) -> bool:
        """True if the answer of the device, or its silence, decided it, and nothing before."""
        return self._was_sent


@dataclass(frozen=True, slots=True)
class Confirmed(Outcome):
    """The device obeyed; with the evidence ``ACKNOWLEDGED`` its network accepted the command, and it may be away.

    Attributes:
        latency: Seconds from sending to the evidence.
        evidence: How well it is known.
        witness: The name of the device that saw it; empty if none did.
    """

    kind: ClassVar[str] = "confirmed"
    succeeded: ClassVar[bool] = True
    is_failure: ClassVar[bool] = False
    judges_device: ClassVar[bool] = True
    explains_reports: ClassVar[bool] = True
    latency: float
    evidence: Evidence
    witness: str = ""

    @property
    def text(self) -> str:
        """As for :class:`Outcome`."""
        if self.evidence is Evidence.SENT:
            return "not sent, and taken for done"
        by = f" by {self.witness}" if self.witness else ""
        verb = "accepted by the network" if self.evidence is Evidence.ACKNOWLEDGED else "confirmed"
        return f"{verb} after {_seconds_text(self.latency)} s ({self.evidence.text}{by})"


@dataclass(frozen=True, slots=True)
class AlreadySo(Outcome):
    """The device had reported that it is so, and nothing contradicted it.

    If that was in the last minute, nothing was sent, except for stop and opening a latch.
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
        witness: The name of the device that saw it; empty if the commanded one itself reports it.
    """

    kind: ClassVar[str] = "contradicted"
    may_obey_later: ClassVar[bool] = True
    judges_device: ClassVar[bool] = True
    _words: ClassVar[str] = "contradicted: {0.saw}"
    saw: str
    witness: str = ""


@dataclass(frozen=True, slots=True)
class Reverted(Outcome):
    """The device obeyed, and reported another value soon after, without another command.

    Attributes:
        after: Seconds after it had obeyed.
        cause: ``device`` if it does so after each command, ``unknown`` if it may be a person as well.
    """

    kind: ClassVar[str] = "reverted"
    wire: ClassVar[Mapping[str, str]] = MappingProxyType({"after": "latency", "cause": "reason"})
    judges_device: ClassVar[bool] = True
    after: float
    cause: str = "unknown"

    @property
    def text(self) -> str:
        """As for :class:`Outcome`."""
        by = "by itself, as usual" if self.cause == "device" else "by a hand or by itself"
        return f"changed back after {_seconds_text(self.after)} s, {by}"


@dataclass(frozen=True, slots=True)
class NoAnswer(Outcome):
    """The device reported nothing since the command was last sent, or since it began to move.

    Attributes:
        waited: Seconds.
        reason: Why it could not be sent, as text; empty if it was sent.
        is_unacknowledged: Whether it was sent, and its network has not acknowledged it, so that it may arrive later.
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

    @property
    def text(self) -> str:
        """As for :class:`Outcome`."""
        if self.reason:
            return f"not sent: {self.reason}"
        later = "; its network has not acknowledged it, and may still deliver it" if self.is_unacknowledged else ""
        return f"no answer within {_seconds_text(self.waited)} s{later}"


@dataclass(frozen=True, slots=True)
class Superseded(Outcome):
    """A newer command to the same part took its place.

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
    """A policy, a lease, the gateway or the device said no.

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
        reason: What there is not, as text; empty if it was there before.
    """

    kind: ClassVar[str] = "gone"
    is_final: ClassVar[bool] = True
    _was_sent: ClassVar[bool] = False
    reason: str = ""

    @property
    def text(self) -> str:
        """As for :class:`Outcome`."""
        return self.reason or "the device was removed"


# A new outcome is a class, its place here, and an import in `homebot`: the wire, the journal, replays, all clients
# and the reference read the rest from the class.
_BEST_FIRST: Final = (AlreadySo, Confirmed, Superseded, Reverted, Contradicted, NoAnswer, Refused, Gone)

OUTCOMES: Final[Mapping[str, type[Outcome]]] = MappingProxyType({one.kind: one for one in _BEST_FIRST})
"""All of them, by their word, the best first."""


def has_succeeded(kind: str) -> bool:
    """Return whether *kind*, the word of an outcome, is a success; False for one of a newer homebot."""
    return kind in OUTCOMES and OUTCOMES[kind].succeeded


def worst(outcomes: tuple[Outcome, ...]) -> Outcome:
    """Return the worst of *outcomes*, at least one; of two confirmed ones the one that is known less well."""
    return max(outcomes, key=_badness)


def _badness(outcome: Outcome) -> tuple[int, int]:
    evidence = outcome.evidence if isinstance(outcome, Confirmed) else 0
    return _BEST_FIRST.index(type(outcome)), -evidence


def _seconds_text(seconds: float) -> str:
    """Return *seconds* with two digits, or all before the point."""
    if 0 < seconds < 0.001:
        return "less than 0.001"
    return f"{seconds:.2g}" if seconds < 10 else f"{seconds:.0f}"
