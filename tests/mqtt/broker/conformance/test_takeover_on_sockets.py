"""Sessions taken over on real sockets: whatever the old connection is up to, the new one is let in."""

import socket
import struct
from contextlib import ExitStack

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.mqtt.broker import Broker
from homebot.mqtt.packets import Connack, Connect, ProtocolVersion, encode

_RESET_ON_CLOSE = struct.pack("ii", 1, 0)  # SO_LINGER: on, for 0 seconds


@pytest.mark.parametrize("version", ProtocolVersion)
async def test_a_session_is_taken_over_from_a_connection_reset_in_the_same_moment(version: ProtocolVersion) -> None:
    connect = encode(Connect("a", version), version)
    welcome = encode(Connack(), version)[:1]
    with ExitStack() as sockets:
        async with Broker() as broker:
            old, new = (sockets.enter_context(_dial(broker)) for _ in range(2))
            old.send(connect)
            assert (await _receive(old))[:1] == welcome
            # The broker hears of both in one turn of its loop, of the login first.
            new.send(connect)
            old.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET_ON_CLOSE)
            old.close()
            assert (await _receive(new))[:1] == welcome
            assert broker.stats.clients == 1


def _dial(broker: Broker) -> socket.socket:
    connection = socket.create_connection((broker.host, broker.port))
    connection.setblocking(False)
    return connection


async def _receive(connection: socket.socket) -> bytes:
    with anyio.fail_after(PATIENCE):
        await anyio.wait_readable(connection)
    return connection.recv(1024)
