"""Calls of services as steps of routines. Pure."""

import colorsys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Final, NamedTuple, TypeAlias

from homebot.devices.text.colors import COLORS
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity
from homebot.integrations.homeassistant.automations.fields import (
    NotCarriedError,
    check_keys,
    check_tag,
    duration_of,
    fields_of,
    items_of,
    number_of,
    shown,
    text_of,
    texts_of,
)
from homebot.routines.steps import Do, Notify, read_step
from homebot.support.located import Located

__all__ = ["steps_of_service"]

_GENERAL: Final = ("alias", "enabled", "continue_on_error", "metadata")
_TARGETS: Final = ("entity_id", "device_id", "area_id")
_ALL: Final = "all"
_MIREDS: Final = 1_000_000
_BRIGHTEST: Final = 255

_Data: TypeAlias = Mapping[str, Located]


class _CommandWords(NamedTuple):
    """Words of commands, each for a capability."""

    capability: str
    words: tuple[str, ...]


_Make: TypeAlias = Callable[[KnownEntity, _Data, int], list[_CommandWords]]


def steps_of_service(entities: Entities, node: Located, fields: Mapping[str, Located], key: str) -> Iterator[str]:
    """Yield the steps of the call of a service, which the field *key* of *node* names."""
    check_keys(node, "action", *_GENERAL, key, "target", "data", "entity_id", "service_data")
    name = text_of(fields[key], key)
    domain, _, service = name.partition(".")
    data = {**_fields(fields.get("service_data")), **_fields(fields.get("data"))}
    target = _fields(fields.get("target"))
    target |= {one: data.pop(one) for one in _TARGETS if one in data}
    target |= {one: fields[one] for one in _TARGETS if one in fields}
    if domain in {"notify", "persistent_notification"} and not target:
        yield _message(data, node, name)
        return
    for one in target:
        if one not in _TARGETS:
            raise NotCarriedError(node.line, f"{name}: the target `{one}`")
    if f"{domain}.{service}" not in _SERVICES and (domain not in _SWITCHED or service not in _SWITCHES):
        raise NotCarriedError(node.line, f"the service {name} has no counterpart in routines")
    if "area_id" in target or _is_all(target):
        yield from _whole(entities, domain, service, target, data, node)
        return
    for entity in _entities(entities, domain, target, node):
        yield from _steps(entity, name, data, node.line)


def _fields(node: Located | None) -> dict[str, Located]:
    if node is None or node.value is None:
        return {}
    return dict(fields_of(node, "data"))


def _is_all(target: _Data) -> bool:
    return "entity_id" in target and texts_of(target["entity_id"], "entity_id") == [_ALL]


def _message(data: dict[str, Located], node: Located, name: str) -> str:
    message = data.pop("message", None)
    title = data.pop("title", None)
    data.pop("notification_id", None)
    if message is None or data:
        raise NotCarriedError(node.line, f"{name}: {'`' + next(iter(data)) + '`' if data else 'no message'}")
    texts = [text_of(one, name) for one in (title, message) if one is not None]
    text = f"notify {' '.join(': '.join(texts).split())}"
    if not isinstance(read_step(text), Notify):
        raise NotCarriedError(node.line, f"{name}: {shown(message)} is no message for a step")
    return text


def _whole(entities: Entities, domain: str, service: str, target: _Data, data: _Data, node: Located) -> Iterator[str]:
    """Yield the step for all lights of a room, or of the house."""
    if domain != "light" or service not in {"turn_on", "turn_off"} or data or len(target) != 1:
        raise NotCarriedError(node.line, f"{domain}.{service}: only lights are switched by `area_id` or `all`")
    rooms = [entities.room_of(one, node.line) for one in texts_of(target.get("area_id", Located([], 0)), "area_id")]
    word = "on" if service == "turn_on" else "off"
    for room in rooms or [""]:
        yield _step(f"lights in {room}" if room else "all lights", [word], node.line)


def _entities(entities: Entities, domain: str, target: _Data, node: Located) -> Iterator[KnownEntity]:
    ids = texts_of(target["entity_id"], "entity_id") if "entity_id" in target else []
    if "device_id" in target:
        raise NotCarriedError(node.line, "the target `device_id`: name the entity")
    if not ids:
        raise NotCarriedError(node.line, "no target; name an entity")
    for one in ids:
        entity = entities.find(one, node.line)
        if domain not in {entity.domain, "homeassistant"}:
            raise NotCarriedError(node.line, f"{domain}: {one} belongs to another domain")
        yield entity


def _steps(entity: KnownEntity, name: str, data: _Data, line: int) -> list[str]:
    service = name.partition(".")[2]
    make = _SERVICES[name] if name in _SERVICES else _SWITCHES[service]
    commands = make(entity, data, line)
    for one in commands:
        if not entity.has(one.capability, settable=True):
            raise NotCarriedError(line, f"{name}: {entity.name} does not take {one.capability}")
    return [_step(_target(entity, one.capability), one.words, line) for one in commands]


def _target(entity: KnownEntity, capability: str) -> str:
    """Return the name of the device, with the id of its part if several take the command."""
    taking = [
        one
        for one in entity.device.parts
        if any(can.name == capability and can.settable for can in one.part.capabilities)
    ]
    return entity.name if len(taking) == 1 else f"{entity.device.id}#{entity.part.id}"


def _step(target: str, words: Sequence[str], line: int) -> str:
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
    raise NotCarriedError(line, f"{target!r} and {', '.join(words)!r} cannot be written as a step")


def _check_data(data: _Data, *known: str) -> None:
    for key, value in data.items():
        check_tag(value)
        if key not in known:
            raise NotCarriedError(value.line, f"data: `{key}` has no counterpart in routines")


def _word(capability: str, word: str) -> _Make:
    """Return the maker of a command of one word, without data."""

    def make(_entity: KnownEntity, data: _Data, _line: int) -> list[_CommandWords]:
        _check_data(data)
        return [_CommandWords(capability, (word,))]

    return make


def _number(capability: str, key: str, words: str, factor: float = 1.0) -> _Make:
    """Return the maker of a command with the number in *key*."""

    def make(_entity: KnownEntity, data: _Data, line: int) -> list[_CommandWords]:
        _check_data(data, key)
        if key not in data:
            raise NotCarriedError(line, f"data: `{key}` is missing")
        return [_CommandWords(capability, (words.format(f"{number_of(data[key], key) * factor:g}"),))]

    return make


def _light(entity: KnownEntity, data: _Data, line: int) -> list[_CommandWords]:
    """Make the commands of ``light.turn_on``: a brightness and a white with it, or a colour after it."""
    _check_data(data, *_LIGHT)
    over = (
        [f"over {length}"] if "transition" in data and (length := duration_of(data["transition"], "transition")) else []
    )
    words, needs = ["on"], "on_off"
    if (level := _level(data)) is not None:
        _check_bounds(entity, needs := "level", level, line)
        words.append(f"{level:g} %")
    if (kelvin := _kelvin(data)) is not None:
        words.append(f"{kelvin:.0f} K")
        _check_bounds(entity, "color_temperature", kelvin, line)
        if not entity.has("color_temperature", settable=True):
            raise NotCarriedError(line, f"{entity.name} takes no white tone")
    commands = [_CommandWords(needs, (*words, *over))]
    if (color := _color(data, line)) is not None:
        commands.append(_CommandWords("color", (f"color {color[0]:.0f} {color[1]:.0f}",)))
        if over:
            raise NotCarriedError(line, "data: `transition` with a colour")
    return commands


def _level(data: _Data) -> float | None:
    for key, most in (("brightness_pct", 100), ("brightness", _BRIGHTEST)):
        if key in data:
            level = 100 * number_of(data[key], key) / most
            if not 0 < level <= 100:
                raise NotCarriedError(data[key].line, f"data: `{key}` is {shown(data[key])}")
            return max(1, round(level))
    return None


def _kelvin(data: _Data) -> float | None:
    for key in ("kelvin", "color_temp_kelvin"):
        if key in data:
            return number_of(data[key], key)
    return _MIREDS / max(1.0, number_of(data["color_temp"], "color_temp")) if "color_temp" in data else None


def _color(data: _Data, line: int) -> tuple[float, float] | None:
    if "color_name" in data:
        name = text_of(data["color_name"], "color_name")
        if name not in COLORS:
            raise NotCarriedError(line, f"data: homebot knows no colour {name!r}")
        hue, saturation = COLORS[name]
        return hue, saturation
    if "hs_color" in data:
        hue, saturation = (number_of(one, "hs_color") for one in _three(data["hs_color"], 2))
        return hue, saturation
    if "rgb_color" in data:
        red, green, blue = (number_of(one, "rgb_color") / _BRIGHTEST for one in _three(data["rgb_color"], 3))
        hue, saturation, _ = colorsys.rgb_to_hsv(red, green, blue)
        return 360 * hue, 100 * saturation
    return None


def _three(node: Located, count: int) -> list[Located]:
    items = items_of(node)
    if len(items) != count:
        raise NotCarriedError(node.line, f"{shown(node)} is no list of {count} numbers")
    return items


def _off(_entity: KnownEntity, data: _Data, _line: int) -> list[_CommandWords]:
    _check_data(data, "transition")
    length = duration_of(data["transition"], "transition") if "transition" in data else ""
    return [_CommandWords("on_off", ("off", f"over {length}") if length else ("off",))]


def _temperature(entity: KnownEntity, data: _Data, line: int) -> list[_CommandWords]:
    _check_data(data, "temperature")
    setpoints = [one for one in ("heating_setpoint", "cooling_setpoint") if entity.has(one, settable=True)]
    if len(setpoints) != 1 or "temperature" not in data:
        raise NotCarriedError(
            line, f"{entity.name} has {len(setpoints)} target temperatures; one is needed, and its value"
        )
    value = number_of(data["temperature"], "temperature")
    _check_bounds(entity, setpoints[0], value, line)
    return [_CommandWords(setpoints[0], (f"{setpoints[0]} {value:g}",))]


def _option(capability: str, key: str) -> _Make:
    """Return the maker of a command that selects one of the options of a part."""

    def make(entity: KnownEntity, data: _Data, line: int) -> list[_CommandWords]:
        _check_data(data, key)
        value = text_of(data[key], key) if key in data else ""
        if value not in entity.options(capability):
            raise NotCarriedError(line, f"{entity.name} has no {key} {value!r}")
        return [_CommandWords(capability, (f"{capability} {value}",))]

    return make


def _moved(word: str, entity: KnownEntity, data: _Data, _line: int) -> list[_CommandWords]:
    _check_data(data)
    return [_CommandWords("movement" if entity.has("movement", settable=True) else "position", (word,))]


def _heating_off(entity: KnownEntity, data: _Data, line: int) -> list[_CommandWords]:
    return _option("thermostat_mode", "hvac_mode")(entity, {**data, "hvac_mode": Located("off", line)}, line)


def _check_bounds(entity: KnownEntity, capability: str, value: float, line: int) -> None:
    bounds = next((one.bounds for one in entity.part.part.capabilities if one.name == capability), ())
    if bounds and not bounds[0] <= value <= bounds[-1]:
        raise NotCarriedError(
            line, f"{entity.name} takes {capability} from {bounds[0]:g} to {bounds[-1]:g}, not {value:g}"
        )


_LIGHT: Final = (
    *("brightness", "brightness_pct", "kelvin", "color_temp_kelvin", "color_temp"),
    *("color_name", "hs_color", "rgb_color", "transition"),
)
_SWITCHED: Final = frozenset(
    {"switch", "input_boolean", "fan", "siren", "humidifier", "media_player", "light", "homeassistant"}
)
_SWITCHES: Final[Mapping[str, _Make]] = {
    "turn_on": _word("on_off", "on"),
    "turn_off": _word("on_off", "off"),
    "toggle": _word("on_off", "toggle"),
}
_SERVICES: Final[Mapping[str, _Make]] = {
    "light.turn_on": _light,
    "light.turn_off": _off,
    "cover.open_cover": partial(_moved, "open"),
    "cover.close_cover": partial(_moved, "close"),
    "cover.stop_cover": _word("movement", "stop"),
    "cover.set_cover_position": _number("position", "position", "{} %"),
    "fan.set_percentage": _number("fan_speed", "percentage", "fan_speed {} %"),
    "lock.lock": _word("lock", "lock"),
    "lock.unlock": _word("lock", "unlock"),
    "climate.set_temperature": _temperature,
    "climate.set_hvac_mode": _option("thermostat_mode", "hvac_mode"),
    "climate.turn_off": _heating_off,
    "media_player.media_play": _word("playback", "playback playing"),
    "media_player.media_pause": _word("playback", "playback paused"),
    "media_player.media_stop": _word("playback", "playback stopped"),
    "media_player.volume_set": _number("volume", "volume_level", "volume {} %", 100.0),
    "vacuum.start": _word("vacuum", "start"),
    "vacuum.pause": _word("vacuum", "pause"),
    "vacuum.return_to_base": _word("vacuum", "dock"),
    "scene.turn_on": _word("scene", "press"),
    "button.press": _word("push", "press"),
    "input_button.press": _word("push", "press"),
    "select.select_option": _option("option", "option"),
    "input_select.select_option": _option("option", "option"),
}
