"""Tokens end, and the door tells when each was last shown."""

import json
from typing import Any

import anyio
import pytest
from pydantic import SecretStr
from tests.patience import PATIENCE
from websockets.exceptions import ConnectionClosed, InvalidStatus

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.bridges.rosbridge.settings import ClientToken
from homebot.clock import ManualClock
from homebot.devices.access_messages import ListedToken, ListTokensRequest

NOW = 1_800_000_000.0


def settings(until: float, *more: str) -> RosbridgeSettings:
    guest = ClientToken(token=SecretStr("guest-secret"), scope=("read",), until=until)
    others = {name: ClientToken(token=SecretStr(name), scope=("read",)) for name in more}
    return RosbridgeSettings(port=0, token=SecretStr("hunter2"), tokens={"guest": guest, **others})


async def test_a_token_counts_until_its_end_and_then_the_answer_says_so(open_house: Any) -> None:
    clock = ManualClock(NOW)
    async with open_house(settings(NOW + 60), clock=clock) as house:
        async with house.peer(Authorization="Bearer guest-secret") as guest:
            await guest.settle()
        clock.advance(60)
        with pytest.raises(InvalidStatus) as caught:
            async with house.peer(Authorization="Bearer guest-secret"):
                pytest.fail("let in")
        async with house.peer(Authorization="Bearer hunter2") as owner:
            await owner.settle()
    assert caught.value.response.status_code == 401
    assert caught.value.response.body == (
        b"the token has ended; change until in [door.tokens.guest], or make another\n"
    )


@pytest.mark.virtual_time
async def test_a_client_is_connected_no_longer_than_its_token_lasts(open_house: Any) -> None:
    async with open_house(settings(0.0)) as house:
        now = house.graph.clock.now()
        house.server.update_tokens(settings(now + 3600))
        async with house.peer(Authorization="Bearer guest-secret") as guest:
            with anyio.fail_after(3600 + PATIENCE), pytest.raises(ConnectionClosed) as caught:
                await guest.connection.recv()
        assert house.graph.clock.now() - now == pytest.approx(3600, abs=5)
    assert caught.value.rcvd is not None
    assert caught.value.rcvd.reason == "its token has ended"


async def test_an_earlier_end_disconnects_who_is_there(open_house: Any) -> None:
    async with open_house(settings(NOW * 2)) as house, house.peer(Authorization="Bearer guest-secret") as guest:
        await guest.settle()
        house.server.update_tokens(settings(NOW * 1.5))
        with anyio.fail_after(PATIENCE), pytest.raises(ConnectionClosed):
            await guest.connection.recv()


async def test_the_door_knows_when_each_token_was_last_shown_and_no_secret(open_house: Any) -> None:
    clock = ManualClock(NOW)
    async with open_house(settings(NOW + 60, "panel"), clock=clock) as house:
        async with house.peer(Authorization="Bearer guest-secret") as guest:
            await guest.settle()
        clock.advance(5)
        async with house.peer(Authorization="Bearer hunter2") as owner:
            await owner.settle()
            listed = house.server.list_tokens(ListTokensRequest())
        house.server.update_tokens(settings(NOW + 60))
        rest = house.server.list_tokens(ListTokensRequest()).tokens
    told: dict[str, ListedToken] = {one.name: one for one in listed.tokens}
    assert {name: one.used_at.sec for name, one in told.items()} == {"owner": NOW + 5, "guest": NOW, "panel": 0}
    assert {name: one.is_connected for name, one in told.items()} == {"owner": True, "guest": False, "panel": False}
    assert (told["guest"].until, told["panel"].until, told["owner"].scope) == (NOW + 60, 0.0, ())
    assert listed.since.sec == NOW
    assert [one.name for one in rest] == ["owner", "guest"]
    assert "hunter2" not in json.dumps(listed.model_dump(mode="json"))
