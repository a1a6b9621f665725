"""Several homebots of one home at one broker: one acts, and the status topic speaks for whoever is there."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random

import anyio
import pytest

from homebot.devices import GatewayState, RawCommand
from homebot.devices.health import GetHealth, HealthRequest
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.virtual_time

STATUS = "homebot/pc/mqtt/status"


class Homebot:
    """One of several."""

    def __init__(self, gateway: MqttGateway, watcher: Node, scope: anyio.CancelScope) -> None:
        self.gateway = gateway
        self._watcher = watcher
        self._scope = scope
        self._out = watcher.create_publisher(RawCommand, gateway.names.out, 10)
        self._state = watcher.create_subscription(GatewayState, gateway.names.state, qos_profile=qos_profile_latched)

    async def send(self) -> None:
        self._out.publish(RawCommand(address="lamp/set", payload="ON"))
        await anyio.sleep(0.1)

    def state(self) -> GatewayState:
        newest = None
        while (state := self._state.take()) is not None:
            newest = state
        assert newest is not None
        return newest

    async def troubles(self) -> tuple[str, ...]:
        client = self._watcher.create_client(GetHealth, self.gateway.names.health)
        return (await client.call(HealthRequest())).troubles

    async def stop(self) -> None:
        self._scope.cancel()
        await anyio.sleep(0.1)


class House:
    """A broker, and who is there."""

    def __init__(self, broker: MemoryBroker, tasks: anyio.abc.TaskGroup, wire: MqttConnection) -> None:
        self.broker = broker
        self.wire = wire
        self._tasks = tasks

    async def start(self, computer: str = "pc", seed: int = 1, **settings: object) -> Homebot:
        started = await self._tasks.start(self._run, computer, seed, settings)
        assert isinstance(started, Homebot)
        return started

    async def _run(
        self, computer: str, seed: int, settings: dict[str, object], *, task_status: anyio.abc.TaskStatus[Homebot]
    ) -> None:
        table = {"url": self.broker.url, "root": "home425", "act": True, "conventions": (), **settings}
        with anyio.CancelScope() as scope:
            graph = Graph()
            async with Node(graph, "mqtt", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
                gateway = MqttGateway(
                    node,
                    MqttGatewaySettings.model_validate(table),
                    GatewayContext.of(
                        HostedBroker(self.broker.url, self.broker.make_client, computer),
                        random=Random(seed),  # noqa: S311 - the same run each time
                    ),
                )
                async with anyio.create_task_group() as tasks:
                    await tasks.start(gateway.serve)
                    task_status.started(Homebot(gateway, watcher, scope))
                    await anyio.sleep_forever()

    async def heard(self) -> list[tuple[str, str]]:
        with anyio.move_on_after(0.01):
            return [(one.topic, one.payload.decode()) for one in await self.wire.receive()]
        return []


@asynccontextmanager
async def house(*filters: str) -> AsyncIterator[House]:
    async with (
        MemoryBroker(random=Random(1)) as broker,  # noqa: S311 - the same run each time
        MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as wire,
        anyio.create_task_group() as tasks,
    ):
        await wire.wait_connected()
        await wire.subscribe(*(MqttSubscription(one, qos=1) for one in filters))
        yield House(broker, tasks, wire)
        tasks.cancel_scope.cancel()


async def test_one_alone_acts_at_once() -> None:
    async with house("lamp/set") as home:
        first = await home.start()
        await first.send()
        assert await home.heard() == [("lamp/set", "ON")]
        assert first.state().acts
        assert await first.troubles() == ()


async def test_a_second_one_observes_and_says_so() -> None:
    async with house("lamp/set") as home:
        first = await home.start()
        await anyio.sleep(10)
        second = await home.start("laptop", seed=2)
        await anyio.sleep(0.5)
        for one in (first, second):
            await one.send()
        assert await home.heard() == [("lamp/set", "ON")]
        state = second.state()
        why = (
            "another homebot (mqtt on pc) already sends commands to home home425; "
            "stop one of the two, or set act = false here"
        )
        assert (state.acts, state.reason) == (False, why)
        assert await second.troubles() == (why,)
        assert first.state().acts
        assert second.gateway.counters.commands_refused == 1


async def test_the_second_one_acts_soon_after_the_first_is_gone() -> None:
    """Whether it said good-bye or not."""
    async with house("lamp/set") as home:
        first = await home.start()
        await anyio.sleep(10)
        second = await home.start("laptop", seed=2)
        await anyio.sleep(20)
        assert not second.gateway.acts
        await first.stop()
        await anyio.sleep(8)
        assert second.gateway.acts
        await second.send()
        assert await home.heard() == [("lamp/set", "ON")]


async def test_after_a_crash_the_next_start_acts_at_once() -> None:
    """What a dead one said lies nowhere."""
    async with house("lamp/set") as home:
        first = await home.start()
        await anyio.sleep(10)
        home.broker.links[-1].abort()
        await first.stop()
        again = await home.start()
        await again.send()
        assert await home.heard() == [("lamp/set", "ON")]


@pytest.mark.parametrize("lag", [0.0, 0.001, 0.5, 1.9, 2.0, 2.1])
@pytest.mark.parametrize("seeds", [(1, 2), (2, 1), (3, 4), (4, 3)])
async def test_of_two_that_start_together_one_acts(lag: float, seeds: tuple[int, int]) -> None:
    async with house("lamp/set") as home:
        both = [await home.start("a", seeds[0])]
        await anyio.sleep(lag)
        both.append(await home.start("b", seeds[1]))
        await anyio.sleep(5)
        assert sorted(one.gateway.acts for one in both) == [False, True]
        for one in both:
            await one.send()
        assert await home.heard() == [("lamp/set", "ON")]


@pytest.mark.parametrize("seeds", [(1, 2, 3), (3, 2, 1), (2, 3, 1), (5, 4, 6)])
async def test_after_the_broker_was_away_one_acts(seeds: tuple[int, int, int]) -> None:
    """Each asks on its new link."""
    async with house("lamp/set") as home:
        all_three = [await home.start(f"computer {seed}", seed) for seed in seeds]
        await anyio.sleep(10)
        for link in tuple(home.broker.links):
            link.abort()
        await anyio.sleep(60)
        assert sorted(one.gateway.acts for one in all_three) == [False, False, True]


async def test_other_homes_and_observers_are_no_rivals() -> None:
    async with house() as home:
        first = await home.start("a")
        other = await home.start("b", seed=2, root="home7")
        looks = await home.start("c", act=False)
        await anyio.sleep(10)
        assert (first.gateway.acts, other.gateway.acts, looks.gateway.acts) == (True, True, False)
        assert await looks.troubles() == ()


async def test_the_will_of_one_does_not_speak_for_the_other() -> None:
    """Two of one name share the status topic."""
    async with house(STATUS) as home:
        await home.start()
        second = await home.start(seed=2)
        await anyio.sleep(10)
        await home.heard()
        await second.stop()
        await anyio.sleep(1)
        assert (await home.heard())[-1] == (STATUS, "online")


@pytest.mark.parametrize(
    "payload", [b"", b"x", b"{}", b"[1]", b'{"says":"act"}', b'{"says":"act","id":""}', b"9" * 5000]
)
async def test_rubbish_on_the_topic_changes_nothing(payload: bytes) -> None:
    async with house() as home:
        first = await home.start()
        await home.wire.publish("homebot/acting/home425", payload, qos=1)
        await anyio.sleep(1)
        assert first.gateway.acts


async def test_a_retained_lease_message_is_ignored() -> None:
    async with house() as home:
        word = json.dumps({"says": "act", "id": "0", "name": "old"})
        await home.wire.publish("homebot/acting/home425", word.encode(), qos=1, retain=True)
        first = await home.start()
        await anyio.sleep(1)
        assert first.gateway.acts
