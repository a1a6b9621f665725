"""The temperatures of the component ``climate``: the one that it measures, and those that it shall reach. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/climate.py`` and ``components/climate/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

from homebot.conventions.command_values import require_number
from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import Publication
from homebot.conventions.homeassistant.capabilities import add_number
from homebot.conventions.homeassistant.climate_source import source_of
from homebot.conventions.homeassistant.command_topic import CommandTopic
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.temperature import Limits, read_thermometer
from homebot.conventions.homeassistant.value_parsing import read_number
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["TargetMode", "add_temperatures"]


@dataclass(slots=True)
class TargetMode:
    """The mode of a thermostat, as far as its targets depend on it.

    Attributes:
        is_reported: Whether it says its mode; else what it was told counts.
        mode: Its last mode; None for unknown.
    """

    is_reported: bool
    mode: str | None = None

    def take_command(self, mode: str) -> None:
        """Take the mode that it was told."""
        if not self.is_reported:
            self.mode = mode

    @property
    def is_pair(self) -> bool:
        """True if the pair of targets counts, and not the single one."""
        return self.mode == "heat_cool"


def add_temperatures(entity: Entity, config: DiscoveryConfig, modes: tuple[str, ...], mode: TargetMode) -> None:
    """Offer what it measures and what it shall reach.

    A single target is a ``heating_setpoint`` where it can heat or does not say what it can, and a ``cooling_setpoint``
    where it can cool. Of a pair the lower one heats and the upper one cools. Where there is both, the pair counts in
    the mode ``heat_cool``, and the single one in any other, also while the mode is unknown.
    """
    thermometer = read_thermometer(config)
    limits = thermometer.limits(config, 7.0, 35.0)
    measured = source_of(config, "current_temperature")
    has_pair = any(_is_there(config, end) for end in _ENDS.values())
    by_single = _by_single(modes)
    if has_pair and _is_there(config, _SINGLE):
        _add_both(entity, config, modes, mode, limits, by_single)
    else:
        for name, key in _ENDS.items() if has_pair else ((name, _SINGLE) for name in by_single):
            add_number(
                entity,
                name,
                source_of(config, f"{key}_state"),
                _command(config, key),
                bounds=limits.bounds,
                unit="°C",
                from_device=thermometer.celsius,
                to_device=limits.number,
            )
    add_number(entity, "local_temperature", measured, None, unit="°C", from_device=thermometer.celsius)


_SINGLE = "temperature"
_ENDS = {"heating_setpoint": "temperature_low", "cooling_setpoint": "temperature_high"}
_HEATS = frozenset({"heat", "heat_cool", "auto"})
_COOLS = frozenset({"cool", "heat_cool"})


def _is_there(config: DiscoveryConfig, key: str) -> bool:
    return config.has(f"{key}_command_topic") or config.has(f"{key}_state_topic")


def _by_single(modes: tuple[str, ...]) -> tuple[str, ...]:
    """Return what a single target is."""
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
    mode_source = source_of(config, "mode_state")  # is read first: of one message it selects what the others mean
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
    """A single target and a pair, of which the mode says which count: by capability, and what they last said by key."""

    mode: TargetMode
    limits: Limits
    by_single: tuple[str, ...]
    commands: Mapping[str, CommandTopic]
    names: list[str] = field(default_factory=list)
    last_values: dict[str, PlainValue] = field(default_factory=dict)

    def read_mode(self, modes: frozenset[str], text: str) -> Readings:
        """Take the mode; with it other targets may count, which were said before."""
        if text != "None" and text not in modes:
            return NO_READINGS
        was_pair = self.mode.is_pair
        self.mode.mode = None if text == "None" else text
        if self.mode.is_pair == was_pair:
            return NO_READINGS
        return {name: self.last_values.get(self._key(name)) for name in self.names}

    def read(self, key: str, text: str) -> Readings:
        """Take the target *key*."""
        found = read_number(key, text, convert=self.limits.thermometer.celsius)
        if not found:
            return NO_READINGS
        self.last_values[key] = found[key]
        return {name: found[key] for name in self.names if self._key(name) == key}

    def write(self, name: str, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        number = self.limits.number(require_number(name, value, *self.limits.bounds, "°C"))
        command = self.commands.get(self._key(name))
        if command is None:
            raise RefusedError(f"{name} in mode {self.mode.mode or 'unknown'}", "it has no such target in that mode")
        return (command.publication(number),)

    def _key(self, name: str) -> str:
        """Return which target is *name* now; empty where none is."""
        if self.mode.is_pair:
            return _ENDS[name]
        return _SINGLE if name in self.by_single else ""
