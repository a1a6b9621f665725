"""Values that users or makers of a device define themselves, in Shelly's second generation. Pure.

The values of a maker's service are components of their own; those of a thermostat make one part.

Source: Shelly Gen2+ API, Virtual Components: Boolean, Number, Text, Enum and Button; XT1, Irrigation Controller, Smart
Water Valve, Neo smart water valve, Top AC Portable EV Charger, LinkedGo ST802 and ST1820; ShellyX, Manifest Reference;
Home Assistant core 2025.11, ``components/shelly/climate.py`` and ``sensor.py``.
"""

import re
from collections.abc import Mapping

from homebot.conventions.command_values import option_writer, percent_writer, push_writer
from homebot.conventions.description import Publications
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, percent_of, text_of
from homebot.conventions.units import number_grid, sensor_type
from homebot.integrations.shelly.formats.gen2_component import MAX_UNIT_CHARACTERS, ShellyComponent
from homebot.integrations.shelly.formats.status import Fields, texts_of
from homebot.support.numbers import to_number

Parts = tuple[JsonPart, ...]

VIRTUAL: Mapping[str, tuple[str, str]] = {
    "boolean": ("state", "state"),
    "number": ("number", "measurement"),
    "text": ("text", "value"),
    "enum": ("option", "value"),
}
"""By kind: the capability of a setting, and of a value that is only reported."""

_MEASURED: Mapping[str, tuple[str, str]] = {
    "average_temperature": ("temperature", ""),
    "last_precipitation": ("measurement", "mm"),
    "current_temperature": ("temperature", ""),
    "current_humidity": ("humidity", ""),
    "water_temperature": ("temperature", ""),
}
"""Capability and unit of the numbers of a maker's service, by role."""

_CONTROLLED: Mapping[tuple[str, str], tuple[str, str]] = {
    ("number", "target_humidity"): ("x_humidifier", "humidity_setpoint"),
    ("boolean", "state"): ("switch", "on_off"),
    ("boolean", "start_charging"): ("switch", "on_off"),
}
"""Service type and capability of the settings of a maker's service, by kind and role."""

_DISPLAYS = ("label", "progressbar")
"""Views of a value that a script of the user reports."""

_VALVE_POSITION = ("number", "position")
"""Kind and role of the opening of a water valve; blinds are covers in a maker's service."""

VALVE_STATE, CONSUMPTION = "state", "water_consumption"
"""Roles of a water valve that is only open or closed, and of the water that it has let through."""

_PHASES = "phase_info"
_CHARGED: tuple[tuple[str, Mapping[str, str]], ...] = (
    ("", {"power": "total_power", "energy": "total_act_energy"}),
    *((f"phase_{phase}", {key: f"phase_{phase}.{key}" for key in ("power", "voltage", "current")}) for phase in "abc"),
)
"""Meters of the Top AC Portable EV Charger, of which the object has that role: in kW and kWh."""

_ZONE = re.compile(r"zone[0-9]{1,2}")
_VALVES = ("open", "closed")


def build_virtual(component: ShellyComponent) -> Parts:
    """Describe a value as a setting, or by its role, its view or its access."""
    role, access = role_of(component.config), text_of(component.config.get("access")) or "*"
    if (component.kind, role) == _VALVE_POSITION or (component.kind == "boolean" and _ZONE.fullmatch(role)):
        return (build_valve(component, role),)
    is_shown = _ui(component.config).get("view") in _DISPLAYS or not {"w", "*"} & set(access)
    if is_shown or (component.kind == "number" and role in _MEASURED):
        plain = VIRTUAL[component.kind][1]
        own_unit = _unit(component.config) if plain == "measurement" else ""
        capability, unit = _MEASURED.get(role if component.kind == "number" else "", (plain, own_unit))
        part = component.part("", sensor_type(capability))
        component.add_value(part, capability, unit=unit)
        return (part,)
    kind, config = component.kind, component.config
    service_type, capability = _CONTROLLED.get((kind, role), ("x_setting", VIRTUAL[kind][0]))
    part = component.part("", service_type, category="config" if service_type == "x_setting" else "")
    component.add_value(
        part,
        capability,
        method=f"{kind.capitalize()}.Set",
        unit=_unit(config) if capability == "number" else "",
        bounds=_bounds_of(config) if kind == "number" else (),
        grid=_grid_of(config),
        options=texts_of(config.get("options")) if kind == "enum" else (),
    )
    return (part,)


def build_virtual_button(component: ShellyComponent) -> Parts:
    """Describe a button that can be pressed by command."""
    part = component.part("", "generic_switch")
    writer = push_writer("push", lambda: component.call("Button.Trigger", event="single_push"))
    part.add_capability("push", writer=writer, readable=False)
    return (part,)


def build_valve(component: ShellyComponent, role: str) -> JsonPart:
    """Describe a water valve, perhaps one that can be opened in part, or a zone of an irrigation controller."""
    has_position = component.kind == "number"

    def decode(status: Fields) -> Readings:
        value = status.get("value")
        opening = percent_of(value) if has_position else value
        if not isinstance(opening, bool | float):
            return NO_READINGS
        position: Readings = {"position": opening} if has_position else NO_READINGS
        return {"valve": "open" if opening else "closed", **position}

    def publish(percent: float) -> Publications:
        if has_position:
            return component.call("Number.Set", value=round(percent))
        return component.call("Boolean.Set", value=percent > 0)

    part = component.part("", "water_valve", tag=role)
    component.read_status(part, decode)
    writer = option_writer("valve", _VALVES, lambda state: publish(100.0 if state == "open" else 0.0))
    part.add_capability("valve", writer=writer, options=_VALVES)
    if has_position:
        part.add_capability("position", writer=percent_writer("position", publish))
    return part


def build_object(component: ShellyComponent) -> Parts:
    """Describe the water that a valve has let through, or the phases of a charger; other objects have no meaning."""
    role = role_of(component.config)
    if role == _PHASES:
        return tuple(_build_meter(component, *meter) for meter in _CHARGED)
    if role != CONSUMPTION:
        return ()
    part = component.part("", "x_sensor")
    component.add_value(part, "measurement", "value.counter.total", unit="m³")
    return (part,)


def _build_meter(component: ShellyComponent, suffix: str, fields: Mapping[str, str]) -> JsonPart:
    part = component.part(suffix, "electrical_meter", tag=suffix)
    for capability, path in fields.items():
        component.add_value(part, capability, f"value.{path}", factor=1000 if capability == "power" else 1)
    return part


def role_of(config: Fields) -> str:
    """Return the role of a value in a maker's service; empty for a user's own value."""
    owner, role = config.get("owner"), config.get("role")
    is_makers = isinstance(owner, str) and owner.startswith("service:")
    return role if is_makers and isinstance(role, str) else ""


def _unit(config: Fields) -> str:
    return text_of(_ui(config).get("unit"), MAX_UNIT_CHARACTERS)


def _ui(config: Fields) -> Fields:
    return as_fields(as_fields(config.get("meta")).get("ui"))


def _bounds_of(config: Fields) -> tuple[float, ...]:
    """Return the smallest and the largest value of a number; empty if they are not configured."""
    least, most = to_number(config.get("min")), to_number(config.get("max"))
    return (least, most) if least is not None and most is not None and least < most else ()


def _grid_of(config: Fields) -> tuple[float, ...]:
    return number_grid(config.get("min"), _ui(config).get("step"))


TARGET = "target_temperature"
OF_THERMOSTAT = frozenset({"enable", "working_mode", "fan_speed"})
"""Roles of the components that the thermostat has beside :data:`TARGET`, and which are no parts then."""

_WORKING_MODES: Mapping[str, str] = {"heat": "heat", "cool": "cool", "dry": "dry", "ventilation": "fan_only"}
"""Thermostat modes by working mode."""

_USUAL = (5.0, 35.0)


def build_service_thermostat(roles: Mapping[str, ShellyComponent]) -> JsonPart:
    """Describe the thermostat of the components with these *roles*, among them :data:`TARGET`."""
    target, working = roles[TARGET], roles.get("working_mode")
    part = target.part("", "thermostat")
    bounds = _bounds_of(target.config) or _USUAL
    listed = ("heat",) if working is None else texts_of(working.config.get("options"))
    functions = tuple(_WORKING_MODES[option] for option in listed if option in _WORKING_MODES)
    for setpoint in ("heating_setpoint", *(("cooling_setpoint",) if "cool" in functions else ())):
        target.add_value(part, setpoint, method="Number.Set", bounds=bounds, grid=_grid_of(target.config))
    if (room := roles.get("current_temperature")) is not None:
        room.add_value(part, "local_temperature")
    _add_mode(part, roles.get("enable"), working, functions)
    if (fan := roles.get("fan_speed")) is not None:
        fan.add_value(part, "fan_mode", method="Enum.Set", options=texts_of(fan.config.get("options")))
    return part


def _add_mode(
    part: JsonPart, enable: ShellyComponent | None, working: ShellyComponent | None, functions: tuple[str, ...]
) -> None:
    """Add the mode: ``off`` by one component, and by another one the function while it is on."""
    is_on, function = True, "heat" if working is None else None

    def read_enable(status: Fields) -> Readings:
        nonlocal is_on
        value = status.get("value")
        if not isinstance(value, bool):
            return NO_READINGS
        is_on = value
        return mode()

    def read_function(status: Fields) -> Readings:
        nonlocal function
        value = status.get("value")
        function = _WORKING_MODES.get(value) if isinstance(value, str) else None
        return mode()

    def mode() -> Readings:
        return {"thermostat_mode": function if is_on else "off"}

    def publish(mode: str) -> Publications:
        calls = enable.call("Boolean.Set", value=mode != "off") if enable is not None else ()
        if working is None or mode == "off":
            return calls
        chosen = next(name for name, known in _WORKING_MODES.items() if known == mode)
        return (*calls, *working.call("Enum.Set", value=chosen))

    if enable is not None:
        enable.read_status(part, read_enable)
    if working is not None:
        working.read_status(part, read_function)
    if enable is not None or working is not None:
        options = (*(("off",) if enable is not None else ()), *functions)
        part.remembers()
        part.add_capability(
            "thermostat_mode", writer=option_writer("thermostat_mode", options, publish), options=options
        )
