"""The thermostat of a maker's service, of which each value is a component of its own. Pure.

Source: Shelly Gen2+ API, XT1: LinkedGo ST802 and ST1820; Home Assistant core 2025.11, ``components/shelly/climate.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.conventions.command_values import option_writer
from homebot.conventions.description import Publications
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.conventions.shelly.gen2_component import ShellyComponent
from homebot.conventions.shelly.gen2_virtual import bounds_of, options_of
from homebot.conventions.shelly.status import Fields

__all__ = ["OF_THERMOSTAT", "TARGET", "build_service_thermostat"]

TARGET = "target_temperature"
OF_THERMOSTAT = frozenset({"enable", "working_mode", "fan_speed"})
"""Roles of the components that the thermostat has beside :data:`TARGET`, and which are no parts then."""

_MODES: Mapping[str, str] = {"heat": "heat", "cool": "cool", "dry": "dry", "ventilation": "fan_only"}
"""Thermostat modes by working mode."""

_USUAL = (5.0, 35.0)


def build_service_thermostat(roles: Mapping[str, ShellyComponent]) -> JsonPart:
    """Describe the thermostat of the components with these *roles*, among them :data:`TARGET`."""
    target = roles[TARGET]
    part = target.part("", "thermostat")
    mode = _ServiceMode(roles.get("enable"), roles.get("working_mode"))
    bounds = bounds_of(target.config) or _USUAL
    for setpoint in ("heating_setpoint", *(("cooling_setpoint",) if "cool" in mode.options else ())):
        target.add_value(part, setpoint, method="Number.Set", bounds=bounds)
    if (room := roles.get("current_temperature")) is not None:
        room.add_value(part, "local_temperature")
    mode.add_to(part)
    if (fan := roles.get("fan_speed")) is not None:
        fan.add_value(part, "fan_mode", method="Enum.Set", options=options_of(fan.config))
    return part


@dataclass(slots=True)
class _ServiceMode:
    """The mode: ``off`` by one component, and by another one the function while it is on."""

    enable: ShellyComponent | None
    working: ShellyComponent | None
    _is_on: bool = True
    _function: str | None = None

    @property
    def options(self) -> tuple[str, ...]:
        listed = ("heat",) if self.working is None else options_of(self.working.config)
        return tuple(_MODES[one] for one in listed if one in _MODES)

    def add_to(self, part: JsonPart) -> None:
        if self.enable is not None:
            self.enable.read_status(part, self._read_enable)
        if self.working is not None:
            self.working.read_status(part, self._read_function)
        else:
            self._function = "heat"
        if self.enable is None and self.working is None:
            return
        options = (*(("off",) if self.enable is not None else ()), *self.options)
        part.remembers()
        writer = option_writer("thermostat_mode", options, self._publish)
        part.add_capability("thermostat_mode", writer=writer, options=options)

    def _read_enable(self, status: Fields) -> Readings:
        value = status.get("value")
        if not isinstance(value, bool):
            return NO_READINGS
        self._is_on = value
        return self._mode()

    def _read_function(self, status: Fields) -> Readings:
        value = status.get("value")
        self._function = _MODES.get(value) if isinstance(value, str) else None
        return self._mode()

    def _mode(self) -> Readings:
        return {"thermostat_mode": self._function if self._is_on else "off"}

    def _publish(self, mode: str) -> Publications:
        calls = self.enable.call("Boolean.Set", value=mode != "off") if self.enable is not None else ()
        if self.working is None or mode == "off":
            return calls
        function = next(name for name, known in _MODES.items() if known == mode)
        return (*calls, *self.working.call("Enum.Set", value=function))
