"""A thermostat heats its room."""

from __future__ import annotations

import pytest

from homebot.house.devices import SimulatedThermostat


def test_an_unheated_room_cools_towards_the_weather() -> None:
    """To 1/e of the distance within its inertia."""
    room = SimulatedThermostat("room", celsius=20.0, outside=10.0, target=5.0, inertia=3000.0)
    reports = room.advance(3000.0)
    assert room.celsius == pytest.approx(10.0 + 10.0 / 2.718281828, abs=0.01)
    assert [float(report) for report in reports] == sorted((float(report) for report in reports), reverse=True)


def test_a_heated_room_stays_near_its_target() -> None:
    """In winter, over a day; heating goes on and off."""
    room = SimulatedThermostat("room", celsius=20.0, target=21.0, outside=-5.0)
    room.advance(20_000.0)
    powers = set()
    for hour in range(24):
        room.advance(20_000.0 + hour * 3600.0)
        powers.add(room.watts())
        assert room.celsius == pytest.approx(21.0, abs=1.0)
    assert powers == {0.0, 1000.0}


def test_a_thermostat_takes_a_target_and_says_it() -> None:
    """A number of degrees from 5 to 30."""
    room = SimulatedThermostat("room")
    assert room.handle_command("22.5", 1.0) == ("22.5",)
    assert room.restore() == "22.5"
    assert room.handle_command("50", 2.0) == ()
