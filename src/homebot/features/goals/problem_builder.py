"""The problem of a goal: each relevant door, part and robot by itself, as planners like it. Pure.

Lifted to variables, the planner would need ten seconds for fifty rooms; so, 0.2 s.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias, final

from homebot.devices import Device, DevicePart
from homebot.devices.always_ask import why_it_asks
from homebot.devices.client_rights import LOCAL_RIGHTS
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.device import target_of
from homebot.devices.value import PlainValue
from homebot.devices.wording.values import value_text
from homebot.features.goals.house_snapshot import OPENINGS, HouseSnapshot
from homebot.features.goals.meanings import GoalPart, ParsedGoal
from homebot.features.goals.operators import GoalProblem, Operator, PartSettings, PlanStep, Settings
from homebot.places.plan import OUTSIDE
from homebot.support.folding import fold
from homebot.words.rights import read_scope
from homebot.words.suitable_parts import part_name
from homebot.words.wishes import DOCK, GoalCondition, RobotCondition, RoomCondition, SceneCondition

if TYPE_CHECKING:
    from homebot.devices.outcomes import Refused
    from homebot.devices.places_messages import DoorInfo
    from homebot.devices.scene_messages import SceneInfo

Preview: TypeAlias = Callable[[CommandRequest, Device, DevicePart], "Refused | None"]
"""Returns the refusal of a command by rights and policies, if it were given now."""

Blocked: TypeAlias = Mapping[tuple[str, str], str]
"""Why a step is not possible, by its place and text."""

_Facts: TypeAlias = dict[str, Callable[[Device], bool]]
"""Facts of a device, each with its test."""

_DEEDS: Final[Mapping[str, Mapping[PlainValue, str]]] = {
    "on_off": {True: "turn on {}", False: "turn off {}"},
    "lock": {"unlocked": "unlock {}", "locked": "lock {}"},
    "movement": {"open": "open {}", "closed": "close {}"},
    "valve": {"open": "open {}", "closed": "close {}"},
    "position": {100.0: "open {}", 0.0: "close {}"},
}
"""Steps in words, by capability and value; others say the value."""

_OF_DOORS: Final = ("lock", "movement", "position")
_MIN_PARTS: Final = 2
"""Parts from which on a scene is used that the goal does not name."""


@dataclass(frozen=True, slots=True)
class GoalClient:
    """The client of a goal; ``preview`` refuses commands that it may not give now, ``blocked`` those that failed."""

    issuer: str
    scope: tuple[str, ...]
    preview: Preview
    blocked: Blocked


def build_problem(
    goal: ParsedGoal, house: HouseSnapshot, unseen: Iterable[str], asker: GoalClient | None = None
) -> GoalProblem:
    """Return the problem; without *asker* only its facts, which takes less time.

    Args:
        unseen: Facts that steps have reached, and that cannot be read.
    """
    facts = _FactBuilder(house)
    for wish, meant in goal.wishes:
        facts.add_parts(wish, meant)
    named = {wish.scene for wish, _ in goal.wishes if isinstance(wish, SceneCondition)}
    for scene in goal.scenes:
        if scene.name in named and not _parts_of(scene):
            facts.add_applied(scene)
    for drive in goal.drives:
        facts.add_robot(drive)
    for door in house.doors:
        facts.add_door(door, is_way=bool(goal.drives))
    facts.problem.facts.update(unseen)
    if asker is not None:
        steps = _StepBuilder(facts, asker)
        steps.add_commands()
        for scene in goal.scenes:
            steps.add_scene(scene, is_named=scene.name in named)
        for drive in goal.drives:
            steps.add_drives(drive)
    return facts.problem


@final
class _FactBuilder:
    """Facts of the house.

    Attributes:
        tests: The facts of each device.
        wished: What is wished of each part.
        follows: The fact that follows from another one.
        unlocked: The fact without which a device does not open, by device.
        closed: The fact without which a lock does not lock, by device.
        of_doors: The devices of doors.
        excluded: For each robot the facts that it is not in a room, with that.
    """

    def __init__(self, house: HouseSnapshot) -> None:
        self.problem, self.house = GoalProblem(), house
        self.tests: dict[str, _Facts] = {}
        self.wished: dict[tuple[str, str], list[GoalPart]] = {}
        self.follows: dict[str, str] = {}
        self.unlocked: dict[str, str] = {}
        self.closed: dict[str, str] = {}
        self.of_doors: set[str] = set()
        self.excluded: dict[str, dict[str, str]] = {}

    def add_parts(self, wish: GoalCondition, meant: Iterable[GoalPart]) -> None:
        """Add the facts that the wish is about."""
        is_any = isinstance(wish, RoomCondition) and wish.is_lit
        for part in meant:
            device, fact = self.house.devices.get(part.device), f"{part.name}: {wish.text}"
            self.wished.setdefault((part.device, part.part), []).append(part)
            self.problem.contrary[fact] = f"{part.name} is not in the house any more"
            if device is not None:
                self._track(device, fact, part.is_so, f"{part.name} {_told(device, part)}")
            if is_any:
                self.follows[fact] = wish.text
                self.problem.operators.append(Operator(frozenset((fact,)), frozenset((wish.text,))))
                if fact in self.problem.facts:
                    self.problem.facts.add(wish.text)
            else:
                self.problem.goal[fact] = None
        if is_any:
            self.problem.goal[wish.text] = None
            self.problem.contrary[wish.text] = f"{wish.text.removesuffix(' lit')} is not lit"

    def add_door(self, door: DoorInfo, *, is_way: bool) -> None:
        """Add the facts of a door that is on a way, or whose devices are concerned, as its devices tell them."""
        contact, lock = self.house.called(door.contact), self.house.called(door.lock)
        devices = {device.id for device in (contact, lock) if device is not None}
        if not (is_way or devices & self.tests.keys()):
            return
        self.of_doors |= devices
        if contact is not None and (_is_open(contact) is not None or _can_open(contact)):
            opened, closed = f"{door.name} is open", f"{door.name} is closed"
            self._track(contact, opened, lambda device: _is_open(device) is not False, closed)
            self._track(contact, closed, lambda device: _is_open(device) is False, opened)
        if lock is not None:
            fact = f"{door.name} is unlocked"
            self._track(lock, fact, lambda device: _value(device, "lock") != "locked", f"{door.name} is locked")
            self.unlocked |= dict.fromkeys(devices, fact)
            if contact is not None:
                self.closed[lock.id] = f"{door.name} is closed"

    def add_applied(self, scene: SceneInfo) -> None:
        """Add the fact that a scene is applied, whose bridge does not tell its values."""
        fact = _apply_step(scene)
        self.problem.goal[fact] = None
        self.problem.contrary[fact] = f"what scene {scene.name} does is known only to its bridge"

    def add_robot(self, wish: RobotCondition) -> None:
        """Add the room of a robot."""
        room, wished = self.house.robots.get(wish.robot, ""), _wished_room(wish)
        self.problem.goal[wished] = None
        self.problem.contrary[wished] = self.house.lost.get(wish.robot) or _at(wish.robot, room)
        if wish.is_not:
            self.excluded.setdefault(wish.robot, {})[wished] = fold(wish.room)
        if not room:
            return
        self.problem.facts.add(_at(wish.robot, room))
        if wish.is_not and fold(room) != fold(wish.room):
            self.problem.facts.add(wished)

    def _track(self, device: Device, fact: str, test: Callable[[Device], bool], contrary: str) -> None:
        self.tests.setdefault(device.id, {}).setdefault(fact, test)
        self.problem.contrary[fact] = contrary
        if test(device):
            self.problem.facts.add(fact)


@final
class _StepBuilder:
    def __init__(self, known: _FactBuilder, asker: GoalClient) -> None:
        self._known, self._house, self._asker = known, known.house, asker
        self._rights = read_scope(asker.scope) if asker.scope else LOCAL_RIGHTS

    def add_commands(self) -> None:
        """Add the commands to the devices of all facts."""
        for device_id in self._known.tests:
            device = self._house.devices[device_id]
            for part in device.parts:
                self._known.problem.operators += self._commands(device, part)

    def add_scene(self, scene: SceneInfo, *, is_named: bool) -> None:
        """Add a scene, if the goal names it, or wishes all that it does."""
        parts = _parts_of(scene)
        if not (is_named or (len(parts) >= _MIN_PARTS and all(map(self._is_wished, parts)))):
            return
        asks = next((part.asks for part in scene.parts if part.asks), "") or next(
            filter(None, map(self._asks, parts)), ""
        )
        step = PlanStep("scene", f"apply scene {scene.name}", scene.id, parts, asks)
        gives, takes = self._effects(step)
        gives |= {_apply_step(scene)}
        refusals = (self._refusal(part, asks) for part in parts)
        why = self._blocked(step) or next(filter(None, refusals), "")
        self._known.problem.operators.append(Operator(frozenset(), gives, takes, step, why, is_unseen=not parts))

    def add_drives(self, wish: RobotCondition) -> None:
        """Add the ways of a robot."""
        robot, wished = wish.robot, _wished_room(wish)
        at, device = _at(robot, self._house.robots.get(robot, "")), self._house.called(robot)
        parts = () if device is None else ((device.id, "", ()),)
        if wish.room == DOCK:
            step = PlanStep("drive", f"{robot} drives to its dock", robot, parts, room=DOCK)
            self._add_drive(step, frozenset(), frozenset((wished,)), frozenset((at,)))
            return
        tracked = {fact for facts in self._known.tests.values() for fact in facts}
        for door in self._house.doors:
            if OUTSIDE in map(fold, door.rooms):
                continue
            passable = tracked & {f"{door.name} is open", f"{door.name} is unlocked"}
            for here, there in (door.rooms, door.rooms[::-1]):
                gives, takes = {_at(robot, there)}, {_at(robot, here)}
                for fact, room in self._known.excluded.get(robot, {}).items():
                    (takes if fold(there) == room else gives).add(fact)
                step = PlanStep("drive", f"{robot} drives to {there}", robot, parts, room=there)
                self._add_drive(step, frozenset((_at(robot, here), *passable)), frozenset(gives), frozenset(takes))

    def _add_drive(self, step: PlanStep, needs: frozenset[str], gives: frozenset[str], takes: frozenset[str]) -> None:
        why = self._house.problems.get(step.place, "") or self._blocked(step)
        self._known.problem.operators.append(Operator(needs, gives, takes, step, why, is_unseen=step.room == DOCK))

    def _commands(self, device: Device, part: DevicePart) -> Iterator[Operator]:
        meant = sorted(self._known.wished.get((device.id, part.id), ()), key=lambda wanted: wanted.asks, reverse=True)
        wished = {
            tuple(wanted.settings.items()): wanted.asks for wanted in meant
        }  # also named by itself, it does not ask
        of_door = _door_settings(part) if device.id in self._known.of_doors else ()
        for settings in filter(None, dict.fromkeys((*wished, *of_door))):
            asks, parts = wished.get(settings), ((device.id, part.id, settings),)
            asks = (why_it_asks(device, part) if asks is None else asks) or self._asks(parts[0])
            text = _step_text(part_name(device, part), settings)
            step = PlanStep("command", text, target_of(device.id, part.id), parts, asks)
            gives, takes = self._effects(step)
            why = self._blocked(step) or self._refusal(parts[0], asks)
            yield Operator(self._needs(device.id, dict(settings)), gives, takes, step, why)

    def _needs(self, door: str, settings: Mapping[str, PlainValue]) -> frozenset[str]:
        """Return the facts that must hold before *settings*: a door that opens is unlocked, one that locks closed."""
        facts = self._known.closed if settings.get("lock") == "locked" else {}
        facts = facts if OPENINGS.isdisjoint(settings) else self._known.unlocked
        return frozenset((facts[door],)) if door in facts else frozenset()

    def _effects(self, step: PlanStep) -> tuple[frozenset[str], frozenset[str]]:
        """Return the facts that hold after *step*, and those that do not, of the devices that it changes."""
        gives, takes = set[str](), set[str]()
        after = self._house.after((step,)).devices
        for device_id in {device_id for device_id, *_ in step.parts} & self._known.tests.keys():
            for fact, test in self._known.tests[device_id].items():
                (gives if test(after[device_id]) else takes).add(fact)
        takes |= {self._known.follows[fact] for fact in takes if fact in self._known.follows}  # it is derived again
        return frozenset(gives), frozenset(takes)

    def _blocked(self, step: PlanStep) -> str:
        return self._asker.blocked.get((step.place, step.text), "")

    def _is_wished(self, part: PartSettings) -> bool:
        device, its_part, settings = part
        return any(wished.settings == dict(settings) for wished in self._known.wished.get((device, its_part), ()))

    def _asks(self, wanted: PartSettings) -> str:
        """Return that each command of the client to a part has to be agreed to; empty if it has not."""
        device = self._house.devices.get(wanted[0])
        part = None if device is None else device.part(wanted[1])
        if device is None or part is None or not self._rights.must_ask(device, part):
            return ""
        return "its client may only ask"

    def _refusal(self, wanted: PartSettings, asks: str) -> str:
        """Return why a part cannot get its settings now; empty if it can."""
        device_id, part_id, settings = wanted
        device = self._house.devices.get(device_id)
        part = None if device is None else device.part(part_id)
        if device is None or part is None:
            return f"{device_id} is not in the house any more"
        if device.reachable.state == "no" or part_id in device.offline_parts:
            return "it cannot be reached"
        request = CommandRequest(
            device=device_id,
            part=part_id,
            settings=tuple(Setting.of(*pair) for pair in settings),
            issuer=self._asker.issuer,
            scope=self._asker.scope,
            ask_first=bool(asks),
        )
        refused = self._asker.preview(request, device, part)
        return "" if refused is None else f"{asks and 'it asks first, and '}{refused.reason} ({refused.policy})"


def _parts_of(scene: SceneInfo) -> tuple[PartSettings, ...]:
    """Return the values of a scene; none if only its bridge knows them."""
    return tuple(
        (part.device, part.part, tuple((setting.capability, setting.value.plain()) for setting in part.settings))
        for part in scene.parts
        if all(part.settings for part in scene.parts)
    )


def _apply_step(scene: SceneInfo) -> str:
    return f"scene {scene.name} is applied"


def _door_settings(part: DevicePart) -> Sequence[Settings]:
    """Return the settings that open, close, lock and unlock a door."""
    able = {capability.name for capability in part.part.capabilities if capability.settable}
    moving = able.intersection(_OF_DOORS) - ({"position"} if "movement" in able else set())
    return [((name, value),) for name in _OF_DOORS if name in moving for value in _DEEDS[name]]


def _step_text(name: str, settings: Settings) -> str:
    if len(settings) == 1:
        ((capability, value),) = settings
        if words := _DEEDS.get(capability, {}).get(value):
            return words.format(name)
    return f"set {name} to {', '.join(value_text(*pair) for pair in settings)}"


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
    names = {capability.name for part in device.parts for capability in part.part.capabilities if capability.settable}
    return not names.isdisjoint(OPENINGS)


def _value(device: Device, capability: str) -> PlainValue:
    states = [state for state in device.states if state.capability == capability]
    newest = max(states, key=lambda state: state.told_at.to_seconds(), default=None)
    return None if newest is None else newest.value.plain()


def _told(device: Device, meant: GoalPart) -> str:
    known = [state for state in device.states if state.part == meant.part and state.capability in meant.capabilities]
    values = ", ".join(value_text(state.capability, state.value.plain()) for state in known)
    return f"is {values}" if values else "is in an unknown state"


def _at(robot: str, room: str) -> str:
    return f"{robot} is in {'its dock' if room == DOCK else room}"


def _wished_room(wish: RobotCondition) -> str:
    return f"{wish.robot} is not in {wish.room}" if wish.is_not else _at(wish.robot, wish.room)
