"""Covers, locks, fans, valves, sirens and thermostats that Zigbee2MQTT knows. Pure.

Some thermostats report their program in a second property; both make up one mode.

Source: zigbee2mqtt.io, Usage > Exposes > climate, cover, lock and fan; temperatures are in °C.
zigbee-herdsman-converters 26.105.0, ``warning``, Bosch BTH-RA, BTH-RM and BTH-RM230Z; percentages and modes as
Zigbee2MQTT 2.14.1 announces them to Home Assistant: paused is off, and ``system_mode`` is valid only in manual
operation.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import (
    bool_writer,
    option_writer,
    percent_writer,
    push_writer,
    require_bool,
    require_option,
    speed_of,
)
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.entity_rows import climate_type, modes_of_switch, setpoints_of
from homebot.conventions.payload import NO_READINGS, JsonMessage, Readings, clean_text, unreadable
from homebot.conventions.units import percent_grid
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.zigbee2mqtt.formats.expose import Expose
from homebot.integrations.zigbee2mqtt.formats.features import (
    Zigbee2MqttPart,
    Zigbee2MqttTopics,
    read_finite,
    same_scalar,
    text_of,
)
from homebot.support.numbers import finite_number


def build_cover(part: Zigbee2MqttPart, cover: Expose, motor: Expose | None) -> DescribedPart:
    """Describe a cover; *motor* is the enum of its motor's direction."""
    state, position, tilt = (cover.feature(name) for name in ("state", "position", "tilt"))
    topics = part.topics
    if state is not None:
        part.read_from(topics.state, _Movement(state.key, position.key if position else "", motor).read)
        writer = option_writer("movement", _COMMANDS, lambda movement: topics.publish({state.key: _COMMANDS[movement]}))
        part.add_capability("movement", readable=state.is_published, writer=writer if state.is_settable else None)
    for name, feature in (("position", position), ("tilt", tilt)):
        if feature is not None:
            part.read_feature(feature, name, _percent)
            writer = percent_writer(name, partial(_set, topics, feature.key))
            part.add_capability(name, readable=feature.is_published, writer=writer if feature.is_settable else None)
    part.request(state, position, tilt)
    return part.build()


@dataclass(frozen=True, slots=True)
class _Movement:
    """Reader of the movement of a cover.

    The direction of a motor often stays in the message after the arrival, so an end on which state and position agree
    precedes it. If a motor only reports that it runs, the state is the target (Tuya TS0601 covers) or the last end
    (Aqara curtains): it is used at the end that it names, and elsewhere only if it can only be the direction. A motor
    that stands is where its position says; its state may be that of an earlier movement (Aqara roller shades).
    """

    state: str
    position: str
    motor: Expose | None

    def read(self, message: JsonMessage) -> Readings:
        if self.state not in message:
            return NO_READINGS
        state = message[self.state]
        if state is None:
            return {"movement": None}
        at = _STATES.get(state) if isinstance(state, str) else None
        word = message.get(self.motor.key) if self.motor is not None else None
        direction = _DIRECTIONS.get(word.lower()) if isinstance(word, str) else None
        position = message.get(self.position)
        is_at_end = self.position != "" and position == _ENDS.get(at or "")
        if direction is not None and not is_at_end:
            return {"movement": direction}
        if at is None:
            return unreadable(state, _STATES)
        runs, percent = message.get(_RUNNING), finite_number(position)
        if direction is None and runs is True:
            return self._read_running(at, percent)
        stands = at == "stopped" or runs is False or (isinstance(word, str) and word.lower() in _STANDING)
        return {"movement": _at_rest(at, percent) if direction is None and stands else at}

    def _read_running(self, at: str, position: float | None) -> Readings:
        if position is None or at not in _ENDS or position == _ENDS[at]:
            return {"movement": at}
        if at == "closed":
            return {"movement": "closing"}
        return {"movement": "opening"} if position == _ENDS["closed"] else NO_READINGS


def _at_rest(at: str, position: float | None) -> str:
    """Return the movement of a standing cover; between its ends it is stopped or open."""
    if position is None:
        return at
    if position <= _ENDS["closed"]:
        return "closed"
    return "open" if at != "stopped" or position >= _ENDS["open"] else at


_RUNNING = "running"
_STATES: Mapping[str, str] = {"OPEN": "open", "CLOSE": "closed", "STOP": "stopped", "OFF": "stopped"}
_STANDING = frozenset({"stop", "stopped", "pause", "blocked"})
"""Words for a standing motor."""

_COMMANDS: Mapping[str, str] = {"open": "OPEN", "closed": "CLOSE", "stopped": "STOP"}
_ENDS: Mapping[str, int] = {"open": 100, "closed": 0}
_DIRECTIONS: Mapping[str, str] = {
    **dict.fromkeys(("opening", "open", "forward", "up", "rising"), "opening"),
    **dict.fromkeys(("closing", "close", "backward", "back", "reverse", "down", "declining"), "closing"),
}
"""Words for a running motor; the state has the end of a standing one."""


def _percent(value: object) -> float | None:
    number = read_finite(value)
    return None if number is None else min(100.0, max(0.0, number))


def _set(topics: Zigbee2MqttTopics, key: str, percent: float) -> Publications:
    return topics.publish({key: round(percent)})


def build_lock(part: Zigbee2MqttPart, lock: Expose) -> DescribedPart:
    """Describe a lock. A bolt that is not fully out is unlocked, to be safe."""
    state, bolt = lock.feature("state"), lock.feature("lock_state")
    part.read_from(part.topics.state, partial(_read, state, bolt))
    writer = None
    if state is not None and state.is_settable:
        writer = part.state_writer(state, "lock", {"locked": state.value_on, "unlocked": state.value_off})
    is_readable = any(expose is not None and expose.is_published for expose in (state, bolt))
    part.add_capability("lock", readable=is_readable, writer=writer, options=("locked", "unlocked"))
    part.request(state)
    return part.build()


_BOLTS: Mapping[str, str] = {"locked": "locked", "unlocked": "unlocked", "not_fully_locked": "unlocked"}


def _read(state: Expose | None, bolt: Expose | None, message: JsonMessage) -> Readings:
    if state is not None and state.key in message:
        value = message[state.key]
        if value is None:
            return {"lock": None}
        for position, expected in (("locked", state.value_on), ("unlocked", state.value_off)):
            if same_scalar(value, expected):
                return {"lock": position}
        return unreadable(value, (str(state.value_on), str(state.value_off)))
    bolt_state = message.get(bolt.key) if bolt is not None else None
    is_known = isinstance(bolt_state, str) and bolt_state in _BOLTS
    return {"lock": _BOLTS[str(bolt_state)]} if is_known else unreadable(bolt_state, _BOLTS)


def build_fan(part: Zigbee2MqttPart, fan: Expose, model: str) -> DescribedPart:
    """Describe a fan; one *model* spells its fastest speed differently."""
    state, mode, speed = (fan.feature(name) for name in ("state", "mode", "speed"))
    part.add_flag(state, "on_off")
    if mode is not None:
        part.add_enum(mode, "fan_mode")
        fastest = ("on",) if model in _MODELS_WITH_FASTEST_ON else ()
        steps = ("off", *(step for step in (*_SPEEDS, *fastest) if step in mode.options))
        _add_speed_steps(part, mode, steps)
    elif speed is not None:
        _add_speed_range(part, speed)
    part.request(state, mode, speed)
    return part.build()


_SPEEDS = ("low", "medium", "high", "1", "2", "3", "4", "5", "6", "7", "8", "9")
_MODELS_WITH_FASTEST_ON = frozenset({"99432"})


def _add_speed_steps(part: Zigbee2MqttPart, mode: Expose, speeds: Sequence[str]) -> None:
    steps = len(speeds) - 1
    if not steps:
        return

    def percent_of(value: object) -> float | None:
        return float(speeds.index(value) * 100 // steps) if isinstance(value, str) and value in speeds else None

    def publish(percent: float) -> Publications:
        return part.topics.publish({mode.key: speeds[speed_of(percent, steps)]})

    writer = percent_writer("fan_speed", publish) if mode.is_settable else None
    part.add_feature(mode, "fan_speed", percent_of, writer, grid=percent_grid(steps))


def _add_speed_range(part: Zigbee2MqttPart, speed: Expose) -> None:
    least, most = speed.least, speed.most
    if least is None or most is None or least >= most:
        return
    steps = most - least + 1

    def percent_of(value: object) -> float | None:
        number = read_finite(value)
        return None if number is None else min(100.0, max(0.0, (number - least + 1) * 100 / steps))

    def publish(percent: float) -> Publications:
        return part.topics.publish({speed.key: math.ceil(speed_of(percent, steps) + least - 1) if percent else 0})

    writer = percent_writer("fan_speed", publish) if speed.is_settable else None
    part.add_feature(speed, "fan_speed", percent_of, writer, grid=percent_grid(steps))


def build_opener(part: Zigbee2MqttPart, trigger: Expose, contact: Expose, *, is_pulse: bool) -> DescribedPart:
    """Describe a garage door by its *trigger* and its *contact*, which is on while it is closed.

    A trigger that gives a pulse moves the door with any value, so it is a push.
    """
    if is_pulse:
        writer = push_writer("push", lambda: part.topics.publish({trigger.key: trigger.value_on}))
        part.add_capability("push", readable=False, writer=writer)
        return part.build()
    targets = {"open": trigger.value_on, "closed": trigger.value_off}
    part.read_feature(contact, "movement", lambda value: _DOORS.get(value) if isinstance(value, bool) else None)
    part.add_capability("movement", writer=part.state_writer(trigger, "movement", targets), options=tuple(targets))
    return part.build()


_DOORS: Mapping[bool, str] = {True: "closed", False: "open"}


def build_valve(part: Zigbee2MqttPart, state: Expose) -> DescribedPart:
    """Describe a valve by the binary of its *state*, which is on while it is open."""
    targets = {"open": state.value_on, "closed": state.value_off}
    part.add_feature(
        state,
        "valve",
        lambda value: next((at for at in targets if same_scalar(value, targets[at])), None),
        part.state_writer(state, "valve", targets),
        options=tuple(targets),
    )
    part.request(state)
    return part.build()


def build_siren(part: Zigbee2MqttPart, warning: Expose) -> DescribedPart:
    """Describe a siren. Tone and volume also turn it on."""
    mode = warning.feature("mode")
    tones = tuple(option for option in mode.options if option != _SILENT) if mode is not None else ()
    usual = _TONE if _TONE in tones or not tones else tones[0]

    def warn(tone: str, level: str = "medium") -> Publications:
        return part.topics.publish({warning.key: {"mode": tone, "level": level, "duration": _SECONDS}})

    def switch(on: bool) -> Publications:  # noqa: FBT001 - the only argument
        return warn(usual) if on else part.topics.publish({warning.key: {"mode": _SILENT}})

    def set_volume(percent: float) -> Publications:
        return warn(usual, next(level for most, level in _LEVELS if percent <= most))

    part.add_capability("on_off", readable=False, writer=bool_writer("on_off", switch))
    if tones:
        writer = option_writer("siren_tone", tones, warn)
        part.add_capability("siren_tone", readable=False, writer=writer, options=tones)
    if warning.feature("level") is not None:
        part.add_capability("volume", readable=False, writer=percent_writer("volume", set_volume))
    return part.build()


_SILENT = "stop"
_TONE = "emergency"
_SECONDS = 10
_LEVELS = ((25.0, "low"), (50.0, "medium"), (75.0, "high"), (100.0, "very_high"))


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
