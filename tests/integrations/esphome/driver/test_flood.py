"""A device that sends tiny frames without end: how much of that is handled before other tasks have their turn."""

from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import anyio.lowlevel
import pytest
from anyio.abc import SocketStream
from tests.integrations.esphome.driver.served import living, service_of, simulated

from homebot.conventions.entity_rows import Fields
from homebot.errors import WireError
from homebot.integrations.esphome.driver.connection import EsphomeConnection, connected
from homebot.support.isolation import first_cause

PADDED_PING = b"\0\xeb\x07\7" + b"\x7a\xe8\x07" + bytes(1000)
"""A ping with a field that nobody knows: 66 of them a second are too many, which the slowest machine can receive."""

STATE = b"\0\0\x15"
"""The state of a binary sensor that says nothing: the smallest frame that is handed on."""

COUNT = 100_000
MOST_AT_ONCE = 8_192
"""States in one turn: of 3 bytes each, what Linux keeps where it is told to keep 8 KiB, and some more."""


class Injector:
    """What stands between device and homebot, and sends a flood in the name of the device."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._client: SocketStream | None = None

    async def serve(self, client: SocketStream) -> None:
        async with (
            client,
            await anyio.connect_tcp("127.0.0.1", self._port) as device,
            anyio.create_task_group() as tasks,
        ):
            self._client = client
            tasks.start_soon(self._forward, device, client)
            await self._forward(client, device)

    async def flood(self, data: bytes, *, is_endless: bool = False) -> None:
        """Send *data*, or what of it can be sent; if endless, again and again until the connection is closed."""
        assert self._client is not None
        try:
            await self._client.send(data)
            while is_endless:
                await self._client.send(data)
        except (anyio.BrokenResourceError, anyio.ClosedResourceError):
            return

    async def _forward(self, source: SocketStream, target: SocketStream) -> None:
        try:
            async for data in source:
                await target.send(data)
        except (anyio.BrokenResourceError, anyio.ClosedResourceError):
            return


@asynccontextmanager
async def connected_through_injector() -> AsyncIterator[tuple[EsphomeConnection, Injector]]:
    """A connection on which a flood can be sent, to a device that is described already."""
    device = simulated("lamp", [])
    async with living(device), await anyio.create_tcp_listener(local_host="127.0.0.1") as listener:
        injector = Injector(device.port)
        service = service_of(device)
        port: int = listener.extra(anyio.abc.SocketAttribute.local_port)  # noqa: S610 - no Django
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, injector.serve)
            try:
                async with connected(service.name, service.addresses, port, None, None) as connection:
                    await connection.describe()
                    yield connection, injector
            finally:
                tasks.cancel_scope.cancel()


async def test_tiny_frames_leave_other_tasks_their_turn() -> None:
    taken: Counter[int] = Counter()
    turns, all_taken = 0, anyio.Event()

    def take(kind: str, state: Fields) -> None:
        del state
        if kind == "binary_sensor":
            taken[turns] += 1
            if taken.total() == COUNT:
                all_taken.set()

    async def count_turns() -> None:
        nonlocal turns
        while True:
            await anyio.lowlevel.checkpoint()
            turns += 1

    async with connected_through_injector() as (connection, injector), anyio.create_task_group() as tasks:
        connection.subscribe(take)
        tasks.start_soon(count_turns)
        tasks.start_soon(injector.flood, STATE * COUNT)
        await all_taken.wait()
        tasks.cancel_scope.cancel()
    assert max(taken.values()) <= MOST_AT_ONCE


async def test_a_flood_ends_the_connection_and_a_person_hears_of_it() -> None:
    """Each ping is answered: to one who reads no answers, they would pile up."""

    async def flooded() -> None:
        async with connected_through_injector() as (connection, injector):
            await injector.flood(PADDED_PING * 100, is_endless=True)
            await connection.lost.wait()

    with pytest.raises(BaseExceptionGroup) as caught:
        await flooded()
    cause = first_cause(caught.value)
    assert isinstance(cause, WireError)
    assert "sends more than 65,536 bytes each second" in str(cause)
