"""A broker that plays a script: one coroutine for each connection, seen from the broker's side."""

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, Protocol, TypeVar

import anyio
from anyio.abc import SocketAttribute, SocketStream
from tests.patience import PATIENCE

from homebot.mqtt.client import MqttClient
from homebot.mqtt.packets import (
    Connack,
    Connect,
    Disconnect,
    Packet,
    PacketReader,
    Pingreq,
    Properties,
    Puback,
    Publish,
    encode,
)

P = TypeVar("P", bound=Packet)


class MakeClient(Protocol):
    """Makes a client of the scripted broker at *port*."""

    def __call__(self, port: int, *, timeout: float = 60.0, **settings: object) -> MqttClient: ...


class Peer:
    """One connection, seen from the broker."""

    def __init__(self, stream: SocketStream) -> None:
        self._stream = stream
        self._reader = PacketReader()

    async def expect(self, kind: type[P]) -> P:
        packet = await self.next()
        assert isinstance(packet, kind), packet
        return packet

    async def next(self) -> Packet:
        while (packet := self._reader.pop()) is None or isinstance(packet, Pingreq):
            self._reader.feed(await self._stream.receive())
        return packet

    async def send(self, *packets: Packet) -> None:
        await self.send_raw(b"".join(encode(packet, self._reader.version) for packet in packets))

    async def send_raw(self, data: bytes) -> None:
        await self._stream.send(data)

    async def login(self, *, session_present: bool = False, **properties: int) -> Connect:
        self.connect = connect = await self.expect(Connect)
        self._reader.version = connect.version
        granted = Properties(**properties)  # type: ignore[arg-type] # whole numbers only
        await self.send(Connack(session_present=session_present, properties=granted))
        return connect

    async def acknowledge(self, count: int) -> None:
        """Answer the next *count* messages at QoS 1."""
        for _ in range(count):
            await self.send(Puback((await self.expect(Publish)).packet_id or 0))

    async def closed(self) -> None:
        """Wait until the client has closed the connection."""
        try:
            async for _ in self._stream:
                pass
        except anyio.BrokenResourceError:
            return


Script = Callable[[Peer], Awaitable[None]]


@asynccontextmanager
async def broker(*scripts: Script) -> AsyncIterator[int]:
    """A port where the n-th connection meets the n-th script; leaving waits until all are played."""
    left = list(scripts)
    done = anyio.Event()

    async def play(stream: SocketStream) -> None:
        script = left.pop(0)
        async with stream:
            await script(Peer(stream))
        if not left:
            done.set()

    listener = await anyio.create_tcp_listener(local_host="127.0.0.1")
    with anyio.fail_after(PATIENCE):
        async with listener, anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, play)
            yield listener.extra(SocketAttribute.local_port)  # noqa: S610 - no database
            await done.wait()
            tasks.cancel_scope.cancel()


@asynccontextmanager
async def linked(
    make: MakeClient, script: Script | None = None, *, granted: Mapping[str, Any] | None = None, **settings: Any
) -> AsyncIterator[tuple[MqttClient, Peer]]:
    """A client that is logged in, and its broker, which plays the script; at the end the client says good-bye."""
    met: list[Peer] = []
    begun, left = anyio.Event(), anyio.Event()

    async def play(peer: Peer) -> None:
        await peer.login(**granted or {})
        met.append(peer)
        begun.set()
        if script is not None:
            await script(peer)
        await left.wait()
        await peer.expect(Disconnect)

    async with broker(play) as port:
        async with (client := make(port, **settings)).connected():
            await begun.wait()
            yield client, met[0]
        left.set()


async def idle(peer: Peer) -> None:
    """Let the client in, and wait until it says good-bye."""
    await peer.login()
    await peer.expect(Disconnect)
