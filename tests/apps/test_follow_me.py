"""Follow me in a simulated flat in virtual time: light where somebody comes in, if it is dark there."""

import pytest
from structlog.testing import capture_logs
from tests.apps.houses import flat, hall, is_on, lamp, motion, warnings

from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


async def test_the_lamp_goes_on_in_each_room_that_somebody_comes_into() -> None:
    world = hall(("06:00", "hall"), ("06:10", "study"), study_lamp=lamp("study"), study_motion=motion("study"))
    async with virtual_house_of("follow_me", world=world) as house:
        await house.run_until("06:05")
        assert (is_on(world, "hall_lamp"), is_on(world, "study_lamp")) == (True, False)
        await house.run_until("06:15")
        assert is_on(world, "study_lamp")


@pytest.mark.parametrize(("at", "goes_on"), [("03:00", True), ("12:00", False)])
async def test_a_light_sensor_tells_whether_it_is_dark(at: str, *, goes_on: bool) -> None:
    world = flat(
        (at, "kitchen"),
        kitchen_lamp=lamp("kitchen"),
        kitchen_motion=motion("kitchen"),
        kitchen_lux={"kind": "lux", "room": "kitchen"},
    )
    async with virtual_house_of("follow_me", world=world) as house:
        await house.run_until(at)
        await house.run_for("5m")
        assert is_on(world, "kitchen_lamp") is goes_on


async def test_where_a_lamp_is_on_the_room_is_left_as_it_is() -> None:
    """Somebody chose that light."""
    world = hall(("06:00", "hall"), reading_lamp=lamp("hall"))
    async with virtual_house_of("follow_me", world=world) as house:
        await house.press("reading_lamp", "0.3")
        await house.run_until("06:05")
        assert not is_on(world, "hall_lamp")
    assert " told " not in world.event_log.text()


@pytest.mark.parametrize(
    ("settings", "goes_on"),
    [({"rooms": ["Hall"]}, True), ({"rooms": ["study"]}, False), ({"without_light_sensor": False}, False)],
)
async def test_the_settings_say_where_it_works(settings: dict[str, object], *, goes_on: bool) -> None:
    world = hall(("06:00", "hall"))
    async with virtual_house_of(world=world, config={"apps": {"follow_me": settings}}) as house:
        await house.run_until("06:05")
        assert is_on(world, "hall_lamp") is goes_on


async def test_a_deaf_lamp_is_told_about_and_the_other_one_goes_on() -> None:
    world = hall(("06:00", "hall"), hall_lamp=lamp("hall", faults={"deaf": {}}), other_lamp=lamp("hall"))
    with capture_logs() as lines:
        async with virtual_house_of("follow_me", world=world) as house:
            await house.run_until("06:05")
            assert is_on(world, "other_lamp")
    assert warnings(lines) == ["hall_lamp → on, by follow_me: no answer within 10 s"]


async def test_together_with_lights_out_the_light_follows_somebody_through_the_flat() -> None:
    world = hall(("06:00", "hall"), ("07:00", "study"), study_lamp=lamp("study"), study_motion=motion("study"))
    async with virtual_house_of("follow_me", "lights_out", world=world) as house:
        await house.run_until("06:05")
        assert is_on(world, "hall_lamp")
        await house.run_until("07:05")
        assert is_on(world, "study_lamp")
        await house.run_until("07:30")
        assert not is_on(world, "hall_lamp")
