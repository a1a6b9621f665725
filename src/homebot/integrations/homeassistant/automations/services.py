"""Calls of services as steps of routines. Pure."""

import colorsys
import math
import re
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Final, NamedTuple

from homebot.conventions.light_color import to_hue_saturation, white_rgb
from homebot.devices.capabilities import CAPABILITIES
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.conditions import templates_of
from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.template_numbers import step_length, step_number
from homebot.support.located import Located
from homebot.units import parse_duration
from homebot.words.colors import COLORS
from homebot.words.steps import Do, Notify, read_step

_ON_OFF: Final = ("light", "switch", "input_boolean", "fan", "siren", "humidifier", "media_player", "homeassistant")
_WORDS: Final = {
    **{f"{domain}.turn_on": "on_off on" for domain in _ON_OFF},
    **{f"{domain}.turn_off": "on_off off" for domain in _ON_OFF},
    **{f"{domain}.toggle": "on_off toggle" for domain in _ON_OFF},
    **{
        f"alarm_control_panel.alarm_arm_{mode}": f"alarm alarm armed_{mode}"
        for mode in ("home", "away", "night", "vacation")
    },
    "alarm_control_panel.alarm_disarm": "alarm disarm",
    "cover.open_cover": "movement|position open",
    "cover.close_cover": "movement|position close",
    "cover.stop_cover": "movement stop",
    "cover.open_cover_tilt": "tilt tilt 100 %",
    "cover.close_cover_tilt": "tilt tilt 0 %",
    "valve.open_valve": "valve|position open",
    "valve.close_valve": "valve|position close",
    "valve.stop_valve": "valve stop",
    "lock.lock": "lock lock",
    "lock.unlock": "lock unlock",
    "lock.open": "lock open",
    "climate.turn_off": "thermostat_mode thermostat_mode off",
    "water_heater.turn_on": "on_off on",
    "water_heater.turn_off": "on_off off",
    "lawn_mower.start_mowing": "mower start",
    "lawn_mower.pause": "mower pause",
    "lawn_mower.dock": "mower dock",
    "media_player.media_play": "playback playback playing",
    "media_player.media_pause": "playback playback paused",
    "media_player.media_stop": "playback playback stopped",
    "media_player.volume_up": "volume volume +10 %",
    "media_player.volume_down": "volume volume -10 %",
    "vacuum.start": "vacuum start",
    "vacuum.pause": "vacuum pause",
    "vacuum.return_to_base": "vacuum dock",
    "vacuum.stop": "vacuum stop",
    "vacuum.clean_spot": "vacuum vacuum spot",
    "scene.turn_on": "scene press",
    "button.press": "push press",
    "input_button.press": "push press",
    "counter.increment": "number number +1",
    "counter.decrement": "number number -1",
    "counter.reset": "number number 0",
    "timer.start": "on_off on",
    "timer.cancel": "on_off off",
}
"""The capability of services without data, of which a device takes the first that it has, and the words."""

_DATA: Final = {
    "light.turn_on": (
        *("brightness_pct", "brightness", "brightness_step_pct", "brightness_step"),
        *("color_temp_kelvin", "kelvin", "color_temp", "effect"),
    ),
    "cover.set_cover_position": ("position",),
    "cover.set_cover_tilt_position": ("tilt_position",),
    "fan.turn_on": ("percentage",),
    "fan.set_percentage": ("percentage",),
    "fan.set_preset_mode": ("preset_mode",),
    "fan.set_direction": ("direction",),
    "fan.oscillate": ("oscillating",),
    "valve.set_valve_position": ("position",),
    "humidifier.set_mode": ("mode",),
    "water_heater.set_temperature": ("temperature",),
    "water_heater.set_operation_mode": ("operation_mode",),
    "climate.set_fan_mode": ("fan_mode",),
    "climate.set_swing_mode": ("swing_mode",),
    "vacuum.set_fan_speed": ("fan_speed",),
    "media_player.select_source": ("source",),
    "number.set_value": ("value",),
    "input_number.set_value": ("value",),
    "counter.set_value": ("value",),
    "input_datetime.set_datetime": ("time",),
    "humidifier.set_humidity": ("humidity",),
    "climate.set_temperature": ("hvac_mode", "temperature"),
    "climate.set_hvac_mode": ("hvac_mode",),
    "climate.set_preset_mode": ("preset_mode",),
    "media_player.volume_set": ("volume_level",),
    "media_player.volume_mute": ("is_volume_muted",),
    "select.select_option": ("option",),
    "input_select.select_option": ("option",),
}
"""The fields of the data of services; without words one of them is needed."""

_SERVICES: Final = _WORDS.keys() | _DATA.keys()


class _Setting(NamedTuple):
    """A value of a service.

    Attributes:
        capabilities: Those that it may be: a device takes only one, or the first of ``a|b`` that it takes.
        words: Those of the command, with the capability and the value.
        factor: What the number in the field is multiplied by.
    """

    capabilities: str
    words: str = "{name} {value}"
    factor: float = 1.0
    value: str | float = ""


_FIELDS: Final = {
    "brightness_pct": _Setting("level", "{value} %"),
    "brightness": _Setting("level", "{value} %", 100 / 255),
    "brightness_step_pct": _Setting("level", "{value} %"),
    "brightness_step": _Setting("level", "{value} %", 100 / 255),
    "tilt_position": _Setting("tilt", "{name} {value} %"),
    "value": _Setting("number", "{name} {value}"),
    "is_volume_muted": _Setting("muted"),
    "color_temp_kelvin": _Setting("color_temperature", "{value} K"),
    "kelvin": _Setting("color_temperature", "{value} K"),
    "color_temp": _Setting("color_temperature", "{value} K"),
    "position": _Setting("position", "{value} %"),
    "percentage": _Setting("fan_speed", "{name} {value} %"),
    "humidity": _Setting("humidity_setpoint"),
    "temperature": _Setting("heating_setpoint cooling_setpoint"),
    "volume_level": _Setting("volume", "{name} {value} %", 100.0),
    "hvac_mode": _Setting("thermostat_mode"),
    "preset_mode": _Setting("preset_mode"),
    "option": _Setting("option"),
    "source": _Setting("option"),
    "effect": _Setting("effect"),
    "direction": _Setting("direction"),
    "oscillating": _Setting("oscillation"),
    "time": _Setting("text", "{value}"),
    "mode": _Setting("humidifier_mode"),
    "operation_mode": _Setting("water_heater_mode"),
    "fan_mode": _Setting("fan_mode"),
    "fan_speed": _Setting("fan_mode"),
    "swing_mode": _Setting("swing_mode"),
}


_DROPPED: Final = {
    *("logbook.log", "persistent_notification.dismiss", "system_log.write", "logger.set_level"),
    *("homeassistant.update_entity", "frontend.set_theme", "browser_mod.popup"),
}
"""Services without an effect in the house."""


def steps_of_service(automation: Automation, fields: UnreadFields, key: str) -> list[str]:
    """Return the steps of the call of a service, which the field *key* names: a scene, or an action of a device."""
    name = _service_name(fields, key)
    domain, data = name.partition(".")[0], fields.inner("data", "data_template", "service_data")
    if key == "device_id":
        data = UnreadFields(
            Located({field: fields.take(field) for field in [*fields.left] if field in _DEVICE_DATA}, 0), "data"
        )
    target = _target_of(fields, data)
    if domain == "tts":
        return [_spoken(automation, name, data)]
    if name in _DROPPED:
        data.left.clear()
        automation.notes.append(f"{name} is left out")
        return []
    if domain == "notify" and _is_clearing(data):
        automation.notes.append("messages of homebot are not cleared")
        return []
    if (domain == "notify" or name == "persistent_notification.create") and target.is_to_notify:
        return [_message(automation, name, data)]
    if name in {"automation.turn_on", "automation.turn_off"}:
        data.take("stop_actions")
        data.end()
        words = name.rpartition("_")[2]
        return [f"routine {automation.names.routine(entity)} {words}" for entity in target.entities]
    if name not in _SERVICES:
        raise NotCarriedError(f"the service {name} has no counterpart in routines{_ADVICE.get(domain, '')}")
    target.check(name)
    if name == "scene.turn_on" and (scenes := automation.names.scenes_of(target.entities)):
        over = data.duration("transition")
        data.end()
        return [f"scene {scene}{f', over {over}' if over else ''}" for scene in scenes]
    if name == "scene.turn_on" and data.duration("transition"):
        automation.notes.append("a scene of Home Assistant takes no transition from homebot")
    if domain in {"alarm_control_panel", "lock"} and data.take("code") is not None:
        automation.notes.append(
            "a code is kept by no routine: write it in Home Assistant as the default code of the entity"
        )
    settings, over = [*_settings(automation, name, data)], data.duration("transition") if domain == "light" else ""
    data.end()
    if any(word.words[:1] == "-" or str(word.value)[:1] == "-" for word in settings) and domain == "light":
        automation.notes.append("a lamp stays on at 1 % where a step would turn it off in Home Assistant")
    if (target.entities == ["all"] or target.areas) and _is_of_lights(name, settings, over):
        return [*_of_rooms(automation, target, settings)]
    known = _entities_of(automation, target, domain)
    return [text for entity in known for text in _steps_of(name, entity, settings, over)]


def _entities_of(automation: Automation, target: "_Target", domain: str) -> list[KnownEntity]:
    """Return the entities of *target*, which a service of *domain* commands."""
    entities = automation.entities
    known = [*map(entities.find, [entity for entity in target.entities if entity != "all"])]
    if "all" in target.entities:
        automation.notes.append(f"all means each {domain} that homebot knows now")
        known += entities.of_domain(domain)
    for kind, place in target.places:
        automation.notes.append(f"{kind} {place} means the devices that homebot knows there now")
        known += entities.of_target(domain, kind, place)
    if others := [entity.id for entity in known if domain not in {entity.domain, "homeassistant"}]:
        raise NotCarriedError(f"a service of {domain}: {others[0]} belongs to another domain")
    return known


_DEVICE_DATA: Final = frozenset({"brightness_pct", "position", "hvac_mode", "preset_mode", "option", "value"})
"""The fields of actions of devices that are data."""

_ADVICE: Final = {
    "camera": "; homebot sends no pictures",
    "mqtt": "; command the device itself, or write an app, see docs/apps.md",
    "pyscript": "; write an app, see docs/apps.md",
    "python_script": "; write an app, see docs/apps.md",
    "remote": "; command the device itself",
    "scene": "; write the scene in homebot, see docs/scenes.md",
    "weather": "; use a sensor of the forecast",
    "media_player": "; homebot plays no media",
    "shell_command": "; write an app, see docs/apps.md",
    "rest_command": "; write an app, see docs/apps.md",
    "script": "; write the routine of its steps, or import it from the file with `script:`",
    "climate": "; write the mode, as `climate.set_hvac_mode`",
}


def _is_of_lights(name: str, settings: Sequence[_Setting], over: str) -> bool:
    """Return whether a service only switches lights on or off, as homebot does with all of a room."""
    return name in {"light.turn_on", "light.turn_off"} and len(settings) == 1 and not over


def _of_rooms(automation: Automation, target: "_Target", settings: Sequence[_Setting]) -> Iterator[str]:
    """Yield the steps for the lights of rooms, or of the house."""
    if not target.areas:
        yield _step("all lights", [settings[0].words])
    for room in map(automation.entities.room_of, target.areas):
        yield _step(f"lights in {room}", [settings[0].words])


class _Target(NamedTuple):
    """The target of a service.

    Attributes:
        places: The fields of the target beside the entities, each with what it names.
    """

    entities: list[str]
    places: list[tuple[str, str]]

    @property
    def is_to_notify(self) -> bool:
        """True unless other entities than those of messages are named."""
        return all(entity.startswith("notify.") for entity in self.entities)

    @property
    def areas(self) -> list[str]:
        """The areas, if nothing else is named."""
        kinds = {kind for kind, _ in self.places}
        return [place for _, place in self.places] if kinds == {"area_id"} and not self.entities else []

    def check(self, name: str) -> None:
        """Refuse a target without a name, or with all domains of a place."""
        if not self.entities and not self.places:
            raise NotCarriedError(f"{name}: no target; name an entity")
        if self.places and name.startswith("homeassistant."):
            raise NotCarriedError(
                f"{name}: everything in {self.places[0][1]}; name the entities, or use light.turn_off"
            )


def _service_name(fields: UnreadFields, key: str) -> str:
    if key == "device_id":
        fields.take(key)
        return f"{fields.text('domain')}.{fields.text('type')}"
    return "scene.turn_on" if key == "scene" else fields.text(key)


def _target_of(fields: UnreadFields, data: UnreadFields) -> _Target:
    """Return the target, which older texts have in the data or beside the service."""
    target = fields.inner("target")
    ids, *places = (
        [(kind, text) for place in (target, data, fields) for text in place.texts(kind)]
        for kind in ("entity_id", "area_id", "device_id", "label_id", "floor_id")
    )
    target.end()
    return _Target([*(text for _, text in ids), *fields.texts("scene")], [*chain(*places)])


_COMMANDS: Final = ("command_", "request_location_update", "remove_channel", "delete_alert", "update_", "TTS")
"""Messages to the app of Home Assistant that are no messages to people, by their beginnings."""


def _is_clearing(data: UnreadFields) -> bool:
    """Return whether a message only clears an earlier one.

    Raises:
        NotCarriedError: It is a command to the phone.
    """
    node = data.left.get("message")
    text = str(node.value).strip() if node else ""
    if text.startswith(_COMMANDS):
        raise NotCarriedError(f"message {text!r}: a command to the phone; leave it out, or write a message")
    if text == "clear_notification":
        data.left.clear()
        return True
    return False


def _spoken(automation: Automation, name: str, data: UnreadFields) -> str:
    """Return the message for a text that is spoken."""
    for key in ("media_player_entity_id", "cache", "language", "options"):
        data.take(key)
    automation.notes.append(f"{name} becomes a message to people: homebot does not speak")
    return _message(automation, name, data)


def _message(automation: Automation, name: str, data: UnreadFields) -> str:
    title, message = (_message_text(automation, data, key) for key in ("title", "message"))
    if not message:
        raise NotCarriedError(f"{name}: `message` is missing")
    data.take("notification_id")
    for key in ("data", "target"):
        if data.take(key) is not None:
            automation.notes.append(f"`{key}` of the message is left out")
    data.end()
    text = f"notify {' '.join(': '.join(filter(None, (title, message))).split())}"
    if not isinstance(read_step(text), Notify):
        raise NotCarriedError(f"{name}: {message!r} is no message for a step")
    return text


def _message_text(automation: Automation, data: UnreadFields, key: str) -> str:
    node = data.left.get(key)
    if node is None or node.tag or not isinstance(node.value, str):
        return data.text(key, "")
    data.take(key)
    return templates_of(automation).message(node.value)


def _settings(automation: Automation, name: str, data: UnreadFields) -> Iterator[_Setting]:
    """Yield the values that a service sets."""
    keys = [key for key in _DATA.get(name, ()) if key in data]
    if name == "timer.start" and "duration" in data:
        yield _Setting("number", value=_minutes(automation, data))
    elif name in _WORDS:
        capabilities, _, words = _WORDS[name].partition(" ")
        yield _Setting(capabilities, words)
    elif not keys:
        data.end()  # it names the field that is there instead
        raise NotCarriedError(f"data: `{_DATA[name][0]}` is missing")
    for key in keys:
        row = _FIELDS[key]
        if row.capabilities == "muted":
            yield row._replace(value=str(data.flag(key, default=True)))
            continue
        if CAPABILITIES[row.capabilities.split()[0]].kind == "bool":
            yield row._replace(value=str(data.flag(key, default=True)).lower())
            continue
        if CAPABILITIES[row.capabilities.split()[0]].kind != "number":
            yield row._replace(value=data.text(key))
            continue
        node = data.left[key]
        if isinstance(node.value, str) and "{{" in node.value and not key.startswith("brightness_step"):
            data.take(key)
            text, factor = step_number(automation, node.value)
            if not math.isclose(factor * row.factor, 1.0) or key == "color_temp":
                raise NotCarriedError(f"data: `{key}` is calculated; a step takes a number of the house as it is")
            yield row._replace(value=text)
            continue
        for number in data.numbers(key):
            value = number * row.factor
            if key.startswith("brightness_step"):
                yield row._replace(words=f"{value:+.3g} %")
            else:
                yield row._replace(value=_of_light(key, value) if name == "light.turn_on" else value)
    if name == "light.turn_on" and (color := _color(data)) is not None:
        yield _Setting("color", f"color {color[0]:.0f} {color[1]:.0f}")


def _minutes(automation: Automation, data: UnreadFields) -> str | float:
    """Return the minutes of a timer."""
    if text := step_length(automation, data.left["duration"]):
        data.take("duration")
        if not text.endswith("}m"):
            raise NotCarriedError("data: `duration` of a timer is a number of the house in minutes")
        return text[:-1]
    return parse_duration(data.duration("duration") or "0s") / 60


def _of_light(key: str, number: float) -> int:
    """Return the brightness in per cent, or the colour temperature in K."""
    value = 1_000_000 / max(1.0, number) if key == "color_temp" else number
    if key.startswith("brightness") and not 0 < value <= 100:
        raise NotCarriedError(f"data: `{key}` is {value:g} %")
    return max(1, round(value))


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


def _steps_of(name: str, entity: KnownEntity, settings: Sequence[_Setting], over: str) -> list[str]:
    """Return the steps that set *settings*; the mode of a heating is one of its own."""
    if name == "climate.set_temperature":
        mode = next((str(setting.value) for setting in settings if setting.capabilities == "thermostat_mode"), "")
        settings = [_of_mode(entity, setting, mode) for setting in settings]
        return [_step_of(entity, [setting], over) for setting in settings]
    if name == "fan.turn_on" and len(settings) > 1:
        settings = settings[1:]
    if name == "light.turn_on":  # what a lamp cannot do, Home Assistant leaves out
        settings = [_as_color(entity, setting) for setting in settings]
        settings = [one for one in settings if one.capabilities not in _OF_LAMPS or entity.takes(one.capabilities)]
    if any(setting.words.startswith(("+", "-")) for setting in settings) and settings[0].words == "on":
        settings = settings[1:]  # a step of brightness turns it on
    return [_step_of(entity, settings, over)]


def _of_mode(entity: KnownEntity, setting: _Setting, mode: str) -> _Setting:
    """Return the target temperature of the mode that is set with it, if a device has one for each."""
    wanted = {"heat": "heating_setpoint", "cool": "cooling_setpoint"}.get(mode, "")
    is_of_mode = wanted in setting.capabilities.split() and entity.takes(wanted)
    return setting._replace(capabilities=wanted) if is_of_mode else setting


def _as_color(entity: KnownEntity, setting: _Setting) -> _Setting:
    """Return a white as the colour of a lamp that has colours alone."""
    if setting.capabilities != "color_temperature" or entity.takes("color_temperature") or not entity.takes("color"):
        return setting
    if isinstance(setting.value, str):
        raise NotCarriedError(f"{entity.name} takes no color_temperature; write its colour")
    hue, saturation = to_hue_saturation("rgb", white_rgb(setting.value), (0, 0))
    return _Setting("color", f"color {hue:.0f} {saturation:.0f}")


_OF_LAMPS: Final = frozenset({"level", "color", "color_temperature"})


def _step_of(entity: KnownEntity, settings: Sequence[_Setting], over: str) -> str:
    """Return the step that sets *settings*."""
    names = [_taken(entity, setting) for setting in settings]
    words = [_words(entity, *name_and_setting) for name_and_setting in zip(names, settings, strict=True)]
    taking = [
        part
        for part in entity.device.parts
        if any(can.name in names and can.settable for can in part.part.capabilities)
    ]
    target = entity.name if len(taking) == 1 else f"{entity.device.id}#{entity.part.id}"
    return _step(target, [*words, *([f"over {over}"] if over else [])])


def _taken(entity: KnownEntity, setting: _Setting) -> str:
    """Return the capability of *setting* that an entity takes."""
    able = [capability for capability in setting.capabilities.replace("|", " ").split() if entity.takes(capability)]
    if not able or (len(able) > 1 and "|" not in setting.capabilities):
        raise NotCarriedError(f"{entity.name} takes {' and '.join(able) or f'no {setting.capabilities}'}")
    return able[0]


def _words(entity: KnownEntity, name: str, setting: _Setting) -> str:
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


def _step(target: str, words: Sequence[str]) -> str:
    """Return a step that homebot reads as a command to *target*."""
    count = len([word for word in words[1:] if not word.startswith("over ")])
    for text in (f"{target} {', '.join(words)}", *([f"{target}: {words[0]}"] if len(words) == 1 else [])):
        try:
            step = read_step(text)
        except UsageError:
            continue
        command = _VALUE.sub("1", words[0])
        if isinstance(step, Do) and (step.target, step.command, len(step.values)) == (target, command, count):
            return text
    raise NotCarriedError(f"{target!r} and {', '.join(words)!r} cannot be written as a step")
