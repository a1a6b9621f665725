import json
from collections.abc import Mapping

import pytest

from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.sensors import build_sensor
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

ZIGBEE_TEMPERATURE = {
    "device_class": "temperature",
    "enabled_by_default": True,
    "state_class": "measurement",
    "state_topic": "zigbee2mqtt/attic",
    "unique_id": "0x1_temperature_zigbee2mqtt",
    "unit_of_measurement": "°C",
    "value_template": '{{ value_json["temperature"] }}',
}
BLE_HUMIDITY = {
    "state_topic": "+/+/BTtoMQTT/A4C138000011",
    "device_class": "humidity",
    "unit_of_measurement": "%",
    "value_template": "{{ value_json.hum | is_defined }}",
}
FAHRENHEIT = {"state_topic": "rtl_433/9/temperature_F", "device_class": "temperature", "unit_of_measurement": "°F"}
COUNTER = {"state_topic": "counter", "state_class": "total_increasing"}
MODE = {"state_topic": "boiler/mode", "device_class": "enum", "options": ["off", "hot water", 3]}
WORDS = {"state_topic": "status"}
BOOTED = {"state_topic": "boot", "device_class": "timestamp"}
DAY = {"state_topic": "day", "device_class": "date"}


def sensor(fields: Mapping[str, object]) -> DescribedPart:
    return build_sensor(DiscoveryConfig("sensor", "node_1", fields))


def heard(fields: Mapping[str, object], said: object, topic: str = "") -> Mapping[str, PlainValue]:
    codec = sensor(fields).codec
    payload = said if isinstance(said, str) else json.dumps(said)
    return codec.read(topic or codec.topics()[0], payload.encode(), retained=True)


@pytest.mark.parametrize(
    ("fields", "said", "expected"),
    [
        (ZIGBEE_TEMPERATURE, {"temperature": 21.25}, {"temperature": 21.25}),
        (ZIGBEE_TEMPERATURE, {"temperature": "21.25"}, {"temperature": 21.25}),
        (ZIGBEE_TEMPERATURE, {"temperature": None}, {"temperature": None}),
        (FAHRENHEIT, "50", {"temperature": 10.0}),
        (COUNTER, " 17 ", {"measurement": 17.0}),
        (MODE, "hot water", {"value": "hot water"}),
        (MODE, "3", {"value": "3"}),
        (WORDS, "all is well", {"value": "all is well"}),
        (WORDS, "None", {"value": None}),
        (BOOTED, "2026-11-20T09:00:00+01:00", {"value": "2026-11-20T08:00:00+00:00"}),
        (BOOTED, "yesterday", {"value": None}),
        (DAY, "2026-11-20", {"value": "2026-11-20"}),
        (DAY, "20.11.", {"value": None}),
    ],
)
def test_a_message_tells_a_value(
    fields: Mapping[str, object], said: object, expected: Mapping[str, PlainValue]
) -> None:
    assert heard(fields, said) == expected


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        (ZIGBEE_TEMPERATURE, {"temperature": ""}),
        (ZIGBEE_TEMPERATURE, {"temperature": "warm"}),
        (ZIGBEE_TEMPERATURE, {"humidity": 4}),
        (ZIGBEE_TEMPERATURE, "no json"),
        (FAHRENHEIT, ""),
        (FAHRENHEIT, "9" * 400),
        (FAHRENHEIT, "1,5"),
        (MODE, "cold water"),
        (WORDS, "w" * 256),
        (BOOTED, "2026-11-20T09:00:00"),
        (BOOTED, "0001-01-01T00:00:00+23:00"),
    ],
)
def test_what_is_no_value_changes_nothing(fields: Mapping[str, object], said: object) -> None:
    assert heard(fields, said) == {}


def test_one_sensor_may_be_heard_by_several_gateways() -> None:
    assert heard(BLE_HUMIDITY, {"hum": 40.5}, "home/hall/BTtoMQTT/A4C138000011") == {"humidity": 40.5}
    assert heard(BLE_HUMIDITY, {"batt": 90}, "home/attic/BTtoMQTT/A4C138000011") == {}


def test_a_sensor_is_described_by_its_class() -> None:
    part = sensor(ZIGBEE_TEMPERATURE).part
    (capability,) = part.capabilities
    assert (part.id, part.service_type, part.tag) == (
        "0x1_temperature_zigbee2mqtt",
        "temperature_sensor",
        "temperature",
    )
    assert (capability.name, capability.unit, capability.readable, capability.settable) == (
        "temperature",
        "°C",
        True,
        False,
    )


def test_a_sensor_with_few_words_names_them() -> None:
    assert sensor(MODE).part.capabilities[0].options == ("off", "hot water", "3")


def test_a_value_of_a_sensor_that_expires_fades() -> None:
    assert sensor({**FAHRENHEIT, "expire_after": 600}).expiries == (AutoExpiry("temperature", 600.0),)


@pytest.mark.parametrize("after", [0, None, 10**12])
def test_a_value_that_does_not_expire_stays(after: int | None) -> None:
    assert sensor({**FAHRENHEIT, "expire_after": after}).expiries == ()


def test_a_template_beyond_us_shows_what_was_said() -> None:
    part = sensor({**WORDS, "value_template": "{{ states('sun.sun') }}"})
    assert [one.name for one in part.part.capabilities] == ["raw"]
    assert part.codec.read("status", b"on\x1b[31m fire", retained=False) == {"raw": "on [31m fire"}


def test_a_sensor_cannot_be_told() -> None:
    with pytest.raises(RefusedError, match="takes nothing"):
        sensor(ZIGBEE_TEMPERATURE).codec.write("temperature", 20.0)


@pytest.mark.parametrize(
    "fields",
    [{}, {"state_topic": ""}, {"state_topic": "a/#/b"}, {**WORDS, "expire_after": -1}, {**WORDS, "options": {}}],
)
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        sensor(fields)
