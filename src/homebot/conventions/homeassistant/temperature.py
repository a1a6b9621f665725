"""Measured temperatures and setpoints of devices in °C or °F. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/climate.py``, ``components/climate/__init__.py`` and
``util/unit_conversion.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

from homebot.conventions.command_values import require_number
from homebot.conventions.description import Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import CommandTopic, ValueSource
from homebot.conventions.payload import NO_READINGS, Readings, read_number, shown
from homebot.conventions.units import celsius_bounds, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

__all__ = ["Limits", "TargetMode", "Thermometer", "add_temperatures", "read_thermometer", "source_at", "source_of"]


@dataclass(frozen=True, slots=True)
class Thermometer:
    """The unit of a device, °F or °C; homebot's is °C."""

    is_fahrenheit: bool

    def celsius(self, number: float) -> float:
        """Return the device's *number* in °C."""
        return to_celsius(number) if self.is_fahrenheit else number

    def number(self, celsius: float) -> float:
        """Return a temperature in °C as the device's number."""
        return to_fahrenheit(celsius) if self.is_fahrenheit else celsius

    def limits(self, config: DiscoveryConfig, least: float, most: float) -> Limits:
        """Return the config's ``min_temp`` and ``max_temp``, with the defaults *least* and *most* in °C."""
        low, high = config.optional_number("min_temp"), config.optional_number("max_temp")
        return Limits(self, self.number(least) if low is None else low, self.number(most) if high is None else high)


@dataclass(frozen=True, slots=True)
class Limits:
    """The lowest and the highest number of a device, in its unit."""

    thermometer: Thermometer
    low: float
    high: float

    @property
    def bounds(self) -> tuple[float, float]:
        """The two in °C; see :func:`celsius_bounds`."""
        return celsius_bounds(self.low, self.high) if self.thermometer.is_fahrenheit else (self.low, self.high)

    def number(self, celsius: float) -> float:
        """Return a temperature within :attr:`bounds` as the device's number, which is within its own."""
        return min(max(self.thermometer.number(celsius), self.low), self.high)


def read_thermometer(config: DiscoveryConfig) -> Thermometer:
    """Return the unit of a device, by default °C.

    Raises:
        WireError: It names another unit.
    """
    unit = config.text("temperature_unit", "C").strip().upper().removeprefix("°")
    if unit not in ("C", "F"):
        raise WireError(f"{config.component}: temperature_unit is {shown(unit)}, not C or F")
    return Thermometer(unit == "F")


def source_of(config: DiscoveryConfig, name: str) -> ValueSource | None:
    """Return the source of *name* of a climate device; ``value_template`` is the default template."""
    return source_at(config, f"{name}_topic", f"{name}_template")


def source_at(config: DiscoveryConfig, topic_key: str, template_key: str) -> ValueSource | None:
    """Return a source as :func:`source_of`, for fields with other names."""
    return config.source(topic_key, template_key if config.has(template_key) else "value_template")


@dataclass(slots=True)
class TargetMode:
    """The mode of a thermostat, on which its targets depend.

    Attributes:
        is_reported: Whether it reports its mode; otherwise its last command is assumed.
        mode: Its last mode; None for unknown.
    """

    is_reported: bool
    mode: str | None = None

    def on_command(self, mode: str) -> None:
        """Record the mode of a command."""
        if not self.is_reported:
            self.mode = mode

    @property
    def is_pair(self) -> bool:
        """True if the pair of targets is effective, not the single one."""
        return self.mode == "heat_cool"


def add_temperatures(entity: Entity, config: DiscoveryConfig, modes: tuple[str, ...], mode: TargetMode) -> None:
    """Add the current temperature and the setpoints.

    A single target is a ``heating_setpoint`` if the device heats or has no modes, and a ``cooling_setpoint`` if it
    cools. Of a pair the lower one heats and the upper one cools. Of both, the pair is effective in the mode
    ``heat_cool``, and the single one in any other. In an unknown mode neither is commanded. Without modes the pair is
    effective.
    """
    thermometer = read_thermometer(config)
    limits = thermometer.limits(config, 7.0, 35.0)
    measured = source_of(config, "current_temperature")
    has_pair = any(_is_there(config, end) for end in _ENDS.values())
    by_single = _by_single(modes)
    if has_pair and modes and _is_there(config, _SINGLE):
        _add_both(entity, config, modes, mode, limits, by_single)
    else:
        for name, key in _ENDS.items() if has_pair else ((name, _SINGLE) for name in by_single):
            entity.add_number(
                name,
                source_of(config, f"{key}_state"),
                _command(config, key),
                bounds=limits.bounds,
                unit="°C",
                from_device=thermometer.celsius,
                to_device=limits.number,
            )
    entity.add_number("local_temperature", measured, None, unit="°C", from_device=thermometer.celsius)


_SINGLE = "temperature"
_ENDS = {"heating_setpoint": "temperature_low", "cooling_setpoint": "temperature_high"}
_HEATS = frozenset({"heat", "heat_cool", "auto"})
_COOLS = frozenset({"cool", "heat_cool"})


def _is_there(config: DiscoveryConfig, key: str) -> bool:
    return config.has(f"{key}_command_topic") or config.has(f"{key}_state_topic")


def _by_single(modes: tuple[str, ...]) -> tuple[str, ...]:
    """Return the capabilities of a single target."""
    cools = ("cooling_setpoint",) if _COOLS.intersection(modes) else ()
    return (*cools, "heating_setpoint") if not cools or _HEATS.intersection(modes) else cools


def _command(config: DiscoveryConfig, key: str) -> CommandTopic | None:
    return config.command(f"{key}_command_topic", f"{key}_command_template")


def _add_both(
    entity: Entity,
    config: DiscoveryConfig,
    modes: tuple[str, ...],
    mode: TargetMode,
    limits: Limits,
    by_single: tuple[str, ...],
) -> None:
    keys = (_SINGLE, *(end for end in _ENDS.values() if _is_there(config, end)))
    commands = {key: command for key in keys if (command := _command(config, key)) is not None}
    targets = _Targets(mode, limits, by_single, commands)
    mode_source = source_of(config, "mode_state")  # read first: the mode selects the target in the same message
    entity.read_text_from(mode_source, partial(targets.read_mode, frozenset(modes)))
    readable = {
        key: entity.read_text_from(source_of(config, f"{key}_state"), partial(targets.read, key)) for key in keys
    }
    for name, end in _ENDS.items():
        ways = [_SINGLE] if name in by_single else []
        ways += [end] if end in keys else []
        if not ways:
            continue
        is_settable = any(way in commands for way in ways)
        targets.names.append(name)
        entity.add_capability(
            name,
            readable=any(readable[way] for way in ways),
            writer=partial(targets.write, name) if is_settable else None,
            unit="°C",
            bounds=limits.bounds if is_settable else (),
        )
    entity.add_commands(*commands.values())
    entity.remembers()


@dataclass(frozen=True, slots=True)
class _Targets:
    """A single target and a pair, selected by the mode, with their last values by key."""

    mode: TargetMode
    limits: Limits
    by_single: tuple[str, ...]
    commands: Mapping[str, CommandTopic]
    names: list[str] = field(default_factory=list)
    last_values: dict[str, PlainValue] = field(default_factory=dict)

    def read_mode(self, modes: frozenset[str], text: str) -> Readings:
        """Read the mode, which may make other, earlier reported targets effective."""
        if text != "None" and text not in modes:
            return NO_READINGS
        was_pair = self.mode.is_pair
        self.mode.mode = None if text == "None" else text
        if self.mode.is_pair == was_pair:
            return NO_READINGS
        return {name: self.last_values.get(self._key(name)) for name in self.names}

    def read(self, key: str, text: str) -> Readings:
        """Read the target *key*."""
        found = read_number(key, text, convert=self.limits.thermometer.celsius)
        if not found:
            return NO_READINGS
        self.last_values[key] = found[key]
        return {name: found[key] for name in self.names if self._key(name) == key}

    def write(self, name: str, value: PlainValue, _transition: float) -> Publications:
        number = self.limits.number(require_number(name, value, *self.limits.bounds, "°C"))
        if self.mode.mode is None:
            raise RefusedError(
                f"{name} {number:g}", "its mode is unknown, and with it the setpoint; set its mode first"
            )
        command = self.commands.get(self._key(name))
        if command is None:
            raise RefusedError(f"{name} in mode {self.mode.mode}", "there is no such setpoint in that mode")
        return command.publish(number)

    def _key(self, name: str) -> str:
        """Return the key of the effective target of *name*; empty for none."""
        if self.mode.is_pair:
            return _ENDS[name]
        return _SINGLE if name in self.by_single else ""
