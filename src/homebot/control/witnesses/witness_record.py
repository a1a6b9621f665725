"""Observations of a sensor at commands to one part, and what it will therefore see. Pure.

Only counts, medians and extremes of the kept observations are used, so that a person can check each conclusion.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final, final

from homebot.control.witnesses.effect import Effect

__all__ = ["MOST_OBSERVATIONS", "Expected", "Observation", "WitnessRecord"]

ENOUGH: Final = 5
"""Consistent observations in each direction before a sensor is trusted."""

_KEPT: Final = 16

MOST_OBSERVATIONS: Final = 2 * _KEPT
"""Observations of one record, in both directions."""

_UNFAILING: Final = 16
"""Effects in a row that a sensor saw before its silence tells as much as a report."""

_SIZE_SLACK: Final = 5.0  # of 100


@dataclass(frozen=True, slots=True)
class Observation:
    """One confirmed command, and what a sensor did, while nothing else near it changed.

    Attributes:
        effect: What the command changed.
        before: The reading before.
        change: By how much it changed in the expected direction, at most.
        delay: Seconds from the device's report to that change; 0 where it came before.
        swing: By how much it went up and down in the time before the command.
        fell_silent: Whether its device reported nothing more after that change, as one that reports only changes.
    """

    effect: Effect
    before: float
    change: float
    delay: float
    swing: float
    fell_silent: bool = False


@dataclass(frozen=True, slots=True)
class Expected:
    """Change that a trusted sensor will see.

    Attributes:
        least: The smallest change among those that count.
        most: The greatest.
        slowest: The longest delay, in seconds.
        within: Seconds after which a change that has not come will not come.
    """

    least: float
    most: float
    slowest: float
    within: float


@final
class WitnessRecord:
    """The last 16 observations of one sensor in each direction; the oldest is forgotten.

    Attributes:
        seen_in_row: How many effects the sensor saw in a row, without missing one that it would have shown.
    """

    def __init__(self) -> None:
        self.seen_in_row = 0
        self._kept: dict[bool, deque[Observation]] = {True: deque(maxlen=_KEPT), False: deque(maxlen=_KEPT)}

    def note(self, observation: Observation) -> None:
        """Take in an observation, whether or not the sensor saw anything."""
        self._kept[observation.effect.rises].append(observation)
        self.seen_in_row = self.seen_in_row + 1 if observation.change else 0

    def note_silence(self) -> None:
        """Take in that it was silent at an effect that it would have shown, by whatever fault."""
        self.seen_in_row = 0

    @property
    def observations(self) -> tuple[Observation, ...]:
        """The observations, those of each direction oldest first."""
        return (*self._kept[False], *self._kept[True])

    @property
    def is_unfailing(self) -> bool:
        """True if its silence tells that there was no effect: it reports changes alone, and missed none for long."""
        silent = [one.fell_silent for one in self.observations]
        return self.seen_in_row >= _UNFAILING and 2 * sum(silent) > len(silent)

    def expected(self, *, rises: bool) -> Expected | None:
        """Return what it will see; None where it is not trusted.

        It is trusted after :data:`ENOUGH` consistent observations in both directions, whose medians differ by no more
        than a factor of two.
        """
        here, there = self._seen(rises=rises), self._seen(rises=not rises)
        if min(len(here), len(there)) < ENOUGH:
            return None
        one, other = sorted((self._typical(rises=rises), self._typical(rises=not rises)))
        if other > 2 * one:
            return None
        slowest = max(each.delay for each in (*here, *there))
        changes = [each.change for each in here]
        return Expected(min(changes), max(changes), slowest, 3 * slowest + 2)

    def is_usual(self, observation: Observation) -> bool:
        """Return whether *observation* is an effect such as it saw before."""
        expected = self.expected(rises=observation.effect.rises)
        return expected is not None and expected.least / 2 <= observation.change <= 2 * expected.most

    def has_seen_as_hard(self, effect: Effect, before: float) -> bool:
        """Return whether it saw such effects where they were as hard to see, and missed none that was as easy.

        What it did while it moved by itself shows neither. The higher the reading before, and the smaller the effect,
        the harder it is to see.
        """
        typical = self._typical(rises=effect.rises)
        slack = typical / 8
        seen = self._seen(rises=effect.rises)
        calm = [one for one in self._kept[effect.rises] if one.swing <= typical / 4]
        alike = [one for one in calm if one.effect.looks == effect.looks]
        as_hard = [
            one
            for one in alike
            if one in seen and one.before >= before - slack and one.effect.size <= effect.size + _SIZE_SLACK
        ]
        missed = [
            one
            for one in alike
            if one not in seen and one.before <= before + slack and one.effect.size >= effect.size - _SIZE_SLACK
        ]
        return len(as_hard) >= ENOUGH and not missed

    def _seen(self, *, rises: bool) -> list[Observation]:
        """Return the consistent ones: each about the median, and far from how the sensor moves by itself."""
        typical = self._typical(rises=rises)
        return [
            one
            for one in self._kept[rises]
            if typical > 0 and typical / 2 <= one.change <= 2 * typical and one.swing <= typical / 4
        ]

    def _typical(self, *, rises: bool) -> float:
        """Return the median of the changes, the lower of two."""
        changes = sorted(one.change for one in self._kept[rises])
        return changes[(len(changes) - 1) // 2] if changes else 0.0
