"""What a screen is told of a device in a list; in virtual time."""

import pytest
from tests.discovery.announcements import announce, part_of
from tests.discovery.directory_house import directory

from homebot.devices import names, services
from homebot.devices.part import Part

pytestmark = pytest.mark.virtual_time


async def listed(*parts: Part, name: str = "Device", facts: dict[str, str] | None = None) -> services.ListedDevice:
    async with directory() as house:
        await house.hears(announce("d", *parts, ids=("id:d",), name=name, facts=facts, at=1.0, confirmed=True))
        ask = house.asker.create_client(services.ListDevices, names.LIST_DEVICES)
        (device,) = (await ask.call(services.ListDevices.Request())).devices
        return device


def settable(service_type: str, *capabilities: str, id: str = "p", name: str = "", tag: str = "") -> Part:  # noqa: A002 - as the part calls it
    return part_of(service_type, *capabilities, id=id, name=name, tag=tag, writes=(f"{id}/set",))


@pytest.mark.parametrize(
    ("name", "parts", "asks"),
    [
        ("Front door", [settable("door_lock", "lock")], ["lock"]),
        ("Garage", [settable("window_covering", "movement", "position")], ["movement", "position"]),
        ("Blind", [settable("window_covering", "position")], []),
        ("Water valve", [settable("plug", "on_off")], ["on_off"]),
        ("Sauna", [settable("switch", "on_off")], ["on_off"]),
        ("Lamp", [settable("light", "on_off", "level")], []),
        ("Boiler", [part_of("thermostat", "heating_setpoint", id="p")], []),  # nothing of it can be set
        ("Drive", [settable("closure", "movement"), settable("light", "on_off", id="lamp")], ["movement"]),
    ],
)
async def test_a_screen_knows_which_settings_may_let_in_flood_or_burn(
    name: str, parts: list[Part], asks: list[str]
) -> None:
    assert list((await listed(*parts, name=name)).asks_first) == asks
