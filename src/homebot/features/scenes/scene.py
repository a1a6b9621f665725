"""The scenes of a house: those of the owner, and those that a bridge or device keeps. Pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Final, TypeAlias, final

from homebot.control.policies.rights import why_asked
from homebot.devices import Device, DevicePart, KeyValue
from homebot.devices.command_messages import Setting
from homebot.devices.device import is_commanded, target_of
from homebot.devices.scene_messages import SceneInfo, ScenePart
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.features.scenes.scene_book import SavedScene, SceneBook
from homebot.features.scenes.scene_words import values_text
from homebot.messages import Time
from homebot.support.folding import fold
from homebot.support.names import no_such, spellings
from homebot.words.suitable_parts import part_name

Place: TypeAlias = tuple[str, str]
"""The ids of a device and of its part."""

_RECALL: Final = "scene"
_BUTTONS: Final = frozenset({"x_scene", "x_setting", "generic_switch"})
_MAX_NAMED: Final = 8
_NAME: Final = attrgetter("name")


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene.

    Attributes:
        id: Its name, or for a native scene the id of the part that recalls it.
        parts: The values by capability of each part; empty values if only the source of a native scene knows them.
        recalled_by: The part that recalls it; None for a scene of the owner.
        is_configured: Whether it is in the configuration.
        problems: The devices of the configuration that cannot be set, with the reasons.
    """

    name: str
    id: str
    parts: Mapping[Place, Mapping[str, PlainValue]]
    recalled_by: tuple[Device, DevicePart] | None = None
    area: str = ""
    is_configured: bool = False
    problems: Mapping[str, str] = field(default_factory=dict)

    @property
    def full_name(self) -> str:
        """Its name with the room, as one of several rooms; without a room its id."""
        return f"{self.name} in {self.area}" if self.area else self.id


@dataclass(slots=True)
class _MembersByName:
    """The commanded parts of the house, by the references of groups and scenes."""

    named: defaultdict[str, list[Place]] = field(default_factory=lambda: defaultdict(list))

    def add(self, device: Device) -> None:
        for part in device.parts:
            if is_commanded(part.part) and not part.part.members:
                names = dict.fromkeys(device.identifiers)
                for route in part.routes:
                    names |= dict.fromkeys(f"{identifier}#{route.part}" for identifier in device.identifiers)
                    names[f"{route.gateway} #{route.part}"] = None
                for name in names:
                    self.named[name].append((device.id, part.id))

    def of(self, device: Device, part: DevicePart) -> dict[Place, dict[str, PlainValue]]:
        """Return the values of a scene, by part; a device that keeps a scene of its own sets its own main parts."""
        places: dict[Place, dict[str, PlainValue]] = {}
        for member_value in part.part.values:
            for place in self._called(member_value.member, part):
                places.setdefault(place, {})[member_value.capability] = member_value.value.plain()
        if not places:
            places = {place: {} for name in part.part.members for place in self._called(name, part)}
        own = (
            own_part
            for own_part in device.parts
            if is_commanded(own_part.part) and own_part.part.service_type not in _BUTTONS
        )
        return places or {(device.id, own_part.id): {} for own_part in own}

    def _called(self, name: str, scene: DevicePart) -> Iterator[Place]:
        for full_name in (name, *(f"{gateway} {name}" for gateway in {route.gateway for route in scene.routes})):
            yield from self.named.get(full_name, ())


@final
class HouseScenes:
    """The scenes of a house with *devices*.

    Attributes:
        configured: The scenes of the configuration by folded name; those of a command outrank them.
    """

    def __init__(self, devices: Sequence[Device], book: SceneBook) -> None:
        self.devices = {device.id: device for device in devices}
        self.configured: dict[str, Scene] = {}
        self._book = book

    def find(self, name: str) -> Scene:
        """Return the scene with this name or id, such as ``Film in living``: of the owner, or else the only native one.

        Raises:
            UsageError: There is none, or there are several; the message names them.
        """
        native = list(self.native())
        for text in spellings(name):
            if (own := self._book.scenes.get(fold(text))) is not None:
                parts = self.current(own).parts
                return Scene(own.name, own.name, {place_of(target): values for target, values in parts.items()})
            if (configured := self.configured.get(fold(text))) is not None:
                return configured
            matches = [scene for scene in native if scene.id == text] or [
                scene for scene in native if fold(text) in (fold(scene.name), fold(scene.full_name))
            ]
            if len(matches) > 1:
                ids = " or ".join(repr(scene.full_name) for scene in matches[:_MAX_NAMED])
                raise UsageError(f"{len(matches)} scenes are called {text!r}; name one: {ids}")
            if matches:
                return matches[0]
        known = map(_NAME, (*self._book.scenes.values(), *self.configured.values(), *native))
        raise UsageError(no_such("scene", name, known, "`homebot scene list` shows them"))

    def check_hides_none(self, name: str) -> None:
        """Raise UsageError if a scene of the owner called *name* would hide a configured or a native one."""
        if fold(name) in self.configured:
            raise UsageError(f"the configuration has a scene {name!r}, which this would hide; choose another name")
        names = {fold(known_name): scene for scene in self.native() for known_name in (scene.name, scene.full_name)}
        if (hidden := names.get(fold(name))) is not None:
            raise UsageError(f"{hidden.id} keeps a scene {hidden.name!r}, which this would hide; choose another name")

    def current(self, scene: SavedScene) -> SavedScene:
        """Return *scene* with the present ids and routes of its parts; those that are not there now keep theirs."""
        parts, routes = dict[str, Mapping[str, PlainValue]](), dict[str, tuple[str, ...]]()
        for target, values in scene.parts.items():
            known = scene.routes.get(target, ())
            device_and_part = self.place(place_of(target)) or self._find_reachable(known)
            now = target if device_and_part is None else target_of(device_and_part[0].id, device_and_part[1].id)
            parts[now], routes[now] = values, known if device_and_part is None else tuple(_routes(device_and_part[1]))
        return scene.model_copy(update={"parts": parts, "routes": routes})

    def _find_reachable(self, routes: Sequence[str]) -> tuple[Device, DevicePart] | None:
        wanted = set(routes)
        parts = ((device, part) for device in self.devices.values() for part in device.parts) if wanted else ()
        return next(
            (device_and_part for device_and_part in parts if not wanted.isdisjoint(_routes(device_and_part[1]))), None
        )

    def all(self) -> Iterator[Scene]:
        """Yield all scenes: those of the owner, and then the native ones by room."""
        for name in sorted({*self._book.scenes, *self.configured}):
            yield self.find(name)
        yield from sorted(self.native(), key=lambda one: (fold(one.area), fold(one.name), one.id))

    def native(self) -> Iterator[Scene]:
        """Yield the scenes that a bridge or device keeps."""
        parts = ((device, part) for device in self.devices.values() for part in device.parts)
        keeping = [(device, part) for device, part in parts if _is_scene(part)]
        members = _MembersByName()
        for device in self.devices.values() if keeping else ():
            members.add(device)
        for device, part in keeping:
            name, scene_id = part.part.name or device.name, target_of(device.id, part.id)
            yield Scene(name, scene_id, members.of(device, part), (device, part), device.area)

    def info(self, scene: Scene) -> SceneInfo:
        """Return *scene* for clients."""
        applied = self._book.applied.get(scene.id)
        return SceneInfo(
            name=scene.name,
            id=scene.id,
            is_native=scene.recalled_by is not None,
            is_configured=scene.is_configured,
            problems=tuple(KeyValue(key=key, value=problem) for key, problem in scene.problems.items()),
            area=scene.area,
            parts=tuple([self._part(place, values) for place, values in scene.parts.items()]),
            can_undo=applied is not None and not applied.is_undone,
            applied_at=Time.from_seconds(applied.at if applied is not None else 0.0),
        )

    def place(self, place: Place) -> tuple[Device, DevicePart] | None:
        """Return a part of the house; None if it is not there now."""
        device = self.devices.get(place[0])
        part = None if device is None else device.part(place[1])
        return None if device is None or part is None else (device, part)

    def name(self, place: Place) -> str:
        """Return the name of a part for people; its id if it is not in the house."""
        device_and_part = self.place(place)
        return target_of(*place) if device_and_part is None else part_name(*device_and_part)

    def why_asked(self, place: Place, values: Mapping[str, PlainValue]) -> str:
        """Return why a person must agree to *values* of a part; empty if none must, or it is not in the house."""
        device_and_part = self.place(place)
        return "" if device_and_part is None else why_asked(*device_and_part, values)

    def _part(self, place: Place, values: Mapping[str, PlainValue]) -> ScenePart:
        device_and_part, settings = self.place(place), tuple(map(Setting.of, values, values.values()))
        return ScenePart(
            device=place[0],
            part=place[1],
            name=self.name(place),
            area="" if device_and_part is None else device_and_part[0].area,
            settings=settings,
            text=values_text(settings),
            asks=self.why_asked(place, values),
            is_known=device_and_part is not None,
        )


def _is_scene(part: DevicePart) -> bool:
    return any(capability.name == _RECALL and capability.settable for capability in part.part.capabilities)


def _routes(part: DevicePart) -> Iterator[str]:
    return (f"{route.name}#{route.part}" for route in part.routes)


def place_of(target: str) -> Place:
    """Return the ids of the device and the part of which *target* was made."""
    device, _, part = target.partition("#")
    return device, part
