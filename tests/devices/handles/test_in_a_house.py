"""Handles in a simulated house: what an app does reaches devices that speak on MQTT, and what they say comes back."""

from pathlib import Path

import anyio
import pytest

from homebot.devices import Devices
from homebot.devices.handles import Closure, ContactSensor, DoorLock, Handle, Light, Thermostat, WindowCovering
from homebot.errors import RefusedError
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import load_world
from homebot.house.devices import SimulatedLamp
from homebot.testing.virtual_house import virtual_house_of

pytestmark = pytest.mark.virtual_time

HOUSE = """
house.dialect = "homeassistant"
rooms.kitchen = {}
rooms.hall = {}
devices.lamp = { kind = "lamp", room = "kitchen" }
devices.blind = { kind = "cover", room = "kitchen" }
devices.old_lamp = { kind = "lamp", room = "hall", dialect = "thesis" }
"""


@pytest.fixture
def world(tmp_path: Path) -> World:
    file = tmp_path / "house.toml"
    file.write_text(HOUSE)
    return load_world(file)


async def test_an_app_commands_devices_of_any_convention_and_gets_their_outcomes(world: World) -> None:
    """Home Assistant's discovery and the thesis's layout in one house."""
    async with virtual_house_of(world=world) as house, Node(house.runtime.graph, "app") as node:
        devices = Devices(node)
        await anyio.sleep(10)
        new, old = await devices.find(Light)
        assert (new.device.id, new.area, new.on) == ("lamp", "kitchen", False)
        assert (old.device.id, old.area, old.on) == ("lights/old_lamp", "hall", False)

        for lamp in (new, old):
            await lamp.turn_on(level=40, kelvin=2500)
        await anyio.sleep(1)
        lamps = [world.devices[name].device for name in ("lamp", "old_lamp")]
        assert [(one.is_on, one.brightness, one.kelvin) for one in lamps if isinstance(one, SimulatedLamp)] == [
            (True, 0.4, 2500.0)
        ] * 2
        assert (new.on, new.level) == (True, 40.0)
        assert (old.on, old.level, old.kelvin) == (True, 40.0, 2500.0)
        assert await devices.find(Light, area="Kitchen", on=True) == (new,)
        assert await devices.find(Light, on=True, dimmable=True) == (new, old)

        (blind,) = await devices.find(WindowCovering, closed=False)
        assert (await blind.close()).succeeded
        await anyio.sleep(1)
        assert (blind.movement, blind.position) == ("closed", 0.0)
        assert await devices.find(WindowCovering, closed=False) == ()
        with pytest.raises(RefusedError, match=r"tilt of blind#\S+ was refused: it has no such setting; it takes"):
            await blind.set_tilt(50)
        assert await devices.find(DoorLock) == ()


THESIS_HOUSE = """
rooms.hall = { doors = ["outside"] }
devices.window = { kind = "window", room = "hall" }
devices.door = { kind = "lock", room = "hall" }
devices.heating = { kind = "thermostat", room = "hall" }
devices.contact = { kind = "contact", room = "hall" }
devices.cleaner = { kind = "robot", room = "hall" }
"""


@pytest.fixture
def thesis_world(tmp_path: Path) -> World:
    file = tmp_path / "thesis.toml"
    file.write_text(THESIS_HOUSE)
    return load_world(file)


async def test_devices_that_know_words_alone_are_handles_like_all_others(thesis_world: World) -> None:
    """Their topics say what they are, and their words how they are."""
    async with virtual_house_of(world=thesis_world) as house, Node(house.runtime.graph, "app") as node:
        devices = Devices(node)
        await anyio.sleep(10)
        (window,) = await devices.find(Closure, closed=True)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(window.set_position, 50)
            await anyio.sleep(0.5)
            assert (window.movement, window.position) == ("opening", 0.0)
        await anyio.sleep(1)
        assert (window.movement, window.position) == ("stopped", 50.0)
        assert await devices.find(Closure, closed=True) == ()

        (door,) = await devices.find(DoorLock, locked=True)
        await door.unlock()
        await anyio.sleep(5)
        assert (door.state, door.device.service_type) == ("unlocked", "locks")

        (heating,) = await devices.find(Thermostat)
        measured = heating.temperature
        assert measured is not None
        await heating.heat_to(measured + 5)
        await anyio.sleep(1)
        assert (heating.temperature, heating.heating_setpoint) == (measured, measured + 5)

        (contact,) = await devices.find(ContactSensor)
        assert contact.is_open is False
        with pytest.raises(RefusedError, match="it takes no commands"):
            await contact.command("contact", value=True)
        assert len(await devices.find(Handle)) == 5
