"""Effects of routines on parts: whether one starts another, and whether two oppose each other. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from typing import Final

from homebot.devices.always_ask import always_asks
from homebot.devices.capabilities import LIGHTS_UP, acts_each_time
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.device import Device, State, target_of
from homebot.devices.query.facets import Facets, facets_of
from homebot.devices.query.matching import compares, fits
from homebot.devices.query.terms import StateIs
from homebot.devices.value import PlainValue, Value
from homebot.devices.value_comparison import changes, related
from homebot.words.conditions import Condition, exclude_each_other
from homebot.words.days import read_days
from homebot.words.times import DaysAndTime, read_time
from homebot.words.triggers import Becomes, Changes, PersonMoves, Press, Trigger

_NEAR: Final = 0.01


@dataclass(frozen=True)
class Effect:
    """The values that a step sets on a part.

    Attributes:
        text: The step.
        is_prompt: Whether it is set as soon as the routine starts, without a wait before.
        may_be: Whether it depends on the value before, as with ``toggle``.
    """

    text: str
    device: Device
    part: str
    settings: Mapping[str, PlainValue]
    is_prompt: bool
    may_be: bool = False

    @property
    def acts_each_time(self) -> bool:
        """True if to set it again may do more, or needs a person."""
        if self.may_be or acts_each_time(self.settings):
            return True
        part = self.device.part(self.part)
        return part is None or always_asks(self.device, part)

    def request(self, app: str) -> CommandRequest:
        """Return the command of *app* for it."""
        settings = tuple(map(Setting.of, self.settings, self.settings.values()))
        return CommandRequest(device=self.device.id, part=self.part, settings=settings, issuer=f"/{app}")

    def opposes(self, other: "Effect") -> bool:
        """Return whether both are for one part, and each would undo the other."""
        if (self.device.id, self.part) != (other.device.id, other.part) or self.may_be or other.may_be:
            return False
        pairs = product(self.settings.items(), other.settings.items())
        return any(
            second in related(first) and changes(first, value, second, wanted)
            for (first, value), (second, wanted) in pairs
        )

    def starts(self, trigger: Trigger) -> bool:
        """Return whether its device matches *trigger* afterwards, because of it."""
        capabilities, facets = self._afterwards
        if isinstance(trigger, Changes):
            is_meant = trigger.capability in {"", *capabilities}
            return self.may_be and is_meant and fits(trigger.query, facets)
        if not isinstance(trigger, Becomes) or trigger.is_none:
            return False
        return not trigger.capabilities.isdisjoint(capabilities) and fits(trigger.query, facets)

    @cached_property
    def _afterwards(self) -> tuple[frozenset[str], Facets]:
        """The capabilities that it changes, and the device with the values that it has then."""
        settings = dict(self.settings)
        if any(settings.get(one) for one in LIGHTS_UP):
            settings["on_off"] = True
        return frozenset(settings), facets_of(_with(self.device, self.part, settings))


@dataclass(frozen=True, slots=True)
class RoutineEffects:
    """A routine with all its effects."""

    name: str
    triggers: tuple[Trigger, ...]
    conditions: tuple[Condition, ...]
    effects: tuple[Effect, ...]

    def concerns(self, other: "RoutineEffects") -> bool:
        """Return whether it starts *other*, or may start when that does: only then may they loop or fight."""
        return any(map(self._starts, other.triggers)) or _may_meet(self, other)

    def _starts(self, trigger: Trigger) -> bool:
        return any(one.starts(trigger) for one in self.effects)


def loops(routines: Iterable[RoutineEffects]) -> Iterator[tuple[str, str]]:
    """Yield each routine that would start itself, also by way of others, with the problem in words."""
    known = {one.name: one for one in routines}
    ways = {name: _started_by(one, known.values()) for name, one in known.items()}
    for name in known:
        if (way := _way_back(name, ways)) is not None:
            steps = (f"{step!r} of {one} starts {after}" for one, step, after in way)
            yield name, f"it would start itself: {'; '.join(steps)}"


def fights(routines: Iterable[RoutineEffects]) -> Iterator[tuple[str, str]]:
    """Yield each routine that fights with another one: they set a part to opposite values, perhaps at once."""
    commanding: dict[tuple[str, str], dict[str, RoutineEffects]] = {}
    for routine in routines:
        for effect in routine.effects:
            commanding.setdefault((effect.device.id, effect.part), {})[routine.name] = routine
    pairs = {
        (one.name, other.name): (one, other)
        for same in commanding.values()
        for one, other in combinations(same.values(), 2)
    }
    for one, other in pairs.values():
        pair = next(_opposed(one, other), None)
        if pair is not None and _may_meet(one, other):
            mine, theirs = pair
            for name, step, by, against in ((one.name, *pair, other.name), (other.name, theirs, mine, one.name)):
                place = step.device.name or target_of(step.device.id, step.part)
                yield name, f"it fights with {against} over {place}: {step.text!r} here and {by.text!r} there"


def _opposed(one: RoutineEffects, other: RoutineEffects) -> Iterator[tuple[Effect, Effect]]:
    pairs = product(one.effects, other.effects)
    return ((mine, theirs) for mine, theirs in pairs if mine.is_prompt and theirs.is_prompt and mine.opposes(theirs))


def _started_by(one: RoutineEffects, others: Iterable[RoutineEffects]) -> dict[str, str]:
    """Return the steps of *one* that start routines, by their names."""
    found: dict[str, str] = {}
    for other in others:
        for effect in one.effects:
            if effect.may_be and other is one:
                continue  # the trigger asks for the value before
            if any(map(effect.starts, other.triggers)):
                found.setdefault(other.name, effect.text)
    return found


def _way_back(name: str, ways: Mapping[str, Mapping[str, str]]) -> tuple[tuple[str, str, str], ...] | None:
    """Return the shortest way from a routine back to itself, each part with its step; None if there is none."""
    reached: dict[str, tuple[tuple[str, str, str], ...]] = {name: ()}
    waiting = [name]
    for one in waiting:
        for after, step in ways[one].items():
            way = (*reached[one], (one, step, after))
            if after == name:
                return way
            if after not in reached:
                reached[after] = way
                waiting.append(after)
    return None


def _may_meet(one: RoutineEffects, other: RoutineEffects) -> bool:
    if any(exclude_each_other(*pair) for pair in product(one.conditions, other.conditions)):
        return False
    return any(_may_coincide(*pair) for pair in product(one.triggers, other.triggers))


def _may_coincide(one: Trigger, other: Trigger) -> bool:
    match one, other:
        case DaysAndTime(), DaysAndTime():
            return read_time(one.time) == read_time(other.time) and not read_days(one.days).excludes(
                read_days(other.days)
            )
        case Press(), Press():
            pairs = (one.value, other.value), (one.part, other.part)
            return one.query == other.query and all(not a or not b or a == b for a, b in pairs)
        case Becomes(), Becomes():
            return (one.lasting, one.is_none) == (other.lasting, other.is_none) and _may_both_hold(one, other)
        case PersonMoves(), PersonMoves():
            return (one.query, one.is_home, one.fact) == (other.query, other.is_home, other.fact)
        case _:
            return one == other


def _may_both_hold(one: Becomes, other: Becomes) -> bool:
    """Return whether the same values of one device may match both, as far as can be told from the texts."""
    return one.scope == other.scope and not any(
        a.capability == b.capability and not _share(a, b) for a, b in product(one.states, other.states)
    )


def _share(one: StateIs, other: StateIs) -> bool:
    """Return whether a value satisfies both terms."""
    values: list[PlainValue] = [one.value, other.value]
    values += [value + step for value in values if isinstance(value, float) for step in (-_NEAR, _NEAR)]
    values += [value is False for value in values if isinstance(value, bool)]
    return any(compares(one, value) and compares(other, value) for value in values)


def _with(device: Device, part: str, settings: Mapping[str, PlainValue]) -> Device:
    """Return *device* with other values of one part."""
    kept = tuple(one for one in device.states if one.part != part or one.capability not in settings)
    at = device.last_seen
    new = (
        State(part=part, capability=name, value=Value.of(value), since=at, told_at=at, live=True)
        for name, value in settings.items()
    )
    return device.model_copy(update={"states": (*kept, *new)})
