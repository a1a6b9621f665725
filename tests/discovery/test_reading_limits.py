"""A value outside the owner's limits is no reading: it is counted and told, and the value before it stays."""

from collections.abc import Mapping

import pytest
from tests.announcements import sighting_of
from tests.discovery.announcements import part_of, tell

from homebot.config import parse_config
from homebot.devices.value import PlainValue
from homebot.discovery import DeviceIndex
from homebot.errors import ConfigError
from homebot.runtime.plan import make_plan

PROBE = sighting_of("probe", part_of("temperature_sensor", "temperature", "humidity"), name="Attic probe")


def index_with(name: str = "Attic probe", **limits: list[float]) -> DeviceIndex:
    index = DeviceIndex(forget_after=1000)
    config = parse_config({"devices": {name: {"limits": limits}}}, "homebot.toml")
    index.table.limits = make_plan(config).limits
    index.observe(PROBE)
    return index


def values(index: DeviceIndex) -> Mapping[str, PlainValue]:
    (device,) = index.devices()
    return {one.capability: one.value.plain() for one in device.states}


@pytest.mark.parametrize("name", ["Attic probe", "attic_probe"])
def test_the_value_before_stays_and_the_last_one_outside_is_told(name: str) -> None:
    index = index_with(name, temperature=[-30, 50])
    for value in (21.5, 85.0, -127.0):
        index.report(tell(PROBE, "temperature", value))
    index.report(tell(PROBE, "humidity", 99.0))
    assert values(index) == {"temperature": 21.5, "humidity": 99.0}
    (device,) = index.devices()
    (fact,) = (one.value for one in device.facts if one.name == "unreadable")
    assert fact == f"payloads outside the limits -30 to 50 of [devices.{name}]: the last had temperature -127"
    assert index.counters.outside_limits == 2


def test_the_limits_themselves_and_other_devices_are_read() -> None:
    for index in (index_with(temperature=[-30, 50]), index_with("Boiler", temperature=[-30, 20])):
        index.report(tell(PROBE, "temperature", 50.0))
        assert values(index) == {"temperature": 50.0}


@pytest.mark.parametrize(
    ("limits", "problem"),
    [
        ({"temprature": [0, 1]}, "'temprature' is no capability with numbers; did you mean temperature"),
        ({"on_off": [0, 1]}, "'on_off' is no capability with numbers"),
        ({"temperature": [50, -30]}, "temperature from 50 to -30 leaves nothing; the lower limit comes first"),
        ({"temperature": [1]}, "temperature"),
    ],
)
def test_wrong_limits_are_errors_of_the_configuration(limits: Mapping[str, list[float]], problem: str) -> None:
    with pytest.raises(ConfigError) as raised:
        make_plan(parse_config({"devices": {"Attic probe": {"limits": dict(limits)}}}, "homebot.toml"))
    assert "devices.Attic probe.limits" in str(raised.value)
    assert problem in str(raised.value)
