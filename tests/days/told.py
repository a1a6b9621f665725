"""What the sensors of a house said, and for how long it counts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from homebot.house.faults import Silent
from homebot.house.simulated_device import Placed
from homebot.testing.virtual_house import HEARTBEAT

RECONNECTED: Final = 60.0
"""Seconds after which all devices and homebot are back at a broker that is back."""

_NOTICED: Final = 120.0
"""Seconds after which a device that lost its link is known to be away, and by which silence may be noticed later."""

_STALE: Final = 3600.0
_STALE_ONLINE: Final = 86_400.0
"""Seconds of silence after which a device is stale: one that says when it is online is for a day longer trusted."""

_MARGIN: Final = 1.0
"""Seconds by which what was said at two sensors may come in another order."""


@dataclass(slots=True)
class Told:
    """What a motion sensor or a contact said.

    Attributes:
        at: When it last said something, of a contact when it last changed.
        word: What; empty for nothing yet.
        has_detected: Whether a motion sensor ever said ``motion``.
        has_opened: Whether a contact ever said ``open``.
        power_at: When its power last went or returned.
        motions: When each motion began and ended, of those that ended.
    """

    at: float
    word: str = ""
    has_detected: bool = False
    has_opened: bool = False
    power_at: float = 0.0
    motions: list[tuple[float, float]] = field(default_factory=list)
    _began: float = 0.0
    _said_at: float = -math.inf
    _before: tuple[str, float, bool] = ("", 0.0, False)

    def take(self, word: str, at: float) -> None:
        """Take in what the sensor says at *at*."""
        if at > self._said_at:
            self._said_at, self._before = at, (self.word, self.at, self.has_detected)
        if word == "motion" and self.word != "motion":
            self._began = at
        if word == "clear" and self.word == "motion":
            self.motions.append((self._began, at))
        if word != self.word or word in {"motion", "clear"}:
            self.at = at
        self.word = word
        self.has_detected = self.has_detected or word == "motion"
        self.has_opened = self.has_opened or word == "open"

    def clear_for(self, now: float) -> float:
        """Return for how many seconds it has said ``clear``; 0 where it has not, or never detected anybody before.

        What it says at this very moment is still on its way.
        """
        newest = self.word, self.at, self.has_detected
        word, at, has_detected = self._before if self._said_at == now else newest
        return now - at if word == "clear" and has_detected else 0.0

    def is_heard_again(self, now: float, away: Sequence[tuple[float, float]]) -> bool:
        """Return whether it surely has told how it is since a broker was back.

        Where the broker was away until about the time after which silence counts, what it has kept of the sensor is as
        good as nothing; the sensor says it again with its next heartbeat.

        Args:
            now: The time.
            away: When the broker went, and for how long.
        """
        return not any(
            lasted + HEARTBEAT >= _STALE and at <= now <= at + lasted + RECONNECTED + HEARTBEAT for at, lasted in away
        )

    def moved_since(self, closed: float, absent_after: float) -> bool:
        """Return whether it showed that somebody moved after all doors were closed at *closed*, and stayed.

        A motion began after that, or went on for *absent_after* longer, which no sensor holds it.
        """
        return any(began > closed + _MARGIN or ended > closed + absent_after + _MARGIN for began, ended in self.motions)

    def silence_known_from(self, placed: Placed, began: float) -> float:
        """Return when it must be known that nothing is heard of the sensor any more."""
        tells_link = _tells_link(placed)
        if not placed.device.has_power:
            return self.power_at + (_NOTICED if tells_link else _STALE + _NOTICED)
        return _silent_from(placed, began) + _NOTICED + (_STALE_ONLINE if tells_link else _STALE)

    def trusted_until(self, placed: Placed, began: float) -> float:
        """Return until when nobody can know that nothing is heard of the sensor any more.

        One that said live that it is online is trusted for a day. Most did so before homebot was there, and what the
        broker has kept does not count, so that nobody has to trust one for longer than an hour.
        """
        if not placed.device.has_power:
            return self.power_at if _tells_link(placed) else self.power_at - HEARTBEAT + _STALE
        return _silent_from(placed, began) - HEARTBEAT + _STALE


def _tells_link(placed: Placed) -> bool:
    return placed.dialect != "thesis"


def _silent_from(placed: Placed, began: float) -> float:
    """Return when a sensor with power said its last, counted from when homebot *began*; infinite if it still speaks."""
    device = placed.device
    return max(device.since, began) if isinstance(device, Silent) and device.now >= device.since else math.inf
