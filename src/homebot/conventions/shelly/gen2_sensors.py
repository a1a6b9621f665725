"""Sensors of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Temperature, Humidity, Illuminance, DevicePower, Smoke, Flood, Presence, Voltmeter,
Input.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.shelly.gen2_component import Fields, ShellyComponent, StatusDecoder, flag, measured
from homebot.devices.part import Category
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = [
    "PRESSES",
    "SENSORS",
    "build_input",
    "build_power",
    "build_sensor",
]


@dataclass(frozen=True, slots=True)
class _Sensor:
    field: str
    capability: str
    service_type: str
    category: Category = ""

    @property
    def decoder(self) -> StatusDecoder:
        is_flag = self.capability in _FLAGS
        return flag(self.field, self.capability) if is_flag else measured(self.field, self.capability)


_FLAGS = frozenset({"smoke", "water_leak", "occupancy"})

SENSORS: Mapping[str, _Sensor] = MappingProxyType(
    {
        "smoke": _Sensor("alarm", "smoke", "smoke_co_alarm"),
        "flood": _Sensor("alarm", "water_leak", "water_leak_detector"),
        "presencezone": _Sensor("state", "occupancy", "occupancy_sensor"),
        "temperature": _Sensor("tC", "temperature", "temperature_sensor"),
        "humidity": _Sensor("rh", "humidity", "humidity_sensor"),
        "illuminance": _Sensor("lux", "illuminance", "light_sensor"),
        "voltmeter": _Sensor("voltage", "voltage", "electrical_meter"),
    }
)
"""The components that are one sensor each."""

PRESSES: Mapping[str, str] = {
    "single_push": "single",
    "double_push": "double",
    "triple_push": "triple",
    "long_push": "long",
}


def build_sensor(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a component that is one sensor."""
    sensor = SENSORS[component.kind]
    part = component.part("", sensor.service_type, category=sensor.category)
    component.read_status(part, sensor.decoder)
    part.add_capability(sensor.capability)
    return (part,)


def build_power(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe a battery, where the device has one."""
    part = component.part("", "x_battery", category="diagnostic")
    component.read_status(part, _decode_power)
    part.add_capability("battery")
    battery = component.status.get("battery")
    if isinstance(battery, dict) and "V" in battery:
        part.add_capability("voltage")
    if isinstance(component.status.get("external"), dict):
        part.add_capability("plugged_in")
    return (part,)


def build_input(component: ShellyComponent) -> tuple[JsonPart, ...]:
    """Describe an input: a button, a switch, an analogue value or a counter, as it is set up."""
    kind = component.config.get("type")
    if component.config.get("enable") is False:
        return ()
    if kind == "analog" or (kind is None and "percent" in component.status and "state" not in component.status):
        part = component.part("", "x_sensor")
        component.read_status(part, measured("percent", "measurement"))
        part.add_capability("measurement", unit="%")
        return (part,)
    if kind == "count":
        part = component.part("", "x_sensor")
        component.read_status(part, _decode_counter)
        part.add_capability("measurement")
        return (part,)
    is_button = kind != "switch"
    part = component.part("", "generic_switch" if is_button else "x_binary_sensor")
    if kind == "switch" or component.status.get("state") is not None:
        component.read_status(part, flag("state", "state"))
        part.add_capability("state")
    if is_button:
        component.read_presses(part, PRESSES)
    return (part,)


def _decode_counter(status: Fields) -> Readings:
    counts = status.get("counts")
    total = to_number(counts.get("total")) if isinstance(counts, dict) else None
    return NO_READINGS if total is None else {"measurement": total}


def _decode_power(status: Fields) -> Readings:
    found: dict[str, PlainValue] = {}
    battery, external = status.get("battery"), status.get("external")
    if isinstance(battery, dict) and "percent" in battery:
        percent = to_number(battery["percent"])
        found["battery"] = percent if percent is not None and 0 <= percent <= 100 else None
    if isinstance(battery, dict) and "V" in battery:
        found["voltage"] = to_number(battery["V"])
    if isinstance(external, dict) and isinstance(present := external.get("present"), bool):
        found["plugged_in"] = present
    return found
