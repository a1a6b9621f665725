"""Who moved in a room after its doors were closed is there until one opens."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome
from tests.control.policies.houses import START, make_device, new_timeline

from homebot.control.policies.facts import Facts
from homebot.control.policies.house import House
from homebot.control.policies.presence_guard import PresenceGuardSettings, remaining_person
from homebot.devices import Device
from homebot.devices.device_view import DeviceView
from homebot.devices.handles import Light
from homebot.devices.outcomes import Refused

DOORS = ("Bath door",)
GUARD = {"absent_after": 300, "doors": {"bath": ["Door"]}}


def door(*, value: bool | None, since: float, name: str = "Bath door") -> Device:
    """A contact that has been so since that many seconds after the start."""
    return make_device(name, "contact_sensor", room="hall", since=START + since, values={"contact": value})


def motion(*, value: bool | None, since: float) -> Device:
    return make_device("motion", "occupancy_sensor", room="bath", since=START + since, values={"occupancy": value})


def facts(*told: Device, now: float) -> Facts:
    """The facts after devices told these one after another."""
    house = House()
    for sequence, device in enumerate(told):
        house.put(DeviceView(device, sequence))
    house.is_known = True
    return Facts(START + now, START + now, None, house, new_timeline)


def stays(*told: Device, now: float = 10_000.0, doors: tuple[str, ...] = DOORS) -> bool:
    settings = PresenceGuardSettings.model_validate({"absent_after": 300, "doors": {"bath": doors} if doors else {}})
    return remaining_person("bath", settings, facts(*told, now=now)) is not None


def test_who_moved_after_the_door_was_closed_is_there_hours_later() -> None:
    assert stays(door(value=False, since=10), motion(value=True, since=20), motion(value=False, since=80))


def test_who_moved_before_the_door_was_closed_may_have_left() -> None:
    """The sensor holds the motion for a while."""
    assert not stays(motion(value=True, since=5), door(value=False, since=10), motion(value=False, since=80))


def test_who_still_moved_long_after_the_door_was_closed_is_there() -> None:
    assert stays(motion(value=True, since=5), door(value=False, since=10), motion(value=False, since=310))
    assert not stays(motion(value=True, since=5), door(value=False, since=10), motion(value=False, since=309))


def test_a_sensor_that_fell_silent_has_seen_what_it_has_seen() -> None:
    assert stays(door(value=False, since=10), motion(value=True, since=20), motion(value=None, since=80))


def test_an_open_door_and_one_of_which_nothing_is_known_let_everybody_out() -> None:
    now = motion(value=True, since=20), motion(value=False, since=80)
    assert not stays(door(value=False, since=10), *now, door(value=True, since=100))
    assert not stays(door(value=False, since=10), *now, door(value=None, since=100))
    assert not stays(door(value=False, since=10), *now, doors=("Bath door", "Window"))
    assert not stays(door(value=False, since=10), *now, doors=())


def test_a_door_that_was_opened_since_lets_everybody_out() -> None:
    now = motion(value=True, since=20), motion(value=False, since=80)
    assert not stays(door(value=False, since=10), *now, door(value=True, since=100), door(value=False, since=103))


def test_of_two_doors_the_one_that_was_closed_last_counts() -> None:
    doors = door(value=False, since=10), door(value=False, since=50, name="Window")
    assert not stays(*doors, motion(value=True, since=20), motion(value=False, since=80), doors=("Bath door", "Window"))
    assert stays(*doors, motion(value=True, since=60), motion(value=False, since=80), doors=("Bath door", "Window"))


def test_two_contacts_of_one_name_are_none() -> None:
    twice = (
        door(value=False, since=10),
        make_device("it", "contact_sensor", values={"contact": False}, name="Bath door"),
    )
    assert not stays(*twice, motion(value=True, since=20), motion(value=False, since=80))


def test_a_sensor_that_never_detected_anybody_shows_nothing() -> None:
    assert not stays(door(value=False, since=10), motion(value=False, since=5000))
    assert not stays(door(value=False, since=10))


async def put_bath(home: Home) -> None:
    home.put("lamp", "light", "on_off", area="Bath")
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="Bath")
    home.put("door", "contact_sensor", readable=("contact",), area="Hall")
    await anyio.sleep(0.1)
    await home.report("lamp", "on_off", True)
    await move(home)


async def move(home: Home) -> None:
    """Let there be motion for a minute."""
    await home.report("motion", "occupancy", True)
    await anyio.sleep(60)
    await home.report("motion", "occupancy", False)
    await anyio.sleep(1)


async def swing(home: Home) -> None:
    """Let somebody go through the door."""
    await home.report("door", "contact", True)
    await anyio.sleep(3)
    await home.report("door", "contact", False)
    await anyio.sleep(1)


@pytest.mark.virtual_time
async def test_no_lamp_goes_off_over_somebody_in_the_bath_until_the_door_opens(open_home: OpenHome) -> None:
    async with open_home(presence_guard=GUARD) as home:
        await put_bath(home)
        await swing(home)
        await move(home)
        lamp = await home.handle(Light, "lamp")
        await anyio.sleep(1800)
        refused = await lamp.turn_off()
        assert isinstance(refused, Refused)
        assert refused.policy == "presence_guard"
        assert refused.reason == (
            "somebody is in Bath: occupancy of motion was on 1861 s ago, and no door has been opened since"
        )
        await swing(home)
        await anyio.sleep(301)
        assert (await lamp.turn_off()).succeeded


@pytest.mark.virtual_time
async def test_without_a_contact_on_the_door_nobody_is_there_after_a_while(open_home: OpenHome) -> None:
    async with open_home(presence_guard=True) as home:
        await put_bath(home)
        await swing(home)
        await move(home)
        await anyio.sleep(1800)
        assert (await (await home.handle(Light, "lamp")).turn_off()).succeeded
