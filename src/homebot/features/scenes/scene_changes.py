"""Changes of the scenes of the owner: saved, edited, renamed, removed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, final

from homebot.command_words.targets import CommandTargets, NoTargetError
from homebot.control.policies.rights import why_asked
from homebot.devices import Device, DevicePart, KeyValue
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.device import target_of
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.scene_messages import MAX_PARTS, ChangeSceneRequest
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UsageError
from homebot.features.scenes.scene import HouseScenes, Scene, place_of
from homebot.features.scenes.scene_book import SavedScene, SceneBook
from homebot.features.scenes.scene_words import present_values, read_values
from homebot.features.scenes.settings import SceneSettings
from homebot.graph import Node
from homebot.support.folding import fold
from homebot.support.names import find_name, no_such
from homebot.words.suitable_parts import part_name

_MAX_NAMED: Final = 5
_NOW: Final = "now"
"""The word for the present values, in place of values in words."""


@final
class SceneChanges:
    """Makes the changes that clients ask for in a book."""

    def __init__(self, node: Node, lookup: DeviceLookup) -> None:
        self._lookup = lookup
        self._targets = CommandTargets(node, lookup, lambda *_: "")

    async def make(
        self, request: ChangeSceneRequest, house: HouseScenes, book: SceneBook
    ) -> tuple[SavedScene | None, tuple[KeyValue, ...]]:
        """Make a change; return the scene, None if it was removed, and the parts that were left out, with the reasons.

        Raises:
            HomebotError: It cannot be made; nothing was changed.
        """
        name = request.name.strip().strip('"')
        if request.change != "save":
            name = find_name(name, [scene.name for scene in book.scenes.values()]) or name
        known = book.scenes.get(fold(name))
        known = None if known is None else house.current(known)
        if request.change == "save":
            return await self._save(name, request, known, house, book)
        if known is None:
            raise _no_scene(name, house, book)
        if request.change == "remove":
            book.remove(fold(name))
            return None, ()
        if request.change == "rename":
            new = request.target.strip().strip('"')
            house.check_hides_none(new)
            return book.rename(known, new), ()
        parts = {} if request.replaces else dict(known.parts)
        edited = await self._edit(parts, request.values, house)
        scene = house.current(known.model_copy(update={"parts": edited}))
        book.put(scene)
        return scene, ()

    async def configured(self, settings: SceneSettings) -> Scene:
        """Return a scene of the configuration, with the parts that its devices and queries mean now."""
        parts, problems = dict[str, Mapping[str, PlainValue]](), dict[str, str]()
        for target, words in settings.values.items():
            try:
                parts |= await self._valued(target, words)
            except (RefusedError, UsageError) as exc:
                problems[target] = str(exc)
        values = {place_of(target): values for target, values in parts.items()}
        return Scene(settings.name, settings.name, values, is_configured=True, problems=problems)

    async def _save(
        self, name: str, request: ChangeSceneRequest, known: SavedScene | None, house: HouseScenes, book: SceneBook
    ) -> tuple[SavedScene, tuple[KeyValue, ...]]:
        if known is None and (request.target or request.values or fold(name) not in house.configured):
            house.check_hides_none(name)
        parts, left_out = dict[str, Mapping[str, PlainValue]](), list[KeyValue]()
        for device, part in await self._scope(name, request, known, house):
            values = present_values(device, part)
            if (problem := _why_left_out(device, part, values)) is None:
                parts[target_of(device.id, part.id)] = values
            elif problem:
                left_out.append(KeyValue(key=part_name(device, part), value=problem))
        if not (parts or request.values):
            reasons = "; ".join(f"{item.key}: {item.value}" for item in left_out[:_MAX_NAMED])
            raise UsageError(f"there is nothing to save; {reasons or 'nothing of that has values to bring back'}")
        edited = await self._edit(parts, request.values, house)
        scene = house.current(SavedScene(name=name, parts=edited))
        book.put(scene)
        return scene, tuple(left_out)

    async def _scope(
        self, name: str, request: ChangeSceneRequest, known: SavedScene | None, house: HouseScenes
    ) -> Sequence[tuple[Device, DevicePart]]:
        """Return the parts whose present values are saved: those of the target, or else those of the scene so far."""
        if request.target:
            return await self._find_parts(request.target)
        configured = house.configured.get(fold(name))
        places = [*map(place_of, known.parts)] if known is not None else configured.parts if configured else ()
        devices_and_parts = [device_and_part for place in places if (device_and_part := house.place(place)) is not None]
        if not (devices_and_parts or request.values):
            raise UsageError("say what the scene is of, such as 'lights in living'")
        return devices_and_parts

    async def _edit(
        self, parts: dict[str, Mapping[str, PlainValue]], values: Sequence[KeyValue], house: HouseScenes
    ) -> dict[str, Mapping[str, PlainValue]]:
        """Return *parts* with *values* in words."""
        for item in values:
            if item.key in parts and house.place(place_of(item.key)) is None:  # it is not in the house now
                valued: list[tuple[str, dict[str, PlainValue]]] = [(item.key, {})]
                if item.value:
                    raise UsageError(f"{item.key} is not in the house now; leave it as it is, or out")
            else:
                valued = await self._valued(item.key, item.value.strip())
            for target, wanted in valued:
                if wanted:
                    parts[target] = wanted
                else:
                    parts.pop(target, None)
        if not 0 < len(parts) <= MAX_PARTS:
            raise UsageError(f"a scene has 1 to {MAX_PARTS} parts, and this would have {len(parts)}")
        return parts

    async def _valued(self, target: str, words: str) -> list[tuple[str, dict[str, PlainValue]]]:
        """Return the parts that *target* means and that take *words*, each with its values."""
        settings: list[tuple[str, dict[str, PlainValue]]] = []
        problem: RefusedError | None = None
        for device, part in await self._find_parts(target):
            try:
                values = _values_of(words, device, part) if words else {}
                settings.append((target_of(device.id, part.id), values))
            except RefusedError as exc:
                problem = problem or exc
        if problem is not None and not settings:
            raise problem
        return settings

    async def _find_parts(self, target: str) -> list[tuple[Device, DevicePart]]:
        """Return the parts that *target* means, with the members of a group in its place, each once."""
        try:
            targets = await self._targets.find(CommandDevicesRequest(target=target))
        except NoTargetError as exc:
            raise UsageError(str(exc)) from exc
        meant: dict[tuple[str, str], tuple[Device, DevicePart]] = {}
        for device, parts in targets:
            for part in parts:
                members = await self._lookup.members(device, part) if part.part.is_group else [(device, part)]
                meant |= {
                    (device.id, other.id): (device, other) for device, other in members if not other.part.is_group
                }
        return list(meant.values())


def _no_scene(name: str, house: HouseScenes, book: SceneBook) -> UsageError:
    if (configured := house.configured.get(fold(name))) is not None:
        return UsageError(f"the scene {configured.name} is in the configuration; change it there, and `homebot reload`")
    named = [scene.name for scene in book.scenes.values()]
    return UsageError(no_such("scene", name, named, "`homebot scene list` shows them; `save` makes one"))


def _values_of(words: str, device: Device, part: DevicePart) -> dict[str, PlainValue]:
    """Return the values that *words* give, or the present ones for ``now``; raises RefusedError if there are none."""
    name = part_name(device, part)
    if words != _NOW:
        return read_values(words, device, part, name)
    if _is_away(device) or not (values := present_values(device, part)):
        raise RefusedError(f"the present state of {name}", "nothing of it is known that a scene could bring back")
    return values


def _why_left_out(device: Device, part: DevicePart, values: Mapping[str, PlainValue]) -> str | None:
    """Return why a scene is saved without *part*; empty if it has nothing to bring back, None if it is saved."""
    if reason := why_asked(device, part, values):
        return f"it always asks ({reason}); `homebot scene edit` can add it"
    if _is_away(device):
        return "its values are unknown, as it cannot be reached"
    if values:
        return None
    return "its values are unknown" if any(capability.settable for capability in part.part.capabilities) else ""


def _is_away(device: Device) -> bool:
    return device.reachable.state == "no" or device.freshness == "stale"
