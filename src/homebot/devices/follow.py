"""A live query: the devices of a type that are there, and then whatever happens to them."""

from __future__ import annotations

from collections import deque
from typing import Self

import anyio
import anyio.lowlevel

from homebot.devices.device import DeviceChange
from homebot.devices.followed import FollowedDevices
from homebot.devices.names import DEVICE_CHANGES, FIND_DEVICES
from homebot.devices.service_starts import service_starts
from homebot.devices.services import FindDevices, FindDevicesRequest, FindDevicesResponse
from homebot.errors import ClosedError, ServiceError
from homebot.graph import Client, Node, Subscription
from homebot.log import LogLimit

__all__ = ["Follow"]

NO_ANSWER = "devices.no_answer"

_TURN = 100
"""Changes given out before other tasks get their turn, should the reader never wait."""

_PAUSE = 0.5
"""Seconds until a directory that fails to answer is asked again."""


class Follow:
    """``async for change in Follow(node, "lights")``: first ``appeared`` for each device there is, then every change.

    To a reader, each device appears first and is removed last. One that falls behind misses intermediate changes of a
    device, never its last one. A directory that is not there yet is waited for; after one was restarted, the reader
    hears what became different, and nothing twice. One task reads.

    Args:
        node: Who asks; the query ends with it.
        service_type: For example ``lights``; empty for every device. A device that offers it no longer is removed.
    """

    def __init__(self, node: Node, service_type: str = "") -> None:
        self._node = node
        self._request = FindDevicesRequest(service_type=service_type)
        self._followed = FollowedDevices(service_type)
        self._changes: Subscription[DeviceChange] | None = None
        self._ready: deque[DeviceChange] = deque()
        self._is_outdated = True
        self._watch = anyio.CancelScope()
        self._given = 0
        self._is_closed = False
        self._limit = LogLimit(node.graph.clock)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> DeviceChange:
        """Return the next change.

        Raises:
            StopAsyncIteration: The query or its node was closed.
        """
        try:
            return await self._next(self._changes or self._begin())
        except ClosedError:
            raise StopAsyncIteration from None

    def close(self) -> None:
        """End the query. Twice is fine."""
        self._is_closed = True
        self._watch.cancel()
        if self._changes is not None:
            self._changes.close()

    async def _next(self, changes: Subscription[DeviceChange]) -> DeviceChange:
        while not self._is_closed:
            await self._give_others_a_turn()
            if self._is_outdated:
                await self._compare()
            elif self._ready:
                return self._ready.popleft()
            elif (change := changes.take()) is None:
                await changes.mailbox.wait()
            elif (told := self._followed.take(change)) is not None:
                return told
        raise ClosedError("the query is closed")

    def _begin(self) -> Subscription[DeviceChange]:
        self._changes = changes = self._node.create_subscription(DeviceChange, DEVICE_CHANGES, qos_profile=1)
        self._node.create_task(self._watch_directory)
        return changes

    async def _watch_directory(self) -> None:
        """One that was restarted has a new index, and numbers its changes anew."""
        with self._watch:
            is_first = True
            async for service in service_starts(self._node.graph):
                if service == FIND_DEVICES or (service is None and not is_first):
                    self._is_outdated = True
                    if self._changes is not None:
                        self._changes.mailbox.wake()
                is_first = False

    async def _compare(self) -> None:
        """Take a snapshot; the subscription is older, so that no change can fall between."""
        client = self._node.create_client(FindDevices, FIND_DEVICES)
        try:
            found = await self._ask(client)
        finally:
            client.close()
        self._is_outdated = False
        self._ready.extend(self._followed.compare(found.devices, found.sequence))

    async def _ask(self, client: Client[FindDevicesRequest, FindDevicesResponse]) -> FindDevicesResponse:
        while True:
            await client.wait_for_service()
            try:
                return await client.call(self._request)
            except ServiceError as exc:
                if self._limit.allows(NO_ANSWER) is not None:
                    self._node.log.warning(NO_ANSWER, message=f"{exc}; it is asked again")
                await anyio.sleep(_PAUSE)

    async def _give_others_a_turn(self) -> None:
        self._given += 1
        if self._given >= _TURN:
            self._given = 0
            await anyio.lowlevel.checkpoint()
