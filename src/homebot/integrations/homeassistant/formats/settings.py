"""Settings and commands: switches, numbers, options, texts, moments, buttons and scenes. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: button.py, notify.py, number.py, scene.py, select.py, switch.py
and text.py; core 2026.11: date.py, datetime.py and time.py.
"""

import re
from collections.abc import Callable, Mapping

from homebot.conventions.bounded_patterns import require_match
from homebot.conventions.command_values import moment_text, option_writer, require_moment
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.payload import Readings, clean_text, compact_json, fields_of, meaning_reader, unreadable
from homebot.conventions.units import number_grid
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity

_MAX_TEXT_CHARACTERS = 255
_MAX_MESSAGE_CHARACTERS = 4096


def build_button(config: DiscoveryConfig) -> DescribedPart:
    """Describe a button. One that makes the device show or sound its place also has ``locate``."""
    command = config.required_command()
    payload = config.text("payload_press", "PRESS")
    entity = Entity(config, "x_setting")
    entity.add_push("push", command, payload)
    if config.device_class == "identify":
        entity.add_push("locate", command, payload)
    return entity.build()


def build_scene(config: DiscoveryConfig) -> DescribedPart:
    """Describe a scene."""
    entity = Entity(config, "x_scene")
    entity.add_push("scene", config.required_command(template_key=""), config.text("payload_on", "ON"))
    return entity.build()


def build_switch(config: DiscoveryConfig) -> DescribedPart:
    """Describe a switch: a plug if its class is ``outlet``.

    One that toggles is a gate or garage door of tydom2mqtt, with a button: what was not confirmed would be repeated.
    """
    command, payloads = config.required_command(), config.on_off_payloads()
    if payloads[True] == payloads[False]:
        gate = Entity(config, "closure")
        gate.add_push("push", command, payloads[True])
        return gate.build()
    entity = Entity(config, "plug" if config.device_class == "outlet" else "switch")
    entity.add_flag("on_off", config.source("state_topic"), command, payloads, config.on_off_states())
    return entity.build()


def build_number(config: DiscoveryConfig) -> DescribedPart:
    """Describe a number in its own unit. Numbers outside of its bounds are neither read nor sent."""
    least, most = config.number("min", 0.0), config.number("max", 100.0)
    if least > most:
        raise WireError(f"number: max is {most:g}, below min {least:g}")
    entity = Entity(config, "x_setting")
    entity.add_number(
        "number",
        config.source("state_topic"),
        config.required_command(),
        bounds=(least, most),
        grid=number_grid(least, config.values.get("step")),
        unit=config.clean_text("unit_of_measurement", 40),
        unknown=config.text("payload_reset", "None"),
        from_device=lambda number: number if least <= number <= most else None,
        to_device=lambda number: int(number) if number.is_integer() else number,
    )
    return entity.build()


def build_select(config: DiscoveryConfig) -> DescribedPart:
    """Describe a choice. The text ``none``, in any case, means that the option is unknown.

    The template of the command may ask for the place of the option in ``this.attributes.options``, as AqualinkD's does.
    """
    if not config.has("options"):
        raise WireError("select: options is None, not a list of texts")
    options = config.options("options")
    command = config.required_command()
    read_option = meaning_reader("option", {option: option for option in options if option.strip()})

    def read(text: str) -> Readings:
        return {"option": None} if text.lower() == "none" else read_option(text)

    entity = Entity(config, "x_setting")
    this = {"this": {"attributes": {"options": list(options)}}} if command.template else {}
    writer = option_writer("option", options, lambda option: command.publish(option, this))
    entity.add_value("option", config.source("state_topic"), read, command, writer, options=options)
    return entity.build()


def build_text(config: DiscoveryConfig) -> DescribedPart:
    """Describe a text. A password is sent, but never read."""
    least = config.integer("min", 0, least=0)
    most = config.integer("max", _MAX_TEXT_CHARACTERS, least=0, most=_MAX_TEXT_CHARACTERS)
    if least > most:
        raise WireError(f"text: max is {most}, below min {least}")

    def read(text: str) -> Readings:
        if text == "None":
            return {"text": None}
        if len(text) > _MAX_TEXT_CHARACTERS:
            return unreadable(text, f"at most {_MAX_TEXT_CHARACTERS} characters")
        return {"text": clean_text(text, _MAX_TEXT_CHARACTERS)}

    return _build_text(config, least, most, None if config.text("mode", "text").lower() == "password" else read)


def build_notify(config: DiscoveryConfig) -> DescribedPart:
    """Describe a display or a speaker of messages."""
    return _build_text(config, 0, _MAX_MESSAGE_CHARACTERS, None)


def _build_text(
    config: DiscoveryConfig, least: int, most: int, read: Callable[[str], Readings] | None
) -> DescribedPart:
    command = config.required_command()

    def write(value: PlainValue, _transition: float) -> Publications:
        if not isinstance(value, str) or not least <= len(value) <= most:
            raise RefusedError("text", f"it takes a text of {least} to {most} characters")
        require_match(value, config.values.get("pattern"))
        return command.publish(value)

    entity = Entity(config, "x_setting")
    is_readable = read is not None and entity.read_text_from(config.source("state_topic"), read)
    entity.add_capability("text", readable=is_readable, writer=write)
    entity.add_commands(command)
    return entity.build()


def build_moment(config: DiscoveryConfig) -> DescribedPart:
    """Describe a date, a time of day, or both, as text in ISO 8601. Other texts are neither read nor sent.

    ESPHome tells and takes its numbers in JSON, without a time zone.
    """
    kind = config.component
    command = config.required_command()
    in_numbers = False  # as the last state

    def read(text: str) -> Readings:
        nonlocal in_numbers
        fields = fields_of(text)
        in_numbers = bool(fields)
        moment = moment_text(kind, _moment_of(kind, fields) if fields else text)
        return {"text": moment} if moment is not None or text == "None" else unreadable(text, f"a {kind} in ISO 8601")

    def write(value: PlainValue, _transition: float) -> Publications:
        moment = require_moment(kind, value, zoned=not in_numbers)
        if in_numbers:
            numbers = map(int, re.findall("[0-9]+", moment))
            moment = compact_json(dict(zip(_NUMBERS[kind], numbers, strict=False)))
        return command.publish(moment)

    entity = Entity(config, "x_setting", kind)
    entity.add_value("text", config.source("state_topic"), read, command, write)
    entity.remembers()
    return entity.build()


_DATE, _TIME = ("year", "month", "day"), ("hour", "minute", "second")
_NUMBERS: Mapping[str, tuple[str, ...]] = {"date": _DATE, "datetime": (*_DATE, *_TIME), "time": _TIME}
_FORMS = {"date": "{year:04}-{month:02}-{day:02}", "time": "{hour:02}:{minute:02}:{second:02}"}
_FORMS["datetime"] = f"{_FORMS['date']}T{_FORMS['time']}"


def _moment_of(kind: str, fields: Mapping[str, object]) -> str:
    """Return the moment in the numbers of a message; empty for none."""
    try:
        return _FORMS[kind].format_map(fields)
    except (LookupError, TypeError, ValueError):
        return ""
