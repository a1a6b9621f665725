"""Values as people say them."""

import pytest

from homebot.devices.wording.values import value_text


@pytest.mark.parametrize(
    ("capability", "value", "step", "text"),
    [
        ("level", 40.15748, 100 / 254, "40 %"),
        ("level", 40.15748, 0.0, "40 %"),
        ("level", 0.4, 0.0, "0.4 %"),
        ("fan_speed", 33.5, 0.5, "33.5 %"),
        ("humidity", 45.27, 0.0, "45 %"),
        ("temperature", 21.4567, 0.0, "21.5 °C"),
        ("heating_setpoint", 21.25, 0.25, "21.25 °C"),
        ("power", 1234.567, 0.0, "1234.6 W"),
        ("current", 0.4321, 0.0, "0.43 A"),
        ("state", False, 0.0, "off"),
        ("smoke", False, 0.0, "no smoke"),
    ],
)
def test_a_value_has_the_decimal_places_that_mean_something(
    capability: str, value: float, step: float, text: str
) -> None:
    """A lamp at 102 of 254 was at 40.16 %, and a relay's input was "no"."""
    assert value_text(capability, value, step=step) == text
