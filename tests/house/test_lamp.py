"""A lamp shines as it is told."""

from __future__ import annotations

import pytest

from homebot.house.devices import SimulatedLamp


def test_a_lamp_is_dimmed_by_a_number() -> None:
    """It draws and gives light in proportion."""
    lamp = SimulatedLamp("lamp", rated_watts=10.0, rated_lux=200.0)
    assert lamp.handle_command("0.5", 1.0) == ("0.5",)
    assert (lamp.state(), lamp.watts(), lamp.lux()) == ("on", 5.0, 100.0)


def test_a_lamp_dimmed_to_nothing_is_off_and_remembers_how_bright_it_was() -> None:
    """As dimmers do."""
    lamp = SimulatedLamp("lamp", is_on=True, brightness=0.4)
    lamp.handle_command("0", 1.0)
    assert (lamp.state(), lamp.watts(), lamp.lux()) == ("off", 0.0, 0.0)
    lamp.handle_command("on", 2.0)
    assert lamp.brightness == 0.4


def test_a_lamp_takes_a_colour_temperature_in_kelvin() -> None:
    """Also while it is off."""
    lamp = SimulatedLamp("lamp")
    assert lamp.handle_command("4000 K", 1.0) == ("4000 K",)
    assert (lamp.kelvin, lamp.is_on) == (4000.0, False)


@pytest.mark.parametrize("command", ["1.5", "-1", "90000 K", "warm K", "2700", ""])
def test_a_lamp_ignores_unknown_commands(command: str) -> None:
    """It says nothing and stays as it is."""
    lamp = SimulatedLamp("lamp", is_on=True)
    assert lamp.handle_command(command, 1.0) == ()
    assert (lamp.state(), lamp.brightness, lamp.kelvin) == ("on", 1.0, 2700.0)
