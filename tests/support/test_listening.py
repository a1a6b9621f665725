"""A server that stops listening leaves no connection open."""

import asyncio
import socket
from contextlib import closing

import pytest
from anyio.lowlevel import cancel_shielded_checkpoint
from tests.patience import PATIENCE

from homebot.support.listening import stop_accepting


class Greeted(asyncio.Protocol):
    def __init__(self, transports: list[asyncio.BaseTransport]) -> None:
        self._transports = transports

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transports.append(transport)


@pytest.mark.parametrize("turns", range(4))
async def test_a_connection_that_was_just_accepted_reaches_its_protocol_or_is_refused(turns: int) -> None:
    greeted: list[asyncio.BaseTransport] = []
    server = await asyncio.get_running_loop().create_server(lambda: Greeted(greeted), "127.0.0.1", 0)
    with closing(socket.create_connection(server.sockets[0].getsockname())) as client:
        for _ in range(turns):
            await cancel_shielded_checkpoint()
        await stop_accepting(server.sockets)
        server.close()
        for transport in greeted:
            transport.close()
        await server.wait_closed()
        await cancel_shielded_checkpoint()

        client.settimeout(PATIENCE)
        try:
            assert client.recv(1) == b""
        except ConnectionResetError:
            assert not greeted
