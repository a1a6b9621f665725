"""The light service, unchanged, in a house of every family of devices, on a real Mosquitto."""

from __future__ import annotations

from dataclasses import dataclass, field

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.house import SimulatedHouse, World
from homebot.house.devices import SimulatedLamp
from homebot.house.dialects import DIALECTS
from homebot.house.rooms import OUTSIDE, Room, Rooms
from homebot.house.simulated_device import Placed
from homebot.runtime import Runtime

pytestmark = pytest.mark.system


@dataclass(eq=False)
class ToldLamp(SimulatedLamp):
    """A lamp of which a test can wait until it was told to be off."""

    dark: anyio.Event = field(default_factory=anyio.Event)

    def _obey(self, command: str) -> tuple[str, ...]:
        if command == "off":
            self.dark.set()
        return super()._obey(command)


async def test_the_light_service_switches_lamps_of_every_family(mosquitto_url: str) -> None:
    """Those that shone before anybody looked, and those that are lit by hand."""
    lamps = {dialect: ToldLamp(f"{dialect}_lamp", is_on=True) for dialect in DIALECTS}
    rooms = Rooms({OUTSIDE: Room(window=1.0), "hall": Room()}, [])
    world = World(rooms, [Placed(lamp, "hall", dialect=dialect) for dialect, lamp in lamps.items()])
    gateway = {"url": mosquitto_url, "root": "home425", "act": True}
    config = parse_config({"gateways": {"mqtt": gateway}, "apps": {"light_service": {}}}, "test")
    house = SimulatedHouse(mosquitto_url, "home425", world, LoopClock())
    async with Runtime(config, with_door=False), anyio.create_task_group() as tasks:
        await tasks.start(house.serve)
        with anyio.fail_after(PATIENCE):
            for lamp in lamps.values():
                await lamp.dark.wait()
                lamp.dark = anyio.Event()
                house.press(lamp.device_id, "on")
                await lamp.dark.wait()
        assert [lamp.is_on for lamp in lamps.values()] == [False] * len(lamps)
        tasks.cancel_scope.cancel()
