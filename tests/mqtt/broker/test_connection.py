"""What the broker asks of TCP."""

import asyncio
import socket

import pytest

from homebot.clock import ManualClock
from homebot.mqtt.broker import BrokerLimits, BrokerState
from homebot.mqtt.broker.connection import BrokerConnection, Sockets
from homebot.mqtt.packets import Connect, Packet, Pingreq, ProtocolVersion, Publish, encode


class FakeSocket:
    family = socket.AF_INET

    def __init__(self) -> None:
        self.asked: list[int] = []

    def setsockopt(self, _level: int, option: int, _value: int) -> None:
        self.asked.append(option)


class FakeTransport(asyncio.Transport):
    def __init__(self) -> None:
        super().__init__({"socket": FakeSocket(), "peername": ("127.0.0.1", 50_000)})
        self.written = b""

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None: ...

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.written += data

    def close(self) -> None: ...

    def get_write_buffer_size(self) -> int:
        return 0


class Wire:
    """A logged-in client on the far side of a connection."""

    def __init__(self) -> None:
        self.transport = FakeTransport()
        self.tcp: FakeSocket = self.transport.get_extra_info("socket")
        self._connection = BrokerConnection(
            BrokerState(ManualClock(), BrokerLimits()), asyncio.get_running_loop(), Sockets(1_000_000)
        )
        self._connection.connection_made(self.transport)

    async def send(self, packet: Packet) -> None:
        data = encode(packet, ProtocolVersion.V311)
        self._connection.get_buffer(-1)[: len(data)] = data
        self._connection.buffer_updated(len(data))
        await asyncio.sleep(0)  # what is written in one turn leaves at its end


@pytest.fixture
async def wire() -> Wire:
    wire = Wire()
    await wire.send(Connect("a", ProtocolVersion.V311))
    return wire


async def test_no_packet_of_the_broker_waits_for_another_to_be_acknowledged(wire: Wire) -> None:
    assert wire.tcp.asked[0] == socket.TCP_NODELAY


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="Linux has it")
async def test_tcp_acknowledges_at_once_what_gets_no_answer(wire: Wire) -> None:
    wire.tcp.asked.clear()
    await wire.send(Publish("t", b"on"))
    assert wire.tcp.asked == [socket.TCP_QUICKACK]


async def test_an_answer_is_left_to_carry_the_acknowledgement_of_tcp(wire: Wire) -> None:
    wire.tcp.asked.clear()
    await wire.send(Pingreq())
    assert wire.transport.written.endswith(b"\xd0\x00")
    assert wire.tcp.asked == []
