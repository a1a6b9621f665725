"""A live query: the devices that match now, and then every change of them."""

from __future__ import annotations

from collections import OrderedDict, deque
from typing import Self

import anyio
import anyio.lowlevel

from homebot.devices.device import DeviceChange, StateChange
from homebot.devices.live_query_state import LiveQueryState
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, DIRECTORY_NODE, FIND_DEVICES
from homebot.devices.query import And, Query, type_is
from homebot.devices.services import FindDevices, FindDevicesRequest, FindDevicesResponse
from homebot.errors import ClosedError, ServiceError
from homebot.graph import Client, Node, Subscription
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.log import LogLimit

__all__ = ["Follow"]

NO_ANSWER = "devices.no_answer"

_TURN = 100
"""Changes given out before other tasks get their turn, should the reader never wait."""

_MAX_STATES = 10_000
"""Values that may wait for a slow reader; beyond them it takes a new snapshot instead."""

_PAUSE = 0.5
"""Seconds until a directory that fails to answer is asked again."""


class Follow:
    """A live query for devices: ``async for change in Follow(node, "lights")``.

    Devices that are there already are reported at once. Of each device ``appeared`` comes first and ``removed`` last. A
    reader that falls behind misses intermediate changes of a device, never the last one. The query waits for a
    directory that is not running yet; after a restart of the directory it yields the differences. Only one task may
    read.

    Args:
        node: The node that asks; the query ends with it.
        service_type: For example ``lights``; empty for every device. A device that no longer has it is ``removed``.
        query: A further condition, also as text, for example ``on lights in kitchen``: a device that comes to match
            ``appeared``, one that no longer does is ``removed``. See :mod:`homebot.devices.query`.

    Raises:
        UsageError: The query cannot be parsed.
    """

    def __init__(self, node: Node, service_type: str = "", query: str | Query = "") -> None:
        self._node = node
        terms: list[Query] = [type_is(service_type)] if service_type else []
        if query:
            terms.append(_parsed(query) if isinstance(query, str) else query)
        self._state = LiveQueryState(terms[0] if len(terms) == 1 else And(tuple(terms)))
        self._request = FindDevicesRequest(service_type=service_type)
        self._changes: Subscription[DeviceChange] | None = None
        self._states: Subscription[StateChange] | None = None
        self._new_states: OrderedDict[str, StateChange] = OrderedDict()
        self._ready: deque[DeviceChange] = deque()
        self._is_outdated = True
        self._watch = anyio.CancelScope()
        self._turns = 0
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
            change = await self._next(self._changes or self._begin())
        except ClosedError:
            raise StopAsyncIteration from None
        CURRENT_CAUSE.set(change)
        return change

    def close(self) -> None:
        """End the query. Twice is fine."""
        self._is_closed = True
        self._watch.cancel()
        if self._changes is not None:
            self._changes.close()
        if self._states is not None:
            self._states.close()

    async def _next(self, changes: Subscription[DeviceChange]) -> DeviceChange:
        while not self._is_closed:
            await self._yield_sometimes()
            if self._is_outdated:
                await self._compare()
            elif self._ready:
                return self._ready.popleft()
            elif (change := changes.take()) is not None:
                shown = self._state.take(change)
                if shown is not None:
                    return shown
            elif self._new_states:
                shown = self._state.take_state(self._new_states.popitem(last=False)[1])
                if shown is not None:
                    return shown
            else:
                await changes.mailbox.wait()
        raise ClosedError("the query is closed")

    def _begin(self) -> Subscription[DeviceChange]:
        self._changes = changes = self._node.create_subscription(
            DeviceChange, DEVICE_CHANGES, qos_profile=1, from_node=DIRECTORY_NODE
        )
        if self._state.wants_states:
            self._states = self._node.create_subscription(
                StateChange, DEVICE_STATES, self._note_state, 1, from_node=DIRECTORY_NODE
            )
        self._node.create_task(self._watch_directory)
        return changes

    def _note_state(self, change: StateChange) -> None:
        """Note a state; the newest of each waits until all changes of devices from before it are read."""
        self._new_states[change.stream] = change
        self._new_states.move_to_end(change.stream)
        if len(self._new_states) > _MAX_STATES:
            self._new_states.clear()
            self._is_outdated = True
        if self._changes is not None:
            self._changes.mailbox.wake()

    async def _watch_directory(self) -> None:
        """Watch for a directory that was restarted: it has a new index, and numbers its changes anew."""
        with self._watch:
            is_first = True
            async for service in self._node.graph.watch_services():
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
        self._ready.extend(self._state.compare(found.devices, found.sequence))

    async def _ask(self, client: Client[FindDevicesRequest, FindDevicesResponse]) -> FindDevicesResponse:
        while True:
            await client.wait_for_service()
            try:
                return await client.call(self._request)
            except ServiceError as exc:
                if self._limit.allows(NO_ANSWER) is not None:
                    self._node.log.warning(NO_ANSWER, message=f"{exc}; trying again")
                await anyio.sleep(_PAUSE)

    async def _yield_sometimes(self) -> None:
        self._turns += 1
        if self._turns >= _TURN:
            self._turns = 0
            await anyio.lowlevel.checkpoint()


def _parsed(text: str) -> Query:
    from homebot.devices.query.parse import parse_query  # noqa: PLC0415 - most apps ask for handles, not by text

    return parse_query(text)
