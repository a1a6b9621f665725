"""The engine for gateways of any protocol, beyond the contract: what it refuses, counts and keeps."""

import gc
import tracemalloc
from collections.abc import Iterator
from contextlib import AbstractAsyncContextManager
from dataclasses import replace

import anyio
import pytest
from tests.gateways.watched_gateway import watched

from homebot.devices import GatewayState, RawMessage, Sighting, SubscribeToTopic
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.names import text_address
from homebot.devices.part import Part
from homebot.devices.services import SubscribeToTopicRequest
from homebot.errors import UnableError, UsageError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.announced.work_budget import MESSAGE_WORK, SHARED_BURST
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Node
from homebot.messages import Time
from homebot.testing.gateway_contract.steps import KEPT, kept, listen

pytestmark = pytest.mark.virtual_time

LAMP = GatewayDevice("hall", "Hall", (simple_part("light", settable=("on_off", "level")),), {"manufacturer": "Acme"})


def house(**settings: object) -> AbstractAsyncContextManager[tuple[MemoryGateway, Node]]:
    table = MemoryGatewaySettings.model_validate(settings)
    return watched("memory", lambda node: MemoryGateway(node, table))


async def text_of(gateway: MemoryGateway, watcher: Node, key: str) -> tuple[RawMessage, ...]:
    """What the watcher missed, when it begins to listen to the only part of a device."""
    return await missed_on(gateway, watcher, text_address(key, ""))


async def missed_on(gateway: MemoryGateway, watcher: Node, address: str) -> tuple[RawMessage, ...]:
    """What the watcher missed, when it begins to listen to *address*."""
    client = watcher.create_client(SubscribeToTopic, gateway.names.subscribe)
    since = Time.from_seconds(gateway.node.graph.clock.now() - 1)
    request = SubscribeToTopicRequest(topic=address, listener=watcher.full_name, since=since)
    return (await client.call(request)).missed


async def test_a_late_joiner_gets_each_value_of_a_part_that_reports_them_one_by_one() -> None:
    """The newest of each comes last, also where one report had several."""
    async with house() as (gateway, watcher):
        gateway.devices.put(LAMP, "new")
        await gateway.devices.report("hall", {"on_off": True, "level": 10.0})
        await gateway.devices.report("hall", {"level": 20.0})
        await gateway.devices.report("hall", {"on_off": False})
        late = kept(listen(watcher, Report, gateway.names.readings))
    readings = [one for report in late for one in report.readings]
    assert {one.capability: one.value.plain() for one in readings} == {"on_off": False, "level": 20.0}


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


async def test_a_listed_device_without_a_description_may_be_asleep() -> None:
    async with house() as (gateway, _):
        gateway.devices.put(replace(LAMP, parts=()), "it is listed")
        with pytest.raises(UnableError, match="it may be asleep: wake it, and try again"):
            gateway.devices.engine.find_part("hall", "")


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


async def test_a_device_counts_as_stale_after_a_time_of_its_own_or_that_of_the_gateway() -> None:
    """An advertising interval, or the lifetime of a registration."""
    async with house(stale_after=600.0) as (gateway, watcher):
        sightings = listen(watcher, Sighting, gateway.names.received_topics)
        gateway.devices.put(LAMP, "new")
        gateway.devices.put(GatewayDevice("tag", "Tag", stale_after=30.0), "new")
        silences = {one.key: one.expires_at.to_seconds() - one.seen_at.to_seconds() for one in kept(sightings)}
        assert silences == {"hall": pytest.approx(600.0), "tag": pytest.approx(30.0)}


async def test_a_device_described_anew_keeps_what_is_known_of_it() -> None:
    """Whether it can be reached, its last texts, and its last raw messages."""
    renamed = replace(LAMP, name="Corridor", raw_address="radio/hall")
    async with house() as (gateway, watcher):
        reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
        gateway.devices.put(replace(LAMP, raw_address="radio/hall"), "new")
        gateway.devices.report_reachable("hall", reachable=False)
        await gateway.devices.report("hall", {"on_off": True})
        await gateway.devices.deliver_raw("hall", b"\x01")
        gateway.devices.put(renamed, "renamed")
        kept(reports)
        gateway.devices.report_reachable("hall", reachable=False)
        assert kept(reports) == []
        assert [one.text() for one in await text_of(gateway, watcher, "hall")] == ["on"]
        assert [one.payload for one in await missed_on(gateway, watcher, "radio/hall")] == [b"\x01"]


async def test_a_raw_address_of_before_or_of_a_device_that_is_gone_keeps_nothing() -> None:
    async with house() as (gateway, watcher):
        gateway.devices.put(replace(LAMP, raw_address="radio/1"), "new")
        await gateway.devices.deliver_raw("hall", b"\x01")
        gateway.devices.put(replace(LAMP, raw_address="radio/2"), "moved")
        await gateway.devices.deliver_raw("hall", b"\x02")
        assert await missed_on(gateway, watcher, "radio/1") == ()
        gateway.devices.remove("hall", "sold")
        assert await missed_on(gateway, watcher, "radio/2") == ()


async def test_a_raw_address_of_two_devices_stays_with_the_one_that_is_left() -> None:
    """Such as a bus on which both are heard."""
    async with house() as (gateway, watcher):
        gateway.devices.put(replace(LAMP, raw_address="bus/1"), "new")
        gateway.devices.put(replace(LAMP, key="stairs", name="Stairs", raw_address="bus/1"), "new")
        await gateway.devices.deliver_raw("stairs", b"\x01")
        gateway.devices.remove("hall", "sold")
        assert gateway.devices.owner_of("bus/1") == ("stairs", "Stairs")
        assert [one.payload for one in await missed_on(gateway, watcher, "bus/1")] == [b"\x01"]


async def test_nothing_is_kept_of_the_raw_messages_of_devices_without_a_raw_address() -> None:
    """Nobody can have missed any, and strangers that come and go would take ever more memory."""
    async with house() as (gateway, _):
        await come_and_go(gateway, "first")
        tracemalloc.start()
        try:
            before, _ = tracemalloc.get_traced_memory()
            for number in range(100):
                await come_and_go(gateway, f"stranger {number}")
            gc.collect()
            assert tracemalloc.get_traced_memory()[0] - before < 200_000
        finally:
            tracemalloc.stop()


async def come_and_go(gateway: MemoryGateway, key: str) -> None:
    """Have a device found, heard ten times, and removed."""
    gateway.devices.put(replace(LAMP, key=key), "new")
    for number in range(10):
        await gateway.devices.deliver_raw(key, bytes([number]) * 4000)
    gateway.devices.remove(key, "gone")


async def test_a_raw_address_is_no_place_for_texts() -> None:
    """An app that reads text would take a raw message for one."""
    async with house() as (gateway, watcher):
        gateway.devices.put(replace(LAMP, raw_address="radio/hall"), "new")
        (sighting,) = kept(listen(watcher, Sighting, gateway.names.received_topics))
        assert sighting.address == text_address("hall", "")


async def test_an_unknown_sender_that_breaks_rules_is_dropped_whatever_it_calls_itself_and_a_device_is_not() -> None:
    async with house() as (gateway, _):
        gateway.devices.put(LAMP, "new")
        number = 0
        while gateway.devices.admits(f"stranger {number}"):
            gateway.devices.reject(f"stranger {number}", b"?" * 100_000, "noise")
            number += 1
        assert number == -(-SHARED_BURST // (MESSAGE_WORK + 100_000))
        assert not gateway.devices.admits("another one")
        assert gateway.devices.admits("hall")
        assert gateway.devices.counters.rejected == number
        assert [one.offender for one in gateway.devices.engine.quarantine.quarantined()] == ["unknown sender"]
        await anyio.sleep(1.0)
        assert gateway.devices.admits("another one")


async def test_messages_that_are_sent_once_wait_in_order_and_are_read_when_there_is_work_to_spare() -> None:
    """For a gateway that asks the quarantine itself."""
    read: list[bytes] = []

    async def read_next(messages: Iterator[bytes]) -> bool:
        message = next(messages, None)
        if message is not None:
            read.append(message)
        return message is not None

    async with house() as (gateway, _), anyio.create_task_group() as tasks:
        quarantine = gateway.devices.engine.quarantine
        tasks.start_soon(quarantine.serve, read_next)
        gateway.devices.put(LAMP, "new")
        while gateway.devices.admits("hall"):
            gateway.devices.reject("hall", b"?" * 100_000, "noise")
        assert quarantine.must_wait(b"1", "hall", b"1")
        assert quarantine.must_wait(b"2", "hall", b"2")
        assert not quarantine.must_wait(b"3", "stranger", b"3")
        await anyio.sleep(0.01)
        assert read == []
        await anyio.sleep(5.0)
        assert read == [b"1", b"2"]
        tasks.cancel_scope.cancel()


async def test_a_state_that_was_published_already_is_nothing_new() -> None:
    """A gateway that looks in turns says each time how its link is."""
    async with house() as (gateway, watcher):
        states = watcher.create_subscription(GatewayState, gateway.names.state)
        for _ in range(3):
            gateway.set_unavailable("the radio is unplugged")
        for _ in range(3):
            gateway.set_available()
        assert [one.state for one in kept(states)] == ["unavailable", "active"]


async def test_a_device_with_too_many_parts_is_refused_and_what_was_known_stays() -> None:
    """As of every gateway: what a network can make a house remember has limits."""
    parts = tuple(Part(id=str(number), service_type="light") for number in range(1001))
    async with house() as (gateway, watcher):
        gateway.devices.put(LAMP, "new")
        gateway.devices.put(replace(LAMP, parts=parts), "grown")
        (sighting,) = kept(listen(watcher, Sighting, gateway.names.received_topics))
        assert sighting.parts == LAMP.parts
        assert gateway.devices.counters.devices_refused == 1
        await gateway.devices.report("hall", {"on_off": True})
        assert [one.text() for one in await text_of(gateway, watcher, "hall")] == ["on"]
