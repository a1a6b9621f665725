"""Values that calls of services set, as steps of routines. Pure."""

import colorsys
import math
import re
from collections.abc import Iterator, Sequence
from typing import Final

from homebot.conventions.light_color import to_hue_saturation, white_rgb
from homebot.devices.capabilities import CAPABILITIES
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.conditions import templates_of
from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity
from homebot.integrations.homeassistant.automations.expressions import constant_of_template, expression_of
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.service_tables import (
    SERVICE_FIELDS,
    SERVICE_WORDS,
    SETTINGS,
    ServiceSetting,
)
from homebot.integrations.homeassistant.automations.states import number_of
from homebot.integrations.homeassistant.automations.template_calculations import calculation_text, step_length
from homebot.integrations.homeassistant.automations.template_numbers import changed_number, step_number
from homebot.integrations.homeassistant.automations.template_times import is_now
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes
from homebot.support.located import Located
from homebot.units import parse_duration
from homebot.words.colors import COLORS
from homebot.words.steps import EXAMPLES, Do, read_step


def settings_of(automation: Automation, name: str, data: UnreadFields) -> Iterator[ServiceSetting]:
    """Yield the values that a service sets."""
    if name == "input_datetime.set_datetime" and {"date", "time"} <= data.left.keys():
        data.left["datetime"] = _joined(*(data.left.pop(key) for key in ("date", "time")))
    keys = [key for key in SERVICE_FIELDS.get(name, ()) if key in data]
    if name == "timer.start" and "duration" in data:
        yield ServiceSetting("number", value=_minutes(automation, data))
    elif name in SERVICE_WORDS:
        capabilities, _, words = SERVICE_WORDS[name].partition(" ")
        yield ServiceSetting(capabilities, words)
    elif not keys:
        data.end()  # it names the field that is there instead
        raise NotCarriedError(f"data: `{SERVICE_FIELDS[name][0]}` is missing")
    for key in keys:
        yield from _settings_in(automation, name, key, data)
    if name == "light.turn_on" and (color := _color(data)) is not None:
        yield ServiceSetting("color", f"color {color[0]:.0f} {color[1]:.0f}")


def _settings_in(automation: Automation, name: str, key: str, data: UnreadFields) -> Iterator[ServiceSetting]:
    """Yield the value, or the values, of the field *key*."""
    row, node = SETTINGS[key], data.left[key]
    if name == "input_text.set_value":
        row = SETTINGS["text"]
    if isinstance(node.value, str) and (constant := constant_of_template(node.value)) is not None:
        node = data.left[key] = node._replace(value=constant)
    match CAPABILITIES[row.capabilities.split()[0]].kind:
        case "bool":
            yield row._replace(value=str(data.flag(key, default=True)).lower())
        case "number" if isinstance(node.value, str) and "{{" in node.value and "step" not in key:
            data.take(key)
            change = _change(automation, row, node.value)
            yield change or row._replace(value=_calculated(automation, key, row.factor, node.value))
        case "number":
            yield from (_of_number(name, key, number * row.factor) for number in data.numbers(key))
        case _ if key in {"datetime", "timestamp"} and _is_now_text(node):
            data.take(key)
            yield row._replace(value="{now}")
        case _ if isinstance(node.value, str) and row == SETTINGS["text"]:
            data.take(key)
            text = templates_of(automation).message(node.value, has_units=False)
            if "," in text:
                raise NotCarriedError(
                    f"data: {text!r} with a comma would be several values of a step; write it without"
                )
            yield row._replace(value=text)
        case _:
            yield row._replace(value=data.text(key))


def _joined(date: Located, time: Located) -> Located:
    """Return the moment of a *date* and *time*: two parts of this moment are this one."""
    parts = [str(part.value) for part in (date, time)]
    if all(_OF_NOW.fullmatch(part.replace(" ", "")) for part in parts):
        return date._replace(value="{{ now().isoformat() }}")
    return date._replace(value=" ".join(parts))


_OF_NOW: Final = re.compile(
    r"\{\{now\(\)\.(?:date\(\)|time\(\)|strftime\(['\"]%(?:Y-%m-%d|H:%M(?::%S)?|X|T)['\"]\))\}\}"
)


def _is_now_text(node: Located) -> bool:
    """Return whether *node* is a template of this moment, however it is written."""
    if not isinstance(node.value, str) or "now()" not in node.value:
        return False
    tree: nodes.Expr | None = expression_of(node.value)
    while tree is not None and not is_now(tree):
        match tree:
            case nodes.Call(node=nodes.Getattr(node=inner, attr="timestamp" | "isoformat"), args=[]):
                tree = inner
            case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]) if (
                form.startswith("%Y-%m-%d") and ("%H:%M" in form or "%T" in form)
            ):
                tree = inner
            case nodes.Call(node=nodes.Name(name="as_timestamp" | "int"), args=[inner, *_]):
                tree = inner
            case nodes.Filter(name="as_timestamp" | "int" | "timestamp_local" | "string", node=inner, args=[]):
                tree = inner
            case _:
                return False
    return tree is not None


def _calculated(automation: Automation, key: str, factor: float, text: str) -> str:
    """Return the number of the house that the template *text* is: as it is, or calculated."""
    try:
        value, own = step_number(automation, text)
    except NotCarriedError:
        value, own = "", math.nan
    if key != "color_temp" and math.isclose(own * factor, 1.0):
        return value
    number = calculation_text(automation, expression_of(text))
    if key == "color_temp":  # in mired
        return f"{{1000000 / ({number})}}"
    return f"{{{number}}}" if factor == 1.0 else f"{{({number}) * {factor:.12g}}}"


def _change(automation: Automation, row: ServiceSetting, text: str) -> ServiceSetting | None:
    """Return the change of a value by a number, such as ``+5 %``, that the template *text* is; None for another one."""
    if (number := changed_number(text)) is None:
        return None
    entity, capability, factor = number_of(automation.entities, number.entity, number.attribute)
    low, *_ = entity.bounds(capability) or (-1.0,)
    is_own = capability in row.capabilities.split() and math.isclose(factor, row.factor)
    if not is_own or low < 0 or entity.unit or (entity.domain == "light" and number.default != 0):
        return None
    automation.notes.append(f"the change of {number.entity} ends at its limits, and is left out while it is unknown")
    return row._replace(value=f"{number.offset * factor:+.6g}", of=entity.id)


def _minutes(automation: Automation, data: UnreadFields) -> str | float:
    """Return the minutes of a timer."""
    if text := step_length(automation, data.left["duration"]):
        data.take("duration")
        if not text.endswith("}m"):
            raise NotCarriedError("data: `duration` of a timer is a number of the house in minutes")
        return text[:-1]
    return parse_duration(data.duration("duration") or "0s") / 60


def _of_number(name: str, key: str, number: float) -> ServiceSetting:
    """Return the value of a field: of a light a step, the brightness in per cent, or the colour temperature in K."""
    row = SETTINGS[key]
    if key.startswith("brightness_step"):
        return row._replace(words=f"{number:+.3g} %")
    if name != "light.turn_on":
        return row._replace(value=number)
    value = 1_000_000 / max(1.0, number) if key == "color_temp" else number
    if key.startswith("brightness") and not 0 < value <= 100:
        raise NotCarriedError(f"data: `{key}` is {value:g} %")
    return row._replace(value=max(1, round(value)))


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
            hue, saturation, _ = colorsys.rgb_to_hsv(red / 255, green / 255, blue / 255)
            return 360 * hue, 100 * saturation
    raise NotCarriedError("data: a colour has two numbers in `hs_color`, or three in `rgb_color`")


def steps_of_entity(name: str, entity: KnownEntity, settings: Sequence[ServiceSetting], over: str) -> list[str]:
    """Return the steps that set *settings*; the mode of a heating is one of its own."""
    if name == "climate.set_temperature":
        mode = next((str(setting.value) for setting in settings if setting.capabilities == "thermostat_mode"), "")
        settings = [_of_mode(entity, setting, mode) for setting in settings]
        return [_step_of(entity, [setting], over) for setting in settings]
    if name == "fan.turn_on" and len(settings) > 1:
        settings = settings[1:]
    if others := [setting.of for setting in settings if setting.of not in {"", entity.id}]:
        raise NotCarriedError(f"data: {entity.id} takes a value of {others[0]} and a number; write the value")
    if name == "light.turn_on":
        settings = _of_lamp(entity, settings)
    if any(_is_change(setting) for setting in settings) and settings[0].words == "on":
        settings = settings[1:]  # a step of brightness turns it on
    return [_step_of(entity, settings, over)]


def _is_change(setting: ServiceSetting) -> bool:
    return setting.words.startswith(("+", "-")) or bool(setting.of)


def _of_mode(entity: KnownEntity, setting: ServiceSetting, mode: str) -> ServiceSetting:
    """Return the target temperature of the mode that is set with it, if a device has one for each."""
    wanted = {"heat": "heating_setpoint", "cool": "cooling_setpoint"}.get(mode, "")
    is_of_mode = wanted in setting.capabilities.split() and entity.takes(wanted)
    return setting._replace(capabilities=wanted) if is_of_mode else setting


def _of_lamp(entity: KnownEntity, settings: Sequence[ServiceSetting]) -> list[ServiceSetting]:
    """Return *settings* without what a lamp cannot do, which Home Assistant leaves out; an effect turns it on."""
    has_effect = any(setting.capabilities == "effect" for setting in settings)
    lit = [_as_color(entity, setting) for setting in settings if not has_effect or setting.words != "on"]
    return [setting for setting in lit if setting.capabilities not in _OF_LAMPS or entity.takes(setting.capabilities)]


def _as_color(entity: KnownEntity, setting: ServiceSetting) -> ServiceSetting:
    """Return a white as the colour of a lamp that has colours alone."""
    if setting.capabilities != "color_temperature" or entity.takes("color_temperature") or not entity.takes("color"):
        return setting
    if isinstance(setting.value, str):
        raise NotCarriedError(f"{entity.name} takes no color_temperature; write its colour")
    hue, saturation = to_hue_saturation("rgb", white_rgb(setting.value), (0, 0))
    return ServiceSetting("color", f"color {hue:.0f} {saturation:.0f}")


_OF_LAMPS: Final = frozenset({"level", "color", "color_temperature"})


def _step_of(entity: KnownEntity, settings: Sequence[ServiceSetting], over: str) -> str:
    """Return the step that sets *settings*."""
    names = [_taken(entity, setting) for setting in settings]
    words = [_words(entity, *name_and_setting) for name_and_setting in zip(names, settings, strict=True)]
    taking = [
        part
        for part in entity.device.parts
        if any(can.name in names and can.settable for can in part.part.capabilities)
    ]
    target = entity.name if len(taking) == 1 else f"{entity.device.id}#{entity.part.id}"
    return step_text(target, [*words, *([f"over {over}"] if over else [])])


def _taken(entity: KnownEntity, setting: ServiceSetting) -> str:
    """Return the capability of *setting* that an entity takes."""
    able = [capability for capability in setting.capabilities.replace("|", " ").split() if entity.takes(capability)]
    if not able or (len(able) > 1 and "|" not in setting.capabilities):
        raise NotCarriedError(f"{entity.name} takes {' and '.join(able) or f'no {setting.capabilities}'}")
    return able[0]


def _words(entity: KnownEntity, name: str, setting: ServiceSetting) -> str:
    """Return the words of *setting* if its value is possible."""
    value, options, bounds = setting.value, entity.options(name), entity.bounds(name)
    if CAPABILITIES[name].kind == "bool" and name == "muted":
        return "mute" if str(value).casefold() in {"true", "on", "yes"} else "unmute"
    if not isinstance(value, str):
        if bounds and not bounds[0] <= value <= bounds[-1]:
            raise NotCarriedError(f"{entity.name} takes {name} from {bounds[0]:g} to {bounds[-1]:g}, not {value:g}")
        return setting.words.format(name=name, value=f"{value:.12g}")
    words = setting.words.format(name=name, value=value)
    capability, _, option = words.partition(" ")
    if capability == name != "color" and option and options and option not in options:
        raise NotCarriedError(f"{entity.name} has no {name} {option!r}, only {', '.join(options)}")
    return words


_VALUE: Final = re.compile(r"\{[^{}]*\}")
"""A number of the house in a step."""


def step_text(target: str, words: Sequence[str]) -> str:
    """Return a step that homebot reads as a command to *target*."""
    count = len([word for word in words[1:] if not word.startswith("over ")])
    for text in (f"{target} {', '.join(words)}", *([f"{target}: {words[0]}"] if len(words) == 1 else [])):
        try:
            step = read_step(text)
        except UsageError:
            continue
        command = _VALUE.sub(lambda value: EXAMPLES.get(value[0][1:-1], "1"), words[0])
        if isinstance(step, Do) and (step.target, step.command, len(step.values)) == (target, command, count):
            return text
    raise NotCarriedError(f"{target!r} and {', '.join(words)!r} cannot be written as a step")
