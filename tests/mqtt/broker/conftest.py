"""A broker without sockets on a clock that is moved by hand, with clients in memory; and clients on real sockets."""

import asyncio
import ssl
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from typing import TypeVar

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.clock import ManualClock
from homebot.mqtt import packets as mqtt
from homebot.mqtt.broker import Broker, BrokerLimits, BrokerPolicy, BrokerState, Peer
from homebot.mqtt.broker.authentication import Authentication
from homebot.mqtt.broker.deadlines import BrokerTimers
from homebot.mqtt.broker.retained import Owed, Replay, RetainedMessages
from homebot.mqtt.broker.session_subscription import SessionSubscription
from homebot.support.turn_budget import TurnBudget
from homebot.testing.mqtt import TestBroker

Kind = TypeVar("Kind")


class WorkClock:
    """A clock that is moved by hand, and goes on while the processor works.

    Args:
        slowness: Times longer that a slow computer takes.
    """

    def __init__(self, start: float = 0.0, slowness: float = 1.0) -> None:
        self._slowness = slowness
        self._moved = start

    def monotonic(self) -> float:
        """Return the seconds that passed and those that were worked."""
        return self._moved + self._slowness * time.thread_time()

    def now(self) -> float:
        """Return seconds since the Unix epoch."""
        return self.monotonic()

    def advance(self, seconds: float) -> None:
        """Move it forward."""
        self._moved += seconds


def owed(retained: RetainedMessages, *filters: str) -> list[Owed]:
    """What new subscriptions to *filters* get, with pauses wherever the broker makes one."""
    clock, deadlines = WorkClock(), BrokerTimers()
    turn = TurnBudget(clock.monotonic, lambda call: deadlines.at(0.0, call))
    replay = Replay(retained, lambda _: True)
    for name in filters:
        replay.add(SessionSubscription(name, name, 0))
    replay.complete = True
    found = []
    while not replay.is_over:
        first = replay.first(turn, 0.0)
        if first is None:
            deadlines.run(1.0)
        else:
            replay.popleft()
            found.append(first)
    return found


class MemoryLink:
    """Fills the broker's link port with a buffer."""

    def __init__(self) -> None:
        self.write_blocked = False
        self.address = "memory"
        self.last = b""
        self.written = bytearray()
        self.reading = True
        self.closed = False
        self.lingers = False

    def write(self, data: bytes) -> None:
        if not self.closed:
            self.last = data
            self.written += data

    def pause_reading(self) -> None:
        self.reading = False

    def resume_reading(self) -> None:
        self.reading = True

    def close(self, *, linger: bool) -> None:
        self.closed = True
        self.lingers = linger


class MemoryClient:
    """One client of a broker: packets in, packets out."""

    def __init__(self, state: BrokerState, version: mqtt.ProtocolVersion = mqtt.ProtocolVersion.V5) -> None:
        self.state = state
        self.link = MemoryLink()
        self.peer = Peer(state, self.link)
        self.version = version
        self._reader = mqtt.PacketReader(version)

    def send(self, *packets: mqtt.Packet) -> None:
        """Send all in one piece, then let the broker do what is due."""
        self.send_bytes(b"".join(mqtt.encode(packet, self.version) for packet in packets))

    def send_bytes(self, data: bytes) -> None:
        self.peer.receive(data)
        self.state.deadlines.run(self.state.clock.monotonic())

    def take(self) -> list[mqtt.Packet]:
        """All packets received since the last call."""
        data = bytes(self.link.written)
        self.link.written.clear()
        return list(self._reader.feed(data))

    def take_only(self, kind: type[Kind]) -> list[Kind]:
        """The packets of one kind among those received since the last call."""
        return [packet for packet in self.take() if isinstance(packet, kind)]

    def lose(self) -> None:
        """Cut the connection."""
        self.link.closed = True
        self.peer.lost()

    def leave(
        self, reason: mqtt.ReasonCode = mqtt.ReasonCode.SUCCESS, properties: mqtt.Properties = mqtt.NO_PROPERTIES
    ) -> None:
        """Disconnect as one should."""
        self.send(mqtt.Disconnect(reason, properties))
        self.peer.lost()

    def subscribe(
        self, *requests: mqtt.MqttSubscription | str, qos: int = 2, identifier: int | None = None
    ) -> tuple[mqtt.ReasonCode, ...]:
        """Subscribe and return the reasons; what else came stays out."""
        filters = tuple(mqtt.MqttSubscription(each, qos) if isinstance(each, str) else each for each in requests)
        properties = mqtt.NO_PROPERTIES
        if identifier is not None:
            properties = mqtt.Properties(subscription_identifiers=(identifier,))
        written = bytes(self.link.written)
        self.link.written.clear()
        self.send(mqtt.Subscribe(1, filters, properties))
        suback, *rest = self.take()
        assert isinstance(suback, mqtt.Suback)
        self.link.written += written + b"".join(mqtt.encode(packet, self.version) for packet in rest)
        return suback.reasons

    def publish(
        self, topic: str, payload: bytes = b"x", qos: int = 0, packet_id: int | None = None, **more: object
    ) -> None:
        """Publish; QoS 1 and 2 need a packet id."""
        self.send(mqtt.Publish(topic, payload, qos, packet_id=packet_id)._replace(**more))  # type: ignore[arg-type] # fields of Publish

    def messages(self) -> list[mqtt.Publish]:
        """The messages received since the last call; nothing is acknowledged."""
        return self.take_only(mqtt.Publish)

    def acknowledge(self, *messages: mqtt.Publish) -> None:
        """Send PUBACK or PUBREC for each."""
        for message in messages:
            assert message.packet_id is not None
            self.send(mqtt.Puback(message.packet_id) if message.qos == 1 else mqtt.Pubrec(message.packet_id))


NewState = Callable[..., BrokerState]
Join = Callable[..., MemoryClient]
Stranger = Callable[..., MemoryClient]
PassTime = Callable[[float], None]


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture
def new_state(clock: ManualClock) -> NewState:
    """Make a broker with other limits, passwords or policies."""

    def make(
        *,
        credentials: dict[str, str] | None = None,
        policy: BrokerPolicy | None = None,
        keep_alive: int | None = None,
        **limits: int,
    ) -> BrokerState:
        return BrokerState(clock, BrokerLimits(**limits), Authentication(credentials), policy, keep_alive)

    return make


@pytest.fixture
def state(new_state: NewState) -> BrokerState:
    return new_state()


@pytest.fixture
def stranger(state: BrokerState) -> Stranger:
    """A connection that has not sent CONNECT."""

    def make(version: mqtt.ProtocolVersion = mqtt.ProtocolVersion.V5, at: BrokerState | None = None) -> MemoryClient:
        return MemoryClient(at or state, version)

    return make


@pytest.fixture
def join(state: BrokerState) -> Join:
    """Log a client in, and subscribe *to* a filter; the answers are checked and taken."""

    def make(
        client_id: str = "a",
        *,
        version: mqtt.ProtocolVersion = mqtt.ProtocolVersion.V5,
        at: BrokerState | None = None,
        clean: bool = True,
        keep_alive: int = 0,
        will: mqtt.Will | None = None,
        present: bool = False,
        to: str = "",
        **properties: object,
    ) -> MemoryClient:
        client = MemoryClient(at or state, version)
        wanted = mqtt.Properties(**properties) if properties else mqtt.NO_PROPERTIES  # type: ignore[arg-type] # names of properties
        client.send(mqtt.Connect(client_id, version, clean, keep_alive, will=will, properties=wanted))
        first, *rest = client.take()
        assert isinstance(first, mqtt.Connack)
        assert (first.reason, first.session_present) == (mqtt.ReasonCode.SUCCESS, present)
        client.link.written += b"".join(mqtt.encode(packet, version) for packet in rest)
        if to:
            client.subscribe(to)
        return client

    return make


@pytest.fixture
def pass_time(clock: ManualClock, state: BrokerState) -> PassTime:
    """Move the clock and let the broker do what is due."""

    def move(seconds: float) -> None:
        clock.advance(seconds)
        state.deadlines.run(clock.monotonic())

    return move


class WireClient:
    """A client on a real socket: packets in, packets out; ``unread`` is what came last, such as half a packet."""

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, version: mqtt.ProtocolVersion
    ) -> None:
        self.reader, self.writer, self.version = reader, writer, version
        self._packets = mqtt.PacketReader(version)
        self.unread = b""

    async def send(self, *packets: mqtt.Packet) -> None:
        await self.send_bytes(b"".join(mqtt.encode(packet, self.version) for packet in packets))

    async def send_bytes(self, data: bytes) -> None:
        self.writer.write(data)
        await self.writer.drain()

    async def take(self) -> mqtt.Packet:
        """The next packet; EOFError where the broker closed instead."""
        with anyio.fail_after(PATIENCE):
            while (packet := self._packets.pop()) is None:
                data = await self.reader.read(65_536)
                if not data:
                    raise EOFError
                self.unread = data
                self._packets.feed(data)
        return packet

    async def call(self, packet: mqtt.Packet) -> mqtt.Packet:
        """Send one packet and return the next that comes."""
        await self.send(packet)
        return await self.take()

    async def rest(self) -> list[mqtt.Packet]:
        """All packets until the broker closes."""
        packets = []
        while True:
            try:
                packets.append(await self.take())
            except EOFError:
                return packets

    async def close(self) -> None:
        self.writer.close()
        with suppress(OSError):
            await self.writer.wait_closed()


Dial = Callable[..., Awaitable[WireClient]]


@pytest.fixture
async def dial() -> AsyncIterator[Dial]:
    """See :func:`dialled`."""
    async with dialled() as make:
        yield make


@asynccontextmanager
async def dialled() -> AsyncIterator[Dial]:
    """Open a socket to a broker; logged in unless ``client_id`` is None. All are closed after the block."""
    clients: list[WireClient] = []

    async def make(
        broker: Broker | TestBroker,
        client_id: str | None = "a",
        version: mqtt.ProtocolVersion = mqtt.ProtocolVersion.V5,
        *,
        context: ssl.SSLContext | None = None,
        limit: int = 65_536,
        **more: object,
    ) -> WireClient:
        streams = await asyncio.open_connection(broker.host, broker.port, ssl=context, limit=limit)
        client = WireClient(*streams, version)
        clients.append(client)
        if client_id is not None:
            connack = await client.call(mqtt.Connect(client_id, version, **more))  # type: ignore[arg-type] # fields of Connect
            assert isinstance(connack, mqtt.Connack)
            assert not connack.reason.failed
        return client

    yield make
    for client in clients:
        await client.close()
