"""Window and heating in a simulated flat in virtual time: no heating out of the window, and warm again afterwards."""

import pytest
from structlog.testing import capture_logs
from tests.apps.houses import Table, flat

from homebot.house import World
from homebot.house.devices import SimulatedThermostat
from homebot.house.faults import unwrap
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


def airing(**more: object) -> World:
    """A study with a window and a heating of 21 °C, and a hall with a heating of its own."""
    heat: Table = {"kind": "thermostat", "room": "study", "target": 21.0}
    return flat(
        study_window={"kind": "window", "room": "study"},
        study_heat=heat | more,
        hall_heat={"kind": "thermostat", "room": "hall", "target": 20.0},
    )


def target(world: World, device: str = "study_heat") -> float:
    thermostat = unwrap(world.devices[device].device)
    assert isinstance(thermostat, SimulatedThermostat)
    return thermostat.target


@pytest.mark.parametrize("faults", [{}, {"lossy": {"share": 0.3}}])
async def test_the_heating_is_lowered_while_a_window_is_open_and_restored_after_it(faults: Table) -> None:
    """In its own room alone; commands without an answer are sent again."""
    world = airing(faults=faults)
    async with virtual_house_of("window_heating", world=world) as house:
        await house.run_for("10m")
        await house.press("study_window", "open")
        await house.run_for("5m")
        assert (target(world), target(world, "hall_heat")) == (12.0, 20.0)
        await house.press("study_window", "close")
        await house.run_for("5m")
        assert (target(world), target(world, "hall_heat")) == (21.0, 20.0)


async def test_a_door_that_somebody_goes_through_changes_nothing() -> None:
    """Its contact is open for seconds only."""
    world = flat(
        ("08:00", "study"),
        study_door={"kind": "contact", "room": "study", "door": "hall"},
        study_heat={"kind": "thermostat", "room": "study", "target": 21.0},
    )
    async with virtual_house_of("window_heating", world=world) as house:
        await house.run_until("09:00")
    assert "study_door says open" in world.event_log.text()
    assert "study_heat told" not in world.event_log.text()


async def test_the_times_and_the_setpoint_can_be_set() -> None:
    world = airing()
    config = {"apps": {"window_heating": {"open_for": 300, "lowered_to": 16}}}
    async with virtual_house_of(world=world, config=config) as house:
        await house.press("study_window", "open")
        await house.run_for("4m")
        assert target(world) == 21.0
        await house.run_for("2m")
        assert target(world) == 16.0


async def test_a_setpoint_that_somebody_changed_meanwhile_is_kept() -> None:
    world = airing()
    async with virtual_house_of("window_heating", world=world) as house:
        await house.press("study_window", "open")
        await house.run_for("5m")
        await house.press("study_heat", "18")
        await house.press("study_window", "close")
        await house.run_for("5m")
        assert target(world) == 18.0


async def test_a_deaf_thermostat_is_told_about() -> None:
    world = airing(faults={"deaf": {}})
    with capture_logs() as lines:
        async with virtual_house_of("window_heating", world=world) as house:
            await house.press("study_window", "open")
            await house.run_for("5m")
            assert target(world) == 21.0
    told = [line["message"] for line in lines if line["event"] == "control.command"]
    assert told == ["study_heat → heating setpoint 12 °C, by window_heating: no answer within 10 s"]


async def test_what_was_lowered_stays_so_when_its_run_ends() -> None:
    """It is known to that run alone; a new one does not guess."""
    world = airing()
    async with virtual_house_of("window_heating", world=world) as house:
        await house.press("study_window", "open")
        await house.run_for("5m")
    assert target(world) == 12.0
