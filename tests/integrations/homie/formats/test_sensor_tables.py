"""The quantity of a number of a Homie device, by its unit and the words around it."""

import pytest

from homebot.integrations.homie.formats.node_types import condition_of, quantity_of

NONE: frozenset[str] = frozenset()


@pytest.mark.parametrize(
    ("unit", "capability"), [("kW", "power"), ("dBm", "signal_strength"), (" °C ", "temperature"), ("K", "measurement")]
)
def test_a_unit_alone_identifies_a_quantity(unit: str, capability: str) -> None:
    assert quantity_of(unit, NONE) == (capability, False)


def test_the_rating_of_a_breaker_is_no_measured_current() -> None:
    """Source: SPAN panel, eBus, Homie 5: the property breaker-rating has the unit A."""
    assert quantity_of("A", frozenset({"breaker", "rating", "main"})) == ("measurement", False)
    assert quantity_of("A", frozenset({"breaker", "main"})) == ("current", False)
    assert quantity_of("A", frozenset({"maximum", "charge", "current"})) == ("measurement", False)
    assert quantity_of("kWh", frozenset({"soe"})) == ("measurement", False)


@pytest.mark.parametrize(
    ("unit", "words", "expected"),
    [
        ("%", {"battery"}, "battery"),
        ("%", {"batterystate"}, "battery"),
        ("%", {"humidity"}, "humidity"),
        ("ppm", {"co"}, "carbon_monoxide"),
        ("", {"coal"}, "measurement"),
        ("%", {"x"}, "measurement"),
    ],
)
def test_words_are_a_guess(unit: str, words: set[str], expected: str) -> None:
    assert quantity_of(unit, frozenset(words)) == (expected, expected != "measurement")


@pytest.mark.parametrize(
    ("words", "around", "expected"),
    [
        ("motion", "kitchen", "occupancy"),
        ("kitchen", "", "state"),
        ("state", "leak sensor", "water_leak"),
        ("water", "", "water_leak"),
        ("water tank", "", "state"),
        ("watertank water tank", "attachment state", "state"),
        ("state", "water heater", "state"),
        ("mop", "water", "state"),
        ("door bell", "", "state"),
        ("door", "kitchen", "contact"),
        ("gas meter connected", "", "state"),
        ("alarm", "smoke", "smoke"),
        ("door closed", "", "state"),
        ("closed", "door", "state"),
        ("state", "window closed", "state"),
        ("no motion", "", "state"),
        ("open", "closed door", "contact"),
    ],
)
def test_a_word_identifies_a_condition(words: str, around: str, expected: str) -> None:
    assert condition_of(frozenset(words.split()), frozenset(around.split())) == expected


@pytest.mark.parametrize("words", ["color temperature", "battery cycles", "battery health"])
def test_a_word_beside_takes_the_meaning_of_another(words: str) -> None:
    assert quantity_of("", frozenset(words.split())) == ("measurement", False)
