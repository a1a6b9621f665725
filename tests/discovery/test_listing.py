"""What a screen is told of a device in a list; in virtual time."""

from collections.abc import Awaitable

import anyio
import anyio.lowlevel
import pytest
from tests.busy_clock import BusyClock
from tests.discovery.announcements import announce, part_of
from tests.discovery.directory_house import House, directory

from homebot.devices import names, services
from homebot.devices.part import Capability, Part
from homebot.messages.key_value import KeyValue

pytestmark = pytest.mark.virtual_time

ANY = services.ListDevices.Request()


async def listed(
    *parts: Part, name: str = "Device", facts: dict[str, str] | None = None, asked: services.ListDevicesRequest = ANY
) -> services.ListedDevice:
    async with directory() as house:
        await house.hears(announce("d", *parts, ids=("id:d",), name=name, facts=facts, at=1.0, confirmed=True))
        ask = house.asker.create_client(services.ListDevices, names.LIST_DEVICES)
        (device,) = (await ask.call(asked)).devices
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


async def test_a_vacuum_with_a_picture_of_its_map_is_a_vacuum() -> None:
    """It was a camera, the first of its types by the alphabet."""
    assert (await listed(part_of("camera", "image", id="map"), part_of("robotic_vacuum_cleaner", "vacuum"))).type == (
        "robotic_vacuum_cleaner"
    )


async def test_a_screen_knows_the_unit_of_a_value_without_a_standard_meaning() -> None:
    wind = Capability(name="measurement", unit="m/s")
    warmth = Capability(name="temperature", unit="°C")
    device = await listed(Part(id="p", service_type="x_sensor", capabilities=(wind, warmth)))
    assert device.units == (KeyValue(key="p measurement", value="m/s"),)


async def test_a_screen_shows_a_keypad_only_where_a_code_is_needed() -> None:
    panel = Capability(name="alarm", settable=True, code="digits")
    device = await listed(Part(id="p", service_type="x_alarm_panel", capabilities=(panel,), writes=("p/set",)))
    assert device.codes == (KeyValue(key="alarm", value="digits"),)


@pytest.mark.parametrize(
    ("name", "service_type", "tag", "model", "kind"),
    [
        ("Hall", "contact_sensor", "garage_door", "", "garage_door"),
        ("Kitchen window", "contact_sensor", "door", "", "door"),  # the class knows better than a name
        ("Fensterkontakt Küche", "contact_sensor", "", "", "window"),
        ("Haustür", "door_lock", "", "", "door"),
        ("Porte du garage", "contact_sensor", "", "", "garage_door"),
        ("Garage", "window_covering", "", "", "garage_door"),
        ("Puerta principal", "door_lock", "", "", "door"),
        ("Hoftor", "closure", "", "", "gate"),
        ("Cancello", "contact_sensor", "", "", "gate"),
        ("Balkondeur", "contact_sensor", "", "", "door"),
        ("Motor", "window_covering", "", "", ""),
        ("Temperatur", "contact_sensor", "", "", ""),
        ("Sensor 7", "contact_sensor", "", "Window sensor", "window"),
        ("Sensor 7", "contact_sensor", "", "Door and window sensor", ""),
        ("Living room", "window_covering", "blind", "", "blind"),
        ("Door lamp", "light", "", "", ""),
    ],
)
async def test_a_screen_knows_what_opens(name: str, service_type: str, tag: str, model: str, kind: str) -> None:
    part = part_of(service_type, "contact", id="p", tag=tag)
    assert (await listed(part, name=name, facts={"model": model})).kind == kind


@pytest.mark.parametrize(
    ("scope", "rights", "commanded"),
    [
        ((), ("act", "read"), {"light"}),  # without a token
        ((), ("read",), set()),
        (("act: all",), ("act", "read"), {"light", "door_lock"}),
        (("act: light",), ("act", "read"), {"light"}),
        (("act: door_lock",), ("act", "read"), {"door_lock"}),
        (("ask: all",), ("act", "ask", "read"), {"light", "door_lock"}),
    ],
)
async def test_a_screen_shows_buttons_only_for_devices_that_its_token_may_command(
    scope: tuple[str, ...], rights: tuple[str, ...], commanded: set[str]
) -> None:
    asked = services.ListDevices.Request(issuer="client:wall", scope=scope, rights=rights)
    parts = [settable("light", "on_off"), settable("door_lock", "lock"), part_of("contact_sensor", "contact", id="p")]
    assert {part.service_type for part in parts if (await listed(part, asked=asked)).may_act} == commanded


async def _turns_of_others(asking: Awaitable[object]) -> int:
    """Return how many turns others have while *asking* is answered."""
    turns = 0

    async def count() -> None:
        nonlocal turns
        while True:
            await anyio.lowlevel.checkpoint()
            turns += 1

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(count)
        await asking
        tasks.cancel_scope.cancel()
    return turns


async def _hears_lamps(house: House, count: int) -> None:
    lamp = settable("light", "on_off", "level")
    await house.hears(
        *(announce(f"d{n}", lamp, ids=(f"id:{n}",), name=f"Lamp {n}", at=1.0, confirmed=True) for n in range(count))
    )


async def test_others_have_their_turn_while_many_devices_are_listed_or_found() -> None:
    """200 were listed in one turn of 8 to 20 ms; 1,010 were found in one of 110 ms."""
    async with directory(clock=BusyClock()) as house:
        await _hears_lamps(house, 60)
        lists = house.asker.create_client(services.ListDevices, names.LIST_DEVICES)
        finds = house.asker.create_client(services.QueryDevices, names.QUERY_DEVICES)
        await lists.call(ANY)  # what was heard is sorted
        assert await _turns_of_others(lists.call(ANY)) >= 20
        assert await _turns_of_others(finds.call(services.QueryDevices.Request())) >= 20


async def test_a_device_is_described_once_until_it_or_the_rights_of_who_asks_change() -> None:
    async with directory() as house:
        await _hears_lamps(house, 2)
        ask = house.asker.create_client(services.ListDevices, names.LIST_DEVICES)
        first = (await ask.call(ANY)).devices
        again = (await ask.call(ANY)).devices
        assert all(one is other for one, other in zip(first, again, strict=True))
        guest = services.ListDevices.Request(issuer="client:wall", scope=("read",), rights=("read",))
        assert [one.may_act for one in (await ask.call(guest)).devices] == [False, False]
        assert [one.may_act for one in (await ask.call(ANY)).devices] == [True, True]
        await house.place(first[0].id, "kitchen", is_new=True)
        changed = (await ask.call(ANY)).devices
        assert {one.id: one.room for one in changed}[first[0].id] == "kitchen"
