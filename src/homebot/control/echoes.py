"""Echoes: reports that repeat a command before the device obeyed, as many bridges send them. Pure.

A capability may be declared as echoed. Of the others it is learnt: where reports that came right after the command were
taken back again and again, those that come as fast are taken for echoes.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

__all__ = ["FAST", "NO_ECHOES", "EchoHistory", "ExpectedEchoes"]

FAST: Final = 0.1
"""Seconds after sending within which a report may be an echo that is not declared."""

_KEPT: Final = 16
_TOO_MANY: Final = 2
"""Fast reports taken back, of the last 16, that make the next ones echoes: one may be a person's hand."""

_FIRST_TRIES: Final = 3
_FIRST_WAIT: Final = 2.0  # seconds
_MOST: Final = 10_000

_Target: TypeAlias = tuple[str, str]


@dataclass(frozen=True, slots=True)
class ExpectedEchoes:
    """The echoes that a command may cause.

    Attributes:
        declared: The capabilities whose first report after sending is an echo.
        suspected: Those where it is one if it comes within :data:`FAST`.
        patience: Seconds from an echo after which nothing better is waited for.
    """

    declared: frozenset[str] = frozenset()
    suspected: frozenset[str] = frozenset()
    patience: float = 0.0


NO_ECHOES: Final = ExpectedEchoes()


@dataclass(slots=True)
class _EchoRecord:
    """Knowledge of one capability of a target.

    Attributes:
        taken_back: For each of the last fast reports, whether another value followed it soon.
        answered: For each of the last echoes, whether the device reported by itself after it.
    """

    taken_back: deque[bool] = field(default_factory=lambda: deque(maxlen=_KEPT))
    answered: deque[bool] = field(default_factory=lambda: deque(maxlen=_KEPT))


@final
class EchoHistory:
    """Outcomes of the echoes of each target: the last 16 of each of at most 10,000; the longest unused are forgotten.

    Only targets with an echo, or with a fast report that was taken back, are kept.
    """

    def __init__(self) -> None:
        self._known: OrderedDict[_Target, _EchoRecord] = OrderedDict()

    @property
    def is_empty(self) -> bool:
        """True if nothing was learnt yet."""
        return not self._known

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
        patience = max(self._patience(target, one, limit) for one in declared | suspected)
        return ExpectedEchoes(declared, suspected, patience)

    def note_fast(self, target: str, capability: str, *, taken_back: bool) -> None:
        """Note of a report that came within :data:`FAST` whether another value followed it."""
        if taken_back or (target, capability) in self._known:
            self._record(target, capability).taken_back.append(taken_back)

    def note_echo(self, target: str, capability: str, *, answered: bool) -> None:
        """Note of an echo whether the device reported by itself after it, whatever that was."""
        self._record(target, capability).answered.append(answered)

    def _is_suspect(self, target: str, capability: str) -> bool:
        record = self._known.get((target, capability))
        return record is not None and sum(record.taken_back) >= _TOO_MANY

    def _patience(self, target: str, capability: str, limit: float) -> float:
        """Return how long to wait after an echo: not at all where nothing ever follows."""
        record = self._known.get((target, capability))
        if record is not None and (any(record.answered) or any(record.taken_back)):
            return limit
        tries = 0 if record is None else len(record.answered)
        return min(_FIRST_WAIT, limit) if tries < _FIRST_TRIES else 0.0

    def _record(self, target: str, capability: str) -> _EchoRecord:
        record = self._known.setdefault((target, capability), _EchoRecord())
        self._known.move_to_end((target, capability))
        if len(self._known) > _MOST:
            self._known.popitem(last=False)
        return record
