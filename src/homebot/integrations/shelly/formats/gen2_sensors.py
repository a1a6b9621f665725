"""Sensors, meters and inputs of Shelly's second generation. Pure.

Source: Shelly Gen2+ API, components Temperature, Humidity, Illuminance, DevicePower, Smoke, Flood, Presence, Voltmeter,
Input, PM1, EM, EM1, EMData, EM1Data, and the measurements of Switch, Cover and Light.
"""

from collections.abc import Mapping
from functools import partial

from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import Readings, as_fields, text_of
from homebot.conventions.probe_errors import DS18X20_RESET, read_probe
from homebot.conventions.units import sensor_type
from homebot.integrations.shelly.formats.gen2_component import MAX_UNIT_CHARACTERS, PRESSES, ShellyComponent
from homebot.integrations.shelly.formats.status import Fields, StatusDecoder, reader_of

Parts = tuple[JsonPart, ...]

SENSORS: Mapping[str, tuple[str, str]] = {
    "smoke": ("alarm", "smoke"),
    "flood": ("alarm", "water_leak"),
    "presencezone": ("state", "occupancy"),
    "temperature": ("tC", "temperature"),
    "humidity": ("rh", "humidity"),
    "illuminance": ("lux", "illuminance"),
    "voltmeter": ("voltage", "voltage"),
    "cb": ("output", "power_detected"),  # a circuit breaker, which no app may turn off
}
"""Field and capability of the components that are one sensor each."""

_WATT_HOURS = 1 / 1000
"""Factor from Shelly's watt-hours."""

_ELECTRICAL = (
    ("apower", "power"),
    ("act_power", "power"),
    ("voltage", "voltage"),
    ("current", "current"),
    ("freq", "frequency"),
)
_COUNTED = (("aenergy", "energy"), ("ret_aenergy", "energy_returned"))
_PHASES = ("a", "b", "c")
_PHASE = (("act_power", "power"), ("voltage", "voltage"), ("current", "current"), ("freq", "frequency"))


def build_sensor(component: ShellyComponent) -> Parts:
    """Describe a component that is one sensor."""
    field, capability = SENSORS[component.kind]
    if component.kind == "illuminance" and field not in component.status and "illumination" in component.status:
        field, capability = "illumination", "value"
    if component.kind == "presencezone" and "value" in component.status:
        field = "value"  # from firmware 1.8 on
    tag = "presence" if component.kind == "presencezone" else ""
    part = component.part("", sensor_type(capability), category="diagnostic" if component.is_inside else "", tag=tag)
    is_probe = component.kind == "temperature" and component.index in _OF_ADD_ON
    component.read_status(part, partial(_decode_sensor, reader_of(field, capability), capability, is_probe=is_probe))
    part.add_capability(capability)
    return (part,)


_OF_ADD_ON = range(100, 200)
"""Numbers of components that an add-on measures."""


def _decode_sensor(read: StatusDecoder, capability: str, status: Fields, *, is_probe: bool) -> Readings:
    """Read a sensor; the number beside an error is invalid: a display without sensor reports -275 °C."""
    if status.get("errors"):
        return {capability: None}
    return read_probe(read(status), DS18X20_RESET) if is_probe else read(status)


_FURTHER: Mapping[str, tuple[tuple[str, str, str], ...]] = {
    "presencezone": (("num_objects", "objects", ""),),
    "voltmeter": (("xvoltage", "value", "xvoltage"),),
    "input": (
        ("xpercent", "value", "xpercent"),
        ("counts.xtotal", "value", "xcounts"),
        ("freq", "frequency", ""),
        ("xfreq", "rate", "xfreq"),
    ),
}
"""Path and name of further values by kind, and the formula of the owner by which they are calculated, with its unit."""


def build_further(component: ShellyComponent) -> Parts:
    """Describe the further values that the component reports."""
    parts: list[JsonPart] = []
    for path, name, formula in _FURTHER.get(component.kind, ()):
        if component.has(path):
            part = component.part(path, "x_sensor", name=name)
            unit = text_of(as_fields(component.config.get(formula)).get("unit"), MAX_UNIT_CHARACTERS)
            component.add_value(part, "measurement", path, unit=unit or ("Hz" if path == "freq" else ""))
            parts.append(part)
    return tuple(parts)


def build_power(component: ShellyComponent) -> Parts:
    """Describe a battery, if the device has one, and whether it is plugged in."""
    status = component.status
    part = component.part("", "x_battery", category="diagnostic")
    if "battery" in status or "external" not in status:
        component.add_value(part, "battery", "battery.percent")
    if "V" in as_fields(status.get("battery")):
        component.add_value(part, "voltage", "battery.V")
    if isinstance(status.get("external"), dict):
        component.add_value(part, "plugged_in", "external.present")
    return (part,)


def build_input(component: ShellyComponent) -> Parts:
    """Describe an input: a button, a switch, an analogue value or a counter, as it is configured."""
    kind, status = component.config.get("type"), component.status
    if component.config.get("enable") is False:
        return ()
    if kind == "analog" or (kind is None and "percent" in status and "state" not in status):
        return _build_measured_input(component, "percent", "%")
    if kind == "count":
        return _build_measured_input(component, "counts.total", "")
    is_button = kind != "switch"
    part = component.part("", "generic_switch" if is_button else "x_binary_sensor")
    if not is_button or component.status.get("state") is not None:
        component.add_value(part, "state", "state")
    if is_button:
        component.add_presses(part, PRESSES)
    return (part,)


def _build_measured_input(component: ShellyComponent, path: str, unit: str) -> Parts:
    part = component.part("", "x_sensor")
    component.add_value(part, "measurement", path, unit=unit)
    return (part,)


def build_meters(component: ShellyComponent) -> Parts:
    """Describe the electrical measurements of a component; none for one that has none."""
    if component.kind == "em":
        return _build_phases(component)
    is_meter = component.kind in {"pm1", "em1"}
    if not is_meter and "apower" not in component.status:
        return ()
    part = component.part("" if is_meter else "meter", "electrical_meter")
    for field, capability in _ELECTRICAL:
        if field in component.status:
            component.add_value(part, capability, field)
    for field, capability in _COUNTED:
        if isinstance(component.status.get(field), dict):
            component.add_value(part, capability, f"{field}.total", factor=_WATT_HOURS)
    if component.kind == "em1":
        _add_counters(component, part, f"em1data:{component.index}", "total_act_energy", "total_act_ret_energy")
    return (part,)


def _build_phases(component: ShellyComponent) -> Parts:
    data = f"emdata:{component.index}"
    total = component.part("", "electrical_meter")
    for field, capability in (("total_act_power", "power"), ("total_current", "current")):
        component.add_value(total, capability, field)
    _add_counters(component, total, data, "total_act", "total_act_ret")
    parts = [total]
    for phase in _PHASES:
        if f"{phase}_act_power" not in component.status:
            continue
        part = component.part(phase, "electrical_meter", tag=f"phase_{phase}")
        for field, capability in _PHASE:
            if field == "act_power" or component.has(f"{phase}_{field}"):
                component.add_value(part, capability, f"{phase}_{field}")
        _add_counters(component, part, data, f"{phase}_total_act_energy", f"{phase}_total_act_ret_energy")
        parts.append(part)
    return tuple(parts)


def _add_counters(component: ShellyComponent, part: JsonPart, key: str, drawn: str, returned: str) -> None:
    """Add the energy that the component *key* counts in both directions."""
    component.add_value(part, "energy", drawn, factor=_WATT_HOURS, key=key)
    component.add_value(part, "energy_returned", returned, factor=_WATT_HOURS, key=key)


def build_own_temperature(component: ShellyComponent) -> Parts:
    """Describe the temperature of the device itself, if the component reports it."""
    if not isinstance(component.status.get("temperature"), dict):
        return ()
    part = component.part("temperature", "temperature_sensor", category="diagnostic")
    component.add_value(part, "temperature", "temperature.tC")
    return (part,)
