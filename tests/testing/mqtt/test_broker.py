"""What a test does with its broker."""

import threading

import anyio
import paho.mqtt.client as paho
import pytest
from paho.mqtt.enums import CallbackAPIVersion
from tests.testing.mqtt.conftest import Join

from homebot.errors import InvalidNameError, UsageError
from homebot.mqtt import packets as mqtt
from homebot.testing.mqtt import BlockingTestBroker, ClientView, RecordedMessage, TestBroker

LAMP = mqtt.Subscribe(1, (mqtt.MqttSubscription("lamp/#", 1),))


async def test_a_published_dict_reaches_subscribers_as_json_with_its_properties(
    mqtt_broker: TestBroker, join: Join
) -> None:
    lamp = await join("lamp")
    await lamp.call(LAMP)
    await mqtt_broker.publish("lamp/set", {"on": True}, qos=1, properties=mqtt.Properties(response_topic="answers"))
    message = await lamp.take()
    assert isinstance(message, mqtt.Publish)
    assert (message.payload, message.qos, message.properties.response_topic) == (b'{"on": true}', 1, "answers")


async def test_publish_refuses_wildcards_and_unknown_qos(mqtt_broker: TestBroker) -> None:
    with pytest.raises(InvalidNameError):
        await mqtt_broker.publish("lamp/#")
    with pytest.raises(UsageError, match="QoS is 0, 1 or 2, not 3"):
        await mqtt_broker.publish("lamp", qos=3)


async def test_expect_returns_what_came_before_and_what_comes_later(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.send(mqtt.Publish("lamp/state", b"1", retain=True))
    await mqtt_broker.settle()
    assert await mqtt_broker.expect("lamp/+") == RecordedMessage("lamp/state", b"1", retain=True, client_id="lamp")
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(mqtt_broker.expect, "lamp/state", "2", 5.0)
        await mqtt_broker.settle()
        await lamp.send(mqtt.Publish("lamp/state", b"2"))


@pytest.mark.parametrize(
    "wanted",
    [
        {"a": [1, 2.0], "b": None},
        '{"b":null,"a":[1,2]}',
        b'{"b":null,"a":[1,2]}',
        lambda message: message.text.startswith('{"b"'),
    ],
)
async def test_a_payload_may_be_json_text_bytes_or_a_function(mqtt_broker: TestBroker, join: Join, wanted: str) -> None:
    lamp = await join("lamp")
    await lamp.send(
        mqtt.Publish("lamp", b"\xff"), mqtt.Publish("lamp", b"{"), mqtt.Publish("lamp", b'{"b":null,"a":[1,2]}')
    )
    assert (await mqtt_broker.expect("lamp", wanted)).json() == {"a": [1, 2], "b": None}


async def test_each_message_is_given_out_once_in_its_order(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.send(mqtt.Publish("lamp", b"1"), mqtt.Publish("lamp", b"2"))
    assert (await mqtt_broker.expect("lamp")).text == "1"
    assert (await mqtt_broker.expect("lamp")).text == "2"
    await mqtt_broker.settle()
    mqtt_broker.assert_not_published("#")


async def test_the_will_of_a_lost_client_counts_as_published(mqtt_broker: TestBroker, join: Join) -> None:
    await join("lamp", will=mqtt.Will("lamp/online", b"no"))
    await mqtt_broker.faults.drop_connection("lamp")
    assert (await mqtt_broker.expect("lamp/online")).text == "no"


async def test_a_failed_expect_shows_other_payloads_and_similar_topics(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.send(mqtt.Publish("lamp/kitchen/state", b"off"), mqtt.Publish("lamp/kitchn/state", b"on"))
    await mqtt_broker.settle()
    with pytest.raises(AssertionError) as caught:
        await mqtt_broker.expect("lamp/kitchen/state", "on", timeout=0.05)
    assert str(caught.value).splitlines() == [
        "no client published 'on' on lamp/kitchen/state within 0.05 s",
        "  received with another payload:",
        "    lamp/kitchen/state 'off' (QoS 0, from lamp)",
        "  received on similar topics:",
        "    lamp/kitchn/state 'on' (QoS 0, from lamp)",
    ]


async def test_a_failed_expect_shows_what_was_taken_already(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.send(mqtt.Publish("lamp", b"on"))
    await mqtt_broker.expect("lamp")
    with pytest.raises(AssertionError, match=r"(?s)an earlier expect\(\) has taken already:.*lamp 'on'"):
        await mqtt_broker.expect("lamp", timeout=0.01)


async def test_a_failed_expect_says_that_nothing_came_at_all(mqtt_broker: TestBroker) -> None:
    await mqtt_broker.publish("lamp", "on")
    with pytest.raises(AssertionError, match="no client published anything at all"):
        await mqtt_broker.expect("lamp", timeout=0.01)


async def test_settle_waits_for_a_chain_of_answers(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp")
    await lamp.call(LAMP)
    heard: list[int] = []

    async def count_down() -> None:
        while (packet := await lamp.take()) and isinstance(packet, mqtt.Publish):
            heard.append(int(packet.payload))
            if heard[-1]:
                await lamp.send(mqtt.Publish("lamp", b"%d" % (heard[-1] - 1)))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(count_down)
        await mqtt_broker.publish("lamp", "20")
        await mqtt_broker.settle()
        assert heard == list(range(20, -1, -1))
        with pytest.raises(AssertionError, match="20 published on lamp"):
            mqtt_broker.assert_not_published("lamp")
        mqtt_broker.forget_messages()
        mqtt_broker.assert_not_published("lamp")
        tasks.cancel_scope.cancel()


async def test_clients_shows_who_is_there_and_whose_session_waits(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp", mqtt.ProtocolVersion.V311, clean_start=False)
    await lamp.call(LAMP)
    assert mqtt_broker.clients == {"lamp": ClientView("lamp", True, frozenset({"lamp/#"}), "3.1.1", 0)}
    await lamp.send(mqtt.Disconnect())
    with pytest.raises(EOFError):
        await lamp.take()
    await mqtt_broker.publish("lamp/set", "on", qos=1)
    assert mqtt_broker.clients == {"lamp": ClientView("lamp", False, frozenset({"lamp/#"}), None, 1)}


@pytest.mark.parametrize("keep", [True, False])
async def test_a_restart_keeps_port_and_if_wanted_sessions(mqtt_broker: TestBroker, join: Join, *, keep: bool) -> None:
    url = mqtt_broker.url
    lamp = await join("lamp", mqtt.ProtocolVersion.V311, clean_start=False)
    await mqtt_broker.restart(keep_sessions=keep)
    with pytest.raises(EOFError):
        await lamp.take()
    assert set(mqtt_broker.clients) == ({"lamp"} if keep else set())
    await join("other")
    assert mqtt_broker.url == url


async def test_the_packet_log_is_in_words_and_without_passwords(mqtt_broker: TestBroker, join: Join) -> None:
    lamp = await join("lamp", username="u", password=b"hush")
    await lamp.call(LAMP)
    await lamp.call(mqtt.Publish("lamp", b"on", 1, packet_id=7))
    lines = [line.split("s  ", 1)[1].split(None, 1)[1] for line in mqtt_broker.packet_log.text().splitlines()]
    assert lines[0] == "→  CONNECT 'lamp' MQTT 5, clean start, keep-alive 60 s, user 'u'"
    assert lines[2:5] == [
        "→  SUBSCRIBE id 1: lamp/# QoS 1",
        "←  SUBACK id 1: QoS 1",
        "→  PUBLISH lamp 'on' QoS 1 id 7",
    ]
    assert "hush" not in repr(mqtt_broker.packet_log.records)


@pytest.mark.mqtt_broker(allow_protocol_errors=True)
async def test_bytes_that_are_no_mqtt_are_told_in_the_log(mqtt_broker: TestBroker) -> None:
    async with await anyio.connect_tcp(mqtt_broker.host, mqtt_broker.port) as stream:
        await stream.send(b"GET / HTTP/1.1\r\n\r\n")
        with pytest.raises(anyio.EndOfStream):
            await stream.receive()
    assert "sent invalid MQTT" in mqtt_broker.packet_log.text()


@pytest.mark.parametrize("topic", ["from/first", "from/second"])
async def test_the_session_broker_serves_on_the_loop_of_each_test(mqtt_broker_session: TestBroker, topic: str) -> None:
    await mqtt_broker_session.publish(topic, "1", retain=True)
    await mqtt_broker_session.settle(quiet=0.01)
    assert mqtt_broker_session.clients == {}
    assert topic in mqtt_broker_session.packet_log.text()


def test_a_blocking_client_works_in_the_tests_own_thread(mqtt_broker_thread: BlockingTestBroker) -> None:
    broker = mqtt_broker_thread
    told = threading.Event()
    client = paho.Client(CallbackAPIVersion.VERSION2, "lamp")
    client.on_subscribe = lambda *_: told.set()

    def answer(_client: paho.Client, _data: object, message: paho.MQTTMessage) -> None:
        client.publish("lamp/state", message.payload)

    client.on_message = answer
    client.connect(broker.host, broker.port)
    client.loop_start()
    try:
        client.subscribe("lamp/set")
        assert told.wait(30)
        broker.publish("lamp/set", {"on": 1})
        assert broker.expect("lamp/state", {"on": 1}).client_id == "lamp"
        broker.settle()
        broker.assert_not_published("#")
        with pytest.raises(AssertionError, match="on lamp/off within"):
            broker.expect("lamp/off", timeout=0.01)
        assert broker.clients["lamp"].protocol == "3.1.1"
    finally:
        client.disconnect()
        client.loop_stop()
