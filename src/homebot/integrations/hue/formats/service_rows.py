"""Lights, sensors, buttons, batteries and scenes of a Hue bridge. Pure.

``min_dim_level`` says how much light there is at the lowest brightness, and limits no brightness. The bridge moves a
colour outside of the gamut of a light to the nearest one in it, and reports that. A light with a gradient has the
colour of its first point, and takes one colour for all of them.

Source: Philips Hue, CLIP API v2 reference, resources ``light``, ``motion``, ``camera_motion``, ``*_area_motion``,
``temperature``, ``light_level``, ``contact``, ``tamper``, ``device_power``, ``button``, ``bell_button``,
``relative_rotary``, ``scene`` and ``smart_scene``.
"""

from collections.abc import Callable, Mapping
from typing import Final

from homebot.conventions.command_values import require_option, require_transition, require_true
from homebot.conventions.light_color import MIRED, from_hue_saturation, nearest_mired_bounds, to_hue_saturation
from homebot.conventions.payload import text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.hue.formats.resources import Fields, HueBody, HueRow, at, hue_row
from homebot.support.numbers import finite_number

_WHITES: Final = (2000, 6500)
_MIREK: Final = (153.0, 500.0)
"""The limits of a light that does not say its own, or says the largest numbers of its bytes."""

_MAX_EFFECTS: Final = 50


def _transition_of(command: Command) -> HueBody:
    """Return the duration of a transition, which may take 6,000 seconds, in milliseconds; nothing for none."""
    seconds = require_transition(command.transition, 6000.0)
    return {"duration": round(seconds * 1000)} if seconds else {}


def _body(command: Command, *, on: bool = True, **changes: object) -> HueBody:
    duration = _transition_of(command)
    return {"on": {"on": on}, **changes, **({"dynamics": duration} if duration else {})}


def _flag(value: object) -> bool | None:
    return value if isinstance(value, bool) else None


def _read_level(light: Fields) -> PlainValue:
    level = finite_number(at(light, "dimming", "brightness"))
    return level if level is not None and 0 <= level <= 100 else None


def _write_level(_light: Fields, command: Command) -> HueBody:
    percent = command.value.number
    return _body(command, dimming={"brightness": round(percent, 2)}) if percent > 0 else _body(command, on=False)


def _mirek_bounds(light: Fields) -> tuple[float, float]:
    schema = at(light, "color_temperature", "mirek_schema")
    least, most = (finite_number(at(schema, name)) for name in ("mirek_minimum", "mirek_maximum"))
    return (least, most) if least is not None and most is not None and 25 <= least < most <= 1000 else _MIREK


def _mirek(light: Fields) -> float | None:
    """Return the colour temperature; None while the light has a colour."""
    mirek = finite_number(at(light, "color_temperature", "mirek"))
    is_white = mirek is not None and mirek >= 1 and at(light, "color_temperature", "mirek_valid") is not False
    return mirek if is_white else None


def _read_kelvin(light: Fields) -> PlainValue:
    mirek = _mirek(light)
    return None if mirek is None else float(round(MIRED / mirek))


def _write_kelvin(light: Fields, command: Command) -> HueBody:
    least, most = _mirek_bounds(light)
    return _body(command, color_temperature={"mirek": round(min(max(MIRED / command.value.number, least), most))})


def _read_color(light: Fields) -> PlainValue:
    x, y = (finite_number(at(light, "color", "xy", name)) for name in ("x", "y"))
    if x is None or y is None or not (0 <= x <= 1 and 0 <= y <= 1) or _mirek(light) is not None:
        return None
    return to_hue_saturation("xy", (x, y), _WHITES)


def _write_color(_light: Fields, command: Command) -> HueBody:
    hue, saturation = command.value.numbers
    x, y = from_hue_saturation("xy", hue, saturation, _WHITES)
    return _body(command, color={"xy": {"x": x, "y": y}})


def _effects(light: Fields) -> tuple[str, ...]:
    listed = at(light, "effects", "effect_values")
    return tuple(text_of(effect, 40) for effect in listed[:_MAX_EFFECTS]) if isinstance(listed, list) else ()


def _read_effect(light: Fields) -> PlainValue:
    effect = at(light, "effects", "status")
    return effect if isinstance(effect, str) and effect in _effects(light) else None


def _write_locate(_device: Fields, command: Command) -> HueBody:
    require_true("locate", command.value.plain())
    return {"identify": {"action": "identify"}}


_COLORS: Final = ("color", "color_temperature")


def _rows_of(kind: str) -> tuple[HueRow, ...]:
    """Return the rows of a light, or of all lights of a room or zone, of which no colour is reported."""
    is_one = kind == "light"
    colors, kelvin, color = (_COLORS, _read_kelvin, _read_color) if is_one else ((), None, None)
    return (
        hue_row(
            kind,
            "on_off",
            ("on",),
            lambda light: _flag(at(light, "on", "on")),
            lambda _light, setting: _body(setting, on=setting.value.flag),
        ),
        hue_row(kind, "level", ("dimming",), _read_level, _write_level, "dimming"),
        hue_row(
            kind,
            "color_temperature",
            colors,
            kelvin,
            _write_kelvin,
            "color_temperature",
            lambda light: nearest_mired_bounds(*_mirek_bounds(light)),
        ),
        hue_row(kind, "color", colors, color, _write_color, "color"),
    )


_LIGHT_ROWS: Final = (
    *_rows_of("light"),
    *_rows_of("grouped_light"),
    hue_row(
        "light",
        "effect",
        ("effects",),
        _read_effect,
        lambda light, setting: _body(
            setting, effects={"effect": require_option("effect", setting.value.text, _effects(light))}
        ),
        "effects",
        options=_effects,
    ),
    hue_row("light", "locate", (), write=_write_locate),
)


MOTION_KINDS: Final = ("motion", "camera_motion", "convenience_area_motion", "security_area_motion")
BUTTON_KINDS: Final = ("button", "bell_button")

_PRESSES: Final = {
    "initial_press": "initial_press",
    "repeat": "repeat",
    "short_release": "single",
    "double_short_release": "double",
    "long_press": "long",
    "long_release": "long_release",
}
"""The events of a button, by homebot's words for those that other protocols have as well."""

_TURNS: Final = {"clock_wise": "rotate_right", "counter_clock_wise": "rotate_left"}
_LOG_STEPS, _MAX_LOG = 10_000.0, 200_000.0


def press_of(change: Fields) -> tuple[str, str]:
    """Return the press or turn in a change of a resource, and its time; both empty if there is none.

    A bridge that starts sends its buttons without a report: none was pressed then.
    """
    button, rotary = at(change, "button", "button_report"), at(change, "relative_rotary", "rotary_report")
    press = _PRESSES.get(text_of(at(button, "event"))) or _TURNS.get(text_of(at(rotary, "rotation", "direction")), "")
    return press, text_of(at(button or rotary, "updated"))


def _presses(button: Fields) -> tuple[str, ...]:
    listed = at(button, "button", "event_values")
    names = listed if isinstance(listed, list) and listed else _PRESSES
    return tuple(dict.fromkeys(_PRESSES[name] for name in names if isinstance(name, str) and name in _PRESSES))


def _sensed(sensor: Fields, feature: str, name: str) -> object:
    """Return a value from its report, or from where older firmware has it; None from a sensor that is turned off."""
    if sensor.get("enabled") is False or at(sensor, feature, f"{name}_valid") is False:
        return None
    report = at(sensor, feature, f"{name}_report", name)
    return at(sensor, feature, name) if report is None else report


def _read_motion(sensor: Fields) -> PlainValue:
    return _flag(_sensed(sensor, "motion", "motion"))


def _read_celsius(sensor: Fields) -> PlainValue:
    celsius = finite_number(_sensed(sensor, "temperature", "temperature"))
    return None if celsius is None else round(celsius, 2)  # it sends 18.139999389648438


def _read_lux(sensor: Fields) -> PlainValue:
    level = finite_number(_sensed(sensor, "light", "light_level"))
    if level is None or not 0 <= level <= _MAX_LOG:
        return None
    return round(10 ** ((level - 1) / _LOG_STEPS), 2) if level > 0 else 0.0


def _read_tamper(sensor: Fields) -> PlainValue:
    reports = sensor.get("tamper_reports")
    return (
        any(at(report, "state") == "tampered" for report in reports) if isinstance(reports, list) and reports else None
    )


def _words(meanings: Mapping[str, bool], *path: str) -> Callable[[Fields], PlainValue]:
    """Return the reader of a word; None for one that is unknown, or of a sensor that is turned off."""
    return lambda service: None if service.get("enabled") is False else meanings.get(text_of(at(service, *path)))


def _write_recall(scene: Fields, command: Command) -> HueBody:
    """Recall a scene; one that follows the day has its own duration."""
    require_true("scene", command.value.plain())
    is_smart = scene.get("type") == "smart_scene"
    return {"recall": {"action": "activate"} if is_smart else {"action": "active", **_transition_of(command)}}


_MOTION, _WARMTH, _LIGHT = ((kind, "enabled") for kind in ("motion", "temperature", "light"))
_CONTACT, _POWER, _ANY = ("contact_report", "enabled"), ("power_state",), ("id",)

_read_contact = _words({"contact": False, "no_contact": True}, "contact_report", "state")
_read_low = _words({"normal": False, "low": True, "critical": True}, "power_state", "battery_state")

SERVICE_ROWS: Final = (
    *_LIGHT_ROWS,
    *(hue_row(kind, "occupancy", _MOTION, _read_motion) for kind in MOTION_KINDS),
    hue_row("temperature", "temperature", _WARMTH, _read_celsius),
    hue_row("light_level", "illuminance", _LIGHT, _read_lux),
    hue_row("contact", "contact", _CONTACT, _read_contact),
    hue_row("tamper", "tamper", ("tamper_reports",), _read_tamper),
    hue_row(
        "device_power", "battery", _POWER, lambda service: finite_number(at(service, "power_state", "battery_level"))
    ),
    hue_row("device_power", "battery_low", _POWER, _read_low),
    *(hue_row(kind, "press", _ANY, options=_presses) for kind in BUTTON_KINDS),
    hue_row("relative_rotary", "press", _ANY, options=lambda _: tuple(_TURNS.values())),
    *(hue_row(kind, "scene", (), write=_write_recall) for kind in ("scene", "smart_scene")),
)
