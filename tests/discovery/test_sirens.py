"""Relays that are sirens by their names, which nobody who turns on all switches wants to hear."""

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.devices import Device, Sighting
from homebot.discovery import DeviceIndex
from homebot.words.queries import parse_query


def device_of(sighting: Sighting) -> tuple[DeviceIndex, Device]:
    index = DeviceIndex(forget_after=1000.0)
    index.observe(sighting)
    (device,) = index.devices()
    return index, device


@pytest.mark.parametrize(
    ("name", "model", "part_name"),
    [
        ("Hall", "Hue Secure siren and chime", ""),
        ("Alarm panel", "Security Panel", "Alarm Panel siren"),
        ("Siren", "", ""),
        ("0x17", "", "siren"),
        ("Keller", "", "Alarmsirene"),
        ("Garage", "", "Sirène garage"),
    ],
)
def test_a_relay_that_is_called_a_siren_is_no_switch(name: str, model: str, part_name: str) -> None:
    """As those of Philips Hue and of ring-mqtt."""
    relay = part_of("switch", "on_off", id="s", name=part_name, writes=("s/set",), advertised="switch")
    index, device = device_of(announce("switch/s", relay, name=name, facts={"model": model} if model else {}))
    assert (device.service_type, device.service_types) == ("siren", ("siren",))
    assert device.parts[0].part.guessed
    assert device.parts[0].part.capabilities == relay.capabilities
    assert index.find(parse_query("switch")) == frozenset()
    assert len(index.find(parse_query("siren"))) == 1


@pytest.mark.parametrize("name", ["Siren light", "Alarm", "Sirenia", "Sensor"])
def test_a_relay_of_another_name_stays_one(name: str) -> None:
    _, device = device_of(announce("switch/s", part_of("switch", "on_off", name=name, writes=("s/set",))))
    assert device.service_type == "switch"


def test_of_several_relays_only_the_one_that_is_called_so_is_a_siren() -> None:
    """As the NoDieby ND-01, whose other one arms it."""
    relays = [part_of("switch", "on_off", id=one, name=one, writes=(f"{one}/set",)) for one in ("alarm", "siren")]
    setting = part_of("x_setting", "on_off", id="x", name="Siren", writes=("x/set",), category="config")
    _, device = device_of(announce("nd", *relays, setting, name="Siren", convention="zigbee2mqtt"))
    assert [one.part.service_type for one in device.parts] == ["switch", "siren", "x_setting"]
