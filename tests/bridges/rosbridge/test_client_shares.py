"""The places of the door: neither one token nor one address takes all of them, and the owner always comes in."""

from contextlib import AsyncExitStack
from typing import Any

import pytest
from pydantic import SecretStr
from tests.bridges.home_api.test_http_attacks import GET, answer
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.typing import Origin

from homebot.bridges.rosbridge import ClientToken, RosbridgeSettings
from homebot.bridges.rosbridge.handshake import LOG_IN

TOKENS = {
    "panel": ClientToken(token=SecretStr("panel"), scope=("read",)),
    "phone": ClientToken(token=SecretStr("phone"), scope=("read",)),
    "hub": ClientToken(token=SecretStr("hub"), scope=("read", "manage")),
}
LOCKED = RosbridgeSettings(port=0, token=SecretStr("owner"), tokens=TOKENS)


async def come_in(stack: AsyncExitStack, house: Any, token: str, address: str = "127.0.0.1") -> ClientConnection:
    url, headers = f"ws://127.0.0.1:{house.server.port}", {"Authorization": f"Bearer {token}"}
    client = connect(url, additional_headers=headers, local_addr=(address, 0), proxy=None, compression=None)
    return await stack.enter_async_context(client)


async def fill(stack: AsyncExitStack, house: Any, token: str, address: str = "127.0.0.1") -> str:
    """Connect until the door refuses; return why."""
    while True:
        try:
            await come_in(stack, house, token, address)
        except InvalidStatus as exc:
            return f"{exc.response.status_code}: {(exc.response.body or b'').decode().strip()}"


async def test_idle_connections_of_one_token_lock_nobody_out(open_house: Any) -> None:
    async with open_house(LOCKED) as house, AsyncExitStack() as stack:
        problem = "503: too many clients with the token panel are connected from this address"
        assert await fill(stack, house, "panel") == problem
        assert house.server.client_count == 48
        for token in ("phone", "owner"):
            told = await answer(house, f"{GET}Authorization: Bearer {token}\r\n\r\n")
            assert "service /discovery/list has no server now" in told[1]  # it came through: this house has none
            await come_in(stack, house, token)
        await come_in(stack, house, "panel", "127.0.0.2")


async def test_two_places_are_kept_for_who_manages_homebot(open_house: Any) -> None:
    async with open_house(LOCKED) as house, AsyncExitStack() as stack:
        await fill(stack, house, "panel")
        assert await fill(stack, house, "phone", "127.0.0.2") == "503: too many clients are connected"
        assert house.server.client_count == 62
        await come_in(stack, house, "hub")
        last = await come_in(stack, house, "owner")
        assert await fill(stack, house, "owner") == "503: too many clients are connected"
        await last.close()
        await come_in(stack, house, "owner")


async def test_the_page_is_served_and_logs_in_while_all_other_places_are_taken(open_house: Any) -> None:
    """Its token is in its first frame, so it is a client only then."""
    async with open_house(LOCKED) as house, AsyncExitStack() as stack:
        await fill(stack, house, "panel")
        await fill(stack, house, "phone", "127.0.0.2")
        url, origin = f"ws://127.0.0.1:{house.server.port}", f"http://127.0.0.1:{house.server.port}"
        for token in ("owner", "phone"):
            page = await stack.enter_async_context(
                connect(url, origin=Origin(origin), subprotocols=[LOG_IN], proxy=None, compression=None)
            )
            await page.send(f'{{"op": "auth", "token": "{token}"}}')
            await page.send('{"op": "call_service", "id": "a", "service": "/rosapi/get_time"}')
            if token == "owner":
                assert '"result":true' in str(await page.recv()).replace(" ", "")
                continue
            with pytest.raises(ConnectionClosed, match="too many clients are connected"):
                await page.recv()
