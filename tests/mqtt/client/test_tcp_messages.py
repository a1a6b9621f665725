"""What a client by TCP does with messages, against a broker that plays a script."""

import logging
from collections.abc import Callable
from typing import Any

import anyio
import pytest
from tests.mqtt.client.scripted_broker import MakeClient, Peer, broker, linked
from tests.patience import PATIENCE

from homebot.errors import LinkError, RefusedError, UsageError
from homebot.mqtt import packets as mqtt
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.options import MqttProtocol

# -- receiving ------------------------------------------------------------------------------------------------


async def test_a_message_is_acknowledged_only_when_it_was_handed_over(make: MakeClient) -> None:
    """The library does it on arrival; a crash then loses the message."""
    async with linked(make) as (client, peer):
        await peer.send(mqtt.Publish("t", b"x", 1, packet_id=7))
        batch = await client.receive()
        await client.publish("marker")
        client.ack(batch)
        assert (await peer.expect(mqtt.Publish)).topic == "marker"
        assert (await peer.expect(mqtt.Puback)).packet_id == 7


async def test_qos_2_is_handed_over_once_and_only_then_recorded(make: MakeClient) -> None:
    async with linked(make) as (client, peer):
        await peer.send(mqtt.Publish("t", b"x", 2, packet_id=7), mqtt.Publish("t", b"x", 2, dup=True, packet_id=7))
        await peer.send(mqtt.Publish("t", b"last"))
        batch = await receive(client, 2)
        assert [message.payload for message in batch] == [b"x", b"last"]
        await client.publish("marker")
        client.ack(batch)
        assert (await peer.expect(mqtt.Publish)).topic == "marker"
        await peer.expect(mqtt.Pubrec)
        await peer.send(mqtt.Pubrel(7))
        assert (await peer.expect(mqtt.Pubcomp)).packet_id == 7


async def test_unread_messages_of_qos_0_are_dropped_oldest_first_and_counted(make: MakeClient) -> None:
    async with linked(make, inbox_messages=10) as (client, peer), anyio.create_task_group() as tasks:
        await peer.send(*(mqtt.Publish("t", b"%d" % n) for n in range(100)), mqtt.Publish("t", b"end", 1, packet_id=1))
        tasks.start_soon(peer.acknowledge, 1)
        await client.publish("marker", qos=1)  # its answer comes behind the messages
        batch = await client.receive()
    assert [message.payload for message in batch] == [b"%d" % n for n in range(90, 100)] + [b"end"]
    assert client.counters.dropped_overflow == 90


async def test_the_window_for_unacknowledged_messages_and_the_size_limit_are_announced(make: MakeClient) -> None:
    async with linked(make, receive_maximum=17, maximum_packet_size=2000, session_expiry=60) as (_, peer):
        # no topic aliases: the library cannot resolve them
        assert peer.connect.properties == mqtt.Properties(
            receive_maximum=17, maximum_packet_size=2000, session_expiry_interval=60
        )


@pytest.mark.parametrize("version", ["5", "3.1.1"])
async def test_a_bad_message_costs_no_more_than_itself(make: MakeClient, version: MqttProtocol) -> None:
    """It is acknowledged, so that it does not come for ever, and counted; the next one arrives."""
    properties = b"\x00" if version == "5" else b""
    bodies = [
        b"\x00\x02\xc3\x28\x00\x01" + properties,  # a topic that is not UTF-8
        b"\x00\x03a/#\x00\x02" + properties,
        b"\x00\x03a\x00b\x00\x03" + properties,
    ]
    if version == "5":
        bodies.append(b"\x00\x01a\x00\x04\x02\x7f\x00")  # an unknown property

    async with linked(make, protocol=version) as (client, peer):
        for body in bodies:
            await peer.send_raw(bytes([0x32, len(body)]) + body)
        await peer.send(mqtt.Publish("good", b"", 1, packet_id=9))
        (message,) = await client.receive()
        assert message.topic == "good"
        assert [(await peer.expect(mqtt.Puback)).packet_id for _ in bodies] == list(range(1, len(bodies) + 1))
    assert client.counters.dropped_malformed == len(bodies)


async def test_a_message_over_the_limit_is_dropped_acknowledged_and_counted(make: MakeClient) -> None:
    async with linked(make, protocol="3.1.1") as (client, peer):
        await peer.send(mqtt.Publish("big", bytes(300_000), 1, packet_id=1), mqtt.Publish("small", b""))
        (message,) = await client.receive()
        assert message.topic == "small"
        assert (await peer.expect(mqtt.Puback)).packet_id == 1
    assert client.counters.dropped_oversize == 1


async def test_an_unreadable_packet_ends_the_link_with_its_reason(make: MakeClient) -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.send_raw(b"\x90\x01\x00")
        await peer.closed()

    async with broker(script) as port, (client := make(port)).connected():
        assert "unreadable" in str(await client.wait_lost())
        with pytest.raises(LinkError):
            await client.receive()


async def test_a_link_that_ends_as_soon_as_it_stands_was_made_and_lost(make: MakeClient) -> None:
    async def script(peer: Peer) -> None:
        connect = await peer.expect(mqtt.Connect)
        await peer.send_raw(mqtt.encode(mqtt.Connack(), connect.version) + b"\x90\x01\x00")
        await peer.closed()

    async with broker(script) as port, (client := make(port)).connected():
        assert "unreadable" in str(await client.wait_lost())


# -- publishing -----------------------------------------------------------------------------------------------


async def test_a_refused_publish_of_qos_2_is_an_error(make_native: MakeClient) -> None:
    async def refuse(peer: Peer) -> None:
        await peer.send(mqtt.Pubrec((await peer.expect(mqtt.Publish)).packet_id or 0, mqtt.ReasonCode.QUOTA_EXCEEDED))

    async with linked(make_native, refuse) as (client, _):
        with pytest.raises(RefusedError, match="quota exceeded"):
            await client.publish("t", qos=2)


async def test_a_publish_in_flight_fails_at_once_when_the_link_drops(make: MakeClient) -> None:
    """The library waits for its time limit, 10 s by default."""

    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(mqtt.Publish)

    async with broker(script) as port, (client := make(port)).connected():
        with anyio.fail_after(PATIENCE), pytest.raises(LinkError, match="the broker closed the connection"):
            await client.publish("t", qos=1)
        with pytest.raises(LinkError):
            await client.publish("t")
        with pytest.raises(LinkError):
            await client.subscribe(MqttSubscription("t"))


async def test_a_subscription_in_flight_fails_at_once_when_the_link_drops(make: MakeClient) -> None:
    async def script(peer: Peer) -> None:
        await peer.login()
        await peer.expect(mqtt.Subscribe)

    async def second(peer: Peer) -> None:
        await peer.login()
        await peer.expect(mqtt.Unsubscribe)

    async with broker(script, second) as port:
        client = make(port)
        with anyio.fail_after(PATIENCE):
            async with client.connected():
                with pytest.raises(LinkError):
                    await client.subscribe(MqttSubscription("t"))
            async with client.connected():
                with pytest.raises(LinkError):
                    await client.unsubscribe("t")


async def test_a_silent_broker_is_a_link_error(make: MakeClient, pass_time: Callable[[float], None]) -> None:
    async def script(peer: Peer) -> None:
        await peer.expect(mqtt.Publish)
        pass_time(8)
        await peer.expect(mqtt.Subscribe)
        pass_time(8)

    async with linked(make, script, timeout=8) as (client, _):
        with pytest.raises(LinkError, match=r"no answer to a publish within 8 s"):
            await client.publish("t", qos=1)
        with pytest.raises(LinkError, match="no answer to a subscribe"):
            await client.subscribe(MqttSubscription("t"))


async def test_the_window_of_the_broker_is_respected(make: MakeClient) -> None:
    """The library ignores Receive Maximum; a broker then closes the link and all is lost."""
    async with (
        linked(make, granted={"receive_maximum": 3}) as (client, peer),
        anyio.create_task_group() as tasks,
    ):
        for _ in range(10):
            tasks.start_soon(lambda: client.publish("t", qos=1))
        first = [await peer.expect(mqtt.Publish) for _ in range(3)]
        await client.publish("marker")
        assert (await peer.expect(mqtt.Publish)).topic == "marker"
        for publish in first:
            await peer.send(mqtt.Puback(publish.packet_id or 0))
        await peer.acknowledge(7)


async def test_many_publishes_at_once_make_no_noise(make: MakeClient, caplog: pytest.LogCaptureFixture) -> None:
    """The library warns from ten on, each time."""
    with caplog.at_level(logging.DEBUG):
        async with linked(make) as (client, peer), anyio.create_task_group() as tasks:
            for _ in range(200):
                tasks.start_soon(lambda: client.publish("t", qos=1))
            await peer.acknowledge(200)
    assert [record for record in caplog.records if record.name != "asyncio"] == []


async def test_what_the_broker_cannot_take_is_refused_here(make: MakeClient) -> None:
    """Sent all the same, it would cost the link."""
    limits = {"maximum_qos": 0, "retain_available": 0, "maximum_packet_size": 100}
    async with linked(make, granted=limits) as (client, _):
        with pytest.raises(RefusedError, match="qos not supported"):
            await client.publish("t", qos=1)
        with pytest.raises(RefusedError, match="retain not supported"):
            await client.publish("t", retain=True)
        with pytest.raises(RefusedError, match="packet too large"):
            await client.publish("t", bytes(100))
        with pytest.raises(RefusedError, match="packet too large"):
            await client.publish("t", properties=mqtt.Properties(user_properties=(("k", "v" * 100),)))


async def test_a_publish_that_is_none_is_a_usage_error(make: MakeClient) -> None:
    async with linked(make) as (client, _):
        with pytest.raises(UsageError):
            await client.publish("a/+")
        with pytest.raises(UsageError):
            await client.publish("t", qos=3)
        with pytest.raises(UsageError, match=r"properties|do not fit into an MQTT field"):
            await client.publish("t", properties=mqtt.Properties(correlation_data=bytes(70_000)))
        with pytest.raises(UsageError):
            await client.subscribe(MqttSubscription("a/#/b"))


async def test_publishes_of_qos_0_wait_for_a_slow_broker(make: MakeClient) -> None:
    """The queue before the socket stays bounded, and a dropped link frees who waits."""
    stuffed = anyio.Event()

    async def script(peer: Peer) -> None:
        await peer.login()
        await stuffed.wait()

    async with broker(script) as port, (client := make(port)).connected():
        sent = 0

        async def flood() -> None:
            nonlocal sent
            try:
                while True:
                    await client.publish("t", bytes(60_000))
                    sent += 1
            except LinkError:
                return

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(flood)
            tasks.start_soon(flood)
            await anyio.wait_all_tasks_blocked()
            assert 0 < sent < 2000
            stuffed.set()


async def test_publishes_of_qos_0_go_on_when_a_slow_broker_reads_again(make: MakeClient) -> None:
    async with linked(make) as (client, peer), anyio.create_task_group() as tasks:
        for _ in range(3):
            tasks.start_soon(flood, client, 400)
        await anyio.wait_all_tasks_blocked()
        for _ in range(1200):
            await peer.expect(mqtt.Publish)


# -- subscribing ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("version", "code", "words"),
    [
        ("5", mqtt.ReasonCode.NOT_AUTHORIZED, "not authorized"),
        ("3.1.1", mqtt.ReasonCode.UNSPECIFIED_ERROR, "unspecified error"),
    ],
)
async def test_a_refused_subscription_is_an_error_that_names_the_filter(
    make: MakeClient, version: MqttProtocol, code: mqtt.ReasonCode, words: str
) -> None:
    async def refuse(peer: Peer) -> None:
        subscribe = await peer.expect(mqtt.Subscribe)
        await peer.send(mqtt.Suback(subscribe.packet_id, (mqtt.ReasonCode.GRANTED_QOS_1, code)))

    async with linked(make, refuse, protocol=version) as (client, _):
        with pytest.raises(RefusedError, match=f"subscription to 'secret/#' was refused: {words}") as caught:
            await client.subscribe(MqttSubscription("a", 1), MqttSubscription("secret/#", 1))
        assert caught.value.code == code


async def test_subscription_options_reach_the_broker(make: MakeClient) -> None:
    wish = MqttSubscription("a/#", 2, no_local=True, retain_as_published=True, retain_handling=2)

    async def script(peer: Peer) -> None:
        subscribe = await peer.expect(mqtt.Subscribe)
        assert subscribe.filters == (wish,)
        await peer.send(mqtt.Suback(subscribe.packet_id, (mqtt.ReasonCode.GRANTED_QOS_1,)))
        unsubscribe = await peer.expect(mqtt.Unsubscribe)
        await peer.send(mqtt.Unsuback(unsubscribe.packet_id, (mqtt.ReasonCode.SUCCESS,)))

    async with linked(make, script) as (client, _):
        assert await client.subscribe(wish) == (1,)
        await client.unsubscribe("a/#")


async def receive(client: MqttClient, count: int) -> list[Any]:
    messages: list[Any] = []
    while len(messages) < count:
        messages += await client.receive()
    return messages


async def flood(client: MqttClient, count: int) -> None:
    for _ in range(count):
        await client.publish("t", bytes(30_000))
