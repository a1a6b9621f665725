"""The parts and values that wishes mean, by the words of ``homebot do``."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

from homebot.command_words.targets import CommandTargets, NoTargetError, Target
from homebot.devices import Device, DevicePart
from homebot.devices.capabilities import MOMENTARY
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.places_messages import DoorInfo
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import And, InArea, Query, StateIs, type_is
from homebot.devices.scene_messages import SceneInfo
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import fits as obeys
from homebot.errors import RefusedError, UsageError
from homebot.features.goals.house_snapshot import HouseReader
from homebot.support.folding import fold
from homebot.words.suitable_parts import part_name, settings_by_part
from homebot.words.wishes import (
    GoalCondition,
    RobotCondition,
    RoomCondition,
    SceneCondition,
    StateCondition,
    read_wishes,
)

_LEAVING: Final[Mapping[PlainValue, StateIs]] = {
    "closing": StateIs("movement", "=", "open"),
    "opening": StateIs("movement", "=", "closed"),
}
"""The state that a cover is about to leave, by its movement."""


@dataclass(frozen=True, slots=True)
class GoalPart:
    """A part that a wish is about.

    Attributes:
        name: Its name for people.
        settings: The values that a command sets; empty for a part that only reports.
        states: States any of which is enough; without any, all settings count.
        asks: Why a person is asked before it is commanded; empty if the goal names it, or nothing needs that.
    """

    device: str
    part: str
    name: str
    settings: Mapping[str, PlainValue]
    states: tuple[StateIs, ...] = ()
    asks: str = ""

    def is_so(self, device: Device) -> bool:
        """Return whether *device* is as wished."""
        part = device.part(self.part)
        if part is None:
            return False
        known = {state.capability: state.value.plain() for state in device.states if state.part == self.part}
        if _LEAVING.get(known.get("movement")) in self.states:
            return False
        if any(fits(term, PartFacets(device, part)) for term in self.states):
            return True
        return bool(self.settings) and all(
            capability in known and obeys(capability, value, known[capability])
            for capability, value in self.settings.items()
        )

    @property
    def capabilities(self) -> frozenset[str]:
        """The capabilities that it is about."""
        return frozenset(self.settings).union(term.capability for term in self.states)


@dataclass(frozen=True, slots=True)
class ParsedGoal:
    """The meaning of a goal.

    Attributes:
        wishes: The wishes, each with its parts.
        scenes: The scenes of the house.
    """

    wishes: tuple[tuple[GoalCondition, tuple[GoalPart, ...]], ...] = ()
    scenes: tuple[SceneInfo, ...] = ()

    @property
    def drives(self) -> list[RobotCondition]:
        """The wishes for robots."""
        return [wish for wish, _ in self.wishes if isinstance(wish, RobotCondition)]


async def parse_goal(text: str, reader: HouseReader) -> ParsedGoal:
    """Return what the goal *text* means.

    Raises:
        UsageError: A wish is not parse_goal, or nothing fits it.
        ServiceError: The directory does not answer.
    """
    scenes, doors = await reader.scenes(), (await reader.places()).doors
    meanings = _Meanings(reader)
    pairs: list[tuple[GoalCondition, tuple[GoalPart, ...]]] = []
    for wish in read_wishes(text, await reader.names(scenes)):
        match wish:
            case StateCondition():
                pairs.append((wish, await meanings.of_state(wish, doors)))
            case RoomCondition():
                pairs.append((wish, await meanings.of_room(wish)))
            case SceneCondition():
                pairs.append((wish, _of_scene(next(scene for scene in scenes if scene.name == wish.scene))))
            case RobotCondition():
                pairs.append((wish, ()))
    return ParsedGoal(tuple(pairs), scenes)


@final
class _Meanings:
    def __init__(self, reader: HouseReader) -> None:
        self._lookup = reader.lookup
        self._targets = CommandTargets(reader.node, reader.lookup, lambda *_: "")

    async def of_state(self, wish: StateCondition, doors: Sequence[DoorInfo]) -> tuple[GoalPart, ...]:
        """Return the parts that *wish* is about.

        Raises:
            UsageError: There are none, several devices have the name, or none takes the value; the message says why.
            ServiceError: The directory does not answer.
        """
        door = next((door for door in doors if fold(door.name) == fold(wish.target)), None)
        target = (door and _door_device(door, wish.command)) or wish.target
        target = f'everything in "{target}"' if wish.area else target
        request = CommandDevicesRequest(target=target, command=wish.command)
        try:
            targets = await self._targets.find(request)
        except (NoTargetError, UsageError) as exc:
            raise UsageError(f"{wish.text}: {exc}") from None
        meant, problem = list[GoalPart](), "nothing takes it"
        for device_and_parts in targets:
            try:
                meant += _meant(request, device_and_parts, wish.states)
            except RefusedError as exc:
                problem = f"{device_and_parts[0].name}: {exc.what}: {exc.reason}"
        if not meant:
            nothing = f"nothing in {wish.target} takes {wish.command}; `homebot find` shows what is there"
            raise UsageError(f"{wish.text}: {nothing if wish.area else problem}")
        return tuple(meant)

    async def of_room(self, wish: RoomCondition) -> tuple[GoalPart, ...]:
        """Return the lamps of an area.

        Raises:
            UsageError: There are none.
            ServiceError: The directory does not answer.
        """
        lights: Query = type_is("light")
        query = And((lights, InArea(fold(wish.area)))) if wish.area else lights
        state = StateIs("on_off", "=", wish.is_lit)
        parts = tuple(
            GoalPart(device.id, part.id, part_name(device, part), settings, (state,))
            for device in await self._lookup.devices(query)
            for part in device.parts
            if fits(lights, PartFacets(device, part))
            and (settings := _settings_of(part, is_on=wish.is_lit)) is not None
        )
        if not parts:
            raise UsageError(
                f"{wish.text}: no lamp is known in {wish.area or 'the house'}; `homebot find lights` shows all"
            )
        return parts


def _door_device(door: DoorInfo, command: str) -> str:
    """Return the device of *door* that *command* is for; empty for none."""
    return door.lock if "lock" in command.casefold() else door.contact


def _of_scene(scene: SceneInfo) -> tuple[GoalPart, ...]:
    """Return the parts of *scene*; none for a native one that does not tell their values.

    Raises:
        UsageError: A part is not in the house.
    """
    if absent := [part.name for part in scene.parts if not part.is_known]:
        raise UsageError(f"scene {scene.name}: {', '.join(absent[:3])} is not in the house now")
    if not all(part.settings for part in scene.parts):
        return ()
    return tuple(
        GoalPart(
            part.device,
            part.part,
            part.name,
            {setting.capability: setting.value.plain() for setting in part.settings},
            asks=part.asks,
        )
        for part in scene.parts
    )


def _meant(request: CommandDevicesRequest, target: Target, states: tuple[StateIs, ...]) -> Iterator[GoalPart]:
    """Yield the parts of a device that take the command; if none does, those that report such a state."""
    device, parts = target
    refused: RefusedError | None = None
    is_taken = False
    for part, parsed in settings_by_part(request, device, parts):
        if isinstance(parsed, RefusedError):
            refused = parsed
        elif MOMENTARY.isdisjoint(parsed):
            is_taken = True
            yield GoalPart(device.id, part.id, part_name(device, part), parsed, states)
    if is_taken:
        return
    wanted = {term.capability for term in states}
    telling = [
        part for part in device.parts if wanted.intersection(capability.name for capability in part.part.capabilities)
    ]
    if not telling:
        raise refused or RefusedError(request.command, "it is done once, and does not last")
    for part in telling:
        yield GoalPart(device.id, part.id, part_name(device, part), {}, states)


def _settings_of(part: DevicePart, *, is_on: bool) -> dict[str, PlainValue] | None:
    """Return the settings that turn a lamp on or off, none if it only reports that; None if it is no lamp by itself."""
    able = [capability for capability in part.part.capabilities if capability.name == "on_off"]
    if not able or part.part.is_group or part.part.category:
        return None
    return {"on_off": is_on} if able[0].settable else {}
