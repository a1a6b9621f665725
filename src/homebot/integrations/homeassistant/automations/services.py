"""Calls of services as steps of routines. Pure."""

import colorsys
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.text.colors import COLORS
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.routines.steps import Do, Notify, read_step

__all__ = ["steps_of_service"]

_MIREDS: Final = 1_000_000.0
_BRIGHTEST: Final = 255.0


class _Setting(NamedTuple):
    """A value that a service sets.

    Attributes:
        capabilities: Those that it may be, of which a device takes one; of ``a > b`` it is ``a`` if it takes both.
        words: Those of the command, with the capability and the value.
        value: The value, or the field with it; empty for none.
        factor: What the number in the field is multiplied by.
    """

    capabilities: str
    words: str
    value: str | float = ""
    factor: float = 1.0


_NAMED: Final = "{name} {value}"
_PERCENT: Final = "{name} {value} %"
_SERVICES: Final[Mapping[str, _Setting]] = {
    "cover.open_cover": _Setting("movement > position", "open"),
    "cover.close_cover": _Setting("movement > position", "close"),
    "cover.stop_cover": _Setting("movement", "stop"),
    "cover.set_cover_position": _Setting("position", "{value} %", "position"),
    "fan.set_percentage": _Setting("fan_speed", _PERCENT, "percentage"),
    "humidifier.set_humidity": _Setting("humidity_setpoint", _NAMED, "humidity"),
    "lock.lock": _Setting("lock", "lock"),
    "lock.unlock": _Setting("lock", "unlock"),
    "climate.set_temperature": _Setting("heating_setpoint cooling_setpoint", _NAMED, "temperature"),
    "climate.set_hvac_mode": _Setting("thermostat_mode", _NAMED, "hvac_mode"),
    "climate.set_preset_mode": _Setting("preset_mode", _NAMED, "preset_mode"),
    "climate.turn_off": _Setting("thermostat_mode", "thermostat_mode off"),
    "media_player.media_play": _Setting("playback", "playback playing"),
    "media_player.media_pause": _Setting("playback", "playback paused"),
    "media_player.media_stop": _Setting("playback", "playback stopped"),
    "media_player.volume_set": _Setting("volume", _PERCENT, "volume_level", 100.0),
    "vacuum.start": _Setting("vacuum", "start"),
    "vacuum.pause": _Setting("vacuum", "pause"),
    "vacuum.return_to_base": _Setting("vacuum", "dock"),
    "scene.turn_on": _Setting("scene", "press"),
    "button.press": _Setting("push", "press"),
    "input_button.press": _Setting("push", "press"),
    "select.select_option": _Setting("option", _NAMED, "option"),
    "input_select.select_option": _Setting("option", _NAMED, "option"),
} | {
    f"{domain}.{service}": _Setting("on_off", word)
    for domain in ("light", "switch", "input_boolean", "fan", "siren", "humidifier", "media_player", "homeassistant")
    for service, word in (("turn_on", "on"), ("turn_off", "off"), ("toggle", "toggle"))
}
_LAMP: Final = (
    _Setting("level", "{value} %", "brightness_pct"),
    _Setting("level", "{value} %", "brightness", 100 / _BRIGHTEST),
    _Setting("color_temperature", "{value} K", "color_temp_kelvin"),
    _Setting("color_temperature", "{value} K", "kelvin"),
)
"""What ``light.turn_on`` may set beside ``on``."""


def steps_of_service(entities: Entities, fields: UnreadFields, key: str) -> list[str]:
    """Return the steps of the call of a service, which the field *key* names."""
    scenes = fields.texts(key) if key == "scene" else []
    name = "scene.turn_on" if scenes else fields.text(key)
    domain = name.partition(".")[0]
    places = fields.inner("target"), fields.inner("data", "service_data"), fields
    ids, areas, devices = (
        [one for place in places for one in place.texts(key)] for key in ("entity_id", "area_id", "device_id")
    )
    ids += scenes
    target, data, _ = places
    target.end()
    if domain in {"notify", "persistent_notification"} and all(one.startswith("notify.") for one in ids):
        return [_message(name, data)]
    if name not in _SERVICES:
        raise NotCarriedError(f"the service {name} has no counterpart in routines")
    if devices or not (ids or areas):
        raise NotCarriedError("the target `device_id`: name the entity" if devices else "no target; name an entity")
    settings, over = [*_settings(name, data)], data.duration("transition") if domain == "light" else ""
    data.end()
    if areas or ids == ["all"]:
        if name not in {"light.turn_on", "light.turn_off"} or len(settings) > 1 or over or (ids and areas):
            raise NotCarriedError(f"{name}: by `area_id` or `all` only lights are switched, and only on and off")
        groups = [f"lights in {entities.room_of(one)}" for one in areas] or ["all lights"]
        return [_step(one, [settings[0].words]) for one in groups]
    known = [*map(entities.find, ids)]
    if others := [one.id for one in known if domain not in {one.domain, "homeassistant"}]:
        raise NotCarriedError(f"{name}: {others[0]} belongs to another domain")
    return [step for one in known for step in _steps(one, settings, over)]


def _message(name: str, data: UnreadFields) -> str:
    title, message = data.text("title", ""), data.text("message")
    data.take("notification_id")
    data.end()
    text = f"notify {' '.join(': '.join(filter(None, (title, message))).split())}"
    if not isinstance(read_step(text), Notify):
        raise NotCarriedError(f"{name}: {message!r} is no message for a step")
    return text


def _settings(name: str, data: UnreadFields) -> Iterator[_Setting]:
    """Yield the values that a service sets."""
    row = _SERVICES[name]
    yield _with_value(row, data)
    if name != "light.turn_on":
        return
    for one in _LAMP:
        if str(one.value) in data:
            found = _with_value(one, data)
            is_level = one.capabilities == "level"
            if is_level and not 0 < float(found.value) <= 100:
                raise NotCarriedError(f"data: `{one.value}` is {found.value:g} %")
            yield found._replace(value=max(1, round(float(found.value))) if is_level else found.value)
    for mireds in data.numbers("color_temp"):
        yield _Setting("color_temperature", "{value} K", round(_MIREDS / max(1.0, mireds)))
    if (color := _color(data)) is not None:
        yield _Setting("color", f"color {color[0]:.0f} {color[1]:.0f}")


def _with_value(row: _Setting, data: UnreadFields) -> _Setting:
    if not (key := str(row.value)):
        return row
    if CAPABILITIES[row.capabilities.split()[0]].kind != "number":
        return row._replace(value=data.text(key))
    if (number := data.number(key)) is None:
        raise NotCarriedError(f"data: `{key}` is missing")
    return row._replace(value=number * row.factor)


def _color(data: UnreadFields) -> tuple[float, float] | None:
    if name := data.text("color_name", ""):
        if name not in COLORS:
            raise NotCarriedError(f"data: homebot knows no colour {name!r}")
        hue, saturation = COLORS[name]
        return hue, saturation
    match data.numbers("hs_color"), data.numbers("rgb_color"):
        case [], []:
            return None
        case [hue, saturation], []:
            return hue, saturation
        case [], [red, green, blue]:
            hue, saturation, _ = colorsys.rgb_to_hsv(red / _BRIGHTEST, green / _BRIGHTEST, blue / _BRIGHTEST)
            return 360 * hue, 100 * saturation
    raise NotCarriedError("data: a colour has two numbers in `hs_color`, or three in `rgb_color`")


def _steps(entity: KnownEntity, settings: Sequence[_Setting], over: str) -> list[str]:
    """Return the steps that set *settings*: one for all, and one for a colour."""
    words, taken = [], []
    for one in settings:
        name = _taken(entity, one)
        _check(entity, name, one)
        value = f"{one.value:.12g}" if isinstance(one.value, (int, float)) else one.value
        words.append(one.words.format(name=name, value=value))
        taken.append(name)
    count = len([one for one in taken if one != "color"])
    if over and count < len(words):
        raise NotCarriedError("data: `transition` with a colour")
    together = [*words[:count], *([f"over {over}"] if over else [])]
    return [
        _step(_target(entity, taken[:count]), together),
        *(_step(_target(entity, ["color"]), [one]) for one in words[count:]),
    ]


def _taken(entity: KnownEntity, setting: _Setting) -> str:
    """Return the capability of *setting* that an entity takes."""
    able = [one for one in setting.capabilities.split() if entity.takes(one)]
    if not able or (len(able) > 1 and ">" not in setting.capabilities):
        names = " and ".join(able) or "no " + setting.capabilities.replace(" > ", " or ")
        raise NotCarriedError(f"{entity.name} takes {names}")
    return able[0]


def _check(entity: KnownEntity, name: str, setting: _Setting) -> None:
    """Check that *setting* has a value that is possible."""
    value, options, bounds = setting.value, entity.options(name), entity.bounds(name)
    if isinstance(value, str):
        word = value or setting.words.rpartition(" ")[2]
        if (value or setting.words.startswith(f"{name} ")) and word not in options and options:
            raise NotCarriedError(f"{entity.name} has no {name} {word!r}, only {', '.join(options)}")
    elif bounds and not bounds[0] <= value <= bounds[-1]:
        raise NotCarriedError(f"{entity.name} takes {name} from {bounds[0]:g} to {bounds[-1]:g}, not {value:g}")


def _target(entity: KnownEntity, names: Sequence[str]) -> str:
    """Return the name of the device, with the id of its part if several take the command."""
    taking = [
        one for one in entity.device.parts if any(can.name in names and can.settable for can in one.part.capabilities)
    ]
    return entity.name if len(taking) == 1 else f"{entity.device.id}#{entity.part.id}"


def _step(target: str, words: Sequence[str]) -> str:
    """Return a step that homebot reads as a command to *target*."""
    for text in (f"{target} {', '.join(words)}", f"{target}: {words[0]}" if len(words) == 1 else ""):
        try:
            step = read_step(text) if text else None
        except UsageError:
            continue
        values = [one for one in words[1:] if not one.startswith("over ")]
        if (
            isinstance(step, Do)
            and (step.target, step.command) == (target, words[0])
            and len(step.values) == len(values)
        ):
            return text
    raise NotCarriedError(f"{target!r} and {', '.join(words)!r} cannot be written as a step")
