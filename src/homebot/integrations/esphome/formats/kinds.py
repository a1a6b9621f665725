"""The components of ESPHome as tables of rows: openings, sensors, switches, settings, alarms. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, date, datetime, time
from functools import partial
from typing import Final

from homebot.conventions.bounded_patterns import require_match
from homebot.conventions.command_values import require_bool, require_moment, require_option
from homebot.conventions.entity_rows import (
    EntityComponent,
    EntityRow,
    Fields,
    ReadField,
    alarm_commands,
    class_of,
    condition_component,
    has_feature,
    number_component,
    opening_type,
    options_of,
    push_row,
    quantity_of_entity,
    quantity_row,
    read_flag,
    switch_type,
    text_component,
    text_of,
    whole_of,
)
from homebot.conventions.payload import shown
from homebot.conventions.secrets import names_secret
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WrongCodeError
from homebot.integrations.esphome.formats.climate import CLIMATE, FAN, WATER_HEATER
from homebot.integrations.esphome.formats.entity import (
    choice_row,
    flag_row,
    listed,
    number_of,
    percent_row,
    read_named,
    read_text,
    supports,
    write_percent,
)
from homebot.integrations.esphome.formats.light import LIGHT

_OPERATIONS = {1: "opening", 2: "closing"}
_LOCK_STATES = dict(enumerate(("locked", "unlocked", "jammed", "locking", "unlocking", "opening", "open"), 1))
_ALARMS = ("disarmed", "armed_home", "armed_away", "armed_night", "armed_vacation", "armed_custom_bypass")
_ALARM_STATES = (*_ALARMS, "pending", "arming", "disarming", "triggered")
_ALARM_COMMANDS = (
    "disarmed",
    "armed_away",
    "armed_home",
    "armed_night",
    "armed_vacation",
    "armed_custom_bypass",
    "triggered",
)
"""States in the order of the numbers of their commands."""

_PLAYER_OFF = 5
_PLAYER_STATES = {1: "stopped", 2: "playing", 3: "paused", 4: "playing", _PLAYER_OFF: "stopped", 6: None}
_PLAYER_VOLUME, _PLAYER_MUTES, _PLAYER_SWITCHES = 4, 8, 128 | 256
_PLAYBACKS = {"playing": (16_384, 0), "paused": (1, 1), "stopped": (4096, 2)}
"""The feature and the command of each."""

_PASSWORD = 1
_MAX_DURATION_S = 2**32


def _read_movement(_info: Fields, state: Fields) -> PlainValue:
    """Read the movement; without a measured position it is 0 or 1."""
    operation, position = state.get("current_operation"), number_of(state, "position")
    if isinstance(operation, int) and operation in _OPERATIONS:
        return _OPERATIONS[operation]
    return None if position is None else "open" if position > 0 else "closed"


def _write_movement(name: str, info: Fields, value: PlainValue, _code: str) -> Fields:
    moves: dict[str, Fields] = {"open": {"position": 1.0}, "closed": {"position": 0.0}}
    if info.get("supports_stop") is True:
        moves["stopped"] = {"stop": True}
    return moves[require_option(name, value, moves)]


def _movement_rows(name: str) -> tuple[EntityRow, ...]:
    return (
        EntityRow(name, _read_movement, partial(_write_movement, name)),
        percent_row("position", "position", "supports_position"),
    )


def _with_code(command: int, code: str) -> Fields:
    return {"command": command, "code": code} if code else {"command": command}


def _write_lock(info: Fields, value: PlainValue, code: str) -> Fields:
    """Write a lock state; the device checks the code if it needs one."""
    commands = {"unlocked": 0, "locked": 1} | ({"open": 2} if info.get("supports_open") is True else {})
    command = commands[require_option("lock", value, commands)]
    if info.get("requires_code") is True and not code:
        raise WrongCodeError.missing(f"lock {value}")
    return _with_code(command, code)


def _write_alarm(info: Fields, value: PlainValue, code: str) -> Fields:
    """Write an alarm state; the device checks the code if it needs one."""
    state = require_option("alarm", value, alarm_commands(info))
    field = {"disarmed": "requires_code", "triggered": ""}.get(state, "requires_code_to_arm")
    if not code and info.get(field) is True:
        raise WrongCodeError.missing(f"alarm {state}")
    return _with_code(_ALARM_COMMANDS.index(state), code)


def _read_number(_info: Fields, state: Fields) -> PlainValue:
    return number_of(state, "state")


def _number_bounds(info: Fields) -> tuple[float, float] | tuple[()]:
    low, high = number_of(info, "min_value"), number_of(info, "max_value")
    return (low, high) if low is not None and high is not None and low < high else ()


def _is_secret(info: Fields) -> bool:
    return info.get("mode") == _PASSWORD or names_secret(text_of(info, "name"))


def _write_text(info: Fields, value: PlainValue, _code: str) -> Fields:
    """Write a text; the device does not check the pattern."""
    least, most = (int(number_of(info, name) or 0) for name in ("min_length", "max_length"))
    if not isinstance(value, str) or not least <= len(value.encode(errors="replace")) <= most:
        raise RefusedError("text", f"it takes a text of {least} to {most} characters")
    require_match(value, text_of(info, "pattern") or None)
    return {"state": value}


def _read_event(info: Fields, state: Fields) -> PlainValue:
    event = state.get("event_type")
    return event if isinstance(event, str) and event in options_of(info, "event_types") else None


def _read_player_on(_info: Fields, state: Fields) -> PlainValue:
    known = state.get("state")
    return known != _PLAYER_OFF if known in _PLAYER_STATES else None


_read_playback = read_named("state", _PLAYER_STATES)


def _playbacks(info: Fields) -> tuple[str, ...]:
    flags = whole_of(info, "feature_flags")
    return tuple(playback for playback, (feature, _) in _PLAYBACKS.items() if flags & feature)


def _write_playback(info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"command": _PLAYBACKS[require_option("playback", value, _playbacks(info))][1]}


def _player_flag(name: str, read: ReadField, on: int, off: int, feature: int) -> EntityRow:
    """Return the row of a flag of a player, with the numbers of the commands that turn it on and off."""

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        return {"command": on if require_bool(name, value) else off}

    return EntityRow(name, read, write, when=has_feature("feature_flags", feature))


def _read_update(_info: Fields, state: Fields) -> PlainValue:
    current, latest = text_of(state, "current_version"), text_of(state, "latest_version")
    return latest != current if current and latest else None


_MOMENTS: Mapping[str, tuple[Callable[..., date | time], tuple[str, ...]]] = {
    "date": (date, ("year", "month", "day")),
    "time": (time, ("hour", "minute", "second")),
    "datetime": (partial(datetime.fromtimestamp, tz=UTC), ("epoch_seconds",)),
}


def _moment(kind: str) -> EntityComponent:
    """Return the kind of a date, a time of day, or both: a text in ISO 8601."""
    make, names = _MOMENTS[kind]

    def read(_info: Fields, state: Fields) -> PlainValue:
        numbers = [number for name in names if isinstance(number := state.get(name), int)]
        try:
            return make(*numbers).isoformat() if len(numbers) == len(names) else None
        except (ValueError, OverflowError, OSError):
            return None

    def write(_info: Fields, value: PlainValue, _code: str) -> Fields:
        text = require_moment(kind, value)
        if kind != "datetime":
            moment = (date if kind == "date" else time).fromisoformat(text)
            return {name: getattr(moment, name) for name in names}
        seconds = int(datetime.fromisoformat(text).timestamp())
        if not 0 <= seconds < _MAX_DURATION_S:
            raise RefusedError(f"text {shown(value)}", "it takes a datetime from 1970 to 2106")
        return {"epoch_seconds": seconds}

    return EntityComponent("x_setting", (EntityRow("text", read, write),), kind)


KINDS: Final[Mapping[str, EntityComponent]] = {
    "climate": CLIMATE,
    "water_heater": WATER_HEATER,
    "light": LIGHT,
    "cover": EntityComponent(
        opening_type,
        (*_movement_rows("movement"), percent_row("tilt", "tilt", "supports_tilt")),
    ),
    "lock": EntityComponent("door_lock", (EntityRow("lock", read_named("state", _LOCK_STATES), _write_lock),)),
    "valve": EntityComponent("water_valve", _movement_rows("valve")),
    "fan": FAN,
    "switch": EntityComponent(switch_type, (flag_row("on_off", "state"),)),
    "siren": EntityComponent(  # it only reports whether it is on; tone and volume also turn it on
        "siren",
        (
            flag_row("on_off", "state"),
            replace(choice_row("siren_tone", "tone", listed("tones"), state=True), read=None),
            EntityRow("volume", None, write_percent("volume", "volume", state=True), supports("supports_volume")),
        ),
    ),
    "alarm_control_panel": EntityComponent(
        "x_alarm_panel",
        (EntityRow("alarm", read_named("state", dict(enumerate(_ALARM_STATES))), _write_alarm, options=_ALARM_STATES),),
    ),
    "media_player": EntityComponent(
        "speaker",
        (
            _player_flag("on_off", _read_player_on, 12, 13, _PLAYER_SWITCHES),
            replace(percent_row("volume", "volume"), when=has_feature("feature_flags", _PLAYER_VOLUME)),
            _player_flag("muted", read_flag("muted"), 3, 4, _PLAYER_MUTES),
            EntityRow("playback", _read_playback, when=lambda info: not _playbacks(info)),
            EntityRow("playback", _read_playback, _write_playback, when=_playbacks, options=_playbacks),
        ),
    ),
    "event": EntityComponent(
        "generic_switch", (EntityRow("press", _read_event, options=lambda info: options_of(info, "event_types")),)
    ),
    "binary_sensor": condition_component(read_flag("state")),
    "sensor": EntityComponent(lambda info: quantity_of_entity(info).service_type, (quantity_row(_read_number),)),
    "text_sensor": EntityComponent("x_sensor", (EntityRow("value", read_text("state")),)),
    "number": number_component(_read_number, _number_bounds, lambda number: {"state": number}),
    "select": EntityComponent("x_setting", (choice_row("option", "state", listed("options")),)),
    "text": text_component(read_text("state"), _write_text, _is_secret),
    "button": EntityComponent(
        "x_setting", (push_row("push", {}), push_row("locate", {}, lambda info: class_of(info) == "identify"))
    ),
    "date": _moment("date"),
    "time": _moment("time"),
    "datetime": _moment("datetime"),
    "update": EntityComponent(  # homebot never installs an update
        "x_update",
        (
            EntityRow("version", read_text("current_version")),
            EntityRow("latest_version", read_text("latest_version")),
            EntityRow("update_available", _read_update),
        ),
    ),
}
"""By component, in the order of parts: the first part that is no setting decides the type of the device."""
