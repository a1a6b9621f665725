from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.settings import build_number
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

CALIBRATION = {
    "command_topic": "zigbee2mqtt/valve/set/local_temperature_calibration",
    "device_class": "temperature_delta",
    "max": 2.5,
    "min": -2.5,
    "state_topic": "zigbee2mqtt/valve",
    "step": 0.5,
    "unit_of_measurement": "°C",
    "value_template": '{{ value_json["local_temperature_calibration"] }}',
}
LIMIT = {"command_topic": "limit/set", "command_template": '{"limit": {{ value }}}', "state_topic": "limit"}


def number(fields: Mapping[str, object]) -> DescribedPart:
    return build_number(DiscoveryConfig("number", "node_1", fields))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (b"1", {"number": 1.0}),
        (b"99.5", {"number": 99.5}),
        (b"None", {"number": None}),
        (b"0", {"number": 0.0}),
        (b"-1", {}),
        (b"101", {}),
        (b"nan", {"number": None}),
        (b"inf", {"number": None}),
        (b"", {}),
        (b"many", {}),
    ],
)
def test_only_a_number_within_the_bounds_is_heard(said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert number(LIMIT).codec.read("limit", said, retained=True) == expected


@pytest.mark.parametrize(
    ("fields", "value", "payload"),
    [
        (CALIBRATION, 1.5, b"1.5"),
        (CALIBRATION, 2.0, b"2"),
        (CALIBRATION, -2.5, b"-2.5"),
        (LIMIT, 0, b'{"limit": 0}'),
        (LIMIT, 100, b'{"limit": 100}'),
        (LIMIT, 7, b'{"limit": 7}'),
        (LIMIT, 7.25, b'{"limit": 7.25}'),
    ],
)
def test_a_whole_number_is_told_without_point(fields: Mapping[str, object], value: float, payload: bytes) -> None:
    assert [one.payload for one in number(fields).codec.write("number", value)] == [payload]


def test_a_number_keeps_its_unit_and_bounds() -> None:
    part = number(CALIBRATION).part
    (capability,) = part.capabilities
    assert (part.tag, capability.unit, capability.bounds) == ("temperature_delta", "°C", (-2.5, 2.5))


@pytest.mark.parametrize("value", [3.0, float("nan"), "1", True, None])
def test_another_value_is_refused(value: PlainValue) -> None:
    with pytest.raises(RefusedError, match=r"-2.5 to 2.5"):
        number(CALIBRATION).codec.write("number", value)


@pytest.mark.parametrize("fields", [{}, {**LIMIT, "min": 5, "max": 4}, {**LIMIT, "min": "few"}])
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        number(fields)
