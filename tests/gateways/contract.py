"""The contract of gateways as one suite, which runs over every gateway.

A gateway joins by a class derived from :class:`GatewayContract` with a ``lamp`` of its own: a :class:`Lamp` in a
gateway that runs, of which the test plays the device's side.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import TypeVar

import anyio
import pytest

from homebot.devices import GatewayState, RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import text_address
from homebot.devices.services import SubscribeToTopicRequest
from homebot.devices.value import PlainValue, Value
from homebot.gateways import Gateway
from homebot.graph import DurabilityPolicy, Node, QoSProfile, Subscription
from homebot.messages import Message

__all__ = ["GatewayContract", "Lamp", "running"]

MessageT = TypeVar("MessageT", bound=Message)

KEPT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PATIENCE = 60.0
"""Seconds: a gateway may wait a while whether an announcement that was withdrawn comes back."""


class Lamp(ABC):
    """A lamp that can be turned on and off, in a gateway that runs.

    Args:
        gateway: The gateway.
        key: What the gateway calls it.
        part: The id of its part.
    """

    def __init__(self, gateway: Gateway, key: str, part: str = "") -> None:
        self.gateway = gateway
        self.key = key
        self.part = part

    @abstractmethod
    async def announce(self) -> None:
        """Come into the house as ``Hall``, off."""

    @abstractmethod
    async def report(self, *, on: bool) -> None:
        """Report whether it is on."""

    @abstractmethod
    async def withdraw(self) -> None:
        """Go out of the house."""

    @abstractmethod
    async def told(self) -> bool | None:
        """Return what it was told last, whether to be on; None for nothing."""

    @abstractmethod
    async def lose_link(self) -> None:
        """Let the gateway lose its devices' world."""

    @abstractmethod
    async def mend_link(self) -> None:
        """Give the gateway its devices' world back."""


@asynccontextmanager
async def running(gateway: Gateway) -> AsyncIterator[None]:
    """Run *gateway* inside the block."""
    async with anyio.create_task_group() as tasks:
        await tasks.start(gateway.serve)
        yield
        tasks.cancel_scope.cancel()


class GatewayContract:
    """What every gateway does."""

    def lamp(self) -> AbstractAsyncContextManager[Lamp]:
        """Return a lamp in a gateway that runs inside the block."""
        raise NotImplementedError

    @asynccontextmanager
    async def house(self) -> AsyncIterator[tuple[Lamp, Node]]:
        """Run the gateway with its lamp, and another node on its graph."""
        async with self.lamp() as lamp, Node(lamp.gateway.node.graph, "watcher") as watcher:
            yield lamp, watcher

    async def test_it_is_ready_and_active_once_it_has_started(self) -> None:
        async with self.house() as (lamp, watcher):
            state = await first(listen(watcher, GatewayState, lamp.gateway.names.state))
            assert (state.state, state.reason, state.acts) == ("active", "", True)

    async def test_a_device_is_sighted_with_its_parts_and_when_it_counts_as_silent(self) -> None:
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            await lamp.announce()
            sighting = await first(sightings)
            assert (sighting.gateway, sighting.key, sighting.name) == (lamp.gateway.node.name, lamp.key, "Hall")
            assert sighting.kind in {"appeared", "updated"}
            assert sighting.expires_at.to_seconds() > sighting.seen_at.to_seconds()
            assert sighting.why
            (part,) = sighting.parts
            assert (part.id, part.service_type) == (lamp.part, "light")
            (on_off,) = (one for one in part.capabilities if one.name == "on_off")
            assert on_off.readable
            assert on_off.settable

    async def test_a_report_has_the_values_of_the_vocabulary(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            report = await reported(reports, on=True)
            assert (report.gateway, report.key, report.retained) == (lamp.gateway.node.name, lamp.key, False)
            assert report.stream
            assert [one.part for one in report.readings] == [lamp.part]

    async def test_a_late_joiner_gets_the_newest_sighting_and_report_of_each_device(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            await reported(reports, on=True)
            assert (await first(listen(watcher, Sighting, lamp.gateway.names.received_topics))).key == lamp.key
            late = listen(watcher, Report, lamp.gateway.names.readings)
            assert [value(one) for one in kept(late) if value(one) is not None] == [True]

    async def test_a_device_that_reports_again_is_sighted_with_a_later_expiry(self) -> None:
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            before = await announced(lamp, watcher)
            await anyio.sleep(1.1)
            await lamp.report(on=True)
            with anyio.fail_after(PATIENCE):
                while (sighting := await sightings.receive()).expires_at == before.expires_at:
                    pass
            assert sighting.expires_at.to_seconds() >= before.expires_at.to_seconds() + 1
            assert sighting.confirmed

    async def test_a_device_that_is_gone_is_removed_and_late_joiners_hear_nothing_of_it(self) -> None:
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            await announced(lamp, watcher)
            await lamp.report(on=True)
            await lamp.withdraw()
            with anyio.fail_after(PATIENCE):
                while (sighting := await sightings.receive()).kind != "removed":
                    pass
            assert sighting.key == lamp.key
            assert kept(listen(watcher, Sighting, lamp.gateway.names.received_topics)) == []
            assert kept(listen(watcher, Report, lamp.gateway.names.readings)) == []

    async def test_a_command_reaches_the_device(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            response = await send(lamp, watcher)
            assert (response.success, response.message, response.problem) == (True, "", "")
            await becomes_told(lamp, on=True)

    async def test_a_gateway_that_only_observes_refuses_and_sends_nothing(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            lamp.gateway.acts = False
            response = await send(lamp, watcher)
            assert (response.success, response.problem, response.unable) == (False, "refused", False)
            assert lamp.gateway.observes_because in response.message
            assert await lamp.told() is None

    @pytest.mark.parametrize(
        ("change", "named"),
        [
            ({"capability": "volume"}, "volume"),
            ({"part": "cellar"}, "cellar"),
            ({"key": "nobody"}, "nobody"),
            ({"value": Value.of("loud")}, "loud"),
            ({"value": Value.of(5.0)}, "5"),
        ],
        ids=["capability", "part", "device", "text", "number"],
    )
    async def test_a_command_that_no_part_can_do_is_refused_with_a_reason_and_nothing_is_sent(
        self, change: dict[str, object], named: str
    ) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            response = await send(lamp, watcher, **change)
            assert (response.success, response.problem, response.unable) == (False, "refused", True)
            assert named in response.message
            assert await lamp.told() is None

    async def test_without_its_link_it_is_unavailable_keeps_its_devices_and_comes_back(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            states = listen(watcher, GatewayState, lamp.gateway.names.state)
            await first(states)
            await lamp.lose_link()
            lost = await first(states)
            assert lost.state == "unavailable"
            assert lost.reason
            response = await send(lamp, watcher)
            assert (response.success, response.problem) == (False, "unreachable")
            assert [one.key for one in kept(listen(watcher, Sighting, lamp.gateway.names.received_topics))] == [
                lamp.key
            ]
            await lamp.mend_link()
            with anyio.fail_after(PATIENCE):
                while (await states.receive()).state != "active":
                    pass
            assert (await send(lamp, watcher)).success

    async def test_its_health_counts_commands(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            await send(lamp, watcher)
            await send(lamp, watcher, capability="volume")
            health = await watcher.create_client(GetHealth, lamp.gateway.names.health).call(HealthRequest())
            counts = {one.name: one.count for one in health.counts}
            assert (counts["commands"], counts["commands_refused"]) == (1, 1)
            assert health.troubles == ()

    async def test_a_part_is_listened_to_and_told_as_text(self) -> None:
        """As the light service does it."""
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            address = text_address(lamp.key, lamp.part)
            client = watcher.create_client(SubscribeToTopic, lamp.gateway.names.subscribe)
            response = await client.call(SubscribeToTopicRequest(topic=address, listener=watcher.full_name))
            assert (response.success, response.message) == (True, "")
            texts = watcher.create_subscription(RawMessage, response.data_topic)
            await lamp.report(on=True)
            with anyio.fail_after(PATIENCE):
                while (text := await texts.receive()).text() != "on":
                    pass
            assert (text.gateway, text.key, text.address) == (lamp.gateway.node.name, lamp.key, address)
            out = watcher.create_publisher(RawCommand, lamp.gateway.names.out, 10)
            out.publish(RawCommand(address=address, payload="on"))
            await becomes_told(lamp, on=True)

    async def test_it_stops_when_it_is_cancelled_and_leaves_nothing_on_the_graph(self) -> None:
        """Another one can be started on the same graph at once."""
        async with self.house() as (lamp, _):
            graph, name = lamp.gateway.node.graph, lamp.gateway.node.full_name
            lamp.gateway.node.close()
            assert not [one.name for one in graph.get_endpoints() if one.node == name]


def listen(watcher: Node, kind: type[MessageT], topic: str) -> Subscription[MessageT]:
    return watcher.create_subscription(kind, topic, qos_profile=KEPT)


def kept(subscription: Subscription[MessageT]) -> list[MessageT]:
    """What late joiners get."""
    return list(iter(subscription.take, None))


async def first(subscription: Subscription[MessageT]) -> MessageT:
    with anyio.fail_after(PATIENCE):
        return await subscription.receive()


async def announced(lamp: Lamp, watcher: Node) -> Sighting:
    """Let the lamp come, and return its first sighting, once its first report was published too."""
    sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
    reports = listen(watcher, Report, lamp.gateway.names.readings)
    await lamp.announce()
    sighting = await first(sightings)
    await reported(reports, on=False)
    return sighting


async def reported(reports: Subscription[Report], *, on: bool) -> Report:
    with anyio.fail_after(PATIENCE):
        while value(report := await reports.receive()) is not on:
            pass
    return report


def value(report: Report) -> PlainValue:
    """Whether the report says that the lamp is on; None where it is about something else."""
    return next((one.value.plain() for one in report.readings if one.capability == "on_off"), None)


async def send(lamp: Lamp, watcher: Node, **change: object) -> SendCommandResponse:
    """Tell the lamp to be on, or what else is said."""
    asked = {"key": lamp.key, "part": lamp.part, "capability": "on_off", "value": Value.of(True), **change}
    client = watcher.create_client(SendCommand, lamp.gateway.names.send_command)
    return await client.call(Command.model_validate(asked))


async def becomes_told(lamp: Lamp, *, on: bool) -> None:
    with anyio.fail_after(PATIENCE):
        while await lamp.told() is not on:  # noqa: ASYNC110 - a device tells nobody
            await anyio.sleep(0.02)
