"""Latest readings of one sensor. Pure."""

from __future__ import annotations

from collections import deque
from typing import Final, final

from homebot.control.witnesses.sensor_resolution import SensorResolution

__all__ = ["SensorHistory"]

_KEPT: Final = 512


@final
class SensorHistory:
    """The readings of one sensor that differ from the one before: the last 512; the oldest is forgotten.

    Attributes:
        resolution: How finely it reports.
        count: How many there were; a *mark* is this number at some time, as several things may happen at one time.
    """

    def __init__(self) -> None:
        self.count = 0
        self._readings: deque[tuple[int, float, float]] = deque(maxlen=_KEPT)
        self.resolution = SensorResolution()

    @property
    def begins(self) -> float | None:
        """The time of the oldest reading; None where there is none."""
        return self._readings[0][1] if self._readings else None

    def note(self, value: float, at: float) -> None:
        """Take in a reading at *at*, in seconds of the monotonic clock, no earlier than the one before."""
        before = self._readings[-1][2] if self._readings else None
        if value == before:
            return
        self.resolution.note(value, at, before)
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
