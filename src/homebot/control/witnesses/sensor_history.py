"""Latest readings of one sensor, and how finely it reports. Pure."""

from __future__ import annotations

from collections import deque
from typing import Final, final

__all__ = ["SensorHistory"]

_KEPT: Final = 512
_ENOUGH_STEPS: Final = 3
_STEPS_COUNT: Final = 259_200.0
"""Seconds for which a step tells how finely the sensor reports: 3 days, in which daylight comes and goes."""

_LEVELS_KEPT: Final = 16


@final
class SensorHistory:
    """The readings of one sensor that differ from the one before: the last 512; the oldest is forgotten.

    Of the steps between them the last 3 are kept for each magnitude of the step and of the value from which it began.

    Attributes:
        count: How many there were; a *mark* is this number at some time, as several things may happen at one time.
    """

    def __init__(self) -> None:
        self.count = 0
        self._readings: deque[tuple[int, float, float]] = deque(maxlen=_KEPT)
        self._steps: dict[tuple[int, int], deque[tuple[float, float, float]]] = {}

    @property
    def begins(self) -> float | None:
        """The time of the oldest reading; None where there is none."""
        return self._readings[0][1] if self._readings else None

    def note(self, value: float, at: float) -> None:
        """Take in a reading at *at*, in seconds of the monotonic clock, no earlier than the one before."""
        if self._readings:
            before = self._readings[-1][2]
            if value == before:
                return
            size = abs(value - before)
            key = (_magnitude(before), _magnitude(size))
            self._steps.setdefault(key, deque(maxlen=_ENOUGH_STEPS)).append((at, before, size))
        self.count += 1
        self._readings.append((self.count, at, value))

    def value_at(self, mark: int) -> float | None:
        """Return the reading that was the newest when :attr:`count` was *mark*; None where that is forgotten."""
        return next((value for number, _, value in self._readings if number == mark), None)

    def swing(self, since: float, mark: int) -> float | None:
        """Return the highest reading of the time from *since* until *mark* less the lowest.

        None where its beginning is forgotten.
        """
        told = [(at, value) for number, at, value in self._readings if number <= mark]
        if not told or told[0][0] > since:
            return None
        first = next(value for at, value in reversed(told) if at <= since)
        values = [first, *(value for at, value in told if at > since)]
        return max(values) - min(values)

    def change(self, mark: int, until: float, *, rises: bool) -> tuple[float, float] | None:
        """Return the greatest rise (or fall) from the reading at *mark*, and when it had come half way.

        Returns:
            The change, 0 where there was none, and a time no later than *until*; None where the reading at *mark* is
            forgotten.
        """
        before = self.value_at(mark)
        if before is None:
            return None
        sign = 1.0 if rises else -1.0
        changes = [
            (at, sign * (value - before)) for number, at, value in self._readings if number > mark and at <= until
        ]
        most = max((change for _, change in changes), default=0.0)
        if most <= 0:
            return 0.0, until
        return most, next(at for at, change in changes if change >= most / 2)

    def is_finer_than(self, step: float, level: float, now: float) -> bool:
        """Return whether it lately reported three changes of *step* or less, from values of *level* or more.

        A sensor that tells of great changes alone says nothing by its silence, and many take a share of the value.
        """
        steps = (one for kept in self._steps.values() for one in kept)
        found = sum(start >= level and size <= step and now - at <= _STEPS_COUNT for at, start, size in steps)
        return found >= _ENOUGH_STEPS

    def has_two_levels(self, apart: float) -> bool:
        """Return whether its last 16 readings were one of two values, about *apart*: it measures one thing alone."""
        values = [value for _, _, value in self._readings][-_LEVELS_KEPT:]
        if len(values) < _LEVELS_KEPT // 2:
            return False
        low, high, slack = min(values), max(values), apart / 8
        are_two = all(value - low <= slack or high - value <= slack for value in values)
        return are_two and abs(high - low - apart) <= 2 * slack


def _magnitude(value: float) -> int:
    """Return the power of two at which *value* lies, -1 to 24."""
    return min(int(abs(value)).bit_length(), 24) if value >= 0 else -1
