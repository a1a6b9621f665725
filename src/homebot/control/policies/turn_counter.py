"""Counter of the turns of values: commands that switch a part to and fro. Pure."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.values import POWERS, is_on
from homebot.devices.value import PlainValue
from homebot.support.bounded_map import BoundedMap

__all__ = ["TurnCounter"]

_MOST_TURNS: Final = 1000
_MOST: Final = 10_000

_POWER: Final = "power_state"
"""Name for the power of a part, by whichever capability it is switched."""

_Place: TypeAlias = tuple[str, str, str]


@dataclass(slots=True)
class _Sent:
    """The last command for one place.

    Attributes:
        value: The commanded value.
        at: The time of its last sending.
        command: Its id.
        turned_by: The id of the last command for another value than the one before.
        direction: The last change of a number.
        is_turn: Whether the last change was a turn.
        turns: The times of the turns.
    """

    value: PlainValue
    at: float
    command: str
    turned_by: str
    direction: float = 0.0
    is_turn: bool = False
    turns: deque[float] = field(default_factory=lambda: deque(maxlen=_MOST_TURNS))


@final
class TurnCounter:
    """Times at which each capability of each part turned: at most 1,000 each, of the last 10,000 capabilities.

    A turn is a command for another value than the one before; of numbers one that changes direction, as to dim is no
    turn. On and off are one value, by whichever capability they are commanded: level 0 is off.
    """

    def __init__(self) -> None:
        self._sent: BoundedMap[_Place, _Sent] = BoundedMap(_MOST)

    def record(self, command: IssuedCommand, now: float) -> None:
        """Record that *command* is sent, or was, at *now* on the monotonic clock.

        A turn counts from the last recording of its command: the device may have received it only then.
        """
        for place, value in _effects(command):
            sent = self._sent.get(place)
            if sent is None:
                self._sent[place] = _Sent(value, now, command.id, command.id)
            else:
                self._sent.move_to_end(place)
                _record(sent, place, value, command, now)

    def count(self, command: IssuedCommand, now: float, seconds: float) -> int:
        """Return how often the values that *command* turns turned within *seconds*; 0 if it turns none."""
        most = 0
        for place, value in _effects(command):
            sent = self._sent.get(place)
            if sent is None or not sent.turns:
                continue
            if _is_turn(sent, value) or (place[2] == _POWER and _is_undone(sent, command, now)):
                most = max(most, len(sent.turns) - bisect_right(sent.turns, now - seconds))
        return most


def _effects(command: IssuedCommand) -> Iterator[tuple[_Place, PlainValue]]:
    """Yield the place and the value of each setting; for a power :data:`_POWER`, with True for on."""
    device, part = command.place
    for capability, value in command.settings.items():
        if capability in POWERS:
            yield (device, part, _POWER), is_on(value)
        if capability != "on_off":
            yield (device, part, capability), value


def _record(sent: _Sent, place: _Place, value: PlainValue, command: IssuedCommand, now: float) -> None:
    is_same = value == sent.value
    is_undone = is_same and place[2] == _POWER and _is_undone(sent, command, now)
    sent.command, sent.at = command.id, now
    if is_same and not is_undone:
        if sent.is_turn and sent.turned_by == command.id:
            sent.turns[-1] = now
        return
    sent.is_turn = is_undone or _is_turn(sent, value)
    if sent.is_turn:
        sent.turns.append(now)
    sent.direction = _direction(sent, value) or sent.direction
    sent.value, sent.turned_by = value, command.id


def _is_undone(sent: _Sent, command: IssuedCommand, now: float) -> bool:
    """Return whether the part reported the opposite power after another command, *sent*, switched it."""
    if sent.command == command.id:
        return False
    states = [one for one in command.device.states if one.part == command.part.id and one.capability in POWERS]
    if not states:
        return False
    state = next((one for one in states if one.capability == "on_off"), states[0])
    is_older = command.issued_at - state.told_at.to_seconds() >= now - sent.at
    return not is_older and is_on(state.value.plain()) is not sent.value


def _is_turn(sent: _Sent, value: PlainValue) -> bool:
    direction = _direction(sent, value)
    return value != sent.value and (not direction or direction * sent.direction < 0)


def _direction(sent: _Sent, value: PlainValue) -> float:
    """Return above 0 for a number that grows, below 0 for one that shrinks, 0 for any other value."""
    if isinstance(value, float) and isinstance(sent.value, float):
        return value - sent.value
    return 0.0
