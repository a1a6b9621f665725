"""Sensors, switches, settings, alarms and the other simple entities of ESPHome. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, date, datetime, time

from homebot.conventions.command_values import require_bool, require_number, require_option
from homebot.conventions.device_classes import condition_of, quantity_of
from homebot.conventions.esphome.entity import (
    EsphomeEntity,
    Fields,
    FieldWriter,
    flag_reader,
    number_of,
    options_of,
    percent_reader,
    percent_writer,
    table_reader,
    text_of,
    whole_of,
)
from homebot.conventions.payload import clean_text, shown
from homebot.conventions.secrets import names_secret
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WrongCodeError

__all__ = ["SIMPLE_BUILDERS"]

_LONGEST = 255
_ALARMS = ("disarmed", "armed_home", "armed_away", "armed_night", "armed_vacation", "armed_custom_bypass")
_ALARM_STATES = (*_ALARMS, "pending", "arming", "disarming", "triggered")
_ALARM_COMMANDS: Mapping[str, tuple[int, int]] = {
    "disarmed": (0, 0),
    "armed_away": (1, 2),
    "armed_home": (2, 1),
    "armed_night": (3, 4),
    "armed_vacation": (4, 32),
    "armed_custom_bypass": (5, 16),
    "triggered": (6, 8),
}
"""State to the number of its command, and to the bit of the feature that it needs."""

_PLAYER_STATES: Mapping[object, str] = {
    1: "idle",
    2: "playing",
    3: "paused",
    4: "announcing",
    5: "off",
    6: "on",
}
_VOLUME, _SWITCHED = 4, 128 | 256
_PASSWORD = 1


def _sensor(kind: str, info: Fields) -> EsphomeEntity:
    quantity = quantity_of(text_of(info, "device_class"), text_of(info, "unit_of_measurement"))

    def read(state: Fields) -> PlainValue:
        number = number_of(state, "state")
        return None if number is None else quantity.value(number)

    entity = EsphomeEntity(kind, info, quantity.service_type)
    entity.add(quantity.capability, read, unit=quantity.unit)
    return entity


def _binary_sensor(kind: str, info: Fields) -> EsphomeEntity:
    service_type, capability = condition_of(text_of(info, "device_class"))
    entity = EsphomeEntity(kind, info, service_type)
    entity.add(capability, flag_reader("state"))
    return entity


def _switch(kind: str, info: Fields) -> EsphomeEntity:
    entity = EsphomeEntity(kind, info, "plug" if text_of(info, "device_class") == "outlet" else "switch")
    entity.add_flag("on_off", "state")
    return entity


def _text_sensor(kind: str, info: Fields) -> EsphomeEntity:
    entity = EsphomeEntity(kind, info, "x_sensor")
    entity.add("value", _text("state"))
    return entity


def _number(kind: str, info: Fields) -> EsphomeEntity:
    low, high = number_of(info, "min_value"), number_of(info, "max_value")
    bounds = (low, high) if low is not None and high is not None and low < high else ()

    def write(value: PlainValue, _code: str) -> Fields:
        return {"state": require_number("number", value, *(bounds or (-1e30, 1e30)))}

    entity = EsphomeEntity(kind, info, "x_setting")
    unit = text_of(info, "unit_of_measurement")
    entity.add("number", lambda state: number_of(state, "state"), write, unit=unit, bounds=bounds)
    return entity


def _select(kind: str, info: Fields) -> EsphomeEntity:
    entity = EsphomeEntity(kind, info, "x_setting")
    entity.add_choice("option", "state", {one: one for one in options_of(info, "options")})
    return entity


def _setting_text(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a text; a password can be set but is never read. The device checks the pattern."""
    least, most = (int(number_of(info, name) or 0) for name in ("min_length", "max_length"))

    def write(value: PlainValue, _code: str) -> Fields:
        if not isinstance(value, str) or not least <= len(value.encode(errors="replace")) <= most:
            raise RefusedError("text", f"it takes a text of {least} to {most} characters")
        return {"state": value}

    entity = EsphomeEntity(kind, info, "x_setting")
    is_secret = info.get("mode") == _PASSWORD or names_secret(text_of(info, "name"))
    entity.add("text", None if is_secret else _text("state"), write)
    return entity


def _button(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a button; one of the class ``identify`` also has ``locate``."""
    entity = EsphomeEntity(kind, info, "x_setting")
    names = ("push", "locate") if text_of(info, "device_class") == "identify" else ("push",)
    for name in names:
        entity.add(name, None, _pusher(name))
    return entity


def _pusher(name: str) -> FieldWriter:
    def write(value: PlainValue, _code: str) -> Fields:
        if value is not True:
            raise RefusedError(f"{name} {shown(value)}", "it takes only true")
        return {}

    return write


def _event(kind: str, info: Fields) -> EsphomeEntity:
    types = options_of(info, "event_types")
    entity = EsphomeEntity(kind, info, "generic_switch")
    entity.add("press", table_reader("event_type", {one: one for one in types}), options=types)
    return entity


def _siren(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a siren; it reports only whether it is on. Tone and volume also turn it on."""
    entity = EsphomeEntity(kind, info, "siren")
    entity.add_flag("on_off", "state")
    if tones := options_of(info, "tones"):
        entity.add(
            "siren_tone",
            None,
            lambda value, _code: {"state": True, "tone": require_option("siren_tone", value, tones)},
            options=tones,
        )
    if info.get("supports_volume") is True:
        volume = percent_writer("volume", "volume")
        entity.add("volume", None, lambda value, code: {"state": True, **volume(value, code)})
    return entity


def _alarm(kind: str, info: Fields) -> EsphomeEntity:
    """Describe an alarm; the device checks the code if it needs one."""
    has = whole_of(info, "supported_features")
    commands = {name: number for name, (number, bit) in _ALARM_COMMANDS.items() if not bit or has & bit}
    to_disarm = info.get("requires_code") is True
    to_arm = info.get("requires_code_to_arm") is True

    def write(value: PlainValue, code: str) -> Fields:
        state = require_option("alarm", value, commands)
        if not code and (to_disarm if state == "disarmed" else to_arm and state != "triggered"):
            raise WrongCodeError(f"alarm {state}", "it needs a code")
        return {"command": commands[state], "code": code} if code else {"command": commands[state]}

    entity = EsphomeEntity(kind, info, "x_alarm_panel")
    entity.add("alarm", table_reader("state", dict(enumerate(_ALARM_STATES))), write, options=_ALARM_STATES)
    return entity


def _media_player(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a player, with its capabilities in the vocabulary: state, volume, on and off."""
    has = whole_of(info, "feature_flags")
    entity = EsphomeEntity(kind, info, "speaker")
    if has & _SWITCHED == _SWITCHED:

        def read(state: Fields) -> PlainValue:
            known = state.get("state")
            return _PLAYER_STATES[known] != "off" if isinstance(known, int) and known in _PLAYER_STATES else None

        commands = {True: {"command": 12}, False: {"command": 13}}
        entity.add("on_off", read, lambda value, _code: commands[require_bool("on_off", value)])
    if has & _VOLUME:
        entity.add("volume", percent_reader("volume"), percent_writer("volume", "volume"))
    entity.add("value", table_reader("state", _PLAYER_STATES))
    return entity


def _update(kind: str, info: Fields) -> EsphomeEntity:
    """Describe the firmware of a device; homebot never installs an update."""

    def is_newer(state: Fields) -> PlainValue:
        current, latest = text_of(state, "current_version"), text_of(state, "latest_version")
        return latest != current if current and latest else None

    entity = EsphomeEntity(kind, info, "x_update")
    entity.add("version", _text("current_version"))
    entity.add("latest_version", _text("latest_version"))
    entity.add("update_available", is_newer)
    return entity


def _text(field: str) -> Callable[[Fields], PlainValue]:
    def read(state: Fields) -> PlainValue:
        value = state.get(field)
        return clean_text(value, _LONGEST) if isinstance(value, str) else None

    return read


def _whole(state: Fields, names: tuple[str, ...]) -> tuple[int, ...]:
    """Return whole numbers; raises ValueError if one is not a number."""
    return tuple(int(_checked(number_of(state, name))) for name in names)


def _checked(number: float | None) -> float:
    if number is None:
        raise ValueError("not a number")
    return number


_DATE, _TIME = ("year", "month", "day"), ("hour", "minute", "second")


def _moment_text(kind: str, state: Fields) -> str:
    if kind == "date":
        year, month, day = _whole(state, _DATE)
        return date(year, month, day).isoformat()
    if kind == "time":
        hour, minute, second = _whole(state, _TIME)
        return time(hour, minute, second).isoformat()
    seconds = state.get("epoch_seconds")
    return datetime.fromtimestamp(seconds if isinstance(seconds, int) else -1e20, UTC).isoformat()


def _moment_fields(kind: str, text: str) -> Fields:
    if kind == "date":
        day = date.fromisoformat(text)
        return {name: getattr(day, name) for name in _DATE}
    if kind == "time":
        moment = time.fromisoformat(text)
        return {name: getattr(moment, name) for name in _TIME}
    instant = datetime.fromisoformat(text)
    if instant.tzinfo is None or not 0 <= instant.timestamp() < _MOST_SECONDS:
        raise ValueError("without time zone, or out of range")
    return {"epoch_seconds": int(instant.timestamp())}


_MOST_SECONDS = 2**32


def _moment(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a date, a time of day, or both: a text in ISO 8601."""

    def read(state: Fields) -> PlainValue:
        try:
            return _moment_text(kind, state)
        except (ValueError, OverflowError, OSError):
            return None

    def write(value: PlainValue, _code: str) -> Fields:
        try:
            return _moment_fields(kind, value if isinstance(value, str) else "")
        except (ValueError, OverflowError):
            zone = " with a time zone" if kind == "datetime" else ""
            raise RefusedError(f"text {shown(value)}", f"it takes a {kind} in ISO 8601 format{zone}") from None

    entity = EsphomeEntity(kind, info, "x_setting", kind)
    entity.add("text", read, write)
    return entity


SIMPLE_BUILDERS: Mapping[str, Callable[[str, Fields], EsphomeEntity]] = {
    "switch": _switch,
    "siren": _siren,
    "alarm_control_panel": _alarm,
    "media_player": _media_player,
    "event": _event,
    "binary_sensor": _binary_sensor,
    "sensor": _sensor,
    "text_sensor": _text_sensor,
    "number": _number,
    "select": _select,
    "text": _setting_text,
    "button": _button,
    "date": _moment,
    "time": _moment,
    "datetime": _moment,
    "update": _update,
}
"""By component."""
