"""The quantity of a number of a Homie device, by its unit; the few words of products that people own."""

import pytest

from homebot.integrations.homie.formats.roles import quantity_of

NONE: frozenset[str] = frozenset()


@pytest.mark.parametrize(
    ("unit", "capability"),
    [("kW", "power"), ("dBm", "signal_strength"), (" °C ", "temperature"), ("K", "measurement"), ("%", "measurement")],
)
def test_a_unit_alone_identifies_a_quantity(unit: str, capability: str) -> None:
    assert quantity_of(unit, NONE) == capability


def test_a_word_without_a_unit_identifies_none() -> None:
    assert quantity_of("", frozenset({"temperature"})) == "measurement"


def test_the_rating_of_a_breaker_is_no_measured_current() -> None:
    """Source: SPAN panel, eBus, Homie 5: the property breaker-rating has the unit A."""
    assert quantity_of("A", frozenset({"breaker", "rating", "main"})) == "measurement"
    assert quantity_of("A", frozenset({"breaker", "main"})) == "current"
    assert quantity_of("A", frozenset({"maximum", "charge", "current"})) == "measurement"
    assert quantity_of("kWh", frozenset({"soe"})) == "measurement"


def test_the_battery_of_a_robot_is_one() -> None:
    """Source: Valetudo, BatteryStateAttribute/level in percent."""
    assert quantity_of("%", frozenset({"batterystateattribute", "battery", "level"})) == "battery"
