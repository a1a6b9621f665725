"""homebot's own page shows its token in its first frame; pages of other origins need one in any case."""

import json
from pathlib import Path
from typing import Any

import anyio
import pytest
from anyio import to_thread
from pydantic import SecretStr
from tests.patience import PATIENCE
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.typing import Origin

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.bridges.rosbridge.first_code import FirstCode
from homebot.bridges.rosbridge.handshake import LOG_IN, token_in
from homebot.bridges.rosbridge.settings import ClientToken
from homebot.clock import ManualClock
from homebot.devices.access_messages import ListTokensRequest
from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.names import APPLY_SCENE
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest
from homebot.support.owner_token import make_owner_token

NEEDS_A_TOKEN = RosbridgeSettings(port=0, token=SecretStr("hunter2"))


def page(port: int, origin: str | None = None) -> connect:
    own = Origin(origin or f"http://127.0.0.1:{port}")
    return connect(f"ws://127.0.0.1:{port}/", origin=own, subprotocols=[LOG_IN], proxy=None)


async def call(connection: ClientConnection, service: str, **args: object) -> dict[str, Any]:
    await connection.send(json.dumps({"op": "call_service", "service": service, "args": args, "id": "1"}))
    with anyio.fail_after(PATIENCE):
        answer: dict[str, Any] = json.loads(await connection.recv())
    return answer


@pytest.mark.parametrize(("settings", "token"), [(NEEDS_A_TOKEN, "hunter2"), (RosbridgeSettings(port=0), "")])
async def test_the_page_reads_with_the_token_that_it_shows_or_without_where_none_is_needed(
    open_house: Any, settings: RosbridgeSettings, token: str
) -> None:
    async with open_house(settings) as house, page(house.server.port) as connection:
        await connection.send(json.dumps({"op": "auth", "token": token}))
        assert (await call(connection, "/rosapi/nodes"))["result"] is True


async def test_a_token_raises_the_rights_of_the_page(open_house: Any) -> None:
    """What anybody at this computer may do is less."""
    owner = ClientToken(token=SecretStr("s3cret"), scope=("read", "manage"))
    async with open_house(RosbridgeSettings(port=0, tokens={"page": owner})) as house:
        results = []
        for token in ("", "s3cret"):
            async with page(house.server.port) as connection:
                await connection.send(json.dumps({"op": "auth", "token": token}))
                results.append(await call(connection, "/rosapi/delete_param"))
    assert "the right manage is missing" in results[0]["values"]
    assert "right" not in results[1]["values"]


@pytest.mark.parametrize("token", ["", "s3cret"])
async def test_a_command_of_the_page_is_a_persons_whatever_its_token(open_house: Any, token: str) -> None:
    seen: list[str] = []

    def apply(request: ApplySceneRequest) -> CommandDevicesResponse:
        seen.append(request.trigger.kind)
        return CommandDevicesResponse(success=True)

    tablet = ClientToken(token=SecretStr("s3cret"), scope=("read", "act: all"))
    async with open_house(RosbridgeSettings(port=0, tokens={"tablet": tablet})) as house:
        house.node("scenes").create_service(ApplyScene, APPLY_SCENE, apply)
        async with page(house.server.port) as connection:
            await connection.send(json.dumps({"op": "auth", "token": token}))
            assert (await call(connection, APPLY_SCENE, name="x"))["result"] is True
    assert seen == [""]


@pytest.mark.parametrize(
    ("frame", "reason"),
    [
        ('{"op": "auth", "token": "wrong"}', "a valid token is needed"),
        ('{"op": "auth", "token": ""}', "a valid token is needed"),
        ('{"op": "subscribe", "topic": "/rosout"}', "the first frame must be an auth"),
        ("hello", "the first frame must be an auth"),
    ],
)
async def test_a_page_without_a_valid_token_is_closed_with_the_reason(open_house: Any, frame: str, reason: str) -> None:
    async with open_house(NEEDS_A_TOKEN) as house, page(house.server.port) as connection:
        await connection.send(frame)
        with anyio.fail_after(PATIENCE), pytest.raises(ConnectionClosed) as caught:
            await connection.recv()
    assert caught.value.rcvd is not None
    assert (caught.value.rcvd.code, caught.value.rcvd.reason) == (1008, reason)


@pytest.mark.parametrize("origin", ["http://localhost:3000", "http://127.0.0.1", "https://evil.example"])
async def test_a_page_of_another_origin_or_port_is_turned_away(open_house: Any, origin: str) -> None:
    """Any program of this computer may serve a page: it neither reads nor commands."""
    async with open_house() as house:
        with pytest.raises(InvalidStatus) as caught:
            async with page(house.server.port, origin):
                pytest.fail("let in")
    assert caught.value.response.status_code == 403


def test_a_token_shows_in_no_error() -> None:
    assert token_in('{"op": "auth", "token": "hunter2", "more": 1}') is None
    assert token_in('{"op": "auth", "token": "hunter2"}') == "hunter2"


async def log_in(port: int, token: str) -> str:
    """Return what becomes of a page that logs in by *token*: ``owner``, ``local``, or the reason of the refusal."""
    async with page(port) as connection:
        await connection.send(json.dumps({"op": "auth", "token": token}))
        try:
            answer = await call(connection, "/rosapi/delete_param")
        except ConnectionClosed as exc:
            return "" if exc.rcvd is None else exc.rcvd.reason
    return "local" if "the right manage is missing" in answer["values"] else "owner"


@pytest.mark.parametrize("why_not", ["", "used", "late", "guessed", "not a page", "another token"])
async def test_a_code_lets_the_first_page_in_once_and_nothing_else(
    open_house: Any, tmp_path: Path, why_not: str
) -> None:
    """A new home has no token that its owner could type in."""
    clock, settings = ManualClock(), RosbridgeSettings(port=0)
    code, owner = FirstCode(clock), await to_thread.run_sync(make_owner_token, tmp_path / "owner.token")
    async with open_house(settings, owner=owner, first_code=code) as house:
        port, secret = house.server.port, code.secret.get_secret_value()
        if why_not == "used":
            assert await log_in(port, secret) == "owner"
        elif why_not == "late":
            clock.advance(15 * 60)
        elif why_not == "guessed":
            for _ in range(20):
                code.count_wrong()
        elif why_not == "another token":
            new = ClientToken(token=SecretStr("s3cret"), scope=("read",))
            house.server.update_tokens(settings.model_copy(update={"tokens": {"screen": new}}))
        elif why_not == "not a page":
            with pytest.raises(InvalidStatus, match="401"):
                await connect(f"ws://127.0.0.1:{port}/?token={secret}", proxy=None)
            assert code.use()
        assert await log_in(port, secret) == ("a valid token is needed" if why_not else "owner")
        assert [one.name for one in house.server.list_tokens(ListTokensRequest()).tokens if "code" in one.name] == []
