import pytest

from homebot.testing import VirtualHouse

pytestmark = pytest.mark.house("manual_override:ManualOverride", world="house.toml")


async def move(house: VirtualHouse) -> None:
    await house.sense("hall_motion", occupied=False)
    await house.run_for("1m")
    await house.sense("hall_motion", occupied=True)
    await house.run_for("1m")


async def test_motion_turns_the_lamp_on(house: VirtualHouse) -> None:
    await move(house)
    await house.becomes("hall_lamp", on=True)


async def test_a_lamp_that_a_person_turned_off_stays_off_for_two_hours_and_a_restart(house: VirtualHouse) -> None:
    await move(house)
    await house.press("hall_lamp", "off")
    await house.run_for("1h")
    await house.reload("manual_override")
    await move(house)
    await house.becomes("hall_lamp", on=False)
    await house.run_for("1h")
    await move(house)
    await house.becomes("hall_lamp", on=True)


async def test_a_lamp_that_a_person_turned_on_goes_off_after_two_hours(house: VirtualHouse) -> None:
    await house.press("hall_lamp", "on")
    await house.run_for("119m")
    await house.becomes("hall_lamp", on=True)
    await house.becomes("hall_lamp", on=False, within="2m")
