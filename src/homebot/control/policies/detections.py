"""Motion sensors that have ever detected a person. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable
from typing import Final, final

from homebot.errors import WireError

__all__ = ["DETECTION", "Detections"]

DETECTION: Final = "detection"
"""The kind of the saved rows."""

_RECORD: Final = '{"version":1}'
_MOST: Final = 10_000
_DAY: Final = 86_400.0
"""Seconds after which a row is saved again: the store drops old rows."""


@final
class Detections:
    """The last 10,000 motion sensors that have detected a person; the others may be broken, or face a wall.

    Args:
        save: Saves a sensor over a restart: its name, and a record, empty to remove it; None for not.

    Attributes:
        forgotten: The number of sensors that were dropped because there were too many.
    """

    def __init__(self, save: Callable[[str, str], None] | None = None) -> None:
        self._save_row = save
        self._saved_at: OrderedDict[str, float] = OrderedDict()
        self.forgotten = 0

    def __contains__(self, sensor: str) -> bool:
        return sensor in self._saved_at

    def record(self, sensor: str, at: float) -> None:
        """Record that *sensor* detected a person at *at*, in seconds since the Unix epoch."""
        saved_at = self._saved_at.get(sensor)
        is_due = saved_at is None or abs(at - saved_at) >= _DAY
        self._put(sensor, at if saved_at is None or is_due else saved_at)
        if is_due:
            self._save(sensor, _RECORD)

    def forget(self, sensor: str) -> None:
        """Forget a sensor: another one may replace it."""
        if self._saved_at.pop(sensor, None) is not None:
            self._save(sensor, "")

    @property
    def sensors(self) -> tuple[str, ...]:
        """All of them, the next one to be dropped first."""
        return tuple(self._saved_at)

    def add(self, sensors: Iterable[str]) -> None:
        """Add *sensors* that detected a person in another run."""
        for sensor in sensors:
            if sensor not in self._saved_at:
                self._put(sensor, 0.0)

    def restore(self, name: str, record: str) -> None:
        """Add a sensor of an earlier run.

        Raises:
            WireError: The record is of another version.
        """
        if record != _RECORD:
            raise WireError("it is no detection of this version", record.encode())
        self.add((name,))

    def _put(self, sensor: str, saved_at: float) -> None:
        self._saved_at[sensor] = saved_at
        self._saved_at.move_to_end(sensor)
        if len(self._saved_at) > _MOST:
            forgotten, _ = self._saved_at.popitem(last=False)
            self.forgotten += 1
            self._save(forgotten, "")

    def _save(self, sensor: str, record: str) -> None:
        if self._save_row is not None:
            self._save_row(sensor, record)
