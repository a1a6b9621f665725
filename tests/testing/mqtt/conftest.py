"""A client that shows every packet."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.mqtt.packets import Connack, Connect, Packet, PacketReader, ProtocolVersion, encode
from homebot.testing.mqtt import TestBroker


class RawClient:
    """Packets in, packets out."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, version: ProtocolVersion) -> None:
        self._reader, self._writer, self._version = reader, writer, version
        self._packets = PacketReader(version)
        self.unread = b""

    async def send(self, *packets: Packet) -> None:
        self._writer.write(b"".join(encode(packet, self._version) for packet in packets))
        await self._writer.drain()

    async def take(self) -> Packet:
        """The next packet; EOFError where the broker closed instead, ``unread`` is then what a packet began with."""
        with anyio.fail_after(PATIENCE):
            while (packet := self._packets.pop()) is None:
                data = await self._reader.read(65_536)
                if not data:
                    raise EOFError
                self.unread = data
                self._packets.feed(data)
        return packet

    async def call(self, packet: Packet) -> Packet:
        await self.send(packet)
        return await self.take()

    async def close(self) -> None:
        self._writer.close()
        with suppress(OSError):
            await self._writer.wait_closed()


Join = Callable[..., Awaitable[RawClient]]


@pytest.fixture
async def join(mqtt_broker: TestBroker) -> AsyncIterator[Join]:
    """Log a client in at ``mqtt_broker``."""
    clients: list[RawClient] = []

    async def make(client_id: str, version: ProtocolVersion = ProtocolVersion.V5, **more: object) -> RawClient:
        client = RawClient(*await asyncio.open_connection(mqtt_broker.host, mqtt_broker.port), version)
        clients.append(client)
        connack = await client.call(Connect(client_id, version, **more))  # type: ignore[arg-type] # fields of Connect
        assert isinstance(connack, Connack)
        assert not connack.reason.failed
        return client

    yield make
    for client in clients:
        await client.close()
