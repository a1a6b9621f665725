"""Changes of devices, and the commands that explain them. Pure."""

from __future__ import annotations

from collections import OrderedDict, deque
from dataclasses import dataclass
from typing import Final, TypeAlias, final

from homebot.devices.device import ChangedSetting
from homebot.devices.value import PlainValue

__all__ = ["ExplainedChanges"]

EVERY_PART: Final = "*"
"""The part of a raw command, of which the part is not known."""

_KEPT: Final = 10
"""Commands of one part, the newest."""

_HEARD_LATER: Final = 0.2
"""Seconds after the gateway that the journal may hear of a raw command, in a loop that is busy."""

_LONGEST: Final = 900.0
"""Seconds after which a command is over at the latest."""

_MOST: Final = 100_000
_CALM: Final = 10.0
"""Seconds in which further numbers of one place are not noted: a dial that is turned, a blind on its way."""

_Place: TypeAlias = tuple[str, str, str]


@dataclass(slots=True)
class _Command:
    id: str
    began: float
    until: float
    is_raw: bool = False
    text: str = ""


@final
class ExplainedChanges:
    """The commands under way and of a moment ago, and the last values of what can be set.

    Of each place the first value that is heard is where it begins, and no change. At most 100,000 parts and places are
    kept; the longest unused are forgotten.
    """

    def __init__(self) -> None:
        self._commands: OrderedDict[tuple[str, str], deque[_Command]] = OrderedDict()
        self._values: OrderedDict[_Place, tuple[PlainValue, float]] = OrderedDict()

    def begin(self, device: str, part: str, command: str, now: float) -> None:
        """Take changes of the part for effects of *command* from *now* on."""
        self._put(device, part, _Command(command, now, now + _LONGEST))

    def end(self, device: str, part: str, command: str, until: float) -> None:
        """Take them so *until* then alone, as the outcome of *command* is known."""
        for one in reversed(self._commands.get((device, part), ())):
            if one.id == command:
                one.until = until
                break

    def begin_raw(self, device: str, command: str, text: str, now: float, until: float) -> None:
        """Take changes of any part of the device for effects of a raw command, from *now* on *until* then."""
        began, text = now - _HEARD_LATER, text.strip().casefold()
        self._put(device, EVERY_PART, _Command(command, began, until, is_raw=True, text=text))

    def take(self, change: ChangedSetting, at: float) -> str | None:
        """Take in a live report; return what it is.

        Returns:
            The id of the raw command that explains it; empty where nothing does; None where it is no change, or one
            that the entries of a command have already.
        """
        device, part = change.device, change.part
        place, value = (device, part, change.capability), change.value.plain()
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
        under_way = [
            one
            for place in ((device, part), (device, EVERY_PART))
            for one in self._commands.get(place, ())
            if one.began <= at <= one.until
        ]
        if not under_way:
            return ""
        meant = [one for one in under_way if one.is_raw and one.text == _word(value)] or under_way
        reason = max(meant, key=lambda one: one.began)
        return reason.id if reason.is_raw else None

    def _put(self, device: str, part: str, command: _Command) -> None:
        known = self._commands.get((device, part))
        if known is not None:
            self._commands.move_to_end((device, part))
        else:
            known = self._commands[device, part] = deque(maxlen=_KEPT)
            if len(self._commands) > _MOST:
                self._commands.popitem(last=False)
        known.append(command)


def _word(value: PlainValue) -> str:
    """Return the text command for *value* of most devices."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return value.casefold() if isinstance(value, str) else ""
