"""Changes of devices that no command explains: a hand at a switch. Pure."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias, final

from homebot.control.command import POWER, IssuedCommand
from homebot.control.policies.verdict import FactUsed
from homebot.control.tolerance import fits, is_intermediate
from homebot.devices.value import PlainValue

__all__ = ["Hands"]

_MOST: Final = 10_000
_KEPT: Final = 32
"""Commands for one place, the newest."""

_EFFECT: Final = 60.0
"""Seconds after a command in which changes of its part are taken for its effect."""

_LATE: Final = -2.0
"""The same for changes before: a device may report what it did before its network says that it has the command."""

_BOUNCE: Final = 3.0
"""Seconds after a device obeyed in which a bridge may tell its state before once more, and then that it obeyed."""

_Place: TypeAlias = tuple[str, str, str]


@dataclass(slots=True)
class _Reason:
    """A command that may explain changes of one place.

    Attributes:
        command: Its id.
        value: What it set.
        first_at: When it was first sent.
        last_at: When it was last sent.
        obeyed_at: When it was known that the device obeyed; None where it is not.
    """

    command: str
    value: PlainValue
    first_at: float
    last_at: float
    obeyed_at: float | None = None

    def may_be_why(self, at: float) -> bool:
        """Return whether a change at *at* may be its effect, by the time alone."""
        return at - self.first_at >= _LATE and at - self.last_at <= _EFFECT

    def explains(self, capability: str, value: PlainValue, at: float) -> bool:
        """Return whether that *capability* became *value* at *at* is its effect, rather than that of a hand.

        A device that obeyed, and becomes so once more, was otherwise in between. Numbers come nearer in steps.
        """
        if self.obeyed_at is not None and at - self.obeyed_at > _BOUNCE and not isinstance(value, float):
            return False
        return fits(capability, self.value, value) or is_intermediate(capability, self.value, value)


@final
class Hands:
    """Commands that explain changes, and changes that none explained: the newest of each part.

    At most 32 commands of each of 10,000 places, and a change of each of 10,000 parts; the longest unused go first.
    """

    def __init__(self) -> None:
        self._sent: OrderedDict[_Place, deque[_Reason]] = OrderedDict()
        self._seen: OrderedDict[tuple[str, str], FactUsed] = OrderedDict()

    def knows(self, command: IssuedCommand) -> bool:
        """Return whether *command* was noted before."""
        return any(one.command == command.id for place in command.places for one in self._sent.get(place, ()))

    def note(self, command: IssuedCommand, now: float) -> None:
        """Note that *command* is sent, or was, at *now*, in seconds of a clock that does not go back."""
        for place, value in command.effects:
            sent = self._sent.setdefault(place, deque(maxlen=_KEPT))
            self._sent.move_to_end(place)
            if sent and sent[-1].command == command.id:
                sent[-1].last_at = now
            else:
                sent.append(_Reason(command.id, value, now, now))
            if len(self._sent) > _MOST:
                self._sent.popitem(last=False)

    def note_obeyed(self, command: IssuedCommand, now: float) -> None:
        """Note that the device is known at *now* to have obeyed *command*."""
        for place, _ in command.effects:
            for one in self._sent.get(place, ()):
                if one.command == command.id:
                    one.obeyed_at = now

    def explain(
        self, part: tuple[str, str], settable: Iterable[str], capability: str, value: PlainValue, at: float
    ) -> bool:
        """Return whether a command explains that *capability* of *part* changed to *value* at *at*.

        One that was sent to it within the minute before does, unless it set that capability to another value, or the
        device had obeyed it long before.
        """
        own = max(self._reasons(part, capability, at), key=lambda one: one.first_at, default=None)
        if own is not None:
            return own.explains(capability, value, at)
        return any(True for name in settable for _ in self._reasons(part, name, at))

    def remember(self, part: tuple[str, str], change: FactUsed) -> None:
        """Keep *change*, which nothing explains, as a newer command is about to hide it."""
        self._seen[part] = change
        self._seen.move_to_end(part)
        if len(self._seen) > _MOST:
            self._seen.popitem(last=False)

    def remembered(self, part: tuple[str, str]) -> FactUsed | None:
        """Return the newest change of *part* that a command has hidden since; None where there is none."""
        return self._seen.get(part)

    def _reasons(self, part: tuple[str, str], capability: str, at: float) -> Iterator[_Reason]:
        for name in ("on_off", POWER) if capability == "on_off" else (capability,):
            for one in self._sent.get((*part, name), ()):
                if one.may_be_why(at):
                    yield one
