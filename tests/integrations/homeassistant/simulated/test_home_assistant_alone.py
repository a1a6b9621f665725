"""A family house that Home Assistant alone knows: apps, policies, leases, ``homebot do`` and replay as in any."""

import asyncio
import tomllib
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE
from tests.replay.recorded_days import APPS, FAMILY, MemorySink, diff_of, recording_of, texts
from tests.simulated.families import FAMILIES

from homebot.cli.main import main
from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import DoorLock, Light, WindowCovering
from homebot.devices.outcomes import Outcome, Refused
from homebot.feature_context import RunObserver
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime

pytestmark = pytest.mark.slow

NIGHT = 1_767_225_600.0 + 3 * 3600
"""Three o'clock: the family sleeps, but for Anna."""

ONLY = {"homeassistant"}
WALKS = range(3, 600, 5)
"""Seconds after three."""


def family() -> World:
    """The family home without its robot, which speaks MQTT; Anna walks every five seconds, and touches no lamp."""
    house = tomllib.loads(FAMILY)
    house["house"] |= {"dialect": FAMILIES["home_assistant"], "by_hand": False}
    del house["devices"]["robot"]
    house["errands"] = [one for one in house["errands"] if one["device"] != "robot"]
    walks = [{"at": f"03:{at // 60:02}:{at % 60:02}", "room": "bath" if at % 2 else "bedroom"} for at in WALKS]
    house["people"]["anna"] |= {"speed": 20.0, "asleep": False, "day": walks}
    house["devices"]["stairs_motion"]["hold"] = 0.3
    return parse_world(house, "family.toml", seed=1)


@asynccontextmanager
async def homebot(
    world: World, tables: Mapping[str, object], observers: Mapping[str, RunObserver] | None = None
) -> AsyncIterator[tuple[Runtime, Devices]]:
    """Run it until the block ends; the devices are all known, each by Home Assistant."""
    usual = {"gateways": {"mqtt": {}}, "door": {"port": 0}, "discovery": {"persist": False}}
    clock = LoopClock(NIGHT)
    async with alone_on_loopback(), MemoryBroker(clock=clock) as broker:
        services = [HostedBroker.in_memory(broker)]
        config = parse_config({**usual, **tables}, "test")
        async with (
            Runtime(config, house=world, clock=clock, services=services, observers=observers or {}) as runtime,
            Node(runtime.graph, "judge") as node,
        ):
            devices = Devices(node)
            with anyio.fail_after(PATIENCE):
                while len(found := await devices.find()) < len(world.devices):  # noqa: ASYNC110 - the last may be any
                    await anyio.sleep(0.05)
            assert {route.gateway for one in found for part in one.parts for route in part.routes} == ONLY
            yield runtime, devices


async def do(runtime: Runtime, *words: str) -> int:
    """Run ``homebot do`` as a person does in a terminal."""
    assert runtime.rosbridge is not None
    return await asyncio.to_thread(main, ["do", *words, "--door", f"127.0.0.1:{runtime.rosbridge.port}"])


def policy_of(outcome: Outcome) -> str:
    return outcome.policy if isinstance(outcome, Refused) else str(outcome)


async def until_off(world: World, name: str) -> None:
    with anyio.fail_after(PATIENCE):
        while world.device(name).state() != "off":  # noqa: ASYNC110 - a simulated device has no event for this
            await anyio.sleep(0.02)


@pytest.mark.rooms("recording")
async def test_the_light_service_and_homebot_do_work_and_a_recording_gives_the_same_commands() -> None:
    sink, world = MemorySink(), family()
    async with homebot(world, {"apps": {"light_service": APPS["light_service"]}}, sink.observers()) as (runtime, _):
        assert await do(runtime, "hall_lamp", "on") == 0
        await until_off(world, "hall_lamp")
        assert await do(runtime, "nursery_lamp", "on") == 0
        await until_off(world, "nursery_lamp")
    recording = recording_of(sink.lines)
    lamps = {one.command.device for one in recording.commands if one.command.issuer == "/light_service"}
    assert lamps == {"hall_lamp", "nursery_lamp"}
    diff = await asyncio.to_thread(diff_of, recording)
    assert texts(recording, diff) == []
    assert diff.same >= 2


async def test_lights_out_obeys_the_guard_and_covers_and_locks_obey_quiet_hours_and_leases(
    capsys: pytest.CaptureFixture[str],
) -> None:
    control = {
        "presence_guard": {"absent_after": 1.0},
        "quiet_hours": [{"start": "00:00", "end": "23:59", "commands": ["close window covering", "unlock door lock"]}],
    }
    lights_out = {**APPS["lights_out"], "quiet_after": 1.5}
    world = family()
    async with homebot(world, {"apps": {"lights_out": lights_out}, "control": control}) as (runtime, devices):
        (lamp,) = await devices.find(Light, name="hall_lamp")
        assert await do(runtime, "hall_lamp", "on") == 0
        assert policy_of(await lamp.turn_off()) == "presence_guard"
        (lock,) = await devices.find(DoorLock)
        assert policy_of(await lock.unlock()) == "quiet_hours"
        assert world.device("front_lock").state() == "locked"
        (cover,) = await devices.find(WindowCovering, name="living_cover")
        assert policy_of(await cover.close()) == "quiet_hours"
        async with cover.hold("open", by="judge"):
            assert policy_of(await cover.set_position(40)) == "lease"
            assert await do(runtime, "living_cover", "close") == 1
            assert "refused (lease): held open by judge" in capsys.readouterr().out
        assert await do(runtime, "stairs_lamp", "on") == 0
        await until_off(world, "stairs_lamp")
        assert world.device("hall_lamp").state() == "on"
