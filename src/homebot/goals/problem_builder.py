"""The problem of a goal: each relevant door, part and robot by itself, as planners like it. Pure.

Lifted to variables, the planner would need ten seconds for fifty rooms; so, 0.2 s.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final, TypeAlias, final

from homebot.command_words.suitable_parts import part_name
from homebot.devices import Device, DevicePart
from homebot.devices.always_ask import why_it_asks
from homebot.devices.capabilities import LIGHTS_UP
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.obedience import END_POSITIONS
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import StateIs, leaves
from homebot.devices.value import PlainValue
from homebot.devices.wording.values import value_text
from homebot.errors import UsageError
from homebot.goals.house_now import HouseNow, with_values
from homebot.goals.operators import CommandStep, DriveStep, GoalProblem, Operator
from homebot.goals.wishes import RobotWish, StateWish, Wish
from homebot.places.plan import OUTSIDE
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.devices.outcomes import Refused
    from homebot.devices.places_messages import DoorInfo

__all__ = ["Blocked", "Preview", "build_problem"]

Preview: TypeAlias = Callable[[CommandRequest, Device, DevicePart], "Refused | None"]
"""Returns the refusal of a command by rights and policies, if it were given now."""

Blocked: TypeAlias = Mapping[tuple[str, str], str]
"""Why a part cannot get a value, by its place and the text of the step."""

_Facts: TypeAlias = list[tuple[str, Callable[[Device], bool]]]
"""Facts of a device, each with its test."""

_DEEDS: Final[Mapping[str, Mapping[PlainValue, str]]] = {
    "on_off": {True: "turn on {}", False: "turn off {}"},
    "lock": {"unlocked": "unlock {}", "locked": "lock {}"},
    "movement": {"open": "open {}", "closed": "close {}"},
    "valve": {"open": "open {}", "closed": "close {}"},
    "position": {100.0: "open {}", 0.0: "close {}"},
}
"""The deeds by capability and value; other capabilities are set to the wished value."""


_OPENINGS: Final = frozenset({"movement", "position"})


def build_problem(
    wishes: Iterable[Wish], house: HouseNow, issuer: str, scope: tuple[str, ...], preview: Preview, blocked: Blocked
) -> GoalProblem:
    """Return the problem.

    Raises:
        UsageError: Nothing fits a wish.
    """
    builder = _Builder(house, issuer, scope, preview, blocked)
    wished = tuple(wishes)
    for one in wished:
        if isinstance(one, StateWish):
            builder.add_state(one)
    drives = [one for one in wished if isinstance(one, RobotWish)]
    if drives:
        for door in house.doors:
            builder.add_door(door)
    builder.add_commands()
    for drive in drives:
        builder.add_drive(drive)
    return builder.problem


@final
class _Builder:
    def __init__(
        self, house: HouseNow, issuer: str, scope: tuple[str, ...], preview: Preview, blocked: Blocked
    ) -> None:
        self.problem = GoalProblem()
        self._house, self._issuer, self._scope = house, issuer, scope
        self._preview, self._blocked = preview, blocked
        self._facts: dict[str, _Facts] = {}
        self._devices: dict[str, Device] = {}
        self._wished: dict[tuple[str, str], list[StateIs]] = {}
        self._follows: dict[str, str] = {}
        self._unlocked: dict[str, str] = {}
        self._closed: dict[str, str] = {}

    def add_state(self, wish: StateWish) -> None:
        """Add the facts that the wish is about."""
        found = list(_parts_of(wish, self._house.devices))
        if not found:
            names = [one.name for one in self._house.devices]
            hint = did_you_mean(wish.name, names, "`homebot find` shows what there is")
            raise UsageError(f"{wish.text}: nothing in the house fits; {hint}")
        states = [one for one in leaves(wish.query) if isinstance(one, StateIs) and one.operator in {"=", ">=", "<="}]
        for device, part in found:
            name, place = part_name(device, part), part.id
            fact = f"{name}: {wish.text}"
            self._wished.setdefault((device.id, place), []).extend(states)

            def test(one: Device, place: str = place) -> bool:
                known = one.part(place)
                return known is not None and fits(wish.query, PartFacets(one, known))

            self._track(device, fact, test, f"{name} is {_told(device, part, states)}")
            if wish.any_of:
                self._follows[fact] = wish.text
                self.problem.operators.append(Operator(frozenset((fact,)), frozenset((wish.text,))))
            else:
                self.problem.goal[fact] = None
        if wish.any_of:
            self.problem.goal[wish.text] = None
            self.problem.contrary[wish.text] = f"not {wish.text}"
            if any(f"{part_name(*one)}: {wish.text}" in self.problem.facts for one in found):
                self.problem.facts.add(wish.text)

    def add_door(self, door: DoorInfo) -> None:
        """Add the facts of a door whose devices tell its state."""
        contact, lock = self._house.called(door.contact), self._house.called(door.lock)
        if contact is not None and (_is_open(contact) is not None or _can_open(contact)):
            self._track(
                contact, f"{door.name} is open", lambda one: _is_open(one) is not False, f"{door.name} is closed"
            )
            self._track(contact, f"{door.name} is closed", lambda one: _is_open(one) is False, f"{door.name} is open")
        if lock is not None:
            fact = f"{door.name} is unlocked"
            self._track(lock, fact, lambda one: _value(one, "lock") != "locked", f"{door.name} is locked")
            for one in {lock.id, contact.id if contact else lock.id}:
                self._unlocked[one] = fact
            if contact is not None:
                self._closed[lock.id] = f"{door.name} is closed"

    def add_commands(self) -> None:
        """Add the commands to the devices of all facts."""
        for device in self._devices.values():
            for part in device.parts:
                self.problem.operators += self._commands(device, part)

    def add_drive(self, wish: RobotWish) -> None:
        """Add the ways of a robot."""
        robot, room = wish.robot, self._house.robots[wish.robot]
        self.problem.facts.add(_at(robot, room))
        self.problem.goal[_at(robot, wish.room)] = None
        self.problem.contrary[_at(robot, wish.room)] = f"{robot} is in {room}"
        tracked = {fact for facts in self._facts.values() for fact, _ in facts}
        for door in self._house.doors:
            if OUTSIDE in map(fold, door.rooms):
                continue
            passable = tracked & {f"{door.name} is open", f"{door.name} is unlocked"}
            for here, there in (door.rooms, door.rooms[::-1]):
                step = DriveStep(f"{robot} drives to {there}", robot, there)
                why = self._house.problems.get(robot, "") or self._blocked.get((robot, step.text), "")
                needs, gives = frozenset((_at(robot, here), *passable)), frozenset((_at(robot, there),))
                self.problem.operators.append(Operator(needs, gives, frozenset((_at(robot, here),)), step, why))

    def _track(self, device: Device, fact: str, test: Callable[[Device], bool], contrary: str) -> None:
        self._devices[device.id] = device
        facts = self._facts.setdefault(device.id, [])
        if fact in (known for known, _ in facts):
            return
        facts.append((fact, test))
        self.problem.contrary[fact] = contrary
        if test(device):
            self.problem.facts.add(fact)

    def _commands(self, device: Device, part: DevicePart) -> Iterator[Operator]:
        wished = self._wished.get((device.id, part.id), [])
        for capability, value, text in _deeds(device, part, wished):
            after = with_values(device, part.id, _implied(part, capability, value))
            gives = frozenset(fact for fact, test in self._facts[device.id] if test(after))
            takes = frozenset(fact for fact, test in self._facts[device.id] if fact not in gives)
            takes |= {self._follows[one] for one in takes if one in self._follows}  # it is derived again
            needs = frozenset[str]()
            if capability in _OPENINGS:
                needs = frozenset((self._unlocked[device.id],)) if device.id in self._unlocked else needs
            elif value == "locked" and device.id in self._closed:
                needs = frozenset((self._closed[device.id],))
            asks = "" if wished else why_it_asks(device, part)
            step = CommandStep(text, device, part, capability, value, asks)
            yield Operator(needs, gives, takes, step, self._why_not(step))

    def _why_not(self, step: CommandStep) -> str:
        device, part = step.device, step.part
        if known := self._blocked.get((step.place, step.text)):
            return known
        if device.reachable.state == "no" or part.id in device.offline_parts:
            return "it cannot be reached"
        request = CommandRequest(
            device=device.id,
            part=part.id,
            settings=(Setting.of(step.capability, step.value),),
            issuer=self._issuer,
            scope=self._scope,
            ask_first=bool(step.asks),
        )
        refused = self._preview(request, device, part)
        return "" if refused is None else f"{step.asks and 'it always asks, and '}{refused.reason} ({refused.policy})"


def _parts_of(wish: StateWish, devices: Sequence[Device]) -> Iterator[tuple[Device, DevicePart]]:
    """Yield the parts that the wish is about: of devices with exactly its name, if there are any."""
    capabilities = {one.capability for one in leaves(wish.query) if isinstance(one, StateIs)}
    found = [
        (device, part)
        for device in devices
        for part in device.parts
        if not part.part.is_group
        and not part.part.category
        and capabilities.intersection(one.name for one in part.part.capabilities)
        and fits(wish.target, PartFacets(device, part))
    ]
    yield from [one for one in found if wish.name in map(fold, (one[0].name, *one[0].names, part_name(*one)))] or found


def _deeds(device: Device, part: DevicePart, wished: Iterable[StateIs]) -> Iterator[tuple[str, PlainValue, str]]:
    """Yield the possible changes of a part: capability, value and words."""
    name = part_name(device, part)
    given = {(one.capability, one.value) for one in wished}
    for one in part.part.capabilities:
        if not one.settable:
            continue
        known = _DEEDS.get(one.name, {})
        if one.name == "position" and any(
            other.name == "movement" and other.settable for other in part.part.capabilities
        ):
            known = {}
        for value, words in known.items():
            yield one.name, value, words.format(name)
        for capability, value in sorted(given, key=str):
            if capability == one.name and value not in known:
                yield one.name, value, f"set {name} to {value_text(capability, value)}"


def _implied(part: DevicePart, capability: str, value: PlainValue) -> dict[str, PlainValue]:
    """Return the values of *part* after the command."""
    able = {one.name for one in part.part.capabilities}
    values: dict[str, PlainValue] = {capability: value}
    if capability in LIGHTS_UP and "on_off" in able:
        values["on_off"] = value != 0
    if capability in _OPENINGS:
        is_open = value != 0 if capability == "position" else value == "open"
        said: dict[str, PlainValue] = {"movement": "open" if is_open else "closed", "contact": is_open}
        values = {**{one: said[one] for one in said if one in able}, **values}
        if capability == "movement" and "position" in able:
            values["position"] = END_POSITIONS[value]
    return values


def _is_open(device: Device) -> bool | None:
    """Return whether a door is open by its device; None if it is unknown."""
    match _value(device, "contact"), _value(device, "position"), _value(device, "movement"):
        case bool() as is_open, _, _:
            return is_open
        case _, float() as position, _:
            return position > 0
        case _, _, str() as movement:
            return movement != "closed"
    return None


def _can_open(device: Device) -> bool:
    names = {one.name for part in device.parts for one in part.part.capabilities if one.settable}
    return not names.isdisjoint(_OPENINGS)


def _value(device: Device, capability: str) -> PlainValue:
    states = [one for one in device.states if one.capability == capability]
    newest = max(states, key=lambda one: one.told_at.to_seconds(), default=None)
    return None if newest is None else newest.value.plain()


def _told(device: Device, part: DevicePart, states: Iterable[StateIs]) -> str:
    wanted = {one.capability for one in states}
    known = [one for one in device.states if one.part == part.id and one.capability in wanted]
    return ", ".join(value_text(one.capability, one.value.plain()) for one in known) or "in an unknown state"


def _at(robot: str, room: str) -> str:
    return f"{robot} is in {room}"
