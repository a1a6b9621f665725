"""Waits for a state that lasts, over a restart."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import pytest
from anyio.abc import TaskGroup
from tests.devices.test_devices import expect_one_problem
from tests.discovery.announcements import announce, part_of, tell
from tests.set_clock import SetClock

from homebot.devices import Devices
from homebot.devices.handles import ContactSensor
from homebot.discovery import Directory, DirectorySettings
from homebot.features.routines.watches import PressWatch, follow_matches
from homebot.graph import Graph, Node
from homebot.mqtt.options import MqttOptions
from homebot.testing import FakeGateway, VirtualHouse, virtual_house_of
from homebot.words.triggers import read_press, read_state

pytestmark = pytest.mark.virtual_time

HOUR = 3600.0
OPEN = read_state("front door open for 10m")
DOOR = {"name": "Front door", "unique_id": "d", "device_class": "door", "state_topic": "d"}


async def end_of_wait(store: dict[str, Any], start: str, found: str, *told: str) -> str:
    """Return when the wait ends in a house that starts then.

    Args:
        found: The retained state of the door.
        told: What it tells after the first, the second, … minute.
    """
    ends: dict[str, None] = {}

    async def wait(house: VirtualHouse, node: Node) -> None:
        async for _ in follow_matches(node, OPEN, store, is_new=True):
            ends[f"{house.now:%H:%M}"] = None

    async with (
        virtual_house_of(start=f"2026-01-01 {start}") as house,
        Node(house.runtime.graph, "waiter") as node,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(wait, house, node)
        door = house.broker.make_client(MqttOptions.from_url(house.broker.url, client_id="door"))
        async with door.connected():
            await door.publish("d", found.encode(), qos=1, retain=True)
            await door.publish("homeassistant/binary_sensor/d/config", json.dumps(DOOR).encode(), qos=1, retain=True)
        for one in told:
            await house.run_for("1m")
            await house.says("d", one)
        await house.run_for("20m" if not told else "1m")
        tasks.cancel_scope.cancel()
    return " ".join(ends)


@pytest.mark.rooms("homeassistant")
async def test_a_wait_goes_on_after_a_restart_if_the_state_is_found_so() -> None:
    store: dict[str, Any] = {}
    assert not await end_of_wait(store, "08:00", "OFF", "ON")
    assert len(store) == 1
    assert await end_of_wait(store, "08:07", "ON") == "08:11"
    assert store == {}


@pytest.mark.rooms("homeassistant")
async def test_a_wait_that_was_over_meanwhile_ends_at_once() -> None:
    store: dict[str, Any] = {}
    assert not await end_of_wait(store, "08:00", "OFF", "ON")
    assert await end_of_wait(store, "08:20", "ON") == "08:20"


@pytest.mark.rooms("homeassistant")
async def test_a_state_that_begins_anew_is_waited_for_anew() -> None:
    store: dict[str, Any] = {}
    assert not await end_of_wait(store, "08:00", "OFF", "ON")
    assert await end_of_wait(store, "08:07", "OFF", "ON", *["ON"] * 12) == "08:18"


@pytest.mark.rooms("homeassistant")
async def test_what_is_found_so_without_a_wait_before_starts_nothing() -> None:
    assert not await end_of_wait({}, "08:07", "ON")


@asynccontextmanager
async def directory(graph: Graph) -> AsyncIterator[tuple[FakeGateway, Node, TaskGroup]]:
    """A directory with a gateway, a node that may wait, and a task group that is cancelled at the end."""
    async with (
        Node(graph, "fake", namespace="/gateway") as node,
        Node(graph, "discovery") as its_node,
        Node(graph, "waiter") as waiter,
        anyio.create_task_group() as tasks,
    ):
        await tasks.start(Directory(its_node, DirectorySettings()).serve)
        yield FakeGateway(node), waiter, tasks
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("jump", [-HOUR, HOUR, -20 * 365 * 24 * HOUR])
async def test_a_clock_that_is_set_changes_no_wait(jump: float) -> None:
    graph, ends = Graph(clock := SetClock(1.8e9)), []
    door = announce("d", part_of("contact_sensor", "contact", id="c"), name="Front door", gateway="fake")

    async def wait(node: Node) -> None:
        async for _ in follow_matches(node, OPEN, is_new=True):
            ends.append(clock.monotonic())  # noqa: PERF401 - it would be cancelled before it extends

    async with directory(graph) as (gateway, waiter, tasks):
        gateway.publish_sighting(door)
        gateway.reports.publish(tell(door, "contact", False, part="c", at=clock.now()))
        await anyio.sleep(1)
        tasks.start_soon(wait, waiter)
        await anyio.sleep(1)
        clock.wall += jump
        opened = clock.monotonic()
        gateway.reports.publish(tell(door, "contact", True, part="c", at=clock.now()))
        await anyio.sleep(HOUR)
    assert ends == pytest.approx([opened + 600])


async def test_the_first_value_of_a_device_that_told_others_before_starts_nothing() -> None:
    """It may have been so before, as that in the first message of a device."""
    graph, began = Graph(SetClock(1.8e9)), []
    door = announce("d", part_of("contact_sensor", "contact", "battery", id="c"), name="Front door", gateway="fake")

    async def wait(node: Node) -> None:
        async for one in follow_matches(node, read_state("front door open"), is_new=True):
            began.append(one.device.id)  # noqa: PERF401 - it would be cancelled before it extends

    async with directory(graph) as (gateway, waiter, tasks):
        gateway.publish_sighting(door)
        tasks.start_soon(wait, waiter)
        for capability, value, expected in (
            ("battery", 0.8, 0),
            ("contact", True, 0),
            ("contact", False, 0),
            ("contact", True, 1),
        ):
            await anyio.sleep(1)
            gateway.reports.publish(tell(door, capability, value, part="c", at=graph.clock.now()))
            await anyio.sleep(1)
            assert len(began) == expected


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize("device_class", ["moisture", "smoke", "tamper", "motion"])
@pytest.mark.parametrize(
    ("found", "silence", "starts", "danger_starts"),
    [
        ("", 5 * 60, 0, 0),  # a new one tells all that it has
        ("", 0.5 * HOUR, 0, 1),
        ("ON", 0.5 * HOUR, 0, 0),  # retained
        ("OFF", 0.5 * HOUR, 1, 1),
        ("", 3 * HOUR, 0, 1),  # forgotten meanwhile
        ("OFF", 3 * HOUR, 0, 1),
    ],
)
async def test_the_first_value_of_a_device_that_was_known_before_starts_what_waits_for_a_danger(
    device_class: str, found: str, silence: float, starts: int, danger_starts: int
) -> None:
    """A leak sensor that was silent for a week, as it reports nothing but water, told of it in vain."""
    kind = {"name": "Cellar", "unique_id": "s", "device_class": device_class, "state_topic": "s"}
    capability = {"moisture": "water_leak", "motion": "occupancy"}.get(device_class, device_class)
    began: list[str] = []

    async def wait(node: Node) -> None:
        async for one in follow_matches(node, read_state(f"{capability} = true"), is_new=True):
            began.append(one.device.id)  # noqa: PERF401 - it would be cancelled before it extends

    async with (
        virtual_house_of(config={"discovery": {"forget_after": HOUR}}) as house,
        Node(house.runtime.graph, "waiter") as node,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(wait, node)
        sensor = house.broker.make_client(MqttOptions.from_url(house.broker.url, client_id="sensor"))
        async with sensor.connected():
            await sensor.publish("s", found.encode(), qos=1, retain=True)
            await sensor.publish("homeassistant/binary_sensor/s/config", json.dumps(kind).encode(), qos=1, retain=True)
        await house.run_for(silence)
        for value in ("ON", "ON"):
            await house.says("s", value)
            await house.run_for("1m")
        assert len(began) == (starts if device_class == "motion" else danger_starts)
        for value in ("OFF", "ON"):
            await house.says("s", value)
            await house.run_for("1m")
        assert len(began) == 1 + (starts if device_class == "motion" else danger_starts)
        tasks.cancel_scope.cancel()


@pytest.mark.rooms("homeassistant")
async def test_a_press_that_is_told_as_event_and_as_trigger_starts_once_and_two_presses_twice() -> None:
    starts: list[object] = []
    press = read_press("Wall button press")
    assert press is not None
    of_wall = {"device": {"identifiers": ["wallbutton12"], "name": "Wall button"}}
    event = {"unique_id": "a", "state_topic": "wall/event", "event_types": ["single"]}
    trigger = {"automation_type": "trigger", "type": "press", "subtype": "1", "payload": "single", "topic": "wall/told"}
    async with virtual_house_of() as house, Node(house.runtime.graph, "watcher") as node:
        await house.says("homeassistant/event/wall/config", json.dumps(event | of_wall))
        await house.says("homeassistant/device_automation/wall/config", json.dumps(trigger | of_wall))
        PressWatch(node, press, starts.append)
        await house.run_for("1m")
        for presses in (1, 2):
            for _ in range(presses):
                await house.says("wall/event", '{"event_type": "single"}')
                await house.says("wall/told", "single")
            await house.run_for("10s")
        assert len(starts) == 3
        await house.says("wall/told", "single")
        await house.run_for("10s")
        assert len(starts) == 4


@pytest.mark.parametrize("text", ["front door open", "front door open for 5s"])
async def test_a_value_that_is_unknown_for_a_moment_starts_nothing_again_and_ends_no_wait(text: str) -> None:
    """Each restart of Home Assistant makes all values unknown."""
    graph, began = Graph(clock := SetClock(1.8e9)), []
    door = announce("d", part_of("contact_sensor", "contact", id="c"), name="Front door", gateway="fake")
    state = read_state(text)

    async def wait(node: Node) -> None:
        async for _ in follow_matches(node, state, is_new=True):
            began.append(round(clock.monotonic() - opened))  # noqa: PERF401 - it would be cancelled

    async def wait_in_an_app(node: Node) -> None:
        async for _ in Devices(node).follow(ContactSensor).became(is_open=True, lasting=state.lasting):
            began.append(round(clock.monotonic() - opened))  # noqa: PERF401 - it would be cancelled

    async with directory(graph) as (gateway, waiter, tasks):
        gateway.publish_sighting(door)
        for value in (None, True, False):  # the first value may have been so before
            gateway.reports.publish(tell(door, "contact", value, part="c", at=clock.now()))
            await anyio.sleep(1)
            if value is None:
                tasks.start_soon(wait, waiter)
                await anyio.sleep(1)
        opened = clock.monotonic()
        tasks.start_soon(wait_in_an_app, waiter)
        for value in (True, None, True, None, True):
            gateway.reports.publish(tell(door, "contact", value, part="c", at=clock.now()))
            await anyio.sleep(1)
        await anyio.sleep(HOUR)
        assert began == [round(state.lasting)] * 2
        for value in (None, False, None, True):
            gateway.reports.publish(tell(door, "contact", value, part="c", at=clock.now()))
            await anyio.sleep(1)
        await anyio.sleep(HOUR)
    assert len(began) == 4


async def test_a_wait_until_none_is_open_counts_from_the_last_that_closed_not_from_another_value() -> None:
    graph = Graph(clock := SetClock(1.8e9))
    door = announce("d", part_of("contact_sensor", "contact", "battery", id="c"), name="Front door", gateway="fake")
    async with directory(graph) as (gateway, waiter, _):
        gateway.publish_sighting(door)
        gateway.reports.publish(tell(door, "contact", False, part="c", at=clock.now()))
        await anyio.sleep(HOUR)
        gateway.reports.publish(tell(door, "battery", 0.5, part="c", at=clock.now()))
        await anyio.sleep(1)
        began = clock.monotonic()
        await anext(follow_matches(waiter, read_state("no front door open for 10m")))
        assert round(clock.monotonic() - began) == 0


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("haul lamp on", "haul lamp on: no device has the word 'haul'"),
        ("lights on in hal for 5m", "lights on in hal for 5m: no device is in 'hal'; did you mean hall?"),
    ],
)
async def test_a_misspelt_state_is_logged_once_and_waited_for(text: str, problem: str) -> None:
    async with directory(Graph()) as (gateway, waiter, _):
        await expect_one_problem(gateway, waiter, problem, lambda node: anext(follow_matches(node, read_state(text))))
