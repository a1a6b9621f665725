"""A day on the wire goes as the day that is played, but for what happens to the wire.

Its devices are those of ``homebot.integrations.thesis``.
"""

from datetime import timedelta

import pytest
from hypothesis import given, settings
from tests.sizes import size

from homebot.apps import App
from homebot.errors import UsageError
from homebot.house.kinds import FAULTS
from homebot.mqtt.options import MqttOptions
from homebot.testing import Day, DayEvent, VirtualHouse, live_day, virtual_house_of
from homebot.testing.day_event import read_time
from homebot.testing.strategies import days, houses
from homebot.testing.virtual_house import parse_time

pytestmark = pytest.mark.virtual_time

LONG = float(size(600, 1800))
WITH_POWER = houses(faults=set(FAULTS) - {"unplugged"}, max_devices=3)
HOUSE = Day.parse('rooms.hall.doors = ["outside"]\ndevices.lamp = { kind = "lamp", room = "hall" }').house


def a_day(*happenings: DayEvent, start: str = "08:00") -> Day:
    return Day(HOUSE, happenings, read_time(start), 3600.0)


def at(time: str) -> float:
    return read_time(time)


async def lived(day: Day) -> tuple[tuple[DayEvent, ...], str]:
    """What found nothing to do, and what happened."""
    start = parse_time("2026-01-01") + timedelta(seconds=day.start)
    async with virtual_house_of(world=day.world(), start=start) as house:
        return await day.live(house), house.world.event_log.text()


@given(days(WITH_POWER, what=["press", "tell"], max_length="2h"))
@settings(max_examples=5, derandomize=True)
def test_where_the_wire_holds_a_day_goes_as_it_is_played(day: Day) -> None:
    assert live_day(day).event_log.text() == day.play().text()


@given(days(houses(kinds=["lamp", "window"], max_devices=2, faults=set(FAULTS)), max_length="1h"))
@settings(max_examples=4, derandomize=True)
def test_a_day_on_the_wire_is_the_same_each_time(day: Day) -> None:
    text = live_day(day, "light_service", seed=3).event_log.text()
    assert live_day(day, "light_service", seed=3).event_log.text() == text


@pytest.mark.no_cover
@pytest.mark.parametrize("fault", sorted(FAULTS))
def test_whatever_is_wrong_with_a_lamp_time_goes_on(fault: str) -> None:
    """Also where an app insists: the light service tells it off each time it says on."""
    lamp = {"kind": "lamp", "room": "hall", "is_on": True, "faults": {fault: {}}}
    day = Day({"rooms": {"hall": {}}, "devices": {"lamp": lamp}}, (), 0.0, LONG)
    assert live_day(day, "light_service").now == pytest.approx(LONG, abs=0.001)


def test_an_app_acts_on_what_happens() -> None:
    world = live_day(a_day(DayEvent(at("08:30"), "press", "lamp", "on")), "light_service")
    assert world.event_log.text() == (
        "0 08:30:00.000 lamp switch on\n0 08:30:00.000 lamp says on\n"
        "0 08:30:00.000 lamp told off\n0 08:30:00.000 lamp says off\n"
    )
    assert world.now == pytest.approx(at("09:00"), abs=0.001)


async def test_what_is_told_while_the_broker_is_away_is_lost() -> None:
    """And is named afterwards; when the broker is back, commands come through."""
    lost = DayEvent(at("08:10"), "tell", "lamp", "on")
    cut = DayEvent(at("08:11"), "cut", "lamp")
    pulled = DayEvent(at("08:12"), "pull", "lamp", lasts=60.0)
    kept = DayEvent(at("08:40"), "tell", "lamp", "0.5")
    day = a_day(DayEvent(at("08:05"), "restart", lasts=600.0), lost, cut, pulled, kept)
    assert await lived(day) == ((lost, cut, pulled), "0 08:40:00.000 lamp told 0.5\n0 08:40:00.000 lamp says 0.5\n")


async def test_what_is_told_over_a_pulled_cable_comes_when_it_is_plugged_in() -> None:
    """Also where two pull the same cable: the later one counts."""
    day = a_day(
        DayEvent(at("08:10"), "pull", "lamp", lasts=120.0),
        DayEvent(at("08:11"), "pull", "lamp", lasts=300.0),
        DayEvent(at("08:12"), "tell", "lamp", "on"),
    )
    assert await lived(day) == ((), "0 08:16:00.000 lamp told on\n0 08:16:00.000 lamp says on\n")


async def test_a_device_whose_link_is_cut_dials_again() -> None:
    day = a_day(DayEvent(at("08:10"), "cut", "lamp"), DayEvent(at("08:11"), "tell", "lamp", "on"))
    assert await lived(day) == ((), "0 08:11:00.000 lamp told on\n0 08:11:00.000 lamp says on\n")


@pytest.mark.parametrize("forget", [False, True])
async def test_a_broker_forgets_where_the_day_says_so(forget: bool) -> None:  # noqa: FBT001
    """Outages that overlap are one, and end with the later."""
    day = a_day(
        DayEvent(at("08:10"), "restart", lasts=600.0, forget=forget),
        DayEvent(at("08:15"), "restart", lasts=900.0),
    )
    start = parse_time("2026-01-01 08:00")
    async with virtual_house_of(world=day.world(), start=start) as house:
        await retain(house)
        before = house.broker.stats.retained_messages
        assert await day.live(house) == ()
        assert house.broker.running
        assert house.broker.stats.retained_messages == before - forget


async def retain(house: VirtualHouse) -> None:
    client = house.broker.make_client(MqttOptions.from_url(house.broker.url, client_id="somebody"))
    async with client.connected():
        await client.publish("note", b"milk", qos=1, retain=True)


async def test_what_outlasts_the_day_ends_with_it() -> None:
    day = a_day(DayEvent(at("08:50"), "restart", lasts=86_400.0))
    start = parse_time("2026-01-01 08:00")
    async with virtual_house_of(world=day.world(), start=start) as house:
        await day.live(house)
        assert house.now == parse_time("2026-01-01 09:00")
        assert house.broker.running


async def test_a_day_that_has_begun_already_cannot_be_lived() -> None:
    day = a_day()
    async with virtual_house_of(world=day.world(), start="2026-01-01 08:30") as house:
        with pytest.raises(UsageError, match=r"begins at 08:00, but the house is already at 08:30:00"):
            await day.live(house)


async def test_a_day_cannot_be_lived_in_another_house() -> None:
    day = a_day(DayEvent(at("08:10"), "cut", "lamp"))
    async with virtual_house_of() as house:
        with pytest.raises(UsageError, match="there is no device 'lamp' in the house"):
            await day.live(house)


class Crashing(App):
    """Crashes at once."""

    async def run(self) -> None:
        raise ZeroDivisionError


def test_an_app_that_crashes_fails_the_day() -> None:
    """It would be started again, and nobody would notice."""
    with pytest.raises(AssertionError, match=r"crashed: .*crashing"):
        live_day(a_day(), f"{__name__}:Crashing")


async def test_a_test_with_async_is_told_what_to_write() -> None:
    with pytest.raises(UsageError, match=r"await day\.live\(house\)"):
        live_day(a_day())
