"""What every implementation of `MqttClient` promises, over each link that there is.

The brokers are the embedded one, on TCP and in memory, and Mosquitto. A new link joins by one more line in `LINKS`.
"""

import contextlib
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, replace
from functools import partial

import anyio
import pytest
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, MosquittoBroker
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions, MqttProtocol
from homebot.mqtt.packets import NO_PROPERTIES, Properties, ReasonCode, Will

pytestmark = pytest.mark.slow

Make = Callable[[MqttOptions], MqttClient]
MANY = size(200, 1000)

AnyBroker = Broker | MemoryBroker | MosquittoBroker


@dataclass(frozen=True)
class Link:
    """A client and what it talks to; in memory the broker makes the client."""

    broker: type[AnyBroker]
    client: Make | None
    protocol: MqttProtocol


LINKS: dict[str, Link] = {
    f"{name}-{protocol}": Link(broker, client, protocol)
    for name, broker, client in (
        ("aiomqtt", Broker, AiomqttClient),
        ("native", Broker, NativeClient),
        ("memory", MemoryBroker, None),
        ("native-mosquitto", MosquittoBroker, NativeClient),
        ("aiomqtt-mosquitto", MosquittoBroker, AiomqttClient),
    )
    for protocol in ("5", "3.1.1")
}


class NoSecrets:
    """Nobody may touch what is secret."""

    def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002, ARG002 - the port's own
        return ReasonCode.NOT_AUTHORIZED if filter.startswith("secret") else ReasonCode.SUCCESS

    def publish(self, client_id: str, topic: str) -> ReasonCode:  # noqa: ARG002 - the port's own
        return ReasonCode.NOT_AUTHORIZED if topic.startswith("secret") else ReasonCode.SUCCESS


NEEDS_MOSQUITTO = (
    pytest.mark.system,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
)


@pytest.fixture(params=[pytest.param(name, marks=NEEDS_MOSQUITTO if "mosquitto" in name else ()) for name in LINKS])
def link(request: pytest.FixtureRequest) -> Link:
    return LINKS[request.param]


@pytest.fixture
async def broker(link: Link) -> AsyncIterator[AnyBroker]:
    async with link.broker(credentials={"anna": "right"}, policy=NoSecrets()) as broker:
        yield broker


@pytest.fixture
def make(broker: AnyBroker, link: Link) -> Make:
    if link.client is not None:
        return link.client
    assert isinstance(broker, MemoryBroker)
    return broker.make_client


@pytest.fixture
def options(broker: AnyBroker, link: Link) -> MqttOptions:
    return MqttOptions.from_url(
        f"mqtt://anna:right@{broker.host}:{broker.port}", client_id="hub", protocol=link.protocol, timeout=5.0
    )


async def receive(client: MqttClient | MqttConnection, count: int) -> list[MqttMessage]:
    """At least *count* messages, not acknowledged."""
    messages: list[MqttMessage] = []
    with anyio.fail_after(PATIENCE):
        while len(messages) < count:
            messages += await client.receive()
    return messages


async def test_a_message_comes_back_as_it_was_published(make: Make, options: MqttOptions) -> None:
    """With aiomqtt at most with QoS 1."""
    most = 1 if make is AiomqttClient else 2
    client = make(options)
    properties = Properties(
        payload_format_indicator=1,
        content_type="text/plain",
        response_topic="r",
        correlation_data=b"\0",
        user_properties=(("k", "v"),),
    )
    async with client.connected() as session:
        await client.subscribe(MqttSubscription("a/+/c", 2))
        for qos in (0, 1, 2):
            await client.publish("a/ü/c", bytes([qos]), qos=qos, properties=properties)
        messages = await receive(client, 3)
        client.ack(messages)
    expected = properties if session.protocol == "5" else NO_PROPERTIES
    assert messages == [MqttMessage("a/ü/c", bytes([qos]), min(qos, most), properties=expected) for qos in (0, 1, 2)]


async def test_more_messages_than_any_window_come_in_order(make: Make, options: MqttOptions) -> None:
    client = make(options)
    got: list[bytes] = []
    async with client.connected(), anyio.create_task_group() as tasks:
        await client.subscribe(MqttSubscription("t", 1))
        for number in range(MANY):
            tasks.start_soon(partial(client.publish, "t", b"%d" % number, qos=1))
        while len(got) < MANY:
            batch = await receive(client, 1)
            client.ack(batch)
            got += [message.payload for message in batch]
    assert got == [b"%d" % number for number in range(MANY)]


async def test_a_stored_message_says_that_it_is_one(make: Make, options: MqttOptions) -> None:
    client = make(options)
    async with client.connected():
        await client.publish("t", b"kept", qos=1, retain=True)
        await client.subscribe(MqttSubscription("t"))
        await client.publish("t", b"live", qos=1)
        assert [(m.payload, m.retain) for m in await receive(client, 2)] == [(b"kept", True), (b"live", False)]


async def test_after_unsubscribing_nothing_comes(make: Make, options: MqttOptions) -> None:
    client = make(options)
    async with client.connected():
        await client.subscribe(MqttSubscription("t"), MqttSubscription("end"))
        await client.unsubscribe("t")
        await client.publish("t")
        await client.publish("end")
        assert [message.topic for message in await receive(client, 1)] == ["end"]


async def test_no_local_leaves_out_what_the_client_published_itself(make: Make, options: MqttOptions) -> None:
    client = make(options)
    async with client.connected() as session:
        await client.subscribe(MqttSubscription("t", no_local=True), MqttSubscription("end"))
        await client.publish("t")
        await client.publish("end")
        expected = ["end"] if session.protocol == "5" else ["t", "end"]
        assert [message.topic for message in await receive(client, len(expected))] == expected


async def test_what_was_not_acknowledged_comes_again_to_the_next_process(make: Make, options: MqttOptions) -> None:
    """A crash between receiving and handing over loses nothing of QoS 1 and 2."""
    kept = replace(options, session_expiry=60)
    crashed = make(kept)
    async with crashed.connected():
        await crashed.subscribe(MqttSubscription("t", 2))
        for qos in (1, 2):
            await crashed.publish("t", bytes([qos]), qos=qos)
        assert len(await receive(crashed, 2)) == 2
    successor = make(kept)
    async with successor.connected() as session:
        assert session.resumed
        messages = await receive(successor, 2)
        assert [message.payload for message in messages] == [b"\x01", b"\x02"]
        successor.ack(messages)
        await successor.publish("t", b"end", qos=1)
        assert [message.payload for message in await receive(successor, 1)] == [b"end"]


async def test_what_was_acknowledged_does_not_come_again(make: Make, options: MqttOptions) -> None:
    client = make(replace(options, session_expiry=60))
    async with client.connected():
        await client.subscribe(MqttSubscription("t", 2))
        for qos in (1, 2):
            await client.publish("t", b"old", qos=qos)
        client.ack(await receive(client, 2))
    async with client.connected():
        await client.publish("t", b"new", qos=1)
        assert [message.payload for message in await receive(client, 1)] == [b"new"]


async def test_a_refused_publish_is_an_error(make: Make, options: MqttOptions) -> None:
    """MQTT 3.1.1 has no way to say so."""
    client = make(options)
    async with client.connected() as session:
        if session.protocol == "5":
            with pytest.raises(RefusedError, match="'secret/door' was refused: not authorized") as caught:
                await client.publish("secret/door", qos=1)
            assert caught.value.code == 0x87
        assert await client.publish("open/door", qos=1) < 0x80


async def test_a_refused_subscription_is_an_error(make: Make, options: MqttOptions, broker: AnyBroker) -> None:
    if isinstance(broker, MosquittoBroker):
        pytest.skip("Mosquitto's file of rules cannot refuse a subscription; it delivers nothing instead")
    client = make(options)
    async with client.connected():
        with pytest.raises(RefusedError, match="'secret/#' was refused"):
            await client.subscribe(MqttSubscription("open/#"), MqttSubscription("secret/#"))
        await client.publish("open/door")
        assert [message.topic for message in await receive(client, 1)] == ["open/door"]


async def test_a_wrong_password_is_refused(make: Make, options: MqttOptions, broker: AnyBroker) -> None:
    wrong = MqttOptions.from_url(f"mqtt://anna:wr0ng@{broker.host}:{broker.port}", protocol=options.protocol)
    with pytest.raises(RefusedError, match="the login was refused") as caught:
        async with make(wrong).connected():
            pass
    assert str(caught.value).endswith("; check user and password_file, which are read at the start")
    assert "wr0ng" not in str(caught.value)


async def test_a_broker_that_dies_is_a_link_error_for_everybody(
    make: Make, options: MqttOptions, broker: AnyBroker
) -> None:
    client = make(options)
    async with client.connected():
        await client.subscribe(MqttSubscription("t"))
        await broker.stop(abrupt=True)
        assert isinstance(await client.wait_lost(), LinkError)
        with pytest.raises(LinkError):
            await client.receive()
        with pytest.raises(LinkError):
            await client.publish("t", qos=1)
    with pytest.raises(LinkError):
        async with client.connected():
            pass


async def test_the_will_is_for_a_crash_and_not_for_a_good_bye(make: Make, options: MqttOptions) -> None:
    watcher, quiet = make(options), make(replace(options, client_id="quiet", will=Will("will", b"quiet")))
    first, second = (make(replace(options, client_id="twin", will=Will("will", b"twin"))) for _ in range(2))
    async with watcher.connected():
        await watcher.subscribe(MqttSubscription("will"))
        async with quiet.connected():
            pass
        async with first.connected(), second.connected():  # the second takes the name over, which cuts the first off
            await first.wait_lost()
            assert [message.payload for message in await receive(watcher, 1)] == [b"twin"]


async def test_a_link_may_be_dropped_without_a_word_and_made_again(make: Make, options: MqttOptions) -> None:
    """The broker takes it for a crash: the will is published."""
    watcher, lamp = make(options), make(replace(options, client_id="lamp", will=Will("will", b"lost")))
    lamp.drop()  # nothing to drop
    async with watcher.connected():
        await watcher.subscribe(MqttSubscription("will"))
        async with lamp.connected():
            lamp.drop()
            assert isinstance(await lamp.wait_lost(), LinkError)
            assert [message.payload for message in await receive(watcher, 1)] == [b"lost"]
        async with lamp.connected():
            await lamp.publish("will", b"back", qos=1)
        assert [message.payload for message in await receive(watcher, 1)] == [b"back"]


@pytest.mark.parametrize("abrupt", [False, True])
async def test_a_restarted_broker_is_found_again_and_no_accepted_message_is_lost(
    make: Make, options: MqttOptions, broker: AnyBroker, *, abrupt: bool
) -> None:
    """What the broker acknowledged to the publisher arrives, over three restarts in the middle of the traffic."""
    accepted: set[bytes] = set()
    got: set[bytes] = set()
    progress = anyio.Event()
    options = replace(options, session_expiry=60)

    async def publish(publisher: MqttConnection) -> None:
        for payload in (b"%d" % number for number in range(300)):
            while payload not in accepted:
                await publisher.wait_connected()
                with contextlib.suppress(LinkError):
                    await publisher.publish("t", payload, qos=1)
                    accepted.add(payload)

    async def restart(hub: MqttConnection) -> None:
        for least in (50, 150, 250):
            while len(got) < least:
                await progress.wait()
            await broker.restart(keep_sessions=True, abrupt=abrupt)
            began = anyio.current_time()
            await hub.wait_connected()
            assert anyio.current_time() - began < 2

    with anyio.fail_after(PATIENCE):
        async with (
            MqttConnection(options, make, status_topic=None) as hub,
            MqttConnection(replace(options, client_id="publisher"), make, status_topic=None) as publisher,
        ):
            await hub.subscribe(MqttSubscription("t", 1))
            await hub.wait_connected()
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(publish, publisher)
                tasks.start_soon(restart, hub)
                while len(got) < 300:
                    batch = await hub.receive()
                    got.update(message.payload for message in batch)
                    hub.ack(batch)
                    progress.set()
                    progress = anyio.Event()
    assert got == accepted


@pytest.mark.parametrize("ends", [False, True])
async def test_a_good_close_ends_the_session_only_where_that_is_asked(
    options: MqttOptions, make: Make, *, ends: bool
) -> None:
    """A client id that will not come again leaves nothing at the broker."""
    lasting = replace(options, session_expiry=60, session_ends_on_close=ends)
    async with make(lasting).connected():
        pass
    async with make(replace(lasting, session_ends_on_close=False)).connected() as session:
        assert session.resumed is not ends


async def test_a_broken_link_leaves_the_session_in_any_case(
    broker: AnyBroker, options: MqttOptions, make: Make
) -> None:
    """What comes meanwhile must not be lost."""
    client = make(replace(options, session_expiry=60, session_ends_on_close=True))
    async with client.connected():
        await broker.restart(keep_sessions=True, abrupt=True)
        with anyio.fail_after(PATIENCE):
            await client.wait_lost()
    async with client.connected() as session:
        assert session.resumed
