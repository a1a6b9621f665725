"""Types and capabilities of the thesis's layout, by the level of the topic."""

import pytest

from homebot.devices.device_types import wanted_types
from homebot.devices.text.commands import decode_command, encode_command
from homebot.devices.text.states import decode_text
from homebot.devices.value import PlainValue
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.integrations.thesis.formats import thesis_part


@pytest.mark.parametrize(
    ("word", "kind", "tag", "settable", "read_only"),
    [
        ("lights", "light", "", ["on_off", "level", "color_temperature"], []),
        ("Lamp", "light", "", ["on_off", "level", "color_temperature"], []),
        ("windows", "closure", "window", ["movement", "position"], []),
        ("doors", "closure", "door", ["movement", "position"], []),
        ("garage_doors", "closure", "garage_door", ["movement", "position"], []),
        ("gates", "closure", "", ["movement", "position"], []),
        ("covers", "window_covering", "", ["movement", "position"], []),
        ("blinds", "window_covering", "", ["movement", "position"], []),
        ("locks", "door_lock", "", ["lock"], []),
        ("plugs", "plug", "", ["on_off"], []),
        ("switches", "switch", "", ["on_off"], []),
        ("fans", "fan", "", ["on_off", "fan_speed"], []),
        ("valves", "water_valve", "", ["valve", "position"], []),
        ("thermostats", "thermostat", "", ["heating_setpoint"], ["local_temperature"]),
        ("climate", "thermostat", "", ["heating_setpoint"], ["local_temperature"]),
        ("contacts", "contact_sensor", "", [], ["contact"]),
        ("motions", "occupancy_sensor", "", [], ["occupancy"]),
        ("light_levels", "light_sensor", "", [], ["illuminance"]),
        ("temperatures", "temperature_sensor", "", [], ["temperature"]),
        ("humidities", "humidity_sensor", "", [], ["humidity"]),
        ("power_meters", "electrical_meter", "", [], ["power"]),
        ("robots", "x_robot", "", [], ["value"]),
    ],
)
def test_the_level_of_the_topic_determines_the_type(
    word: str, kind: str, tag: str, settable: list[str], read_only: list[str]
) -> None:
    part = thesis_part(word, "home/x/y/out", "home/x/y/in")
    assert (part.id, part.service_type, part.tag, part.advertised, part.guessed) == ("", kind, tag, word, True)
    assert [one.name for one in part.capabilities if one.settable] == settable
    assert [one.name for one in part.capabilities if not one.settable] == read_only
    assert part.reads == ("home/x/y/out",)
    assert part.writes == (("home/x/y/in",) if settable else ())
    assert kind in wanted_types(word)


@pytest.mark.parametrize("word", ["coffee", "", "type7", "x", "Küchen", "lights\0"])
def test_an_unknown_word_has_no_type(word: str) -> None:
    part = thesis_part(word, "out", "in")
    assert (part.service_type, part.capabilities, part.writes) == ("", (), ())


@pytest.mark.parametrize(
    "device",
    [
        SimulatedLamp("x"),
        WindowMotor("x"),
        CoverMotor("x"),
        SimulatedDoorLock("x"),
        SimulatedContactSensor("x"),
        MotionSensor("x"),
        LuxSensor("x"),
        PowerMeter("x"),
        SimulatedThermostat("x"),
    ],
    ids=lambda device: device.kind,
)
def test_every_simulated_device_reports_and_obeys_its_capabilities(device: SimulatedDevice) -> None:
    """The house's own words are the reference of the layout."""
    part = thesis_part(device.service_type, "out", "in")
    assert decode_text(device.state(), part)
    values: dict[str, PlainValue] = {
        "on_off": True,
        "level": 40.0,
        "color_temperature": 2500.0,
        "movement": "open",
        "position": 25.0,
        "lock": "unlocked",
        "heating_setpoint": 23.0,
    }
    for capability in part.capabilities:
        if capability.settable:
            said = encode_command(capability.name, values[capability.name], part)
            assert decode_command(said, part) == (capability.name, values[capability.name])
            answers = device.handle_command(said, device.now)
            assert answers
            assert all(decode_text(one, part) for one in answers)
