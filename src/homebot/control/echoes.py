"""Echoes: reports that repeat a command before the device obeyed, as many bridges send them. Pure.

A capability may be declared as echoed. Of the others it is learnt: where reports that came right after the command were
taken back again and again, those that come as fast are taken for echoes. A device that obeys and goes back by itself is
told apart: it does so after the same time each time, later than a bridge asks, or it was seen to obey.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, Final, NamedTuple, TypeAlias, final

from pydantic import Field

from homebot.control.learnt_record import KeepLearnt, LearntRecord

__all__ = ["FAST", "NO_ECHOES", "EchoHistory", "ExpectedEchoes"]

FAST: Final = 0.1
"""Seconds after sending within which a report may be an echo that is not declared."""

_KEPT: Final = 16
_TOO_MANY: Final = 2
"""Fast reports taken back, of the last 16, that make the next ones echoes: one may be a person's hand."""

_SOON: Final = 3.0
"""Seconds within which a bridge that was refused, or reads back, takes its echo back: two such are enough."""

_TIMER_SPREAD: Final = 0.5
"""Seconds by which the times may differ after which a device goes back by a timer of its own."""

_FIRST_TRIES: Final = 3
_FIRST_WAIT: Final = 2.0  # seconds
_MOST: Final = 10_000

_Target: TypeAlias = tuple[str, str]
_Seconds: TypeAlias = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class ExpectedEchoes(NamedTuple):
    """The echoes that a command may cause.

    Attributes:
        declared: The capabilities whose first report after sending is an echo.
        suspected: Those where it is one if it comes within :data:`FAST`.
        repeated: Those of both whose echo is repeated by the bridge, so that no further report of the same is better.
        patience: Seconds from an echo after which nothing better is waited for.
    """

    declared: frozenset[str] = frozenset()
    suspected: frozenset[str] = frozenset()
    repeated: frozenset[str] = frozenset()
    patience: float = 0.0


NO_ECHOES: Final = ExpectedEchoes()


@dataclass(slots=True)
class _EchoRecord:
    """Knowledge of one capability of a target.

    Attributes:
        fast: For each of the last fast reports, after how many seconds another value followed it; None where none did,
            or where the device had obeyed meanwhile.
        false_repeats: For each of the last fast reports that were repeated, whether another value followed it.
        answered: For each of the last echoes, whether the device reported by itself after it.
    """

    fast: deque[float | None] = field(default_factory=lambda: deque(maxlen=_KEPT))
    false_repeats: deque[bool] = field(default_factory=lambda: deque(maxlen=_KEPT))
    answered: deque[bool] = field(default_factory=lambda: deque(maxlen=_KEPT))

    @property
    def taken_back(self) -> list[float]:
        """The seconds after which fast reports were taken back."""
        return [one for one in self.fast if one is not None]

    @property
    def is_suspect(self) -> bool:
        """True if the next fast report may be an echo, and not that of a device that goes back by a timer."""
        taken_back = self.taken_back
        if sum(seconds <= _SOON for seconds in taken_back) >= _TOO_MANY:
            return True
        return len(taken_back) > _TOO_MANY and max(taken_back) - min(taken_back) > _TIMER_SPREAD

    @property
    def is_repeated(self) -> bool:
        """True if the bridge repeats its echoes, as one does that tells what it holds for the state."""
        return sum(self.false_repeats) >= _TOO_MANY


class _KeptEchoes(LearntRecord):
    title = "echo that was learnt"

    target: str
    capability: str
    fast: Annotated[tuple[_Seconds | None, ...], Field(max_length=_KEPT)] = ()
    false_repeats: Annotated[tuple[bool, ...], Field(max_length=_KEPT)] = ()
    answered: Annotated[tuple[bool, ...], Field(max_length=_KEPT)] = ()

    @property
    def kept_as(self) -> str:
        return _name(self.target, self.capability)


@final
class EchoHistory:
    """Outcomes of the echoes of each target: the last 16 of each of at most 10,000; the longest unused are forgotten.

    Only targets with an echo, or with a fast report that was taken back, are kept.

    Args:
        keep: Keeps what is learnt over a restart.

    Attributes:
        known: What was learnt, by target and capability; for reading.
    """

    def __init__(self, keep: KeepLearnt) -> None:
        self._keep = keep
        self.known: OrderedDict[_Target, _EchoRecord] = OrderedDict()

    def expected(self, target: str, settings: Iterable[str], declared: frozenset[str], limit: float) -> ExpectedEchoes:
        """Return the echoes that a command to *target* may cause.

        Args:
            target: What is commanded.
            settings: The capabilities that are set.
            declared: Those of them that are declared as echoed.
            limit: Seconds that the device may take for its own report.
        """
        suspected = frozenset(one for one in settings if one not in declared and self._is_suspect(target, one))
        if not declared and not suspected:
            return NO_ECHOES
        echoed = declared | suspected
        repeated = frozenset(one for one in echoed if self._of(target, one).is_repeated)
        patience = max(self._patience(target, one, limit) for one in echoed)
        return ExpectedEchoes(declared, suspected, repeated, patience)

    def note_fast(
        self, target: str, capability: str, command: str, taken_back_after: float | None, *, is_repeated: bool
    ) -> None:
        """Note a report that came within :data:`FAST` of *command*.

        Args:
            target: What was commanded.
            capability: What was reported.
            command: The id of the command.
            taken_back_after: Seconds after which another value followed it; None where none did, or where the device
                had obeyed meanwhile.
            is_repeated: Whether it was reported again before.
        """
        if taken_back_after is not None or (target, capability) in self.known:
            known = self._record(target, capability)
            known.fast.append(taken_back_after)
            if is_repeated:
                known.false_repeats.append(taken_back_after is not None)
            self._save(target, capability, command)

    def note_echo(self, target: str, capability: str, command: str, *, answered: bool) -> None:
        """Note of an echo whether the device reported by itself after it, whatever that was."""
        self._record(target, capability).answered.append(answered)
        self._save(target, capability, command)

    def restore(self, name: str, record: str) -> None:
        """Take over what an earlier run learnt.

        Args:
            name: The name under which it was kept.
            record: The record.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        row = _KeptEchoes.read(name, record)
        known = self._record(row.target, row.capability)
        known.fast.extendleft(reversed(row.fast))
        known.false_repeats.extendleft(reversed(row.false_repeats))
        known.answered.extendleft(reversed(row.answered))

    def _save(self, target: str, capability: str, command: str) -> None:
        known = self.known[target, capability]
        row = _KeptEchoes(
            target=target,
            capability=capability,
            fast=tuple(known.fast),
            false_repeats=tuple(known.false_repeats),
            answered=tuple(known.answered),
        )
        self._keep(row.kept_as, row.model_dump_json(), command)

    def _is_suspect(self, target: str, capability: str) -> bool:
        return self._of(target, capability).is_suspect

    def _of(self, target: str, capability: str) -> _EchoRecord:
        """Return what is known of a capability; nothing of it is kept."""
        return self.known.get((target, capability)) or _EchoRecord()

    def _patience(self, target: str, capability: str, limit: float) -> float:
        """Return how long to wait after an echo: not at all where nothing ever follows."""
        record = self._of(target, capability)
        if any(record.answered) or record.taken_back:
            return limit
        return min(_FIRST_WAIT, limit) if len(record.answered) < _FIRST_TRIES else 0.0

    def _record(self, target: str, capability: str) -> _EchoRecord:
        record = self.known.setdefault((target, capability), _EchoRecord())
        self.known.move_to_end((target, capability))
        if len(self.known) > _MOST:
            forgotten, _ = self.known.popitem(last=False)
            self._keep(_name(*forgotten), "", "")
        return record


def _name(target: str, capability: str) -> str:
    return f"{target} {capability}"
