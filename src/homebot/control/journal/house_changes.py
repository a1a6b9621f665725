"""Changes of settings in the house, and the raw commands that may explain them. Pure."""

from __future__ import annotations

from collections import OrderedDict, deque
from typing import Final, NamedTuple, TypeAlias, final

from homebot.devices.device import ChangedSetting
from homebot.devices.value import PlainValue

__all__ = ["HouseChanges", "RawWindow"]

_MOST_COMMANDS: Final = 10
"""The newest raw commands of one device."""

_DELAY: Final = 0.2
"""Seconds after the gateway within which the journal receives a raw command in a busy loop."""

_MOST: Final = 100_000
_CALM: Final = 10.0
"""Seconds in which further numbers of one place are not recorded: a dial that is turned, a blind on its way."""

_Place: TypeAlias = tuple[str, str, str]


class RawWindow(NamedTuple):
    """The time in which a raw command explains changes of its device, in seconds since the Unix epoch.

    Attributes:
        id: The id of the command; empty for none.
        began: The begin.
        until: The end.
        text: The command.
    """

    id: str = ""
    began: float = 0.0
    until: float = 0.0
    text: str = ""

    def means(self, value: PlainValue) -> bool:
        """Return whether the command is the usual text for *value*."""
        if isinstance(value, bool):
            return self.text == ("on" if value else "off")
        return isinstance(value, str) and self.text == value.casefold()


_NONE: Final = RawWindow()


@final
class HouseChanges:
    """The last values of settings, and recent raw commands.

    The first value of each place is no change. At most 100,000 places and devices are stored; the longest unused are
    dropped.
    """

    def __init__(self) -> None:
        self._raw: OrderedDict[str, deque[RawWindow]] = OrderedDict()
        self._values: OrderedDict[_Place, tuple[PlainValue, float]] = OrderedDict()

    def begin_raw(self, device: str, command: str, text: str, now: float, until: float) -> None:
        """Add a raw command that explains changes of the device from *now* to *until*."""
        known = self._raw.setdefault(device, deque(maxlen=_MOST_COMMANDS))
        self._raw.move_to_end(device)
        known.append(RawWindow(command, now - _DELAY, until, text.strip().casefold()))
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
        if known is None and len(self._values) > _MOST:
            self._values.popitem(last=False)
        if known is None or not _is_change(known, value, at):
            return None
        raw = [one for one in self._raw.get(change.device, ()) if one.began <= at <= one.until]
        meant = [one for one in raw if one.means(value)] or raw
        return max(meant, key=lambda one: one.began, default=_NONE)


def _is_change(known: tuple[PlainValue, float], value: PlainValue, at: float) -> bool:
    before, before_at = known
    is_dial = isinstance(value, float) and before and value and at - before_at < _CALM
    return before != value and not is_dial
