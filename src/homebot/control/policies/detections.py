"""The motion sensors that have ever detected somebody. Pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from typing import Final, final

from homebot.control.learnt_record import KeepLearnt, LearntRecord

__all__ = ["DETECTION", "Detections"]

DETECTION: Final = "detection"
"""The kind of the rows that are kept over a restart."""

_MOST: Final = 10_000
_DAY: Final = 86_400.0
"""Seconds after which a row is kept anew: one that is not is dropped with the journal's old entries."""


class _KeptDetection(LearntRecord):
    title = "detection"

    sensor: str

    @property
    def kept_as(self) -> str:
        return self.sensor


@final
class Detections:
    """The sensors that have detected somebody: at most 10,000; the one that did so longest ago is forgotten first.

    One that never has may be broken, or look at a wall, and that it detects nobody says nothing.

    Args:
        keep: Keeps them over a restart; None for not at all.

    Attributes:
        forgotten: How many were forgotten because they were too many.
    """

    def __init__(self, keep: KeepLearnt | None = None) -> None:
        self._keep = keep
        self._kept_at: OrderedDict[str, float] = OrderedDict()
        self.forgotten = 0

    def __contains__(self, sensor: str) -> bool:
        return sensor in self._kept_at

    def note(self, sensor: str, at: float) -> None:
        """Note that *sensor* detected somebody at *at*, in seconds since the Unix epoch."""
        kept_at = self._kept_at.get(sensor)
        is_due = kept_at is None or abs(at - kept_at) >= _DAY
        self._put(sensor, at if kept_at is None or is_due else kept_at)
        if is_due:
            self._save(sensor, _KeptDetection(sensor=sensor).model_dump_json())

    def forget(self, sensor: str) -> None:
        """Forget a sensor: another one may come in its place."""
        if self._kept_at.pop(sensor, None) is not None:
            self._save(sensor, "")

    @property
    def sensors(self) -> tuple[str, ...]:
        """All of them, the one that is forgotten next first."""
        return tuple(self._kept_at)

    def take_over(self, sensors: Iterable[str]) -> None:
        """Take over *sensors*, which detected somebody in another run."""
        for sensor in sensors:
            if sensor not in self._kept_at:
                self._put(sensor, 0.0)

    def restore(self, name: str, record: str) -> None:
        """Take over a sensor that detected somebody in an earlier run.

        Args:
            name: The sensor.
            record: What was kept of it.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        self.take_over((_KeptDetection.read(name, record).sensor,))

    def _put(self, sensor: str, kept_at: float) -> None:
        self._kept_at[sensor] = kept_at
        self._kept_at.move_to_end(sensor)
        if len(self._kept_at) > _MOST:
            forgotten, _ = self._kept_at.popitem(last=False)
            self.forgotten += 1
            self._save(forgotten, "")

    def _save(self, sensor: str, record: str) -> None:
        if self._keep is not None:
            self._keep(sensor, record, "")
