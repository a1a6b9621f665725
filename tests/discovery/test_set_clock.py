"""A computer's clock that is set, forward, back, or from 1970 to now: deadlines do not go by it."""

import asyncio
from typing import Literal

import anyio
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.discovery.announcements import announce, part_of, tell
from tests.set_clock import SetClock
from tests.sizes import examples

from homebot.apps import App
from homebot.apps.base import NoSettings
from homebot.devices import DEVICE_CHANGES, DeviceChange, RawMessage
from homebot.discovery import DeviceIndex, Directory, DirectorySettings
from homebot.discovery.record import entry_record, read_entry
from homebot.graph import Graph, Node
from homebot.testing import FakeGateway, FakeGatewaySettings, VirtualTimeLoop

pytestmark = pytest.mark.slow

Step = tuple[Literal["speak", "pass", "set", "restart"], float]

HOUR, YEAR = 3600.0, 365 * 86_400.0
STALE_AFTER, FORGET_AFTER = 60.0, 600.0

steps = st.lists(
    st.one_of(
        st.tuples(st.just("speak"), st.integers(0, 2).map(float)),
        st.tuples(st.just("pass"), st.floats(0.5, 300.0)),
        st.tuples(st.just("restart"), st.just(0.0)),
        st.tuples(st.just("set"), st.floats(-60 * YEAR, 60 * YEAR)),
    ),
    min_size=1,
    max_size=25,
)


async def life(moves: list[Step], wall: float, *, is_set: bool) -> list[tuple[float, str, str]]:
    """When what happened to which device."""
    clock = SetClock(wall)
    graph = Graph(clock)
    happened: list[tuple[float, str, str]] = []
    async with Node(graph, "fake", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        gateway = FakeGateway(node, FakeGatewaySettings(stale_after=STALE_AFTER))

        def on_change(change: DeviceChange) -> None:
            happened.append((round(clock.monotonic(), 3), change.kind, change.device.id))

        watcher.create_subscription(DeviceChange, DEVICE_CHANGES, on_change, 1000)
        moves = [*moves]
        while moves:
            async with Node(graph, "discovery") as its_node, anyio.create_task_group() as tasks:
                directory = Directory(its_node, DirectorySettings(forget_after=FORGET_AFTER))
                await tasks.start(directory.serve)
                while moves and (move := moves.pop(0))[0] != "restart":
                    if move[0] == "speak":
                        gateway.sees(f"lights/{move[1]:.0f}")
                    elif move[0] == "pass":
                        await anyio.sleep(move[1])
                    elif is_set:
                        clock.wall += move[1]
                    await anyio.sleep(0.01)
                tasks.cancel_scope.cancel()
    return happened


@pytest.mark.no_cover
@settings(max_examples=examples(150))
@example([("speak", 0.0), ("set", HOUR), ("pass", 5.0)], 1.8e9)
@example([("speak", 0.0), ("set", 10 * YEAR), ("pass", 5.0)], 1.8e9)
@example([("speak", 0.0), ("set", -HOUR), ("pass", 100.0)], 1.8e9)
@example([("set", 56 * YEAR), ("speak", 0.0), ("pass", 5.0)], 0.0)
@example([("speak", 0.0), ("set", 56 * YEAR), ("pass", 5.0), ("restart", 0.0), ("pass", 5.0)], 0.0)
@example([("speak", 0.0), ("pass", 100.0), ("set", -HOUR), ("restart", 0.0), ("pass", 1.0)], 1.8e9)
@given(steps, st.sampled_from([0.0, 1.8e9, 2.2e9]))
def test_what_happens_to_devices_is_the_same_however_the_clock_is_set(moves: list[Step], wall: float) -> None:
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        undisturbed = runner.run(life(moves, 1.8e9, is_set=False))
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        assert runner.run(life(moves, wall, is_set=True)) == undisturbed


def test_what_is_newer_counts_also_where_the_clock_was_set_back() -> None:
    """Of two announcements of one part; and when it was last seen, and how often it speaks."""
    index = DeviceIndex(forget_after=HOUR)
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("mac:aabbccddeeff",), name="Lamp", at=5000)
    own = announce(
        "z", part_of("light", "on_off", id="s"), convention="zigbee2mqtt", ids=("mac:aabbccddeeff",), at=5000
    )
    index.observe(lamp, 1.0)
    index.observe(own, 1.0)
    index.report(tell(lamp, "on_off", True, part="l", at=5002), 3.0)
    index.report(tell(own, "on_off", False, part="s", at=1404), 5.0)
    (device,) = index.devices()
    assert [(one.value.plain(), one.told_at.sec) for one in device.states] == [(False, 1404)]
    assert (device.last_seen.sec, device.expires.sec) == (1404, 1404 + 3600)
    entry = index.entry(device.id)
    assert entry is not None
    assert entry.report_interval.gaps == (2.0,)


def test_the_index_file_keeps_how_long_a_device_may_be_silent() -> None:
    """Not until when, and not less because the clock was set between what it announced and what it said."""
    index = DeviceIndex(forget_after=HOUR)
    lamp = announce("l", part_of("light", "on_off", id="l"), name="Lamp", at=5000, confirmed=True)
    index.observe(lamp, 1.0)
    index.report(tell(lamp, "on_off", True, part="l", at=5000 + 10 * YEAR), 2.0)
    entry = index.entry("lamp")
    assert entry is not None
    after = DeviceIndex(forget_after=HOUR)
    after.restore(read_entry("lamp", entry_record(entry)), 50.0, wall=9000.0)
    assert after.expire(50.0 + HOUR - 1) == 0
    assert after.devices()[0].expires.sec == 9000 + 3600
    assert after.expire(50.0 + HOUR) == 1


@pytest.mark.virtual_time
@pytest.mark.parametrize("jump", [HOUR, -HOUR, 10 * YEAR])
async def test_a_listener_gets_what_came_since_it_began_and_nothing_older(jump: float) -> None:
    """Whether the clock was set before it came or between that and its asking."""
    graph = Graph(clock := SetClock(1.8e9))
    heard: list[bytes] = []

    class Listener(App):
        async def run(self) -> None:
            await anyio.sleep(5)
            for device in await self.devices.find("lights"):
                await self.devices.listen(device, self.on_message)
            await anyio.sleep_forever()

        async def on_message(self, message: RawMessage) -> None:
            heard.append(message.payload)

    async with (
        Node(graph, "fake", namespace="/gateway") as node,
        Node(graph, "discovery") as its_node,
        anyio.create_task_group() as tasks,
    ):
        await tasks.start(Directory(its_node, DirectorySettings()).serve)
        gateway = FakeGateway(node, FakeGatewaySettings(stale_after=STALE_AFTER))
        await gateway.says("lights/lamp", "before")
        await anyio.sleep(1)
        async with Node(graph, "listener") as listener:
            tasks.start_soon(Listener(listener, NoSettings()).run)
            await anyio.sleep(1)
            clock.wall += jump
            await gateway.says("lights/lamp", "after")
            await anyio.sleep(10)
        tasks.cancel_scope.cancel()
    assert heard == [b"after"]
