"""Fights: two apps that command the same part in turn, each against the other. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Final, NamedTuple, TypeAlias, final

from homebot.control.timeline.facts import PartRef
from homebot.devices.command_messages import Setting
from homebot.devices.journal_messages import DeviceFight
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import changes, related
from homebot.devices.wording.journal_words import settings_text
from homebot.messages import Time
from homebot.support.bounded_map import BoundedMap

_TURNS: Final = 4
_MAX_FIGHT_S: Final = 600.0
_MAX_REACTION_S: Final = 30.0
"""The longest gap between a command and a reaction to it, in seconds; two of the three gaps are this short."""

_SHOWN_S: Final = 3600.0
"""Seconds for which a fight is shown after its last command."""

_MAX_PARTS: Final = 1000
_Sensed: TypeAlias = tuple[str, str, str]


class Turn(NamedTuple):
    """A command of an app that had, or may have had, an effect.

    Attributes:
        at: When it was given, in seconds since the Unix epoch.
        values: The wanted values by capability.
        sensed: The values of another device to which the app responds, by device, part and capability.
    """

    at: float
    issuer: str
    values: Mapping[str, PlainValue]
    label: str
    sensed: Mapping[_Sensed, PlainValue] = MappingProxyType({})


def is_fight(turns: Sequence[Turn]) -> bool:
    """Return whether two apps alternated in the four *turns*, oldest first, each undoing the one before."""
    if len(turns) < _TURNS or turns[-1].at - turns[0].at > _MAX_FIGHT_S:
        return False
    first, second = turns[0].issuer, turns[1].issuer
    quick = sum(after.at - before.at <= _MAX_REACTION_S for before, after in pairwise(turns))
    return (
        quick >= _TURNS // 2
        and first != second
        and [turn.issuer for turn in turns] == [first, second] * 2
        and all(
            _opposes(before.values, after.values) and not _follows(before.sensed, after.sensed)
            for before, after in pairwise(turns)
        )
    )


def _follows(before: Mapping[_Sensed, PlainValue], after: Mapping[_Sensed, PlainValue]) -> bool:
    """Return whether both turns respond to one sensor that changed in between, as motion sensors often do."""
    return any(sensor in before and before[sensor] != value for sensor, value in after.items())


def _opposes(before: Mapping[str, PlainValue], after: Mapping[str, PlainValue]) -> bool:
    return any(
        other in after and changes(capability, value, other, after[other])
        for capability, value in before.items()
        for other in related(capability)
    )


@dataclass(frozen=True, slots=True)
class _Fight:
    """A fight; *last* are its newest turns."""

    began: float
    commands: int
    last: tuple[Turn, ...]


@final
class Fights:
    """The fights of the last hour over the 1,000 parts that apps commanded last."""

    def __init__(self) -> None:
        self._turns: BoundedMap[PartRef, tuple[Turn, ...]] = BoundedMap(_MAX_PARTS)
        self._fights: BoundedMap[PartRef, _Fight] = BoundedMap(_MAX_PARTS)

    def add(self, place: PartRef, turn: Turn) -> DeviceFight | None:
        """Record a command; return the fight if this command starts it."""
        before = self._turns.get(place, ())
        if before and before[-1].issuer == turn.issuer:
            before = before[:-1]
        turns = self._turns[place] = tuple(sorted((*before, turn), key=lambda one: one.at))[-_TURNS:]
        if not is_fight(turns):
            return None
        known, opponents = self._fights.get(place), {turn.issuer for turn in turns}
        if known and turn.at - known.last[-1].at <= _MAX_FIGHT_S and {turn.issuer for turn in known.last} == opponents:
            self._fights[place] = replace(known, commands=known.commands + 1, last=turns)
            return None
        fight = self._fights[place] = _Fight(turns[0].at, len(turns), turns)
        return _message(place, fight)

    def recent(self, now: float, device: str = "") -> tuple[DeviceFight, ...]:
        """Return the fights of the last hour over *device*, or over all."""
        return tuple(
            _message(place, fight)
            for place, fight in self._fights.items()
            if device in {"", place[0]} and abs(now - fight.last[-1].at) <= _SHOWN_S
        )


def _message(place: PartRef, fight: _Fight) -> DeviceFight:
    device, part = place
    first, other = (
        f"{turn.issuer.removeprefix('/')} ({settings_text(map(Setting.of, turn.values, turn.values.values()))})"
        for turn in fight.last[:2]
    )
    newest = fight.last[-1].at
    text = f"{first} and {other} fight over {fight.last[0].label}"
    return DeviceFight(
        device=device,
        part=part,
        issuers=tuple(turn.issuer for turn in fight.last[:2]),
        text=f"{text}: {fight.commands} commands in {max(1, round(newest - fight.began))} s",
        began=Time.from_seconds(fight.began),
        newest=Time.from_seconds(newest),
        commands=fight.commands,
    )
