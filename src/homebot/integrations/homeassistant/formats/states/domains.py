"""The domains of Home Assistant as tables of rows. Pure.

Source: Home Assistant core 2024.3, ``components``: ``const.py``, ``__init__.py`` and ``services.yaml`` of each domain.
"""

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import Final

from homebot.conventions.bounded_patterns import require_match
from homebot.conventions.command_values import moment_text, require_moment, require_number, require_option
from homebot.conventions.device_classes import is_quantity
from homebot.conventions.entity_rows import (
    ALARM_ACTIONS,
    ALARM_STATES,
    EntityComponent,
    EntityRow,
    Fields,
    WriteField,
    alarm_commands,
    class_of,
    code_of,
    condition_component,
    number_component,
    opening_type,
    options_of,
    progress_rows,
    push_row,
    quantity_of_entity,
    quantity_row,
    switch_type,
    text_component,
)
from homebot.conventions.lamp import LightFeatures, WhiteRange
from homebot.conventions.payload import shown
from homebot.conventions.units import to_celsius
from homebot.devices.part import CodeKind
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WrongCodeError
from homebot.integrations.homeassistant.formats.components import (
    LOCK_STATES,
    MOWER_ACTIONS,
    MOWER_STATES,
    VACUUM_ACTIONS,
    VACUUM_STATES,
)
from homebot.integrations.homeassistant.formats.states.climate import CLIMATE, FAN, HUMIDIFIER, WATER_HEATER
from homebot.integrations.homeassistant.formats.states.rows import (
    SWITCH,
    bounds_of,
    choice,
    flag,
    has,
    moves,
    percent,
    read_named,
    read_number,
    read_state,
    read_text,
    read_while_on,
    reported,
    sensed,
    switch,
)
from homebot.support.numbers import to_number

_COLORS = frozenset({"hs", "xy", "rgb", "rgbw", "rgbww"})
_USUAL_KELVINS = (2_000, 6_535)


def _lamp(info: Fields) -> LightFeatures:
    """Return the features of a lamp; Home Assistant converts hue and saturation to the channels that it has."""
    modes = frozenset(options_of(info, "supported_color_modes"))
    kelvins = bounds_of(info, "min_color_temp_kelvin", "max_color_temp_kelvin")
    known = (int(kelvins[0]), int(kelvins[1])) if kelvins else _USUAL_KELVINS
    effects = options_of(info, "effect_list") if has(4)(info) else ()
    color = {"hs"} if modes & _COLORS else set()
    return LightFeatures((modes - _COLORS) | color or frozenset({"onoff"}), WhiteRange(known, kelvins), effects)


def _write_lamp(name: str) -> Callable[[Fields, PlainValue, str], Fields]:
    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        command = _lamp(info).command(name, value)
        if not command.on:
            return {"service": "turn_off"}
        fields = {
            "brightness": command.brightness,
            "color_temp_kelvin": command.kelvin,
            "hs_color": command.color,
            "effect": command.effect,
        }
        return {"service": "turn_on", **{key: value for key, value in fields.items() if value not in (None, (), "")}}

    return write


def _lamp_row(name: str, read: Callable[[Fields, Fields], PlainValue]) -> EntityRow:
    return EntityRow(
        name,
        read,
        _write_lamp(name),
        when=lambda info: name in _lamp(info).abilities(),
        options=lambda info: _lamp(info).abilities()[name].get("options", ()),
        bounds=lambda info: _lamp(info).abilities()[name].get("bounds", ()),
    )


def _read_color(_info: Fields, state: Fields) -> PlainValue:
    color = state.get("hs_color")
    if state.get("color_mode") not in _COLORS or not isinstance(color, list) or len(color) != 2:
        return None
    hue, saturation = map(to_number, color)
    return None if hue is None or saturation is None else (hue, saturation)


def _read_white(info: Fields, state: Fields) -> PlainValue:
    if state.get("color_mode") != "color_temp":
        return None
    return read_number("color_temp_kelvin", 1.0, 1.0)(info, state)


_LIGHT: Final = EntityComponent(
    "light",
    (
        EntityRow("on_off", SWITCH.read, _write_lamp("on_off")),
        _lamp_row("level", read_while_on("brightness", 100 / 255)),
        _lamp_row("color_temperature", _read_white),
        _lamp_row("color", _read_color),
        _lamp_row("effect", read_text("effect")),
    ),
)

_OPENINGS = ("open", "closed", "opening", "closing")


def _opening(name: str, domain: str) -> tuple[EntityRow, ...]:
    services = {"open": (1, f"open_{domain}"), "closed": (2, f"close_{domain}"), "stopped": (8, f"stop_{domain}")}
    position = percent("position", "current_position", f"set_{domain}_position", "position", has(4))
    return (*moves(name, services, read_named(*_OPENINGS)), *reported(position, "current_position"))


def _write_end_of_tilt(_info: Fields, value: PlainValue, _code: str) -> Fields:
    """Turn slats that have no position to one of their ends."""
    percent_open = require_number("tilt", value, 0, 100, "%")
    if percent_open not in {0, 100}:
        raise RefusedError(f"tilt {percent_open:g}", "its slats only open (100) and close (0)")
    return {"service": "open_cover_tilt" if percent_open else "close_cover_tilt"}


def _write_lock(info: Fields, value: PlainValue, code: str) -> Fields:
    services = {"locked": "lock", "unlocked": "unlock"} | ({"open": "open"} if has(1)(info) else {})
    service = services[require_option("lock", value, services)]
    if info.get("code_format") and not code:
        raise WrongCodeError.missing(f"lock {shown(value)}")
    return {"service": service, **({"code": code} if code else {})}


def _code_of(info: Fields) -> CodeKind:
    return code_of(info.get("code_format"))


def _write_alarm(info: Fields, value: PlainValue, code: str) -> Fields:
    state = require_option("alarm", value, alarm_commands(info))
    is_coded = state == "disarmed" or (state != "triggered" and info.get("code_arm_required") is not False)
    if info.get("code_format") and is_coded and not code:
        raise WrongCodeError.missing(f"alarm {state}")
    return {"service": f"alarm_{ALARM_ACTIONS[state][1]}", **({"code": code} if code else {})}


def _write_tone(info: Fields, value: PlainValue, _code: str) -> Fields:
    return {"service": "turn_on", "tone": require_option("siren_tone", value, _tones(info))}


def _tones(info: Fields) -> tuple[str, ...]:
    tones = info.get("available_tones")
    listed = list(tones.values()) if isinstance(tones, dict) else tones
    return options_of({"tones": listed}, "tones") if has(4)(info) else ()


_PLAYER_ON = {
    **dict.fromkeys(("off", "standby"), False),
    **dict.fromkeys(("on", "idle", "playing", "paused", "buffering"), True),
}

_PLAYBACK = {
    **dict.fromkeys(("off", "standby", "idle"), "stopped"),
    **{state: state for state in ("playing", "paused", "buffering")},
}
_PLAYER_MOVES = {"playing": (16_384, "media_play"), "paused": (1, "media_pause"), "stopped": (4096, "media_stop")}


def _write_media(_info: Fields, value: PlainValue, _code: str) -> Fields:
    """Play ``[announce] [TYPE] ADDRESS``; without a type it is music."""
    if not isinstance(value, str) or not (words := value.split()):
        raise RefusedError("media", "it takes the address of a stream, such as of a radio")
    is_announced = words[0] == "announce" and len(words) > 1
    kind, _, address = value.strip().removeprefix("announce" if is_announced else "").strip().partition(" ")
    media = {"media_content_id": address or kind, "media_content_type": kind if address else "music"}
    return {"service": "play_media", **media, **({"announce": True} if is_announced else {})}


def _has_sources(info: Fields) -> bool:
    """Return whether a player takes a source: only then Home Assistant lists them."""
    return bool(has(2048)(info) or info.get("source_list"))


_MEDIA_PLAYER: Final = EntityComponent(
    lambda info: "video_player" if class_of(info) in {"tv", "projector"} else "speaker",
    (
        switch(128, 256, read_state(_PLAYER_ON)),
        *reported(percent("volume", "volume_level", "volume_set", "volume_level", has(4), 100.0), "volume_level"),
        flag("muted", "is_volume_muted", "volume_mute", has(8)),
        choice("option", "source", "source_list", "select_source", when=_has_sources),
        *moves("playback", _PLAYER_MOVES, read_state(_PLAYBACK)),
        EntityRow("media_title", read_text("media_title")),
        EntityRow("media_artist", read_text("media_artist")),
        EntityRow("media", None, _write_media, has(512)),
    ),
)


def _is_number(info: Fields) -> bool:
    device_class = class_of(info)
    has_unit = any(info.get(field) is not None for field in ("unit_of_measurement", "state_class"))
    return device_class not in {"date", "enum", "timestamp"} and (is_quantity(device_class) or has_unit)


_TRACKER: Final = EntityComponent("x_tracker", (EntityRow("place", read_text("state")),))
_NUMBER: Final = number_component(
    read_number("state"),
    lambda info: bounds_of(info, "min", "max"),
    lambda number: {"service": "set_value", "value": number},
    "min",
)
_SELECT: Final = EntityComponent("x_setting", (choice("option", "state", "options", "select_option", "option"),))


def _text_writer(service: str, field: str, longest: int) -> WriteField:
    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        least, most = (int(bound) for bound in bounds_of(info, "min", "max") or (0, longest))
        if not isinstance(value, str) or not least <= len(value) <= most:
            raise RefusedError("text", f"it takes a text of {least} to {most} characters")
        require_match(value, info.get("pattern"))
        return {"service": service, field: value}

    return write


_TEXT: Final = text_component(
    read_text("state"), _text_writer("set_value", "value", 255), lambda info: info.get("mode") == "password"
)
_PRESS: Final = {"service": "press"}
_BUTTON: Final = EntityComponent(
    "x_setting", (push_row("push", _PRESS), push_row("locate", _PRESS, lambda info: class_of(info) == "identify"))
)


def _moment(kind: str = "") -> EntityComponent:
    """Return the domain of a date, a time of day, or both, in ISO 8601; without a *kind* that of a local helper."""

    def kind_of(info: Fields) -> str:
        if kind:
            return kind
        return "time" if not info.get("has_date") else "datetime" if info.get("has_time") else "date"

    def read(info: Fields, state: Fields) -> PlainValue:
        return moment_text(kind_of(info), read_text("state")(info, state))

    def write(info: Fields, value: PlainValue, _code: str) -> Fields:
        moment = require_moment(kind_of(info), value, zoned=bool(kind))
        return {"service": "set_value" if kind else "set_datetime", kind_of(info): moment}

    return EntityComponent("x_setting", (EntityRow("text", read, write),), kind)


def _read_value(info: Fields, state: Fields) -> PlainValue:
    """Read the text of a sensor; a timestamp is that of UTC."""
    text = state.get("state")
    if class_of(info) != "timestamp" or not isinstance(text, str):
        return read_text("state")(info, state)
    try:
        return datetime.fromisoformat(text[:40]).astimezone(UTC).isoformat(timespec="seconds")
    except (ValueError, OverflowError):
        return None


_WEATHER: Final = (
    *("clear-night", "cloudy", "exceptional", "fog", "hail", "lightning", "lightning-rainy", "partlycloudy"),
    *("pouring", "rainy", "snowy", "snowy-rainy", "sunny", "windy", "windy-variant"),
)


def _read_outdoors(info: Fields, state: Fields) -> PlainValue:
    """Read the temperature of the weather, which has a unit of its own."""
    number = read_number("temperature")(info, state)
    return to_celsius(number, 3) if isinstance(number, float) and state.get("temperature_unit") == "°F" else number


DOMAINS: Final[Mapping[str, EntityComponent]] = {
    "climate": CLIMATE,
    "water_heater": WATER_HEATER,
    "light": _LIGHT,
    "cover": EntityComponent(
        opening_type,
        (
            *_opening("movement", "cover"),
            percent("tilt", "current_tilt_position", "set_cover_tilt_position", "tilt_position", has(128)),
            EntityRow(
                "tilt",
                read_number("current_tilt_position", 1.0, 0, 100),
                _write_end_of_tilt,
                when=lambda info: has(16, 32)(info) and not has(128)(info),
            ),
        ),
    ),
    "lock": EntityComponent("door_lock", (EntityRow("lock", read_named(*LOCK_STATES), _write_lock, code=_code_of),)),
    "valve": EntityComponent("water_valve", _opening("valve", "valve")),
    "fan": FAN,
    "humidifier": HUMIDIFIER,
    "vacuum": EntityComponent(
        "robotic_vacuum_cleaner",
        (
            *moves("vacuum", VACUUM_ACTIONS, read_named(*VACUUM_STATES)),
            choice("fan_mode", "fan_speed", "fan_speed_list", "set_fan_speed", when=has(32)),
            percent("battery", "battery_level", when=has(64)),
            push_row("locate", {"service": "locate"}, has(512)),
        ),
    ),
    "lawn_mower": EntityComponent("x_lawn_mower", moves("mower", MOWER_ACTIONS, read_named(*MOWER_STATES))),
    "alarm_control_panel": EntityComponent(
        "x_alarm_panel",
        (EntityRow("alarm", read_named(*ALARM_STATES), _write_alarm, options=ALARM_STATES, code=_code_of),),
    ),
    "siren": EntityComponent(
        "siren",
        (
            switch(1, 2),
            EntityRow("siren_tone", None, _write_tone, when=_tones, options=_tones),
            EntityRow("volume", None, percent("volume", "", "turn_on", "volume_level", None, 100.0).write, has(8)),
        ),
    ),
    "switch": EntityComponent(switch_type, (SWITCH,)),
    "media_player": _MEDIA_PLAYER,
    "camera": EntityComponent("camera", (EntityRow("value", read_text("state")),)),
    "event": EntityComponent(
        "generic_switch",
        (EntityRow("press", read_text("event_type"), options=lambda info: options_of(info, "event_types")),),
    ),
    "binary_sensor": condition_component(read_state({"on": True, "off": False})),
    "sensor": EntityComponent(
        lambda info: quantity_of_entity(info).service_type if _is_number(info) else "x_sensor",
        (
            quantity_row(lambda _info, state: to_number(state.get("state")), _is_number),
            EntityRow("value", _read_value, when=lambda info: not _is_number(info)),
        ),
    ),
    "weather": EntityComponent(
        "x_sensor",
        (
            EntityRow("value", read_named(*_WEATHER), options=_WEATHER),
            sensed("temperature", "temperature", _read_outdoors),
            sensed("humidity", "humidity", read_number("humidity", 1.0, 0, 100)),
        ),
    ),
    "device_tracker": _TRACKER,
    "person": _TRACKER,
    "scene": EntityComponent("x_scene", (push_row("scene", {"service": "turn_on"}),)),
    "number": _NUMBER,
    "input_number": _NUMBER,
    "select": _SELECT,
    "input_select": _SELECT,
    "text": _TEXT,
    "input_text": _TEXT,
    "notify": EntityComponent("x_setting", (EntityRow("text", None, _text_writer("send_message", "message", 4096)),)),
    "schedule": EntityComponent("x_binary_sensor", (EntityRow("state", read_state({"on": True, "off": False})),)),
    "button": _BUTTON,
    "input_button": _BUTTON,
    "input_boolean": EntityComponent("x_setting", (SWITCH,)),
    "date": _moment("date"),
    "time": _moment("time"),
    "datetime": _moment("datetime"),
    "input_datetime": _moment(),
    "counter": number_component(
        read_number("state"),
        lambda info: bounds_of(info, "minimum", "maximum"),
        lambda number: {"service": "set_value", "value": round(number)},
        "minimum",
    ),
    "image": EntityComponent("camera", (EntityRow("value", read_text("state")),)),
    "timer": EntityComponent("x_setting", (EntityRow("value", read_text("state")),)),
    "update": EntityComponent(  # homebot never installs an update
        "x_update",
        (
            EntityRow("version", read_text("installed_version")),
            EntityRow("latest_version", read_text("latest_version")),
            EntityRow("update_available", read_state({"on": True, "off": False})),
            *progress_rows("in_progress", "update_percentage"),
        ),
    ),
}
"""By domain, in the order of parts: the first part that is no setting decides the type of the device."""
