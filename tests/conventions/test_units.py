"""Numbers that devices measure, in the vocabulary's units."""

import pytest

from homebot.conventions.units import Quantity, conversion_of, quantity, sensor_type
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES


@pytest.mark.parametrize(
    ("capability", "unit"), [("temperature", "%"), ("humidity", ""), ("battery", "V"), ("power", "")]
)
def test_a_unit_of_something_else_is_not_converted(capability: str, unit: str) -> None:
    assert conversion_of(capability, unit) is None


def test_the_capability_determines_the_type_of_a_sensor() -> None:
    assert sensor_type("temperature") == "temperature_sensor"
    assert [sensor_type(name) for name in ("tamper", "signal_strength", "value")] == [
        "x_binary_sensor",
        "x_sensor",
        "x_sensor",
    ]
    assert {sensor_type(name) for name in CAPABILITIES} <= DEVICE_TYPES.keys()


def test_a_quantity_converts_into_the_vocabularys_unit() -> None:
    assert quantity("temperature", "°F").value(212.0) == pytest.approx(100.0)
    assert quantity("energy") == Quantity("electrical_meter", "energy")


@pytest.mark.parametrize(
    ("capability", "unit", "expected"),
    [
        ("energy", "KWh", 1.0),
        ("energy", "kwh", 1.0),
        ("energy", "wh", 0.001),
        ("energy_returned", "Wh", 0.001),
        ("energy", "mwh", None),
        ("power", "KW", 1000.0),
        ("power", "mw", None),
        ("power", "w", 1.0),
        ("pressure", "Bar", 1000.0),
        ("pressure", "hpa", 1.0),
        ("pressure", "inH₂O", 2.490889),
        ("flow", "l/min", 0.06),
        ("flow", "gal/d", 0.003785412 / 24),
        ("energy", "thm", 29.300111),
        ("temperature", "ºC", 1.0),
        ("illuminance", "LUX", 1.0),
        ("voltage", "mv", None),
        ("humidity", "X", None),
    ],
)
def test_a_unit_in_another_case_counts_where_that_leaves_no_doubt(
    capability: str, unit: str, expected: float | None
) -> None:
    conversion = conversion_of(capability, unit)
    assert (None if conversion is None else conversion.value(1.0)) == (
        None if expected is None else pytest.approx(expected)
    )
