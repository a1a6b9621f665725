"""The services for scenes; the scenes of the owner are kept by the directory, with all that the owner states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Final, Protocol, final

from homebot.devices import names
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest, ListRoutines, RoutinesRequest
from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.scene_messages import (
    ApplyScene,
    ApplySceneRequest,
    ChangeScene,
    ChangeSceneRequest,
    ChangeSceneResponse,
    ListScenes,
    SceneInfo,
    ScenesRequest,
    ScenesResponse,
)
from homebot.errors import HomebotError, WireError
from homebot.features.scenes import APPLY_SCENE, CHANGE_SCENE, FEATURE, LIST_SCENES
from homebot.features.scenes.scene import HouseScenes
from homebot.features.scenes.scene_applying import SceneApplying
from homebot.features.scenes.scene_book import SceneBook
from homebot.features.scenes.scene_changes import SceneChanges
from homebot.features.scenes.settings import SceneSettings
from homebot.graph import Node
from homebot.support.folding import fold
from homebot.words.routine_text import rename_scene

if TYPE_CHECKING:
    from homebot.feature_context import FeatureContext

UNREADABLE = "scenes.unreadable"

_NEVER_IN_STEPS: Final = frozenset("\"'\\,")
"""A name that stands in a text of TOML as it is."""

_PATIENCE: Final = 60.0


class SceneKeeper(Protocol):
    """Keeps the scenes across restarts, as the directory does."""

    def owner_record(self, feature: str) -> str:
        """Return the record that was kept; empty for none."""

    async def save_record(self, feature: str, record: str, *, at_once: bool) -> str:
        """Save *record*; return why that failed, in words, empty if it did not."""


@final
class SceneServices:
    """Lists, changes and applies scenes.

    Args:
        keeper: Returns the keeper of the scenes of commands; None before it runs.
        configured: Returns the scenes of the configuration.
    """

    def __init__(
        self,
        node: Node,
        keeper: Callable[[], SceneKeeper | None],
        configured: Callable[[], Sequence[SceneSettings]] = tuple,
    ) -> None:
        self._configured = configured
        self._node = node
        self._keeper = keeper
        self._lookup = DeviceLookup(node)
        self._changes = SceneChanges(node, self._lookup)
        self._applying = SceneApplying(node)
        self._read: SceneBook | None = None

    def serve(self, name: str) -> None:
        """Create the service with this name."""
        if name == LIST_SCENES.name:
            self._node.create_service(ListScenes, name, self._list, concurrent=True)
        elif name == CHANGE_SCENE.name:
            self._node.create_service(ChangeScene, name, self._change)
        else:
            self._node.create_service(ApplyScene, APPLY_SCENE.name, self._apply, concurrent=True)

    async def _list(self, request: ScenesRequest) -> ScenesResponse:
        try:
            house, _ = await self._house()
            scenes = (house.find(request.name),) if request.name else house.all()
            return ScenesResponse(success=True, scenes=tuple(map(house.info, scenes)))
        except HomebotError as exc:
            return ScenesResponse(success=False, message=str(exc))

    async def _change(self, request: ChangeSceneRequest) -> ChangeSceneResponse:
        try:
            house, book = await self._house()
            scene, left_out = await self._changes.make(request, house, book)
        except HomebotError as exc:
            return ChangeSceneResponse(success=False, message=str(exc))
        scenes: tuple[SceneInfo, ...] = () if scene is None else (house.info(house.find(scene.name)),)
        problem = await self._store(book, at_once=True)
        messages = [f"a restart would lose this, as it was not written: {problem}"] if problem else []
        if request.change == "rename" and scene is not None:
            messages += await self._rename_uses(request.name.strip(), scene.name)
        return ChangeSceneResponse(success=True, message="; ".join(messages), scenes=scenes, left_out=left_out)

    async def _rename_uses(self, old: str, new: str) -> list[str]:
        """Rename a scene in the kept routines that apply it; return which others still name the *old* one."""
        problems = list[str]()
        if not (routines := self._node.create_client(ListRoutines, names.LIST_ROUTINES)).service_is_ready():
            return problems
        change = self._node.create_client(ChangeRoutine, names.CHANGE_ROUTINE)
        with closing(routines), closing(change):
            for routine in (await routines.call(RoutinesRequest())).routines:
                text = rename_scene(routine.text, old, new)
                if text == routine.text:
                    continue
                if not (routine.is_kept and _NEVER_IN_STEPS.isdisjoint(new)):
                    problems.append(f"the routine {routine.name} still applies {old}; change it there")
                    continue
                own = self._node.full_name
                edit = ChangeRoutineRequest(name=routine.name, change="edit", text=text, issuer=own)
                answer = await change.call(edit, timeout=_PATIENCE)
                problems += [] if answer.success else [f"the routine {routine.name}: {answer.message}"]
        return problems

    async def _apply(self, request: ApplySceneRequest) -> CommandDevicesResponse:
        try:
            house, book = await self._house()
            scene = house.find(request.name)
        except HomebotError as exc:
            return CommandDevicesResponse(success=False, message=str(exc))
        keep = partial(self._store, book, at_once=True)  # an undo outlives a sudden death
        if request.undo:
            answer = await self._applying.undo(request, scene, house, book)
        else:
            answer = await self._applying.apply(request, scene, house, book, keep)
        await keep()
        return answer

    async def _house(self) -> tuple[HouseScenes, SceneBook]:
        """Return the scenes; the book is read once the directory has answered, which has read its file by then."""
        devices = await self._lookup.devices()
        book = self._read = self._read or self._read_book()
        house = HouseScenes(devices, book)
        for scene in self._configured():
            house.configured[fold(scene.name)] = await self._changes.configured(scene)
        return house, book

    def _read_book(self) -> SceneBook:
        keeper = self._keeper()
        try:
            return SceneBook(keeper.owner_record(FEATURE.name) if keeper is not None else "")
        except WireError as exc:
            self._node.log.error(UNREADABLE, message=f"the scenes of the owner cannot be read: {exc}")
            return SceneBook()

    async def _store(self, book: SceneBook, *, at_once: bool) -> str:
        keeper = self._keeper()
        return "" if keeper is None else await keeper.save_record(FEATURE.name, book.record(), at_once=at_once)


def start(node: Node, house: FeatureContext) -> SceneServices:
    """Return the server."""
    return SceneServices(node, house.directory, lambda: house.table("scenes") or ())
