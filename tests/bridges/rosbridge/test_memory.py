"""Nothing keeps a connection that has ended, but the circles of the library, which the garbage collector finds."""

import gc

import anyio
import pytest
from tests.bridges.conftest import OpenHouse
from tests.patience import until
from websockets.server import ServerProtocol

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.bridges.rosbridge.connection import RosbridgeConnection

SETTINGS = RosbridgeSettings(port=0)


def held(kind: type[object]) -> int:
    gc.collect()
    return sum(type(one) is kind for one in gc.get_objects())


@pytest.mark.parametrize(
    "request_",
    [
        b"GET /api/home HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"POST /api/command HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\r\n{}",
    ],
)
async def test_the_garbage_collector_finds_all_of_a_request_that_is_answered(
    open_house: OpenHouse, request_: bytes
) -> None:
    async with open_house(SETTINGS) as house:
        before = held(RosbridgeConnection), held(ServerProtocol)
        async with await anyio.connect_tcp("127.0.0.1", house.server.port) as stream:
            await stream.send(request_)
            assert (await stream.receive()).startswith(b"HTTP/1.1 ")
        await until(lambda: (held(RosbridgeConnection), held(ServerProtocol)) == before)


async def test_the_garbage_collector_finds_all_of_a_session(open_house: OpenHouse) -> None:
    async with open_house(SETTINGS) as house:
        before = held(RosbridgeConnection), held(ServerProtocol)
        async with house.peer() as peer:
            await peer.send("call_service", id="1", service="/rosapi/get_time")
            assert (await peer.receive())["id"] == "1"
            assert held(ServerProtocol) == before[1] + 1
        await until(lambda: (held(RosbridgeConnection), held(ServerProtocol)) == before)
