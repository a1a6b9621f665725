"""The engine for gateways of any protocol, beyond the contract: what it refuses, counts and keeps."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.gateways.contract import KEPT, kept, listen, running

from homebot.devices import RawMessage, Sighting, SubscribeToTopic
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.names import text_address
from homebot.devices.part import Capability, Part
from homebot.devices.services import SubscribeToTopicRequest
from homebot.errors import UsageError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Graph, Node

pytestmark = pytest.mark.virtual_time

LAMP = GatewayDevice("hall", "Hall", (simple_part("light", settable=("on_off", "level")),), {"manufacturer": "Acme"})
BUTTON = Part(id="", service_type="button", capabilities=(Capability(name="press"),))


@asynccontextmanager
async def house(**settings: object) -> AsyncIterator[tuple[MemoryGateway, Node]]:
    graph = Graph()
    async with Node(graph, "memory", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        gateway = MemoryGateway(node, MemoryGatewaySettings.model_validate(settings))
        async with running(gateway):
            yield gateway, watcher


async def text_of(gateway: MemoryGateway, watcher: Node, key: str) -> tuple[RawMessage, ...]:
    """What the watcher missed, when it begins to listen to the only part of a device."""
    client = watcher.create_client(SubscribeToTopic, gateway.names.subscribe)
    request = SubscribeToTopicRequest(topic=text_address(key, ""), listener=watcher.full_name)
    return (await client.call(request)).missed


async def test_who_listens_later_gets_the_last_state_as_one_that_was_kept() -> None:
    """No broker keeps it, so the gateway does."""
    async with house() as (gateway, watcher):
        gateway.devices.put(LAMP, "new")
        await gateway.devices.report("hall", {"on_off": True})
        await gateway.devices.report("hall", {"on_off": False})
        await anyio.sleep(100)
        missed = await text_of(gateway, watcher, "hall")
    assert [(one.text(), one.retained) for one in missed] == [("off", True)]


@pytest.mark.parametrize(
    "values", [{"on_off": "yes"}, {"level": float("nan")}, {"volume": 5.0}, {"level": True}, {"on_off": 1.0}]
)
async def test_a_value_that_the_part_cannot_have_reported_is_refused_and_counted(values: dict[str, float]) -> None:
    """The others of the same report are published."""
    async with house() as (gateway, watcher):
        reports = listen(watcher, Report, gateway.names.readings)
        gateway.devices.put(LAMP, "new")
        await gateway.devices.report("hall", {**values, **({"level": 5.0} if "on_off" in values else {"on_off": True})})
        (report,) = kept(reports)
        assert [one.capability for one in report.readings] == ["level" if "on_off" in values else "on_off"]
        assert gateway.devices.counters.readings_refused == 1


async def test_a_report_of_an_unknown_device_or_part_is_counted_and_not_published() -> None:
    async with house() as (gateway, watcher):
        gateway.devices.put(LAMP, "new")
        await gateway.devices.report("nobody", {"on_off": True})
        await gateway.devices.report("hall", {"on_off": True}, "cellar")
        assert kept(listen(watcher, Report, gateway.names.readings)) == []
        assert gateway.devices.counters.readings_refused == 2


async def test_an_unknown_value_is_reported_as_unknown() -> None:
    async with house() as (gateway, watcher):
        gateway.devices.put(LAMP, "new")
        await gateway.devices.report("hall", {"on_off": None})
        (report,) = kept(listen(watcher, Report, gateway.names.readings))
        assert report.readings[0].value.plain() is None


async def test_an_event_is_heard_once_and_by_no_late_joiner() -> None:
    async with house() as (gateway, watcher):
        now = watcher.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
        gateway.devices.put(GatewayDevice("bell", "Bell", (BUTTON,)), "new")
        await gateway.devices.report("bell", {"press": "single"})
        await gateway.devices.report("bell", {"press": "single"})
        assert [one.readings[0].value.plain() for one in kept(now)] == ["single", "single"]
        assert kept(listen(watcher, Report, gateway.names.readings)) == []


async def test_reachable_is_reported_when_it_changes_and_the_device_stays() -> None:
    """Advertised and reachable are two facts."""
    async with house() as (gateway, watcher):
        sightings = listen(watcher, Sighting, gateway.names.received_topics)
        reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
        gateway.devices.put(LAMP, "new")
        heard = []
        for reachable in (True, False, False, None):
            gateway.devices.report_reachable("hall", reachable=reachable)
            heard += [(one.readings[0].capability, one.readings[0].value.plain()) for one in kept(reports)]
        assert heard == [(REACHABLE, True), (REACHABLE, False), (REACHABLE, None)]
        assert [one.kind for one in kept(sightings)] == ["appeared"]


async def test_a_device_described_anew_is_sighted_at_once_and_one_that_is_the_same_once_a_second() -> None:
    async with house() as (gateway, watcher):
        sightings = listen(watcher, Sighting, gateway.names.received_topics)
        for _ in range(3):
            gateway.devices.put(LAMP, "still there")
        assert [one.kind for one in kept(sightings)] == ["appeared"]
        gateway.devices.put(GatewayDevice("hall", "Corridor", LAMP.parts), "renamed")
        assert [(one.kind, one.name) for one in kept(sightings)] == [("updated", "Corridor")]
        await anyio.sleep(1.1)
        gateway.devices.put(GatewayDevice("hall", "Corridor", LAMP.parts), "still there")
        assert [one.why for one in kept(sightings)] == ["still there"]


async def test_a_device_too_many_is_refused_and_counted() -> None:
    async with house(max_devices=1) as (gateway, watcher):
        gateway.devices.put(LAMP, "new")
        gateway.devices.put(GatewayDevice("other", "Other"), "new")
        assert [one.key for one in kept(listen(watcher, Sighting, gateway.names.received_topics))] == ["hall"]
        assert gateway.devices.keys == ("hall",)
        assert gateway.devices.counters.devices_refused == 1


@pytest.mark.parametrize(
    ("service_type", "capability", "named"), [("lamp", "on_off", "'lamp'"), ("light", "onoff", "'onoff'")]
)
def test_a_part_of_no_type_or_capability_of_the_vocabulary_is_refused(
    service_type: str, capability: str, named: str
) -> None:
    with pytest.raises(UsageError, match=named):
        simple_part(service_type, settable=(capability,))
