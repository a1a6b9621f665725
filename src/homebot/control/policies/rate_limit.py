"""Rate limit: no value is switched back and forth endlessly. Pure."""

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

from pydantic import Field

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, PolicyTable, Verdict
from homebot.devices.obedience import POWERS
from homebot.devices.value import PlainValue
from homebot.support.bounded_map import BoundedMap
from homebot.units import Seconds

__all__ = ["RateLimitSettings", "TurnCounter"]

NAME: Final = "rate_limit"

_WITHIN: Final = Verdict(NAME, allowed=True)
_MOST_TURNS: Final = 1000
_MOST: Final = 10_000

_POWER: Final = "power_state"
"""Name for the power of a part, whichever capability switches it."""

_Place: TypeAlias = tuple[str, str, str]


class RateLimitSettings(PolicyTable):
    """The table ``[control.rate_limit]``.

    Attributes:
        changes: How many turns of a value are allowed within *seconds*.
    """

    changes: int = Field(default=30, ge=1, le=1000)
    seconds: Seconds = 10.0

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Refuse a command that turns a value more often than allowed."""
        turns = facts.turns(command, facts.monotonic, self.seconds)
        if turns < self.changes:
            return _WITHIN
        used = FactUsed(f"changes of {command.target} in {self.seconds:g} s", float(turns))
        reason = f"{command.label} was switched back and forth {turns} times within {self.seconds:g} s"
        return Verdict(NAME, allowed=False, reason=reason, facts=(used,))


@dataclass(slots=True)
class _Sent:
    """The last command for one place.

    Attributes:
        turned_by: The id of the last command whose value differed from the one before.
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
    """Times at which each capability of each part turned: up to 1,000 for each of the last 10,000 capabilities.

    A turn is a command whose value differs from the one before; a number must also change direction, so dimming is not
    a turn. On and off are one value, whichever capability commands them: level 0 is off.
    """

    def __init__(self) -> None:
        self._sent: BoundedMap[_Place, _Sent] = BoundedMap(_MOST)

    def record(self, command: IssuedCommand, now: float) -> None:
        """Record that *command* is sent, or was, at *now* on the monotonic clock.

        A turn counts from the last recording of its command: the device may not have received it before.
        """
        for place, value in _effects(command):
            sent = self._sent.get(place)
            if sent is None:
                self._sent[place] = _Sent(value, now, command.id, command.id)
            else:
                self._sent.move_to_end(place)
                _record(sent, place, value, command, now)

    def count(self, command: IssuedCommand, now: float, seconds: float) -> int:
        """Return how often the values that *command* turns did so within *seconds*; 0 if it turns none."""
        most = 0
        for place, value in _effects(command):
            sent = self._sent.get(place)
            if sent is None or not sent.turns:
                continue
            if _turn(sent, value)[0] or (place[2] == _POWER and _is_undone(sent, command, now)):
                most = max(most, len(sent.turns) - bisect_right(sent.turns, now - seconds))
        return most


def _effects(command: IssuedCommand) -> list[tuple[_Place, PlainValue]]:
    """Return the place and the value of each setting; for a power :data:`_POWER`, with True for on."""
    device, part = command.place
    effects: list[tuple[_Place, PlainValue]] = []
    for capability, value in command.settings.items():
        if capability in POWERS:
            effects.append(((device, part, _POWER), bool(value)))
        if capability != "on_off":
            effects.append(((device, part, capability), value))
    return effects


def _record(sent: _Sent, place: _Place, value: PlainValue, command: IssuedCommand, now: float) -> None:
    is_same = value == sent.value
    is_undone = is_same and place[2] == _POWER and _is_undone(sent, command, now)
    sent.command, sent.at = command.id, now
    if is_same and not is_undone:
        if sent.is_turn and sent.turned_by == command.id:
            sent.turns[-1] = now
        return
    is_turn, direction = _turn(sent, value)
    sent.is_turn = is_undone or is_turn
    if sent.is_turn:
        sent.turns.append(now)
    sent.direction = direction or sent.direction
    sent.value, sent.turned_by = value, command.id


def _is_undone(sent: _Sent, command: IssuedCommand, now: float) -> bool:
    """Return whether the part reported the opposite power after another command, *sent*, switched it."""
    if sent.command == command.id:
        return False
    states = command.states
    state = states.get("on_off") or states.get("level") or states.get("fan_speed")
    if state is None:
        return False
    is_older = command.issued_at - state.told_at.to_seconds() >= now - sent.at
    return not is_older and bool(state.value.plain()) is not sent.value


def _turn(sent: _Sent, value: PlainValue) -> tuple[bool, float]:
    """Return whether *value* is a turn, and its direction: above 0 for a number that grows, else 0."""
    before, direction = sent.value, 0.0
    if isinstance(value, float) and isinstance(before, float):
        direction = value - before
    return value != before and (not direction or direction * sent.direction < 0), direction
