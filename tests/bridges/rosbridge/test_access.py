"""What clients of the door may do, by their token: over a real WebSocket."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import aiohttp
import anyio
import pytest
from pydantic import SecretStr, ValidationError
from structlog.testing import capture_logs
from tests.bridges.conftest import Peer
from tests.patience import PATIENCE
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus
from websockets.typing import Origin

from homebot.bridges.rosbridge import ClientToken, RosbridgeSettings
from homebot.bridges.rosbridge.access import ClientAccess, right_to_publish
from homebot.devices import RawCommand
from homebot.devices.access_messages import AccessRefused
from homebot.devices.client_rights import ALL_RIGHTS, LOCAL_RIGHTS
from homebot.devices.command_messages import (
    CommandDevicesRequest,
    CommandDevicesResponse,
    CommandRequest,
    PerformCommand,
)
from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.health import HealthRequest
from homebot.devices.names import ACCESS_REFUSALS, APPLY_SCENE, PERFORM_COMMAND
from homebot.devices.outcomes import Confirmed, Evidence, Outcome
from homebot.devices.own_services import right_to_call
from homebot.devices.robot_owners import RobotOwners
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest
from homebot.devices.services import SubscribeToTopicRequest
from homebot.messages import String
from homebot.messages.interfaces import find_message
from homebot.messages.std_srvs import SuccessResponse, Trigger
from homebot.rights import Right
from homebot.words.rights import read_scope

OUT = "/gateway/mqtt/out"
RAW_COMMAND = {"address": "home/locks/front/in", "payload": "unlock", "issuer": "/light_service"}
COMMAND = {
    "device": "locks/front",
    "part": "",
    "settings": [{"capability": "lock", "value": {"type": 3, "text": "unlocked"}}],
    "issuer": "client:owner",
    "scope": ["act: all"],
}


def settings(*scope: str, **fields: Any) -> RosbridgeSettings:
    """A door with the token ``robot-secret``, whose name is ``robot``, and what else is given."""
    robot = ClientToken(token=SecretStr("robot-secret"), scope=scope)
    return RosbridgeSettings(port=0, tokens={"robot": robot}, **fields)


@asynccontextmanager
async def robot(open_house: Any, *scope: str) -> AsyncIterator[tuple[Any, Any]]:
    """A house, and a client with a token of this scope."""
    async with open_house(settings(*scope)) as house, house.peer(Authorization="Bearer robot-secret") as peer:
        yield house, peer


async def refusal(peer: Any, op: str, **fields: object) -> str:
    """What the client is told when it asks for what it may not."""
    await peer.send(op, id="asked", **fields)
    frame = await peer.receive()
    assert (frame["op"], frame["level"], frame["id"]) == ("status", "error", "asked")
    return str(frame["msg"])


@pytest.mark.parametrize(
    ("topic", "ros_type"),
    [
        (OUT, "homebot/msg/RawCommand"),
        ("gateway/mqtt/out", "homebot/msg/RawCommand"),
        ("~/refusals", "homebot/msg/AccessRefused"),
        ("/gateway/mqtt/received_topics", "homebot/msg/Sighting"),
        ("/gateway/mqtt/readings", "homebot/msg/Report"),
        ("/gateway/mqtt/state", "homebot/msg/GatewayState"),
        ("/gateway/mqtt/offer_commands", "homebot/msg/Command"),
        ("/discovery/changes", "homebot/msg/DeviceChange"),
        ("/discovery/states", "homebot/msg/StateChange"),
        ("/control/events", "homebot/msg/CommandEvent"),
        ("/network_services", "homebot/msg/NetworkService"),
        ("/rosout", "rcl_interfaces/msg/Log"),
        ("/parameter_events", "rcl_interfaces/msg/ParameterEvent"),
        ("/gateway/mqtt/received_data/lamp", "homebot/msg/RawMessage"),
        ("/light_service/inbox", "homebot/msg/RawMessage"),
    ],
)
async def test_a_client_without_the_right_raw_publishes_on_no_topic_of_homebot(
    open_house: Any, topic: str, ros_type: str
) -> None:
    """It can neither command behind the control layer nor forge a sighting, a reading or an event."""
    async with open_house() as house, house.peer() as peer:
        before = house.entities()
        told = await refusal(peer, "advertise", topic=topic, type=ros_type)
        assert told == await refusal(peer, "publish", topic=topic, msg={})
        assert house.entities() - before == {("publisher", ACCESS_REFUSALS)}
    assert told == (
        "the right raw is missing; a client without a token has: read, act. To give it, make a token: "
        'homebot token new NAME --scope "read" --scope "raw"'
    )


def test_a_client_is_no_node_that_listens_to_what_no_device_says() -> None:
    client = ClientAccess("local", LOCAL_RIGHTS, RobotOwners())
    wanted = {"topic": "zigbee2mqtt/bridge/info", "listener": "/robots"}
    assert client.stamped(SubscribeToTopicRequest, wanted) == {"topic": "zigbee2mqtt/bridge/info", "listener": ""}


def test_a_persons_client_may_override_leases_and_a_robots_may_not() -> None:
    rights = read_scope(("act: all",))
    phone, robot = (ClientAccess("x", one, RobotOwners()) for one in (rights, rights._replace(robots=("rosie",))))
    wanted = {"target": "door", "command": "close", "override": True}
    assert phone.stamped(CommandDevicesRequest, wanted)["override"] is True
    assert robot.stamped(CommandDevicesRequest, wanted)["override"] is False
    owner = ClientAccess("owner", ALL_RIGHTS, RobotOwners())
    assert owner.stamped(CommandDevicesRequest, wanted)["override"] is True


@pytest.mark.parametrize("service", ["/control/perform", "/devices/command", "/gateway/mqtt/send_command", "/rosapi/x"])
async def test_a_client_without_the_right_raw_takes_the_place_of_no_service_of_homebot(
    open_house: Any, service: str
) -> None:
    """Whoever served it would get the commands of all apps, with their codes."""
    async with open_house() as house, house.peer() as peer:
        told = await refusal(peer, "advertise_service", service=service, type="std_srvs/Trigger")
    assert told.startswith("the right raw is missing; ")


async def test_a_client_with_the_right_raw_publishes_on_the_topics_of_gateways(open_house: Any) -> None:
    async with robot(open_house, "raw", "read") as (house, peer):
        commands = house.node("mqtt").create_subscription(RawCommand, OUT)
        await peer.send("publish", topic=OUT, msg=RAW_COMMAND)
        await peer.send("advertise", topic="/gateway/mqtt/received_topics", type="homebot/msg/Sighting")
        with anyio.fail_after(PATIENCE):
            heard = await commands.receive()
        assert (heard.payload, heard.issuer) == ("unlock", "client:robot")
        await peer.settle()
        assert ("publisher", "/gateway/mqtt/received_topics") in house.entities()


@pytest.mark.parametrize(
    ("headers", "is_allowed"),
    [
        ({}, False),
        ({"Origin": "http://127.0.0.1:PORT"}, False),
        ({"Origin": "http://localhost:8080"}, False),
        ({"Origin": "http://localhost:3000", "Authorization": "Bearer robot-secret"}, True),
    ],
)
async def test_neither_programs_nor_pages_approve_without_a_token(
    open_house: Any, headers: dict[str, str], is_allowed: object
) -> None:
    """An agent on this computer could otherwise approve the lock that it was told to ask about."""
    door = settings("read", "act: harmless", "manage", allowed_origins=("http://localhost:8080",))
    async with AsyncExitStack() as stack:
        house = await stack.enter_async_context(open_house(door))
        headers = {name: value.replace("PORT", str(house.server.port)) for name, value in headers.items()}
        peer = await stack.enter_async_context(house.peer(**headers))
        answer = SuccessResponse(success=True, message="")
        for name in ("/discovery/approve", "/discovery/alias", "/app/go"):
            house.node(name.rpartition("/")[2]).create_service(Trigger, name, lambda _: answer)
        managed = [await peer.call(name) for name in ("/discovery/approve", "/discovery/alias")]
        assert (await peer.call("/app/go"))["result"] is True
    assert [one["result"] for one in managed] == [is_allowed] * 2
    if not is_allowed:
        program = "web page" if headers.get("Origin", "").startswith("http://127") else "client"
        assert managed[0]["values"] == (
            f"the right manage is missing; a {program} without a token has: read, act. To give it, "
            'make a token: homebot token new NAME --scope "read" --scope "manage"'
        )


@pytest.mark.parametrize(
    "of_a_browser",
    [{}, {"User-Agent": ""}, {"Accept-Language": "en"}, {"Pragma": "no-cache"}, {"Sec-Fetch-Site": "same-origin"}],
)
async def test_a_program_that_sends_an_origin_as_websocket_client_does_is_no_page(
    open_house: Any, of_a_browser: dict[str, str]
) -> None:
    """Browsers say which they are; ros-mcp and other programs with that library do not."""
    async with open_house(settings("read", scope=("read", "manage"))) as house:
        house.node("approve").create_service(
            Trigger, "/discovery/approve", lambda _: SuccessResponse(success=True, message="")
        )
        address = f"127.0.0.1:{house.server.port}"
        async with connect(
            f"ws://{address}",
            origin=Origin(f"http://{address}"),
            additional_headers=of_a_browser,
            user_agent_header=None,
            compression=None,
            proxy=None,
        ) as connection:
            assert (await Peer(connection).call("/discovery/approve"))["result"] is (not of_a_browser)


async def test_the_right_raw_is_none_to_read_or_to_manage(open_house: Any) -> None:
    async with robot(open_house, "raw") as (_, peer):
        read = await refusal(peer, "subscribe", topic="/discovery/changes")
        answer = await peer.call("/rosapi/set_param", name="/a:b", value="1")
    assert read.startswith("the right read is missing; the token robot has: raw. ")
    assert answer["result"] is False
    assert answer["values"].startswith("the right manage is missing; ")


async def test_a_client_is_told_its_own_rights_and_on_what_it_may_act_whatever_it_claims(open_house: Any) -> None:
    async with robot(open_house, "read", "ask: light", "act: blind in hall") as (_, peer):
        answer = await peer.call("/rosapi/rights", issuer="client:owner", rights=["manage"], scope=["act: all"])
    assert answer["values"] == {
        "issuer": "client:robot",
        "rights": ["act", "ask", "read"],
        "acts_on": ["act: blind in hall", "ask: light"],
    }


async def test_a_client_that_may_only_read_publishes_nothing_and_commands_nothing(open_house: Any) -> None:
    async with robot(open_house, "read") as (house, peer):
        house.node("listener").create_subscription(String, "/chatter")
        services = ("/app/go", "/control/perform", "/devices/command")
        app = house.node("app")
        for name in services:
            app.create_service(Trigger, name, lambda _: SuccessResponse(success=True, message=""))
        assert (await peer.call("/rosapi/topics"))["result"] is True
        told = await refusal(peer, "publish", topic="/chatter", msg={"data": "x"})
        answers = [await peer.call(name) for name in services]
    assert told == (
        "the right act is missing; the token robot has: read. To give it, "
        'add "act: harmless" to its scope, in the table [door.tokens.robot] of homebot.toml'
    )
    assert [(one["result"], one["values"]) for one in answers] == [(False, told)] * 3


@pytest.mark.parametrize(
    ("scope", "problem"),
    [
        (("read",), "service /discovery/aprove_device has no server now; did you mean /discovery/approve_device?"),
        (("act: all",), "the right manage is missing; the token robot has: act. "),
    ],
)
async def test_a_client_that_may_list_services_learns_of_a_misspelt_one(
    open_house: Any, scope: tuple[str, ...], problem: str
) -> None:
    """No right would help. Whoever may not list them is told nothing of which there are."""
    async with robot(open_house, *scope) as (house, peer):
        answer = SuccessResponse(success=True, message="")
        house.node("index").create_service(Trigger, "/discovery/approve_device", lambda _: answer)
        refused = await peer.call("/discovery/aprove_device")
        counts = {one.name: one.count for one in house.server.health(HealthRequest()).counts}
    assert refused["result"] is False
    assert refused["values"].startswith(problem)
    assert (counts["requests_refused"], counts["rights_missing"]) == (1, "read" not in scope)


async def test_a_client_that_may_act_on_something_speaks_with_apps(open_house: Any) -> None:
    async with robot(open_house, "act: light in hall") as (house, peer):
        heard = house.node("listener").create_subscription(String, "/chatter")
        house.node("app").create_service(Trigger, "/app/go", lambda _: SuccessResponse(success=True, message=""))
        await peer.send("publish", topic="/chatter", msg={"data": "x"})
        assert (await peer.call("/app/go"))["result"] is True
        with anyio.fail_after(PATIENCE):
            assert (await heard.receive()).data == "x"


@pytest.mark.parametrize("kind", ["door", "lift"])
@pytest.mark.parametrize("way", ["/adapter_", "/"])
async def test_only_a_robot_asks_for_doors_and_lifts_which_an_app_may_open(
    open_house: Any, way: str, kind: str
) -> None:
    ros_type = f"rmf_{kind}_msgs/msg/{kind.title()}Request"
    request: dict[str, Any] = {"topic": f"{way}{kind}_requests", "type": ros_type}
    async with robot(open_house, "read", "act: harmless") as (_, peer):
        assert (await refusal(peer, "advertise", **request)).startswith("the right robot is missing; ")
        assert (await refusal(peer, "publish", **request, msg={})).startswith("the right robot is missing; ")
    async with robot(open_house, "read", "robot: rosie") as (house, peer):
        heard = house.node("doors").create_subscription(find_message(ros_type), request["topic"])
        await peer.send("publish", **request, msg={f"{kind}_name": "front"})
        with anyio.fail_after(PATIENCE):
            assert getattr(await heard.receive(), f"{kind}_name") == "front"


async def test_only_a_robot_says_where_it_is_and_says_nothing_of_another(open_house: Any) -> None:
    room: dict[str, Any] = {"topic": "/rosie/room", "type": "homebot/RobotRoom"}
    async with robot(open_house, "read", "act: all", "manage", "raw") as (_, peer):
        for topic, kind in (("/robot/pose", "geometry_msgs/PoseStamped"), ("/tf", "tf2_msgs/TFMessage")):
            refused = await refusal(peer, "publish", topic=topic, type=kind, msg={})
            assert refused.startswith("the right robot is missing; ")
    async with robot(open_house, "read", "robot: rosie") as (_, peer):
        refused = await refusal(peer, "publish", **room, msg={"robot": "bob", "room": "Hall"})
        assert refused == "the robot 'bob' is not of the robot rosie"


async def test_a_client_without_the_right_raw_does_not_send_commands_by_a_gateway(open_house: Any) -> None:
    sent: list[Command] = []

    def send(command: Command) -> SendCommandResponse:
        sent.append(command)
        return SendCommandResponse(success=True)

    async with robot(open_house, "read", "act: all", "manage") as (house, peer):
        house.node("mqtt").create_service(SendCommand, "/gateway/mqtt/send_command", send)
        answer = await peer.call("/gateway/mqtt/send_command", key="k", part="", capability="lock")
    assert (answer["result"], sent) == (False, [])
    assert answer["values"].startswith("the right raw is missing; the token robot has: read, act, manage. ")


@pytest.mark.parametrize(
    ("token", "issuer", "scope", "trigger"),
    [
        ("", "client:local", (), "program"),
        ("robot-secret", "client:robot", ("act: light in hall", "act: lock"), "program"),
        ("owner-secret", "client:owner", ("act: all",), ""),
    ],
)
async def test_the_issuer_of_a_command_is_its_client(
    open_house: Any, token: str, issuer: str, scope: tuple[str, ...], trigger: str
) -> None:
    """Its rights travel with it: those that it claims count as little; without a token it is a program, no person."""
    seen: list[tuple[str, tuple[str, ...], str]] = []

    def perform(request: CommandRequest) -> Outcome:
        seen.append((request.issuer, request.scope, request.trigger.kind))
        return Confirmed(0.25, Evidence.REPORTED, command_id="1", reported={"level": 40.0})

    owner = {"token": SecretStr("owner-secret")} if token == "owner-secret" else {}
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    async with (
        open_house(settings("act: light in hall", "read", "act: lock", **owner)) as house,
        house.peer(**headers) as peer,
    ):
        house.node("control").create_service(PerformCommand, PERFORM_COMMAND, perform)
        forged = await peer.call(PERFORM_COMMAND, **COMMAND)
        silent = await peer.call(
            PERFORM_COMMAND, **{key: one for key, one in COMMAND.items() if key not in {"issuer", "scope"}}
        )
        assert (forged["result"], silent["result"]) == (True, True)
        answer = forged["values"]
        assert (answer["outcome"], answer["text"]) == ("confirmed", "confirmed after 0.25 s (reported)")
        assert answer["reported"] == [{"capability": "level", "value": 40.0}]
    assert seen == [(issuer, scope, trigger)] * 2


@pytest.mark.rooms("scenes")
async def test_a_command_of_the_http_api_is_a_programs_also_with_the_owners_token(open_house: Any) -> None:
    seen: list[tuple[str, str]] = []

    def apply(request: ApplySceneRequest) -> CommandDevicesResponse:
        seen.append((request.issuer, request.trigger.kind))
        return CommandDevicesResponse(success=True)

    async with open_house(settings(token=SecretStr("owner-secret"))) as house:
        house.node("scenes").create_service(ApplyScene, APPLY_SCENE, apply)
        url, headers = f"http://127.0.0.1:{house.server.port}/api/scene", {"Authorization": "Bearer owner-secret"}
        async with (
            aiohttp.ClientSession() as session,
            session.post(url, json={"scene": "x"}, headers=headers) as answer,
        ):
            assert answer.status == 200
    assert seen == [("client:owner", "program")]


async def test_each_refusal_is_counted_and_logged_and_told_on_the_graph(open_house: Any) -> None:
    with capture_logs() as lines:
        async with robot(open_house, "read") as (house, peer):
            refusals = house.node("journal").create_subscription(AccessRefused, ACCESS_REFUSALS)
            await refusal(peer, "publish", topic=OUT, msg=RAW_COMMAND)
            with anyio.fail_after(PATIENCE):
                told = await refusals.receive()
            counts = {one.name: one.count for one in house.server.health(HealthRequest()).counts}
    assert (told.issuer, told.operation, told.target, told.right) == ("client:robot", "publish", OUT, "raw")
    assert told.address.startswith("127.0.0.1:")
    assert told.reason.startswith("the right raw is missing; ")
    assert (counts["rights_missing"], counts["requests_refused"]) == (1, 1)
    line = next(one for one in lines if one["event"] == "door.right_missing")
    assert f"publishing on {OUT} was refused: the right raw is missing" in line["message"]
    assert "secret" not in f"{lines}{told}"


async def test_messages_on_a_refused_topic_are_refused_before_they_are_parsed(open_house: Any) -> None:
    """A robot without its right streams on: what is no JSON behind the topic is not even read."""
    async with robot(open_house, "read") as (house, peer):
        first = await refusal(peer, "publish", topic=OUT, msg=RAW_COMMAND)
        await peer.connection.send(f'{{"op": "publish", "id": "again", "topic": "{OUT}", "msg": [nothing')
        again = await peer.receive()
        counts = {one.name: one.count for one in house.server.health(HealthRequest()).counts}
    assert (again["id"], again["msg"]) == ("again", first)
    assert counts["rights_missing"] == 2


async def test_a_flood_of_refusals_is_counted_in_full_and_told_in_part(open_house: Any) -> None:
    with capture_logs() as lines:
        async with open_house() as house, house.peer() as peer:
            refusals = house.node("journal").create_subscription(AccessRefused, ACCESS_REFUSALS, qos_profile=1000)
            for _ in range(200):
                await refusal(peer, "publish", topic=OUT, msg=RAW_COMMAND)
            counts = {one.name: one.count for one in house.server.health(HealthRequest()).counts}
            told = sum(1 for _ in iter(refusals.take, None))
    assert counts["rights_missing"] == 200
    assert told == sum(line["event"] == "door.right_missing" for line in lines) < 100


async def test_a_wrong_token_is_turned_away_where_there_are_named_ones(open_house: Any) -> None:
    """It does not fall back to what clients without a token may do."""
    async with open_house(settings("read")) as house:
        with pytest.raises(InvalidStatus) as caught:
            async with house.peer(Authorization="Bearer wrong"):
                pytest.fail("let in")
    assert caught.value.response.status_code == 401


async def test_where_there_is_a_token_without_a_name_every_client_needs_one(open_house: Any) -> None:
    door = settings("read", token=SecretStr("owner-secret"))
    async with open_house(door) as house:
        with pytest.raises(InvalidStatus):
            async with house.peer():
                pytest.fail("let in")
        async with house.peer(Authorization="Bearer robot-secret") as peer:
            await peer.settle()


async def test_the_token_without_a_name_has_every_right(open_house: Any) -> None:
    door = RosbridgeSettings(port=0, token=SecretStr("owner-secret"))
    async with open_house(door) as house, house.peer(Authorization="Bearer owner-secret") as peer:
        commands = house.node("mqtt").create_subscription(RawCommand, OUT)
        await peer.send("publish", topic=OUT, msg=RAW_COMMAND)
        with anyio.fail_after(PATIENCE):
            await commands.receive()


async def test_the_scope_of_the_door_holds_for_clients_without_a_token(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, scope=("read",))) as house, house.peer() as peer:
        await peer.settle()
        told = await refusal(peer, "publish", topic="/chatter", msg={})
    assert told.startswith("the right act is missing; a client without a token has: read. ")


def test_where_others_can_connect_a_client_without_a_token_has_no_rights() -> None:
    door = settings("read", host="0.0.0.0")  # noqa: S104  # the case under test
    assert set(door.rights(LOCAL_RIGHTS)) == {"robot"}


@pytest.mark.parametrize("name", ["local", "owner", "", "a b", "a" * 65, "a/b"])
def test_a_token_has_a_name_of_its_own(name: str) -> None:
    with pytest.raises(ValidationError, match="a token cannot be called"):
        RosbridgeSettings(tokens={name: ClientToken(token=SecretStr("s"), scope=("read",))})


def test_each_token_has_a_secret_of_its_own_which_no_error_shows() -> None:
    one = ClientToken(token=SecretStr("hunter2"), scope=("read",))
    with pytest.raises(ValidationError, match="the tokens owner and robot are the same") as caught:
        RosbridgeSettings(token=SecretStr("hunter2"), tokens={"robot": one})
    assert "hunter2" not in str(caught.value)


@pytest.mark.parametrize(
    ("service", "right"),
    [
        ("/getIndexData", Right.READ),
        ("/discovery/query", Right.READ),
        ("/discovery/places", Right.READ),
        ("/control/journal", Right.READ),
        pytest.param("/history/read", Right.READ, marks=pytest.mark.rooms("history")),
        pytest.param("/history/energy", Right.READ, marks=pytest.mark.rooms("history")),
        ("/control/unapproved", Right.READ),
        ("/gateway/mqtt/health", Right.READ),
        ("/gateway/mqtt/subscribe_to_topic", Right.READ),
        ("/gateway/nfc/read_tag", Right.READ),
        ("/rosapi/get_param", Right.READ),
        ("/light_service/health", Right.READ),
        ("/devices/command", Right.ACT),
        ("/devices/perform", Right.ACT),
        ("/devices/hold", Right.ACT),
        ("/devices/hold/_action/send_goal", Right.RAW),
        ("/devices/hold/_action/cancel_goal", Right.MANAGE),
        ("/fib/_action/cancel_goal", Right.ACT),
        ("/control/perform", Right.ACT),
        ("/control/send_text", Right.ACT),
        ("/control/hold", Right.ACT),
        ("/control/renew", Right.ACT),
        ("/control/release", Right.ACT),
        ("/control/answer", Right.ACT),
        ("/control/get_questions", Right.READ),
        ("/my_app/go", Right.ACT),
        ("/rosapi/set_param", Right.MANAGE),
        ("/robot/set_parameters", Right.MANAGE),
        ("/gateway/mqtt/get_parameters", Right.READ),
        ("/discovery/forget", Right.MANAGE),
        ("/discovery/merge", Right.MANAGE),
        ("/discovery/place", Right.MANAGE),
        ("/discovery/approve", Right.MANAGE),
        ("/control/end_leases", Right.MANAGE),
        ("/control/leases", Right.READ),
        ("/control/causes", Right.READ),
        ("/gateway/mqtt/refresh", Right.ACT),
        ("/gateway/nfc/write_tag", Right.MANAGE),
        ("/gateway/matter/commission", Right.MANAGE),
        pytest.param("/homebot/start_recorder", Right.MANAGE, marks=pytest.mark.rooms("recording")),
        pytest.param("/homebot/recorder/read", Right.MANAGE, marks=pytest.mark.rooms("recording")),
        ("/discovery/export_index", Right.MANAGE),
        ("/control/to_come", Right.MANAGE),
        ("/gateway/mqtt/send_command", Right.RAW),
    ],
)
def test_each_service_needs_one_right(service: str, right: Right) -> None:
    """One of homebot's own that is not known here is taken for one that changes it."""
    assert right_to_call(service) is right


def test_a_name_that_only_begins_like_one_of_homebot_is_none() -> None:
    assert right_to_publish("/gateways/out") is Right.ACT
    assert right_to_publish("/gateway") is Right.RAW
