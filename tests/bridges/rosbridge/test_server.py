"""The door: who is let in, what bad clients get, and that everything goes with its client."""

import json
import socket
from contextlib import suppress
from typing import Any

import anyio
import pytest
from pydantic import SecretStr
from structlog.testing import capture_logs
from tests.bridges.conftest import House, Peer
from tests.patience import PATIENCE
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from homebot.bridges.rosbridge import RosbridgeServer, RosbridgeSettings
from homebot.devices.exposure import NetworkService
from homebot.errors import ConfigError, UsageError
from homebot.graph import Graph, Node
from homebot.messages import String


async def test_everything_a_client_holds_goes_with_it(house: House) -> None:
    house.node("talker").create_publisher(String, "/chatter")
    async with house.peer() as peer:
        await peer.send("subscribe", topic="/chatter")
        await peer.send("subscribe", topic="/early")
        await peer.send("advertise", topic="/mine", type="std_msgs/String")
        await peer.tell("advertise_service", service="/serve", type="std_srvs/Trigger")
        assert house.entities() == {
            ("subscription", "/chatter"),
            ("publisher", "/mine"),
            ("service", "/serve"),
        }
        with house.graph.watch() as changes:
            peer.connection.transport.abort()
            with anyio.fail_after(PATIENCE):
                while house.entities():
                    await changes.receive()
    with anyio.fail_after(PATIENCE):
        while house.server.client_count:
            await anyio.lowlevel.checkpoint()


async def test_a_stopped_door_says_goodbye(open_house: Any) -> None:
    async with open_house() as house:
        connection = await connect(f"ws://127.0.0.1:{house.server.port}", proxy=None)
    with pytest.raises(ConnectionClosed) as caught:
        await connection.recv()
    assert caught.value.rcvd is not None
    assert caught.value.rcvd.code == 1001


async def test_a_stopped_door_does_not_wait_for_a_client_that_hangs(open_house: Any) -> None:
    with anyio.fail_after(PATIENCE):
        async with open_house() as house:
            publisher = house.node("camera").create_publisher(String, "/image")
            connection = await connect(f"ws://127.0.0.1:{house.server.port}", proxy=None)
            await connection.send('{"op": "subscribe", "topic": "/image"}')
            while not publisher.subscription_count:
                await anyio.lowlevel.checkpoint()
            connection.transport.pause_reading()
            for _ in range(20):
                publisher.publish(String(data="x" * 500_000))
                await anyio.lowlevel.checkpoint()
    connection.transport.abort()
    await connection.wait_closed()


async def test_a_client_that_takes_no_bytes_is_cut_off(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, stall_timeout=0.1)) as house, house.peer() as stalled:
        publisher = house.node("camera").create_publisher(String, "/image")
        await stalled.tell("subscribe", topic="/image")
        stalled.connection.transport.pause_reading()
        with house.graph.watch() as changes, anyio.fail_after(PATIENCE):
            for _ in range(30):
                publisher.publish(String(data="x" * 500_000))
            while house.entities():
                await changes.receive()
        stalled.connection.transport.abort()


async def test_a_stopped_door_does_not_wait_for_a_client_that_says_nothing(open_house: Any) -> None:
    with anyio.fail_after(PATIENCE):
        async with open_house(open_timeout=10 * PATIENCE) as house:
            silent = await anyio.connect_tcp("127.0.0.1", house.server.port)
            async with house.peer() as peer:
                await peer.settle()
    await silent.aclose()


def test_an_empty_token_is_no_token() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        RosbridgeSettings(token=SecretStr(""))


BAD_FRAMES = [
    ("not json", "the frame is not JSON: Expecting value"),
    ('{"op": "publish", "topic": "/chatter", "msg": {"data": 5}}', "'data': input should be a valid string, got 5"),
    ('{"op": "publish", "topic": "/chatter", "msg": {"data": ' + "[" * 90 + "]" * 90 + "}}", "'data': input should be"),
    ('{"op": "publish", "topic": "/nowhere", "msg": {}}', "there is no topic /nowhere yet, so its type must be given"),
    ('{"op": "publish", "topic": "a b", "msg": {}}', "topic name '/a b' has a character that is not allowed"),
    ('{"op": "advertise", "topic": "/chatter", "type": "std_msgs/Int32"}', "/chatter carries std_msgs/msg/String, not"),
    ('{"op": "advertise", "topic": "/new", "type": "who_msgs/Knows"}', "unknown message type 'who_msgs/Knows'"),
    ('{"op": "subscribe", "topic": "/chatter", "type": "std_msgs/Int32"}', "/chatter carries std_msgs/msg/String, not"),
    ('{"op": "unsubscribe", "topic": "/chatter"}', "topic /chatter was not subscribed to by this client"),
    ('{"op": "advertise_service", "service": "/s", "type": "who_srvs/Knows"}', "unknown service type 'who_srvs/Knows'"),
    ('{"op": "unadvertise_service", "service": "/s"}', "service /s is not provided by this client"),
    ('{"op": "service_response", "service": "/s", "id": "1", "result": true}', "no call of /s with the id '1'"),
    ('{"op": "advertise_action", "action": "/a", "type": "x/action/Y"}', "unknown action type 'x/action/Y'"),
    ('{"op": "subscribe", "topic": "/new", "type": "std_msgs/Strng"}', "unknown message type 'std_msgs/Strng'; simi"),
    ('{"op": "fragment", "id": "1", "data": "{}", "num": 0, "total": 1}', "the unknown operation 'fragment'; known"),
]


@pytest.mark.parametrize(("frame", "said"), BAD_FRAMES)
async def test_a_bad_frame_is_told_to_its_client_and_changes_nothing(house: House, frame: str, said: str) -> None:
    """Unasked: the protocol's default level is ``error``."""
    async with house.peer() as bad, house.peer() as good:
        publisher = house.node("talker").create_publisher(String, "/chatter")
        await good.tell("subscribe", topic="/chatter")
        await bad.connection.send(frame)
        answer = await bad.receive()
        assert (answer["op"], answer["level"], answer.get("id")) == ("status", "error", "1" if '"1"' in frame else None)
        assert said in answer["msg"]
        await bad.settle()
        publisher.publish(String(data="still here"))
        assert (await good.receive())["msg"] == {"data": "still here"}
        assert house.entities() == {("subscription", "/chatter")}


async def test_status_is_not_sent_to_a_client_that_asked_for_none(peer: Peer) -> None:
    await peer.send("set_level", level="none")
    with capture_logs() as logs:
        for _ in range(20):
            await peer.connection.send("not json")
        await peer.send("call_service", id="call", service="/rosapi/get_time")
        assert (await peer.receive())["op"] == "service_response"
    assert [line["op"] for line in logs if line["event"] == "door.refused"] == ["frame"] * 20


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ("not json", " sent a frame that is not JSON: Expecting value: line 1 column 1 (char 0)"),
        ('{"op": "fly"}', " sent a frame that uses the unknown operation 'fly'; known are action_feedback, "),
        ('{"op": "publish", "topic": "/chatter"}', ": publishing on /chatter was refused: field 'msg' is missing"),
        ('{"op": "publish", "topic": "/t", "msg": {}}', ": publishing on /t was refused: "),
        ('{"op": "unsubscribe", "topic": "/t"}', ": unsubscribing from /t was refused: topic /t was not subscribed to"),
        ('{"op": "unadvertise_service", "service": "/s"}', ": withdrawing /s was refused: service /s is not provided"),
        ('{"op": "set_level", "level": 9}', ": set_level was refused: field 'level': "),
        ('{"op": "unsubscribe", "topic": "' + "x" * 5000 + '"}', f": unsubscribing from {'x' * 99}… was refused: "),
    ],
)
async def test_the_log_names_the_client_and_its_mistake(open_house: Any, frame: str, said: str) -> None:
    async with open_house() as house, house.peer() as peer:
        with capture_logs() as logs:
            await peer.connection.send(frame)
            await peer.settle()
        host, port = peer.connection.local_address[:2]
    (line,) = logs
    assert line["message"].startswith(f"client:local ({host}:{port}){said}")
    assert len(line["message"]) <= 300


async def test_json_may_come_in_a_binary_frame(peer: Peer) -> None:
    """ROS# sends its frames so."""
    await peer.connection.send('\n{"op": "fly", "id": "Küche"}'.encode())
    assert (await peer.receive())["id"] == "Küche"


@pytest.mark.parametrize(
    ("frame", "code"),
    [(b"\x00\x01", 1003), (b'{"op": "\xff"}', 1003), ('{"op": "publish", "msg": "' + "x" * 5000, 1009)],
)
async def test_a_frame_that_cannot_be_taken_ends_that_connection(
    open_house: Any, frame: str | bytes, code: int
) -> None:
    settings = RosbridgeSettings(port=0, max_frame_bytes=4096)
    async with open_house(settings) as house, house.peer() as bad, house.peer() as good:
        with capture_logs() as logs:
            await bad.connection.send(frame)
            with anyio.fail_after(PATIENCE), pytest.raises(ConnectionClosed) as caught:
                await bad.connection.recv()
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == code
            await good.settle()
        told = [
            one["message"]
            for one in logs
            if "exceeds limit of 4096 bytes, the max_frame_bytes of [door]" in one["message"]
        ]
        assert len(told) == (code == 1009)


async def test_a_client_may_hold_only_so_much(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_entities=2)) as house, house.peer() as peer:
        await peer.send("set_level", level="error")
        for number in range(3):
            await peer.send("advertise", topic=f"/t{number}", type="std_msgs/String")
        assert "this client uses 2 topics and services already" in (await peer.receive())["msg"]
        assert len(house.entities()) == 2


async def test_each_id_of_a_request_counts(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_entities=3)) as house, house.peer() as peer:
        house.node("talker").create_publisher(String, "/chatter")
        for number in range(4):
            await peer.send("subscribe", id=f"{number}", topic="/chatter")
        assert "this client uses 3 topics and services already" in (await peer.receive())["msg"]
        await peer.send("unsubscribe", id="0", topic="/chatter")
        await peer.send("advertise", id="a", topic="/chatter", type="std_msgs/String")
        await peer.send("advertise", id="b", topic="/chatter", type="std_msgs/String")
        assert "this client uses 4 topics and services already" in (await peer.receive())["msg"]
        await peer.send("unadvertise", topic="/chatter")
        await peer.tell("unsubscribe", topic="/chatter")
        assert house.entities() == set()


async def test_all_clients_together_may_hold_only_so_much(open_house: Any) -> None:
    async with (
        open_house(RosbridgeSettings(port=0, max_entities_of_all=5)) as house,
        house.peer() as one,
        house.peer() as two,
    ):
        for number in range(3):
            await one.send("advertise", topic=f"/t{number}", type="std_msgs/String")
        await one.settle()
        await two.send("advertise", topic="/mine", type="std_msgs/String")
        assert "all clients together use 5 topics and services already" in (await two.receive())["msg"]


async def test_a_client_that_sends_too_fast_is_read_more_slowly_and_loses_nothing(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_frames_per_second=100)) as house, house.peer() as peer:
        reader = house.node("reader").create_subscription(String, "/chatter", qos_profile=1000)
        await peer.send("set_level", level="warning")
        started = anyio.current_time()
        for number in range(150):
            await peer.send("publish", topic="/chatter", msg={"data": f"{number}"})
        assert "more than 100 frames a second came from this client" in (await peer.receive())["msg"]
        with anyio.fail_after(PATIENCE):
            got = [(await reader.receive()).data for _ in range(150)]
    assert anyio.current_time() - started >= 0.5
    assert got == [f"{number}" for number in range(150)]


async def test_one_client_too_many_is_turned_away(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_clients=1)) as house, house.peer():
        with pytest.raises(InvalidStatus) as caught:
            async with house.peer():
                pytest.fail("let in")
        assert caught.value.response.status_code == 503


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("/", {}, 401),
        ("/?token=wrong", {}, 401),
        ("/?token=hunter2", {"Origin": "https://evil.example"}, 403),
        ("/", {"Authorization": "Bearer wrong"}, 401),
    ],
)
async def test_a_client_without_the_token_or_of_a_foreign_page_is_turned_away(
    open_house: Any, path: str, headers: dict[str, str], status: int
) -> None:
    with capture_logs() as logs:
        async with open_house(RosbridgeSettings(port=0, token=SecretStr("hunter2"))) as house:
            with pytest.raises(InvalidStatus) as caught:
                async with house.peer(path, **headers):
                    pytest.fail("let in")
            assert caught.value.response.status_code == status
    assert [line["event"] for line in logs] == ["door.turned_away"]
    assert "hunter2" not in repr(logs)


@pytest.mark.parametrize(("path", "headers"), [("/?token=hunter2", {}), ("/", {"Authorization": "Bearer hunter2"})])
async def test_a_client_with_the_token_is_let_in(open_house: Any, path: str, headers: dict[str, str]) -> None:
    settings = RosbridgeSettings(port=0, token=SecretStr("hunter2"))
    async with open_house(settings) as house, house.peer(path, **headers) as peer:
        await peer.settle()


async def get(port: int, path: str = "/", header: str = "Accept: */*") -> str:
    """What a plain HTTP client such as curl is answered."""
    async with await anyio.connect_tcp("127.0.0.1", port) as stream:
        await stream.send(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n{header}\r\n\r\n".encode())
        answer = b""
        with anyio.fail_after(PATIENCE), suppress(anyio.EndOfStream):
            while True:
                answer += await stream.receive()
    return answer.decode()


@pytest.mark.parametrize("path", ["/", "/api/home", "/api/devices"])
async def test_the_address_of_a_plain_request_has_no_token_that_counts(open_house: Any, path: str) -> None:
    """It stays in histories and logs of proxies; each client of HTTP can send a header."""
    with capture_logs() as logs:
        async with open_house(RosbridgeSettings(port=0, token=SecretStr("hunter2"))) as house:
            assert (await get(house.server.port, f"{path}?token=hunter2")).startswith("HTTP/1.1 401 ")
            authorized = await get(house.server.port, path, "Authorization: Bearer hunter2")
    assert not authorized.startswith("HTTP/1.1 401 ")
    assert "hunter2" not in repr(logs)


async def test_a_plain_http_client_gets_a_greeting(open_house: Any) -> None:
    async with open_house() as house:
        head, _, body = (await get(house.server.port)).partition("\r\n\r\n")
    assert head.startswith("HTTP/1.1 426 ")
    assert "\r\nUpgrade: websocket" in head
    assert body == "this is homebot's rosbridge v2 WebSocket server, not a web page\n"


async def test_a_plain_http_client_without_the_token_is_told_no_more_than_that(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, token=SecretStr("hunter2"))) as house:
        assert (await get(house.server.port)).startswith("HTTP/1.1 401 ")


async def test_a_rebound_name_is_turned_away(house: House) -> None:
    with socket.create_connection(("127.0.0.1", house.server.port)) as raw:
        raw.setblocking(False)
        raw.send(
            b"GET / HTTP/1.1\r\nHost: evil.example\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        with anyio.fail_after(PATIENCE):
            await anyio.wait_readable(raw)
        assert raw.recv(100).startswith(b"HTTP/1.1 403")


async def test_invalid_web_socket_is_logged_and_harmless(open_house: Any) -> None:
    async with open_house() as house, house.peer() as peer:
        with capture_logs() as logs:
            for _ in range(3):
                stream = await anyio.connect_tcp("127.0.0.1", house.server.port)
                async with stream:
                    await stream.send(b"\x16\x03\x01 not http\r\n\r\n")
                    with anyio.fail_after(PATIENCE), pytest.raises(anyio.EndOfStream):
                        await stream.receive()
            await peer.settle()
    assert [line["event"] for line in logs] in ([], ["door.invalid_http"] * 3)  # not every websockets release tells


def test_an_open_door_needs_a_token() -> None:
    async def make() -> None:
        RosbridgeServer(Node(Graph(), "door"), RosbridgeSettings(host="0.0.0.0"))  # noqa: S104  # the case under test

    with pytest.raises(ConfigError, match=r"0\.0\.0\.0 can be reached by others, so it needs a token"):
        anyio.run(make)


async def test_a_taken_address_is_named(house: House) -> None:
    second = RosbridgeServer(house.node("second"), RosbridgeSettings(port=house.server.port))
    with pytest.raises(UsageError, match=f"127.0.0.1:{house.server.port} is in use, maybe by another homebot"):
        await second.run()


async def test_an_address_of_another_machine_is_named() -> None:
    door = RosbridgeServer(Node(Graph(), "door"), RosbridgeSettings(host="192.0.2.1", port=0, token=SecretStr("t")))
    with pytest.raises(UsageError, match=r"cannot listen on 192\.0\.2\.1:0"):
        await door.run()


async def test_frames_are_ascii(house: House, peer: Peer) -> None:
    publisher = house.node("talker").create_publisher(String, "/chatter")
    await peer.tell("subscribe", topic="/chatter")
    publisher.publish(String(data="Küche \ud800"))
    text = await peer.connection.recv()
    assert isinstance(text, str)
    assert text.isascii()
    assert json.loads(text)["msg"]["data"] == "Küche \ud800"


async def test_the_door_says_where_it_listens_and_that_it_no_longer_does() -> None:
    said: list[NetworkService] = []
    node = Node(Graph(), "rosbridge_websocket")
    door = RosbridgeServer(node, RosbridgeSettings(host="0.0.0.0", port=0, token=SecretStr("secret")), said.append)  # noqa: S104
    async with anyio.create_task_group() as tasks:
        await tasks.start(door.run)
        (service,) = said
        assert (service.service_type, service.addresses, service.port) == ("_rosbridge._tcp", ("0.0.0.0",), door.port)  # noqa: S104
        assert "secret" not in repr(service)
        tasks.cancel_scope.cancel()
    assert said[1:] == [NetworkService(service_type="_rosbridge._tcp", is_withdrawn=True)]
