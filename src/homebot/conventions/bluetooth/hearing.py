"""The strengths with which several receivers hear one device, and the room that these suggest. Pure.

The model is that of :mod:`homebot.conventions.bluetooth.signal`: walls scatter the loss of each path by 8 dB, so that
the difference of two paths has a deviation of 8 √2. A receiver that does not hear the device counts as one at the limit
of its sensitivity.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import erf
from typing import Final

from homebot.conventions.bluetooth.signal import SCATTER, SignalFilter
from homebot.support.bounded_map import BoundedMap

MAX_RECEIVERS: Final = 32
"""Of one device; the one that heard it longest ago is left out."""

_UNHEARD: Final = -100.0
"""dBm of a receiver that does not hear a device."""

_STEPS: Final = 10


@dataclass(frozen=True, slots=True)
class RoomGuess:
    """A room that is suggested for a device.

    Attributes:
        certainty: The probability that it is the one of the rooms with receivers that the device is nearest to, in
            steps of a tenth.
    """

    room: str
    certainty: float


class Hearing:
    """The signal strengths of one device by receiver."""

    def __init__(self) -> None:
        self._signals: BoundedMap[str, SignalFilter] = BoundedMap(MAX_RECEIVERS)

    def add(self, receiver: str, rssi: int, now: float) -> None:
        """Add a signal strength in dBm, with which *receiver* heard the device."""
        signal = self._signals[receiver] = self._signals.get(receiver) or SignalFilter()
        signal.add(rssi, now)

    def strongest(self, now: float) -> tuple[str, float] | None:
        """Return the receiver that hears it best, and how strongly, in dBm; None if none did lately."""
        return max(self._heard(now).items(), key=lambda heard: heard[1], default=None)

    def room(self, now: float, rooms: Mapping[str, str]) -> RoomGuess | None:
        """Return the room of the receiver that hears it best; None if no other room has a receiver, or none hears it.

        Args:
            rooms: The room of each receiver that listens now.
        """
        heard = self._heard(now)
        best = dict.fromkeys(rooms.values(), _UNHEARD)
        for receiver, room in rooms.items():
            best[room] = max(best[room], heard.get(receiver, _UNHEARD))
        ranked = sorted(best, key=best.__getitem__, reverse=True)
        if len(ranked) < 2 or best[ranked[0]] <= _UNHEARD:
            return None
        certainty = 1.0
        for other in ranked[1:]:
            certainty *= (1 + erf((best[ranked[0]] - best[other]) / (2 * SCATTER))) / 2
        return RoomGuess(ranked[0], round(certainty * _STEPS) / _STEPS)

    def _heard(self, now: float) -> dict[str, float]:
        values = {receiver: signal.value(now) for receiver, signal in self._signals.items()}
        return {receiver: value for receiver, value in values.items() if value is not None}
