"""Resolution of one sensor: how finely it reports, by the changes that it reported. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Final, TypeAlias, final

__all__ = ["SensorResolution", "Step"]

Step: TypeAlias = tuple[float, float, float]
"""When a sensor reported a change, the value from which it began, and by how much it changed."""

_ENOUGH_STEPS: Final = 3
_STEPS_COUNT: Final = 259_200.0
"""Seconds for which a step tells how finely the sensor reports: 3 days, in which daylight comes and goes."""

_LEVELS_KEPT: Final = 16


@final
class SensorResolution:
    """The last 3 steps of each magnitude of the step and of the value from which it began, and the last 16 readings."""

    def __init__(self) -> None:
        self._steps: dict[tuple[int, int], deque[Step]] = {}
        self._levels: deque[float] = deque(maxlen=_LEVELS_KEPT)

    def note(self, value: float, at: float, before: float | None) -> None:
        """Take in a reading that differs from the one *before*; None where none is known."""
        self._levels.append(value)
        if before is not None:
            self._add(at, before, abs(value - before))

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps, oldest first."""
        return tuple(sorted(one for kept in self._steps.values() for one in kept))

    @property
    def levels(self) -> tuple[float, ...]:
        """The last readings, oldest first."""
        return tuple(self._levels)

    def restore(self, steps: Iterable[Step], levels: Iterable[float]) -> None:
        """Take over what an earlier run knew, as :attr:`steps` and :attr:`levels`; what is known now is kept."""
        now_known, self._steps = self.steps, {}
        for at, before, size in (*sorted(steps), *now_known):
            self._add(at, before, size)
        self._levels = deque((*levels, *self._levels), maxlen=_LEVELS_KEPT)

    def is_finer_than(self, step: float, level: float, now: float) -> bool:
        """Return whether it lately reported three changes of *step* or less, from values of *level* or more.

        A sensor that tells of great changes alone says nothing by its silence, and many take a share of the value.
        """
        steps = (one for kept in self._steps.values() for one in kept)
        found = sum(start >= level and size <= step and now - at <= _STEPS_COUNT for at, start, size in steps)
        return found >= _ENOUGH_STEPS

    def has_two_levels(self, apart: float) -> bool:
        """Return whether its last 16 readings were one of two values, about *apart*: it measures one thing alone."""
        values = self._levels
        if len(values) < _LEVELS_KEPT // 2:
            return False
        low, high, slack = min(values), max(values), apart / 8
        are_two = all(value - low <= slack or high - value <= slack for value in values)
        return are_two and abs(high - low - apart) <= 2 * slack

    def _add(self, at: float, before: float, size: float) -> None:
        key = (_magnitude(before), _magnitude(size))
        self._steps.setdefault(key, deque(maxlen=_ENOUGH_STEPS)).append((at, before, size))


def _magnitude(value: float) -> int:
    """Return the power of two at which *value* lies, -1 to 24."""
    return min(int(abs(value)).bit_length(), 24) if value >= 0 else -1
