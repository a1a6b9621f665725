"""Bytes of incomplete frames: whoever holds too many is cut off, and all others go on."""

import json

import anyio
import pytest
from pydantic import SecretStr
from tests.bridges.conftest import OpenHouse, Peer
from tests.patience import PATIENCE, until
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed
from websockets.frames import Frame, Opcode

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.bridges.rosbridge.handshake import LOG_IN

SETTINGS = RosbridgeSettings(port=0, max_arriving_bytes_of_all=100_000)


def begin(peer: Peer, size: int, opcode: Opcode = Opcode.TEXT, *, is_end: bool = False) -> None:
    """Send a frame that does not end its message."""
    peer.connection.transport.write(Frame(opcode, b"x" * size, is_end).serialize(mask=True))


async def test_the_client_with_the_most_bytes_is_cut_off(open_house: OpenHouse) -> None:
    async with open_house(SETTINGS) as house, house.peer() as small, house.peer() as large:
        begin(small, 30_000)
        begin(large, 60_000)
        await until(lambda: house.server._pending._account.used > 90_000)  # with the heads of the frames
        async with house.peer() as honest:
            await honest.send("call_service", id="1", service="/rosapi/get_time", args={"text": "x" * 40_000})
            assert (await honest.receive())["id"] == "1"
            with anyio.fail_after(PATIENCE), pytest.raises(ConnectionClosed, match="too many bytes"):
                await large.connection.recv()
            await until(lambda: house.server.client_count == 2)


async def test_what_was_handled_no_longer_counts(open_house: OpenHouse) -> None:
    async with open_house(SETTINGS) as house, house.peer() as peer:
        for _ in range(4):
            await peer.tell("set_level", level="none", text="x" * 60_000)
            begin(peer, 100, Opcode.PING, is_end=True)
        account = house.server._pending._account
        assert account.used == 0
    assert account.used == 0


async def test_a_page_that_has_not_logged_in_may_send_little(open_house: OpenHouse) -> None:
    async with (
        open_house(RosbridgeSettings(port=0, token=SecretStr("hunter2"))) as house,
        connect(
            f"ws://127.0.0.1:{house.server.port}",
            origin=f"http://127.0.0.1:{house.server.port}",  # type: ignore[arg-type]
            subprotocols=[LOG_IN],
            proxy=None,
        ) as page,
    ):
        await page.send(json.dumps({"op": "auth", "token": "x" * 200_000}))
        with anyio.fail_after(PATIENCE), pytest.raises(ConnectionClosed, match="too many bytes"):
            await page.recv()
