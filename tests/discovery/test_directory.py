"""The directory on the graph: what it announces, what it answers, and how it comes back; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial

import anyio
import pytest
from structlog.testing import capture_logs
from tests.discovery.announcements import announce, part_of, tell

from homebot.clock import Clock, ManualClock
from homebot.devices import (
    DEVICE_CHANGES,
    FIND_DEVICES,
    GET_INDEX_DATA,
    DeviceChange,
    FindDevices,
    GetIndexData,
    Sighting,
)
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.devices.value import Reading, Value
from homebot.discovery import Directory, DirectorySettings
from homebot.graph import Client, Graph, Node, Subscription, qos_profile_latched
from homebot.messages import String, Time
from homebot.testing import FakeGateway, FakeGatewaySettings

pytestmark = pytest.mark.virtual_time


STALE_AFTER = 60.0


@dataclass
class Layer:
    """A gateway, a directory, and who watches both."""

    graph: Graph
    gateway: FakeGateway
    directory: Directory
    watcher: Node
    changes: Subscription[DeviceChange]

    async def heard(self) -> list[tuple[str, str]]:
        """Kind and device of each change since the last call."""
        await anyio.sleep(0.001)
        found: list[tuple[str, str]] = []
        while (change := self.changes.take()) is not None:
            found.append((change.kind, change.device.id))
        return found


@asynccontextmanager
async def directory_on(graph: Graph, **settings: object) -> AsyncIterator[Directory]:
    async with Node(graph, "discovery") as node, anyio.create_task_group() as tasks:
        directory = Directory(node, DirectorySettings.model_validate(settings))
        await tasks.start(directory.serve)
        yield directory
        tasks.cancel_scope.cancel()


@asynccontextmanager
async def layer(clock: Clock | None = None, **settings: object) -> AsyncIterator[Layer]:
    graph = Graph(clock)
    async with (
        Node(graph, "fake", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        directory_on(graph, **settings) as directory,
    ):
        gateway = FakeGateway(node, FakeGatewaySettings(stale_after=STALE_AFTER))
        changes = watcher.create_subscription(DeviceChange, DEVICE_CHANGES, qos_profile=100)
        yield Layer(graph, gateway, directory, watcher, changes)


async def test_every_change_is_announced_once() -> None:
    """Appeared, changed, removed; a device that only goes on talking is no news."""
    async with layer() as house:
        house.gateway.sees("lights/lamp")
        house.gateway.sees("lights/lamp")
        assert await house.heard() == [("appeared", "lights/lamp")]
        house.gateway.sees("lights/lamp", name="reading lamp")
        assert await house.heard() == [("changed", "lights/lamp")]
        house.gateway.removes("lights/lamp")
        assert await house.heard() == [("removed", "lights/lamp")]


async def announce_mixed(house: Layer, *, seconds: float) -> None:
    """Announce eight parts of each of twenty lamps, the first of all lamps first, and then others for *seconds*."""
    for number in range(8):
        for lamp in range(20):
            key, relay = f"{lamp}/{number}", part_of("switch", "on_off", id=f"relay{number}")
            house.gateway.publish_sighting(announce(key, relay, ids=(f"id:lamp{lamp}",), gateway="fake"))
        await anyio.sleep(0.05)
    for number in range(int(seconds / 0.05)):
        house.gateway.publish_sighting(announce(f"other{number}", part_of("light", "on_off", id="l"), gateway="fake"))
        await anyio.sleep(0.05)


async def test_devices_that_are_announced_in_many_mixed_messages_are_published_twice() -> None:
    """At once, and once more with all that they are when no more announcements come."""
    async with layer() as house:
        await announce_mixed(house, seconds=0)
        await anyio.sleep(0.2)
        heard = await house.heard()
    assert sorted(kind for kind, _ in heard) == ["appeared"] * 20 + ["changed"] * 20
    assert {len(device.parts) for device in house.directory.index.devices()} == {8}


async def test_devices_that_are_announced_in_one_burst_are_published_once_with_all_their_parts() -> None:
    async with layer() as house:
        for number in range(8):
            for lamp in range(20):
                relay = part_of("switch", "on_off", id=f"relay{number}")
                sighting = announce(f"{lamp}/{number}", relay, ids=(f"id:lamp{lamp}",), gateway="fake")
                house.gateway.publish_sighting(sighting)
            for _ in range(3):  # as a gateway that reads a broker's messages
                await anyio.lowlevel.checkpoint()
        await anyio.sleep(0.2)
        found = [(change.kind, len(change.device.parts)) for change in iter(house.changes.take, None)]
    assert found == [("appeared", 8)] * 20


async def test_the_first_reachability_of_devices_of_a_burst_is_published_with_them() -> None:
    """It often comes by another topic, after the last announcement."""
    light = part_of("light", "on_off", id="l")
    lamps = [announce(f"{lamp}", light, ids=(f"id:lamp{lamp}",), gateway="fake") for lamp in range(20)]
    async with layer() as house:
        for lamp in lamps:
            house.gateway.publish_sighting(lamp)
        for lamp in lamps:
            house.gateway.reports.publish(tell(lamp, REACHABLE, True, retained=True))
            for _ in range(3):  # as a gateway that reads a broker's messages
                await anyio.lowlevel.checkpoint()
        await anyio.sleep(0.2)
        found = [(change.kind, change.device.reachable.state) for change in iter(house.changes.take, None)]
    assert found == [("appeared", "yes")] * 20


async def test_a_flood_of_others_keeps_no_device_from_being_published_whole() -> None:
    """Ten seconds later at the latest."""
    async with layer() as house:
        seen = anyio.Event()

        def look(change: DeviceChange) -> None:
            if len(change.device.parts) == 8:
                seen.set()

        house.watcher.create_subscription(DeviceChange, DEVICE_CHANGES, look, 1000)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(partial(announce_mixed, house, seconds=30))
            with anyio.fail_after(11):
                await seen.wait()
            tasks.cancel_scope.cancel()


async def test_silence_makes_stale_and_then_forgotten_at_its_time() -> None:
    """A day passes in no time; a device that spoke meanwhile has its own deadline."""
    async with layer(forget_after=1000.0) as house:
        house.gateway.sees("lights/a")
        await anyio.sleep(10)
        house.gateway.sees("lights/b")
        await house.heard()

        await anyio.sleep(STALE_AFTER - 10)
        assert await house.heard() == [("stale", "lights/a")]
        await anyio.sleep(10)
        assert await house.heard() == [("stale", "lights/b")]
        house.gateway.sees("lights/b")
        assert await house.heard() == [("returned", "lights/b")]
        await anyio.sleep(1000)
        assert await house.heard() == [("stale", "lights/b"), ("removed", "lights/a")]


async def test_a_device_whose_time_is_shorter_than_all_others_is_not_kept_waiting() -> None:
    """The sleep until the next deadline is cut short, also by a sighting that changes nothing else."""
    async with layer() as house, Node(house.graph, "hasty", namespace="/gateway") as node:
        hasty = FakeGateway(node, FakeGatewaySettings(stale_after=1.0))
        house.gateway.sees("lights/calm")
        await house.heard()
        hasty.sees("lights/brief")
        await anyio.sleep(1)
        assert await house.heard() == [("appeared", "lights/brief"), ("stale", "lights/brief")]


async def test_index_data_is_answered_as_the_thesis_did() -> None:
    """One entry for each device of the type, and all of them for no type; nothing is not an error."""
    async with layer() as house:
        for key in ("lights/b", "windows/w", "lights/a"):
            house.gateway.sees(key)
        await house.heard()
        ask = house.watcher.create_client(GetIndexData, GET_INDEX_DATA)

        lights = await ask.call(GetIndexData.Request(service_type="lights"))
        assert lights.topics == ("lights/a/out", "lights/b/out")
        assert [(one.gateway, one.topic, one.device_id) for one in lights.entries] == [
            ("fake", "lights/a/out", "lights/a"),
            ("fake", "lights/b/out", "lights/b"),
        ]
        assert lights.device_ids == ("lights/a", "lights/b")
        assert len((await ask.call(GetIndexData.Request(service_type=""))).topics) == 3
        assert (await ask.call(GetIndexData.Request(service_type="locks"))).topics == ()


async def test_devices_are_found_with_the_number_of_the_last_change_in_the_answer() -> None:
    """So that a follower can tell what is in it."""
    async with layer() as house:
        house.gateway.sees("lights/a")
        await anyio.sleep(0.001)
        change = house.changes.take()
        found = await house.watcher.create_client(FindDevices, FIND_DEVICES).call(FindDevices.Request())
        assert change is not None
        assert found.devices == (change.device,)
        assert found.sequence == change.sequence


async def test_a_restarted_directory_knows_everybody_before_it_answers() -> None:
    """What gateways keep for late joiners is taken in first; its numbers go on above the old ones."""
    graph = Graph()
    async with Node(graph, "fake", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        gateway = FakeGateway(node)
        ask = watcher.create_client(FindDevices, FIND_DEVICES)
        async with directory_on(graph):
            gateway.sees("lights/a")
            gateway.sees("lights/gone")
            await anyio.sleep(0.001)
            first = await ask.call(FindDevices.Request())
        gateway.sees("lights/gone", kind="removed")
        gateway.sees("lights/new")
        async with directory_on(graph):
            second = await ask.call(FindDevices.Request())

    assert [device.id for device in first.devices] == ["lights/a", "lights/gone"]
    assert [device.id for device in second.devices] == ["lights/a", "lights/new"]
    assert second.sequence > first.sequence


async def test_a_gateway_that_comes_later_or_again_is_heard() -> None:
    """Also when more came onto the graph at once than a watcher can remember."""
    async with layer() as house:
        for _ in range(2):
            async with Node(house.graph, "late", namespace="/gateway") as node:
                for number in range(10_001):
                    node.create_publisher(String, f"noise_{number}").close()
                FakeGateway(node).sees("lights/late")
                await anyio.sleep(0.001)
        assert ("appeared", "lights/late") in await house.heard()
        assert "/gateway/late/received_topics" in house.directory._sources


async def test_a_topic_of_sightings_that_another_type_holds_is_left_out_and_told() -> None:
    """An outsider's type of the same name must not end the directory."""

    class Impostor(Sighting):
        ros_type = Sighting.ros_type

    async with layer() as house, Node(house.graph, "impostor", namespace="/gateway") as node:
        with capture_logs() as lines:
            node.create_publisher(Impostor, "/gateway/impostor/received_topics")
            await anyio.sleep(0.001)
        assert [line["event"] for line in lines] == ["discovery.source_not_followed"]
        house.gateway.sees("lights/lamp")
        assert await house.heard() == [("appeared", "lights/lamp")]


async def test_a_flood_of_devices_is_all_announced_but_not_all_told() -> None:
    """Fifty lines in ten seconds; the next tells how many were held back."""
    async with layer() as house:
        with capture_logs() as lines:
            for number in range(500):
                house.gateway.sees(f"lights/{number:03}")
            assert len(await house.heard()) == 500
            assert len(lines) == 50
            await anyio.sleep(10)
            house.gateway.sees("lights/last")
            await anyio.sleep(0.001)
        assert lines[-1]["message"].endswith("(and 450 more like this)")


async def test_a_lost_link_is_one_line_and_one_when_it_is_back() -> None:
    """All devices of it are announced; one that becomes unavailable by itself keeps its line."""
    async with layer() as house:
        for number in range(60):
            house.gateway.sees(f"lights/{number:02}")
        await house.heard()
        with capture_logs() as lines:
            house.gateway.publish_state("unavailable", "connection refused")
            assert len(await house.heard()) == 60
            house.gateway.publish_state("unavailable", "no answer")
            house.gateway.publish_state("active")
            assert len(await house.heard()) == 60
            house.gateway.devices.report_reachable("lights/07", reachable=False)
            await house.heard()
        told = [line["message"] for line in lines if line["event"].startswith("discovery.")]
    assert told[:2] == [
        "60 devices cannot be reached: fake is unavailable: connection refused",
        "fake reaches 60 devices again",
    ]
    assert [text.partition(" changed")[0] for text in told[2:]] == ["lights/07"]


async def test_who_asks_in_a_flood_is_answered_before_it_ends() -> None:
    """As many devices come in a turn as a gateway hands over in one, and no answer waits for the last of them."""
    answered = anyio.Event()

    async def ask(find: Client[FindDevicesRequest, FindDevicesResponse]) -> None:
        await find.call(FindDevicesRequest())
        answered.set()

    clock = ManualClock()
    async with layer(clock) as house, anyio.create_task_group() as tasks:
        find = house.watcher.create_client(FindDevices, FIND_DEVICES)
        for turn in range(100):
            if turn == 20:
                tasks.start_soon(ask, find)
            for number in range(30):
                house.gateway.sees(f"lights/{turn}-{number}")
            clock.advance(0.01)
            await anyio.lowlevel.checkpoint()
            if answered.is_set():
                break
        assert answered.is_set()
        tasks.cancel_scope.cancel()


async def test_many_devices_that_fall_silent_together_are_all_announced() -> None:
    """In portions, so that others get their turn."""
    async with layer() as house:
        for number in range(500):
            house.gateway.sees(f"lights/{number:03}")
        await house.heard()
        await anyio.sleep(STALE_AFTER)
        assert await house.heard() == [("stale", f"lights/{number:03}") for number in range(500)]


async def test_a_full_index_is_told_once() -> None:
    """And the devices that are in it are served on."""
    async with layer(max_devices=1) as house:
        house.gateway.sees("lights/a")
        await anyio.sleep(0.001)
        with capture_logs() as lines:
            for number in range(10):
                house.gateway.sees(f"lights/extra{number}")
            assert await house.heard() == [("appeared", "lights/a")]
        assert [line["event"] for line in lines] == ["discovery.index_full"]


async def test_the_directory_follows_gateways_only_on_their_own_topics_in_their_own_name() -> None:
    """Whoever else publishes sightings or reports, on a gateway's topic too, makes no device and changes none."""
    async with (
        layer() as house,
        Node(house.graph, "door") as outsider,
        Node(house.graph, "bad", namespace="/gateway") as bad,
    ):
        house.gateway.sees("lights/lamp")
        assert await house.heard() == [("appeared", "lights/lamp")]
        forged = house.directory.index.table.sources["fake", "lights/lamp"].sighting.model_copy(
            update={"key": "lights/forged"}
        )
        for topic in ("/gateway/fake/received_topics", "sightings", "/gateway/forged/received_topics"):
            outsider.create_publisher(Sighting, topic, qos_profile_latched).publish(forged)
        own = bad.create_publisher(Sighting, "/gateway/bad/received_topics", qos_profile_latched)
        own.publish(forged)
        own.publish(forged.model_copy(update={"gateway": "no gateway!"}))
        assert await house.heard() == []
        own.publish(forged.model_copy(update={"gateway": "bad"}))
        assert await house.heard() == [("appeared", "lights/forged")]


async def test_a_report_of_an_outsider_changes_no_device() -> None:
    async with layer() as house, Node(house.graph, "door") as outsider:
        house.gateway.sees("lights/lamp", confirmed=False)
        await house.heard()
        report = Report(
            gateway="fake",
            key="lights/lamp",
            readings=(Reading(part="", capability=REACHABLE, value=Value.of(False)),),
            address="said",
            retained=False,
            received_at=Time.from_seconds(1.0),
        )
        outsider.create_publisher(Report, "/gateway/fake/readings").publish(report)
        await house.heard()
        (device,) = house.directory.index.devices()
        assert device.reachable.state == "unknown"
