"""The MQTT gateway against the embedded broker: what it makes of good and bad messages, and of commands."""

import platform
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial

import anyio
import anyio.abc
import anyio.lowlevel
import pytest
from structlog.testing import capture_logs
from tests.patience import PATIENCE

from homebot.devices import GatewayState, RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.services import NEVER, SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.errors import LinkError, RefusedError
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile, Subscription, qos_profile_latched
from homebot.messages import Time
from homebot.mqtt.broker import Broker, RefusedFilters
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.names import escape_token

pytestmark = pytest.mark.slow

LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass
class House:
    """A gateway, a node that watches it, and a client on the devices' side of the broker."""

    graph: Graph
    gateway: MqttGateway
    watcher: Node
    devices: MqttConnection
    sightings: Subscription[Sighting]

    async def say(self, topic: str, payload: bytes = b"on", *, qos: int = 1, retain: bool = False) -> None:
        await self.devices.publish(topic, payload, qos=qos, retain=retain)

    async def next_sighting(self) -> Sighting:
        with anyio.fail_after(PATIENCE):
            return await self.sightings.receive()

    async def listen(self, topic: str, *, listener: str = "", since: Time = NEVER) -> SubscribeToTopicResponse:
        client = self.watcher.create_client(SubscribeToTopic, "/gateway/mqtt/subscribe_to_topic")
        return await client.call(SubscribeToTopicRequest(topic=topic, listener=listener, since=since))

    def data(self, topic: str) -> Subscription[RawMessage]:
        return self.watcher.create_subscription(RawMessage, topic, qos_profile=1000)

    def command(self, address: str, payload: str = "off") -> None:
        self.watcher.create_publisher(RawCommand, "/gateway/mqtt/out").publish(
            RawCommand(address=address, payload=payload)
        )


@asynccontextmanager
async def gateway_on(url: str, **settings: object) -> AsyncIterator[House]:
    """Run a gateway on the broker at *url* in home ``home425``, acting unless told otherwise."""
    table = MqttGatewaySettings.model_validate(
        {"url": url, "root": "home425", "act": True, "conventions": ("thesis",), **settings}
    )
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        MqttConnection(MqttOptions.from_url(url), AiomqttClient, status_topic=None) as devices,
        anyio.create_task_group() as tasks,
    ):
        gateway = MqttGateway(node, table)
        sightings = watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=LATCHED)
        await tasks.start(gateway.serve)
        await devices.wait_connected()
        yield House(graph, gateway, watcher, devices, sightings)
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("client", ["aiomqtt", "native"])
async def test_a_device_that_speaks_is_sighted_once(embedded_broker_url: str, client: str) -> None:
    """Its second message within a second is no new sighting."""
    async with gateway_on(embedded_broker_url, client=client) as house:
        await house.say("home425/lights/lamp/out")
        await house.say("home425/lights/lamp/out")
        await house.say("home425/lights/other/out")

        first, second = await house.next_sighting(), await house.next_sighting()
        assert (first.kind, first.key, first.confirmed) == ("appeared", "lights/lamp", True)
        assert (first.address, first.command_address) == ("home425/lights/lamp/out", "home425/lights/lamp/in")
        assert second.key == "lights/other"


BROKEN_TOPICS = ("home425/lights", "home425//lamp/out", "home425/lights/lamp/out/deep", "home425/lights//out")


async def test_each_topic_that_breaks_the_layout_is_counted_and_named_once_with_the_reason(
    embedded_broker_url: str,
) -> None:
    """The rest goes on."""
    async with gateway_on(embedded_broker_url) as house:
        with capture_logs() as lines:
            for topic in (*BROKEN_TOPICS, *BROKEN_TOPICS):
                await house.say(topic)
            await house.say("home425/lights/lamp/out")
            sighting = await house.next_sighting()

        assert sighting.key == "lights/lamp"
        assert house.gateway.counters.rejected == 2 * len(BROKEN_TOPICS)
        told = [line for line in lines if line["event"] == "gateway.message_rejected"]
        assert [line["topic"] for line in told] == list(BROKEN_TOPICS)
        assert all(repr(line["topic"]) in line["message"] for line in told)


async def test_a_command_makes_no_device_and_does_not_come_back(embedded_broker_url: str) -> None:
    """Neither ours nor a stranger's on ``in``."""
    async with gateway_on(embedded_broker_url) as house:
        house.command("home425/lights/lamp/in")
        await house.say("home425/lights/stranger/in")
        await house.say("home425/lights/lamp/out")

        assert (await house.next_sighting()).key == "lights/lamp"
        assert house.gateway.counters.received == 1


@pytest.mark.parametrize("device_id", ["Küche 1", "0x00158d"])
async def test_an_odd_device_id_is_a_device_and_its_mirror_topic_is_escaped(
    embedded_broker_url: str, device_id: str
) -> None:
    """The escape is legal, visible and reversible; see homebot.names."""
    async with gateway_on(embedded_broker_url) as house:
        await house.say(f"home425/lights/{device_id}/out")
        assert (await house.next_sighting()).name == device_id

        answer = await house.listen(f"home425/lights/{device_id}/out")
        assert answer.data_topic == f"/gateway/mqtt/received_data/{escape_token(device_id)}"


async def test_a_retained_message_alone_is_a_sighting_without_confirmation(embedded_broker_url: str) -> None:
    """It may be a ghost: the log says so once, and the device's own word confirms it."""
    async with MqttConnection(MqttOptions.from_url(embedded_broker_url), AiomqttClient) as past:
        await past.wait_connected()
        await past.publish("home425/lights/ghost/out", b"on", qos=1, retain=True)
    with capture_logs() as lines:
        async with gateway_on(embedded_broker_url) as house:
            ghost = await house.next_sighting()

    assert (ghost.key, ghost.confirmed) == ("lights/ghost", False)
    assert any("lights/ghost is known only from a retained message" in str(line) for line in lines)


async def test_clearing_a_retained_message_removes_the_device(embedded_broker_url: str) -> None:
    """An empty payload is MQTT's way to take something away."""
    async with gateway_on(embedded_broker_url) as house:
        await house.say("home425/lights/lamp/out", retain=True)
        await house.next_sighting()
        await house.say("home425/lights/lamp/out", b"", retain=True)

        assert (await house.next_sighting()).kind == "removed"
        late = house.watcher.create_subscription(Sighting, house.gateway.names.received_topics, qos_profile=LATCHED)
        assert late.take() is None


async def test_a_burst_of_qos_0_does_not_overrun_an_inbox_with_a_fast_reader(embedded_broker_url: str) -> None:
    """3,000 messages that arrive in a few reads, three times what the inbox holds."""
    everything = anyio.Event()
    heard: list[bytes] = []

    def hear(message: RawMessage) -> None:
        heard.append(message.payload)
        if len(heard) == 3000:
            everything.set()

    async with gateway_on(embedded_broker_url, root="h") as house:
        answer = await house.listen("h/l/x/out", listener="/watcher")
        house.watcher.create_subscription(RawMessage, answer.data_topic, hear, 1000)
        for number in range(3000):
            await house.say("h/l/x/out", b"%d" % number, qos=0)

        with anyio.fail_after(PATIENCE):
            await everything.wait()
        assert heard == [b"%d" % number for number in range(3000)]


async def test_asking_for_an_address_that_no_device_has_is_refused_with_the_reason(embedded_broker_url: str) -> None:
    """Wildcards, commands, strangers, nodes that are not there."""
    async with gateway_on(embedded_broker_url) as house:
        for topic, reason in (
            ("home425/+/lamp/out", "wildcard"),
            ("home425/lights/lamp/in", "no device publishes on topic"),
            ("home426/lights/lamp/out", "no device publishes on topic"),
            ("home425/lights", "1 levels"),
            ("", "is empty"),
        ):
            answer = await house.listen(topic)
            assert not answer.success
            assert reason in answer.message
        nobody = await house.listen("home425/lights/lamp/out", listener="/nobody")
        assert "no such node" in nobody.message


async def test_commands_to_illegal_addresses_are_refused_counted_and_told(embedded_broker_url: str) -> None:
    """And the next good one goes through."""
    async with gateway_on(embedded_broker_url) as house:
        await house.devices.subscribe(MqttSubscription("home425/lights/lamp/in", qos=1))
        with capture_logs() as lines:
            for address in ("home425/+/in", "", "a\0b"):
                house.command(address)
            house.command("home425/lights/lamp/in")
            with anyio.fail_after(PATIENCE):
                await house.devices.receive()

        assert house.gateway.counters.commands_refused == 3
        assert any(line["event"] == "gateway.command_refused" and "wildcard" in line["message"] for line in lines)


@pytest.mark.parametrize("abrupt", [False, True])
async def test_a_restarted_broker_loses_no_acknowledged_message_and_the_gateway_is_back_in_time(
    *, abrupt: bool
) -> None:
    """Every publish of QoS 1 that was acknowledged reaches the listener, across three restarts."""
    async with Broker() as broker, gateway_on(broker.url) as house:
        answer = await house.listen("home425/lights/lamp/out", listener="/watcher")
        inbox = house.data(answer.data_topic)
        acknowledged: set[bytes] = set()
        with anyio.fail_after(PATIENCE):
            async with anyio.create_task_group() as tasks:
                for number in range(600):
                    if number % 150 == 149:
                        tasks.start_soon(partial(broker.restart, keep_sessions=True, abrupt=abrupt))
                    payload = str(number).encode()
                    while payload not in acknowledged:
                        try:
                            await house.say("home425/lights/lamp/out", payload)
                            acknowledged.add(payload)
                        except LinkError:
                            await anyio.lowlevel.checkpoint()
                            await house.devices.wait_connected()
        received: set[bytes] = set()
        with anyio.fail_after(PATIENCE):
            while not acknowledged <= received:
                received.add((await inbox.receive()).payload)


async def test_clearing_a_topic_that_this_gateway_never_heard_removes_the_device_too(embedded_broker_url: str) -> None:
    """The directory may know it from before the gateway's restart."""
    async with gateway_on(embedded_broker_url) as house:
        await house.say("home425/lights/lamp/out", b"", retain=True)
        sighting = await house.next_sighting()
    assert (sighting.key, sighting.kind) == ("lights/lamp", "removed")


async def test_devices_that_come_and_go_leave_nothing_behind(embedded_broker_url: str) -> None:
    """However many names somebody invents."""
    async with gateway_on(embedded_broker_url) as house:
        for number in range(50):
            await house.say(f"home425/lights/{number}/out", b"on")
            await house.say(f"home425/lights/{number}/out", b"")
        for _ in range(100):
            await house.next_sighting()
        assert house.gateway._described._listeners.by_address == {}


async def test_asking_twice_brings_what_was_missed_once(embedded_broker_url: str) -> None:
    """The second time nothing was missed."""
    async with gateway_on(embedded_broker_url) as house:
        await house.say("home425/lights/lamp/out", b"on")
        await house.next_sighting()
        beginning = Time(sec=0, nanosec=0)
        first = await house.listen("home425/lights/lamp/out", listener="/watcher", since=beginning)
        second = await house.listen("home425/lights/lamp/out", listener="/watcher", since=beginning)
        assert [len(first.missed), len(second.missed)] == [1, 0]


async def test_a_device_that_never_becomes_stale_has_the_last_time_there_is(embedded_broker_url: str) -> None:
    """A time of ROS ends in 2038; a larger number must not crash the gateway with every message."""
    async with gateway_on(embedded_broker_url, stale_after=1e12) as house:
        await house.say("home425/lights/lamp/out")
        assert (await house.next_sighting()).expires_at == NEVER


async def test_one_status_topic_is_all_that_runs_leave_at_the_broker(embedded_broker_url: str) -> None:
    """Its name does not change from run to run."""
    for _ in range(3):
        async with gateway_on(embedded_broker_url):
            pass
    async with MqttConnection(MqttOptions.from_url(embedded_broker_url), AiomqttClient, status_topic=None) as late:
        await late.subscribe(MqttSubscription("homebot/#", qos=1))
        await late.wait_connected()
        with anyio.fail_after(PATIENCE):
            (status,) = await late.receive()
    assert status.topic == f"homebot/{platform.node()}/mqtt/status"
    assert status.payload == b"offline"


@pytest.mark.parametrize("client", ["aiomqtt", "native"])
async def test_a_wrong_password_is_found_before_the_start(client: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """That a port was open counted as well, and the first message of the gateway was that its login is refused."""
    async with Broker(credentials={"robot": "right"}) as broker:
        table = {"url": broker.url, "user": "robot", "password_env": "PASSWORD", "client": client}
        settings = MqttGatewaySettings.model_validate(table)
        monkeypatch.setenv("PASSWORD", "right")
        await MqttGateway.reach(settings)
        monkeypatch.setenv("PASSWORD", "wrong")
        with pytest.raises(RefusedError, match="check user and password_file"):
            await MqttGateway.reach(settings)


async def test_each_lost_link_is_told_and_the_waiting_for_the_next_is_not_repeated() -> None:
    """Two outages within seconds are two lines."""
    with capture_logs() as lines:
        async with Broker() as broker, gateway_on(broker.url) as house:
            for _ in range(2):
                await broker.stop()
                with anyio.fail_after(PATIENCE):
                    async for state in house.gateway._connection.states():
                        if state.phase is LinkPhase.WAITING:
                            break
                await broker.start()
                with anyio.fail_after(PATIENCE):
                    await house.gateway._connection.wait_connected()
                await anyio.wait_all_tasks_blocked()
    assert sum(line["event"] == "gateway.link_lost" for line in lines) == 2


@pytest.mark.parametrize(
    ("refused", "state", "outcome"),
    [
        (
            ("home425/+/+/out", "home425", "home425/+", "home425/+/+", "home425/+/+/+/+/#"),
            "unavailable",
            "receives nothing",
        ),
        (("home425",), "active", "listening to home425"),
    ],
)
async def test_a_broker_that_refuses_subscriptions_is_told_in_one_line(
    refused: tuple[str, ...], state: str, outcome: str
) -> None:
    """Connected is not enough to be well."""
    with capture_logs() as lines:
        async with Broker(policy=RefusedFilters(refused)) as broker, gateway_on(broker.url) as house:
            states = house.watcher.create_subscription(
                GatewayState, "/gateway/mqtt/state", qos_profile=qos_profile_latched
            )
            with anyio.fail_after(PATIENCE):
                now = await states.receive()
    assert now.state == state
    assert "refused the subscription to" in now.reason
    (told,) = [line for line in lines if line["event"] == "gateway.subscription_refused"]
    assert outcome in told["message"]


@pytest.mark.parametrize(("client", "notes"), [("aiomqtt", 1), ("native", 0)])
async def test_its_health_tells_what_its_client_cannot_do(embedded_broker_url: str, client: str, notes: int) -> None:
    async with gateway_on(embedded_broker_url, client=client) as house:
        asked = house.watcher.create_client(GetHealth, house.gateway.names.health)
        health = await asked.call(HealthRequest())
    assert len(health.notes) == notes
    assert health.troubles == ()
