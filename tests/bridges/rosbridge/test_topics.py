"""Topics through the door, over a real WebSocket."""

from contextlib import AsyncExitStack
from typing import Any

import anyio
import pytest
from pydantic import SecretStr
from structlog.testing import capture_logs
from tests.bridges.conftest import House, Peer
from tests.patience import PATIENCE

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.bridges.rosbridge.settings import ClientToken
from homebot.devices import RawMessage
from homebot.devices.health import HealthRequest
from homebot.devices.value import PlainValue, Reading, Value
from homebot.graph import DurabilityPolicy, QoSProfile, qos_profile_latched, qos_profile_sensor_data
from homebot.messages import Int32, String, Time
from homebot.messages.cdr import message_to_cdr
from homebot.messages.json import message_from_json


async def test_a_client_reads_the_messages_of_a_node(house: House, peer: Peer) -> None:
    publisher = house.node("talker").create_publisher(String, "/chatter")
    await peer.tell("subscribe", topic="/chatter", type="std_msgs/String")
    publisher.publish(String(data="hi"))
    assert await peer.receive() == {"op": "publish", "topic": "/chatter", "msg": {"data": "hi"}}


async def test_a_node_reads_the_messages_of_a_client(house: House, peer: Peer) -> None:
    subscription = house.node("listener").create_subscription(String, "/chatter")
    await peer.send("advertise", topic="chatter", type="std_msgs/msg/String")
    await peer.send("publish", topic="chatter", msg={"data": "hi"})
    assert await subscription.receive() == String(data="hi")


async def test_a_client_that_asks_for_png_is_told_what_there_is_and_gets_json(house: House, peer: Peer) -> None:
    house.node("lamp").create_publisher(String, "/state", qos_profile_latched).publish(String(data="on"))
    await peer.send("subscribe", id="s", topic="/state", compression="png")
    remark = await peer.receive()
    assert (remark["op"], remark["level"], remark["id"]) == ("status", "error", "s")
    assert "there are none, cbor, cbor-raw" in remark["msg"]
    assert (await peer.receive())["msg"] == {"data": "on"}


async def test_missing_fields_are_zero_or_empty_with_a_warning(house: House, peer: Peer) -> None:
    """As ROSBRIDGE_PROTOCOL.md has it, section 3.2.3."""
    subscription = house.node("listener").create_subscription(RawMessage, "/raw")
    await peer.send("set_level", level="warning")
    await peer.send("publish", id="p", topic="/raw", msg={"key": "k", "received_at": {"secs": 5}})
    remark = await peer.receive()
    assert (remark["op"], remark["level"], remark["id"]) == ("status", "warning", "p")
    assert "lacks gateway, address, payload, retained, received_at.nanosec, which" in remark["msg"]
    assert await subscription.receive() == RawMessage(
        gateway="", key="k", address="", payload=b"", retained=False, received_at=Time(sec=5, nanosec=0)
    )


async def test_a_message_on_a_topic_of_homebot_must_be_whole(open_house: Any) -> None:
    """Nothing is sent to a device that nobody wrote."""
    async with open_house(RosbridgeSettings(port=0, scope=("raw",))) as house, house.peer() as peer:
        house.node("gateway").create_subscription(String, "/gateway/g/out")
        await peer.send("publish", topic="/gateway/g/out", msg={})
        assert "field 'data' is missing" in (await peer.receive())["msg"]


@pytest.mark.parametrize("topic", ["/gateway/g/received_data/lamp", "/app/inbox"])
async def test_a_reader_with_a_wrong_type_keeps_homebot_from_none_of_its_topics(house: House, topic: str) -> None:
    """Otherwise a client with the right to read alone could silence a gateway or an app."""
    async with house.peer() as wrong, house.peer() as right:
        await wrong.tell("subscribe", topic=topic, type="std_msgs/Int32")
        await right.tell("subscribe", topic=topic, type="std_msgs/String")
        publisher = house.node("owner").create_publisher(String, topic)
        for peer in (wrong, right):
            await peer.settle()
        publisher.publish(String(data="hi"))
        for peer in (wrong, right):
            assert (await peer.receive())["msg"] == {"data": "hi"}


async def test_a_latched_message_waits_for_a_late_client(house: House) -> None:
    async with house.peer() as early, house.peer() as late:
        await early.send("advertise", topic="/state", type="std_msgs/String", latch=True)
        await early.tell("publish", topic="/state", msg={"data": "on"}, latch=True)
        await late.send("subscribe", topic="/state")
        assert (await late.receive())["msg"] == {"data": "on"}


async def test_a_second_request_of_one_client_gets_the_latched_message_too(house: House, peer: Peer) -> None:
    publisher = house.node("talker").create_publisher(String, "/state", qos_profile_latched)
    publisher.publish(String(data="on"))
    await peer.send("subscribe", id="a", topic="/state")
    assert (await peer.receive())["msg"] == {"data": "on"}
    await peer.send("subscribe", id="b", topic="/state")
    assert (await peer.receive())["msg"] == {"data": "on"}


async def test_two_requests_for_one_topic_give_each_message_once(house: House, peer: Peer) -> None:
    publisher = house.node("talker").create_publisher(Int32, "/n")
    await peer.send("subscribe", id="a", topic="/n")
    await peer.tell("subscribe", id="b", topic="/n")
    publisher.publish(Int32(data=1))
    publisher.publish(Int32(data=2))
    assert [(await peer.receive())["msg"]["data"] for _ in range(2)] == [1, 2]
    await peer.tell("unsubscribe", id="a", topic="/n")
    publisher.publish(Int32(data=3))
    assert (await peer.receive())["msg"] == {"data": 3}
    await peer.tell("unsubscribe", id="b", topic="/n")
    assert house.entities() == set()


async def test_a_best_effort_publisher_reaches_a_client(house: House, peer: Peer) -> None:
    publisher = house.node("sensor").create_publisher(Int32, "/lux", qos_profile_sensor_data)
    await peer.tell("subscribe", topic="/lux")
    publisher.publish(Int32(data=7))
    assert (await peer.receive())["msg"] == {"data": 7}


async def test_a_message_with_a_type_needs_no_advertisement(house: House, peer: Peer) -> None:
    heard = house.node("listener").create_subscription(String, "/new")
    await peer.tell("publish", topic="/new", type="std_msgs/String", msg={"data": "hello"})
    assert heard.take() == String(data="hello")


async def test_a_topic_of_a_known_type_may_be_read_before_anybody_publishes(house: House, peer: Peer) -> None:
    await peer.tell("subscribe", topic="/later", type="std_msgs/String")
    house.node("talker").create_publisher(String, "/later").publish(String(data="now"))
    assert (await peer.receive())["msg"] == {"data": "now"}


async def test_a_topic_without_a_type_is_read_once_it_appears(house: House, peer: Peer) -> None:
    await peer.send("set_level", level="warning")
    await peer.send("subscribe", id="s", topic="later")
    remark = await peer.receive()
    assert (remark["op"], remark["level"], remark["id"]) == ("status", "warning", "s")
    assert "there is no topic /later yet" in remark["msg"]
    publisher = house.node("talker").create_publisher(String, "/later")
    with anyio.fail_after(PATIENCE):
        while not publisher.subscription_count:
            await peer.settle()
    publisher.publish(String(data="now"))
    assert await peer.receive() == {"op": "publish", "topic": "later", "msg": {"data": "now"}}


async def test_a_request_for_a_topic_to_come_can_be_taken_back(house: House, peer: Peer) -> None:
    await peer.send("subscribe", id="a", topic="/later")
    await peer.send("subscribe", id="b", topic="/later", type="who_msgs/Knows")
    await peer.send("unsubscribe", id="a", topic="/later")
    await peer.tell("unsubscribe", topic="/later")
    publisher = house.node("talker").create_publisher(String, "/later")
    await peer.settle()
    assert publisher.subscription_count == 0


async def test_a_topic_that_comes_with_another_type_than_expected_is_logged(house: House, peer: Peer) -> None:
    await peer.tell("subscribe", id="a", topic="/later", type="who_msgs/Knows")
    with capture_logs() as logs:
        house.node("talker").create_publisher(String, "/later")
        await peer.settle()
    assert [line["event"] for line in logs] == ["door.late_topic_unfit"]
    assert "carries std_msgs/msg/String, not who_msgs/Knows" in logs[0]["problem"]


async def test_advertising_twice_needs_unadvertising_twice(house: House, peer: Peer) -> None:
    for identifier in ("a", "b"):
        await peer.send("advertise", id=identifier, topic="/t", type="std_msgs/String")
    await peer.tell("unadvertise", id="a", topic="/t")
    assert house.entities() == {("publisher", "/t")}
    await peer.send("set_level", level="warning")
    for _ in range(2):
        await peer.send("unadvertise", id="b", topic="/t")
    problem = "topic /t was not advertised by this client"
    assert await peer.receive() == {"op": "status", "id": "b", "level": "warning", "msg": problem}
    assert house.entities() == set()


async def test_a_client_publishes_on_a_new_connection_as_it_advertised_on_the_last(house: House) -> None:
    """ros-mcp 3.1 closes its connection if no error comes within a second of each frame."""
    async with house.peer() as first:
        await first.tell("advertise", topic="/t", type="std_msgs/String")
    async with house.peer() as second, house.peer() as reader:
        await second.tell("publish", topic="/t", msg={"data": "a"})
        await reader.send("subscribe", topic="/t")
        assert (await reader.receive())["msg"] == {"data": "a"}


@pytest.mark.parametrize("latched", [{"latch": True}, {"qos": {"durability": "transient_local", "depth": 1}}])
async def test_a_topic_advertised_again_as_latched_becomes_latched(
    house: House, peer: Peer, latched: dict[str, Any]
) -> None:
    """``qos`` as in rosbridge_suite from 2.7."""
    await peer.send("advertise", id="a", topic="/t", type="std_msgs/String")
    await peer.tell("advertise", id="b", topic="/t", type="std_msgs/String", **latched)
    (info,) = house.graph.get_endpoints(name="/t")
    assert info.qos == qos_profile_latched


async def first_heard(peer: Peer, count: int, **wishes: Any) -> list[str]:
    """Return the first messages that a late subscription of ``/t`` receives."""
    await peer.send("subscribe", topic="/t", **wishes)
    frames = [(await peer.receive())["msg"]["data"] for _ in range(count)]
    await peer.tell("unsubscribe", topic="/t")
    return frames


async def test_late_subscribers_receive_as_many_messages_as_both_sides_say(peer: Peer) -> None:
    qos = {"durability": "transient_local", "depth": 3}
    await peer.send("advertise", topic="/t", type="std_msgs/String", qos=qos)
    for number in range(5):
        await peer.send("publish", topic="/t", msg={"data": f"{number}"})
    assert await first_heard(peer, 3) == ["2", "3", "4"]
    assert await first_heard(peer, 2, qos={"depth": 2}) == ["3", "4"]
    await peer.send("subscribe", topic="/t", qos={"durability": "volatile"})
    await peer.send("publish", topic="/t", msg={"data": "new"})
    assert (await peer.receive())["msg"] == {"data": "new"}


async def test_late_subscribers_receive_every_static_transform(open_house: Any) -> None:
    """Rclpy's broadcaster repeats all of its own in each message; clients in other languages send one at a time."""
    tokens = {name: ClientToken(token=SecretStr(name), scope=("read", f"robot: {name}")) for name in "ab"}
    async with open_house(RosbridgeSettings(port=0, tokens=tokens)) as house, AsyncExitStack() as stack:
        for name in tokens:
            robot = await stack.enter_async_context(house.peer(Authorization=f"Bearer {name}"))
            await robot.send("advertise", topic="/tf_static", type="tf2_msgs/TFMessage", latch=True)
            for part in ("camera", "lidar"):
                moved = {"header": {"frame_id": f"{name}/base"}, "child_frame_id": f"{name}/{part}"}
                await robot.tell("publish", topic="/tf_static", msg={"transforms": [moved]})
        late = await stack.enter_async_context(house.peer())
        await late.send("subscribe", topic="/tf_static")
        frames = [(await late.receive())["msg"]["transforms"][0]["child_frame_id"] for _ in range(4)]
    assert frames == ["a/camera", "a/lidar", "b/camera", "b/lidar"]


async def test_a_quality_of_service_that_is_none_is_refused(peer: Peer) -> None:
    await peer.send("subscribe", id="1", topic="/t", type="std_msgs/String", qos={"depth": "many"})
    assert "qos.depth" in (await peer.receive())["msg"]


async def test_a_slow_client_loses_its_oldest_messages_and_delays_no_other(open_house: Any) -> None:
    async with (
        open_house(RosbridgeSettings(port=0, queue_depth=5)) as house,
        house.peer() as slow,
        house.peer() as quick,
    ):
        publisher = house.node("camera").create_publisher(String, "/image")
        for peer in (slow, quick):
            await peer.tell("subscribe", topic="/image")
        slow.connection.transport.pause_reading()
        big = "x" * 500_000
        with anyio.fail_after(PATIENCE):
            for number in range(60):
                await publisher.send(String(data=f"{number} {big}"))
                assert (await quick.receive())["msg"]["data"].startswith(f"{number} ")
        slow.connection.transport.resume_reading()
        frames = [await slow.receive()]
        while not frames[-1]["msg"]["data"].startswith("59 "):
            frames.append(await slow.receive())
        assert sum(frame.get("lost", 0) for frame in frames) == 60 - len(frames) > 0


KEEPING = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL)


def _refused(house: House) -> int:
    return {one.name: one.count for one in house.server.health(HealthRequest()).counts}["requests_refused"]


async def test_a_message_waits_for_a_busy_reader_for_as_long_as_it_takes(house: House) -> None:
    """Nothing that was delivered expires; a reader that comes later gets the messages of the last second alone."""
    async with house.node("app") as app, house.peer() as robot:
        await robot.tell("advertise", topic="/goals", type="std_msgs/String")
        busy = app.create_subscription(String, "/goals")
        await robot.tell("publish", topic="/goals", msg={"data": "kitchen"})
        await anyio.sleep(1.1)
        late = app.create_subscription(String, "/goals", qos_profile=KEEPING)
        assert busy.take() == String(data="kitchen")
        assert (busy.expired, late.take()) == (0, None)


async def test_a_stream_that_nobody_reads_is_checked_when_somebody_does(house: House) -> None:
    """One message a second is checked at once, so that a client learns of its mistakes."""
    async with house.node("app") as app, house.peer() as robot:
        await robot.send("advertise", topic="/count", type="std_msgs/Int32")
        for number in ("at once", 0, "again", *range(1, 20), "no number"):
            await robot.send("publish", id="p", topic="/count", msg={"data": number})
        assert "got 'at once'" in (await robot.receive())["msg"]
        await robot.settle()
        assert _refused(house) == 1
        late = app.create_subscription(Int32, "/count", qos_profile=KEEPING)
        assert [message.data for message in (late.take() for _ in range(9)) if message] == list(range(11, 20))
        remark = await robot.receive()
        assert (remark["op"], remark["id"]) == ("status", "p")
        assert "'data'" in remark["msg"]
        await robot.tell("publish", topic="/count", msg={"data": 21})
        assert late.take() == Int32(data=21)


async def test_a_frame_that_nobody_reads_is_not_parsed_before_somebody_does(house: House) -> None:
    async with house.node("app") as app, house.peer() as robot:
        await robot.send("advertise", topic="/count", type="std_msgs/Int32")
        for _ in range(10):
            await robot.send("publish", topic="/count", msg={"data": 1})
        for text in ("no JSON", '{"data": 2}}', '{"data": 3}, "topic": "/other"}'):
            await robot.connection.send(f'{{"op": "publish", "id": "p:1", "topic": "/count", "msg": {text}')
        await robot.settle()
        assert _refused(house) == 0
        late = app.create_subscription(Int32, "/count", qos_profile=KEEPING)
        assert [message.data for message in iter(late.take, None)] == [1] * 7 + [2]
        problems = [(await robot.receive())["msg"] for _ in range(2)]
        assert "is not JSON" in problems[0]
        assert "'topic' occurs twice" in problems[1]


async def test_values_of_devices_are_plain_in_json_and_messages_in_cbor(house: House) -> None:
    values: tuple[PlainValue, ...] = (True, 40.0, "warm", (30.0, 0.5), None)
    readings = [Reading(part="", capability="x", value=Value.of(value)) for value in values]
    async with house.peer() as screen, house.peer() as typed:
        publisher = house.node("app").create_publisher(Reading, "/readings")
        await screen.send("subscribe", topic="/readings")
        await typed.send("subscribe", topic="/readings", compression="cbor-raw")
        for peer in (screen, typed):
            await peer.settle()
        for reading in readings:
            await publisher.send(reading)
        frames = [(await screen.receive())["msg"] for _ in values]
        assert [frame["value"] for frame in frames] == [True, 40, "warm", [30, 0.5], None]
        assert [message_from_json(Reading, frame) for frame in frames] == readings
        for reading in readings:
            assert message_to_cdr(reading) in await typed.connection.recv()
