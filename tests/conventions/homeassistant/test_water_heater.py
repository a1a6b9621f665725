from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.climate import build_water_heater
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

EMS_ESP = {
    "mode_command_topic": "ems-esp/dhw/mode",
    "mode_state_topic": "ems-esp/dhw_data",
    "mode_state_template": "{{ value_json.mode }}",
    "modes": ["off", "eco", "performance"],
    "temperature_command_topic": "ems-esp/dhw/seltemp",
    "temperature_state_topic": "ems-esp/dhw_data",
    "temperature_state_template": "{{ value_json.seltemp }}",
    "current_temperature_topic": "ems-esp/dhw_data",
    "current_temperature_template": "{{ value_json.curtemp }}",
    "power_command_topic": "ems-esp/dhw/power",
    "payload_on": "on",
    "payload_off": "off",
    "min_temp": 30,
    "max_temp": 70,
}


def heater(fields: Mapping[str, object] = EMS_ESP) -> DescribedPart:
    return build_water_heater(DiscoveryConfig("water_heater", "node_1", fields))


def test_one_message_tells_its_mode_and_temperatures() -> None:
    part = heater()
    assert part.part.service_type == "water_heater"
    said = b'{"mode": "eco", "seltemp": 55, "curtemp": 48.5}'
    assert part.codec.read("ems-esp/dhw_data", said, retained=True) == {
        "water_heater_mode": "eco",
        "heating_setpoint": 55.0,
        "local_temperature": 48.5,
    }


@pytest.mark.parametrize(
    ("capability", "value", "topic", "payload"),
    [
        ("water_heater_mode", "performance", "ems-esp/dhw/mode", b"performance"),
        ("heating_setpoint", 50.0, "ems-esp/dhw/seltemp", b"50.0"),
        ("on_off", True, "ems-esp/dhw/power", b"on"),
        ("on_off", False, "ems-esp/dhw/power", b"off"),
    ],
)
def test_it_is_told_as_home_assistant_does(capability: str, value: PlainValue, topic: str, payload: bytes) -> None:
    (publication,) = heater().codec.write(capability, value)
    assert (publication.topic, publication.payload) == (topic, payload)


@pytest.mark.parametrize(
    ("capability", "value"), [("water_heater_mode", "gas"), ("heating_setpoint", 80.0), ("on_off", "on")]
)
def test_what_it_cannot_do_is_refused(capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        heater().codec.write(capability, value)


def test_without_limits_it_takes_what_home_assistant_does() -> None:
    (setpoint, *_) = heater({"temperature_command_topic": "t", "temperature_state_topic": "s"}).part.capabilities
    assert setpoint.bounds == pytest.approx((43.333, 60.0), abs=0.001)


def test_a_heater_without_a_topic_for_power_has_no_switch() -> None:
    assert heater({"current_temperature_topic": "t"}).part.capabilities[0].name == "local_temperature"
    assert len(heater({"current_temperature_topic": "t"}).part.capabilities) == 1
