"""The base class of apps that act room by room."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Coroutine, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, TypeVar

import anyio
from anyio.abc import TaskGroup

from homebot.apps.base import App, SettingsT
from homebot.devices import Device
from homebot.devices.devices import MessageHandler
from homebot.devices.handles import FollowHandles, Handle, HandleChange
from homebot.devices.health import GetHealth
from homebot.devices.misspelt_names import ConfiguredNames
from homebot.devices.outcomes import Superseded
from homebot.errors import RefusedError, ServiceError
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.support.folding import fold

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome

__all__ = ["RoomApp", "in_room"]

HandleT = TypeVar("HandleT", bound=Handle)
ResultT = TypeVar("ResultT")


def in_room(handles: Iterable[HandleT], room: str) -> list[HandleT]:
    """Return the *handles* in *room* itself; for a floor those in none of its rooms.

    Case and accents do not matter. A device without a room is in none.
    """
    return [one for one in handles if room and fold(one.area) == fold(room)]


class RoomApp(App[SettingsT]):
    """An app with at most one task for each room: a newer one cancels the older, and rooms do not wait for each other.

    Call :meth:`watch` in the constructor.

    Args:
        node: The node of the app.
        settings: Its settings.
        rooms: The rooms of its key ``rooms``; an unknown one is logged and shown by `homebot doctor`.
    """

    def __init__(self, node: Node, settings: SettingsT, rooms: Iterable[str] = ()) -> None:
        super().__init__(node, settings)
        self._watchers: list[Callable[[], Coroutine[object, object, None]]] = []
        self._room_tasks: TaskGroup | None = None
        self._scopes: dict[str, anyio.CancelScope] = {}
        self._log_limit = LogLimit(node.graph.clock)
        if named := [("rooms", room) for room in rooms]:
            names = ConfiguredNames(node, rooms=named)
            node.create_service(GetHealth, "~/health", names.health)
            self._watchers.append(names.run)

    def watch(self, changes: FollowHandles[HandleT], take: Callable[[HandleChange[HandleT]], None]) -> None:
        """Call *take* with each of *changes* once the app runs."""

        async def watcher() -> None:
            async for change in changes:
                take(change)

        self._watchers.append(watcher)

    def listen(self, device: Device, handler: MessageHandler) -> None:
        """Call *handler* with each raw message of *device*, if its gateways deliver any; while the app runs."""

        async def listening() -> None:
            with suppress(RefusedError, ServiceError):  # its changes can be followed all the same
                await self.devices.listen(device, handler)

        self.start_task(listening)

    async def run(self) -> None:
        """Run the watchers, and the tasks of the rooms."""
        async with anyio.create_task_group() as self._room_tasks:
            for watcher in self._watchers:
                self._room_tasks.start_soon(watcher)

    def start(self, room: str, function: Callable[[str], Awaitable[None]]) -> None:
        """Call *function* with *room* in a task, in place of the one that the room has; while the app runs."""
        self.cancel(room)
        if self._room_tasks is not None:
            scope = self._scopes[fold(room)] = anyio.CancelScope()
            self._room_tasks.start_soon(self._run_task, room, function, scope)

    def start_task(self, function: Callable[[], Coroutine[object, object, object]]) -> None:
        """Call *function* in a task beside those of the rooms, any number at once; while the app runs."""
        if self._room_tasks is not None:
            self._room_tasks.start_soon(function)

    def cancel(self, room: str) -> None:
        """Cancel the task of *room*, if it has one."""
        if (scope := self._scopes.pop(fold(room), None)) is not None:
            scope.cancel()

    async def each(
        self, function: Callable[[HandleT], Coroutine[object, object, ResultT]], handles: Iterable[HandleT]
    ) -> list[ResultT]:
        """Call *function* with each of *handles*, all at once; return the results when all are done, as they came."""
        results: list[ResultT] = []

        async def call(handle: HandleT) -> None:
            results.append(await function(handle))

        async with anyio.create_task_group() as calls:
            for handle in handles:
                calls.start_soon(call, handle)
        return results

    async def attempt(self, handle: Handle, command: Callable[[], Awaitable[Outcome]]) -> bool:
        """Give *command* to *handle*; return whether it succeeded, and log its outcome if it failed."""
        try:
            outcome = await command()
        except RefusedError as exc:
            problem = str(exc)
        else:
            if outcome.succeeded:
                return True

            if isinstance(outcome, Superseded):  # a newer wish replaces it
                return False
            problem = outcome.text
        self.node.log.warning("app.command_failed", message=f"{handle.name}: {problem}", device=handle.device.id)
        return False

    def log_limited(self, event: str, handle: Handle, text: str) -> None:
        """Log *text* about *handle*, at most once in 10 s for each event of each handle."""
        if self._log_limit.allows(f"{event} {handle.id}") is not None:
            self.node.log.info(event, message=f"{handle.id} {text}", device=handle.device.id)

    async def _run_task(self, room: str, function: Callable[[str], Awaitable[None]], scope: anyio.CancelScope) -> None:
        with scope:
            await function(room)
            if self._scopes.get(fold(room)) is scope:
                del self._scopes[fold(room)]
