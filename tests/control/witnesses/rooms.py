"""Rooms with a sensor that sees what a lamp does."""

from __future__ import annotations

import anyio
from tests.control.conftest import Behaviour, Home, ignore, obey

from homebot.devices import FIND_DEVICES, FindDevices
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Evidence
from homebot.devices.services import FindDevicesRequest

__all__ = ["REPORTED", "WITNESSED", "dark_room", "room", "shining", "telling_changes", "toggle"]

WITNESSED = ("Lux", Evidence.WITNESSED)
REPORTED = ("", Evidence.REPORTED)


def shining(sensor: str, lux: float, after: float = 0.2, capability: str = "illuminance") -> Behaviour:
    """Obey, and let a sensor measure so much more, or nothing, so many seconds later."""

    async def behaviour(home: Home, command: Command) -> None:
        await obey(home, command)
        home.later(after, sensor, capability, lux if command.value.plain() else 0.0)

    return behaviour


async def repeat(home: Home, sensor: str, capability: str) -> None:
    """Let a sensor say every two seconds what it measures, as many do, until it is told to ignore everything."""
    find = home.app.create_client(FindDevices, FIND_DEVICES)
    while home.behaviours.get(sensor) is not ignore:
        for device in (await find.call(FindDevicesRequest())).devices:
            for state in device.states:
                if device.name == sensor.title() and state.capability == capability:
                    await home.report(sensor, capability, state.value.plain())
        await anyio.sleep(2)


async def room(home: Home, **behaviours: Behaviour) -> Light:
    """Put lamps and a light sensor into a room with daylight that was seen to change a little; return the lamp."""
    for name, behaviour in {"lamp": shining("lux", 150.0), **behaviours}.items():
        home.put(name, "light", "on_off", area="Hall")
        home.behaviours[name] = behaviour
        await home.report(name, "on_off", False)
    home.put("lux", "light_sensor", readable=("illuminance",), area="Hall")
    await home.report("lux", "illuminance", 0.0)
    home.tasks.start_soon(repeat, home, "lux", "illuminance")
    lamp = await home.handle(Light, "lamp")
    home.behaviours["lamp"], learnt = obey, home.behaviours["lamp"]
    await lamp.turn_off()  # with the first command control begins to watch
    await anyio.sleep(1)
    for lux in (160.0, 170.0, 180.0, 190.0, 160.0, 0.0, 1.0, 2.0, 1.0, 0.0):
        await home.report("lux", "illuminance", lux)
        await anyio.sleep(10)
    home.behaviours["lamp"] = learnt
    await anyio.sleep(120)
    return lamp


def telling_changes(lux: float = 150.0) -> Behaviour:
    """Obey, and let a sensor tell what it measures then, and nothing else."""
    return shining("lux", lux)


async def dark_room(home: Home, behaviour: Behaviour) -> Light:
    """Put a lamp and a light sensor that reports only changes into a room without windows; return the lamp."""
    home.put("lamp", "light", "on_off", area="Cellar")
    home.put("lux", "light_sensor", readable=("illuminance",), area="Cellar")
    home.behaviours["lamp"] = behaviour
    await home.report("lamp", "on_off", False)
    await home.report("lux", "illuminance", 0.0)
    lamp = await home.handle(Light, "lamp")
    home.behaviours["lamp"] = obey
    await lamp.turn_off()  # with the first command control begins to watch
    home.behaviours["lamp"] = behaviour
    await anyio.sleep(120)
    return lamp


async def toggle(lamp: Light, times: int, gap: float = 40.0) -> list[tuple[str, Evidence]]:
    """Switch a lamp on and off; return the grades."""
    found = []
    for number in range(times):
        outcome = await (lamp.turn_off() if number % 2 else lamp.turn_on())
        assert isinstance(outcome, Confirmed)
        found.append((outcome.witness, outcome.evidence))
        await anyio.sleep(gap)
    return found
