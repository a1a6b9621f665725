"""The commands that were sent lately, by how often they turned a value round. Pure."""

from __future__ import annotations

from bisect import bisect_right
from collections import OrderedDict, deque
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

from homebot.control.command import POWER, IssuedCommand
from homebot.control.held_values import POWERS, is_on
from homebot.devices.value import PlainValue

__all__ = ["RecentCommands"]

_MOST_TURNS: Final = 1000
_MOST: Final = 10_000

_Place: TypeAlias = tuple[str, str, str]


_Sending: TypeAlias = tuple[PlainValue, float]
"""What was sent, and when."""


@dataclass(slots=True)
class _Sent:
    """The last command for one place.

    Attributes:
        value: What it set.
        at: When it was last sent.
        command: Its id.
        turned_by: The id of the last command that changed the value.
        before: What was sent before that command.
        direction: As :func:`_direction` says, of the last change of a number.
        is_turn: Whether the last change was a turn.
        turns: When there were turns.
    """

    value: PlainValue
    at: float
    command: str
    turned_by: str
    before: _Sending | None = None
    direction: float = 0.0
    is_turn: bool = False
    turns: deque[float] = field(default_factory=lambda: deque(maxlen=_MOST_TURNS))


@final
class RecentCommands:
    """The turns of each capability of each part: at most 1,000 each, of at most 10,000; the longest unused go first.

    A turn is a command for another value than the one before. Of numbers it is one that goes down where the last went
    up, or up where it went down: to dim is no turn. To turn on and off is one, by whichever capability: level 0 is off.
    """

    def __init__(self) -> None:
        self._sent: OrderedDict[_Place, _Sent] = OrderedDict()

    def note(self, command: IssuedCommand, now: float) -> None:
        """Note that *command* is sent, or was, at *now*, in seconds of a clock that does not go back.

        A turn counts from when its command was last noted: the device may have got it only then.
        """
        for place, value in command.effects:
            sent = self._sent.get(place)
            if sent is None:
                self._sent[place] = _Sent(value, now, command.id, command.id)
                if len(self._sent) > _MOST:
                    self._sent.popitem(last=False)
                continue
            self._sent.move_to_end(place)
            is_same = value == sent.value
            is_undone = is_same and place[2] == POWER and _is_undone(sent, command, now)
            if sent.command != command.id:
                sent.before, sent.command = (sent.value, sent.at), command.id
            sent.at = now
            if is_same and not is_undone:
                if sent.is_turn and sent.turned_by == command.id:
                    sent.turns[-1] = now
                continue
            direction = _direction(sent, value)
            sent.is_turn = is_undone or not direction or direction * sent.direction < 0
            if sent.is_turn:
                sent.turns.append(now)
            sent.direction = direction or sent.direction
            sent.value, sent.turned_by = value, command.id

    def last(self, command: IssuedCommand, capability: str) -> _Sending | None:
        """Return to what *capability* of the part was set last, and when, by another command than *command*."""
        sent = self._sent.get((*command.place, capability))
        if sent is None:
            return None
        return sent.before if sent.command == command.id else (sent.value, sent.at)

    def turns(self, command: IssuedCommand, now: float, seconds: float) -> int:
        """Return how often the values that *command* would turn were turned within *seconds*; 0 if it turns none."""
        most = 0
        for place, value in command.effects:
            sent = self._sent.get(place)
            if sent is None or not sent.turns:
                continue
            if _turns(sent, value) or (place[2] == POWER and _is_undone(sent, command, now)):
                most = max(most, len(sent.turns) - bisect_right(sent.turns, now - seconds))
        return most


def _is_undone(sent: _Sent, command: IssuedCommand, now: float) -> bool:
    """Return whether the part reported after another command turned it on that it is off, or the other way round.

    *sent* is the other command.
    """
    if sent.command == command.id:
        return False
    state = None
    for one in command.device.states:
        if one.part == command.part.id and one.capability in POWERS and (state is None or one.capability == "on_off"):
            state = one
    if state is None or command.issued_at - state.told_at.to_seconds() >= now - sent.at:
        return False
    return is_on(state.value.plain()) is not sent.value


def _turns(sent: _Sent, value: PlainValue) -> bool:
    if value == sent.value:
        return False
    direction = _direction(sent, value)
    return not direction or direction * sent.direction < 0


def _direction(sent: _Sent, value: PlainValue) -> float:
    """Return above 0 for a number that grows, below 0 for one that shrinks, 0 for everything else."""
    if isinstance(value, float) and isinstance(sent.value, float):
        return value - sent.value
    return 0.0
