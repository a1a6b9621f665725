"""The components of ESPHome as tables of rows: openings, lights, sensors, switches, settings, alarms. Pure.

A colour mode of a light is a set of abilities as bits; a state says which one is active, and only its fields count.

Source: ESPHome 2026.10, ``components/api/api.proto``, ``components/light/color_mode.h`` and ``light_call.cpp``.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from datetime import UTC, date, datetime, time
from functools import partial
from typing import Final

from homebot.conventions.bounded_patterns import require_match
from homebot.conventions.command_values import (
    require_bool,
    require_color,
    require_moment,
    require_number,
    require_option,
)
from homebot.conventions.entity_rows import (
    EntityComponent,
    EntityRow,
    Fields,
    ReadField,
    alarm_commands,
    class_of,
    code_of,
    condition_component,
    has_feature,
    number_component,
    opening_type,
    options_of,
    progress_rows,
    push_row,
    quantity_of_entity,
    quantity_row,
    read_flag,
    switch_type,
    text_component,
    text_of,
    whole_of,
)
from homebot.conventions.light_color import MIRED, KelvinRange, from_hue_saturation, to_hue_saturation
from homebot.conventions.payload import shown
from homebot.conventions.secrets import names_secret
from homebot.devices.part import CodeKind
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WrongCodeError
from homebot.integrations.esphome.formats.climate import CLIMATE, FAN, WATER_HEATER
from homebot.integrations.esphome.formats.entity import (
    choice_row,
    flag_row,
    listed,
    number_of,
    numbers_of,
    percent_row,
    read_named,
    read_percent,
    read_text,
    supports,
    write_percent,
)

_BRIGHTNESS, _COLOR_TEMPERATURE, _COLD_WARM, _RGB = 2, 8, 16, 32
_CHANNELS: Mapping[int, tuple[str, tuple[str, ...]]] = {
    35: ("rgb", ()),
    39: ("rgbw", ("white",)),
    51: ("rgbww", ("cold_white", "warm_white")),
    47: ("rgb", ()),
}
"""Colour modes with colours, best first: in which channels of :data:`CHANNELS` they count, and the fields of white."""

_WHITES = (11, 19, 47, 51)
"""Colour modes with whites from warm to cold, best first."""

_NO_EFFECT = "None"
_MAX_MIRED = 1000.0
_USUAL_KELVINS = (2_000, 6_535)


def _write_level(_info: Fields, value: PlainValue, _code: str) -> Fields:
    level = require_number("level", value, 0, 100, "%")
    return {"state": True, "brightness": level / 100} if level else {"state": False}


def _first_mode(modes: Iterable[int], info: Fields) -> int:
    """Return the best of *modes* that the light has; 0 for none."""
    known = numbers_of(info, "supported_color_modes")
    return next((mode for mode in modes if mode in known), 0)


def _mired_range(info: Fields) -> tuple[float, float]:
    """Return coldest and warmest white in mired; zeros if it has no valid range."""
    coldest, warmest = (number_of(info, name) or 0.0 for name in ("min_mireds", "max_mireds"))
    return (coldest, warmest) if 1 <= coldest <= warmest <= _MAX_MIRED else (0.0, 0.0)


def _kelvin_bounds(info: Fields) -> tuple[float, ...]:
    coldest, warmest = _mired_range(info)
    return (float(round(MIRED / warmest)), float(round(MIRED / coldest))) if coldest else ()


def _kelvins(info: Fields) -> KelvinRange:
    bounds = _kelvin_bounds(info)
    return (int(bounds[0]), int(bounds[1])) if bounds else _USUAL_KELVINS


def _read_white(info: Fields, state: Fields) -> PlainValue:
    mode = state.get("color_mode")
    if not isinstance(mode, int) or mode not in _WHITES or (mode & _RGB and not _is_white(mode, state)):
        return None
    mired = number_of(state, "color_temperature")
    if mode & _COLD_WARM:
        cold, warm = number_of(state, "cold_white") or 0.0, number_of(state, "warm_white") or 0.0
        if min(cold, warm) < 0 or not cold + warm:
            mired = None
        else:
            coldest, warmest = _mired_range(info)
            middle = (coldest + warmest) / 2
            # the reported value is the last command; the channels, which are not linear (gamma), may contradict it
            if mired is None or not coldest <= mired <= warmest or (mired - middle) * (warm - cold) < 0:
                mired = coldest + (warmest - coldest) * warm / (cold + warm)
    return None if not mired or not 1 <= mired <= _MAX_MIRED else float(round(MIRED / mired))


def _write_white(info: Fields, value: PlainValue, _code: str) -> Fields:
    mode, (coldest, warmest) = _first_mode(_WHITES, info), _mired_range(info)
    low, high = _kelvins(info)
    kelvin = require_number("color_temperature", value, low, high, "K")
    state = {"state": True, "color_mode": mode, "color_temperature": min(max(MIRED / kelvin, coldest), warmest)}
    if mode & _RGB:
        state["color_brightness"] = 0.0
        return {**state, "white": 1.0} if mode & _COLOR_TEMPERATURE else state
    return state


def _is_white(mode: int, state: Fields) -> bool:
    """Return whether a lamp in a mode with colours and white shines white only."""
    return mode in (47, 51) and number_of(state, "color_brightness") == 0


def _read_color(info: Fields, state: Fields) -> PlainValue:
    mode = state.get("color_mode")
    if not isinstance(mode, int) or mode not in _CHANNELS or _is_white(mode, state):
        return None
    letters, whites = _CHANNELS[mode]
    values = [number_of(state, name) for name in ("color_brightness", "red", "green", "blue", *whites)]
    shares = [value for value in values if value is not None and 0 <= value <= 1]
    if len(shares) < len(values):
        return None
    strength, *channels = shares
    rgb = [channel * (strength if whites else 1.0) for channel in channels[:3]]
    return to_hue_saturation(letters, tuple(round(255 * channel) for channel in (*rgb, *channels[3:])), _kelvins(info))


def _write_color(info: Fields, value: PlainValue, _code: str) -> Fields:
    mode = _first_mode(_CHANNELS, info)
    letters, whites = _CHANNELS[mode]
    hue, saturation = require_color(value)
    channels = [channel / 255 for channel in from_hue_saturation(letters, hue, saturation, _kelvins(info))]
    strength = max(channels[:3])
    rgb = tuple(channel / strength for channel in channels[:3]) if strength else (1.0, 1.0, 1.0)
    state = {"state": True, "color_mode": mode, "rgb": rgb, "color_brightness": strength}
    if mode & _COLOR_TEMPERATURE:
        state["white"] = 0.0
    return {**state, **dict(zip(whites, channels[3:], strict=True))}


def _effects(info: Fields) -> Mapping[str, object]:
    listed = options_of(info, "effects")
    names = listed if _NO_EFFECT in listed or not listed else (_NO_EFFECT, *listed)
    return {name: name for name in names}


LIGHT: Final = EntityComponent(
    "light",
    (
        flag_row("on_off", "state"),
        EntityRow(
            "level",
            read_percent("brightness"),
            _write_level,
            when=lambda info: any(mode & _BRIGHTNESS for mode in numbers_of(info, "supported_color_modes")),
        ),
        EntityRow(
            "color_temperature",
            _read_white,
            _write_white,
            when=lambda info: _first_mode(_WHITES, info) and _kelvin_bounds(info),
            bounds=_kelvin_bounds,
        ),
        EntityRow("color", _read_color, _write_color, when=lambda info: _first_mode(_CHANNELS, info)),
        choice_row("effect", "effect", _effects, state=True),
    ),
)


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


def _lock_code(info: Fields) -> CodeKind:
    return (code_of(info.get("code_format")) or "text") if info.get("requires_code") is True else ""


def _alarm_code(info: Fields) -> CodeKind:
    return "digits" if info.get("requires_code") is True else ""


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
    "lock": EntityComponent(
        "door_lock", (EntityRow("lock", read_named("state", _LOCK_STATES), _write_lock, code=_lock_code),)
    ),
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
        (
            EntityRow(
                "alarm",
                read_named("state", dict(enumerate(_ALARM_STATES))),
                _write_alarm,
                options=_ALARM_STATES,
                code=_alarm_code,
            ),
        ),
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
            *progress_rows("in_progress", "progress"),
        ),
    ),
}
"""By component, in the order of parts: the first part that is no setting decides the type of the device."""
