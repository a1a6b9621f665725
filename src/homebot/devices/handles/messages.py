"""Raw messages of the devices that have a handle of a kind."""

from collections import deque
from collections.abc import Awaitable, Callable
from contextlib import suppress
from functools import partial
from typing import Final, Generic, Self, TypeVar, final

import anyio

from homebot.devices.device import Device
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.handles.follow import FollowHandles, HandleChange
from homebot.devices.handles.handle import Handle
from homebot.errors import RefusedError, ServiceError
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE

HandleT = TypeVar("HandleT", bound=Handle)

_MAX_QUEUED: Final = 1000
"""Messages queued for a slow reader; the oldest is dropped and counted."""


@final
class HandleMessages(Generic[HandleT]):
    """Iterator over the raw messages of all devices with a handle that matches; see :meth:`Devices.messages`.

    Args:
        node: The node that asks; the query ends with it.
        listen: Registers a function to be called with the messages of a device.

    Attributes:
        lost: Number of messages dropped because 1,000 were waiting for the reader.
    """

    def __init__(
        self,
        node: Node,
        follow: FollowHandles[HandleT],
        listen: Callable[[Device, Callable[[RawMessage], None]], Awaitable[None]],
    ) -> None:
        self._node = node
        self._follow = follow
        self._listen = listen
        self._handles: dict[str, dict[str, HandleT]] = {}  # by device and part
        self._waiting: deque[tuple[HandleT, RawMessage]] = deque()
        self._news = anyio.Event()
        self._is_running = False
        self._end: Exception | None = None
        self.lost = 0

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> HandleChange[HandleT]:
        """Return the next message.

        Raises:
            StopAsyncIteration: The node was closed.
            UsageError: The query has a misspelt name.
        """
        if not self._is_running:
            self._is_running = True
            self._node.create_task(self._run)
        while True:
            while not self._waiting:
                if self._end is not None:
                    raise self._end
                await self._news.wait()
                self._news = anyio.Event()
            handle, message = self._waiting.popleft()
            if _is_newest(handle, message):
                CURRENT_CAUSE.set((handle.device.id, message))
                return HandleChange("message", handle, message=message)

    async def _run(self) -> None:
        end: Exception = StopAsyncIteration()
        try:
            async for change in self._follow:
                handle = change.handle
                parts = self._handles.setdefault(handle.device.id, {})
                if change.kind == "removed":
                    parts.pop(handle.part_id, None)
                elif change.kind == "appeared":
                    parts[handle.part_id] = handle
                    self._node.create_task(partial(self._listen_to, handle.device))
        except Exception as exc:  # noqa: BLE001 - it is the reader's
            end = exc
        self._end = end
        self._news.set()

    async def _listen_to(self, device: Device) -> None:
        with suppress(RefusedError, ServiceError):  # its changes can still be followed
            await self._listen(device, partial(self._add, device.id))

    def _add(self, device_id: str, message: RawMessage) -> None:
        for handle in self._handles.get(device_id, {}).values():
            if _is_newest(handle, message):
                if len(self._waiting) >= _MAX_QUEUED:
                    self._waiting.popleft()
                    self.lost += 1
                self._waiting.append((handle, message))
                self._news.set()


def _is_newest(handle: Handle, message: RawMessage) -> bool:
    return handle.told_at < message.received_at.to_seconds()
