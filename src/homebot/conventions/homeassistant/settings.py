"""The components of one value each that can be set: switches, buttons, scenes, numbers, selects, texts, moments. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: switch.py, button.py, scene.py, number.py, select.py, text.py,
notify.py; and 2026.11: date.py, time.py, datetime.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import date, datetime, time
from types import MappingProxyType
from typing import TypeAlias

from homebot.conventions.command_values import require_bool, require_option
from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity, add_number, add_push
from homebot.conventions.payload import clean_text, shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

__all__ = [
    "build_button",
    "build_moment",
    "build_notify",
    "build_number",
    "build_scene",
    "build_select",
    "build_switch",
    "build_text",
]


def build_switch(config: DiscoveryConfig) -> DescribedPart:
    """Describe a switch: a plug where its class is ``outlet``."""
    command = config.required_command()
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    states: dict[str, bool | None] = {
        config.text("state_on") or payloads[True]: True,
        config.text("state_off") or payloads[False]: False,
        "None": None,
    }

    def read(text: str) -> Readings:
        return {"on_off": states[text]} if text in states else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(payloads[require_bool("on_off", value)]),)

    entity = Entity(config, "plug" if config.text("device_class") == "outlet" else "switch")
    entity.add_capability("on_off", readable=entity.read_text_from(config.source("state_topic"), read), writer=write)
    entity.add_commands(command)
    return entity.build()


def build_button(config: DiscoveryConfig) -> DescribedPart:
    """Describe a button. One that makes the device show or sound where it is can be told ``locate`` as well."""
    command = config.required_command()
    payload = config.text("payload_press", "PRESS")
    entity = Entity(config, "x_setting")
    add_push(entity, "push", command, payload)
    if config.text("device_class") == "identify":
        add_push(entity, "locate", command, payload)
    return entity.build()


def build_scene(config: DiscoveryConfig) -> DescribedPart:
    """Describe a scene."""
    entity = Entity(config, "x_scene")
    add_push(entity, "scene", config.required_command(template_key=""), config.text("payload_on", "ON"))
    return entity.build()


def build_number(config: DiscoveryConfig) -> DescribedPart:
    """Describe a number in its own unit; what lies outside of its bounds is neither heard nor told."""
    least, most = config.number("min", 0.0), config.number("max", 100.0)
    if least > most:
        raise WireError(f"number: max is {most:g}, below min {least:g}")

    def from_device(number: float) -> float | None:
        return number if least <= number <= most else None

    entity = Entity(config, "x_setting")
    add_number(
        entity,
        "number",
        config.source("state_topic"),
        config.required_command(),
        bounds=(least, most),
        unit=config.clean_text("unit_of_measurement", 40),
        unknown=config.text("payload_reset", "None"),
        from_device=from_device,
        to_device=_shortest,
    )
    return entity.build()


def _shortest(number: float) -> float:
    """A whole number is told without point."""
    return int(number) if number.is_integer() else number


def build_select(config: DiscoveryConfig) -> DescribedPart:
    """Describe a choice. Where it says ``none``, however that is written, the option is unknown."""
    if not config.has("options"):
        raise WireError("select: options is None, not a list of texts")
    options = config.options("options")
    known = frozenset(options)
    command = config.required_command()

    def read(text: str) -> Readings:
        if text.lower() == "none":
            return {"option": None}
        return {"option": text} if text.strip() and text in known else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(require_option("option", value, options)),)

    entity = Entity(config, "x_setting")
    entity.add_capability(
        "option", readable=entity.read_text_from(config.source("state_topic"), read), writer=write, options=options
    )
    entity.add_commands(command)
    return entity.build()


def build_text(config: DiscoveryConfig) -> DescribedPart:
    """Describe a text. A password is told, but never read.

    Of the config's ``pattern`` nothing is checked: it is a stranger's regular expression, and the device has its own.
    """
    least = config.integer("min", 0, least=0)
    most = config.integer("max", _TEXT_LONGEST, least=0, most=_TEXT_LONGEST)
    if least > most:
        raise WireError(f"text: max is {most}, below min {least}")
    is_secret = config.text("mode", "text") == "password"

    def read(text: str) -> Readings:
        if text == "None":
            return {"text": None}
        return NO_READINGS if len(text) > _TEXT_LONGEST else {"text": clean_text(text, _TEXT_LONGEST)}

    return _build_setting(config, least, most, None if is_secret else read)


def build_notify(config: DiscoveryConfig) -> DescribedPart:
    """Describe something that shows or speaks messages."""
    return _build_setting(config, 0, _LONGEST_MESSAGE, None)


_Read: TypeAlias = Callable[[str], Readings]
_TEXT_LONGEST = 255
_LONGEST_MESSAGE = 4096


def _build_setting(config: DiscoveryConfig, least: int, most: int, read: _Read | None) -> DescribedPart:
    command = config.required_command()

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        if not isinstance(value, str) or not least <= len(value) <= most:
            raise RefusedError("text", f"it takes a text of {least} to {most} characters")
        return (command.publication(value),)

    entity = Entity(config, "x_setting")
    is_readable = read is not None and entity.read_text_from(config.source("state_topic"), read)
    entity.add_capability("text", readable=is_readable, writer=write)
    entity.add_commands(command)
    return entity.build()


def build_moment(config: DiscoveryConfig) -> DescribedPart:
    """Describe a date, a time of day, or both, as the component says; what is none is neither heard nor told."""
    kind = config.component
    parse = _PARSERS[kind]
    command = config.required_command()

    def spelled(text: str) -> str | None:
        try:
            return parse(text.strip()[:_MOMENT_LONGEST]).isoformat()
        except ValueError:
            return None

    def read(text: str) -> Readings:
        if text == "None":
            return {"text": None}
        moment = spelled(text)
        return NO_READINGS if moment is None else {"text": moment}

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        moment = spelled(value) if isinstance(value, str) else None
        if moment is None:
            raise RefusedError(f"text {shown(value)}", f"it takes a {kind} as ISO 8601 has it")
        if kind == "datetime" and datetime.fromisoformat(moment).tzinfo is None:
            raise RefusedError(f"text {shown(value)}", "it takes a datetime with its time zone")
        return (command.publication(moment),)

    entity = Entity(config, "x_setting", kind)
    entity.add_capability("text", readable=entity.read_text_from(config.source("state_topic"), read), writer=write)
    entity.add_commands(command)
    return entity.build()


_MOMENT_LONGEST = 64
_Parser: TypeAlias = Callable[[str], date | time | datetime]
_PARSERS: Mapping[str, _Parser] = MappingProxyType(
    {"date": date.fromisoformat, "datetime": datetime.fromisoformat, "time": time.fromisoformat}
)
