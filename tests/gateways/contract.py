"""The contract of gateways as one suite, which runs over every gateway.

A gateway joins by a class derived from :class:`GatewayContract` with a ``lamp`` of its own, a :class:`Lamp` in
its world of which the test plays the device's side, and a ``gateway`` to that world.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import TypeVar

import anyio
import pytest
from structlog.testing import capture_logs
from tests.held_clock import HeldClock
from tests.patience import PATIENCE

from homebot.devices import GatewayState, RawCommand, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.exposure import ExposedDevice, ExposedState
from homebot.devices.gateway_messages import SENDS_NOTHING, Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse, Quarantine
from homebot.devices.names import text_address
from homebot.devices.part import Capability, Part
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.value import PlainValue, Reading, Value
from homebot.gateways import Gateway
from homebot.gateways.base import UNAVAILABLE, Delivery
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile, Subscription
from homebot.messages import Message
from homebot.runtime.muted_node import MutedNode

__all__ = ["GatewayContract", "Lamp", "Neighbour", "running"]

MessageT = TypeVar("MessageT", bound=Message)

KEPT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ROBOT = ExposedDevice(
    id="robot",
    name="Robot",
    parts=(Part(id="", service_type="light", capabilities=(Capability(name="on_off", settable=True),)),),
)


class Lamp(ABC):
    """A lamp that can be turned on and off, in the world of a gateway: its broker, its folder, its radio.

    A protocol without lamps has something else that is on or off, and says which capability that is.

    Args:
        key: What the gateway calls it.
        part: The id of its part.
        address: Where it reports raw messages.

    Attributes:
        gateway: The gateway that runs there now.
        name: What people call it.
        service_type: The type of its part.
        capability: The capability that is true while it is on.
    """

    gateway: Gateway
    name = "Hall"
    service_type = "light"
    capability = "on_off"

    def __init__(self, key: str, part: str = "", *, address: str) -> None:
        self.key = key
        self.part = part
        self.address = address

    @abstractmethod
    async def announce(self) -> None:
        """Come into the house as :attr:`name`, off."""

    @abstractmethod
    async def report(self, *, on: bool) -> None:
        """Report whether it is on."""

    @abstractmethod
    def raw(self, *, on: bool) -> bytes:
        """Return the raw message by which it does."""

    @abstractmethod
    async def misbehave(self) -> None:
        """Let a stranger send so much that breaks the rules that no gateway should go on reading all of it."""

    @abstractmethod
    async def withdraw(self) -> None:
        """Go out of the house."""

    @abstractmethod
    async def told(self) -> bool | None:
        """Return what it was told last, whether to be on; None for nothing."""

    @abstractmethod
    async def lose_link(self) -> None:
        """Take the world away from the gateway, which may not run yet."""

    @abstractmethod
    async def mend_link(self) -> None:
        """Give it back."""

    async def meet_again(self) -> None:  # noqa: B027 - no duty: most networks keep what their devices announced
        """Do what a device does by itself when a gateway was restarted."""


class Neighbour(ABC):
    """Another system in the world of a gateway, to which homebot exposes devices."""

    @abstractmethod
    async def seen(self, name: str) -> bool | None:
        """Return whether the device that is called *name* is on; None where it is not seen, or says neither."""

    @abstractmethod
    async def turn(self, name: str, *, on: bool) -> None:
        """Tell it to be on or off."""


@asynccontextmanager
async def running(gateway: Gateway) -> AsyncIterator[None]:
    """Run *gateway* inside the block."""
    async with anyio.create_task_group() as tasks:
        await tasks.start(gateway.serve)
        yield
        tasks.cancel_scope.cancel()


class GatewayContract:
    """What every gateway does.

    Attributes:
        name: What the gateway is called.
        time_is_virtual: Whether it costs nothing to wait.
        takes_commands: Whether devices of its protocol can be told anything; of others, all commands are refused.
        tells_goodbye: Whether its protocol says that a device was taken away.
    """

    name = "gateway"
    time_is_virtual = False
    takes_commands = True
    tells_goodbye = True

    def lamp(self) -> AbstractAsyncContextManager[Lamp]:
        """Return a lamp in its world, which is there inside the block."""
        raise NotImplementedError

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        """Return a gateway to the world of *lamp*, with these *settings* beside those that lead there."""
        raise NotImplementedError

    def neighbour(self, lamp: Lamp) -> Neighbour | None:
        """Return another system in the world of *lamp*; None where homebot cannot expose anything there."""
        del lamp
        return None

    @asynccontextmanager
    async def house(self, *, is_muted: bool = False, **settings: object) -> AsyncIterator[tuple[Lamp, Node]]:
        """Run the gateway with its lamp, and another node on its graph, whose clock is a :class:`HeldClock`."""
        graph = Graph(HeldClock())
        async with (
            self.lamp() as lamp,
            Node(graph, "watcher") as watcher,
            self.started(lamp, graph, settings, is_muted=is_muted),
        ):
            yield lamp, watcher

    @asynccontextmanager
    async def started(
        self, lamp: Lamp, graph: Graph, settings: dict[str, object], *, is_muted: bool = False
    ) -> AsyncIterator[None]:
        """Run a gateway to the world of *lamp*; *is_muted* as in a dry run, of which it does not know."""
        async with MutedNode(graph, self.name) if is_muted else Node(graph, self.name, namespace="/gateway") as node:
            lamp.gateway = self.gateway(lamp, node, settings)
            async with running(lamp.gateway):
                yield

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
            assert (part.id, part.service_type) == (lamp.part, lamp.service_type)
            (on_off,) = (one for one in part.capabilities if one.name == lamp.capability)
            assert on_off.readable
            assert on_off.settable is self.takes_commands

    async def test_a_report_has_the_values_of_the_vocabulary(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            report = await reported(lamp, reports, on=True)
            assert (report.gateway, report.key, report.retained) == (lamp.gateway.node.name, lamp.key, False)
            assert report.stream
            assert [one.part for one in report.readings] == [lamp.part]

    async def test_a_late_joiner_gets_the_newest_sighting_and_report_of_each_device(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            await reported(lamp, reports, on=True)
            assert (await first(listen(watcher, Sighting, lamp.gateway.names.received_topics))).key == lamp.key
            late = listen(watcher, Report, lamp.gateway.names.readings)
            assert [value(lamp, one) for one in kept(late) if value(lamp, one) is not None] == [True]

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
        if not self.tells_goodbye:
            pytest.skip("its protocol does not say that a device was taken away")
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
            if not self.takes_commands:
                assert (response.success, response.problem, response.unable) == (False, "refused", True)
                assert lamp.capability in response.message
                return
            assert (response.success, response.message, response.problem) == (True, "", "")
            await becomes_told(lamp, on=True)

    async def test_a_gateway_that_only_observes_refuses_and_sends_nothing(self) -> None:
        async with self.house(act=False) as (lamp, watcher):
            await announced(lamp, watcher)
            response = await send(lamp, watcher)
            assert (response.success, response.problem, response.unable) == (False, "refused", False)
            assert lamp.gateway.observes_because in response.message
            assert await lamp.told() is None

    async def test_in_a_dry_run_no_command_comes_to_it_although_it_would_act(self) -> None:
        """As one of somebody else may, which ignores `act`."""
        async with self.house(is_muted=True) as (lamp, watcher):
            await announced(lamp, watcher)
            assert lamp.gateway.acts
            response = await send(lamp, watcher)
            assert (response.success, response.problem, response.message) == (False, "refused", SENDS_NOTHING)
            out = watcher.create_publisher(RawCommand, lamp.gateway.names.out)
            assert out.reaches(lamp.gateway.names.node)
            await out.send(RawCommand(address=text_address(lamp.key, lamp.part), payload="on"))
            offers = watcher.create_publisher(ExposedDevice, lamp.gateway.names.offers, KEPT)
            offers.publish(ROBOT)
            await anyio.wait_all_tasks_blocked()
            assert await lamp.told() is None
            counts = {one.name: one.count for one in (await healthy(lamp, watcher)).counts}
            assert not {name: count for name, count in counts.items() if name.startswith("commands") and count}
            if (neighbour := self.neighbour(lamp)) is not None:
                assert await neighbour.seen(ROBOT.name) is None

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
        if not self.takes_commands and "value" in change:
            pytest.skip("no value is right")
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
            if self.takes_commands:
                response = await send(lamp, watcher)
                assert (response.success, response.problem) == (False, "unreachable")
            assert [one.key for one in kept(listen(watcher, Sighting, lamp.gateway.names.received_topics))] == [
                lamp.key
            ]
            await lamp.mend_link()
            with anyio.fail_after(PATIENCE):
                while (await states.receive()).state != "active":
                    pass
            assert (await send(lamp, watcher)).success is self.takes_commands

    async def test_before_it_has_its_link_it_is_ready_and_unavailable_and_logs_it(self) -> None:
        graph = Graph()
        async with self.lamp() as lamp, Node(graph, "watcher") as watcher:
            await lamp.lose_link()
            with capture_logs() as lines:
                async with self.started(lamp, graph, {}):
                    states = listen(watcher, GatewayState, lamp.gateway.names.state)
                    state = await first(states)
                    assert state.state == "unavailable"
                    assert state.reason
                    (line,) = (line for line in lines if line["event"] == UNAVAILABLE)
                    assert state.reason in line["message"]
                    await lamp.mend_link()
                    with anyio.fail_after(PATIENCE):
                        while (await states.receive()).state != "active":
                            pass
                    await announced(lamp, watcher)

    async def test_after_a_restart_it_finds_its_devices_again_by_the_same_keys(self) -> None:
        """Its topics were empty; nobody else announces them for it."""
        graph = Graph()
        async with self.lamp() as lamp, Node(graph, "watcher") as watcher:
            async with self.started(lamp, graph, {}):
                before = await announced(lamp, watcher)
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            assert kept(sightings) == []
            async with self.started(lamp, graph, {}):
                await lamp.meet_again()
                again = await first(sightings)
                assert (again.key, again.name, again.parts) == (before.key, before.name, before.parts)
                assert (await send(lamp, watcher)).success is self.takes_commands

    @pytest.mark.parametrize("delivery", ["inbox", "mirror"])
    async def test_raw_messages_come_to_the_inbox_of_who_asks_or_to_the_topic_of_the_device(
        self, delivery: Delivery
    ) -> None:
        async with self.house(delivery=delivery) as (lamp, watcher):
            await announced(lamp, watcher)
            response = await subscribe(lamp, watcher, lamp.address)
            mirror = lamp.gateway.names.received_data(lamp.name)
            assert response.data_topic == {"inbox": f"{watcher.full_name}/inbox", "mirror": mirror}[delivery]
            messages = watcher.create_subscription(RawMessage, response.data_topic)
            await lamp.report(on=True)
            with anyio.fail_after(PATIENCE):
                while (message := await messages.receive()).payload != lamp.raw(on=True):
                    pass
            assert (message.gateway, message.key) == (lamp.gateway.node.name, lamp.key)
            assert (message.address, message.retained) == (lamp.address, False)

    async def test_a_peer_that_breaks_the_rules_is_quarantined_and_the_others_are_read(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            quarantines = listen(watcher, Quarantine, lamp.gateway.names.quarantine)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            clock = watcher.graph.clock
            assert isinstance(clock, HeldClock)
            with clock.held():  # budgets get nothing back, however long the machine takes
                await lamp.misbehave()
                quarantine = await first(quarantines)
                await lamp.report(on=True)
                await reported(lamp, reports, on=True)
                health = await healthy(lamp, watcher)
            assert (quarantine.gateway, quarantine.is_over) == (lamp.gateway.node.name, False)
            assert quarantine.offender
            assert quarantine.why
            assert quarantine.until.to_seconds() > quarantine.since.to_seconds()
            assert [one.offender for one in health.quarantined] == [quarantine.offender]
            counts = {one.name: one.count for one in health.counts}
            assert counts["quarantines"] == 1
            assert counts["rejected"] + counts["announcements_rejected"] > 0

    async def test_a_quarantine_ends_when_the_peer_is_quiet(self) -> None:
        if not self.time_is_virtual:
            pytest.skip("it is quiet for ten seconds")
        async with self.house() as (lamp, watcher):
            quarantines = listen(watcher, Quarantine, lamp.gateway.names.quarantine)
            await lamp.misbehave()
            begun, over = await first(quarantines), await first(quarantines)
            assert (over.offender, over.is_over) == (begun.offender, True)
            assert (await healthy(lamp, watcher)).quarantined == ()
            assert kept(listen(watcher, Quarantine, lamp.gateway.names.quarantine)) == []

    async def test_what_homebot_exposes_is_seen_by_other_systems_and_commanded_by_them(self) -> None:
        async with self.house() as (lamp, watcher):
            neighbour = self.neighbour(lamp)
            if neighbour is None:
                pytest.skip("its protocol shows homebot's own devices to nobody")
            commands = watcher.create_subscription(Command, lamp.gateway.names.offer_commands)
            offers = watcher.create_publisher(ExposedDevice, lamp.gateway.names.offers, KEPT)
            states = watcher.create_publisher(ExposedState, lamp.gateway.names.offer_reports, KEPT)
            offers.publish(ROBOT)
            states.publish(
                ExposedState(id=ROBOT.id, readings=(Reading(part="", capability="on_off", value=Value.of(True)),))
            )
            await becomes_seen(neighbour, on=True)
            await neighbour.turn(ROBOT.name, on=False)
            command = await first(commands)
            assert (command.key, command.part, command.capability) == (ROBOT.id, "", "on_off")
            assert command.value.plain() is False
            offers.publish(ROBOT.model_copy(update={"is_withdrawn": True}))
            await becomes_seen(neighbour, on=None)
            assert kept(listen(watcher, Sighting, lamp.gateway.names.received_topics)) == []

    async def test_its_health_counts_commands(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            await send(lamp, watcher)
            await send(lamp, watcher, capability="volume")
            health = await healthy(lamp, watcher)
            counts = {one.name: one.count for one in health.counts}
            done, refused = (1, 1) if self.takes_commands else (0, 2)
            assert (counts["commands"], counts["commands_refused"], counts["commands_failed"]) == (done, refused, 0)
            assert counts["reports"] >= 1
            assert (health.troubles, health.quarantined) == ((), ())

    async def test_a_part_is_listened_to_and_told_as_text(self) -> None:
        """As the light service does it."""
        if not self.takes_commands:
            pytest.skip("nobody tells it anything")
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            address = text_address(lamp.key, lamp.part)
            response = await subscribe(lamp, watcher, address)
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
    await reported(lamp, reports, on=False)
    return sighting


async def reported(lamp: Lamp, reports: Subscription[Report], *, on: bool) -> Report:
    with anyio.fail_after(PATIENCE):
        while value(lamp, report := await reports.receive()) is not on:
            pass
    return report


def value(lamp: Lamp, report: Report) -> PlainValue:
    """Whether the report says that the lamp is on; None where it is about something else."""
    return next((one.value.plain() for one in report.readings if one.capability == lamp.capability), None)


async def send(lamp: Lamp, watcher: Node, **change: object) -> SendCommandResponse:
    """Tell the lamp to be on, or what else is said."""
    asked = {"key": lamp.key, "part": lamp.part, "capability": lamp.capability, "value": Value.of(True), **change}
    client = watcher.create_client(SendCommand, lamp.gateway.names.send_command)
    return await client.call(Command.model_validate(asked), timeout=PATIENCE)


async def subscribe(lamp: Lamp, watcher: Node, address: str) -> SubscribeToTopicResponse:
    """Let the watcher listen to *address*."""
    client = watcher.create_client(SubscribeToTopic, lamp.gateway.names.subscribe)
    response = await client.call(SubscribeToTopicRequest(topic=address, listener=watcher.full_name), timeout=PATIENCE)
    assert (response.success, response.message) == (True, "")
    return response


async def healthy(lamp: Lamp, watcher: Node) -> HealthResponse:
    """Return the health of the gateway."""
    return await watcher.create_client(GetHealth, lamp.gateway.names.health).call(HealthRequest(), timeout=PATIENCE)


async def becomes_seen(neighbour: Neighbour, *, on: bool | None) -> None:
    with anyio.fail_after(PATIENCE):
        while await neighbour.seen(ROBOT.name) is not on:  # noqa: ASYNC110 - another system tells nobody
            await anyio.sleep(0.02)


async def becomes_told(lamp: Lamp, *, on: bool) -> None:
    with anyio.fail_after(PATIENCE):
        while await lamp.told() is not on:  # noqa: ASYNC110 - a device tells nobody
            await anyio.sleep(0.02)
