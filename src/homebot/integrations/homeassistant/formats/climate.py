"""Thermostats, air conditioners, heat pumps and water heaters, with temperatures in °C or °F. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/climate.py`` and ``water_heater.py``,
``components/climate/__init__.py`` and ``util/unit_conversion.py``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import require_bool, require_number
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.entity_rows import climate_type, modes_of_switch, setpoints_of
from homebot.conventions.payload import NO_READINGS, Readings, read_number, shown
from homebot.conventions.table_codec import write_mode_for_switch
from homebot.conventions.units import celsius_bounds, number_grid, to_celsius, to_fahrenheit
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity
from homebot.integrations.homeassistant.formats.topics import CommandTopic, ValueSource

_HEATER_MODES = ("eco", "electric", "gas", "heat_pump", "high_demand", "performance", "off")
_HEATER_RANGE = (to_celsius(110.0), to_celsius(140.0))


def build_climate(config: DiscoveryConfig) -> DescribedPart:
    """Describe a thermostat or an air conditioner."""
    modes = _modes(config)
    entity = Entity(config, climate_type(modes))
    targets = _Targets(config, modes)
    targets.add_to(entity, config)
    entity.add_number("humidity", _source_of(config, "current_humidity"), None, unit="%")
    humidity_command = config.command_of("target_humidity")
    source = _source_of(config, "target_humidity_state")
    least, most = config.number("min_humidity", 30.0), config.number("max_humidity", 99.0)
    if least >= most or most > 100:
        raise WireError(f"climate: max_humidity is {most:g}, not above min_humidity {least:g} and at most 100")
    if source is not None and humidity_command is None:
        raise WireError("climate: target_humidity_state_topic needs target_humidity_command_topic")
    entity.add_number("humidity_setpoint", source, humidity_command, bounds=(least, most), unit="%", to_device=int)
    mode = config.command_of("mode")
    entity.add_choice("thermostat_mode", _source_of(config, "mode_state"), mode, modes, on_command=targets.on_command)
    _add_switch(entity, config, mode, modes, targets)
    entity.add_choice("thermostat_action", _source_at(config, "action_topic", "action_template"), None, _ACTIONS)
    for name, default in _CHOICES.items():
        command = config.command_of(name)
        options = config.options(f"{name}s") if config.has(f"{name}s") else default
        entity.add_choice(name, _source_of(config, f"{name}_state"), command, options)
    presets = config.options("preset_modes")
    if "none" in presets:
        raise WireError("climate: preset_modes has none, which means that there is no preset")
    command = config.command_of("preset_mode")
    if presets and command is not None:
        source = _source_at(config, "preset_mode_state_topic", "preset_mode_value_template")
        entity.add_choice("preset_mode", source, command, ("none", *presets), meanings={"None": "none"})
    return entity.build()


_MODES = ("auto", "off", "cool", "heat", "dry", "fan_only")
_ACTIONS = ("off", "heating", "cooling", "drying", "idle", "fan", "preheating", "defrosting")
_CHOICES = {
    "fan_mode": ("auto", "low", "medium", "high"),
    "swing_mode": ("on", "off"),
    "swing_horizontal_mode": ("on", "off"),
}
"""Default options by capability, which is also the beginning of the fields."""

_SHOWN = 200


def _modes(config: DiscoveryConfig) -> tuple[str, ...]:
    """Return its modes; those of Home Assistant for a mode without a list.

    A valve without a mode has none, although Home Assistant shows it with all of its own: it is no air conditioner.
    """
    if config.has("modes"):
        return config.options("modes")
    return _MODES if config.has("mode_command_topic") or config.has("mode_state_topic") else ()


def _add_switch(
    entity: Entity, config: DiscoveryConfig, mode: CommandTopic | None, modes: tuple[str, ...], targets: _Targets
) -> None:
    """Add ``on_off``: with a topic of its own, or else by the mode, as in Home Assistant."""
    power = config.command_of("power")
    command = power or mode
    texts = config.on_off_payloads() if power else modes_of_switch(modes)
    source = _source_of(config, "mode_state") if "off" in modes else None

    def write(value: PlainValue, _transition: float) -> Publications:
        is_on = require_bool("on_off", value)
        if is_on not in texts:
            raise RefusedError(f"on_off {shown(value)}", f"none of its modes is that: {', '.join(modes)[:_SHOWN]}")
        publications = command.publish(texts[is_on]) if command else ()
        if power is None:
            targets.on_command(texts[is_on])
        return publications

    is_readable = entity.read_text_from(source, partial(_read_switch, modes))
    is_settable = power is not None or (mode is not None and "off" in modes)
    entity.add_capability("on_off", readable=is_readable, writer=write if is_settable else None)
    if power is None:
        entity.joint = write_mode_for_switch
    entity.add_commands(power)


def _read_switch(modes: tuple[str, ...], text: str) -> Readings:
    if text == "None":
        return {"on_off": None}
    return {"on_off": text != "off"} if text in modes else NO_READINGS


def build_water_heater(config: DiscoveryConfig) -> DescribedPart:
    """Describe a water heater. Its switch, if it has a topic, is never reported."""
    temperatures = _read_temperatures(config, *_HEATER_RANGE)
    entity = Entity(config, "water_heater")
    temperatures.add_setpoint(entity, "heating_setpoint", config, "temperature")
    temperatures.add_measured(entity, config)
    modes = config.options("modes") if config.has("modes") else _HEATER_MODES
    entity.add_choice("water_heater_mode", _source_of(config, "mode_state"), config.command_of("mode"), modes)
    entity.add_flag("on_off", None, config.command_of("power"), config.on_off_payloads())
    return entity.build()


@dataclass(frozen=True, slots=True)
class _Temperatures:
    """Temperatures of a device: its unit, °F or °C, and its lowest and highest setpoint in that unit; a grid in °C."""

    is_fahrenheit: bool
    low: float
    high: float
    grid: tuple[float, ...]

    @property
    def bounds(self) -> tuple[float, float]:
        """The setpoints in °C; see :func:`celsius_bounds`."""
        return celsius_bounds(self.low, self.high) if self.is_fahrenheit else (self.low, self.high)

    def celsius(self, number: float) -> float:
        return to_celsius(number) if self.is_fahrenheit else number

    def number(self, celsius: float) -> float:
        """Return a setpoint in °C as the device's number, which is within its range."""
        return min(max(to_fahrenheit(celsius) if self.is_fahrenheit else celsius, self.low), self.high)

    def add_setpoint(self, entity: Entity, name: str, config: DiscoveryConfig, key: str) -> None:
        """Add the setpoint *name* from the fields that begin with *key*."""
        entity.add_number(
            name,
            _source_of(config, f"{key}_state"),
            config.command_of(key),
            bounds=self.bounds,
            grid=self.grid,
            unit="°C",
            from_device=self.celsius,
            to_device=self.number,
        )

    def add_measured(self, entity: Entity, config: DiscoveryConfig) -> None:
        source = _source_of(config, "current_temperature")
        entity.add_number("local_temperature", source, None, unit="°C", from_device=self.celsius)


def _read_temperatures(config: DiscoveryConfig, least: float, most: float) -> _Temperatures:
    """Return the temperatures of a config, with the default range *least* to *most* in °C."""
    unit = config.text("temperature_unit", "C").strip().upper().removeprefix("°")
    if unit not in ("C", "F"):
        raise WireError(f"{config.component}: temperature_unit is {shown(unit)}, not C or F")
    low, high = (to_fahrenheit(end) if unit == "F" else end for end in (least, most))
    least, most = config.number("min_temp", low), config.number("max_temp", high)
    step = config.values.get("temp_step", config.values.get("precision"))
    return _Temperatures(unit == "F", least, most, number_grid(0, step, is_fahrenheit=unit == "F"))


def _source_of(config: DiscoveryConfig, name: str) -> ValueSource | None:
    """Return the source of *name* of a climate device; ``value_template`` is the default template."""
    return _source_at(config, f"{name}_topic", f"{name}_template")


def _source_at(config: DiscoveryConfig, topic_key: str, template_key: str) -> ValueSource | None:
    """Return a source as :func:`_source_of`, for fields with other names."""
    return config.source(topic_key, template_key if config.has(template_key) else "value_template")


_SINGLE = "temperature"
_ENDS = {"heating_setpoint": "temperature_low", "cooling_setpoint": "temperature_high"}


class _Targets:
    """The targets of a thermostat, with its mode and their last values by key.

    Of a pair the lower one heats and the upper one cools. Of a pair and a single one, the pair is effective in the mode
    ``heat_cool``, and the single one in any other. In an unknown mode neither is commanded. Without modes the pair is
    effective.
    """

    def __init__(self, config: DiscoveryConfig, modes: tuple[str, ...]) -> None:
        self._modes = modes
        self._by_single = setpoints_of(modes)
        self._temperatures = _read_temperatures(config, 7.0, 35.0)
        self._is_mode_reported = config.has("mode_state_topic") and not config.flag("optimistic")
        self._mode: str | None = None
        self._commands: dict[str, CommandTopic] = {}
        self._names: list[str] = []
        self._last_values: dict[str, PlainValue] = {}

    def on_command(self, mode: str) -> None:
        """Record the mode of a command, if the device reports none."""
        if not self._is_mode_reported:
            self._mode = mode

    def add_to(self, entity: Entity, config: DiscoveryConfig) -> None:
        single, *pair = (
            config.has(f"{key}_command_topic") or config.has(f"{key}_state_topic") for key in (_SINGLE, *_ENDS.values())
        )
        if single and any(pair) and self._modes:
            ends = [end for end, is_there in zip(_ENDS.values(), pair, strict=True) if is_there]
            self._add_both(entity, config, (_SINGLE, *ends))
        else:
            for name, key in _ENDS.items() if any(pair) else dict.fromkeys(self._by_single, _SINGLE).items():
                self._temperatures.add_setpoint(entity, name, config, key)
        self._temperatures.add_measured(entity, config)

    def _add_both(self, entity: Entity, config: DiscoveryConfig, keys: tuple[str, ...]) -> None:
        """Add a single target and a pair; each setpoint is set in one of several ways."""
        self._commands = {key: command for key in keys if (command := config.command_of(key)) is not None}
        # The mode is read first: it selects the target in the same message.
        entity.read_text_from(_source_of(config, "mode_state"), self._read_mode)
        readable = {
            key: entity.read_text_from(_source_of(config, f"{key}_state"), partial(self._read, key)) for key in keys
        }
        for name, end in _ENDS.items():  # a setpoint is the target of one or of several keys, by the mode
            ways = [key for key in keys if key == end or (key == _SINGLE and name in self._by_single)]
            if not ways:
                continue
            self._names.append(name)
            is_settable = not self._commands.keys().isdisjoint(ways)
            entity.add_capability(
                name,
                readable=any(readable[way] for way in ways),
                writer=partial(self._write, name) if is_settable else None,
                unit="°C",
                bounds=self._temperatures.bounds if is_settable else (),
                grid=self._temperatures.grid,
            )
        entity.add_commands(*self._commands.values())
        entity.remembers()

    def _read_mode(self, text: str) -> Readings:
        """Read the mode, which may make other, earlier reported targets effective."""
        if text != "None" and text not in self._modes:
            return NO_READINGS
        was_pair = self._is_pair
        self._mode = None if text == "None" else text
        if self._is_pair == was_pair:
            return NO_READINGS
        return {name: self._last_values.get(self._key(name)) for name in self._names}

    def _read(self, key: str, text: str) -> Readings:
        readings = read_number(key, text, convert=self._temperatures.celsius)
        if not readings:
            return NO_READINGS
        self._last_values[key] = readings[key]
        return {name: readings[key] for name in self._names if self._key(name) == key}

    def _write(self, name: str, value: PlainValue, _transition: float) -> Publications:
        number = self._temperatures.number(require_number(name, value, *self._temperatures.bounds, "°C"))
        if self._mode is None:
            raise RefusedError(
                f"{name} {number:g}", "its mode is unknown, and with it the setpoint; set its mode first"
            )
        command = self._commands.get(self._key(name))
        if command is None:
            raise RefusedError(f"{name} in mode {self._mode}", "there is no such setpoint in that mode")
        return command.publish(number)

    @property
    def _is_pair(self) -> bool:
        return self._mode == "heat_cool"

    def _key(self, name: str) -> str:
        """Return the key of the effective target of *name*; empty for none."""
        if self._is_pair:
            return _ENDS[name]
        return _SINGLE if name in self._by_single else ""
