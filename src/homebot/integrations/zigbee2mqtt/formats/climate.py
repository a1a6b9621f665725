"""Thermostats and air conditioners that Zigbee2MQTT knows. Pure.

Some thermostats report their program in a second property; both make up one mode.

Source: zigbee2mqtt.io, Usage > Exposes > climate; temperatures are in °C. zigbee-herdsman-converters 26.105.0, Bosch
BTH-RA, BTH-RM and BTH-RM230Z, as Zigbee2MQTT 2.14.1 announces them to Home Assistant: paused is off, and
``system_mode`` is valid only in manual operation.
"""

from collections.abc import Collection, Mapping
from functools import partial

from homebot.conventions.command_values import bool_writer, require_bool, require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.entity_rows import climate_type, modes_of_switch, setpoints_of
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text, unreadable
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.zigbee2mqtt.formats.expose import Expose
from homebot.integrations.zigbee2mqtt.formats.features import Zigbee2MqttPart, Zigbee2MqttTopics, text_of

_MANUAL = "manual"
_MODES = {"schedule": "auto", "pause": "off"}
_OPTIONS = {mode: option for option, mode in _MODES.items()}
_PAIR = 2


def is_program(expose: Expose) -> bool:
    """Return whether *expose* is the program of a thermostat: schedule, manual or pause."""
    is_whole = expose.is_published and expose.is_settable
    return expose.name == "operating_mode" and is_whole and set(expose.options) == {_MANUAL, *_MODES}


class _Mode:
    """Reader and writer of the mode, from the enums ``system_mode`` and ``operating_mode``."""

    def __init__(self, topics: Zigbee2MqttTopics, mode: Expose, program: Expose) -> None:
        self._topics = topics
        self._mode = mode
        self._program = program
        self._by_hand = tuple(option for option in mode.options if option not in _OPTIONS)
        self._options = ("off", *self._by_hand, "auto")

    def add_to(self, part: Zigbee2MqttPart) -> None:
        """Add ``thermostat_mode`` and ``on_off``."""
        part.read_from(part.topics.state, self._read)
        part.add_capability("thermostat_mode", writer=self._write, options=self._options)
        part.add_capability("on_off", writer=self._write_switch)

    def _read(self, message: JsonMessage) -> Readings:
        if self._program.key not in message:
            return NO_READINGS
        reported = message[self._program.key]
        if reported is None:
            return {"thermostat_mode": None, "on_off": None}
        if reported == _MANUAL:
            reported = message.get(self._mode.key)
            option = reported if reported in self._by_hand else self._by_hand[0] if len(self._by_hand) == 1 else None
        else:
            option = _MODES.get(reported) if isinstance(reported, str) else None
        if option is None:
            return unreadable(reported, self._options)
        return {"thermostat_mode": option, "on_off": option != "off"}

    def _write(self, value: PlainValue, _transition: float) -> Publications:
        target = require_option("thermostat_mode", value, self._options)
        if target in _OPTIONS:
            return self._topics.publish({self._program.key: _OPTIONS[target]})
        further = {self._mode.key: self._mode.options[target]} if len(self._mode.options) >= _PAIR else {}
        return self._topics.publish({self._program.key: _MANUAL, **further})

    def _write_switch(self, value: PlainValue, transition: float) -> Publications:
        return self._write(_mode_of(value, self._options), transition)


def _read_switch(options: Collection[str], value: object) -> bool | None:
    mode = text_of(value)
    return mode != "off" if mode in options else None


def _mode_of(on: PlainValue, modes: Collection[str]) -> str:
    """Return the mode of on or off.

    Raises:
        RefusedError: *on* is no boolean, or no mode of the device is on.
    """
    target = modes_of_switch(modes).get(require_bool("on_off", on))
    if target is None:
        raise RefusedError("on_off true", f"none of its modes is that: {', '.join(modes)[:_SHOWN]}")
    return target


def type_of_climate(climate: Expose) -> str:
    """Return the service type."""
    mode = climate.feature("system_mode")
    return climate_type(mode.options if mode is not None else ())


def build_climate(part: Zigbee2MqttPart, climate: Expose, program: Expose | None) -> DescribedPart:
    """Describe a thermostat; *program* is the enum of its program."""
    part.add_number(climate.feature("local_temperature"), "local_temperature")
    mode = climate.feature("system_mode")
    single, cooling = climate.feature(*_SINGLE), climate.feature(_COOLING)
    part.add_number(cooling, "cooling_setpoint")
    for setpoint in (
        setpoints_of(mode.options if mode is not None else ()) if cooling is None else ("heating_setpoint",)
    ):
        part.add_number(single, setpoint)
    if mode is not None and program is not None:
        _Mode(part.topics, mode, program).add_to(part)
    else:
        part.add_enum(mode, "thermostat_mode")
        if mode is not None and "off" in mode.options:
            options, key = mode.options, mode.key
            writer = bool_writer("on_off", lambda on: part.topics.publish({key: options[_mode_of(on, options)]}))
            part.add_feature(mode, "on_off", partial(_read_switch, options), writer if mode.is_settable else None)
    for capability, name, meanings in _ENUMS:
        part.add_enum(climate.feature(name), capability, meanings)
    part.request(*climate.own_features)
    return part.build()


def build_thermometer(topics: Zigbee2MqttTopics, climate: Expose) -> DescribedPart | None:
    """Describe the thermometer in a thermostat as a sensor; None for none."""
    local = climate.feature("local_temperature")
    if local is None or not local.is_published:
        return None
    part = Zigbee2MqttPart(topics, clean_text(local.key), "temperature_sensor", name=local.title, advertised=local.name)
    part.add_number(local, "temperature")
    return part.build()


_SHOWN = 200
_SINGLE = ("occupied_heating_setpoint", "current_heating_setpoint")
_COOLING = "occupied_cooling_setpoint"
_ENUMS: tuple[tuple[str, str, Mapping[str, str] | None], ...] = (
    ("fan_mode", "fan_mode", None),
    ("swing_mode", "swing_mode", None),
    ("preset_mode", "preset", None),
    ("thermostat_action", "running_state", {"idle": "idle", "heat": "heating", "cool": "cooling", "fan_only": "fan"}),
)
"""Capability, feature, and the vocabulary's names of its values if they differ."""
