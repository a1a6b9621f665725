"""Changes of settings in the house, and the raw commands that may explain them. Pure."""

from __future__ import annotations

from collections import OrderedDict, deque
from typing import Final, NamedTuple, TypeAlias, final

from homebot.devices.device import ChangedSetting
from homebot.devices.value import PlainValue

__all__ = ["HouseChanges", "RawWindow"]

_KEPT: Final = 10
"""Raw commands of one device, the newest."""

_HEARD_LATER: Final = 0.2
"""Seconds after the gateway that the journal may receive a raw command, in a loop that is busy."""

_MOST: Final = 100_000
_CALM: Final = 10.0
"""Seconds in which further numbers of one place are not noted: a dial that is turned, a blind on its way."""

_Place: TypeAlias = tuple[str, str, str]


class RawWindow(NamedTuple):
    """The time in which a raw command explains changes of its device.

    Attributes:
        id: The id of the command; empty for none.
        began: Seconds since the Unix epoch.
        until: Likewise.
        text: The command.
    """

    id: str = ""
    began: float = 0.0
    until: float = 0.0
    text: str = ""

    def says(self, value: PlainValue) -> bool:
        """Return whether the command is the usual text for *value*."""
        if isinstance(value, bool):
            return self.text == ("on" if value else "off")
        return isinstance(value, str) and self.text == value.casefold()


_NONE: Final = RawWindow()


@final
class HouseChanges:
    """The last values of what can be set, and the raw commands of a moment ago.

    The first value of each place is no change. At most 100,000 places and devices are kept; the longest unused are
    forgotten.
    """

    def __init__(self) -> None:
        self._raw: OrderedDict[str, deque[RawWindow]] = OrderedDict()
        self._values: OrderedDict[_Place, tuple[PlainValue, float]] = OrderedDict()

    def begin_raw(self, device: str, command: str, text: str, now: float, until: float) -> None:
        """Take changes of the device for effects of a raw command, from *now* on *until* then."""
        known = self._raw.setdefault(device, deque(maxlen=_KEPT))
        self._raw.move_to_end(device)
        known.append(RawWindow(command, now - _HEARD_LATER, until, text.strip().casefold()))
        if len(self._raw) > _MOST:
            self._raw.popitem(last=False)

    def record(self, change: ChangedSetting, at: float) -> RawWindow | None:
        """Record a live report.

        Returns:
            The raw command that may explain it, an empty one if there is none; None if it is no change.
        """
        place, value = (change.device, change.part, change.capability), change.value.plain()
        known = self._values.pop(place, None)
        self._values[place] = value, at
        if known is None:
            if len(self._values) > _MOST:
                self._values.popitem(last=False)
            return None
        if known[0] == value:
            return None
        if isinstance(value, float) and known[0] and value and at - known[1] < _CALM:
            return None
        raw = [one for one in self._raw.get(change.device, ()) if one.began <= at <= one.until]
        meant = [one for one in raw if one.says(value)] or raw
        return max(meant, key=lambda one: one.began, default=_NONE)
